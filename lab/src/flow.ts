// How many people cross a line, over the time of a run.

import { signal } from "@preact/signals";
import type { Film } from "./film";
import type { Flow as Counted, Point } from "./protocol";

/** Bytes of frames that are sent at once. */
const MOST_BYTES = 20e6;

/** People per second between the first and the last of so many (frames), as docs/measure.md defines it; null for fewer than
 * two, or all at once. */
export function meanFlow(people: number, first: number, last: number, step: number): number | null {
    return people > 1 && last > first ? (people - 1) / ((last - first) * step) : null;
}

/** Frames of the crossings in one direction, ascending. */
export type Way = 1 | -1;

export class Flow {
    readonly refused = signal("");
    /** Frames that are counted. */
    readonly counted = signal(0);
    readonly crossings: Record<Way, number[]> = { 1: [], [-1]: [] };
    #asking = false;

    constructor(
        readonly film: Film,
        readonly line: [Point, Point],
    ) {}

    /** Counts over the frames that came since. */
    async follow() {
        const { film } = this;
        if (this.#asking || this.refused.value) return;
        this.#asking = true;
        try {
            const most = Math.max(2, Math.floor(MOST_BYTES / Math.max(1, 8 * film.frames.length)));
            while (!film.over && this.counted.value < film.frames.count) {
                // A crossing lies between two frames, so the last one counts again.
                const from = Math.max(0, this.counted.value - 1);
                const to = Math.min(film.frames.count, from + most);
                const request = { ask: "flow", run: film.scene.run, line: this.line } as const;
                const { value } = await film.client.ask<Counted>(request, film.frames.copy(from, to));
                for (const [place, , way] of value.crossings) this.crossings[way].push(from + place);
                this.counted.value = to;
            }
        } catch (error) {
            if (!film.over) this.refused.value = (error as Error).message;
        } finally {
            this.#asking = false;
        }
    }

    /** How many crossed up to each of the frames (ascending). */
    counts(way: Way, frames: ArrayLike<number>): number[] {
        const crossings = this.crossings[way];
        let n = 0;
        return Array.from(frames, (frame) => {
            while (n < crossings.length && crossings[n]! <= frame) n += 1;
            return n;
        });
    }

    /** People per second from the first to the last crossing up to a frame; null for fewer than two. */
    mean(way: Way, until: number): number | null {
        const crossings = this.crossings[way].filter((frame) => frame <= until);
        return meanFlow(crossings.length, crossings[0] ?? 0, crossings.at(-1) ?? 0, this.film.scene.step);
    }

    /** An arrow that shows the direction on the page. */
    arrow(way: Way): string {
        const [[x1, y1], [x2, y2]] = this.line;
        // To the right of the line, seen along it.
        const angle = Math.atan2(way * (x1 - x2), way * (y2 - y1));
        return "→↗↑↖←↙↓↘"[(Math.round(angle / (Math.PI / 4)) + 8) % 8]!;
    }
}
