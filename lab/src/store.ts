// Keeps files that the user has opened, in the browser's database: a reload brings them back. They never leave it.

import { t } from "./language";

const NAME = "lemons-lab";
/** So many of the latest are kept besides those that are in use; a file has at most 50 MB. */
const MOST = 5;

interface Entry {
    key: string;
    bytes: Uint8Array;
}

/** What was opened since the page was; also where the browser keeps nothing. */
const here = new Map<string, Uint8Array>();

/** Keys of what lasts until the page is closed: the browser keeps nothing, or has no room. */
export const brief = new Set<string>();

function finished<T>(request: IDBRequest<T>): Promise<T> {
    return new Promise((done, failed) => {
        request.onsuccess = () => done(request.result);
        request.onerror = () => failed(request.error ?? new Error(t("the browser's database failed")));
    });
}

/** A request may be done and its transaction fail: where there is no room, it is told only then. */
function committed(transaction: IDBTransaction): Promise<void> {
    return new Promise((done, failed) => {
        transaction.addEventListener("complete", () => done());
        transaction.addEventListener("abort", () => failed(transaction.error ?? new Error(t("the browser's database failed"))));
    });
}

async function entries(mode: IDBTransactionMode): Promise<IDBObjectStore> {
    const opening = indexedDB.open(NAME, 1);
    opening.onupgradeneeded = () => opening.result.createObjectStore("files", { keyPath: "key" });
    const database = await finished(opening);
    const transaction = database.transaction("files", mode);
    transaction.oncomplete = transaction.onabort = () => database.close();
    return transaction.objectStore("files");
}

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
        const store = await entries("readwrite");
        const written = committed(store.transaction);
        const entry: Entry = { key, bytes };
        store.put(entry);
        const listing = store.getAllKeys();
        listing.onsuccess = () => {
            for (const old of unneeded(listing.result as string[], used)) store.delete(old);
        };
        await written;
    } catch {
        brief.add(key);
    }
    return key;
}

export async function kept(key: string): Promise<Uint8Array | null> {
    const known = here.get(key);
    if (known) return known;
    try {
        const entry = (await finished((await entries("readonly")).get(key))) as Entry | undefined;
        if (!entry) return null;
        here.set(key, entry.bytes);
        return entry.bytes;
    } catch {
        return null;
    }
}

export async function remove(key: string) {
    here.delete(key);
    try {
        (await entries("readwrite")).delete(key);
    } catch {
        // Then it was not kept.
    }
}

/** Several files one after the other, as a request holds them. */
export async function joined(files: File[]): Promise<Uint8Array> {
    return new Uint8Array(await new Blob(files).arrayBuffer());
}
