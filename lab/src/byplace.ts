// Density and squeeze by place, over a time of a run. The lab sums them up; here are the frames.

import { computed, signal } from "@preact/signals";
import type { Client } from "./client";
import { averaged, colourOf, isForce, meanWords, round, type Scale, shade, FROM_GREY, VIRIDIS } from "./colour";
import { table } from "./csv";
import { circle, type Inks, label, strokes } from "./draw";
import type { Film } from "./film";
import { count, type Plain, t } from "./language";
import { digits } from "./parts";
import { plan, type Plan } from "./plan";
import { COLUMNS, type Grid, type Point } from "./protocol";
import { toMetres, toPixels, type View } from "./view";

/** Places of people in an answer: the page plays meanwhile. The density costs more, because of its kernel. */
const AT_ONCE = { density: 2000, squeeze: 50_000 };
/** Places of people in a map of the density: with more, it has only every second frame, or every fourth, … */
const MOST = 200_000;

/** Colours of a map, besides the first one. */
const SHADES = 128;

export type Kind = Exclude<Plan["map"], "none">;

interface Filled {
    grid: Grid;
    /** Density, or mean, greatest and count. */
    values: Float64Array[];
    /** The first frame, the last one, and how many. */
    first: number;
    last: number;
    frames: number;
    stride: number;
}

export class ByPlace {
    readonly filled = signal<Filled | null>(null);
    readonly refused = signal("");
    /** The map of a run beside it, which has the same colours. */
    readonly beside = signal<ByPlace | null>(null);
    /** Whether frames are missing in it that are there. */
    readonly busy = signal(false);
    /** What a map that can go on was made of, and the frame that is next. */
    #of = "";
    #wanted: Plan["span"] = [null, null];
    #next = 0;
    #asking = false;
    /** The lab has one map of a run: it belongs to another one now. */
    #ended = false;
    /** The greatest number of these. */
    #largest: { of: Float64Array; value: number } = { of: new Float64Array(), value: 0 };
    #image: { of: Float64Array; high: number; ramp: Scale["ramp"]; canvas: HTMLCanvasElement } | null = null;

    constructor(
        readonly client: Client,
        readonly film: Film,
        readonly quantity: "density" | "squeeze",
        /** The run, if the lab of this client knows it by another number. */
        readonly run = film.scene.run,
        /** In s: no further than a run that it is compared with. */
        readonly until = () => Infinity,
    ) {}

    /** Frames that are wanted and there; those of squeeze have steps before them. */
    #span(): [number, number] {
        const { step } = this.film.scene;
        const [from, to] = this.#wanted;
        const first = Math.max(this.quantity === "density" ? 0 : 1, Math.ceil((from ?? 0) / step - 1e-6));
        const last = Math.min(this.film.frames.count - 1, Math.floor(Math.min(to ?? Infinity, this.until()) / step + 1e-6));
        return [first, last];
    }

    /** So that the map has not too many places: a power of two, because the run goes on. */
    #stride(first: number, last: number): number {
        if (this.quantity === "squeeze") return 1;
        const places = this.film.scene.agents.length * (last - first + 1);
        return 2 ** Math.max(0, Math.ceil(Math.log2(places / MOST)));
    }

    /** Asks for no more. */
    end() {
        this.#ended = true;
    }

    get #over() {
        return this.#ended || (this.client === this.film.client && this.film.over);
    }

    /** Adds frames that came since; begins anew if another time is wanted, also after one was refused. */
    async follow(span: Plan["span"]) {
        const again = JSON.stringify(span) !== JSON.stringify(this.#wanted);
        this.#wanted = span;
        if (this.#asking || this.#over || (this.refused.peek() && !again)) return;
        this.#asking = true;
        this.refused.value = "";
        try {
            while (!this.#over) {
                const [first, last] = this.#span();
                const stride = this.#stride(first, last);
                const of = `${first} ${this.#wanted[1]} ${stride} ${this.quantity === "squeeze" ? averaged(this.film) : ""}`;
                const fresh = of !== this.#of;
                if (last < first) {
                    this.filled.value = null;
                    this.#of = "";
                    break;
                }
                if (fresh) [this.#of, this.#next] = [of, first];
                else if (this.#next > last) break;
                this.busy.value = true;
                await this.#ask(fresh, first, last, stride);
            }
        } catch (error) {
            // What the lab has of it is not known.
            this.#of = "";
            if (!this.#over) this.refused.value = (error as Error).message;
        } finally {
            this.#asking = false;
            this.busy.value = false;
        }
    }

    async #ask(fresh: boolean, first: number, last: number, stride: number) {
        const { frames, scene } = this.film;
        const people = scene.agents.length;
        const most = Math.max(1, Math.floor(AT_ONCE[this.quantity] / people));
        const count = Math.min(most, Math.floor((last - this.#next) / stride) + 1);
        const numbers = new Float64Array(3 * people * count);
        for (let j = 0; j < count; j++) {
            const k = this.#next + j * stride;
            const squeeze = this.quantity === "squeeze" ? frames.means(k, averaged(this.film)) : null;
            const frame = frames.frame(k);
            for (let a = 0; a < people; a++) {
                const at = 3 * (j * people + a);
                numbers[at] = frame[COLUMNS * a]!;
                numbers[at + 1] = frame[COLUMNS * a + 1]!;
                numbers[at + 2] = squeeze?.[a] ?? 0;
            }
        }
        const { value, bytes } = await this.client.ask<Grid>({ ask: "map", run: this.run, of: this.quantity, fresh }, new Uint8Array(numbers.buffer));
        this.#next += count * stride;
        const all = new Float64Array(bytes);
        const cells = value.columns * value.rows;
        const values = Array.from({ length: all.length / cells }, (_, k) => all.subarray(k * cells, (k + 1) * cells));
        this.filled.value = { grid: value, values, first, last: this.#next - stride, frames: (this.#next - first) / stride, stride };
    }

    /** What the map shows of a cell: not a number where nobody was. */
    numbers(kind: Kind): Float64Array {
        return this.filled.value?.values[kind === "greatest" ? 1 : 0] ?? new Float64Array();
    }

    #most(kind: Kind): number {
        const numbers = this.numbers(kind);
        if (this.#largest.of !== numbers) this.#largest = { of: numbers, value: numbers.reduce((one, other) => (other > one ? other : one), 0) };
        return this.#largest.value;
    }

    /** A ramp has one meaning at a time: the map has that which people do not have. */
    scale(kind: Kind): Scale {
        const other = this.beside.value;
        const largest = Math.max(this.#most(kind), other ? other.#most(kind) : 0);
        const density = kind === "density";
        return { label: t(NAMES[kind]), unit: density ? t("per m²") : "N", low: 0, high: round(largest || 1), largest, ramp: isForce(colourOf(this.film, plan.value.colour)) ? VIRIDIS : FROM_GREY.light };
    }

    /** The value at a place. */
    at(kind: Kind, [x, y]: Point): number {
        const grid = this.filled.value?.grid;
        if (!grid) return NaN;
        const { low, cell, columns, rows } = grid;
        const [column, row] = [Math.floor((x - low[0]) / cell[0] + 0.5), Math.floor((y - low[1]) / cell[1] + 0.5)];
        return column < 0 || row < 0 || column >= columns || row >= rows ? NaN : this.numbers(kind)[row * columns + column]!;
    }

    /** Of which time it is a mean, in words. */
    words(): string {
        const filled = this.filled.value;
        if (!filled) return t("no frames in this time");
        const { first, last, frames, stride } = filled;
        const time = (k: number) => Number((k * this.film.scene.step).toPrecision(6));
        const every = stride > 1 ? t(", one of {stride}", { stride }) : "";
        const squeeze = this.quantity === "squeeze" ? t(". Squeeze: {mean}", { mean: meanWords(this.film) }) : "";
        const span = { from: time(first), to: time(last) };
        return `${count(frames, "{n} frame", "{n} frames")} ${t("from {from} to {to} s", span)}${every}${squeeze}`;
    }

    /** How large its cells are, in words. */
    cells(): string {
        const [wide, high] = this.filled.value!.grid.cell.map((size) => Number(size.toPrecision(3))) as [number, number];
        return t("cells of {wide} m × {high} m", { wide, high });
    }

    #painted(kind: Kind, scale: Scale): HTMLCanvasElement | null {
        const filled = this.filled.value;
        if (!filled) return null;
        const values = this.numbers(kind);
        if (this.#image?.of === values && this.#image.high === scale.high && this.#image.ramp === scale.ramp) return this.#image.canvas;
        const { columns, rows } = filled.grid;
        const canvas = document.createElement("canvas");
        [canvas.width, canvas.height] = [columns, rows];
        const context = canvas.getContext("2d")!;
        const image = context.createImageData(columns, rows);
        const ink = (share: number) => [...shade(scale, share * scale.high).fill.match(/\d+/g)!.map(Number), 255];
        const inks = Array.from({ length: SHADES + 1 }, (_, k) => ink(k / SHADES));
        const pixels = image.data;
        for (let k = 0; k < values.length; k++) {
            const value = values[k]!;
            if (Number.isNaN(value)) continue;
            const parts = inks[Math.round(Math.min(1, value / scale.high) * SHADES)]!;
            // The first row of an image is the upper one.
            const at = 4 * ((rows - 1 - Math.floor(k / columns)) * columns + (k % columns));
            for (let part = 0; part < 4; part++) pixels[at + part] = parts[part]!;
        }
        context.putImageData(image, 0, 0);
        this.#image = { of: values, high: scale.high, ramp: scale.ramp, canvas };
        return canvas;
    }

    paint(kind: Kind, context: CanvasRenderingContext2D, view: View, scale = this.scale(kind)) {
        const image = this.#painted(kind, scale);
        if (!image) return;
        const { low, cell, columns, rows } = this.filled.value!.grid;
        context.setTransform(1, 0, 0, 1, 0, 0);
        // The density is smooth; cells of squeeze are what was counted.
        context.imageSmoothingEnabled = this.quantity === "density";
        const [left, top] = [low[0] - cell[0] / 2, low[1] + (rows - 0.5) * cell[1]];
        context.drawImage(image, view.x + view.scale * left, view.y - view.scale * top, view.scale * columns * cell[0], view.scale * rows * cell[1]);
        context.imageSmoothingEnabled = true;
    }

    /** The middle of the cell with the greatest value; null if there is none above 0. */
    most(kind: Kind): Point | null {
        const { largest } = this.scale(kind);
        const k = largest > 0 ? this.numbers(kind).indexOf(largest) : -1;
        if (k < 0) return null;
        const { low, cell, columns } = this.filled.value!.grid;
        return [low[0] + cell[0] * (k % columns), low[1] + cell[1] * Math.floor(k / columns)];
    }

    /** Marks that cell, with its value. */
    paintMost(kind: Kind, context: CanvasRenderingContext2D, view: View, inks: Inks) {
        const at = this.most(kind);
        if (!at) return;
        const { unit, largest } = this.scale(kind);
        const [x, y] = toPixels(view, at);
        const size = 7 * devicePixelRatio;
        context.setTransform(1, 0, 0, 1, 0, 0);
        circle(context, [x, y], size);
        strokes(context, [[inks.paper, 4 * devicePixelRatio], [inks.ink, 2 * devicePixelRatio]]);
        const side = y < 4 * size ? 1 : -1;
        label(context, `${digits(largest, 3)} ${unit}`, toMetres(view, x, y + side * 2.4 * size), view, inks);
    }

    /** A row for each cell, from the lowest; of squeeze for those where somebody was. */
    csv(): string {
        const { grid, values } = this.filled.value!;
        const { low, cell, columns } = grid;
        const over = this.quantity === "density" ? "" : `_of_means_of_${Number((averaged(this.film) * this.film.scene.step).toPrecision(6))}_s`;
        const names = this.quantity === "density" ? ["density [1/m²]"] : [`mean_squeeze${over} [N]`, `greatest_squeeze${over} [N]`, "values"];
        const rows: (string | number)[][] = [["x [m]", "y [m]", ...names]];
        const place = (from: number, size: number, k: number) => Number((from + k * size).toPrecision(9));
        for (let k = 0; k < values[0]!.length; k++) {
            if (Number.isNaN(values[0]![k]!)) continue;
            rows.push([place(low[0], cell[0], k % columns), place(low[1], cell[1], Math.floor(k / columns)), ...values.map((of) => of[k]!)]);
        }
        return table(rows);
    }
}

export const NAMES: Record<Kind, Plain> = { density: "Density", mean: "Mean squeeze", greatest: "Greatest squeeze" };

/** The map of the film on the stage, if one is shown. */
export const byPlace = signal<ByPlace | null>(null);
export const mapKind = computed<Kind | null>(() => (plan.value.map === "none" || plan.value.view === "3d" ? null : plan.value.map));
/** Where the mouse is on the picture. */
export const pointed = signal<Point | null>(null);
