// Squeeze above a limit of the user's: how many people, how long, and from when.

import { limit, ready } from "./drawn";
import type { Film } from "./film";
import { fixed, t } from "./language";
import { beat } from "./layout";
import { brief, digits, Facts, NumberField } from "./parts";
import { change, plan } from "./plan";
import type { Limit as Told } from "./protocol";

/** Frames of a mean over so many seconds. */
export function framesOf({ scene }: Pick<Film, "scene">, seconds: number): number {
    return Math.max(1, Math.round(seconds / scene.step));
}

/** Bytes of squeezes that are sent at once. */
const MOST_BYTES = 8e6;
/** So many the lab knows at a time. */
const NUMBERS = 4;
let last = 0;

/** What the lab knows of each run: the limit, and the frame that is next. */
const known = new WeakMap<Film, { number: number; of: string; next: number; found: Told }>();

/** How long people were above the limit, as `lemons measure --above` has it, and the greatest mean of 1 s; up to the last frame
 * that was shown or asked for. */
function found(film: Film): Told {
    const to = film.playing.value ? film.reached.peek() : film.reached.value;
    const { force, seconds } = plan.value.limit;
    const { frames, scene } = film;
    const of = `${force} ${seconds}`;
    const before = known.get(film);
    const fresh = before?.of !== of || before.next > to + 1;
    const state = { number: before?.number ?? last++ % NUMBERS, of, next: fresh ? 0 : before.next, found: fresh ? { above: null, worst: null } : before.found };
    known.set(film, state);
    const most = Math.max(1, Math.floor(MOST_BYTES / (8 * Math.max(1, frames.agents))));
    while (state.next <= to) {
        const end = Math.min(to + 1, state.next + most);
        const wanted = { number: state.number, people: frames.agents, step: scene.step, limit: force, over: seconds, from: state.next };
        try {
            state.found = limit(wanted, frames.squeezes(state.next, end));
            state.next = end;
        } catch (error) {
            // Another run may have had the number.
            if (state.next === 0) throw error;
            state.next = 0;
        }
    }
    return state.found;
}

/** The greatest mean of 1 s of anybody's squeeze; null: none yet. */
export function worst(film: Film): Told["worst"] {
    if (film.playing.value) beat.value;
    return ready() && film.scene.agents.length > 0 ? found(film).worst : null;
}

/** What is told of the limit. */
export function aboveLimit(film: Film): [string, string][] {
    const { seconds } = plan.value.limit;
    const { step, agents } = film.scene;
    const name = t("Ever above the limit");
    if (!ready() || agents.length === 0) return [];
    const seen = found(film).above;
    if (!seen) return [[name, step > seconds ? t("not known: a step is longer than {seconds} s", { seconds }) : t("nothing yet: the run is shorter than {seconds} s", { seconds })]];
    const { people, first, longest, who, time } = seen;
    if (first === null) return [[name, t("nobody")]];
    return [
        [name, t("{people} of {n}", { people, n: agents.length })],
        [t("Above it at first"), t("at {first} s", { first: fixed(first, 2) })],
        [t("Longest without a break"), `${digits(longest, 3)} s (${brief(agents[who]!.id)})`],
        [t("All together"), t("{time} person-seconds", { time: digits(time, 3) })],
    ];
}

export function Limit({ film }: { film: Film }) {
    if (film.playing.value) beat.value;
    const of = plan.value.limit;
    return (
        <>
            <h2>{t("Squeeze above a limit")}</h2>
            <div class="row">
                <NumberField label={t("Limit")} unit="N" value={of.force} min={1} max={1e6} step={10} onChange={(force) => change({ limit: { ...of, force } })} />
                <NumberField of={t("Limit")} label={t("mean over")} unit="s" value={of.seconds} min={0.01} max={600} step={0.5} onChange={(seconds) => change({ limit: { ...of, seconds } })} />
            </div>
            <Facts rows={aboveLimit(film)} />
            <p class="note">{t("623 N is what men tolerated against a flat bar. No number here says who is hurt: About this scale, below the picture, says more.")}</p>
        </>
    );
}
