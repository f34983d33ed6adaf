// Drawings from above with their dimensions. Lengths of the drawings are in m; the gaze goes up.

import type { ComponentChildren } from "preact";
import type { Point } from "./protocol";

/** From the body's frame (x: gaze, y: left) to the drawing (x: right, y: down). */
function place([x, y]: Point): string {
    return `${-y} ${-x}`;
}

export function pathOf(polygons: Point[][]): string {
    return polygons.map((polygon) => `M${polygon.map(place).join("L")}Z`).join("");
}

/** Extents of a drawing, in the body's frame, in m. */
export interface Extents {
    back: number;
    front: number;
    right: number;
    left: number;
}

/** Extents of points, each with a margin around it. */
export function extents(points: [x: number, y: number, margin: number][]): Extents {
    const least = (k: 0 | 1) => Math.min(...points.map((point) => point[k] - point[2]));
    const most = (k: 0 | 1) => Math.max(...points.map((point) => point[k] + point[2]));
    return { back: least(0), front: most(0), right: least(1), left: most(1) };
}

interface DrawingProps {
    size: Extents;
    /** A length in words. */
    words(length: number): string;
    label: string;
    children: ComponentChildren;
}

/** Something from above, between dimension lines: one below it, one at its left. */
export function Drawing({ size, words, label, children }: DrawingProps) {
    const { back, front, right, left } = size;
    const [across, along] = [left - right, front - back];
    const text = 0.055 * Math.max(across, along);
    const gap = 1.1 * text;
    const [low, beside] = [-back + gap, -left - gap];
    const [width, height] = [across + 6.4 * gap, along + 4 * gap];
    return (
        <svg class="drawing" viewBox={`${-left - 3.2 * gap} ${-front - gap} ${width} ${height}`} role="img" aria-label={label}>
            {children}
            <g class="dimension">
                <path d={`M${-left} ${low - gap / 2}v${gap}M${-right} ${low - gap / 2}v${gap}${arrow(-left, low, -right, low, gap / 3)}`} />
                <text x={-(left + right) / 2} y={low + gap} font-size={text} text-anchor="middle" dominant-baseline="middle">
                    {words(across)}
                </text>
                <path d={`M${beside - gap / 2} ${-front}h${gap}M${beside - gap / 2} ${-back}h${gap}${arrow(beside, -front, beside, -back, gap / 3)}`} />
                <text transform={`translate(${beside - gap} ${-(front + back) / 2}) rotate(-90)`} font-size={text} text-anchor="middle" dominant-baseline="middle">
                    {words(along)}
                </text>
            </g>
        </svg>
    );
}

/** A level or upright line with a head at both ends. */
function arrow(x1: number, y1: number, x2: number, y2: number, head: number) {
    const upright = x1 === x2;
    const ends = upright
        ? `M${x1 - head} ${y1 + 2 * head}L${x1} ${y1}l${head} ${2 * head}M${x2 - head} ${y2 - 2 * head}L${x2} ${y2}l${head} ${-2 * head}`
        : `M${x1 + 2 * head} ${y1 - head}L${x1} ${y1}l${2 * head} ${head}M${x2 - 2 * head} ${y2 - head}L${x2} ${y2}l${-2 * head} ${head}`;
    return `M${x1} ${y1}L${x2} ${y2}${ends}`;
}

/** Where somebody looks: an arrow from the middle upwards. */
export function Gaze({ length }: { length: number }) {
    return <path d={`M0 0v${-length}m${-0.12 * length} ${0.18 * length}l${0.12 * length} ${-0.18 * length}l${0.12 * length} ${0.18 * length}`} class="gaze" />;
}
