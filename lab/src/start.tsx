// Where a visit begins: ready scenes, or the user's own files.

import { EXAMPLES, type Example } from "./examples";
import { Keep } from "./kept";
import { t } from "./language";
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
    const example = EXAMPLES.find((one) => one.name === name);
    return (
        <section class="panel" aria-label={t("Start")}>
            <p class="note">{t("People in dense crowds, as bodies that touch and press. Choose a question, move a slider, and watch; or draw your own room.")}</p>
            <div class="row">
                <TourButton />
                <NewRoom />
            </div>
            <h2>{example ? asked(example, film.value?.scene.agents.length) : name}</h2>
            <Sliders />
            <Keep />
            <SweepForm />
            <h2>{t("Questions")}</h2>
            {EXAMPLES.map((example) => (
                <button key={example.name} type="button" class="card" aria-pressed={name === example.name && !canUndo.value} onClick={() => begin(example)}>
                    <Sketch base={example.made.base} />
                    <strong>{t(example.name)}</strong>
                    <span>
                        {asked(example)} {example.sentence}
                    </span>
                </button>
            ))}
            <Scenes />
            <h2>{t("Open your own Trial")}</h2>
            <p class="note">{t("A zip or a folder with Agents.xml, Geometry.xml, Materials.xml and AgentDynamics.xml; drop it anywhere on this page, or choose it here. It stays on this machine.")}</p>
            <FileInput label={t("Open a zip or a scenario")} accept=".zip,.toml,application/zip" onFiles={openTrial} />
            <FileInput label={t("Open a folder")} folder onFiles={openTrial} />
        </section>
    );
}

function asked({ question, made: { base } }: Example, people = base.kind === "crowd" ? (base.number ?? 0) : 0) {
    return question(people);
}

function begin({ name, made }: Example) {
    // The forms say what is on the stage, to go on from there.
    open(name, made, true, crowdOf(made.base) ?? undefined);
}

