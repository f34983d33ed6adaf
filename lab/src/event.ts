// What happens too fast to be seen: pushes, and the wave that follows them. It is shown slowly, and the timeline ends with it.

import { signal } from "@preact/signals";
import { label, paintPush } from "./draw";
import type { Film } from "./film";
import { SQUEEZE } from "./frames";
import { handles } from "./handles";
import { pushWords } from "./motiontool";
import { plan } from "./plan";
import { COLUMNS, type Point, type Push } from "./protocol";
import { choose, film, selected } from "./session";

/** Simulated seconds in a second meanwhile. */
const SLOW = 0.1;
/** The wave is over when nobody is squeezed by more than this share of the greatest squeeze, or so long [s] after the pushes. */
const [OVER, LONGEST] = [0.05, 3];
/** [s] What is shown after it. */
const AFTER = 0.3;
/** [s] The answer is a mean over so long a time. */
const MEAN = 1;
/** [m] Along a push, people nearer to each other are in the same row. */
const ROW = 0.2;

/** [s] When it begins and ends, as far as it is computed; null: nothing like it. */
export function eventOf({ made: { motion }, scene: { leaving, step }, frames }: Film): [from: number, to: number] | null {
    if (motion.kind !== "push" || leaving > 0 || motion.pushes.length === 0) return null;
    const pushed = Math.max(...motion.pushes.map(({ start, duration }) => start + duration));
    const curve = frames.curve("greatest");
    const most = curve.reduce((one, other) => Math.max(one, other), 0);
    const wave = step * curve.findLastIndex((squeeze) => squeeze > OVER * most);
    return [Math.min(...motion.pushes.map(({ start }) => start)), Math.max(MEAN, AFTER + Math.max(pushed, Math.min(wave, pushed + LONGEST)))];
}

/** Simulated seconds in a second at a frame: chosen, or as slow as what happens needs it. */
export function paceAt(of: Film, frame: number): number {
    if (plan.value.pace) return plan.value.pace;
    const event = eventOf(of);
    const time = frame * of.scene.step;
    return event && time >= event[0] && time < event[1] ? SLOW : 1;
}

/** How many real seconds it takes up to a time [s]. */
export function lasts(of: Film, end: number): number {
    const event = plan.value.pace ? null : eventOf(of);
    const slow = event ? Math.max(0, Math.min(end, event[1]) - event[0]) : 0;
    return (end - slow) / (plan.value.pace || 1) + slow / SLOW;
}

/** Goes on by real seconds; by itself it stops where what happens is over. Who plays it again sees how it goes on. */
export function play(of: Film, seconds: number) {
    const end = plan.value.pace ? undefined : eventOf(of)?.[1];
    const [before, last] = [of.place.value, end && Math.ceil(end / of.scene.step - 1e-9)];
    of.tick(seconds, paceAt(of, before));
    if (last && before < last && of.place.value >= last) void of.show(last);
}

/** People by rows across the first push, from behind: how far they are [m], their mean squeeze [N] in a frame, and the greatest up to it. */
export function byRow({ made: { motion }, frames, scene }: Film, until: number): [far: number[], now: number[], greatest: number[]] {
    if (motion.kind !== "push" || motion.pushes.length === 0) return [[], [], []];
    const [angle, first] = [(motion.pushes[0]!.direction * Math.PI) / 180, frames.frame(0)];
    const far = scene.agents.map((_, a) => first[COLUMNS * a]! * Math.cos(angle) + first[COLUMNS * a + 1]! * Math.sin(angle));
    const rows: number[][] = [];
    for (const a of [...far.keys()].sort((a, b) => far[a]! - far[b]!)) {
        const row = rows.at(-1);
        if (row && far[a]! - far[row[0]!]! < ROW) row.push(a);
        else rows.push([a]);
    }
    const mean = (row: number[], k: number) => row.reduce((sum, a) => sum + frames.number(k, a, SQUEEZE), 0) / row.length;
    const back = far[rows[0]![0]!]!;
    const greatest = rows.map((row) => Array.from({ length: until + 1 }, (_, k) => mean(row, k)).reduce((one, other) => Math.max(one, other)));
    return [rows.map(([a]) => Number((far[a!]! - back).toFixed(2))), rows.map((row) => mean(row, until)), greatest];
}

const aim = signal<Push | null>(null);

/** Who is dragged is pushed that way, as hard as the pushes of the scene. */
export const pushTool = handles<Push, Point>({
    now: () => (plan.value.made.motion.kind === "push" ? plan.value.made.motion.pushes[0]! : null),
    dragged: aim,
    keeps: true,
    grab(now, { agent, at }) {
        const frame = film.value?.frames.frame(0);
        if (agent === null || !frame) return null;
        selected.value = agent;
        // Where they stand at the start: there it is said who is pushed. A click is no push.
        const place = [0, 1].map((axis) => Number(frame[COLUMNS * agent + axis]!.toFixed(3))) as Point;
        return { part: at, from: { ...now, at: place, direction: NaN } };
    },
    drag: (from, { at }, push) => ({ ...push, direction: Math.round((Math.atan2(at[1] - from[1], at[0] - from[0]) * 180) / Math.PI) }),
    put(push) {
        const { motion } = plan.value.made;
        if (motion.kind === "push" && !Number.isNaN(push.direction)) choose({ motion: { ...motion, pushes: [push] } }, true);
    },
    paint(context, view, inks) {
        const push = aim.value;
        if (!push || Number.isNaN(push.direction)) return;
        paintPush(context, push, -1, view, inks, true);
        label(context, pushWords(push), push.at, view, inks);
    },
});
