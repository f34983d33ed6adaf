// What is computed for longer than half a second, and the button that ends it.

import type { Slow } from "./client";
import { fixed, t } from "./language";
import { Button } from "./parts";
import type { Progress, Request } from "./protocol";
import { client, stop } from "./session";

/** Stages of a placing, for those who have never placed a crowd. */
const STAGES = [
    t("People grow to full size"),
    t("People are pushed apart"),
    t("People are shaken free"),
    t("People are pressed together"),
    t("Some are taken out to see how many fit"),
];
/** A run is computed again. */
const AGAIN = 5;

const DOING: Record<Request["ask"], string> = {
    person: t("The person is made"),
    body: t("The body is made"),
    kinds: t("The kinds of people are read"),
    bicycle: t("The bicycle is made"),
    show: t("The scene is made"),
    room: t("The room is drawn"),
    drawing: t("The room is read"),
    overlaps: t("Overlaps are looked for"),
    advance: t("The run is computed"),
    forces: t("Forces are computed"),
    flow: t("People are counted"),
    map: t("The map is computed"),
    limit: t("The time above a limit is counted"),
    sections: t("Bodies are cut"),
    bodies: t("Bodies are made"),
    report: t("The report is made"),
    take: t("The file is made"),
};

function words({ ask, progress }: Slow): string {
    if (!progress) return DOING[ask];
    return progress.stage === AGAIN ? t("The run is computed again, step {iteration} of {limit}", { iteration: progress.iteration, limit: progress.limit }) : (STAGES[progress.stage] ?? DOING[ask]);
}

function details({ stage, iteration, density, overlap }: Progress): string {
    return stage === AGAIN ? "" : t("round {iteration}: {density} people per m², overlaps up to {overlap} mm", { iteration, density: fixed(density, 2), overlap: fixed(1000 * overlap, 1) });
}

export function Busy() {
    const slow = client.slow.value;
    return (
        <div class="busy">
            {/* Only the words are read out; numbers change too often. */}
            <p role="status">{slow ? `${words(slow)} …` : ""}</p>
            {slow && (
                <>
                    {slow.progress && slow.progress.limit > 0 && <progress aria-label={t("Progress")} max={slow.progress.limit} value={slow.progress.iteration} />}
                    <span>{slow.progress && details(slow.progress)}</span>
                    <Button words={t("Stop")} onClick={stop} />
                </>
            )}
        </div>
    );
}
