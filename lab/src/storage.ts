// The browser's storage.

const asked = new URLSearchParams(location.search);
const phone = matchMedia("(pointer: coarse) and (max-width: 50rem), (pointer: coarse) and (max-height: 30rem)").matches;

/** Whether another page shows the scene (`?embed`). */
export const embedded = asked.has("embed");
/** Whether a scene is only looked at: a link with `?view`, and any on a phone but `?lab`. Then nothing of the visitor's is read or
 * written, and the link stays in the address. */
export const viewed = embedded || asked.has("view") || (phone && location.hash.length > 1 && !asked.has("lab"));

/** The browser's storage; none where it is forbidden. */
export function storage(kind: "localStorage" | "sessionStorage"): Storage | null {
    if (viewed) return null;
    try {
        return window[kind];
    } catch {
        return null;
    }
}
