// The browser's storage.

/** Whether another page shows the stage alone (`?embed`). Then nothing of the visitor's is read or written. */
export const embedded = new URLSearchParams(location.search).has("embed");

/** The browser's storage; none where it is forbidden. */
export function storage(kind: "localStorage" | "sessionStorage"): Storage | null {
    if (embedded) return null;
    try {
        return window[kind];
    } catch {
        return null;
    }
}
