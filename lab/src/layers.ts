// What is drawn over the people of a run: where they came from, and the forces between them.

import { signal } from "@preact/signals";
import { round } from "./colour";
import type { Film } from "./film";
import { t } from "./language";
import { Latest } from "./latest";
import type { View } from "./view";

/** Seconds that a trail goes back. */
const TRAIL = 2;
/** Parts of a trail, each paler than the one after it. */
const AGES = 8;
const MOST_SEGMENTS = 50_000;

function colour(context: CanvasRenderingContext2D, name: string) {
    return getComputedStyle(context.canvas).getPropertyValue(name);
}

/** Which frames trails are of: each, every second, … so that there are not too many segments. */
function strideOf({ scene }: Film): number {
    return Math.max(1, Math.ceil((scene.agents.length * Math.round(TRAIL / scene.step)) / MOST_SEGMENTS));
}

/** What trails leave out; empty if nothing. */
export function trailsNote(film: Film): string {
    const stride = strideOf(film);
    return stride > 1 ? t("There are many people: trails show one frame of {stride}.", { stride }) : "";
}

/** Lines from where everybody was in the last two seconds. */
export function paintTrails(context: CanvasRenderingContext2D, film: Film, shown: number, view: View) {
    const { scene, frames } = film;
    const people = scene.agents.length;
    const back = Math.min(shown, Math.round(TRAIL / scene.step));
    if (back < 1) return;
    const stride = strideOf(film);
    // Multiples of the stride: a thinned trail does not flicker.
    const first = Math.ceil((shown - back) / stride) * stride;
    const places: number[] = [];
    for (let k = first; k < shown; k += stride) places.push(k);
    places.push(shown);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.strokeStyle = colour(context, "--ink");
    context.lineWidth = Math.max(1, 0.02 * view.scale);
    context.lineJoin = "round";
    for (let age = 0; age < AGES; age++) {
        const from = Math.floor((age * (places.length - 1)) / AGES);
        const to = Math.floor(((age + 1) * (places.length - 1)) / AGES);
        if (from === to) continue;
        context.globalAlpha = (0.7 * (age + 1)) / AGES;
        context.beginPath();
        for (let a = 0; a < people; a++) {
            for (let j = from; j <= to; j++) {
                const x = view.x + view.scale * frames.number(places[j]!, a, 0);
                const y = view.y - view.scale * frames.number(places[j]!, a, 1);
                if (j === from) context.moveTo(x, y);
                else context.lineTo(x, y);
            }
        }
        context.stroke();
    }
    context.globalAlpha = 1;
    // As it was: what is drawn later would have round corners, too, as long as the picture lives.
    context.lineJoin = "miter";
}

/** Numbers of a touching pair: where the line begins and ends, and the normal force in N. */
const PAIR = 5;
/** Width of the widest line, in m. */
const WIDEST = 0.15;

/** Force chains: a line for each two that touch, as wide as the force is large. */
export class Chains {
    #pairs = signal<Float64Array>(new Float64Array());
    #now = signal(0);
    /** The force of a line of the greatest width. */
    #scale = 0;
    #there = -1;
    #asked = new Latest<number>(async (k) => {
        const { film } = this;
        if (film.over || k === this.#there) return;
        try {
            const { bytes } = await film.client.ask({ ask: "forces", run: film.scene.run, time: k * film.scene.step }, film.frames.copy(k, k + 1));
            this.#show(new Float64Array(bytes));
        } catch {
            // The run is over, or another request says what is wrong with it. Forces of another frame would be wrong.
            this.#show(new Float64Array());
        }
        this.#there = k;
    });

    constructor(readonly film: Film) {}

    /** The force of the widest line that is shown, in N; 0 where nothing presses. */
    get largest() {
        return this.#now.value;
    }

    /** Asks for the forces of a frame, one frame after the other. Who paints is told by a signal. */
    update(shown: number) {
        if (shown !== this.#there) void this.#asked.want(shown);
    }

    #show(pairs: Float64Array) {
        let largest = 0;
        for (let at = PAIR - 1; at < pairs.length; at += PAIR) largest = Math.max(largest, pairs[at]!);
        // The same width is the same force throughout a run, unless forces grow.
        if (largest > this.#scale) this.#scale = round(largest);
        this.#now.value = largest;
        this.#pairs.value = pairs;
    }

    paint(context: CanvasRenderingContext2D, view: View) {
        const pairs = this.#pairs.value;
        context.setTransform(1, 0, 0, 1, 0, 0);
        context.strokeStyle = colour(context, "--mark");
        context.lineCap = "round";
        for (let at = 0; at < pairs.length; at += PAIR) {
            context.lineWidth = (WIDEST * view.scale * pairs[at + 4]!) / this.#scale;
            context.beginPath();
            context.moveTo(view.x + view.scale * pairs[at]!, view.y - view.scale * pairs[at + 1]!);
            context.lineTo(view.x + view.scale * pairs[at + 2]!, view.y - view.scale * pairs[at + 3]!);
            context.stroke();
        }
        context.lineCap = "butt";
    }
}
