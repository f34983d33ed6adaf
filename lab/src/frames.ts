// The frames of a run, and the crowd's numbers over time. Numbers have the precision of a picture: tables and FMUs are
// computed again.

import { COLUMNS } from "./protocol";

/** Frames lie in blocks, so that long runs neither copy nor allocate for each frame. */
const BLOCK_BYTES = 4e6;
/** \[m\] Nobody walks further from a frame to the next one. */
const CARRIED = 1;
export const SQUEEZE = 6;
const CONTACTS = 7;
export const BY_WALLS = 8;

/** Curves of the whole crowd, one number for each frame. */
export const CURVES = ["speed", "squeeze", "greatest", "contacts", "left"] as const;
export type Curve = (typeof CURVES)[number];

export class Frames {
    /** How many there are. */
    count = 0;
    /** How many numbers a frame has, and how many with those that may follow, column by column: so many are added. */
    readonly length: number;
    readonly whole: number;
    readonly #perBlock: number;
    #blocks: Float32Array[] = [];
    #curves: Record<Curve, Float32Array>;
    /** The frame that was asked for last: most are asked for several times. */
    #last: { k: number; numbers: Float32Array } = { k: -1, numbers: new Float32Array() };
    readonly #between: Float32Array;
    /** Means of columns, with their frame and how many before it they are over. */
    #means = new Map<number, { k: number; last: number; means: Float64Array }>();
    /** Sums over so many of the last frames, for the greatest mean of each frame. */
    #running = new Map<string, { sums: Float64Array; greatest: number[] }>();

    constructor(
        readonly agents: number,
        further: number,
    ) {
        this.length = COLUMNS * agents;
        this.whole = this.length + further * agents;
        this.#perBlock = Math.max(1, Math.floor(BLOCK_BYTES / (4 * Math.max(1, this.whole))));
        const curve = () => new Float32Array(1024);
        this.#curves = { speed: curve(), squeeze: curve(), greatest: curve(), contacts: curve(), left: curve() };
        this.#between = new Float32Array(this.length);
    }

    /** What a frame occupies. */
    get bytes() {
        return 4 * this.whole + 4 * CURVES.length;
    }

    /** Appends so many frames, which lie one after the other. */
    add(numbers: Float64Array, count: number) {
        const length = this.whole;
        for (let k = 0; k < count; k++) {
            const place = this.count % this.#perBlock;
            if (place === 0) this.#blocks.push(new Float32Array(this.#perBlock * length));
            const block = this.#blocks.at(-1)!;
            block.set(numbers.subarray(k * length, (k + 1) * length), place * length);
            this.#sum(block, place * length);
            this.count += 1;
        }
    }

    #sum(block: Float32Array, start: number) {
        const k = this.count;
        if (k === this.#curves.speed.length) {
            for (const name of CURVES) {
                const longer = new Float32Array(2 * k);
                longer.set(this.#curves[name]);
                this.#curves[name] = longer;
            }
        }
        let [speed, squeeze, greatest, contacts, there, outside] = [0, 0, 0, 0, 0, 0];
        for (let at = start; at < start + this.length; at += COLUMNS) {
            if (Number.isNaN(block[at]!)) {
                // Who has not come yet has no velocity either.
                if (Number.isNaN(block[at + 3]!)) outside += 1;
                continue;
            }
            there += 1;
            const [vx, vy, squeezed] = [block[at + 3]!, block[at + 4]!, block[at + SQUEEZE]!];
            speed += Math.sqrt(vx * vx + vy * vy);
            squeeze += squeezed;
            if (squeezed > greatest) greatest = squeezed;
            contacts += block[at + CONTACTS]!;
        }
        // Who has left is no part of a mean.
        const people = Math.max(1, there);
        this.#curves.speed[k] = speed / people;
        this.#curves.squeeze[k] = squeeze / people;
        this.#curves.greatest[k] = greatest;
        this.#curves.contacts[k] = contacts / people;
        this.#curves.left[k] = this.agents - there - outside;
    }

    /** A curve of those who have not left: mean speed, mean and greatest squeeze, mean number of contacts of a person; and how
     * many have left. `count` of each. */
    curve(name: Curve): Float32Array {
        return this.#curves[name].subarray(0, this.count);
    }

    /** Its numbers, not to be changed. */
    frame(k: number): Float32Array {
        const place = Math.max(0, Math.min(k, this.count - 1));
        if (this.#last.k !== place) {
            this.#last = { k: place, numbers: this.#all(place).subarray(0, this.length) };
        }
        return this.#last.numbers;
    }

    #all(k: number): Float32Array {
        const start = (k % this.#perBlock) * this.whole;
        return this.#blocks[Math.floor(k / this.#perBlock)]!.subarray(start, start + this.whole);
    }

    /** Where a column begins in a frame, and how far it is from agent to agent. */
    #column(column: number): [start: number, stride: number] {
        return column < COLUMNS ? [column, COLUMNS] : [column * this.agents, 1];
    }

    number(k: number, agent: number, column: number): number {
        const [start, stride] = this.#column(column);
        return this.#blocks[Math.floor(k / this.#perBlock)]![(k % this.#perBlock) * this.whole + start + stride * agent]!;
    }

    /** Between two frames: poses in proportion (angles are not wrapped), the rest as in the earlier one. Valid until the
     * next call. */
    at(place: number): Float32Array {
        const k = Math.floor(place);
        const share = place - k;
        if (!(share > 0) || k + 1 >= this.count) return this.frame(k);
        const later = this.frame(k + 1);
        const earlier = this.frame(k);
        const out = this.#between;
        out.set(earlier);
        for (let at = 0; at < this.length; at += COLUMNS) {
            // Who was carried over a link is on the earlier floor.
            if (Math.hypot(later[at]! - earlier[at]!, later[at + 1]! - earlier[at + 1]!) > CARRIED) continue;
            for (let column = 0; column < 3; column++) {
                const from = earlier[at + column]!;
                out[at + column] = from + share * (later[at + column]! - from);
            }
        }
        return out;
    }

    /** For each agent the mean of the last frames up to `k`, of squeeze or another column. Valid until the next call of the same. */
    means(k: number, last: number, column = SQUEEZE): Float64Array {
        const known = this.#means.get(column);
        if (known?.k === k && known.last === last) return known.means;
        const means = known?.means.fill(0) ?? new Float64Array(this.agents);
        this.#means.set(column, { k, last, means });
        const [first, stride] = this.#column(column);
        // In the first frame, no step was computed yet.
        const from = Math.min(k, Math.max(1, k - last + 1));
        for (let j = from; j <= k; j++) {
            const start = (j % this.#perBlock) * this.whole + first;
            const block = this.#blocks[Math.floor(j / this.#perBlock)]!;
            for (let a = 0; a < this.agents; a++) means[a]! += block[start + stride * a]!;
        }
        for (let a = 0; a < this.agents; a++) means[a]! /= k - from + 1;
        return means;
    }

    /** Such a mean of one agent. */
    meanOf(k: number, last: number, agent: number, column: number): number {
        const from = Math.min(k, Math.max(1, k - last + 1));
        let sum = 0;
        for (let j = from; j <= k; j++) sum += this.number(j, agent, column);
        return sum / (k - from + 1);
    }

    /** In each frame the greatest of these means. */
    greatestMean(last: number, column = SQUEEZE): Float32Array {
        return Float32Array.from(this.#greatest(last, column));
    }

    /** Everybody's squeeze in frames, from one to before another: not a number for who has left. */
    squeezes(from: number, to: number): Uint8Array<ArrayBuffer> {
        const { agents } = this;
        const numbers = new Float64Array((to - from) * agents);
        for (let k = from; k < to; k++) {
            const frame = this.frame(k);
            for (let a = 0; a < agents; a++) numbers[(k - from) * agents + a] = Number.isNaN(frame[COLUMNS * a]!) ? NaN : frame[COLUMNS * a + SQUEEZE]!;
        }
        return new Uint8Array(numbers.buffer);
    }

    /** The frame that is in a mean of the last ones no more, when another one comes: the first one, without a step, is in no
     * mean but its own. */
    #gone(k: number, last: number): Float32Array | null {
        return k - last >= 1 ? this.#all(k - last) : k === 1 ? this.#all(0) : null;
    }

    #greatest(last: number, column = SQUEEZE): number[] {
        const [key, [first, stride]] = [`${last} ${column}`, this.#column(column)];
        const running = this.#running.get(key) ?? { sums: new Float64Array(this.agents), greatest: [] };
        this.#running.set(key, running);
        const { sums, greatest } = running;
        for (let k = greatest.length; k < this.count; k++) {
            const gone = this.#gone(k, last);
            const come = this.#all(k);
            let most = 0;
            for (let a = 0; a < this.agents; a++) {
                const at = first + stride * a;
                sums[a]! += come[at]! - (gone ? gone[at]! : 0);
                // Who has left is pressed by nobody.
                if (sums[a]! > most && !Number.isNaN(come[COLUMNS * a]!)) most = sums[a]!;
            }
            greatest.push(most / Math.max(1, Math.min(k, last)));
        }
        return greatest;
    }

    /** Frees frames of which only the curves and the greatest of these means will be asked for. */
    forget(means: number[]) {
        for (const last of means) this.#greatest(last);
        const unneeded = Math.floor((this.count - Math.max(...means)) / this.#perBlock);
        if (unneeded > 0) this.#blocks.fill(new Float32Array(), 0, unneeded);
    }

    /** A copy of frames, from one to before another, as the lab reads them. */
    copy(from: number, to: number): Uint8Array<ArrayBuffer> {
        const numbers = new Float64Array((to - from) * this.length);
        for (let k = from; k < to; k++) numbers.set(this.frame(k), (k - from) * this.length);
        return new Uint8Array(numbers.buffer);
    }
}
