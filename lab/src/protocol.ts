// What the page and the worker tell each other. Lengths in m, masses in kg, angles in rad, times in s.

export interface PersonWanted {
    sex: "male" | "female";
    breadth: number | null;
    depth: number | null;
    stature: number | null;
    mass: number | null;
}

export interface CrowdWanted {
    number: number;
    seed: number;
    room: [number, number];
    men: number;
    /** In degrees. */
    direction: number | null;
    speed: number;
}

export type Request =
    | ({ ask: "person" } & PersonWanted)
    | ({ ask: "crowd" } & CrowdWanted)
    | { ask: "example"; name: string }
    | { ask: "open"; name: string }
    | { ask: "advance"; run: number; steps: number }
    | { ask: "take"; run: number; wanted: { file: "trial" } | { file: "fmu"; version: 2 | 3; binaries: [string, number][] } };

export interface Measure {
    name: string;
    unit: string;
    value: number;
    possible: [number, number];
    /** Fraction of the surveyed people below the value. */
    rank: number;
    median: number;
    quantiles: number[];
}

/** x, y, radius, in the body's frame. */
export type Disk = [number, number, number];

export interface Person {
    sex: string;
    measures: Measure[];
    disks: Disk[];
    area: number;
    inertia: number;
    surveyed: number;
}

export interface Scene {
    /** The number of its run. */
    run: number;
    name: string;
    agents: { id: string; mass: number; disks: Disk[] }[];
    walls: { id: string; corners: [number, number][] }[];
    step: number;
    mechanical_step: number;
    /** The longest stable mechanical step; null if nothing can touch. */
    stable: number | null;
    /** About how large errors of positions are with the mechanical step. */
    error: number | null;
}

export interface Advanced {
    time: number;
    overlap: number;
    mechanical_steps: number;
    pairs: number;
    contacts: number;
}

/** Numbers of an agent in a frame: x, y, orientation, speed, squeeze, contacts. */
export const COLUMNS = 6;

export interface Progress {
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
