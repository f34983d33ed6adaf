// Drawing and changing a room by pointer and keys.

import { computed, effect, signal } from "@preact/signals";
import { circle, handle, type Inks, label, through } from "./draw";
import { drawn, edited } from "./drawn";
import { t } from "./language";
import { length } from "./parts";
import { MOST, roomFits } from "./forms";
import { change, plan } from "./plan";
import type { Point, Room } from "./protocol";
import { canLose, closes, distance, rings, snapped, spanned, squared, wallAt } from "./roomshape";
import { bases, choose, problem, trialWalls } from "./session";
import { begin, begun, clicks, drawingKey, hover, mode, type Pointer, sketch, type Tool } from "./tool";
import { inMetres, type View } from "./view";

/** Width of a new door, in m. */
const DOOR = 1;

export type Part = { kind: "corner"; ring: number; k: number } | { kind: "door"; k: number };
export const picked = signal<Part | null>(null);

/** While something is dragged. */
const dragged = signal<Room | null>(null);
/** The room as it was pressed on. */
let pressed: Room | null = null;

/** Whether the walls of the Trial on the stage are changed, or the room of the forms; null: whichever is nearer at hand. */
const chosen = signal<"trial" | "forms" | null>(null);
export const target = computed(() => {
    const { kind } = plan.value.made.base;
    if (kind === "crowd") return "forms";
    return chosen.value ?? (kind === "upload" ? "trial" : "forms");
});

export function aim(at: "trial" | "forms") {
    begin("change");
    chosen.value = at;
}

effect(() => {
    bases.value;
    chosen.value = null;
});
// What is drawn belongs to one of both.
effect(() => {
    target.value;
    begin("change");
});

const NOTHING: Room = { outline: [], obstacles: [], doors: [] };

/** The Trial's walls as they are changed, or else as its files have them; null until they are known. */
const ofTrial = computed((): Room | null => {
    const { base, edits } = plan.value.made;
    const changed = edits.find((edit) => edit.do === "room");
    if (changed) return changed.room;
    const own = trialWalls.value;
    if (own?.base !== JSON.stringify(base)) return null;
    return { outline: [], obstacles: [], walls: own.walls.map(({ id, corners }) => ({ corners, of: id })), doors: [] };
});

/** Why the walls of the Trial cannot be changed; empty if they can. */
export const fixed = computed(() => {
    const walls = ofTrial.value;
    if (!walls) return t("One moment …");
    const corners = rings(walls).flat().length;
    if (corners <= MOST.all && roomFits(walls)) return "";
    return t("These walls can be seen, but not be changed here: there are {n} with {corners} corners. This page changes up to {walls} walls with up to {all} corners.", { n: rings(walls).length - 1, corners, walls: MOST.walls, all: MOST.all });
});

/** Whether the walls of the Trial on the stage were changed. */
export const isChanged = computed(() => plan.value.made.edits.some((edit) => edit.do === "room"));

/** The room that is changed. */
export const room = computed(() => (target.value === "forms" ? plan.value.crowd.room : fixed.value ? NOTHING : ofTrial.value!));
export const draft = computed(() => dragged.value ?? room.value);
const courses = computed(() => drawn(draft.value).doors);

export function setRoom(next: Room) {
    if (target.peek() === "forms") return change({ crowd: { ...plan.value.crowd, room: next } });
    // What is shown to be changed is not all of them then.
    if (fixed.peek()) {
        problem.value = fixed.peek();
        return;
    }
    setTrial({ do: "room", room: next });
}

function setTrial(...of: { do: "room"; room: Room }[]) {
    choose({ edits: [...plan.value.made.edits.filter((edit) => edit.do !== "room"), ...of] }, false);
}

/** The Trial has the walls of its files again. */
export const takeBack = () => setTrial();

effect(() => {
    begun.value;
    dragged.value = picked.value = null;
});

/** What is drawn becomes a part of the room. */
function finish() {
    const corners = sketch.value;
    const { crowd } = plan.value;
    const kind = mode.value;
    const now = room.value;
    begin("change");
    if (corners.length < (kind === "wall" ? 2 : 3)) return;
    if (kind === "outline") return change({ crowd: { ...crowd, room: { outline: corners, obstacles: [], doors: [] }, region: null }, drawn: null });
    if (kind === "region") return change({ crowd: { ...crowd, region: corners } });
    if (rings(now).length > MOST.walls) {
        problem.value = t("There are {walls} walls already.", { walls: MOST.walls });
        return;
    }
    const open = kind === "wall" && !closes(corners);
    const further = (wall: Point[]): Room => ({ outline: now.outline, obstacles: now.obstacles, walls: [...(now.walls ?? []), { corners: wall, of: null }], doors: now.doors });
    if (open) setRoom(further(corners));
    // A Trial has no obstacles but walls that are closed.
    else if (target.value === "trial") setRoom(further(kind === "wall" ? corners : [...corners, corners[0]!]));
    else setRoom({ ...now, obstacles: [...now.obstacles, kind === "wall" ? corners.slice(0, -1) : corners] });
}

export function remove(part: Part) {
    const now = room.value;
    picked.value = null;
    if (part.kind === "door") return setRoom({ ...now, doors: now.doors.filter((_, k) => k !== part.k) });
    const { ring, k: corner } = part;
    if (canLose(now, ring)) setRoom(edited(now, { do: "remove", ring, corner }));
    else if (ring > 0) clear(ring);
}

/** An obstacle or a wall goes away with its last corners. */
export function clear(ring: number) {
    picked.value = null;
    setRoom(edited(room.value, { do: "clear", ring }));
}

/** A corner on a side, or in its middle. */
export function insert(into: Room, ring: number, side: number, at?: Point): Room {
    if (rings(into)[ring]!.length >= MOST.outline) return into;
    return edited(into, { do: "insert", ring, side, at: snapped(at ?? drawn(into).rings[ring]!.middles[side]!) });
}

/** The part under the pointer: doors first, then corners, then a wall, which gets a corner. */
function grab({ at, reach }: Pointer): { part: Part; room: Room } | null {
    const now = room.value;
    const door = now.doors.findIndex((given) => distance(given.at, at) < Math.max(reach, given.width / 3));
    if (door >= 0) return { part: { kind: "door", k: door }, room: now };
    for (const [ring, corners] of rings(now).entries()) {
        const k = corners.findIndex((corner) => distance(corner, at) < reach);
        if (k >= 0) return { part: { kind: "corner", ring, k }, room: now };
    }
    const { near } = drawn(now, at);
    if (!near || near.away >= reach || rings(now)[near.ring]!.length >= MOST.outline) return null;
    return { part: { kind: "corner", ring: near.ring, k: near.side + 1 }, room: insert(now, near.ring, near.side, at) };
}

/** A corner of a wall that is near: those of a Trial lie on no grid. */
function cornerNear({ at, reach }: Pointer, but?: { ring: number; k: number }): Point | undefined {
    if (target.value !== "trial" && mode.value !== "wall") return undefined;
    const others = rings(room.value).flatMap((corners, ring) => (ring === but?.ring ? [] : corners));
    return others.find((corner) => distance(corner, at) < reach);
}

function dragTo(pointer: Pointer) {
    const part = picked.value;
    const now = pressed;
    if (!part || !dragged.value || !now) return;
    const { at, shift } = pointer;
    if (part.kind === "door") {
        const { near } = drawn(now, at);
        dragged.value = { ...now, doors: now.doors.map((door, k) => (k === part.k && near ? { ...door, at: snapped(near.at) } : door)) };
        return;
    }
    const { ring, k: corner } = part;
    const corners = rings(now)[ring]!;
    // The last corner of a closed wall is the first one.
    const before = corners.at(corner === 0 && closes(corners) ? -2 : corner - 1)!;
    dragged.value = edited(now, { do: "move", ring, corner, to: cornerNear(pointer, part) ?? snapped(shift ? squared(at, before) : at) });
}

function next(pointer: Pointer): Point {
    const last = sketch.value.at(-1);
    return cornerNear(pointer) ?? snapped(pointer.shift && last ? squared(pointer.at, last) : pointer.at);
}

function press(pointer: Pointer): boolean {
    const kind = mode.value;
    clicks.held = null;
    if (kind === "change") {
        const found = grab(pointer);
        picked.value = found?.part ?? null;
        if (!found) return false;
        pressed = found.room;
        dragged.value = pressed;
        return true;
    }
    if (kind === "rectangle" || kind === "region") sketch.value = [next(pointer)];
    else clicks.held = pointer;
    return true;
}

/** A click while a door or corners are drawn. */
function click(pointer: Pointer) {
    if (mode.value === "door") {
        const now = room.value;
        const { near } = drawn(now, pointer.at);
        if (near && near.away < 3 * pointer.reach && now.doors.length < MOST.parts) {
            setRoom({ ...now, doors: [...now.doors, { at: snapped(near.at), width: DOOR }] });
            mode.value = "change";
            picked.value = { kind: "door", k: now.doors.length };
        }
        return;
    }
    const first = sketch.value[0];
    const round = sketch.value.length >= 3 && distance(pointer.at, first!) < 1.5 * pointer.reach;
    if (round && mode.value === "wall") sketch.value = [...sketch.value, first!];
    if (pointer.double || round || sketch.value.length >= MOST.corners) finish();
    else sketch.value = [...sketch.value, next(pointer)];
}

const STEPS: Record<string, Point> = { ArrowLeft: [-0.05, 0], ArrowRight: [0.05, 0], ArrowUp: [0, 0.05], ArrowDown: [0, -0.05] };

/** What is marked is moved by a key. */
function step(part: Part, [dx, dy]: Point) {
    const now = room.value;
    const sum = (at: number, by: number) => (by ? Number((at + by).toFixed(4)) : at);
    const moved = ([x, y]: Point): Point => [sum(x, dx), sum(y, dy)];
    if (part.kind === "door") setRoom({ ...now, doors: now.doors.map((door, k) => (k === part.k ? { ...door, at: moved(door.at) } : door)) });
    else setRoom(edited(now, { do: "move", ring: part.ring, corner: part.k, to: moved(rings(now)[part.ring]![part.k]!) }));
    picked.value = part;
}

export const roomTool: Tool = {
    draws: () => mode.value !== "change",
    down: press,
    move(pointer, drags) {
        hover.value = next(pointer);
        if (drags && dragged.value) dragTo(pointer);
    },
    cancel() {
        clicks.held = null;
        dragged.value = null;
        if (mode.value === "rectangle" || mode.value === "region") sketch.value = [];
        // A corner of an edge is none yet.
        if (mode.value === "change") picked.value = null;
    },
    up(pointer) {
        const kind = mode.value;
        if (clicks.held && kind !== "change") click(clicks.held);
        clicks.held = null;
        if (kind === "rectangle" || kind === "region") {
            const [from, to] = [sketch.value[0], snapped(pointer.at)];
            if (!from || from[0] === to[0] || from[1] === to[1]) return;
            sketch.value = spanned(from, to);
            return finish();
        }
        const moved = dragged.value;
        dragged.value = null;
        // A press that moved nothing is no change.
        if (moved && JSON.stringify(moved) !== JSON.stringify(room.value)) setRoom(moved);
    },
    key(event) {
        if (drawingKey(event, finish)) return true;
        if ((event.key === "Delete" || event.key === "Backspace") && picked.value) {
            const { kind, ring } = { ring: 0, ...picked.value };
            // All of an obstacle or a wall.
            if (event.shiftKey && kind === "corner" && ring > 0) clear(ring);
            else remove(picked.value);
        } else if (event.shiftKey && STEPS[event.key] && picked.value) step(picked.value, STEPS[event.key]!);
        else return false;
        return true;
    },
    extent: () => rings(room.value).flat(),
    faint: () => {
        const { base } = plan.value.made;
        if (target.value === "trial") return dragged.value !== null;
        return base.kind !== "crowd" || JSON.stringify(base.room) !== JSON.stringify(draft.value);
    },
    paint(context, view, inks) {
        const room = draft.value;
        const region = target.value === "forms" ? plan.value.crowd.region : null;
        const pixel = devicePixelRatio / view.scale;
        if (region) paintRegion(context, region, pixel, inks);
        context.strokeStyle = inks.pick;
        context.lineWidth = 3 * pixel;
        for (const [ring, corners] of rings(room).entries()) trace(context, corners, !wallAt(room, ring));
        for (const [k, course] of courses.value.entries()) paintDoor(context, course, pixel, inks, isPicked("door", k));
        if (mode.value === "change") handles(context, room, pixel, inks);
        else paintSketch(context, view, pixel, inks);
    },
};

function isPicked(kind: Part["kind"], k: number, ring?: number) {
    const part = picked.value;
    return part?.kind === kind && part.k === k && (part.kind === "door" || part.ring === ring);
}

function trace(context: CanvasRenderingContext2D, corners: Point[], closed: boolean) {
    through(context, corners, closed);
    context.stroke();
}

function paintRegion(context: CanvasRenderingContext2D, region: Point[], pixel: number, inks: Inks) {
    context.strokeStyle = inks.way;
    context.fillStyle = inks.way;
    context.lineWidth = 1.5 * pixel;
    context.setLineDash([7 * pixel, 5 * pixel]);
    trace(context, region, true);
    context.setLineDash([]);
    context.globalAlpha = 0.12;
    context.fill();
    context.globalAlpha = 1;
}

/** A gap with its two ends. */
function paintDoor(context: CanvasRenderingContext2D, course: Point[], pixel: number, inks: Inks, chosen: boolean) {
    const thick = (chosen ? 4 : 2.5) * pixel;
    context.strokeStyle = inks.paper;
    context.lineWidth = 6 * pixel;
    trace(context, course, false);
    context.strokeStyle = chosen ? inks.mark : inks.pick;
    // Across each end: the first dash of a broad line. No other one follows.
    context.save();
    context.lineCap = "butt";
    context.lineWidth = 14 * pixel;
    context.setLineDash([thick, 1e6]);
    for (const from of [course, [...course].reverse()]) trace(context, from, false);
    context.restore();
    context.lineWidth = thick;
    context.setLineDash([3 * pixel, 3 * pixel]);
    trace(context, course, false);
    context.setLineDash([]);
}

function handles(context: CanvasRenderingContext2D, room: Room, pixel: number, inks: Inks) {
    context.strokeStyle = inks.pick;
    context.lineWidth = 2 * pixel;
    for (const [ring, corners] of rings(room).entries()) {
        corners.forEach((corner, k) => {
            const marked = isPicked("corner", k, ring);
            // Of a small column, not each corner has room for one.
            if (!marked && k > 0 && distance(corner, corners[k - 1]!) < 8 * pixel) return;
            handle(context, corner, (marked ? 7 : 5) * pixel, marked ? inks.mark : inks.paper);
        });
    }
}

function paintSketch(context: CanvasRenderingContext2D, view: View, pixel: number, inks: Inks) {
    const to = hover.value;
    const corners = sketch.value;
    const first = corners[0];
    context.strokeStyle = inks.mark;
    context.fillStyle = inks.mark;
    context.lineWidth = 2.5 * pixel;
    if (!to) return;
    if (mode.value === "door") {
        const [course] = drawn({ ...draft.value, doors: [{ at: to, width: DOOR }] }).doors;
        return course?.length ? paintDoor(context, course, pixel, inks, true) : undefined;
    }
    circle(context, to, 4 * pixel);
    context.fill();
    const { unit } = plan.value;
    if (!first) {
        return label(context, `${length(to[0], unit)}, ${length(to[1], unit)}`, [to[0], to[1] - 18 * pixel], view, inks);
    }
    const spans = mode.value === "rectangle" || mode.value === "region";
    trace(context, spans ? spanned(first, to) : [...corners, to], spans);
    for (const corner of corners) {
        circle(context, corner, 5 * pixel);
        context.fill();
    }
    const last = corners.at(-1)!;
    const words = spans ? `${length(Math.abs(to[0] - first[0]), unit)} × ${length(Math.abs(to[1] - first[1]), unit)}` : length(distance(last, to), unit);
    label(context, words, [(last[0] + to[0]) / 2, (last[1] + to[1]) / 2], view, inks);
    inMetres(context, view);
}
