// What the user may have made has these forms, also when it comes from a link or the browser's storage.

import { type Check, dictionary, firsts, fits, flag, forms, list, nullable, number, one, optional, record, type Row, row, tagged, text, tuple, within } from "./check";
import type { BalanceName, Base, Door, Edit, Four, Further, Material, Material2d, Mechanics, Motion, Normal, OpenTime, People, PersonRequest, Point, Push, Room, Rotational, Scenario, Sex, Waypoint } from "./protocol";
import { rectangle } from "./roomshape";
import { MODEL_NAMES } from "./walkingmodels";

/** Files of the user's are kept in the browser under this key (store.ts). They are never sent. */
interface Kept {
    key: string;
}

type Upload = Extract<Base, { kind: "upload" }>;
/** Of tables sex, name and length. */
export type KeptPeople = Extract<People, { kind: "survey" | "statistics" }> | ({ kind: "table"; files: [Sex, string, number][] } & Kept);
/** Of a scenario what the forms have; `session.ts` makes one of it. */
type Keys = Pick<Scenario, "number" | "density" | "direction" | "friction" | "round">;
export type KeptCrowd = Keys & { seed: number; room: Room; region: Point[] | null; people: KeptPeople; mix: Record<string, number>; men: number; speed: number; material: Material; levels: number | null };
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
const CROWD: { [K in keyof KeptCrowd]: Row<KeptCrowd[K]> } = {
    number: row(nullable(number), 40),
    density: row(nullable(number), null),
    seed: row(number, 1),
    room: row(room, { outline: rectangle(4, 4), obstacles: [], doors: [] }),
    region: row(nullable(corners), null),
    people: row(people, { kind: "survey" }),
    mix: row(dictionary(within(0, 1e6), MOST.kinds), {}),
    men: row(number, 0.5),
    direction: row(nullable(number), 0),
    speed: row(number, 1),
    material: row(one("human_naked", "human_clothes", "human_soft"), "human_naked"),
    friction: row(nullable(number), null),
    round: row(flag, false),
    levels: row(nullable(within(1, 10)), null),
};
const inCrowd = record<KeptCrowd>(forms(CROWD));
/** The forms of a crowd at first. */
export const FIRST_CROWD: KeptCrowd = firsts(CROWD);
/** Kinetic friction of people, where it is not changed: as crates/people has it. */
export function frictionOf({ friction, material }: Pick<KeptCrowd, "friction" | "material">): number {
    return friction ?? (material === "human_clothes" ? 0.5 : 0.4);
}
/** Former pages kept whether people wear clothes, no material, no friction, no round bodies, no levels, and no kinds. */
export const crowd: Check<KeptCrowd> = (given) => {
    const kept = given as { clothes?: unknown };
    return inCrowd({ material: kept?.clothes === true ? "human_clothes" : "human_naked", friction: null, round: false, levels: null, mix: {}, ...kept });
};
/** As `roomFits`, of a crowd. */
export const crowdFits = (given: KeptCrowd) => fits(crowd, given);
export const base = tagged<"kind", KeptBase>("kind", {
    example: record({ name: one("push") }),
    crowd,
    upload: record({ name: text(MOST.name), files: list(tuple<[string, number]>(text(MOST.path), number), MOST.files, 1), key: text() }),
});
/** A picture under the room: its lower left corner and its width in m, its height over its width, and how much of it is seen. */
const picture = record({ name: text(MOST.name), key: text(), at: point, width: within(1e-3, 1e6), aspect: within(1e-4, 1e4), opacity: within(0, 1) });
export type Backdrop = ReturnType<typeof picture>;
export const backdrop = nullable(picture);
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
/** A line or a polygon, one of the two, where people leave or stay. */
const place = record({
    name: text(MOST.name),
    line: nullable(tuple<[Point, Point]>(point, point)),
    polygon: nullable(corners),
    /** So many of the people take it, relative to the other exits; for all exits or for none. */
    share: nullable(number),
    /** Of exits: when people can leave by it; null: always. */
    open: nullable(openTimes),
});
export type Place = ReturnType<typeof place>;
const name = nullable(text(MOST.name));
const rotational = nullable(record<Rotational>({ time_gap: number, standstill_gap: number, reaction_time: (given) => number(given ?? 0), speed_noise: number, acceleration: number }));
const balance: Check<BalanceName> = (given) => one<BalanceName>("none", "pendulum", "two-level")(given ?? "none");
/** What the page's forms have of a decision.toml. */
const decision = record({
    model: one(...MODEL_NAMES),
    /** Only with this model; null for its defaults. */
    rotational,
    balance,
    /** In N: greatest force with which people push ahead; null for no limit. */
    push: nullable(number),
    /** With which force in N who waits leans on who is in front, and after how many s it is another one; null for nobody. */
    queue: (given) => nullable(record({ push: number, push_time: number }))(given ?? null),
    /** Part of the people who are in groups that stay together; null for nobody. */
    groups: nullable(record({ share: within(0, 1) })),
    /** In s: each starts to walk at a time between both, all as likely; null for at once. */
    start: nullable(record({ min: within(0, 1e5), max: within(0, 1e5) })),
    desired_speed: number,
    /** Chooses who takes which exit by shares, who is in a group, who starts when, and what people do who are stuck. */
    seed: number,
    exits: list(place, MOST.places),
    goals: list(place, MOST.places),
    /** By Id, for those who do not go where the others go: the name of one of both. */
    agents: dictionary(record({ exit: name, goal: name }), MOST.edits),
});
export type DecisionConfig = ReturnType<typeof decision>;
const toGo = record({ decision });
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
    // Former pages kept it as `wishes`.
    go: (given) => toGo({ decision: (given as { wishes?: unknown }).wishes, ...(given as object) }),
});
