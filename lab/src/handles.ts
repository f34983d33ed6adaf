// One model of all that is drawn and dragged on the picture: what each tool fills in.

import { type Signal } from "@preact/signals";
import { type Inks, label } from "./draw";
import { length } from "./parts";
import { plan } from "./plan";
import type { Point } from "./protocol";
import { distance, snapped, squared } from "./roomshape";
import { begin, begun, hover, type Mode, mode, over, type Pointer, sketch, type Tool } from "./tool";
import { inMetres, type View } from "./view";

/** What the points that are drawn in a mode become. */
export interface Drawing {
    /** How many points: a click makes one; Enter or a double click ends it, and so does the last one. */
    points: [least: number, most: number];
    /** The first and the last point are also those of a drag. */
    drag?: boolean;
    /** A click on the first point ends it; "again": that is its last point, too. */
    closes?: boolean | "again";
    /** Where the next point is; otherwise snapped and, with Shift, at a right angle. */
    place?(pointer: Pointer, last: Point | undefined): Point;
    /** Whether they can be it; if not, it is drawn anew. */
    fits?(points: Point[], pointer: Pointer, dragged: boolean): boolean;
    done(points: Point[], dragged: boolean): void;
    /** The last point is that of the pointer. */
    paint(context: CanvasRenderingContext2D, points: Point[], view: View, inks: Inks, drags: boolean): void;
    /** What is said of it meanwhile, if not the length of the last piece. */
    words?(points: Point[], drags: boolean): string | undefined;
}

const drawings: Partial<Record<Mode, Drawing>> = {};
/** A press that draws counts when it ends: a second finger may make it a pinch. */
let held: Pointer | null = null;
let drags = false;

export function draws(what: Partial<Record<Mode, Drawing>>) {
    Object.assign(drawings, what);
    for (const key of Object.keys(what)) over[key as Mode] = pen;
}

export const aimed = ({ at, shift }: Pointer, from: Point | undefined): Point => snapped(shift && from ? squared(at, from) : at);

function placed(pointer: Pointer): Point {
    return (drawings[mode.value]!.place ?? aimed)(pointer, sketch.value.at(-1));
}

function finish(dragged = false) {
    const [drawing, points] = [drawings[mode.value]!, sketch.value];
    begin("change");
    if (points.length >= drawing.points[0]) drawing.done(points, dragged);
}

/** It ends with these points, if they can be it. */
function offer(points: Point[], pointer: Pointer, dragged: boolean) {
    const fits = drawings[mode.value]!.fits?.(points, pointer, dragged) ?? true;
    sketch.value = fits ? points : [];
    if (fits) finish(dragged);
}

function click(pointer: Pointer) {
    const { points, closes } = drawings[mode.value]!;
    const most = points[1];
    const near = (point: Point | undefined) => point !== undefined && distance(pointer.at, point) < 1.5 * pointer.reach;
    // Two clicks at one place are no line.
    if (most === 2 && near(sketch.value.at(-1))) return;
    const now = sketch.value.length < most ? sketch.value : [];
    if (closes && now.length >= 3 && near(now[0])) {
        if (closes === "again") sketch.value = [...now, now[0]!];
        return finish();
    }
    if (pointer.double && most > 2) return finish();
    const next = [...now, placed(pointer)];
    if (next.length >= most) offer(next, pointer, false);
    else sketch.value = next;
}

const pen: Tool = {
    draws: () => true,
    down(pointer) {
        held = pointer;
        return true;
    },
    move(pointer, pressed) {
        if (pressed && held && drawings[mode.value]!.drag) {
            if (!drags) sketch.value = [placed(held)];
            drags = true;
        }
        hover.value = placed(pointer);
    },
    cancel() {
        if (drags) sketch.value = [];
        held = null;
        drags = false;
    },
    up(pointer) {
        const [pressed, dragged] = [held, drags];
        held = null;
        drags = false;
        if (dragged) offer([sketch.value[0]!, placed(pointer)], pointer, true);
        else if (pressed) click(pressed);
    },
    key({ key }) {
        if (key === "Escape") begin("change");
        else if (key === "Enter") finish();
        else if (key === "Backspace") sketch.value = sketch.value.slice(0, -1);
        else return false;
        return true;
    },
    paint(context, view, inks) {
        const to = hover.value;
        if (!to) return;
        const { paint, words, points: [, most] } = drawings[mode.value]!;
        const points = sketch.value.length < most ? [...sketch.value, to] : sketch.value;
        paint(context, points, view, inks, drags);
        const [from, [x, y]] = [points.at(-2), points.at(-1)!];
        const { unit } = plan.value;
        const said = words?.(points, drags) ?? (from ? length(distance(from, [x, y]), unit) : `${length(x, unit)}, ${length(y, unit)}`);
        label(context, said, from ? [(from[0] + x) / 2, (from[1] + y) / 2] : [x, y - (18 * devicePixelRatio) / view.scale], view, inks);
        inMetres(context, view);
    },
};

/** The sides of a rectangle between its first and its last corner. */
export function sides(points: Point[]): string | undefined {
    const [from, to] = [points[0]!, points.at(-1)!];
    return points.length > 1 ? [0, 1].map((axis) => length(Math.abs(to[axis]! - from[axis]!), plan.value.unit)).join(" × ") : undefined;
}

/** What can be dragged of something, by its parts. */
interface Handles<S, P> extends Tool {
    /** What stands; null: nothing that is dragged. */
    now(): S | null;
    /** What stands instead while it is dragged. */
    dragged: Signal<S | null>;
    /** The part under the pointer, which is marked, and of what, if that is another one now. */
    grab(now: S, pointer: Pointer): { part: P; from?: S } | null;
    /** It after a drag of a part. */
    drag(part: P, pointer: Pointer, from: S): S;
    put(next: S): void;
    /** What is marked goes; whether it does. */
    remove?(whole: boolean): boolean;
    /** What is marked is moved by keys; whether it is. */
    step?(by: Point): boolean;
}

const STEPS: Record<string, Point> = { ArrowLeft: [-0.05, 0], ArrowRight: [0.05, 0], ArrowUp: [0, 0.05], ArrowDown: [0, -0.05] };

export function handles<S, P>({ now, dragged, grab, drag, put, remove, step, ...more }: Handles<S, P>): Tool {
    let pressed: { part: P; from: S } | null = null;
    const cancel = () => void (pressed = dragged.value = null);
    begun.subscribe(cancel);
    return {
        down(pointer) {
            const stands = now();
            const found = stands && grab(stands, pointer);
            pressed = found && { from: stands, ...found };
            dragged.value = pressed && pressed.from;
            return pressed !== null;
        },
        move(pointer, presses) {
            if (presses && pressed) dragged.value = drag(pressed.part, pointer, pressed.from);
        },
        cancel,
        up() {
            const next = dragged.value;
            cancel();
            // A press that moved nothing is no change.
            if (next && JSON.stringify(next) !== JSON.stringify(now())) put(next);
        },
        key(event) {
            const by = event.shiftKey && STEPS[event.key];
            if (by) return step?.(by) ?? false;
            return (event.key === "Delete" || event.key === "Backspace") && (remove?.(event.shiftKey) ?? false);
        },
        ...more,
    };
}
