// Keeps files that the user has opened, in the browser's database: a reload brings them back. They never leave it.

import { createStore, del, delMany, get, keys, set } from "idb-keyval";

const NAME = "lemons-lab";
/** So many of the latest are kept besides those that are in use; a file has at most 50 MB. */
const MOST = 5;

/** What was opened since the page was; also where the browser keeps nothing. */
const here = new Map<string, Uint8Array>();

/** Keys of what lasts until the page is closed: the browser keeps nothing, or has no room. */
export const brief = new Set<string>();

const files = createStore(`${NAME} files`, "files");
/** Where earlier versions of the page kept them, as `{ key, bytes }`. */
const former = createStore(NAME, "files");

/** Keys begin with their time. */
function unneeded(keys: Iterable<string>, used: Set<string>): string[] {
    return [...keys].filter((key) => !used.has(key)).sort().slice(0, -MOST);
}

/** Returns the key. Older files go, but not those that are in use. */
export async function keep(bytes: Uint8Array, used: Set<string>): Promise<string> {
    const key = `${Date.now().toString(36)}-${Math.random().toString(36).slice(2)}`;
    here.set(key, bytes);
    for (const old of unneeded(here.keys(), used)) here.delete(old);
    try {
        await set(key, bytes, files);
        await delMany(unneeded(await keys<string>(files), used), files);
    } catch {
        brief.add(key);
    }
    return key;
}

export async function kept(key: string): Promise<Uint8Array | null> {
    try {
        const bytes = here.get(key) ?? (await get<Uint8Array>(key, files)) ?? (await get<{ bytes: Uint8Array }>(key, former))?.bytes;
        if (bytes) here.set(key, bytes);
        return bytes ?? null;
    } catch {
        return null;
    }
}

export async function remove(key: string) {
    here.delete(key);
    // What cannot be deleted was not kept.
    await Promise.all([files, former].map((store) => del(key, store))).catch(() => {});
}

/** Several contents one after the other, as a request holds them. */
export async function joined(parts: BlobPart[]): Promise<Uint8Array> {
    return new Uint8Array(await new Blob(parts).arrayBuffer());
}
