// How a tab takes part in the picture: it hears the pointer and paints over it. All places are in m.

import { batch, computed, signal } from "@preact/signals";
import { useEffect, useLayoutEffect } from "preact/hooks";
import type { Inks } from "./draw";
import type { Point } from "./protocol";
import type { View } from "./view";

export interface Pointer {
    at: Point;
    /** How near is near, in m: about a finger's breadth on the screen. */
    reach: number;
    shift: boolean;
    /** The person under it. */
    agent: number | null;
    /** The second press of a double click. */
    double: boolean;
}

export interface Tool {
    /** Whether it takes the pointer; if not, the ground is moved or a person selected. */
    down?(pointer: Pointer): boolean;
    /** Also while nothing is pressed. */
    move?(pointer: Pointer, pressed: boolean): void;
    up?(pointer: Pointer): void;
    /** Instead of `up`: the press was none after all. What it began is as before. */
    cancel?(): void;
    /** Whether it takes the key. */
    key?(event: KeyboardEvent): boolean;
    /** What it reads of signals is painted again when they change. */
    paint?(context: CanvasRenderingContext2D, view: View, inks: Inks): void;
    /** What should be visible with it. */
    extent?(): Point[];
    /** Poses that are shown instead, while somebody is dragged. */
    frame?(frame: Float32Array): Float32Array;
    /** Who is marked as overlapping instead of those who overlap at the start. */
    overlapping?(): readonly number[] | null;
    /** People are faint, because something else is looked at. */
    faint?(): boolean;
    /** All is seen as before while it drags. */
    keeps?: boolean;
    /** Whether the next press draws: the pointer is a cross. */
    draws?(): boolean;
}

/** The tool of the present tab. */
export const tool = signal<Tool | null>(null);
/** It is the tool while the component is there. What a former tab leaves may be tidied up only after this tab began. */
export function useTool(own: Tool, modes: readonly Mode[] = []) {
    // Not `useEffect`: it waits for the next frame, and a key pressed before that would be lost.
    useLayoutEffect(() => {
        tool.value = own;
        return () => {
            if (tool.value === own) tool.value = null;
        };
    }, [own]);
    useEffect(() => () => endOf(modes), []);
}

/** What the tools of the tabs Room and Motion draw. */
export const ROOM = ["outline", "rectangle", "polygon", "wall", "door", "region"] as const;
export const MOTION = ["push", "way", "exit line", "exit area", "goal line", "goal area"] as const;
/** What the next presses draw, in any tab: two tools cannot draw at once. "change": nothing. */
export type Mode = "change" | (typeof ROOM)[number] | (typeof MOTION)[number] | "measure" | "scale" | "move";
export const mode = signal<Mode>("change");
/** Counts the beginnings: what was dragged is over then. */
export const begun = signal(0);
/** Points of what is being drawn, and where the pointer is, snapped. */
export const sketch = signal<Point[]>([]);
export const hover = signal<Point | null>(null);

export function begin(next: Mode) {
    batch(() => {
        mode.value = next;
        sketch.value = [];
        hover.value = null;
        begun.value = begun.peek() + 1;
    });
}

/** Ends what is drawn, if it is one of these. */
export function endOf(modes: readonly Mode[]) {
    if (modes.includes(mode.peek())) begin("change");
}

/** Begins, or ends what was begun. */
export const turn = (kind: Mode) => begin(mode.peek() === kind ? "change" : kind);

/** Tools that take precedence over that of the tab while their mode lasts. */
export const over: Partial<Record<Mode, Tool>> = {};
/** The one that hears the pointer now. */
export const active = computed(() => over[mode.value] ?? tool.value);
