// Places as they are clicked: what of a room is near, snapping, and what a sketch shows before it is a room.

import type { Further, Point, Room } from "./protocol";

/** The outline is ring 0; obstacles and further walls follow. */
export function rings({ outline, obstacles, walls = [] }: Room): Point[][] {
    return [outline, ...obstacles, ...walls.map(({ corners }) => corners)];
}

/** The further wall of a ring. */
export function wallAt({ obstacles, walls = [] }: Room, ring: number): Further | undefined {
    return walls[ring - 1 - obstacles.length];
}

/** Whether a polyline ends where it begins. */
export function closes(corners: Point[]): boolean {
    const [first, last] = [corners[0], corners.at(-1)];
    return corners.length > 3 && first![0] === last![0] && first![1] === last![1];
}

/** Whether a ring can lose a corner: a closed wall has three, an open one two. */
export function canLose(room: Room, ring: number): boolean {
    const corners = rings(room)[ring]!;
    const closed = closes(corners);
    return corners.length - (closed ? 1 : 0) > (wallAt(room, ring) && !closed ? 2 : 3);
}

export function distance(a: Point, b: Point) {
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

/** From a point to a line through corners; 0 inside of an area. */
export function away([x, y]: Point, corners: Point[]): number {
    const area = corners.length > 2;
    let [least, inside] = [Infinity, false];
    for (let k = area ? 0 : 1; k < corners.length; k++) {
        const [[ax, ay], [bx, by]] = [corners.at(k - 1)!, corners[k]!];
        const share = Math.max(0, Math.min(1, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2 || 1)));
        least = Math.min(least, Math.hypot(ax + share * (bx - ax) - x, ay + share * (by - ay) - y));
        if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
    }
    return area && inside ? 0 : least;
}

const SNAP = 0.05;

/** Millimetres are enough. */
export function snapped(at: Point): Point {
    return at.map((place) => Number((Math.round(place / SNAP) * SNAP).toFixed(3))) as Point;
}

/** Level with or straight above another point, whichever is nearer. */
export function squared(at: Point, from: Point): Point {
    return Math.abs(at[0] - from[0]) > Math.abs(at[1] - from[1]) ? [at[0], from[1]] : [from[0], at[1]];
}

/** The rectangle between two corners. */
export function spanned(a: Point, b: Point): Point[] {
    const [left, right] = [Math.min(a[0], b[0]), Math.max(a[0], b[0])];
    const [low, high] = [Math.min(a[1], b[1]), Math.max(a[1], b[1])];
    return [
        [left, low],
        [right, low],
        [right, high],
        [left, high],
    ];
}

export function rectangle(width: number, height: number, x = 0, y = 0): Point[] {
    return spanned([x, y], [x + width, y + height]);
}
