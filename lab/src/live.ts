// One scene, always live: people are placed again when the forms of the room or of the crowd change. What moves them stays
// as far as it still fits.

import { effect, signal } from "@preact/signals";
import { ready, shape } from "./drawn";
import { type KeptCrowd, ofAllPairs } from "./forms";
import { t } from "./language";
import { arrived, crowdOf, opened, plan } from "./plan";
import { beyond, cornersOf } from "./places";
import type { Motion, Point, Room } from "./protocol";
import { rename } from "./scenes";
import { choose, film, playsOn, said } from "./session";

/** Milliseconds without a further change. */
const PAUSE = 300;
/** How far beyond a room exits and ways may lie, in m. */
const BEYOND = 5;

/** What was placed last, or could not be. */
let tried = "";
/** Doors of exits that lie beyond doors, by the exits' names: until the lines beyond the new doors are known. */
const following = signal<{ doors: Map<string, number>; before: unknown; base: string } | null>(null);

/** Whether people stand as the forms say. */
export function isPlaced() {
    const { made, crowd } = plan.value;
    return JSON.stringify(crowdOf(made.base)) === JSON.stringify(crowd);
}

/** Begins to place people when the forms change, if the scene is of a crowd. */
export function follow() {
    effect(() => {
        const { made, crowd } = plan.value;
        const wanted = JSON.stringify(crowd);
        if (made.base.kind !== "crowd" || isPlaced()) {
            tried = "";
            return;
        }
        // A scene that was opened is shown, or refused, as it is.
        if (wanted === tried || !ready() || arrived.value !== opened.value) return;
        const timer = setTimeout(() => {
            tried = wanted;
            place(false);
        }, PAUSE);
        return () => clearTimeout(timer);
    });
    effect(() => {
        const shown = film.value;
        const wanted = following.value;
        if (!shown || !wanted || shown === wanted.before) return;
        following.value = null;
        const { base, motion } = plan.peek().made;
        // The placing failed, and this is another one.
        if (JSON.stringify(base) !== wanted.base) return;
        const next = beyond(motion, ({ name }) => wanted.doors.get(name), shown.scene.beyond_doors);
        if (JSON.stringify(next) !== JSON.stringify(motion)) choose({ motion: next }, shown.playing.peek(), plan.peek().crowd, said.peek(), false);
    });
}

/** Places the people of the forms. If other people stand there then, what was done to single ones by hand is over. */
export function place(asStep: boolean) {
    const { crowd, made } = plan.value;
    const before = made.base.kind === "crowd" ? made.base.room : null;
    const { motion, gone } = kept(made.motion, before, crowd);
    const edits = made.base.kind === "crowd" && same(made.base, crowd) ? made.edits : [];
    if (edits.length < made.edits.length) gone.push(t("changes by hand"));
    // Another material has other numbers.
    const was = made.base.kind === "crowd" && made.base.material === crowd.material ? made.base : null;
    const mechanics = was?.friction === crowd.friction ? made.mechanics : was ? ofAllPairs(made.mechanics, crowd.material) : undefined;
    if (made.mechanics && !mechanics) gone.push(t("changed materials and steps"));
    const words = gone.length > 0 ? t("Not there any more: {gone}. Undo brings them back.", { gone: gone.join(", ") }) : "";
    if (asStep) rename("A crowd");
    choose({ base: { kind: "crowd", ...crowd }, edits, mechanics, motion }, !asStep && playsOn(), crowd, words, asStep);
}

/** Whether the same people stand at the same places in both crowds. */
export function same(one: KeptCrowd, other: KeptCrowd): boolean {
    const [a, b] = [one, other].map(({ room: { outline, obstacles, walls }, seed, number, density, region, people, mix, men, direction, round, levels }) => JSON.stringify([outline, obstacles, walls, seed, number, density, region, people, mix, men, direction, round, levels]));
    return a === b;
}

/** The place of each old door among the new ones. */
function doorAfter(before: Room, after: Room, door: number): number {
    if (before.doors.length <= after.doors.length) return door;
    const text = JSON.stringify(before.doors[door]);
    return after.doors.findIndex((one) => JSON.stringify(one) === text);
}

/** What moves people, without what lies elsewhere now, which is told. */
function kept(motion: Motion, before: Room | null, crowd: KeptCrowd): { motion: Motion; gone: string[] } {
    const { room } = crowd;
    const [width, height, left, low] = shape(room.outline).bounds;
    const near = ([x, y]: Point) => x >= left - BEYOND && x <= left + width + BEYOND && y >= low - BEYOND && y <= low + height + BEYOND;
    const gone: string[] = [];
    const stays = <T>(parts: T[], fits: (part: T) => boolean, name: (k: number) => string): T[] =>
        parts.filter((part, k) => {
            const fit = fits(part);
            if (!fit) gone.push(name(k));
            return fit;
        });
    following.value = null;
    if (motion.kind === "push") {
        const pushes = stays(motion.pushes, ({ at, radius }) => at[0] > left - radius && at[0] < left + width + radius && at[1] > low - radius && at[1] < low + height + radius, (k) => t("push {k}", { k: k + 1 }));
        return { motion: pushes.length > 0 ? { ...motion, pushes } : { kind: "none" }, gone };
    }
    if (motion.kind === "walk") {
        const ways = stays(motion.ways, (way) => way.every(({ x, y }) => near([x, y])), (k) => t("way {k}", { k: k + 1 }));
        const shares = motion.shares && motion.shares.filter((_, k) => ways.includes(motion.ways[k]!));
        return { motion: ways.length > 0 ? { ...motion, ways, shares } : { kind: "none" }, gone };
    }
    if (motion.kind !== "go") return { motion, gone };
    const { decision } = motion;
    const lines = (film.value?.scene.beyond_doors ?? []).map((line) => JSON.stringify(line));
    const doors = new Map<string, number>();
    const exits = stays(
        decision.exits,
        (exit) => {
            const door = lines.indexOf(JSON.stringify(exit.line));
            if (door < 0 || !before) return cornersOf(exit).every(near);
            const now = doorAfter(before, room, door);
            doors.set(exit.name, now);
            return now >= 0;
        },
        (k) => JSON.stringify(decision.exits[k]!.name),
    );
    const goals = stays(decision.goals, (goal) => cornersOf(goal).every(near), (k) => JSON.stringify(decision.goals[k]!.name));
    if (exits.length + goals.length === 0) return { motion: { kind: "none" }, gone };
    const names = [...exits, ...goals].map(({ name }) => name);
    const agents = Object.entries(decision.agents).filter(([, { exit, goal }]) => names.includes(exit ?? goal ?? ""));
    following.value = { doors, before: film.value, base: JSON.stringify({ kind: "crowd", ...crowd }) };
    return { motion: { kind: "go", decision: { ...decision, exits, goals, agents: Object.fromEntries(agents) } }, gone };
}
