// What the colours say: which number, and from what to how much.

import { signal } from "@preact/signals";
import type { Film } from "./film";
import { t } from "./language";
import { SQUEEZE } from "./frames";
import { type Colour, plan } from "./plan";
import { CHEST, COLUMNS, LEVELS } from "./protocol";
import { heightOf, levelAt } from "./sections";

/** Colours of a scale, from its low end, equidistant. */
export type Ramp = readonly string[];

/** viridis (Smith, van der Walt). */
export const VIRIDIS: Ramp = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];
/** A warm grey, then magma by the same authors; on dark ground from its dark part to its bright end. As crates/picture has
 * them: a test there compares. */
export const FROM_GREY: Record<"light" | "dark", Ramp> = {
    light: ["#dcd6cb", "#feb57d", "#fd9c6c", "#fa8461", "#f46b5d", "#e95562", "#d8466b", "#c43c74", "#af357b", "#992e80", "#832682", "#6e1e81", "#5a167e", "#441074", "#2e1161", "#1a1042"],
    dark: ["#7a7268", "#d4446d", "#df4c68", "#e95562", "#f0615f", "#f56e5d", "#f97c5f", "#fb8b63", "#fd996a", "#fea873", "#feb67d", "#fec489", "#fed395", "#fde1a2", "#fdefb1", "#fcfdbf"],
};

const scheme = matchMedia("(prefers-color-scheme: dark)");
export const dark = signal(scheme.matches);
scheme.addEventListener("change", () => (dark.value = scheme.matches));

/** Between them, finely. */
const FINE = 128;

export interface Shade {
    fill: string;
    /** Unlike the colour inside, so that people who touch are told apart. */
    rim: string;
}

const known = new Map<Ramp, Shade[]>();

function shadesOf(ramp: Ramp): Shade[] {
    const found = known.get(ramp);
    if (found) return found;
    const shades = Array.from({ length: FINE + 1 }, (_, k) => {
        const place = (k / FINE) * (ramp.length - 1);
        const low = Math.min(ramp.length - 2, Math.floor(place));
        const mixed = [1, 3, 5].map((at) => {
            const [from, to] = [part(ramp[low]!, at), part(ramp[low + 1]!, at)];
            return Math.round(from + (place - low) * (to - from));
        }) as [number, number, number];
        return shadeOf(mixed);
    });
    known.set(ramp, shades);
    return shades;
}

/** Of a kind, and of what is of none, light and dark: as crates/picture has them (its `Palette`). */
const KINDS: Record<"light" | "dark", { colours: string[]; paper: string; none: string }> = {
    light: { colours: ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#3a4350"], paper: "#ffffff", none: "#b9c2cf" },
    dark: { colours: ["#4095c8", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#c4ccd8"], paper: "#12161d", none: "#6a7482" },
};

const part = (text: string, at: number) => Number.parseInt(text.slice(at, at + 2), 16);

const parts = (text: string) => [1, 3, 5].map((at) => part(text, at)) as [number, number, number];

function shadeOf([red, green, blue]: [number, number, number]): Shade {
    return { fill: `rgb(${red} ${green} ${blue})`, rim: 0.299 * red + 0.587 * green + 0.114 * blue < 130 ? "#ffffff" : "#1b1b1b" };
}

/** The colour of the k-th kind: after seven, paler ones follow. Below 0: of no kind. */
export function kindShade(k: number): Shade {
    const { colours, paper, none } = KINDS[dark.value ? "dark" : "light"];
    if (k < 0) return shadeOf(parts(none));
    const colour = parts(colours[k % colours.length]!);
    const ground = parts(paper);
    return shadeOf(k < colours.length ? colour : (colour.map((one, j) => Math.round((one + ground[j]!) / 2)) as typeof colour));
}

/** Things look the same whatever colours say of people: metal, and luggage. */
export const THINGS: Record<"frame" | "luggage", string> = { frame: "#7d8794", luggage: "#946c43" };

/** The kinds of the people of a scene, in the order of their names. */
export function kindsOf({ scene }: Film): string[] {
    return [...new Set(scene.agents.flatMap(({ kind }) => kind ?? []))].sort();
}

/** Whether there are numbers for it. */
export function isKnown(film: Film, colour: Colour): boolean {
    const { chests, levels } = film.scene;
    if (colour === "kind") return kindsOf(film).length > 0;
    if (colour === "level") return levels.length > 1;
    return chests || (colour !== "chest" && colour !== "compression");
}

/** What is coloured: as chosen, unless there is nothing of it. */
export function colourOf(film: Film, colour: Colour): Colour {
    return isKnown(film, colour) ? colour : "squeeze";
}

export interface Scale {
    /** Kinds of people instead of numbers, with the colour of each. */
    kinds?: { name: string; count: number; shade: Shade }[];
    label: string;
    unit: string;
    /** At and below it, people have the first colour. */
    low: number;
    /** At and above it, they have the last one. */
    high: number;
    /** The largest value so far. */
    largest: number;
    ramp: Ramp;
}

/** The colour of a value; of none, if it is no number. */
export function shade({ low, high, ramp, kinds }: Scale, value: number): Shade {
    if (kinds || Number.isNaN(value)) return kinds?.[value]?.shade ?? kindShade(-1);
    const share = (value - low) / (high - low);
    return shadesOf(ramp)[Math.round(Math.max(0, Math.min(1, share)) * FINE)]!;
}

/** Frames over which squeeze is a mean: single communication steps flicker. */
export function averaged({ scene: { step } }: Film) {
    return Math.max(1, Math.round(plan.value.smooth / step));
}

/** The time over which the squeeze is a mean really: whole communication steps, at the start of a run fewer. */
export function meanWords(film: Film, k = Infinity) {
    const steps = Math.max(1, Math.min(k, averaged(film)));
    const seconds = Number((steps * film.scene.step).toPrecision(6));
    return steps === 1 ? t("mean of 1 step ({seconds} s)", { seconds }) : t("mean of {seconds} s", { seconds });
}

/** Name and unit, the low end, and what no automatic scale's high end goes below. */
const SCALES: Record<Exclude<Colour, "kind">, [string, string, number, number]> = {
    speed: [t("Speed"), "m/s", 0, 0.5],
    squeeze: [t("Squeeze"), "N", 200, 400],
    contacts: [t("Contacts"), "", 0, 4],
    chest: [t("Load on the chest"), "N", 200, 400],
    compression: [t("Chest, front–back"), "N", 100, 200],
    level: [t("Squeeze by level"), "N", 200, 400],
};
/** Means of forces, and their columns. A level, and a chest in it, has its part of the ends. */
const FORCES: Partial<Record<Colour, number>> = { squeeze: SQUEEZE, chest: CHEST, compression: CHEST + 2, level: LEVELS };
export const isForce = (colour: Colour) => colour in FORCES;
/** The column of a frame. */
const CONTACTS = 7;
/** The automatic scale ends at this quantile of all values that are not 0, of people and frames. */
export const QUANTILE = 0.98;

/** A round value that is not below: one of some factors times a power of ten. */
export function round(value: number, factors = [1, 1.5, 2, 3, 4, 5, 6, 8]) {
    const size = 10 ** Math.floor(Math.log10(value));
    return size * (factors.find((factor) => factor * size >= value) ?? 10);
}

/** What is coloured of each person, in a frame; of levels the one that is drawn, or the greatest. */
export function values(film: Film, k: number, wanted: Colour): Float64Array {
    const colour = colourOf(film, wanted);
    if (colour === "kind") {
        const kinds = kindsOf(film);
        return Float64Array.from(film.scene.agents, ({ kind }) => (kind === null ? -1 : kinds.indexOf(kind)));
    }
    if (colour === "level") {
        const levels = byPart(film, k, colour);
        const at = levelAt(film, heightOf(film) ?? -1);
        return levels[at] ?? levels[0]!.map((_, a) => Math.max(...levels.map((level) => level[a]!)));
    }
    if (isForce(colour)) return film.frames.means(k, averaged(film), FORCES[colour]);
    const frame = film.frames.frame(k);
    const count = film.scene.agents.length;
    const found = new Float64Array(count);
    for (let a = 0; a < count; a++) {
        const at = COLUMNS * a;
        found[a] = colour === "speed" ? Math.hypot(frame[at + 3]!, frame[at + 4]!) : frame[at + CONTACTS]!;
    }
    return found;
}

/** The same; of levels, those of each. */
export function byPart(film: Film, k: number, wanted: Colour): Float64Array[] {
    if (colourOf(film, wanted) !== "level") return [values(film, k, wanted)];
    return film.scene.levels.map((_, level) => film.frames.means(k, averaged(film), LEVELS + level));
}

/** How often values were: counts in bins whose width grows with the value, by 2 %. */
class Spread {
    static readonly #PER_OCTAVE = 32;
    static readonly #FIRST = -10;
    #counts = new Float64Array(40 * Spread.#PER_OCTAVE);
    #count = 0;
    /** Frames that were looked at. */
    #seen = 0;
    largest = 0;

    add(film: Film, colour: Colour, computed: number) {
        for (; this.#seen < computed; this.#seen++) {
            for (const of of byPart(film, this.#seen, colour)) for (const value of of) this.#add(value);
        }
    }

    #add(value: number) {
        // Also of those who have left, it is no number.
        if (!(value > 0)) return;
        if (value > this.largest) this.largest = value;
        const bin = Math.floor((Math.log2(value) - Spread.#FIRST) * Spread.#PER_OCTAVE);
        this.#counts[Math.max(0, Math.min(bin, this.#counts.length - 1))]! += 1;
        this.#count += 1;
    }

    /** The upper end of the bin in which the quantile is. */
    quantile(share: number): number {
        let left = Math.ceil(share * this.#count - 1e-6);
        const bin = this.#counts.findIndex((count) => (left -= count) <= 0);
        return this.#count === 0 ? 0 : Math.min(this.largest, 2 ** (Spread.#FIRST + (bin + 1) / Spread.#PER_OCTAVE));
    }
}

const spreads = new WeakMap<Film, Map<string, Spread>>();

function spreadOf(film: Film, colour: Colour): Spread {
    const of = spreads.get(film) ?? new Map<string, Spread>();
    spreads.set(film, of);
    const key = `${colour} ${isForce(colour) ? plan.value.smooth : ""}`;
    const spread = of.get(key) ?? new Spread();
    of.set(key, spread);
    spread.add(film, colour, film.computed.value);
    return spread;
}

/** As the user has fixed it, or up to the quantile of the run so far. */
export function scaleOf(film: Film, wanted: Colour): Scale {
    const colour = colourOf(film, wanted);
    if (colour === "kind") {
        const count = (name: string) => film.scene.agents.filter(({ kind }) => kind === name).length;
        const kinds = kindsOf(film).map((name, k) => ({ name, count: count(name), shade: kindShade(k) }));
        return { kinds, label: t("Kind"), unit: "", low: 0, high: kinds.length, largest: 0, ramp: kinds.map(({ shade }) => shade.fill) };
    }
    const [label, unit, whole, least] = SCALES[colour];
    const part = isForce(colour) && colour !== "squeeze" ? Math.max(1, film.scene.levels.length) : 1;
    const low = part > 1 ? round(whole / part) : whole;
    const spread = spreadOf(film, colour);
    const high = plan.value.most[colour] ?? round(Math.max(least / part, spread.quantile(QUANTILE)));
    const ramp = isForce(colour) ? FROM_GREY[dark.value ? "dark" : "light"] : VIRIDIS;
    return { label, unit, low: Math.min(low, high / 2), high, largest: spread.largest, ramp };
}
