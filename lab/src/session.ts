// The present run: which plan it shows, how it is opened, what is told about it.

import { batch, computed, effect, signal, untracked } from "@preact/signals";
import { Client, Stopped } from "./client";
import { Film } from "./film";
import { type KeptBase } from "./forms";
import { about, count, fixed, inWords, t } from "./language";
import { arrive, change, FIRST, follow, isNew, keysInUse, type Made as Planned, opened, plan, settle, unread } from "./plan";
import type { Opened, PlacedCrowd, Scene, Sex, Shown } from "./protocol";
import { viewed } from "./storage";
import { kept, remove } from "./store";

export const client = new Client();
export const film = signal<Film | null>(null);
export const selected = signal<number | null>(null);
/** How the crowd on the stage was placed. */
export const made = signal<PlacedCrowd | null>(null);
export const notes = signal<string[]>([]);
/** What is well. */
export const said = signal("");
/** What is not. */
export const problem = signal("");
/** Counts the scenes that had another base than the one before. */
export const bases = signal(0);

/** What the film shows. */
let present: Planned | null = null;
/** The walls of an opened Trial as its files have them, and which Trial it is (its base as text). */
export const trialWalls = signal<{ base: string; walls: Scene["walls"] } | null>(null);
/** Whether the next one plays at once. The first scene does, and the example with files of its own. */
let plays = isNew || viewed || (plan.value.made.base.kind === "example" && plan.value.tab === "start");

/** Whether the visitor likes pictures that move by themselves. */
const moves = !matchMedia("(prefers-reduced-motion: reduce)").matches;

/** What is said when the next scene is there. */
let sayNext = "";
/** Who is selected in the next scene. */
let nextId: string | undefined;

export function selectNext(id: string) {
    nextId = id;
}

/** Scenes are asked for one after the other; only the latest counts. */
let latest = 0;
/** What is waited for. */
let opening: Planned | null = null;

const same = (one: unknown, other: unknown) => JSON.stringify(one) === JSON.stringify(other);

export async function attempt(what: () => Promise<void>) {
    problem.value = "";
    try {
        await what();
    } catch (error) {
        if (error instanceof Stopped) {
            if (error.message === "stopped") said.value = t("Stopped.");
        } else {
            problem.value = (error as Error).message;
            said.value = "";
        }
    }
}

/** Without what only the page needs, and the files' contents. */
export async function sent(base: KeptBase): Promise<[Pick<Shown, "base" | "tables">, Uint8Array | undefined]> {
    if (base.kind === "example") return [{ base }, undefined];
    if (base.kind === "upload") {
        const { key, ...upload } = base;
        return [{ base: upload }, await contents(key, base.name)];
    }
    const { region, people, ...keys } = base;
    const regions = region ? [{ corners: region, number: null, density: null }] : [];
    if (people.kind !== "table") return [{ base: { ...keys, regions, people } }, undefined];
    const tables = people.files.map(([, name, length]): [string, number] => [name, length]);
    const of = (sex: Sex) => people.files.find(([whose]) => whose === sex)?.[1] ?? null;
    return [{ base: { ...keys, regions, people: { kind: "tables", male: of("male"), female: of("female") } }, tables }, await contents(people.key, tables.map(([name]) => name).join(", "))];
}

async function contents(key: string, name: string): Promise<Uint8Array> {
    const bytes = await kept(key);
    if (!bytes) throw new Error(t('"{name}" is not kept in this browser: a link holds no files. Open it here.', { name }));
    return bytes;
}

/** How many people were placed, or opened. */
function describe(opened: Opened, base: KeptBase, seconds: number): string {
    const people = count(opened.scene.agents.length, "{n} person", "{n} people");
    if (base.kind === "crowd") return t("{people} placed in {seconds} s", { people, seconds: fixed(seconds, 2) });
    return base.kind === "upload" ? about(`"${base.name}"`, people) : "";
}

async function open(wanted: Planned, number: number) {
    const { edits, motion, mechanics } = wanted;
    const [scene, bytes] = await sent(wanted.base);
    if (number !== latest) return;
    const before = said.value;
    const { value, bytes: first, seconds } = await client.ask<Opened>({ ask: "show", ...scene, edits, mechanics, motion }, bytes);
    // The lab has this scene now and not the one that is shown, which is opened again if the later one fails.
    if (number !== latest) {
        film.value?.end();
        if (!opening) back();
        return;
    }
    const other = !same(present?.base, wanted.base);
    const chosen = nextId ?? (!other && selected.value !== null ? film.value?.scene.agents[selected.value]?.id : undefined);
    nextId = undefined;
    const place = value.scene.agents.findIndex(({ id }) => id === chosen);
    film.value?.end();
    present = wanted;
    opening = null;
    const next = new Film(client, value.scene, wanted, first);
    // What follows from the new film may already want the next one.
    const playing = plays && moves;
    plays = false;
    batch(() => {
        notes.value = value.notes.map(inWords);
        made.value = value.made;
        // Those who were moved by hand were not placed again.
        const placed = other || !film.value ? describe(value, wanted.base, seconds) : "";
        const words = [placed, sayNext].filter(Boolean).join(". ");
        // What was said meanwhile ("The link is copied.") stays.
        const meanwhile = said.value === before ? "" : said.value;
        said.value = [meanwhile, words].filter(Boolean).join(" ");
        sayNext = "";
        selected.value = place < 0 ? null : place;
        film.value = next;
        if (!wanted.edits.some((edit) => edit.do === "room")) trialWalls.value = { base: JSON.stringify(wanted.base), walls: value.scene.walls };
        next.playing.value = playing;
        arrive();
        if (other) bases.value += 1;
    });
}

/** Opens it; if that fails, what was there before is what the plan says. */
async function show(wanted: Planned) {
    const number = ++latest;
    // Nobody waits any more for what is still being placed.
    if (opening && client.slow.peek()?.ask === "show") client.stop("another scene is wanted");
    opening = wanted;
    problem.value = "";
    try {
        await open(wanted, number);
    } catch (error) {
        if (number !== latest) return;
        opening = null;
        plays = false;
        nextId = undefined;
        // Who ended the worker opens what was there again.
        if (error instanceof Stopped) return;
        sayNext = "";
        // A link or a former visit may hold what cannot be made. The effect below shows what could be.
        if (same(plan.value.made, wanted)) settle(present ?? FIRST.made);
        // A file that is no Trial need not be kept.
        const { base } = wanted;
        if (base.kind === "upload" && !keysInUse().has(base.key)) void remove(base.key);
        problem.value = (error as Error).message;
    }
}

const wanted = computed(() => JSON.stringify(plan.value.made));
/** Begins to show what the plan says, now and whenever it changes. */
export function begin() {
    effect(() => {
        opened.value;
        const next = JSON.parse(wanted.value) as Planned;
        if (opening && same(opening, next)) return;
        // Also when it is brought back: by undo, a link, the browser's storage.
        const shown = !opening && film.peek() && !film.peek()!.over && same(present, next);
        untracked(() => (shown ? arrive() : void show(next)));
    });
    problem.value = unread;
    addEventListener("hashchange", async () => {
        const left = await follow();
        if (left) problem.value = left;
    });
}

/** Whether a run that takes the place of the present one plays: that one does, or it has ended. */
export function playsOn(): boolean {
    const now = film.peek();
    if (!now) return false;
    const ended = now.emptied.peek();
    return now.playing.peek() || (ended !== null && now.shown.peek() >= ended);
}

/** What takes the place of the present run plays: who moves a slider wants to see what follows. */
export function goOn() {
    if (moves && film.peek()) film.peek()!.playing.value = true;
}

/** Makes it the present run; from its start again, if it is. */
export function choose(next: Partial<Planned>, playing: boolean, crowd = plan.value.crowd, saying = "", asStep = true) {
    const before = plan.value.made;
    const all = { ...before, ...next };
    plays = playing;
    sayNext = saying;
    if (same(before, all)) {
        change({ crowd }, asStep);
        void show(all);
    } else change({ made: all, crowd }, asStep);
}

/** Opens what was there before, because its worker ended. If nothing was, the first example. */
function back() {
    const before = present ?? FIRST.made;
    plays = false;
    opening = null;
    // What follows from it may show it already.
    settle(before);
    if (!opening) void show(before);
}

/** Ends whatever is computed. */
export function stop() {
    client.stop("stopped");
    sayNext = t("Stopped. What was there before is shown from its start.");
    back();
}

client.broken = (why) => {
    const again = client.works;
    if (again) back();
    problem.value = `${t("The computation ended ({why}).", { why })} ${again ? t("What was shown is opened again, from its start.") : t("This browser cannot run the lab, or its files are not complete.")}`;
};
