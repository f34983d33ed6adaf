// The canvas of a run as a picture that explains itself: on paper, with the time and what the colours mean.

import { type ByPlace, byPlace, type Kind, mapKind } from "./byplace";
import { type Scale, scaleOf } from "./colour";
import type { Film } from "./film";
import { about, fixed, t } from "./language";
import { kindWords } from "./kindwords";
import { empty } from "./layout";
import { digits, length } from "./parts";
import { plan } from "./plan";
import { heightOf } from "./sections";

/** Height of the line below the picture, for a screen with one pixel per pixel of CSS. */
const FOOT = 30;

/** Draws the map alone: people are of one moment, and the map of a time. */
export function composeMap(onto: HTMLCanvasElement, from: HTMLCanvasElement, places: ByPlace, kind: Kind) {
    empty.value = true;
    let begun: ReturnType<typeof begin>;
    try {
        begun = begin(onto, from, 3);
    } finally {
        empty.value = false;
    }
    const { context, width, line, ink } = begun;
    const write = (words: string, k: number) => context.fillText(words, 10 * devicePixelRatio, line(k));
    write(places.words(), 0);
    write(places.cells(), 1);
    row(context, "", places.scale(kind), width, line(2), ink);
}

/** Draws it on another canvas, which becomes as large as it needs to be (with even sides: movies ask for it). */
export function compose(onto: HTMLCanvasElement, from: HTMLCanvasElement, film: Film) {
    const [kind, places] = [mapKind.value, byPlace.value];
    const map = kind && places?.filled.value ? places : null;
    const { context, width, line, ink } = begin(onto, from, map ? 2 : 1);
    const { colour, unit } = plan.value;
    const height = heightOf(film);
    const at = height === null ? "" : `, ${t("{length} above the ground", { length: length(height, unit) })}`;
    const time = `${fixed(film.place.value * film.scene.step, 2)} s${at}`;
    row(context, map ? t("People at {time}", { time }) : time, scaleOf(film, colour), width, line(0), ink);
    if (map) row(context, map.words(), map.scale(kind!), width, line(1), ink);
}

/** The picture on paper, with room for lines below it. */
function begin(onto: HTMLCanvasElement, from: HTMLCanvasElement, lines: number) {
    // Not its own size: it may be coarser while something moves.
    const pixel = devicePixelRatio;
    const even = (size: number) => 2 * Math.ceil(size / 2);
    const [wide, high] = [from.clientWidth * pixel, from.clientHeight * pixel];
    const [width, height] = [even(wide), even(high + lines * FOOT * pixel)];
    // Setting them clears the canvas and costs time.
    if (onto.width !== width || onto.height !== height) [onto.width, onto.height] = [width, height];
    const context = onto.getContext("2d")!;
    const style = getComputedStyle(from);
    const [ink, paper] = [style.getPropertyValue("--ink"), style.getPropertyValue("--paper")];
    context.fillStyle = paper;
    context.fillRect(0, 0, width, height);
    context.drawImage(from, 0, 0, wide, high);
    const line = (k: number) => high + (k + 0.5) * FOOT * pixel;
    context.font = `${13 * pixel}px system-ui, sans-serif`;
    context.textBaseline = "middle";
    context.fillStyle = ink;
    return { context, width, line, ink };
}

/** A line below the picture: words, and a scale or kinds. */
function row(context: CanvasRenderingContext2D, words: string, { label, unit, low, high: most, largest, ramp: colours, kinds }: Scale, width: number, middle: number, ink: string) {
    const pixel = devicePixelRatio;
    context.fillText(words, 10 * pixel, middle);
    if (kinds) return paintKinds(context, kinds.map(({ name, shade }) => [kindWords(name), shade.fill]), width - 10 * pixel, middle, context.measureText(words).width + 20 * pixel, pixel, ink);
    const end = `${largest > most ? "≥ " : ""}${digits(most, 3)} ${unit}`.trim();
    let right = width - 10 * pixel - context.measureText(end).width;
    context.fillText(end, right, middle);
    const ramp = Math.min(120 * pixel, width / 4);
    right -= ramp + 8 * pixel;
    colours.forEach((colour, k) => {
        context.fillStyle = colour;
        context.fillRect(right + (k * ramp) / colours.length, middle - 6 * pixel, ramp / colours.length + 1, 12 * pixel);
    });
    const begin = about(label, low > 0 ? `≤ ${low}` : 0);
    context.fillStyle = ink;
    right -= context.measureText(begin).width + 8 * pixel;
    if (right > context.measureText(words).width + 20 * pixel) context.fillText(begin, right, middle);
}

/** Names of kinds with their colours, from the right; those for which there is room. */
function paintKinds(context: CanvasRenderingContext2D, kinds: [string, string][], right: number, middle: number, least: number, pixel: number, ink: string) {
    for (const [name, colour] of kinds.toReversed()) {
        const wide = context.measureText(name).width + 22 * pixel;
        if (right - wide < least) return;
        right -= wide;
        context.fillStyle = colour;
        context.fillRect(right, middle - 5 * pixel, 10 * pixel, 10 * pixel);
        context.fillStyle = ink;
        context.fillText(name, right + 14 * pixel, middle);
    }
}

/** A picture that one of the above draws. */
export async function png(draw: (onto: HTMLCanvasElement) => void): Promise<Blob> {
    const canvas = document.createElement("canvas");
    draw(canvas);
    const blob = await new Promise<Blob | null>((done) => canvas.toBlob(done, "image/png"));
    if (!blob) throw new Error(t("the browser made no picture"));
    return blob;
}
