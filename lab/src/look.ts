// What part of the plane the pictures show: the same part side by side.

import { effect, signal } from "@preact/signals";
import { canvas } from "./layout";
import { bases } from "./session";
import { type View, zoomed } from "./view";

export const view = signal<View>({ scale: 1, x: 0, y: 0 });
/** All is kept visible until the user zooms or moves the picture. */
export const fits = signal(true);

export function fit() {
    fits.value = true;
}

export function look(next: View) {
    fits.value = false;
    view.value = next;
}

export function zoom(by: number) {
    const on = canvas.value;
    if (on) look(zoomed(view.value, by, on.width / 2, on.height / 2));
}

/** Zooms where the wheel turns. */
function wheel(event: WheelEvent) {
    // The page must not scroll at the same time.
    event.preventDefault();
    look(zoomed(view.value, Math.exp(-0.0015 * event.deltaY * (event.deltaMode ? 30 : 1)), event.offsetX * devicePixelRatio, event.offsetY * devicePixelRatio));
}

/** Keeps a canvas as fine as its pixels, and hears the wheel on it. Its size or its colours are others where it calls. Returns what
 * ends it. */
export function fitted(on: HTMLCanvasElement, changed: () => void): () => void {
    const measure = () => {
        [on.width, on.height] = [Math.round(on.clientWidth * devicePixelRatio), Math.round(on.clientHeight * devicePixelRatio)];
        changed();
    };
    const observer = new ResizeObserver(measure);
    observer.observe(on);
    const scheme = matchMedia("(prefers-color-scheme: dark)");
    scheme.addEventListener("change", measure);
    on.addEventListener("wheel", wheel, { passive: false });
    return () => {
        observer.disconnect();
        scheme.removeEventListener("change", measure);
        on.removeEventListener("wheel", wheel);
    };
}

// Another scene is seen as a whole at first.
effect(() => {
    bases.value;
    fits.value = true;
});
