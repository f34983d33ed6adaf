// Where a visit begins: ready scenes, or the user's own files.

import { example, questionOf } from "./answer";
import { pushTool } from "./event";
import { EXAMPLES, type Example } from "./examples";
import { Keep } from "./kept";
import { t } from "./language";
import { NewRoom } from "./newroom";
import { canUndo, crowdOf, plan, scene, title } from "./plan";
import { Scenes } from "./scenelist";
import { open } from "./scenes";
import { film } from "./session";
import { Sketch } from "./sketch";
import { Sliders } from "./sliders";
import { SweepForm } from "./sweepform";
import { useTool } from "./tool";
import { TourButton } from "./tour";
import { FileInput, openTrial } from "./upload";

export function StartTab() {
    const { name } = scene.value;
    const { more } = plan.value;
    const here = example();
    useTool(pushTool);
    const further = (
        <>
            <p class="note">{t("People in dense crowds, as bodies that touch and press. Choose a question, move a slider, and watch; or draw your own room.")}</p>
            {more && <SweepForm />}
            <h2>{t("Questions")}</h2>
            {EXAMPLES.map((one) => (
                <button key={one.name} type="button" class="card" aria-pressed={name === one.name && !canUndo.value} onClick={() => begin(one)}>
                    <Sketch base={one.made.base} />
                    <strong>{t(one.name)}</strong>
                    <span>
                        {one.question(one.made.base.kind === "crowd" ? (one.made.base.number ?? 0) : 0)} {one.sentence}
                    </span>
                </button>
            ))}
            {!more && <SweepForm />}
            <Scenes />
            <NewRoom />
            <h2>{t("Open your own Trial")}</h2>
            <p class="note">{t("A zip or a folder with Agents.xml, Geometry.xml, Materials.xml and AgentDynamics.xml; drop it anywhere on this page, or choose it here. It stays on this machine.")}</p>
            <FileInput label={t("Open a zip or a scenario")} accept=".zip,.toml,application/zip" onFiles={openTrial} />
            <FileInput label={t("Open a folder")} folder onFiles={openTrial} />
        </>
    );
    return (
        <section class="panel" aria-label={t("Start")}>
            {/* Asked of the people that there are now. */}
            <h2>{here ? questionOf(film.value) : title.value}</h2>
            {/* It tells of the example as it is. */}
            {here && !canUndo.value && <p class="note">{here.sentence}</p>}
            <Sliders />
            <div class="row">
                <Keep />
                <TourButton />
            </div>
            {more ? further : <details><summary>{t("Other questions, and your scenes")}</summary>{further}</details>}
        </section>
    );
}

function begin({ name, made }: Example) {
    // The forms say what is on the stage, to go on from there.
    open(name, made, true, crowdOf(made.base) ?? undefined);
}

