// What moves the people, as the forms and the tools on the picture have it: they change one and the same.

import { computed, effect, signal } from "@preact/signals";
import { plan } from "./plan";
import type { Motion } from "./protocol";
import { bases, choose } from "./session";
import { begin } from "./tool";

/** The push, the way, or the place that is marked: of places the number among exits, then goals. */
export const picked = signal<number | null>(null);

/** What stands while it is dragged. */
export const dragged = signal<Motion | null>(null);

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

// What is drawn belongs to a place: in another one it would lie anywhere.
effect(() => {
    bases.value;
    pending.value = null;
    picked.value = null;
    begin("change");
});
