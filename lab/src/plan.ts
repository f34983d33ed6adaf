// The scene on the stage and the state of the page: changed, undone and redone, and sent as a link.

import { batch, computed, effect, signal } from "@preact/signals";
import { firsts, flag, forms, list, nullable, number, type OfRows, one, patched, record, row, text, tuple, Unfit, within } from "./check";
import { EXAMPLES, titled } from "./examples";
import { backdrop, base, crowd, edit, FIRST_CROWD, type KeptBase, type KeptCrowd, mechanics, MOST, motion, person, point } from "./forms";
import { capital, t } from "./language";
import type { Edit, Mechanics, Motion, Point } from "./protocol";
import { packed, unpacked } from "./link";
import { storage, viewed } from "./storage";

/** What is on the stage. */
export interface Made {
    base: KeptBase;
    edits: Edit[];
    motion: Motion;
    /** Changed materials and steps. */
    mechanics?: Mechanics;
}

export const TABS = ["start", "room", "crowd", "motion", "person", "take"] as const;
export type Colour = "speed" | "squeeze" | "contacts" | "kind" | "chest" | "compression" | "level";

/** Most letters of the name of a scene, and of who made it. */
export const NAME = 80;
/** Checks the upper end of a colour scale. */
const upper = within(1e-3, 1e7);
/** What of a plan belongs to the page. */
const PAGE_ROWS = {
    tab: row(one(...TABS), "start"),
    unit: row(one("m", "cm"), "cm"),
    /** Whether all tools, numbers and settings are shown, not only what is needed first. */
    more: row(flag, false),
    /** Simulated seconds in a second; 0: as slow as what happens needs it. */
    pace: row(within(0, 100), 0),
    /** "asked": what the question of the scene is about. */
    chart: row(one("asked", "greatest", "mean", "speed", "left", "flow", "density", "chest", "rows", "all"), "asked"),
    view: row(one("2d", "3d", "section"), "2d"),
    /** Altitude of the section, in m. */
    altitude: row(within(0, 3), 1.3),
};
/** What belongs to its scene, and goes with it into links and files. */
const SCENE_ROWS = {
    made: row(record<Made>({ base, edits: list(edit, MOST.edits), motion, mechanics }), { base: { kind: "example", name: "push" }, edits: [], motion: { kind: "own" } }),
    /** What the forms say; not necessarily made yet. */
    crowd: row(crowd, FIRST_CROWD),
    person: row(person, { sex: "female", breadth: null, depth: null, stature: null, mass: null, altitude: null }),
    colour: row(one<Colour>("speed", "squeeze", "contacts", "kind", "chest", "compression", "level"), "squeeze"),
    /** Time over which squeeze is a mean, in s. */
    smooth: row(within(0.01, 10), 0.1),
    /** Upper ends of the colours that the user has fixed. */
    most: row(record<Record<Colour, number | null>>({ speed: nullable(upper), squeeze: nullable(upper), contacts: nullable(upper), kind: () => null, chest: nullable(upper), compression: nullable(upper), level: nullable(upper) }), {
        speed: null,
        squeeze: null,
        contacts: null,
        kind: null,
        chest: null,
        compression: null,
        level: null,
    }),
    /** Where the timeline ends, in s; the first value: with what happens, if that ends (event.ts). */
    end: row(within(1e-3, 1e5), 30),
    trails: row(flag, false),
    forces: row(flag, false),
    /** What is shown by place, and the time over which: null for the start, and for as far as is computed. */
    map: row(one("none", "density", "mean", "greatest"), "none"),
    span: row(tuple<[number | null, number | null]>(nullable(within(0, 1e5)), nullable(within(0, 1e5))), [null, null]),
    /** Who steps over it is counted. */
    line: row(nullable(tuple<[Point, Point]>(point, point)), null),
    /** Two opposite corners: who is inside is counted. */
    area: row(nullable(tuple<[Point, Point]>(point, point)), null),
    /** The picture under the room. */
    backdrop: row(backdrop, null),
    /** What the form of a sweep says. No parameter or measure and null stand for what it proposes. */
    sweep: row(record({ parameter: text(MOST.name), values: nullable(text(MOST.list)), seeds: within(1, MOST.seeds), until: nullable(within(0.1, 1e5)), measure: text(MOST.name) }), {
        parameter: "",
        values: null,
        seeds: 3,
        until: null,
        measure: "",
    }),
    /** Of squeeze, as a mean over so many seconds: who was above it, and how long, is told. */
    limit: row(record({ force: within(1, 1e6), seconds: within(0.01, 600) }), { force: 623, seconds: 1 }),
    /** Name of the file of which the room was made. */
    drawn: row(nullable(text(MOST.name)), null),
    /** Who made the scene, for its report. */
    author: row(text(NAME), ""),
};
type Part = OfRows<typeof SCENE_ROWS>;
const undone = record<Pick<Part, "made" | "crowd" | "person" | "backdrop">>({ made: SCENE_ROWS.made[0], crowd, person, backdrop });
export type Plan = OfRows<typeof PAGE_ROWS> & Part;
const ROWS = { ...PAGE_ROWS, ...SCENE_ROWS };
export const FIRST: Plan = firsts(ROWS);
const whole = patched<Plan>(forms(ROWS), FIRST);

const only = <R extends object>(plan: Plan, rows: R) => Object.fromEntries(Object.keys(rows).map((key) => [key, plan[key as keyof Plan]])) as OfRows<R>;
export const sceneOf = (plan: Plan): Part => only(plan, SCENE_ROWS);

/** A scene with its name and what can be undone. */
export interface Kept {
    name: string;
    /** When it was changed, in ms since 1970. */
    changed: number;
    plan: Plan;
    past: string[];
    future: string[];
}

/** A scene has a few kilobytes; its past may have more. */
const LONGEST = 4e6;
/** Steps that can be undone, and letters of them that are kept. */
const STEPS = 200;
const PAST = 3e5;

/** What of a plan is named when it did not fit. */
const PARTS: Partial<Record<keyof Plan, string>> = {
    made: t("the scene"),
    crowd: t("the forms of the room and the crowd"),
    person: t("the person"),
    line: t("the line"),
    area: t("the area"),
    backdrop: t("the picture under the room"),
};

export interface Read {
    kept: Kept | null;
    /** What did not fit, in words; empty if all did. */
    left: string;
}

const steps = list(text(LONGEST), STEPS);

/** A scene as a link, a file or the browser has it. `Kept` lies flat in it: its plan's parts beside its name. */
export function read(from: string | null, whose: string): Read {
    if (!from) return { kept: null, left: "" };
    try {
        if (from.length > LONGEST) throw new Unfit();
        const left = new Set<string>();
        const given: unknown = JSON.parse(from);
        const plan = whole(given, (key) => left.add(PARTS[key] ?? t("settings")));
        const words = left.size > 0 ? t("Not all of {whose} fits this version of the page. Left out: {parts}.", { whose, parts: [...left].join(", ") }) : "";
        const { name, changed, past, future } = patched<Omit<Kept, "plan">>({ name: text(NAME), changed: number, past: steps, future: steps }, { name: "", changed: 0, past: [], future: [] })(given, () => {});
        return { kept: { name, changed, plan, past, future }, left: words };
    } catch {
        return { kept: null, left: t("{whose} cannot be read: it is not whole, or it is none of this page.", { whose: capital(whose) }) };
    }
}

/** The latest steps that have not too many letters together. */
function latest(steps: string[]): string[] {
    let letters = 0;
    const from = steps.findLastIndex((step) => (letters += step.length) > PAST);
    return steps.slice(from + 1);
}

/** A link is read once: later changes count more. */
async function linked(): Promise<Read> {
    const { hash } = location;
    if (hash.length < 2) return { kept: null, left: "" };
    if (!viewed) history.replaceState(null, "", location.pathname + location.search);
    // What cannot be unpacked is no plan, either.
    const found = read(await unpacked(hash.slice(1), LONGEST).catch(() => "-"), t("the link"));
    // A link brings its scene. What belongs to the page is as this visitor has it.
    return found.kept ? { ...found, kept: { ...found.kept, name: found.kept.name || "From a link", past: [], future: [] } } : found;
}

/** Key of what this tab has, which it finds again after a reload: also a scene that is not kept. */
const TAB = "lemons-lab tab";
/** What belongs to the page, for the next visit. */
const PAGE = "lemons-lab page";
/** Key of the one scene of earlier versions of the page. */
export const FORMER = "lemons-lab plan 2";
/** Before the Id of a scene. */
export const SCENE = "lemons-lab scene ";

/** The forms that say it, if it is made by forms. */
export function crowdOf(base: KeptBase): KeptCrowd | null {
    if (base.kind !== "crowd") return null;
    const { kind: _, ...crowd } = base;
    return crowd;
}

/** The scenes that this browser keeps, the latest first. */
export function keptScenes(): { id: string; kept: Kept }[] {
    const from = storage("localStorage");
    const found = Array.from({ length: from?.length ?? 0 }, (_, k) => from!.key(k) ?? "")
        .filter((key) => key.startsWith(SCENE))
        .flatMap((key) => {
            const { kept } = read(from!.getItem(key), "a scene");
            return kept ? [{ id: key.slice(SCENE.length), kept }] : [];
        });
    return found.sort((one, other) => other.kept.changed - one.kept.changed);
}

/** What this tab had, what was changed last in this browser, or what an earlier version kept. */
function found(): { id: string | null; read: Read; former: boolean } {
    const tab = read(storage("sessionStorage")?.getItem(TAB) ?? null, t("what this tab had"));
    if (tab.kept) {
        const id = (JSON.parse(storage("sessionStorage")!.getItem(TAB)!) as { id?: unknown }).id;
        return { id: typeof id === "string" ? id : null, read: tab, former: false };
    }
    const [last] = keptScenes();
    if (last) return { id: last.id, read: { kept: last.kept, left: tab.left }, former: false };
    const former = read(storage("localStorage")?.getItem(FORMER) ?? null, t("what this browser kept"));
    return { id: null, read: { kept: former.kept && { ...former.kept, name: "Of an earlier visit" }, left: former.left || tab.left }, former: former.kept !== null };
}

const given = await linked();
const before = found();
/** Whether there is nothing of a former visit, and no link. */
export const isNew = !given.kept && !before.read.kept;
const { name: called, made } = EXAMPLES[0]!;
const first = given.kept ?? before.read.kept ?? { name: called, changed: 0, plan: { ...FIRST, made, crowd: crowdOf(made.base) ?? FIRST_CROWD }, past: [], future: [] };
const page = read(storage("localStorage")?.getItem(PAGE) ?? null, "the page").kept?.plan ?? FIRST;
const own = given.kept || !storage("sessionStorage")?.getItem(TAB) ? { ...page, tab: "start" as const } : first.plan;
export const plan = signal<Plan>({ ...own, ...sceneOf(first.plan) });
/** The scene on the stage: its Id if it is kept, and its name. */
export const scene = signal<{ id: string | null; name: string }>({ id: given.kept ? null : before.id, name: first.name || "A scene" });
/** Its name as it is shown. */
export const title = computed(() => titled(scene.value.name));
/** Whether it is of an earlier version of the page. */
export const isFormer = !given.kept && before.former;
/** What could not be read when the page was opened. */
export const unread = [given.left, before.read.left].filter(Boolean).join(" ");

/** What can be undone. */
function undoable({ made, crowd, person, backdrop }: Plan) {
    return JSON.stringify({ made, crowd, person, backdrop });
}

const past = signal<string[]>(first.past);
const future = signal<string[]>(first.future);
export const canUndo = computed(() => past.value.length > 0);
export const canRedo = computed(() => future.value.length > 0);

/** The scene as it is kept. */
export function toKeep() {
    return { name: scene.value.name, ...sceneOf(plan.value), past: latest(past.value), future: latest(future.value) };
}

effect(() => {
    try {
        const page = only(plan.value, PAGE_ROWS);
        storage("sessionStorage")?.setItem(TAB, JSON.stringify({ id: scene.value.id, ...page, ...toKeep() }));
        storage("localStorage")?.setItem(PAGE, JSON.stringify(page));
    } catch {
        // It is kept until the tab is closed or loaded again. Of scenes, scenes.ts says so.
    }
});

type Wanted = Pick<Kept, "name" | "past" | "future"> & { plan: Partial<Part> };

/** Counts the scenes that were put on the stage, also those that were put back. */
export const opened = signal(0);
/** Which of them is shown. */
export const arrived = signal(-1);
/** The scene to go back to if the one that is opened cannot be shown; at first an example. Null once it is shown. */
let former: { id: string | null; kept: Wanted } | null = { id: null, kept: { name: "A push through a row", past: [], future: [], plan: { made: FIRST.made } } };

function put(id: string | null, kept: Wanted) {
    batch(() => {
        opened.value += 1;
        scene.value = { id, name: kept.name || "A scene" };
        past.value = kept.past;
        future.value = kept.future;
        plan.value = { ...plan.value, ...kept.plan };
    });
}

/** Puts another scene on the stage. */
export function replace(id: string | null, kept: Wanted) {
    former ??= { id: scene.value.id, kept: { name: scene.value.name, past: past.value, future: future.value, plan: sceneOf(plan.value) } };
    put(id, kept);
}

/** Tells that the scene on the stage is shown. */
export function arrive() {
    former = null;
    arrived.value = opened.value;
}

/** A change; of what is made, it can be undone, unless it only completes the change before. */
export function change(part: Partial<Plan>, asStep = true) {
    const after = { ...plan.value, ...part };
    const before = undoable(plan.value);
    if (asStep && undoable(after) !== before) {
        past.value = [...past.value.slice(1 - STEPS), before];
        future.value = [];
    }
    plan.value = after;
}

/** Puts back what could be made, after something else could not: with its scene, if another one was opened. It is no step of
 * its own. */
export function settle(made: Made) {
    if (former) {
        const { id, kept } = former;
        former = null;
        return put(id, { ...kept, plan: { ...kept.plan, made } });
    }
    plan.value = { ...plan.value, made };
    // Undo should not bring back what is there already.
    if (past.value.at(-1) === undoable(plan.value)) past.value = past.value.slice(0, -1);
}

function go(from: typeof past, to: typeof past) {
    const step = from.value.at(-1);
    if (!step) return;
    from.value = from.value.slice(0, -1);
    try {
        const now = undoable(plan.value);
        plan.value = { ...plan.value, ...undone(JSON.parse(step)) };
        to.value = [...to.value, now];
    } catch {
        // It came from the browser's storage, where it was not whole.
    }
}

export const undo = () => go(past, future);
export const redo = () => go(future, past);

/** The scene as a link, without what is as at first. It holds no picture. */
export async function link(query: "?view" | "?embed" | "?lab") {
    const held = Object.entries(sceneOf(plan.value)).filter(([key, value]) => key !== "backdrop" && JSON.stringify(value) !== JSON.stringify(FIRST[key as keyof Plan]));
    return `${location.origin}${location.pathname}${query}#${await packed(JSON.stringify({ name: scene.value.name, ...Object.fromEntries(held) }))}`;
}

/** What is said of a link where the page is on the visitor's own machine. */
export const onlyHere = ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname) ? t("It works on this machine only: for others, put the page on a web host (docs/lab.md says how).") : "";

/** Takes a link that was put into the open page. Returns what of it does not fit. */
export async function follow(): Promise<string> {
    const { kept, left } = await linked();
    if (kept) replace(null, { ...kept, plan: sceneOf(kept.plan) });
    return left;
}

/** The scene that was deleted last, to bring it back. */
export const deleted = signal<{ id: string; text: string; name: string } | null>(null);

/** Files that a scene needs, or that undo, redo and "Bring it back" do. */
export function keysInUse(): Set<string> {
    const keys = new Set<string>();
    const see = ({ made: { base }, crowd: form, backdrop }: Pick<Plan, "made" | "crowd" | "backdrop">) => {
        if (backdrop) keys.add(backdrop.key);
        if (base.kind === "upload") keys.add(base.key);
        if (base.kind === "crowd" && base.people.kind === "table") keys.add(base.people.key);
        if (form.people.kind === "table") keys.add(form.people.key);
    };
    const gone = deleted.value && read(deleted.value.text, "it").kept;
    const all = [{ plan: plan.value, past: past.value, future: future.value }, ...keptScenes().map(({ kept }) => kept), ...(former ? [{ ...former.kept, plan: { ...plan.value, ...former.kept.plan } }] : []), ...(gone ? [gone] : [])];
    for (const { plan, past, future } of all) {
        see(plan);
        for (const step of [...past, ...future]) {
            try {
                see(undone(JSON.parse(step)));
            } catch {
                // It cannot be undone, either.
            }
        }
    }
    return keys;
}

/** Names of files that the plan needs but a link cannot hold. */
export function unlinked({ made: { base }, backdrop }: Plan): string[] {
    const picture = backdrop ? [backdrop.name] : [];
    if (base.kind === "upload") return [base.name, ...picture];
    if (base.kind === "crowd" && base.people.kind === "table") return [...base.people.files.map(([, name]) => name), ...picture];
    return picture;
}
