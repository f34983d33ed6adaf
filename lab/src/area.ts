// How many people are in an area, and how they are squeezed, over the time of a run.

import type { Film } from "./film";
import { SQUEEZE } from "./frames";
import { COLUMNS, type Point } from "./protocol";

export class Inside {
    /** Number of centres inside in each frame, and the mean squeeze of these people. */
    readonly counts: number[] = [];
    readonly squeezes: number[] = [];
    /** In m². */
    readonly size: number;

    constructor(
        readonly film: Film,
        readonly corners: [Point, Point],
    ) {
        const [[x1, y1], [x2, y2]] = corners;
        this.size = Math.abs((x2 - x1) * (y2 - y1));
    }

    /** Looks at the frames that are new. */
    follow() {
        const { frames, scene } = this.film;
        const [[x1, y1], [x2, y2]] = this.corners;
        const [left, right, low, high] = [Math.min(x1, x2), Math.max(x1, x2), Math.min(y1, y2), Math.max(y1, y2)];
        for (let k = this.counts.length; k < frames.count; k++) {
            const frame = frames.frame(k);
            let [count, squeeze] = [0, 0];
            for (let a = 0; a < scene.agents.length; a++) {
                const [x, y] = [frame[COLUMNS * a]!, frame[COLUMNS * a + 1]!];
                // Who has left has no place: no comparison holds.
                if (!(x >= left && x <= right && y >= low && y <= high)) continue;
                count += 1;
                squeeze += frame[COLUMNS * a + SQUEEZE]!;
            }
            this.counts.push(count);
            this.squeezes.push(count > 0 ? squeeze / count : NaN);
        }
    }
}
