// Drawing and changing a room by pointer and keys.

import { computed, signal } from "@preact/signals";
import { type Inks, label } from "./draw";
import { drawn, edited } from "./drawn";
import { length } from "./parts";
import { type KeptCrowd, MOST } from "./forms";
import { change, plan } from "./plan";
import type { Point, Room } from "./protocol";
import { distance, rings, snapped, spanned, squared } from "./roomshape";
import { lineTool, type Pointer, type Tool } from "./tool";
import { inMetres, type View } from "./view";

/** What the next presses do. */
export type Mode = "change" | "outline" | "polygon" | "rectangle" | "door" | "region";
export const mode = signal<Mode>("change");

/** Width of a new door, in m. */
const DOOR = 1;

export type Part = { kind: "corner"; ring: number; k: number } | { kind: "door"; k: number };
export const picked = signal<Part | null>(null);

/** Corners of what is being drawn. */
const sketch = signal<Point[]>([]);
/** Where the pointer is, snapped. */
const hover = signal<Point | null>(null);
/** While something is dragged. */
const dragged = signal<KeptCrowd | null>(null);
/** The room as it was pressed on. */
let pressed: Room | null = null;

export const draft = computed(() => dragged.value ?? plan.value.crowd);
const courses = computed(() => drawn(draft.value.room).doors);

export function setRoom(room: Room) {
    change({ crowd: { ...plan.value.crowd, room } });
}

export function begin(next: Mode) {
    mode.value = next;
    if (next !== "change") lineTool.value = null;
    sketch.value = [];
    hover.value = null;
    dragged.value = null;
    picked.value = null;
}

/** What is drawn becomes a part of the room. */
function finish() {
    const corners = sketch.value;
    const { crowd } = plan.value;
    const kind = mode.value;
    begin("change");
    if (corners.length < 3) return;
    if (kind === "outline") change({ crowd: { ...crowd, room: { outline: corners, obstacles: [], doors: [] }, region: null } });
    else if (kind === "region") change({ crowd: { ...crowd, region: corners } });
    else setRoom({ ...crowd.room, obstacles: [...crowd.room.obstacles, corners].slice(-MOST.parts) });
}

export function remove(part: Part) {
    const { room } = plan.value.crowd;
    picked.value = null;
    if (part.kind === "door") return setRoom({ ...room, doors: room.doors.filter((_, k) => k !== part.k) });
    const { ring, k: corner } = part;
    // Three corners are the fewest; an obstacle goes with them.
    if (rings(room)[ring]!.length > 3) setRoom(edited(room, { do: "remove", ring, corner }));
    else if (ring > 0) setRoom(edited(room, { do: "clear", ring }));
}

/** A corner on a side, or in its middle. */
export function insert(room: Room, ring: number, side: number, at?: Point): Room {
    if (rings(room)[ring]!.length >= MOST.corners) return room;
    return edited(room, { do: "insert", ring, side, at: snapped(at ?? drawn(room).rings[ring]!.middles[side]!) });
}

/** The part under the pointer: doors first, then corners, then a wall, which gets a corner. */
function grab({ at, reach }: Pointer): { part: Part; room: Room } | null {
    const { room } = plan.value.crowd;
    const door = room.doors.findIndex((given) => distance(given.at, at) < Math.max(reach, given.width / 3));
    if (door >= 0) return { part: { kind: "door", k: door }, room };
    for (const [ring, corners] of rings(room).entries()) {
        const k = corners.findIndex((corner) => distance(corner, at) < reach);
        if (k >= 0) return { part: { kind: "corner", ring, k }, room };
    }
    const { near } = drawn(room, at);
    if (!near || near.away >= reach || rings(room)[near.ring]!.length >= MOST.corners) return null;
    return { part: { kind: "corner", ring: near.ring, k: near.side + 1 }, room: insert(room, near.ring, near.side, at) };
}

function dragTo({ at, shift }: Pointer) {
    const part = picked.value;
    const crowd = dragged.value;
    const room = pressed;
    if (!part || !crowd || !room) return;
    if (part.kind === "door") {
        const { near } = drawn(room, at);
        const doors = room.doors.map((door, k) => (k === part.k && near ? { ...door, at: snapped(near.at) } : door));
        dragged.value = { ...crowd, room: { ...room, doors } };
        return;
    }
    const { ring, k: corner } = part;
    const before = rings(room)[ring]!.at(corner - 1)!;
    dragged.value = { ...crowd, room: edited(room, { do: "move", ring, corner, to: snapped(shift ? squared(at, before) : at) }) };
}

function next({ at, shift }: Pointer): Point {
    const last = sketch.value.at(-1);
    return snapped(shift && last ? squared(at, last) : at);
}

/** A click that draws counts when it ends: a second finger may make it a pinch. */
let held: Pointer | null = null;

function press(pointer: Pointer): boolean {
    const kind = mode.value;
    held = null;
    if (kind === "change") {
        const found = grab(pointer);
        picked.value = found?.part ?? null;
        if (!found) return false;
        pressed = found.room;
        dragged.value = { ...plan.value.crowd, room: pressed };
        return true;
    }
    if (kind === "rectangle" || kind === "region") sketch.value = [next(pointer)];
    else held = pointer;
    return true;
}

/** A click while a door or corners are drawn. */
function click(pointer: Pointer) {
    if (mode.value === "door") {
        const { room } = plan.value.crowd;
        const { near } = drawn(room, pointer.at);
        if (near && near.away < 3 * pointer.reach && room.doors.length < MOST.parts) {
            setRoom({ ...room, doors: [...room.doors, { at: snapped(near.at), width: DOOR }] });
            mode.value = "change";
            picked.value = { kind: "door", k: room.doors.length };
        }
        return;
    }
    const closes = sketch.value.length >= 3 && distance(pointer.at, sketch.value[0]!) < 1.5 * pointer.reach;
    if (pointer.double || closes || sketch.value.length >= MOST.corners) finish();
    else sketch.value = [...sketch.value, next(pointer)];
}

export const roomTool: Tool = {
    draws: () => mode.value !== "change",
    down: press,
    move(pointer, drags) {
        hover.value = next(pointer);
        if (drags && dragged.value) dragTo(pointer);
    },
    cancel() {
        held = null;
        dragged.value = null;
        if (mode.value === "rectangle" || mode.value === "region") sketch.value = [];
        // A corner of an edge is none yet.
        if (mode.value === "change") picked.value = null;
    },
    up(pointer) {
        const kind = mode.value;
        if (held && kind !== "change") click(held);
        held = null;
        if (kind === "rectangle" || kind === "region") {
            const [from, to] = [sketch.value[0], snapped(pointer.at)];
            if (!from || from[0] === to[0] || from[1] === to[1]) return;
            sketch.value = spanned(from, to);
            return finish();
        }
        const crowd = dragged.value;
        dragged.value = null;
        if (crowd) change({ crowd });
    },
    key(event) {
        const drawing = mode.value !== "change";
        if (event.key === "Escape" && drawing) begin("change");
        else if (event.key === "Enter" && drawing) finish();
        else if (event.key === "Backspace" && drawing) sketch.value = sketch.value.slice(0, -1);
        else if ((event.key === "Delete" || event.key === "Backspace") && picked.value) remove(picked.value);
        else return false;
        return true;
    },
    extent: () => rings(plan.value.crowd.room).flat(),
    faint: () => {
        const { base } = plan.value.made;
        return base.kind !== "crowd" || JSON.stringify(base.room) !== JSON.stringify(draft.value.room);
    },
    paint(context, view, inks) {
        const { room, region } = draft.value;
        const pixel = devicePixelRatio / view.scale;
        if (region) paintRegion(context, region, pixel, inks);
        context.strokeStyle = inks.pick;
        context.lineWidth = 3 * pixel;
        for (const corners of rings(room)) trace(context, corners, true);
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
    context.beginPath();
    corners.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
    if (closed) context.closePath();
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
    for (const [ring, corners] of rings(room).entries()) {
        corners.forEach(([x, y], k) => {
            const half = (isPicked("corner", k, ring) ? 7 : 5) * pixel;
            context.fillStyle = isPicked("corner", k, ring) ? inks.mark : inks.paper;
            context.strokeStyle = inks.pick;
            context.lineWidth = 2 * pixel;
            context.fillRect(x - half, y - half, 2 * half, 2 * half);
            context.strokeRect(x - half, y - half, 2 * half, 2 * half);
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
        const [course] = drawn({ ...draft.value.room, doors: [{ at: to, width: DOOR }] }).doors;
        return paintDoor(context, course!, pixel, inks, true);
    }
    context.beginPath();
    context.arc(...to, 4 * pixel, 0, 2 * Math.PI);
    context.fill();
    const { unit } = plan.value;
    if (!first) {
        return label(context, `${length(to[0], unit)}, ${length(to[1], unit)}`, [to[0], to[1] - 18 * pixel], view, inks);
    }
    const spans = mode.value === "rectangle" || mode.value === "region";
    trace(context, spans ? spanned(first, to) : [...corners, to], spans);
    for (const corner of corners) {
        context.beginPath();
        context.arc(...corner, 5 * pixel, 0, 2 * Math.PI);
        context.fill();
    }
    const last = corners.at(-1)!;
    const words = spans ? `${length(Math.abs(to[0] - first[0]), unit)} × ${length(Math.abs(to[1] - first[1]), unit)}` : length(distance(last, to), unit);
    label(context, words, [(last[0] + to[0]) / 2, (last[1] + to[1]) / 2], view, inks);
    inMetres(context, view);
}
