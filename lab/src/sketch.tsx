// A small plan of a scene's room.

import type { KeptBase } from "./forms";
import type { Point, Room } from "./protocol";
import { away, distance, rings } from "./roomshape";

/** The direction of the wall that is nearest to a point. */
function along(room: Room, at: Point): Point {
    const walls = rings(room).flatMap((ring) => ring.map((corner, k): [Point, Point] => [ring.at(k - 1)!, corner]));
    const [from, to] = walls.reduce((best, wall) => (away(at, wall) < away(at, best) ? wall : best));
    const length = distance(from, to) || 1;
    return [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
}

/** `exits`: lines and areas that are drawn with it. */
export function Sketch({ base, exits = [] }: { base: KeptBase; exits?: Point[][] }) {
    if (base.kind !== "crowd") {
        return (
            <svg class="sketch" viewBox="-0.2 -0.2 5.4 2" aria-hidden="true">
                {[0, 1, 2, 3, 4].map((k) => (
                    <ellipse key={k} cx={k + 0.9} cy="0.8" rx="0.3" ry="0.5" class="crowded" />
                ))}
                <path d="M-.1 .8h.5m-.2-.15l.2.15l-.2.15" class="outline" />
            </svg>
        );
    }
    const { room, region } = base;
    const line = (corners: Point[]) => `M${corners.map(([x, y]) => `${x} ${-y}`).join("L")}`;
    const path = (corners: Point[]) => `${line(corners)}Z`;
    const [xs, ys] = [0, 1].map((axis) => [...room.outline, ...exits.flat()].map((corner) => corner[axis as 0 | 1])) as [number[], number[]];
    const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    return (
        <svg class="sketch" viewBox={`${left - 0.3} ${-high - 0.3} ${right - left + 0.6} ${high - low + 0.6}`} aria-hidden="true">
            <path d={path(region ?? room.outline)} class="crowded" />
            <path d={[room.outline, ...room.obstacles].map(path).join("")} class="outline" />
            {room.walls && <path d={room.walls.map(({ corners }) => line(corners)).join("")} class="wall" />}
            {room.doors.map(({ at: [x, y], width }) => {
                const [dx, dy] = along(room, [x, y]).map((part) => (part * width) / 2) as Point;
                return <path key={`${x} ${y}`} d={`M${x - dx} ${dy - y}L${x + dx} ${-dy - y}`} class="gap" />;
            })}
            {exits.length > 0 && <path d={exits.map((corners) => (corners.length > 2 ? path(corners) : line(corners))).join("")} class="way-out" />}
        </svg>
    );
}
