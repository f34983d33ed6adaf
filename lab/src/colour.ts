// What the colours say: which number, and from nought to how much.

import type { Film } from "./film";
import { type Colour, plan } from "./plan";
import { COLUMNS } from "./protocol";

/** Colours of viridis (Smith, van der Walt), from low to high. */
export const COLOURS = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];

/** Between them, finely. */
const FINE = 128;
const SHADES = Array.from({ length: FINE + 1 }, (_, k) => {
    const place = (k / FINE) * (COLOURS.length - 1);
    const low = Math.min(COLOURS.length - 2, Math.floor(place));
    const part = (text: string, at: number) => Number.parseInt(text.slice(at, at + 2), 16);
    const mixed = [1, 3, 5].map((at) => {
        const [from, to] = [part(COLOURS[low]!, at), part(COLOURS[low + 1]!, at)];
        return Math.round(from + (place - low) * (to - from));
    });
    return `rgb(${mixed.join(" ")})`;
});

export function colourOf(share: number) {
    return SHADES[Math.round(Math.max(0, Math.min(1, share)) * FINE)]!;
}

export interface Scale {
    label: string;
    unit: string;
    /** Of a frame; a speed is that of columns 3 and 4 together. */
    column: number;
    /** What no automatic scale goes below. */
    least: number;
    /** Largest value of the colours. */
    most: number;
}

/** Squeeze is the mean over this time, in s: single communication steps flicker. */
export const SMOOTH = 0.1;

/** Over what the squeeze is a mean really: whole communication steps, at the start of a run fewer. */
export function meanWords(film: Film, k = Infinity) {
    const { step } = film.scene;
    const steps = Math.max(1, Math.min(k, Math.round(SMOOTH / step)));
    const seconds = `${Number((steps * step).toPrecision(6))} s`;
    return steps === 1 ? `mean of 1 step (${seconds})` : `mean of ${seconds}`;
}

const SCALES: Record<Colour, Omit<Scale, "most">> = {
    speed: { label: "Speed", unit: "m/s", column: 3, least: 0.5 },
    squeeze: { label: "Squeeze", unit: "N", column: 6, least: 100 },
    contacts: { label: "Contacts", unit: "", column: 7, least: 4 },
};

/** A round value that is not below. */
export function round(value: number) {
    const size = 10 ** Math.floor(Math.log10(value));
    const by = [1, 1.5, 2, 3, 4, 5, 6, 8].find((factor) => factor * size >= value) ?? 10;
    return by * size;
}

/** What is coloured of each person, in a frame. */
export function values(film: Film, k: number, colour: Colour): Float64Array {
    if (colour === "squeeze") return film.squeezeMean(k, SMOOTH);
    const frame = film.frame(k);
    const count = film.scene.agents.length;
    const found = new Float64Array(count);
    for (let a = 0; a < count; a++) {
        const at = COLUMNS * a;
        found[a] = colour === "speed" ? Math.hypot(frame[at + 3]!, frame[at + 4]!) : frame[at + SCALES.contacts.column]!;
    }
    return found;
}

/** The largest values of a run so far. Each frame is looked at once for each colour. */
class Largest {
    #seen: Record<Colour, number> = { speed: 0, squeeze: 0, contacts: 0 };
    #largest: Record<Colour, number> = { speed: 0, squeeze: 0, contacts: 0 };

    constructor(readonly film: Film) {}

    of(colour: Colour, computed: number): number {
        for (let k = this.#seen[colour]; k < computed; k++) {
            for (const value of values(this.film, k, colour)) {
                if (value > this.#largest[colour]) this.#largest[colour] = value;
            }
        }
        this.#seen[colour] = Math.max(computed, this.#seen[colour]);
        return this.#largest[colour];
    }
}

const known = new WeakMap<Film, Largest>();

/** The largest value so far. */
export function largest(film: Film, colour: Colour): number {
    const found = known.get(film) ?? new Largest(film);
    known.set(film, found);
    return found.of(colour, film.computed.value);
}

/** As the user has fixed it, or so that all values of the run so far fit. */
export function scaleOf(film: Film, colour: Colour): Scale {
    const scale = SCALES[colour];
    const fixed = plan.value.most[colour];
    return { ...scale, most: fixed ?? round(Math.max(scale.least, largest(film, colour))) };
}
