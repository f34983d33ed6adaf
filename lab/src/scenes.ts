// The visitor's scenes: kept in the browser, opened, copied, deleted, and written to files. A scene that comes from an example
// or a link is a copy: it is kept when it is changed. Storage is localStorage, not IndexedDB: it is written before the page can
// be closed, and tells other tabs.

import { batch, computed, effect, signal } from "@preact/signals";
import { canRedo, canUndo, FORMER, former, type Kept, keptScenes, NAME, plan, read, replace, SCENE, scene, sceneOf, storage, toKeep } from "./plan";
import { choose, problem, said } from "./session";

/** Changes when scenes in the browser do. */
const turn = signal(0);
export const scenes = computed(() => (turn.value, keptScenes()));
/** Why the scene on the stage cannot be kept; empty if it is or need not be. */
export const unkept = signal("");
/** What was deleted last, to bring it back. */
export const deleted = signal<{ id: string; text: string; name: string } | null>(null);

/** The scene as it was opened or kept last. */
let last = JSON.stringify(sceneOf(plan.value));
/** Also its name and what can be undone, as it was written last. */
let written = "";

function newId() {
    return `${Date.now().toString(36)}${Math.random().toString(36).slice(2, 8)}`;
}

/** Returns whether it is kept. */
function write(id: string, text: string): boolean {
    try {
        const to = storage("localStorage");
        if (!to) throw new Error("this browser allows no storage here");
        to.setItem(SCENE + id, text);
        turn.value += 1;
        return true;
    } catch (error) {
        const full = (error as Error).name === "QuotaExceededError";
        unkept.value = full ? "this browser's storage is full: delete scenes that you do not need" : (error as Error).message;
        return false;
    }
}

/** Keeps the scene on the stage under an Id. */
function keep(id: string) {
    const now = toKeep();
    written = JSON.stringify({ ...now, changed: Date.now() });
    if (!write(id, written)) return;
    unkept.value = "";
    if (scene.peek().id !== id) scene.value = { ...scene.peek(), id };
}

let name = scene.value.name;

/** Keeps each change, and what an earlier version of the page kept. */
export function begin() {
    if (former) {
        keep(newId());
        if (!unkept.value) storage("localStorage")?.removeItem(FORMER);
    }
    effect(() => {
        const now = JSON.stringify(sceneOf(plan.value));
        const { id, name: called } = scene.value;
        const named = called !== name;
        name = called;
        // What only completes the scene as it was opened is no change of the visitor's.
        const opened = id === null && !canUndo.value && !canRedo.value && sameRest(now, last);
        if (now === last && !named) return;
        last = now;
        if (!opened || named) keep(id ?? newId());
    });
    addEventListener("storage", ({ key, newValue }) => {
        turn.value += 1;
        const { id, name: called } = scene.value;
        if (id === null || key !== SCENE + id || newValue === written) return;
        // Nothing of the other tab's is written over.
        const copy = newValue === null ? called : `${called} (copy)`.slice(-NAME);
        name = copy;
        scene.value = { id: null, name: copy };
        said.value = newValue === null ? `${called} was deleted in another tab. Here it is a copy, which is kept when you change it.` : `${called} was changed in another tab. Here it is a copy, which is kept when you change it.`;
    });
}

/** Whether two scenes differ at most in what was made of the same wishes. */
function sameRest(one: string, other: string) {
    const [a, b] = [one, other].map((text) => ({ ...(JSON.parse(text) as object), made: null, crowd: null }));
    return JSON.stringify(a) === JSON.stringify(b);
}

/** Shows a scene that is not the visitor's own yet, or an opened file at once as one. */
export function open(called: string, part: Parameters<typeof choose>[0], playing: boolean, crowd = plan.value.crowd, own = false) {
    name = called.slice(0, NAME);
    last = JSON.stringify({ ...sceneOf(plan.value), line: null, area: null, made: { ...plan.value.made, ...part }, crowd });
    batch(() => {
        replace(null, { name, past: [], future: [], plan: { line: null, area: null } });
        choose(part, playing, crowd, "", false);
    });
    if (own) keep(newId());
}

export function openKept(id: string, kept: Kept) {
    last = JSON.stringify(sceneOf(kept.plan));
    name = kept.name;
    replace(id, { ...kept, plan: sceneOf(kept.plan) });
}

export function rename(called: string) {
    const next = called.trim().slice(0, NAME);
    if (next) scene.value = { ...scene.value, name: next };
}

/** Another scene with the same contents. */
export function duplicate({ name: called, plan: from, past, future }: Kept) {
    write(newId(), JSON.stringify({ name: `${called} (copy)`.slice(-NAME), ...sceneOf(from), past, future, changed: Date.now() }));
}

export function remove(id: string) {
    const from = storage("localStorage");
    const text = from?.getItem(SCENE + id);
    if (!from || !text) return;
    deleted.value = { id, text, name: read(text, "it").kept?.name ?? "" };
    from.removeItem(SCENE + id);
    // On the stage it stays, as a copy.
    if (scene.value.id === id) scene.value = { ...scene.value, id: null };
    turn.value += 1;
}

export function bringBack() {
    const was = deleted.value;
    if (was && write(was.id, was.text)) deleted.value = null;
}

/** The scene on the stage as a file. */
export function file(): [string, string] {
    return [`${scene.value.name}.scene.json`, JSON.stringify({ ...toKeep(), past: [], future: [] }, null, 1)];
}

/** Opens such a file. */
export async function openFile(given: File) {
    if (given.size > 4e6) throw new Error(`${given.name} is too large for a scene`);
    const { kept, left } = read(await given.text(), given.name);
    if (!kept) throw new Error(left);
    last = JSON.stringify(sceneOf(kept.plan));
    name = kept.name || given.name.slice(0, NAME);
    replace(null, { name, past: [], future: [], plan: sceneOf(kept.plan) });
    keep(newId());
    problem.value = left;
}
