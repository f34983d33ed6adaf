// What the user may have made has these forms, also when it comes from a link or the browser's storage.

import { type Check, dictionary, fits, flag, list, nullable, number, one, optional, record, tagged, text, tuple, within } from "./check";
import type { BalanceName, Base, Door, Edit, Four, Further, Material, Material2d, Mechanics, Motion, Normal, OpenTime, People, PersonRequest, Place, Point, Push, Room, Rotational, Scenario, Sex, WalkingModelName, Waypoint, Wishes } from "./protocol";
import { rectangle } from "./roomshape";

/** Files of the user's are kept in the browser under this key (store.ts). They are never sent. */
interface Kept {
    key: string;
}

type Upload = Extract<Base, { kind: "upload" }>;
/** Of tables sex, name and length. */
export type KeptPeople = Extract<People, { kind: "survey" | "statistics" }> | ({ kind: "table"; files: [Sex, string, number][] } & Kept);
/** Of a scenario what the forms have; `session.ts` makes one of it. */
type Keys = Pick<Scenario, "number" | "density" | "direction" | "friction" | "round">;
export type KeptCrowd = Keys & { seed: number; room: Room; region: Point[] | null; people: KeptPeople; mix: Record<string, number>; men: number; speed: number; material: Material };
export type KeptBase = Extract<Base, { kind: "example" }> | ({ kind: "crowd" } & KeptCrowd) | (Upload & Kept);

/** Most corners of an area and of a wall, most walls, most parts of another kind, most letters of a name, of a path and of a list of values,
 * and most seeds of a sweep. */
export const MOST = { corners: 200, outline: 2000, walls: 500, all: 5000, parts: 50, places: 50, ways: 20, points: 50, times: 20, edits: 1000, name: 200, path: 400, list: 10_000, seeds: 100, files: 1000, kinds: 50 };

export const point: Check<Point> = tuple<Point>(number, number);
const corners = list(point, MOST.corners, 3);
const openTimes = list(tuple<OpenTime>(number, number), MOST.times, 1);
const outline = list(point, MOST.outline, 3);
const further = list(record<Further>({ corners: list(point, MOST.outline, 2), of: nullable(text(MOST.name)) }), MOST.walls);
const parts = {
    obstacles: list(outline, MOST.walls),
    walls: optional(further),
    doors: list(record<Door>({ at: point, width: number, open: optional(openTimes) }), MOST.parts),
};
const room = record<Room>({ outline, ...parts });
/** In place of a Trial's walls. */
const ofTrial = record<Room>({ outline: list(point, 0), ...parts });
/** Whether it is still a room after a reload: what is larger would be lost then. */
export const roomFits = (given: Room) => fits(given.outline.length > 0 ? room : ofTrial, given);

const normal: Check<Normal> = tuple<Normal>(number, number, number, number);
const four = record<Four>({ breadth: normal, depth: normal, stature: normal, mass: normal });
const people = tagged<"kind", KeptPeople>("kind", {
    survey: record({}),
    statistics: record({ male: four, female: four }),
    table: record({ files: list(tuple<[Sex, string, number]>(one("male", "female"), text(MOST.name), number), 2, 1), key: text() }),
});
const inCrowd = record<KeptCrowd>({
    number: nullable(number),
    density: nullable(number),
    seed: number,
    room,
    region: nullable(corners),
    people,
    mix: dictionary(within(0, 1e6), MOST.kinds),
    men: number,
    direction: nullable(number),
    speed: number,
    material: one("human_naked", "human_clothes", "human_soft"),
    friction: nullable(number),
    round: flag,
});
/** Kinetic friction of people, where it is not changed: as crates/people has it. */
export function frictionOf({ friction, material }: Pick<KeptCrowd, "friction" | "material">): number {
    return friction ?? (material === "human_clothes" ? 0.5 : 0.4);
}
/** The forms of a crowd at first. */
export const FIRST_CROWD: KeptCrowd = {
    number: 40,
    density: null,
    seed: 1,
    room: { outline: rectangle(4, 4), obstacles: [], doors: [] },
    region: null,
    people: { kind: "survey" },
    mix: {},
    men: 0.5,
    direction: 0,
    speed: 1,
    material: "human_naked",
    friction: null,
    round: false,
};

/** Former pages kept whether people wear clothes, no material, no friction, no round bodies, and no kinds. */
export const crowd: Check<KeptCrowd> = (given) => {
    const kept = given as { clothes?: unknown };
    return inCrowd({ material: kept?.clothes === true ? "human_clothes" : "human_naked", friction: null, round: false, mix: {}, ...kept });
};
/** As `roomFits`, of a crowd. */
export const crowdFits = (given: KeptCrowd) => fits(crowd, given);
export const base = tagged<"kind", KeptBase>("kind", {
    example: record({ name: one("push") }),
    crowd,
    upload: record({ name: text(MOST.name), files: list(tuple<[string, number]>(text(MOST.path), number), MOST.files, 1), key: text() }),
});
/** A picture under the room. */
export interface Backdrop {
    name: string;
    key: string;
    /** Its lower left corner, and its width, in m. */
    at: Point;
    width: number;
    /** Its height over its width. */
    aspect: number;
    /** 1: all of it is seen. */
    opacity: number;
}
export const backdrop = nullable(record<Backdrop>({ name: text(MOST.name), key: text(), at: point, width: within(1e-3, 1e6), aspect: within(1e-4, 1e4), opacity: within(0, 1) }));
export const person = record<PersonRequest>({
    sex: one("male", "female"),
    breadth: nullable(number),
    depth: nullable(number),
    stature: nullable(number),
    mass: nullable(number),
    altitude: nullable(within(0, 3)),
});
export const edit = tagged<"do", Edit>("do", {
    move: record({ id: text(), x: number, y: number, theta: number }),
    copy: record({ id: text(), as: text(), x: number, y: number, theta: number }),
    put: record({ id: text(), person, x: number, y: number, theta: number }),
    delete: record({ id: text() }),
    room: record({ room: ofTrial }),
});
const id = text(MOST.name);
const changed = record<Mechanics>({
    time_step: nullable(number),
    time_step_mechanical: nullable(number),
    materials: list(record<Material2d>({ id, young_modulus: number, shear_modulus: number }), MOST.edits),
    contacts: list(record<Mechanics["contacts"][number]>({ id1: id, id2: id, gamma_normal: number, gamma_tangential: number, kinetic_friction: nullable(number) }), MOST.edits),
});
/** Whether changed numbers of it are still there after a reload. */
export const canChange = (id: string) => id.length <= MOST.name;
/** Most scenes change none of it. */
export const mechanics = optional(changed);
/** Without frictions of single pairs with people, who are of a material: the crowd has one for all of them. */
export function ofAllPairs(changed: Mechanics | undefined, people: string): Mechanics | undefined {
    const contact = (of: Mechanics["contacts"][number]) => (of.id1 === people || of.id2 === people ? { ...of, kinetic_friction: null } : of);
    return changed && { ...changed, contacts: changed.contacts.map(contact) };
}
/** A circle of a negative radius cannot even be drawn. */
const radius = within(0, 1e6);
const push = record<Push>({ at: point, radius, direction: number, force: number, start: number, duration: number });
const way = list(record<Waypoint>({ x: number, y: number, radius }), MOST.points, 1);
const place = record<Place>({
    name: text(MOST.name),
    line: nullable(tuple<[Point, Point]>(point, point)),
    polygon: nullable(corners),
    share: nullable(number),
    open: nullable(openTimes),
});
const name = nullable(text(MOST.name));
const rotational = nullable(record<Rotational>({ time_gap: number, standstill_gap: number, reaction_time: (given) => number(given ?? 0), speed_noise: number, acceleration: number }));
const balance: Check<BalanceName> = (given) => one<BalanceName>("none", "pendulum", "two-level")(given ?? "none");
const wishes = record<Wishes>({
    model: one<WalkingModelName>("straight", "collision-free-speed", "social-force", "rotational"),
    rotational,
    balance,
    push: nullable(number),
    groups: nullable(record<NonNullable<Wishes["groups"]>>({ share: within(0, 1) })),
    start: nullable(record<NonNullable<Wishes["start"]>>({ min: within(0, 1e5), max: within(0, 1e5) })),
    desired_speed: number,
    seed: number,
    exits: list(place, MOST.places),
    goals: list(place, MOST.places),
    agents: dictionary(record({ exit: name, goal: name }), MOST.edits),
});
export const motion = tagged<"kind", Motion>("kind", {
    own: record({}),
    none: record({}),
    push: record({ pushes: list(push, MOST.parts), balance }),
    walk: record({
        speed: number,
        ways: list(way, MOST.ways),
        shares: nullable(list(number, MOST.ways)),
        seed: (given) => number(given ?? 1),
    }),
    go: record({ wishes }),
});
