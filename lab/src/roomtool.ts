// Drawing and changing a room by pointer and keys.

import { computed, effect, signal } from "@preact/signals";
import { circle, handle, type Inks, through } from "./draw";
import { drawn, edited } from "./drawn";
import { aimed, type Drawing, draws, handles, sides } from "./handles";
import { t } from "./language";
import { MOST, roomFits } from "./forms";
import { change, plan } from "./plan";
import type { Point, Room } from "./protocol";
import { canLose, closes, distance, rings, snapped, spanned, wallAt } from "./roomshape";
import { bases, choose, problem, trialWalls } from "./session";
import { begin, begun, mode, type Pointer, ROOM } from "./tool";

/** Width of a new door, in m. */
const DOOR = 1;

export type Part = { kind: "corner"; ring: number; k: number } | { kind: "door"; k: number };
export const picked = signal<Part | null>(null);

/** While something is dragged. */
const dragged = signal<Room | null>(null);

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
    picked.value = null;
});

/** A rectangle is drawn by two corners, all else by as many as it has. */
const isSpan = (kind: string) => kind === "rectangle" || kind === "region";

/** What is drawn becomes a part of the room. */
function add(kind: (typeof ROOM)[number], points: Point[]) {
    const { crowd } = plan.value;
    const now = room.value;
    const corners = isSpan(kind) ? spanned(points[0]!, points[1]!) : points;
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
function grab(now: Room, { at, reach }: Pointer): { part: Part; from?: Room } | null {
    const door = now.doors.findIndex((given) => distance(given.at, at) < Math.max(reach, given.width / 3));
    if (door >= 0) return { part: { kind: "door", k: door } };
    for (const [ring, corners] of rings(now).entries()) {
        const k = corners.findIndex((corner) => distance(corner, at) < reach);
        if (k >= 0) return { part: { kind: "corner", ring, k } };
    }
    const { near } = drawn(now, at);
    if (!near || near.away >= reach || rings(now)[near.ring]!.length >= MOST.outline) return null;
    return { part: { kind: "corner", ring: near.ring, k: near.side + 1 }, from: insert(now, near.ring, near.side, at) };
}

/** A corner of a wall that is near: those of a Trial lie on no grid. */
function cornerNear({ at, reach }: Pointer, but?: { ring: number; k: number }): Point | undefined {
    if (target.value !== "trial" && mode.value !== "wall") return undefined;
    const others = rings(room.value).flatMap((corners, ring) => (ring === but?.ring ? [] : corners));
    return others.find((corner) => distance(corner, at) < reach);
}

function place(pointer: Pointer, last: Point | undefined): Point {
    return cornerNear(pointer) ?? aimed(pointer, last);
}

const doorAt = (at: Point) => ({ ...draft.value, doors: [{ at, width: DOOR }] });

for (const kind of ROOM) {
    const span = isSpan(kind);
    const shape: Drawing = {
        points: span ? [2, 2] : [kind === "wall" ? 2 : 3, MOST.corners],
        drag: span,
        closes: kind === "wall" ? "again" : true,
        place,
        fits: ([from, to]) => !span || (from![0] !== to![0] && from![1] !== to![1]),
        done: (points) => add(kind, points),
        paint(context, points, view, inks) {
            const pixel = devicePixelRatio / view.scale;
            context.strokeStyle = context.fillStyle = inks.mark;
            context.lineWidth = 2.5 * pixel;
            trace(context, span && points[1] ? spanned(points[0]!, points[1]) : points, span);
            for (const corner of points) {
                circle(context, corner, 5 * pixel);
                context.fill();
            }
        },
        words: span ? sides : undefined,
    };
    const door: Drawing = {
        points: [1, 1],
        place: ({ at }) => drawn(room.value, at).near?.at ?? at,
        fits: (_, { at, reach }) => (drawn(room.value, at).near?.away ?? Infinity) < 3 * reach && room.value.doors.length < MOST.parts,
        done([at]) {
            const { doors } = room.value;
            setRoom({ ...room.value, doors: [...doors, { at: snapped(at!), width: DOOR }] });
            picked.value = { kind: "door", k: doors.length };
        },
        paint(context, [at], view, inks) {
            const [course] = drawn(doorAt(at!)).doors;
            if (course?.length) paintDoor(context, course, devicePixelRatio / view.scale, inks, true);
        },
    };
    draws({ [kind]: kind === "door" ? door : shape });
}

export const roomTool = handles<Room, Part>({
    now: () => room.value,
    dragged,
    grab(now, pointer) {
        const found = grab(now, pointer);
        picked.value = found?.part ?? null;
        return found;
    },
    drag(part, pointer, from) {
        if (part.kind === "door") {
            const { near } = drawn(from, pointer.at);
            return { ...from, doors: from.doors.map((door, k) => (k === part.k && near ? { ...door, at: snapped(near.at) } : door)) };
        }
        const { ring, k: corner } = part;
        const corners = rings(from)[ring]!;
        // The last corner of a closed wall is the first one.
        const before = corners.at(corner === 0 && closes(corners) ? -2 : corner - 1)!;
        return edited(from, { do: "move", ring, corner, to: cornerNear(pointer, part) ?? aimed(pointer, before) });
    },
    put: setRoom,
    remove(whole) {
        const part = picked.value;
        // All of an obstacle or a wall.
        if (part?.kind === "corner" && whole && part.ring > 0) clear(part.ring);
        else if (part) remove(part);
        return part !== null;
    },
    step([dx, dy]) {
        const [part, now] = [picked.value, room.value];
        if (!part) return false;
        const sum = (at: number, by: number) => (by ? Number((at + by).toFixed(4)) : at);
        const moved = ([x, y]: Point): Point => [sum(x, dx), sum(y, dy)];
        if (part.kind === "door") setRoom({ ...now, doors: now.doors.map((door, k) => (k === part.k ? { ...door, at: moved(door.at) } : door)) });
        else setRoom(edited(now, { do: "move", ring: part.ring, corner: part.k, to: moved(rings(now)[part.ring]![part.k]!) }));
        picked.value = part;
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
        if (mode.value === "change") corners(context, room, pixel, inks);
    },
});

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

function corners(context: CanvasRenderingContext2D, room: Room, pixel: number, inks: Inks) {
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
