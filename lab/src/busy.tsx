// What is computed for longer than half a second, and the button that ends it.

import type { Slow } from "./client";
import type { Progress, Request } from "./protocol";
import { client, stop } from "./session";

/** Stages of a placing, for those who have never placed a crowd. */
const STAGES = [
    "People grow to full size",
    "People are pushed apart",
    "People are shaken free",
    "People are pressed together",
    "Some are taken out to see how many fit",
];
/** A run is computed again. */
const AGAIN = 5;

const DOING: Record<Request["ask"], string> = {
    person: "The person is made",
    body: "The body is made",
    kinds: "The kinds of people are read",
    bicycle: "The bicycle is made",
    show: "The scene is made",
    room: "The room is drawn",
    drawing: "The room is read",
    overlaps: "Overlaps are looked for",
    advance: "The run is computed",
    forces: "Forces are computed",
    flow: "People are counted",
    map: "The map is computed",
    limit: "The time above a limit is counted",
    sections: "Bodies are cut",
    bodies: "Bodies are made",
    take: "The file is made",
};

function words({ ask, progress }: Slow): string {
    if (!progress) return DOING[ask];
    return progress.stage === AGAIN ? `The run is computed again, step ${progress.iteration} of ${progress.limit}` : (STAGES[progress.stage] ?? DOING[ask]);
}

function details({ stage, iteration, density, overlap }: Progress): string {
    return stage === AGAIN ? "" : `round ${iteration}: ${density.toFixed(2)} people per m², overlaps up to ${(1000 * overlap).toFixed(1)} mm`;
}

export function Busy() {
    const slow = client.slow.value;
    return (
        <div class="busy">
            {/* Only the words are read out; numbers change too often. */}
            <p role="status">{slow ? `${words(slow)} …` : ""}</p>
            {slow && (
                <>
                    {slow.progress && slow.progress.limit > 0 && <progress aria-label="Progress" max={slow.progress.limit} value={slow.progress.iteration} />}
                    <span>{slow.progress && details(slow.progress)}</span>
                    <button type="button" onClick={stop}>
                        Stop
                    </button>
                </>
            )}
        </div>
    );
}
