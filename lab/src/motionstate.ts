// What moves the people, as the forms and the tools on the picture have it: they change one and the same.

import { computed, effect, signal } from "@preact/signals";
import { plan } from "./plan";
import type { Motion, Point } from "./protocol";
import { snapped } from "./roomshape";
import { bases, choose } from "./session";
import { lineTool, type Pointer } from "./tool";

/** What the next presses do. */
export type Mode = "change" | "push" | "way" | "exit line" | "exit area" | "goal line" | "goal area";
export const mode = signal<Mode>("change");
/** The push, the way, or the place that is marked: of places the number among exits, then goals. */
export const picked = signal<number | null>(null);

/** What stands while it is dragged. */
export const dragged = signal<Motion | null>(null);
/** Points of what is being drawn. */
export const sketch = signal<Point[]>([]);
/** Where the pointer is, snapped. */
export const hover = signal<Point | null>(null);

/** Something is wanted that people need to move by, but there is none yet: until then nobody moves. */
const pending = signal<Motion | null>(null);
export const standing = computed(() => (plan.value.made.motion.kind === "none" && pending.value) || plan.value.made.motion);
/** As the forms show it. */
export const motion = computed(() => dragged.value ?? standing.value);

function isEmpty(of: Motion) {
    if (of.kind === "push") return of.pushes.length === 0;
    if (of.kind === "walk") return of.ways.length === 0;
    return of.kind === "go" && of.decision.exits.length + of.decision.goals.length === 0;
}

export function setMotion(next: Motion) {
    const empty = isEmpty(next);
    pending.value = empty ? next : null;
    choose({ motion: empty ? { kind: "none" } : next }, false);
}

export function begin(next: Mode) {
    mode.value = next;
    if (next !== "change") lineTool.value = null;
    sketch.value = [];
    dragged.value = null;
    clicks.held = null;
}

/** A press that draws counts when it ends: a second finger may make it a pinch. */
export const clicks: { held: Pointer | null } = { held: null };

/** A click makes the next point; a double click ends it, and so does the last point there may be. */
export function addPoint({ at, double }: Pointer, most: number, finish: () => void) {
    if (!double) sketch.value = [...sketch.value, snapped(at)];
    if (double || sketch.value.length >= most) finish();
}

/** Keys while something is drawn point by point, or marked. */
export function toolKey(event: KeyboardEvent, finish: () => void, remove: (k: number) => void): boolean {
    const drawing = mode.value !== "change";
    if (event.key === "Escape" && drawing) begin("change");
    else if (event.key === "Enter" && drawing) finish();
    else if (event.key === "Backspace" && drawing) sketch.value = sketch.value.slice(0, -1);
    else if (event.key === "Delete" && picked.value !== null) remove(picked.value);
    else return false;
    return true;
}

// What is drawn belongs to a place: in another one it would lie anywhere.
effect(() => {
    bases.value;
    pending.value = null;
    picked.value = null;
    begin("change");
});
