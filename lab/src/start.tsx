// Where a visit begins: ready scenes, or the user's own files.

import { EXAMPLES, type Example } from "./examples";
import { change, plan } from "./plan";
import type { Point } from "./protocol";
import { choose } from "./session";
import { FileInput, openTrial } from "./upload";

export function StartTab() {
    const { made } = plan.value;
    const now = JSON.stringify(made);
    return (
        <section class="panel" aria-label="Start">
            <h2>Start from an example</h2>
            {EXAMPLES.map((example) => (
                <button key={example.name} type="button" class="card" aria-pressed={now === JSON.stringify(example.made)} onClick={() => begin(example)}>
                    <Sketch example={example} />
                    <strong>{example.name}</strong>
                    <span>{example.sentence}</span>
                </button>
            ))}
            <h2>Open your own Trial</h2>
            <p class="note">A zip or a folder with Agents.xml, Geometry.xml, Materials.xml and AgentDynamics.xml; drop it anywhere on this page, or choose it here. It stays on this machine.</p>
            <FileInput label="Open a zip" accept=".zip,application/zip" onFiles={openTrial} />
            <FileInput label="Open a folder" folder onFiles={openTrial} />
        </section>
    );
}

function begin({ made }: Example) {
    const { base } = made;
    change({ line: null });
    if (base.kind !== "crowd") return choose(made, true);
    const { kind: _, ...crowd } = base;
    // The forms say what is on the stage, to go on from there.
    choose(made, true, crowd);
}

/** A small plan of its room. */
function Sketch({ example: { made } }: { example: Example }) {
    if (made.base.kind !== "crowd") {
        return (
            <svg class="sketch" viewBox="-0.2 -0.2 5.4 2" aria-hidden="true">
                {[0, 1, 2, 3, 4].map((k) => (
                    <ellipse key={k} cx={k + 0.9} cy="0.8" rx="0.3" ry="0.5" class="crowded" />
                ))}
                <path d="M-.1 .8h.5m-.2-.15l.2.15l-.2.15" class="outline" />
            </svg>
        );
    }
    const { room, region } = made.base;
    const path = (corners: Point[]) => `M${corners.map(([x, y]) => `${x} ${-y}`).join("L")}Z`;
    const [xs, ys] = [0, 1].map((axis) => room.outline.map((corner) => corner[axis as 0 | 1])) as [number[], number[]];
    const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    return (
        <svg class="sketch" viewBox={`${left - 0.3} ${-high - 0.3} ${right - left + 0.6} ${high - low + 0.6}`} aria-hidden="true">
            <path d={path(region ?? room.outline)} class="crowded" />
            <path d={[room.outline, ...room.obstacles].map(path).join("")} class="outline" />
            {room.doors.map(({ at: [x, y], width }) => (
                <path key={`${x} ${y}`} d={`M${x} ${-y - width / 2}v${width}`} class="gap" />
            ))}
        </svg>
    );
}
