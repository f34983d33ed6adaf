// What the page and the worker tell each other. Lengths in m, masses in kg, angles in rad, times in s.

import type { Door, OpenTime, Point, Room, RoomEdit } from "./roomtypes";

export type * from "./roomtypes";

export interface PersonWanted {
    sex: "male" | "female";
    breadth: number | null;
    depth: number | null;
    stature: number | null;
    mass: number | null;
    /** Where `Person.sections` are, in m above the ground; null: nowhere. */
    altitude: number | null;
}

/** Whether somebody is as tall as children only are: nobody in the survey is. */
export function isChild({ stature }: Pick<PersonWanted, "stature">): boolean {
    return stature !== null && stature < 1.35;
}

/** A normal distribution: mean, standard deviation, smallest, largest value. */
export type Normal = [number, number, number, number];
export type Four = Record<"breadth" | "depth" | "stature" | "mass", Normal>;

export type People =
    | { kind: "survey" }
    | { kind: "statistics"; male: Four; female: Four }
    /** Tables of the survey ANSUR II. The bytes of the request are their contents. */
    | { kind: "table"; files: ["male" | "female", string, number][] };

export interface CrowdWanted {
    /** Either this or the density. */
    number: number | null;
    /** People per m² of the region. */
    density: number | null;
    seed: number;
    room: Room;
    /** Where people are placed; null: in the whole room. */
    region: Point[] | null;
    people: People;
    /** Shares of kinds of people, by their names; empty: adults with nothing. */
    mix: Record<string, number>;
    /** Share of men among the people. */
    men: number;
    /** In degrees; null: each another one. */
    direction: number | null;
    speed: number;
    material: Material;
    /** Instead of the material's: kinetic friction of people with each other and with walls. */
    friction: number | null;
    /** Each body is one disk, of the same area. */
    round: boolean;
}

export type Material = "human_naked" | "human_clothes" | "human_soft";

export type Base =
    | { kind: "example"; name: "push" }
    | ({ kind: "crowd" } & CrowdWanted)
    /** A zip, or the files of a folder. The bytes of the request are their contents. */
    | { kind: "upload"; name: string; files: [string, number][] };

export type Edit =
    | { do: "move"; id: string; x: number; y: number; theta: number }
    | { do: "copy"; id: string; as: string; x: number; y: number; theta: number }
    /** Somebody more, with measures. */
    | { do: "put"; id: string; person: PersonWanted; x: number; y: number; theta: number }
    | { do: "delete"; id: string }
    /** Other walls in place of a Trial's. */
    | { do: "room"; room: Room };

/** A half-sine pulse on all whose centres lie in a circle. */
export interface Push {
    at: Point;
    radius: number;
    /** In degrees. */
    direction: number;
    /** Greatest force on each of them, in N. */
    force: number;
    start: number;
    duration: number;
}

export interface Waypoint {
    x: number;
    y: number;
    radius: number;
}

/** How people walk among others. */
export const MODELS = ["straight", "collision-free-speed", "social-force", "rotational"] as const;
export type Model = (typeof MODELS)[number];

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

/** Constants of the rotational model. */
export interface Rotational {
    /** In s. */
    time_gap: number;
    /** In m. */
    standstill_gap: number;
    reaction_time: number;
    /** In m/s. */
    speed_noise: number;
    /** In m/s². */
    acceleration: number;
}

/** How people who stand keep their balance. */
export const BALANCES = ["none", "pendulum", "two-level"] as const;
export type Balance = (typeof BALANCES)[number];

/** As decision.toml says it. */
export interface Wishes {
    model: Model;
    /** Only with this model; null for its defaults. */
    rotational: Rotational | null;
    balance: Balance;
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

export type Motion =
    /** As the Trial says. */
    | { kind: "own" }
    | { kind: "none" }
    | { kind: "push"; pushes: Push[]; balance: Balance }
    /** Everybody takes the way whose first point is nearest; or each way gets a share of the people, chosen by the seed. */
    | { kind: "walk"; speed: number; ways: Waypoint[][]; shares: number[] | null; seed: number }
    /** They go around walls to exits, where they leave, and to goals, where they stay. */
    | { kind: "go"; wishes: Wishes };

/** A material: both moduli in N/m. */
export interface Material2d {
    id: string;
    young_modulus: number;
    shear_modulus: number;
}

/** What two materials do where they touch: dampings in kg/s. */
export interface Contact {
    id1: string;
    id2: string;
    gamma_normal: number;
    gamma_tangential: number;
    kinetic_friction: number;
}

/** Changed materials and steps. What is null or not there is as the scene has it. */
export interface Mechanics {
    /** In s. */
    time_step: number | null;
    time_step_mechanical: number | null;
    materials: Material2d[];
    contacts: (Omit<Contact, "kinetic_friction"> & { kinetic_friction: number | null })[];
}

export interface Shown {
    base: Base;
    edits: Edit[];
    /** Whether changes by hand that do not fit are left out. */
    fitting?: boolean;
    mechanics?: Mechanics;
    motion: Motion;
}

export type Wanted =
    | { file: "trial" }
    | { file: "fmu"; version: 2 | 3; binaries: [string, number][] }
    /** With a frame, then a number for each agent as float64: what its colour shows (as on the stage). `range` is that of the colours. */
    | { file: "svg"; range: [number, number]; beyond: boolean; from_grey: boolean; label: string; unit: string; time: number; forces: boolean; by_kind: boolean }
    | { file: "population" }
    /** With a frame. */
    | { file: "mesh"; format: "obj" | "stl" }
    /** The table of `lemons run`, computed again from the start. */
    | { file: "trajectories"; steps: number };

export type Request =
    | ({ ask: "person" } & PersonWanted)
    /** The surface of a person's body: vertices and triangles. */
    | ({ ask: "body" } & PersonWanted)
    | { ask: "bicycle" }
    /** All kinds of people: `KindShown[]`. */
    | { ask: "kinds" }
    | ({ ask: "show" } & Shown)
    /** A room after an edit, and its wall near to a place. */
    | { ask: "room"; room: Room; edit: RoomEdit | null; near: Point | null }
    /** The room in a Geometry.xml or a drawing, which is the bytes. */
    | ({ ask: "drawing" } & DrawingWanted)
    | { ask: "overlaps"; run: number; agent: number; x: number; y: number; theta: number }
    | { ask: "advance"; run: number; steps: number }
    /** With a frame. The answer's bytes: x1, y1, x2, y2, force for each two that touch. */
    | { ask: "forces"; run: number; time: number }
    /** With frames. */
    | { ask: "flow"; run: number; line: [Point, Point] }
    /** With x, y and squeeze of everybody in frames: they are added to the run's map, or to a new one. */
    | { ask: "map"; run: number; of: "density" | "squeeze"; fresh: boolean }
    /** With squeezes in N of everybody in frames: not a number for who has left. */
    | ({ ask: "limit" } & LimitWanted)
    | { ask: "sections"; run: number; altitude: number }
    | { ask: "bodies"; run: number }
    | { ask: "take"; run: number; wanted: Wanted };

/** Frames more about a limit of the squeeze. */
export interface LimitWanted {
    /** From 0 to 3: of what is asked about. */
    number: number;
    people: number;
    /** In s: of a communication step. */
    step: number;
    /** In N. */
    limit: number;
    /** In s: of means that are compared with it. */
    over: number;
    /** The first frame; 0 begins anew. */
    from: number;
}

/** How long people were above a limit; null: the run is shorter than the means, or a step is longer. Times in s. */
export interface Limit {
    above: {
        people: number;
        /** Null: never. */
        first: number | null;
        who: number;
        /** Without a break. */
        longest: number;
        /** Of all of them. */
        time: number;
    } | null;
}

/** How a drawing is understood. */
export interface DrawingWanted {
    /** Of the file: it says the format. */
    name: string;
    /** In m; null: as the file says. */
    unit: number | null;
    /** In m: ends of lines that are so near are joined. */
    close: number | null;
    origin: boolean;
    /** Layers; none: all. */
    walls: string[];
    /** The room is what walls enclose; layers of obstacles, and in m the widest gap that is closed. */
    enclosing: { obstacles: string[]; widest: number } | null;
    /** Further doors. */
    doors: Door[];
}

/** What a drawing seems to be. */
export interface Proposal {
    layers: { name: string; sort: string; lines: number }[];
    walls: string[];
    obstacles: string[];
    /** In m. */
    widest: number;
    /** In m; null: there are no small gaps. */
    close: number | null;
    /** In m²: within walls, and without obstacles. */
    areas: [number, number];
    /** Its rim, then holes; none: nothing is enclosed. */
    ground: Point[][];
    gaps: { kind: string; door: Door; outside: boolean; said: string }[];
    questions: string[];
}

/** What is in a drawing. */
export interface Understood {
    /** Null: no wall is closed, but there are proposals. */
    room: Room | null;
    exits: { name: string; corners: Point[] }[];
    /** Where people stand. */
    distributions: Point[][];
    waypoints: number;
    /** In m². */
    area: number | null;
    /** As `lemons room` says it: what, and how. */
    said: [string, string][];
    /** Those of which some can be chosen as walls. */
    layers: string[];
    /** Why its outline may not be the room. */
    doubt: string | null;
    proposal: Proposal | null;
}

export interface Measure {
    name: string;
    unit: string;
    value: number;
    possible: [number, number];
    /** Fraction of the surveyed people below the value. */
    rank: number;
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
    /** Polygons of the body at the altitude that was asked for, in its frame; null if none was. */
    sections: Point[][] | null;
}

/** The surface of a body. The bytes: coordinates as float32 (x, y, z of each vertex), then corners as uint32. */
export interface Surface {
    vertices: number;
    triangles: number;
}

export interface Bicycle {
    rectangles: Point[][];
    measures: { name: string; unit: string; value: number }[];
}

/** What things are made of: of each disk, null where it is of a body. */
export type Thing = "frame" | "luggage" | null;

/** A kind of people, with somebody of it as an example. */
export interface KindShown {
    kind: string;
    disks: Disk[];
    things: Thing[];
    /** The disks of who sits in a wheelchair: they are drawn, and nothing of the mechanics. */
    seated: Disk[] | null;
    /** Where the numbers of the kind are from. */
    sources: string[];
}

export interface Agent {
    id: string;
    /** Of all, with what goes along. */
    mass: number;
    disks: Disk[];
    /** What it is of, if its Trial says so. */
    kind: string | null;
    /** Desired speed, if somebody says it, in m/s. */
    speed: number | null;
    /** As those of `KindShown`; null if nothing goes along. */
    things: Thing[] | null;
    seated: Disk[] | null;
}

export interface Scene {
    /** The number of its run. */
    run: number;
    name: string;
    agents: Agent[];
    /** What goes along with people of each kind. */
    kinds: Record<string, string[]>;
    walls: { id: string; corners: Point[]; open?: OpenTime[] }[];
    step: number;
    mechanical_step: number;
    /** The longest stable mechanical step; null if nothing can touch. */
    stable: number | null;
    /** The longest mechanical step without a warning, and the one that a crowd gets. */
    longest: number | null;
    advised: number | null;
    /** About how large errors of positions are with the mechanical step. */
    error: number | null;
    /** Of changed materials and steps. */
    warnings: string[];
    materials: Material2d[];
    contacts: Contact[];
    /** Agents that overlap others or walls at the start, by more than 0.1 mm. */
    overlapping: number[];
    /** The deepest overlap at the start. */
    overlap: number;
    /** Ids of those who get a force of their own over time. */
    pushed: string[];
    /** Whether people walk, on ways or to exits and goals. */
    walk: boolean;
    /** Where people walk to. */
    ways: Waypoint[][];
    /** Exits, then goals (`stay`): lines have two corners. */
    targets: { name: string; stay: boolean; corners: Point[]; open?: OpenTime[] }[];
    /** How many have an exit. */
    leaving: number;
    /** A line 1 m beyond each door of a crowd's room. */
    beyond_doors: [Point, Point][];
    /** How the people of a crowd were drawn; null if only their disks are known. */
    people: { sex: string; breadth: number; depth: number; stature: number; mass: number }[] | null;
}

/** Statistics of one measure of all people of a kind. */
export interface Summary {
    measure: string;
    unit: string;
    mean: number;
    sd: number | null;
    min: number;
    max: number;
}

/** How a crowd was placed. */
export interface Made {
    density: number;
    area: number;
    iterations: number;
    largest_overlap: number;
    statistics: { kind: string; count: number; measures: Summary[] }[];
}

export interface Opened {
    scene: Scene;
    notes: string[];
    made: Made | null;
    /** Changes by hand that do not fit: their places, and why. */
    left_out: [number, string][];
}

export interface Overlaps {
    agents: number[];
    wall: boolean;
    depth: number;
}

export interface Flow {
    /** Place of the later frame, agent, 1 from left to right of the line or -1. */
    crossings: [number, number, 1 | -1][];
}

/** Cells of a map. The bytes: density of each as float64, or mean squeeze, then greatest, then the number of values; row by
 * row from the lowest. */
export interface Grid {
    /** The middle of the lowest cell on the left. */
    low: Point;
    cell: Point;
    columns: number;
    rows: number;
}

export interface Sections {
    altitude: number;
    /** Polygons of each agent, in its frame; none where the plane is above it. */
    bodies: Point[][][];
    /** How many bodies the plane cuts, and the area of their sections. */
    cut: number;
    area: number;
    /** Sex and measures are not known: bodies are those that fit the disks, height and mass. */
    estimated: boolean;
}

/** Numbers of vertices and triangles of each. The bytes: for each, coordinates as float32, then corners as uint32. */
export interface Bodies {
    agents: [number, number][];
    /** The same of what goes along, after all agents. */
    things: [number, number][];
    /** How many have none, because none fits the disks. */
    without: number;
    estimated: boolean;
}

/** Numbers of each step. */
export interface Advanced {
    /** Deepest overlap so far. */
    overlaps: number[];
    /** How many of those who walk have arrived or left. */
    arrived: number[];
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
