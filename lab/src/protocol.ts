// What the page and the worker tell each other. Lengths in m, masses in kg, angles in rad, times in s.

import type { Message, PersonRequest, Request } from "./generated";

export type { DecisionConfig, Place } from "./forms";
export type * from "./generated";

export type Point = [number, number];
/** x, y, radius, in the body's frame. */
export type Disk = [number, number, number];
/** From and to which time in s something is open. */
export type OpenTime = [number, number];
/** A normal distribution: mean, standard deviation, smallest, largest value. */
export type Normal = [number, number, number, number];

/** Whether somebody is as tall as children only are: nobody in the survey is. */
export function isChild({ stature }: Pick<PersonRequest, "stature">): boolean {
    return stature !== null && stature < 1.35;
}

export type Material = "human_naked" | "human_clothes" | "human_soft";

/** Numbers of an agent in a frame: x, y, theta, vx, vy, omega, mean squeeze of the step, contacts, the part of the
 * squeeze by walls, x and y of the middle of the feet, 1 for who wants to get on and else 0. Of who has left, x and y are
 * not numbers, nor are feet without legs. */
export const COLUMNS = 12;
/** Place of the feet among them. */
export const FEET = 9;
/** Place of whether somebody wants to get on. */
export const GOES = 11;

/** Where there are chests or levels (`Scene.further`), further numbers follow: of the chest its load, the part by walls, what
 * presses it together front–back, side–side and from all sides; then the squeeze of each level, from the lowest. */
export const CHEST = COLUMNS;
export const LEVELS = CHEST + 5;

/** Whether an agent of a frame has not left. */
export function isThere(frame: Float32Array, agent: number): boolean {
    return !Number.isNaN(frame[COLUMNS * agent]!);
}

export interface Progress {
    /** 0 growing, 1 spreading, 2 shaking, 3 pressing, 4 thinning; 5: a run is computed again. */
    stage: number;
    iteration: number;
    limit: number;
    overlap: number;
    density: number;
}

/** To the worker. */
export interface Asked {
    id: number;
    request: Request;
    bytes?: Uint8Array;
}

/** From the worker. */
export type Told =
    | { id: number; value: unknown; bytes: ArrayBuffer; seconds: number }
    | { id: number; refused: Message }
    | { id: number; progress: Progress }
    /** The share of the lab that has come; then the lab, for the page. */
    | { loading: number }
    | { module: WebAssembly.Module }
    | { broken: string };
