// What the user has made: kept in the browser, undone and redone, and sent as a link.

import { computed, effect, signal } from "@preact/signals";
import { flag, list, nullable, number, one, patched, record, tuple, Unfit, within } from "./check";
import { base, crowd, edit, type KeptBase, type KeptCrowd, MOST, motion, point } from "./forms";
import type { Edit, Motion, PersonWanted, Point } from "./protocol";

/** What is on the stage. */
export interface Made {
    base: KeptBase;
    edits: Edit[];
    motion: Motion;
}

export type Colour = "speed" | "squeeze" | "contacts";
export const TABS = ["start", "room", "crowd", "motion", "person", "take"] as const;

export interface Plan {
    tab: (typeof TABS)[number];
    made: Made;
    /** What the forms say; not necessarily made yet. */
    crowd: KeptCrowd;
    person: PersonWanted;
    unit: "m" | "cm";
    colour: Colour;
    /** Upper ends of the colours that the user has fixed. */
    most: Record<Colour, number | null>;
    /** Simulated seconds in a second. */
    pace: number;
    view: "2d" | "3d" | "section";
    /** Of the section, in m. */
    altitude: number;
    trails: boolean;
    forces: boolean;
    /** Who steps over it is counted. */
    line: [Point, Point] | null;
}

export function rectangle(width: number, height: number, x = 0, y = 0): Point[] {
    return [
        [x, y],
        [x + width, y],
        [x + width, y + height],
        [x, y + height],
    ];
}

export const FIRST: Plan = {
    tab: "start",
    made: { base: { kind: "example", name: "push" }, edits: [], motion: { kind: "own" } },
    crowd: {
        number: 40,
        density: null,
        seed: 1,
        room: { outline: rectangle(4, 4), obstacles: [], doors: [] },
        region: null,
        people: { kind: "survey" },
        men: 0.5,
        direction: 0,
        speed: 1,
        material: "human_naked",
    },
    person: { sex: "female", breadth: null, depth: null, stature: null, mass: null, altitude: null },
    unit: "cm",
    colour: "squeeze",
    most: { speed: null, squeeze: null, contacts: null },
    pace: 1,
    view: "2d",
    altitude: 1.3,
    trails: false,
    forces: false,
    line: null,
};

/** Of colours. */
const upper = within(1e-3, 1e7);
const whole = patched<Plan>(
    {
        tab: one(...TABS),
        made: record<Made>({ base, edits: list(edit, MOST.edits), motion }),
        crowd,
        person: record<PersonWanted>({
            sex: one("male", "female"),
            breadth: nullable(number),
            depth: nullable(number),
            stature: nullable(number),
            mass: nullable(number),
            altitude: nullable(within(0, 3)),
        }),
        unit: one("m", "cm"),
        colour: one("speed", "squeeze", "contacts"),
        most: record<Plan["most"]>({ speed: nullable(upper), squeeze: nullable(upper), contacts: nullable(upper) }),
        pace: within(0.01, 100),
        view: one("2d", "3d", "section"),
        altitude: within(0, 3),
        trails: flag,
        forces: flag,
        line: nullable(tuple<[Point, Point]>(point, point)),
    },
    FIRST,
);

export const KEY = "lemons-lab plan 2";
/** A plan has a few kilobytes. */
const LONGEST = 4e6;

/** What of a plan is named when it did not fit. */
const PARTS: Partial<Record<keyof Plan, string>> = {
    made: "the scene",
    crowd: "the forms of the room and the crowd",
    person: "the person",
    line: "the line",
};

interface Read {
    plan: Plan | null;
    /** What did not fit, in words; empty if all did. */
    left: string;
}

function read(from: string | null, whose: string): Read {
    if (!from) return { plan: null, left: "" };
    try {
        if (from.length > LONGEST) throw new Unfit();
        const left = new Set<string>();
        const found = whole(JSON.parse(from), (key) => left.add(PARTS[key] ?? "settings"));
        const words = left.size > 0 ? `Not all of ${whose} fits this version of the page. Left out: ${[...left].join(", ")}.` : "";
        return { plan: found, left: words };
    } catch {
        return { plan: null, left: `${capital(whose)} cannot be read: it is not whole, or it is none of this page.` };
    }
}

function capital(words: string) {
    return words[0]!.toUpperCase() + words.slice(1);
}

function stored(): string | null {
    try {
        return localStorage.getItem(KEY);
    } catch {
        return null;
    }
}

/** A link is read once: later changes count more. */
function linked(): Read {
    const { hash } = location;
    if (hash.length < 2) return { plan: null, left: "" };
    history.replaceState(null, "", location.pathname + location.search);
    let text = hash.slice(1);
    try {
        text = decodeURIComponent(text);
    } catch {
        // Then it is no plan, either.
    }
    return read(text, "the link");
}

const given = linked();
const found = read(stored(), "what this browser kept");
export const plan = signal<Plan>(given.plan ?? found.plan ?? FIRST);
/** What could not be read when the page was opened. */
export const unread = [given.left, found.left].filter(Boolean).join(" ");

/** What can be undone. */
function undoable({ made, crowd, person }: Plan) {
    return JSON.stringify({ made, crowd, person });
}

/** A link takes the place of what the visitor had made: undo brings that back. */
const past = signal<string[]>(given.plan && found.plan && undoable(found.plan) !== undoable(given.plan) ? [undoable(found.plan)] : []);
const future = signal<string[]>([]);
export const canUndo = computed(() => past.value.length > 0);
export const canRedo = computed(() => future.value.length > 0);

effect(() => {
    const now = JSON.stringify(plan.value);
    try {
        localStorage.setItem(KEY, now);
    } catch {
        // Nothing is kept where the browser allows no storage.
    }
});

/** A change; of what is made, it can be undone. */
export function change(part: Partial<Plan>) {
    const after = { ...plan.value, ...part };
    const before = undoable(plan.value);
    if (undoable(after) !== before) {
        past.value = [...past.value.slice(-199), before];
        future.value = [];
    }
    plan.value = after;
}

/** Puts back what could be made, after something else could not. It is no step of its own. */
export function settle(made: Made) {
    plan.value = { ...plan.value, made };
    // Undo should not bring back what is there already.
    if (past.value.at(-1) === undoable(plan.value)) past.value = past.value.slice(0, -1);
}

function go(from: typeof past, to: typeof past) {
    const found = from.value.at(-1);
    if (!found) return;
    from.value = from.value.slice(0, -1);
    to.value = [...to.value, undoable(plan.value)];
    plan.value = { ...plan.value, ...(JSON.parse(found) as Pick<Plan, "made" | "crowd" | "person">) };
}

export const undo = () => go(past, future);
export const redo = () => go(future, past);

export function link() {
    return `${location.origin}${location.pathname}#${encodeURIComponent(JSON.stringify(plan.value))}`;
}

/** Takes a link that was put into the open page. Returns what of it does not fit. */
export function follow(): string {
    const { plan: next, left } = linked();
    if (next) change(next);
    return left;
}

/** Files that the plan needs, or that undo and redo bring back. */
export function keysInUse(): Set<string> {
    const keys = new Set<string>();
    const see = ({ made: { base }, crowd: form }: Pick<Plan, "made" | "crowd">) => {
        if (base.kind === "upload") keys.add(base.key);
        if (base.kind === "crowd" && base.people.kind === "table") keys.add(base.people.key);
        if (form.people.kind === "table") keys.add(form.people.key);
    };
    see(plan.value);
    for (const step of [...past.value, ...future.value]) see(JSON.parse(step) as Plan);
    return keys;
}

/** Names of files that the plan needs but a link cannot hold. */
export function unlinked({ made: { base } }: Plan): string[] {
    if (base.kind === "upload") return [base.name];
    if (base.kind === "crowd" && base.people.kind === "table") return base.people.files.map(([, name]) => name);
    return [];
}
