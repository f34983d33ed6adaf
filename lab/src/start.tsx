// Where a visit begins: ready scenes, or the user's own files.

import { EXAMPLES, type Example } from "./examples";
import { plan } from "./plan";
import { Scenes } from "./scenelist";
import { open } from "./scenes";
import { Sketch } from "./sketch";
import { FileInput, openTrial } from "./upload";

export function StartTab() {
    const { made } = plan.value;
    const now = JSON.stringify(made);
    return (
        <section class="panel" aria-label="Start">
            <h2>Start from an example</h2>
            {EXAMPLES.map((example) => (
                <button key={example.name} type="button" class="card" aria-pressed={now === JSON.stringify(example.made)} onClick={() => begin(example)}>
                    <Sketch base={example.made.base} />
                    <strong>{example.name}</strong>
                    <span>{example.sentence}</span>
                </button>
            ))}
            <Scenes />
            <h2>Open your own Trial</h2>
            <p class="note">A zip or a folder with Agents.xml, Geometry.xml, Materials.xml and AgentDynamics.xml; drop it anywhere on this page, or choose it here. It stays on this machine.</p>
            <FileInput label="Open a zip" accept=".zip,application/zip" onFiles={openTrial} />
            <FileInput label="Open a folder" folder onFiles={openTrial} />
        </section>
    );
}

function begin({ name, made }: Example) {
    const { base } = made;
    if (base.kind !== "crowd") return open(name, made, true);
    const { kind: _, ...crowd } = base;
    // The forms say what is on the stage, to go on from there.
    open(name, made, true, crowd);
}

