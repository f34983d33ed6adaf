// Squeeze above a limit of the user's: how many people, how long, and from when.

import type { ComponentChildren } from "preact";
import type { Film } from "./film";
import { beat } from "./layout";
import { brief, digits, Facts, NumberField } from "./parts";
import { change, plan } from "./plan";

/** Frames of a mean over so many seconds. */
export function framesOf({ scene }: Pick<Film, "scene">, seconds: number): number {
    return Math.max(1, Math.round(seconds / scene.step));
}

/** What is told of the limit, up to the last frame that was shown or asked for. */
export function aboveLimit(film: Film): [string, ComponentChildren][] {
    const { force, seconds } = plan.value.limit;
    const { step, agents } = film.scene;
    const [span, to] = [framesOf(film, seconds), film.playing.value ? film.reached.peek() : film.reached.value];
    const { people, frames, longest, who, first } = film.frames.above(force, span, to);
    if (to < span) return [["Ever above the limit", `nothing yet: the run is shorter than ${seconds} s`]];
    const rows: [string, ComponentChildren][] = [["Ever above the limit", people === 0 ? "nobody" : `${people} of ${agents.length}`]];
    if (people === 0) return rows;
    return [
        ...rows,
        ["Above it at first", `at ${(first * step).toFixed(2)} s`],
        [
            "Longest without a break",
            <>
                {`${digits(longest * step, 3)} s`} (<span translate={false}>{brief(agents[who]!.id)}</span>)
            </>,
        ],
        ["All together", `${digits(frames * step, 3)} person-seconds`],
    ];
}

export function Limit({ film }: { film: Film }) {
    if (film.playing.value) beat.value;
    const { limit } = plan.value;
    return (
        <>
            <h2>Squeeze above a limit</h2>
            <div class="row">
                <NumberField label="Limit" unit="N" value={limit.force} min={1} max={1e6} step={10} onChange={(force) => change({ limit: { ...limit, force } })} />
                <NumberField label="Limit, mean over" short="mean over" unit="s" value={limit.seconds} min={0.01} max={600} step={0.5} onChange={(seconds) => change({ limit: { ...limit, seconds } })} />
            </div>
            <Facts rows={aboveLimit(film)} />
            <p class="note">623 N is what men tolerated against a flat bar. No number here says who is hurt: About this scale, below the picture, says more.</p>
        </>
    );
}
