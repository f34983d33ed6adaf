// Single people, moved, turned, copied and deleted by hand. Each act is one edit of the plan.

import { computed, signal } from "@preact/signals";
import { count, t } from "./language";
import { circle, strokes, through } from "./draw";
import { digits } from "./parts";
import { MOST } from "./forms";
import { handles } from "./handles";
import { plan } from "./plan";
import { COLUMNS, type Edit, isThere, type Overlaps, type PersonRequest, type Point, type Scene } from "./protocol";
import { away, distance } from "./roomshape";
import { choose, client, film, problem, selected, selectNext } from "./session";
import { inMetres } from "./view";

export interface Pose {
    agent: number;
    x: number;
    y: number;
    theta: number;
}

/** Distance of the handle that turns from the middle of the person, in m. */
const ARM = 0.5;

/** Nobody is selected yet. */
const NOBODY: Pose = { agent: -1, x: 0, y: 0, theta: 0 };
/** Where somebody is dragged to; it stays until the scene with it is there. */
const pose = signal<Pose | null>(null);
const overlaps = signal<Overlaps | null>(null);
/** Those whom the dragged person overlapped before. */
let partners: number[] = [];
let asking = false;

/** People can be moved where they start only. */
export const movable = computed(() => film.value !== null && film.value.place.value === 0);

/** Where the selected person is. */
export const chosen = computed<Pose | null>(() => {
    const shown = film.value;
    const agent = selected.value;
    if (!shown || agent === null || agent >= shown.scene.agents.length) return null;
    if (pose.value?.agent === agent) return pose.value;
    // What was said last may not be on the stage yet.
    const { id } = shown.scene.agents[agent]!;
    for (const edit of [...plan.value.made.edits].reverse()) {
        if (edit.do === "move" && edit.id === id) return { agent, x: edit.x, y: edit.y, theta: edit.theta };
    }
    const frame = shown.frames.frame(0);
    if (!isThere(frame, agent)) return null;
    return { agent, x: frame[COLUMNS * agent]!, y: frame[COLUMNS * agent + 1]!, theta: frame[COLUMNS * agent + 2]! };
});

/** Says whom the dragged person overlaps. */
export const said = computed(() => {
    const found = overlaps.value;
    if (!pose.value || !found) return "";
    if (found.depth <= 0) return t("No overlap.");
    const others = found.agents.length;
    const those = found.wall ? count(others, "{n} other and a wall", "{n} others and a wall") : count(others, "{n} other", "{n} others");
    return t("It overlaps {whom}, by {depth} mm.", { whom: others > 0 ? those : t("a wall"), depth: digits(1000 * found.depth, 2) });
});

/** One question at a time; the last place counts. */
async function ask() {
    if (asking) return;
    asking = true;
    try {
        for (let at = pose.peek(); at && film.value; at = pose.peek()) {
            const { value } = await client.ask<Overlaps>({ ask: "overlaps", run: film.value.scene.run, ...at });
            if (pose.peek()) overlaps.value = value;
            if (pose.peek() === at) break;
        }
    } catch {
        // The scene is another one by now.
    } finally {
        asking = false;
    }
}

/** Whom somebody overlaps before a drag. */
function seek(at: Pose) {
    overlaps.value = null;
    partners = [];
    const run = film.value!.scene.run;
    client
        .ask<Overlaps>({ ask: "overlaps", run, ...at })
        .then(({ value }) => {
            partners = value.agents;
            if (pose.peek()) overlaps.value ??= value;
        })
        .catch(() => {});
}

const clean = (value: number) => Number(value.toFixed(4));

/** Whether an edit adds the person with this Id. */
function isNew(edit: Edit, id: string) {
    return (edit.do === "copy" && edit.as === id) || (edit.do === "put" && edit.id === id);
}

type OfPerson = Exclude<Edit, { do: "room" }>;

/** Where somebody stood before the last of several moves does not matter, nor do copies that are deleted. */
function edited(edits: Edit[], next: OfPerson): Edit[] {
    if (next.do === "copy" || next.do === "put") return [...edits, next];
    const stays = edits.filter((edit) => !(edit.do === "move" && edit.id === next.id));
    const copied = stays.some((edit) => isNew(edit, next.id));
    const copies = stays.some((edit) => edit.do === "copy" && edit.id === next.id);
    if (next.do === "delete" && copied && !copies) return stays.filter((edit) => !isNew(edit, next.id));
    return [...stays, next];
}

function act(edit: OfPerson) {
    const { edits } = plan.value.made;
    const after = edited(edits, edit);
    if (after.length > MOST.edits) {
        problem.value = t("There are {most} changes by hand already.", { most: MOST.edits });
        pose.value = null;
        return;
    }
    choose({ edits: after }, false);
}

const idOf = (agent: number) => film.value!.scene.agents[agent]!.id;

export function put(to: Pose) {
    pose.value = to;
    act({ do: "move", id: idOf(to.agent), x: clean(to.x), y: clean(to.y), theta: clean(to.theta) });
}

/** An Id that nobody has. */
function newId(): string {
    // Also not one of an earlier edit: a later one would mean somebody else.
    const edited = plan.value.made.edits.flatMap((edit) => (edit.do === "copy" ? [edit.id, edit.as] : edit.do === "room" ? [] : [edit.id]));
    const present = film.value!.scene.agents.map(({ id }) => id);
    const ids = [...present, ...edited].map(Number).filter(Number.isSafeInteger);
    return String(Math.max(-1, ...ids) + 1);
}

export function copy({ agent, x, y, theta }: Pose) {
    const as = newId();
    selectNext(as);
    // Beside it: the copy is dragged to its place.
    const [right, up] = [Math.sin(theta), -Math.cos(theta)];
    act({ do: "copy", id: idOf(agent), as, x: clean(x + 0.6 * right), y: clean(y + 0.6 * up), theta: clean(theta) });
}

/** Somebody more, at a place or where most room is among the people, facing like the first one. */
export function add(person: PersonRequest, at: Point | null) {
    const frame = film.value!.frames.frame(0);
    const [x, y] = at ?? roomiest(film.value!.scene, frame);
    const id = newId();
    selectNext(id);
    act({ do: "put", id, person: { ...person, altitude: null }, x: clean(x), y: clean(y), theta: clean(frame[2]!) });
}

/** The point of a grid over the people that is farthest from everybody and from walls. */
function roomiest({ agents, walls }: Scene, frame: Float32Array): Point {
    const there = agents.flatMap((_, a): Point[] => (isThere(frame, a) ? [[frame[COLUMNS * a]!, frame[COLUMNS * a + 1]!]] : []));
    const [xs, ys] = [0, 1].map((k) => there.map((at) => at[k]!)) as [number[], number[]];
    const [left, low] = [Math.min(...xs), Math.min(...ys)];
    const [width, height] = [Math.max(...xs) - left, Math.max(...ys) - low];
    const pieces = walls.flatMap(({ corners }) => corners.slice(1).map((corner, k) => [corners[k]!, corner]));
    const count = 40;
    let [best, most]: [Point, number] = [[left, low], -Infinity];
    for (let k = 0; k < count * count; k++) {
        const at: Point = [left + (width * (k % count)) / count, low + (height * Math.floor(k / count)) / count];
        const free = Math.min(...there.map((other) => distance(at, other)), ...pieces.map((piece) => away(at, piece)));
        if (free > most) [best, most] = [at, free];
    }
    return best;
}

export function drop({ agent }: Pose) {
    if (film.value!.scene.agents.length > 1) act({ do: "delete", id: idOf(agent) });
}

/** After another scene came. */
export function forget() {
    pose.value = null;
    overlaps.value = null;
}

const handle = ({ x, y, theta }: Pose): Point => [x + ARM * Math.cos(theta), y + ARM * Math.sin(theta)];

/** Where it was pressed from the middle of the person, or the handle that turns. */
export const handTool = handles<Pose, Point | "turn">({
    now: () => (movable.value ? chosen.value : null) ?? NOBODY,
    dragged: pose,
    grab(now, pointer) {
        if (!movable.value) return null;
        if (now !== NOBODY && distance(handle(now), pointer.at) < pointer.reach) {
            seek(now);
            return { part: "turn" };
        }
        if (pointer.agent === null) return null;
        selected.value = pointer.agent;
        const from = chosen.value!;
        seek(from);
        return { part: [from.x - pointer.at[0], from.y - pointer.at[1]], from };
    },
    drag(part, { at, shift }, from) {
        void ask();
        if (part !== "turn") return { ...from, x: at[0] + part[0], y: at[1] + part[1] };
        const angle = Math.atan2(at[1] - from.y, at[0] - from.x);
        const step = Math.PI / 12;
        return { ...from, theta: shift ? Math.round(angle / step) * step : angle };
    },
    put,
    remove: () => movable.value && chosen.value !== null && (drop(chosen.value), true),
    step([dx, dy]) {
        const now = chosen.value;
        if (!now || !movable.value) return false;
        put({ ...now, x: now.x + dx, y: now.y + dy });
        return true;
    },
    frame(frame) {
        const now = pose.value;
        if (!now) return frame;
        const moved = frame.slice();
        moved.set([now.x, now.y, now.theta], COLUMNS * now.agent);
        return moved;
    },
    overlapping() {
        const now = pose.value;
        const scene = film.value?.scene;
        if (!now || !scene) return null;
        const stays = scene.overlapping.filter((a) => a !== now.agent && !partners.includes(a));
        const found = overlaps.value;
        if (!found || found.depth <= 0) return stays;
        return [...new Set([...stays, ...found.agents, now.agent])];
    },
    paint(context, view, inks) {
        const now = chosen.value;
        if (!now || !movable.value) return;
        inMetres(context, view);
        const pixel = devicePixelRatio / view.scale;
        const [x, y] = handle(now);
        context.fillStyle = inks.paper;
        through(context, [[now.x + 0.2 * (x - now.x), now.y + 0.2 * (y - now.y)], [x, y]]);
        strokes(context, [[inks.pick, 2 * pixel]]);
        circle(context, [x, y], 7 * pixel);
        context.fill();
        context.stroke();
    },
});
