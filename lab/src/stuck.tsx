// People who do not get on: they want to go on, but stay where they are.

import { signal } from "@preact/signals";
import { circle } from "./draw";
import type { Film } from "./film";
import { count, t } from "./language";
import { brief, Button } from "./parts";
import { COLUMNS, GOES, isThere } from "./protocol";

/** Who has not moved by so many metres in so many seconds is stuck. Blocked people mill about: half a breadth of shoulders. */
const [FAR, LONG] = [0.25, 10];
/** Places that are looked at in this time. */
const LOOKS = 50;
/** Most Ids that are told. */
const MOST = 20;

/** Whether those who are stuck are marked on the picture. */
export const marked = signal(false);

let last: { film: Film; k: number; found: number[] } | null = null;

/** Who is stuck in a frame: was there for 10 s, wanted to get on all the time, and was never as far as that away. */
export function stuckIn(film: Film, k: number): number[] {
    if (last?.film === film && last.k === k) return last.found;
    const { scene, frames } = film;
    const span = Math.round(LONG / scene.step);
    const stride = Math.max(1, Math.floor(span / LOOKS));
    const stays = (_: unknown, a: number) => {
        const of = (j: number, column: number) => frames.number(j, a, column);
        for (let j = k; j >= k - span; j -= stride) {
            if (!(of(j, GOES) > 0 && Math.hypot(of(j, 0) - of(k, 0), of(j, 1) - of(k, 1)) < FAR)) return false;
        }
        return true;
    };
    const found = scene.walk && k >= span ? scene.agents.flatMap((agent, a) => (stays(agent, a) ? [a] : [])) : [];
    last = { film, k, found };
    return found;
}

/** Rings around them. */
export function paintStuck(context: CanvasRenderingContext2D, film: Film, frame: Float32Array, ink: string, pixel: number) {
    if (!marked.value) return;
    context.strokeStyle = ink;
    context.lineWidth = 3 * pixel;
    for (const a of stuckIn(film, film.shown.value)) {
        if (!isThere(frame, a)) continue;
        circle(context, [frame[COLUMNS * a]!, frame[COLUMNS * a + 1]!], 0.38);
        context.stroke();
    }
}

/** How many they are at the shown time, and who. */
export function Stuck({ film, k }: { film: Film; k: number }) {
    const found = stuckIn(film, k);
    if (found.length === 0) return null;
    const ids = found.slice(0, MOST).map((a) => brief(film.scene.agents[a]!.id));
    return (
        <div class="warning">
            <p>{`${count(found.length, "{n} person wants to get on", "{n} people want to get on")}${t(", but moved by less than {far} cm in the last {long} s.", { far: 100 * FAR, long: LONG })}`}</p>
            <p>
                {ids.join(", ")}
                {found.length > MOST && " …"}
            </p>
            <Button words={t("Mark them on the picture")} aria-pressed={marked.value} onClick={() => (marked.value = !marked.value)} />
        </div>
    );
}
