// What the page and the worker tell each other. Lengths in m, masses in kg, angles in rad, times in s.

import type { BalanceName, PersonRequest, Request, Rotational, WalkingModelName } from "./generated";

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

/** A line or a polygon, one of the two, where people leave or stay. */
export interface Place {
    name: string;
    line: [Point, Point] | null;
    polygon: Point[] | null;
    /** So many of the people take it, relative to the other exits; for all exits or for none. */
    share: number | null;
    /** Of exits: when people can leave by it; null: always. */
    open: OpenTime[] | null;
}

/** What the page's forms have of a decision.toml. */
export interface Wishes {
    model: WalkingModelName;
    /** Only with this model; null for its defaults. */
    rotational: Rotational | null;
    balance: BalanceName;
    /** In N: greatest force with which people push ahead; null for no limit. */
    push: number | null;
    /** Part of the people who are in groups that stay together; null for nobody. */
    groups: { share: number } | null;
    /** In s: each starts to walk at a time between both, all as likely; null for at once. */
    start: { min: number; max: number } | null;
    desired_speed: number;
    /** Chooses who takes which exit by shares, who is in a group, who starts when, and what people do who are stuck. */
    seed: number;
    exits: Place[];
    goals: Place[];
    /** By Id, for those who do not go where the others go: the name of one of both. */
    agents: Record<string, { exit: string | null; goal: string | null }>;
}

/** Numbers of an agent in a frame: x, y, theta, vx, vy, omega, mean squeeze of the step, contacts, the part of the
 * squeeze by walls, x and y of the middle of the feet, 1 for who wants to get on and else 0. Of who has left, x and y are
 * not numbers, nor are feet without legs. */
export const COLUMNS = 12;
/** Place of the feet among them. */
export const FEET = 9;
/** Place of whether somebody wants to get on. */
export const GOES = 11;

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
    | { id: number; refused: string }
    | { id: number; progress: Progress }
    | { broken: string };
