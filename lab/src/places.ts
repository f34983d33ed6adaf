// Exits and goals: added, changed, removed. They are numbered together, exits before goals.

import type { DecisionConfig, Motion, Place, Point, Rotational } from "./protocol";

/** The model that `lemons crowd --leave` writes, and its speed. */
export const FIRST_DECISION: DecisionConfig = { model: "rotational", rotational: null, balance: "none", push: null, queue: null, groups: null, start: null, desired_speed: 1.34, seed: 1, exits: [], goals: [], agents: {} };

/** As crates/decision has them. */
export const ROTATIONAL: Rotational = { time_gap: 0.9, standstill_gap: 0.09, reaction_time: 0, speed_noise: 0.15, acceleration: 4 };

export type Kind = "exit" | "goal";

export const placesOf = ({ exits, goals }: DecisionConfig): Place[] => [...exits, ...goals];
export const kindOf = ({ exits }: DecisionConfig, k: number): Kind => (k < exits.length ? "exit" : "goal");
export const cornersOf = ({ line, polygon }: Place): Point[] => line ?? polygon ?? [];

export function shaped(place: Place, corners: Point[]): Place {
    const [from, to, ...more] = corners;
    const line: [Point, Point] | null = from && to && more.length === 0 ? [from, to] : null;
    return { ...place, line, polygon: line ? null : corners };
}

/** Moves exits to lines beyond doors: each to the one whose number it has, if there is one. */
export function beyond(motion: Motion, door: (exit: Place) => number | undefined, lines: [Point, Point][]): Motion {
    if (motion.kind !== "go") return motion;
    const exits = motion.decision.exits.map((exit) => {
        const line = lines[door(exit) ?? -1];
        return line ? { ...exit, line, polygon: null } : exit;
    });
    return { kind: "go", decision: { ...motion.decision, exits } };
}

/** Shares are for all exits or for none. */
export function hasShares({ exits }: DecisionConfig) {
    return exits.some(({ share }) => share !== null);
}

function free(decision: DecisionConfig, words: string): string {
    const names = placesOf(decision).map(({ name }) => name);
    let k = 1;
    while (names.includes(`${words} ${k}`)) k += 1;
    return `${words} ${k}`;
}

/** `words` and the next number are its name. */
export function added(decision: DecisionConfig, kind: Kind, corners: Point[], words: string = kind): DecisionConfig {
    const place = shaped({ name: free(decision, words), line: null, polygon: null, share: kind === "exit" && hasShares(decision) ? 1 : null, open: null }, corners);
    return kind === "exit" ? { ...decision, exits: [...decision.exits, place] } : { ...decision, goals: [...decision.goals, place] };
}

function split(decision: DecisionConfig, places: Place[], exits: number): DecisionConfig {
    return { ...decision, exits: places.slice(0, exits), goals: places.slice(exits) };
}

/** Those who go there follow its new name. */
export function changed(decision: DecisionConfig, k: number, place: Place): DecisionConfig {
    const places = placesOf(decision);
    const before = places[k]!.name;
    places[k] = place;
    const next = (name: string | null) => (name === before ? place.name : name);
    const agents = Object.entries(decision.agents).map(([id, { exit, goal }]) => [id, { exit: next(exit), goal: next(goal) }]);
    return { ...split(decision, places, decision.exits.length), agents: Object.fromEntries(agents) };
}

/** Those who went there go where the others go. */
export function removed(decision: DecisionConfig, k: number): DecisionConfig {
    const places = placesOf(decision);
    const [gone] = places.splice(k, 1);
    const agents = Object.entries(decision.agents).filter(([, { exit, goal }]) => exit !== gone!.name && goal !== gone!.name);
    return { ...split(decision, places, decision.exits.length - (k < decision.exits.length ? 1 : 0)), agents: Object.fromEntries(agents) };
}
