// The visitor's scenes: kept in the browser, opened, copied, deleted, and written to files. A scene that comes from an example
// or a link is a copy: it is kept when it is changed. Storage is localStorage, not IndexedDB: it is written before the page can
// be closed, and tells other tabs.

import { batch, computed, effect, signal, untracked } from "@preact/signals";
import { titled } from "./examples";
import { t } from "./language";
import { arrived, canRedo, canUndo, deleted, FIRST, FORMER, isFormer, type Kept, keptScenes, NAME, opened, plan, read, replace, SCENE, scene, sceneOf, title, toKeep } from "./plan";
import { choose, problem, said } from "./session";
import { storage } from "./storage";

/** In ms: then a tab that was loaded again has let go of its scene. */
const SOON = 500;
/** Changes when scenes in the browser do. */
const turn = signal(0);
export const scenes = computed(() => (turn.value, keptScenes()));
/** Why the scene on the stage cannot be kept; empty if it is or need not be. */
export const unkept = signal("");

/** The scene as it was opened or kept last. */
let last = JSON.stringify(sceneOf(plan.value));
/** Also its name and what can be undone, as it was written last. */
let written = "";
/** Which opening is of a file: once it is shown, it is kept. */
let ofFile: number | null = null;

function newId() {
    return `${Date.now().toString(36)}${Math.random().toString(36).slice(2, 8)}`;
}

/** Returns why it is not kept; empty if it is. */
function write(id: string, text: string): string {
    try {
        const to = storage("localStorage");
        if (!to) throw new Error(t("this browser allows no storage here"));
        to.setItem(SCENE + id, text);
        turn.value += 1;
        return "";
    } catch (error) {
        const full = (error as Error).name === "QuotaExceededError";
        return full ? t("this browser's storage is full: delete scenes that you do not need") : (error as Error).message;
    }
}

/** Keeps the scene on the stage under an Id. */
function keep(id: string) {
    const now = toKeep();
    written = JSON.stringify({ ...now, changed: Date.now() });
    unkept.value = write(id, written);
    if (!unkept.value && scene.peek().id !== id) scene.value = { ...scene.peek(), id };
}

let name = scene.value.name;
let opening = opened.value;

/** Keeps each change, and what an earlier version of the page kept. */
export function begin() {
    if (isFormer) {
        keep(newId());
        if (!unkept.value) storage("localStorage")?.removeItem(FORMER);
    }
    effect(() => {
        const now = JSON.stringify(sceneOf(plan.value));
        const { id, name: called } = scene.value;
        const named = called !== name;
        name = called;
        const other = opened.value !== opening;
        opening = opened.value;
        if (other) {
            unkept.value = "";
            last = now;
            return;
        }
        // What only completes the scene as it was opened is no change of the visitor's.
        const completed = id === null && !canUndo.value && !canRedo.value && sameRest(now, last);
        if (now === last && !named) return;
        last = now;
        if (!completed || named) keep(id ?? newId());
    });
    effect(() => {
        if (arrived.value === ofFile) untracked(() => keep(scene.value.id ?? newId()));
    });
    addEventListener("storage", ({ key, newValue }) => {
        turn.value += 1;
        const { id, name: called } = scene.value;
        if (id === null || key !== SCENE + id || newValue === written) return;
        // Nothing of the other tab's is written over.
        const why = newValue === null ? t('"{called}" was deleted in another tab.', { called: titled(called) }) : t('"{called}" was changed in another tab.', { called: titled(called) });
        leave(newValue === null ? called : copyOf(called), why);
    });
    const shown = computed(() => scene.value.id);
    effect(() => {
        if (shown.value === null) return;
        const [key, { name: called }, end] = [SCENE + shown.value, scene.peek(), new AbortController()];
        // Kept by the first tab that shows the scene.
        const kept = () => new Promise<void>((done) => end.signal.addEventListener("abort", () => done()));
        const take = (again: boolean) =>
            void navigator.locks?.request(key, { ifAvailable: true }, (lock) => {
                if (end.signal.aborted) return;
                if (lock) return kept();
                if (again) setTimeout(take, SOON, false);
                else leave(copyOf(called), t('"{called}" is open in another tab.', { called: titled(called) }));
            });
        take(true);
        return () => end.abort();
    });
}

const copyOf = (called: string) => t("{name} (copy)", { name: titled(called) }).slice(-NAME);

/** What is on the stage is a copy from now on. */
function leave(called: string, why: string) {
    name = called;
    scene.value = { id: null, name: called };
    said.value = `${why} ${t("Here it is a copy, which is kept when you change it.")}`;
}

/** Whether two scenes differ at most in what was made of the same forms. */
function sameRest(one: string, other: string) {
    const [a, b] = [one, other].map((text) => ({ ...(JSON.parse(text) as object), made: null, crowd: null }));
    return JSON.stringify(a) === JSON.stringify(b);
}

/** Shows a scene that is not the visitor's own yet, or an opened file at once as one. */
export function open(called: string, part: Parameters<typeof choose>[0], playing: boolean, crowd = plan.value.crowd, own = false) {
    batch(() => {
        replace(null, { name: called.slice(0, NAME), past: [], future: [], plan: { end: FIRST.end, line: null, area: null, map: "none", span: [null, null], backdrop: null, drawn: null, sweep: FIRST.sweep, limit: FIRST.limit, author: "" } });
        // Materials and steps that were changed are those of the scene before.
        choose({ mechanics: undefined, ...part }, playing, crowd, "", false);
        if (own) ofFile = opened.value;
    });
}

export function openKept(id: string, kept: Kept) {
    replace(id, { ...kept, plan: sceneOf(kept.plan) });
}

export function rename(called: string) {
    const next = called.trim().slice(0, NAME);
    if (next) scene.value = { ...scene.value, name: next };
}

function tell(why: string) {
    if (why) problem.value = t("Not saved: {why}.", { why });
}

/** Another scene with the same contents. */
export function duplicate({ name: called, plan: from, past, future }: Kept) {
    tell(write(newId(), JSON.stringify({ name: copyOf(called), ...sceneOf(from), past, future, changed: Date.now() })));
}

export function remove(id: string) {
    const from = storage("localStorage");
    const text = from?.getItem(SCENE + id);
    if (!from || !text) return;
    deleted.value = { id, text, name: read(text, "it").kept?.name ?? "" };
    from.removeItem(SCENE + id);
    // On the stage it stays, as a copy.
    if (scene.value.id === id) scene.value = { ...scene.value, id: null };
    // Now there may be room for what was changed.
    else if (unkept.value) keep(scene.value.id ?? newId());
    turn.value += 1;
}

export function bringBack() {
    const was = deleted.value;
    if (!was) return;
    const why = write(was.id, was.text);
    if (!why) deleted.value = null;
    tell(why);
}

/** The scene on the stage as a file. */
export function file(): [string, string] {
    return [`${title.value}.scene.json`, JSON.stringify({ ...toKeep(), past: [], future: [] }, null, 1)];
}

/** Opens such a file. */
export async function openFile(given: File) {
    if (given.size > 4e6) throw new Error(t("{name} is too large for a scene", { name: given.name }));
    const { kept, left } = read(await given.text(), given.name);
    if (!kept) throw new Error(left);
    batch(() => {
        replace(null, { name: kept.name || given.name.slice(0, NAME), past: [], future: [], plan: sceneOf(kept.plan) });
        ofFile = opened.value;
    });
    problem.value = left;
}
