// What parts of the stage share.

import { type ReadonlySignal, signal } from "@preact/signals";
import type { Film } from "./film";
import type { View } from "./view";

/** The picture that is shown, if there is one. */
export const canvas = signal<HTMLCanvasElement | null>(null);

/** Returns what ends it. What was shown before may end only after this began. */
export function show(on: HTMLCanvasElement): () => void {
    canvas.value = on;
    return () => {
        if (canvas.value === on) canvas.value = null;
    };
}

/** Changes some times in a second while a run plays: what is read need not change with each picture. */
export const beat = signal(0);

/** A number of a run at the last beat, or as it is where the run does not play. */
export function calmly({ playing }: Film, of: ReadonlySignal<number>): number {
    return playing.value ? (beat.value, of.peek()) : of.value;
}

/** Whether the stage is shown alone, to an audience. */
export const presents = signal(false);

/** Fills the screen, where the browser allows it. */
export function present(on: boolean) {
    presents.value = on;
    if (on) document.documentElement.requestFullscreen?.().catch(() => {});
    else if (document.fullscreenElement) void document.exitFullscreen();
}

/** The person under the mouse. */
export const hovered = signal<number | null>(null);

/** Whether people are left out of the picture: that of a map is of another time than they are. */
export const empty = signal(false);

/** What is drawn besides people and walls. */
export interface Layers {
    below(context: CanvasRenderingContext2D, view: View): void;
    above(context: CanvasRenderingContext2D, view: View): void;
    /** Instead of disks. */
    paths(): Path2D[] | null;
}
