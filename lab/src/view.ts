// Where things are on the picture: fitting, zooming, moving.

import { COLUMNS, isThere, type Point, type Scene } from "./protocol";

/** From metres to pixels of the canvas; up is up. */
export interface View {
    scale: number;
    x: number;
    y: number;
}

/** Least and most pixels per metre. */
const [FAR, NEAR] = [0.5, 5000];

export function toPixels(view: View, [x, y]: Point): Point {
    return [view.x + view.scale * x, view.y - view.scale * y];
}

export function toMetres(view: View, x: number, y: number): Point {
    return [(x - view.x) / view.scale, (view.y - y) / view.scale];
}

/** Canvas coordinates become metres. */
export function inMetres(context: CanvasRenderingContext2D, { scale, x, y }: View) {
    context.setTransform(scale, 0, 0, -scale, x, y);
}

/** All is visible: walls, people where they start, and what else is given. */
export function fitting(scene: Scene, frame: Float32Array, further: Point[], width: number, height: number): View {
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    const see = (x: number, y: number, margin: number) => {
        left = Math.min(left, x - margin);
        right = Math.max(right, x + margin);
        low = Math.min(low, y - margin);
        high = Math.max(high, y + margin);
    };
    for (const wall of scene.walls) for (const [x, y] of wall.corners) see(x, y, 0.15);
    scene.agents.forEach((_, a) => isThere(frame, a) && see(frame[COLUMNS * a]!, frame[COLUMNS * a + 1]!, 0.6));
    for (const [x, y] of further) see(x, y, 0.3);
    if (left > right) see(0, 0, 1);
    // The answer is above, the scale bar below.
    const edge = Math.min(40 * devicePixelRatio, height / 6);
    const scale = Math.max(FAR, Math.min(width / (right - left), (height - 2 * edge) / (high - low), NEAR));
    return { scale, x: width / 2 - (scale * (left + right)) / 2, y: height / 2 + (scale * (low + high)) / 2 };
}

/** A pixel keeps its place. */
export function zoomed(view: View, by: number, x: number, y: number): View {
    const scale = Math.max(FAR, Math.min(view.scale * by, NEAR));
    const real = scale / view.scale;
    return { scale, x: x + real * (view.x - x), y: y + real * (view.y - y) };
}
