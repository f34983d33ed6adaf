// Where a visit begins: ready scenes, or the user's own files.

import { EXAMPLES, type Example } from "./examples";
import { Keep } from "./kept";
import { NewRoom } from "./newroom";
import { canUndo, crowdOf, scene } from "./plan";
import { Scenes } from "./scenelist";
import { open } from "./scenes";
import { film } from "./session";
import { Sketch } from "./sketch";
import { Sliders } from "./sliders";
import { SweepForm } from "./sweepform";
import { TourButton } from "./tour";
import { FileInput, openTrial } from "./upload";

export function StartTab() {
    const { name } = scene.value;
    // Asked of the people that there are now.
    const question = EXAMPLES.find((example) => example.name === name)?.question.replace(/\d+/, (number) => String(film.value?.scene.agents.length ?? number));
    return (
        <section class="panel" aria-label="Start">
            <p class="note">People in dense crowds, as bodies that touch and press. Choose a question, move a slider, and watch; or draw your own room.</p>
            <div class="row">
                <TourButton />
                <NewRoom />
            </div>
            {question ? <h2>{question}</h2> : <h2 translate={false}>{name}</h2>}
            <Sliders />
            <Keep />
            <SweepForm />
            <h2>Questions</h2>
            {EXAMPLES.map((example) => (
                <button key={example.name} type="button" class="card" aria-pressed={name === example.name && !canUndo.value} onClick={() => begin(example)}>
                    <Sketch base={example.made.base} />
                    <strong>{example.name}</strong>
                    <span>
                        {example.question} {example.sentence}
                    </span>
                </button>
            ))}
            <Scenes />
            <h2>Open your own Trial</h2>
            <p class="note">A zip or a folder with Agents.xml, Geometry.xml, Materials.xml and AgentDynamics.xml; drop it anywhere on this page, or choose it here. It stays on this machine.</p>
            <FileInput label="Open a zip or a scenario" accept=".zip,.toml,application/zip" onFiles={openTrial} />
            <FileInput label="Open a folder" folder onFiles={openTrial} />
        </section>
    );
}

function begin({ name, made }: Example) {
    // The forms say what is on the stage, to go on from there.
    open(name, made, true, crowdOf(made.base) ?? undefined);
}

