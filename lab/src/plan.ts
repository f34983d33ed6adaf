// What the user has made: kept in the browser, undone and redone, and sent as a link.

import { computed, effect, signal } from "@preact/signals";
import type { CrowdWanted, PersonWanted } from "./protocol";

/** What the present run is of. */
export type Source = { kind: "example"; name: string } | { kind: "crowd"; made: CrowdWanted };
export type Colour = "speed" | "squeeze" | "contacts";

export interface Plan {
    tab: "run" | "crowd" | "person";
    source: Source;
    /** What the form says; not necessarily made yet. */
    crowd: CrowdWanted;
    person: PersonWanted;
    unit: "m" | "cm";
    colour: Colour;
    /** Simulated seconds in a second. */
    pace: number;
}

export const FIRST: Plan = {
    tab: "run",
    source: { kind: "example", name: "push" },
    crowd: { number: 40, seed: 1, room: [4, 4], men: 0.5, direction: 0, speed: 1 },
    person: { sex: "female", breadth: null, depth: null, stature: null, mass: null },
    unit: "cm",
    colour: "squeeze",
    pace: 1,
};

const KEY = "lemons-lab plan 1";

/** Only what has the form of a plan, because links and storage may hold anything. */
function read(text: string | null): Plan | null {
    if (!text) return null;
    try {
        const given = JSON.parse(text);
        const plan = fitted(FIRST, given) as Plan;
        const made = given?.source?.kind === "crowd";
        return made ? { ...plan, source: { kind: "crowd", made: fitted(FIRST.crowd, given.source.made) as CrowdWanted } } : plan;
    } catch {
        return null;
    }
}

const CHOICES: Record<string, readonly unknown[]> = {
    tab: ["run", "crowd", "person"],
    kind: ["example"],
    sex: ["female", "male"],
    unit: ["m", "cm"],
    colour: ["speed", "squeeze", "contacts"],
};

/** `given` where it has the form of `form`, else `form`. */
function fitted(form: unknown, given: unknown, key = ""): unknown {
    const number = (value: unknown) => typeof value === "number" && Number.isFinite(value);
    if (key in CHOICES) return CHOICES[key]!.includes(given) ? given : form;
    if (form === null || key === "direction") return given === null || number(given) ? given : form;
    if (Array.isArray(form)) {
        const fits = Array.isArray(given) && given.length === form.length;
        return fits ? form.map((part, k) => fitted(part, given[k])) : form;
    }
    if (typeof form === "object") {
        if (typeof given !== "object" || given === null) return form;
        const parts = Object.entries(form).map(([name, part]) => {
            return [name, fitted(part, (given as Record<string, unknown>)[name], name)];
        });
        return Object.fromEntries(parts);
    }
    return typeof given === typeof form && (typeof given !== "number" || number(given)) ? given : form;
}

function stored(): string | null {
    try {
        return localStorage.getItem(KEY);
    } catch {
        return null;
    }
}

function linked(): string | null {
    try {
        return decodeURIComponent(location.hash.slice(1)) || null;
    } catch {
        return null;
    }
}

const given = read(linked());
export const plan = signal<Plan>(given ?? read(stored()) ?? FIRST);
// A link is read once: later changes count more.
if (location.hash) history.replaceState(null, "", location.pathname + location.search);
const past = signal<string[]>([]);
const future = signal<string[]>([]);
export const canUndo = computed(() => past.value.length > 0);
export const canRedo = computed(() => future.value.length > 0);

effect(() => {
    const text = JSON.stringify(plan.value);
    try {
        localStorage.setItem(KEY, text);
    } catch {
        // Nothing is kept where the browser allows no storage.
    }
});

/** A change; of what is made, it can be undone. */
export function change(part: Partial<Plan>) {
    const before = JSON.stringify(plan.value);
    const after = { ...plan.value, ...part };
    if (JSON.stringify(after) === before) return;
    if (part.source || part.crowd || part.person) {
        past.value = [...past.value.slice(-199), before];
        future.value = [];
    }
    plan.value = after;
}

function go(from: typeof past, to: typeof past) {
    const text = from.value.at(-1);
    if (!text) return;
    from.value = from.value.slice(0, -1);
    to.value = [...to.value, JSON.stringify(plan.value)];
    const { source, crowd, person } = JSON.parse(text) as Plan;
    plan.value = { ...plan.value, source, crowd, person };
}

export const undo = () => go(past, future);
export const redo = () => go(future, past);

export function link() {
    return `${location.origin}${location.pathname}#${encodeURIComponent(JSON.stringify(plan.value))}`;
}
