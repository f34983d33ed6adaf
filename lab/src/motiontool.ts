// Pushes, ways, exits and goals, drawn and dragged on the picture.

import { ARROW, label, paintPush, paintWays, tip } from "./draw";
import { middleOf, paintHandles, paintPlaces } from "./drawplaces";
import { MOST } from "./forms";
import { aimed, type Drawing, draws, handles } from "./handles";
import { dragged, motion, picked, setMotion, standing } from "./motionstate";
import { added, changed, cornersOf, kindOf, placesOf, removed, shaped } from "./places";
import type { DecisionConfig, Motion, Point, Push, Waypoint } from "./protocol";
import { distance, snapped } from "./roomshape";
import { film } from "./session";
import type { Pointer } from "./tool";

export const FIRST_PUSH: Push = { at: [0, 0], radius: 0.5, direction: 0, force: 500, start: 0.2, duration: 0.3 };
export const FIRST_RADIUS = 0.5;

type Walk = Extract<Motion, { kind: "walk" }>;

const wayOf = (points: Point[]) => points.map(([x, y]) => ({ x, y, radius: FIRST_RADIUS }));

/** With another way, which gets a share where the others have one. */
export function withWay(now: Walk, way: Waypoint[]): Walk {
    return { ...now, ways: [...now.ways, way], shares: now.shares && [...now.shares, 1] };
}

export const setDecision = (decision: DecisionConfig) => setMotion({ kind: "go", decision });

/** An arrow of no length would push nobody. */
const LEAST = 10;

/** A push whose arrow ends there. */
function pushTo(push: Push, to: Point): Push {
    const [dx, dy] = [to[0] - push.at[0], to[1] - push.at[1]];
    const force = Math.max(LEAST, Math.round((ARROW * Math.hypot(dx, dy)) / 10) * 10);
    return { ...push, force, direction: Math.round((Math.atan2(dy, dx) * 180) / Math.PI) };
}

const drawnPush = (points: Point[]) => pushTo({ ...FIRST_PUSH, at: points[0]! }, points.at(-1)!);
export const pushWords = ({ force, direction }: Push) => `${force} N, ${direction}°`;

function place(kind: "exit" | "goal", line: boolean): Drawing {
    return {
        points: line ? [2, 2] : [3, MOST.corners],
        closes: true,
        done(corners) {
            if (standing.value.kind !== "go") return;
            const { decision } = standing.value;
            const next = added(decision, kind, corners);
            picked.value = kind === "exit" ? decision.exits.length : next.exits.length + decision.goals.length;
            setDecision(next);
        },
        paint: (context, corners, view, inks) => paintPlaces(context, [{ name: "", stay: kind === "goal", corners }], view, inks, 0),
    };
}

draws({
    push: {
        points: [1, 1],
        drag: true,
        done(points, drags) {
            const now = standing.value;
            if (now.kind !== "push" || now.pushes.length >= MOST.parts) return;
            const push = drawnPush(points);
            picked.value = now.pushes.length;
            // A click without an arrow is a push with the usual force.
            setMotion({ ...now, pushes: [...now.pushes, drags && push.force > LEAST ? push : { ...push, force: FIRST_PUSH.force }] });
        },
        // The tip need not be on the grid.
        place: ({ at }, from) => (from ? at : snapped(at)),
        paint: (context, points, view, inks) => paintPush(context, drawnPush(points), -1, view, inks, true, true),
        words: (points) => (points.length > 1 ? pushWords(drawnPush(points)) : undefined),
    },
    way: {
        points: [1, MOST.points],
        done(points) {
            const now = standing.value;
            if (now.kind !== "walk") return;
            picked.value = now.ways.length;
            setMotion(withWay(now, wayOf(points)));
        },
        paint: (context, points, view, inks) => paintWays(context, [wayOf(points)], view, inks, 0),
    },
    "exit line": place("exit", true),
    "exit area": place("exit", false),
    "goal line": place("goal", true),
    "goal area": place("goal", false),
});

/** Which part is dragged: of a push its middle, rim or tip; a point of a way or a place by its number, or all of a place. */
type Part = "middle" | "rim" | "tip" | "all" | number;

/** The push, way or place under the pointer, and which part of it. */
function under(now: Motion, { at, reach }: Pointer): [k: number, part: Part] | null {
    const near = (points: Point[], far: number) => points.findIndex((point) => distance(at, point) < far);
    const parts = (
        now.kind === "push"
            ? now.pushes.map((push) => {
                  const away = distance(at, push.at);
                  return distance(at, tip(push)) < reach ? "tip" : away < reach ? "middle" : Math.abs(away - push.radius) < reach ? "rim" : -1;
              })
            : now.kind === "walk"
              ? now.ways.map((way) => near(way.map(({ x, y }) => [x, y]), 1.5 * reach))
              : now.kind === "go"
                ? placesOf(now.decision).map((place) => {
                      const corners = cornersOf(place);
                      const corner = near(corners, reach);
                      return corner < 0 && distance(at, middleOf(corners)) < 1.5 * reach ? "all" : corner;
                  })
                : []
    ) as Part[];
    const k = parts.findIndex((part) => part !== -1);
    return k < 0 ? null : [k, parts[k]!];
}

function moved(now: Motion, k: number, part: Part, pointer: Pointer): Motion {
    const { at } = pointer;
    const other = <T>(all: T[], change: (one: T) => T) => all.map((one, j) => (j === k ? change(one) : one));
    if (now.kind === "push") {
        const change = (push: Push) => (part === "tip" ? pushTo(push, at) : part === "rim" ? { ...push, radius: Math.max(0.1, Number(distance(at, push.at).toFixed(2))) } : { ...push, at: snapped(at) });
        return { ...now, pushes: other(now.pushes, change) };
    }
    if (now.kind === "walk") {
        const [x, y] = snapped(at);
        return { ...now, ways: other(now.ways, (way) => way.map((point, j) => (j === part ? { ...point, x, y } : point))) };
    }
    if (now.kind !== "go") return now;
    const place = placesOf(now.decision)[k]!;
    const corners = cornersOf(place);
    const [x, y] = middleOf(corners);
    const shift = (corner: Point, j: number): Point => (part === "all" ? snapped([corner[0] + at[0] - x, corner[1] + at[1] - y]) : j === part ? aimed(pointer, corners.at(j - 1)) : corner);
    return { kind: "go", decision: changed(now.decision, k, shaped(place, corners.map(shift))) };
}

export const motionTool = handles<Motion, [k: number, part: Part]>({
    now: () => standing.value,
    dragged,
    grab(now, pointer) {
        const part = under(now, pointer);
        if (part) picked.value = part[0];
        return part && { part };
    },
    drag: ([k, part], pointer, from) => moved(from, k, part, pointer),
    put: setMotion,
    remove() {
        const k = picked.value;
        if (k !== null) remove(k);
        return k !== null;
    },
    // There should be room for exits beyond doors.
    extent: () => (standing.value.kind === "go" && film.value?.scene.beyond_doors.flat()) || [],
    paint(context, view, inks) {
        const [now, drags, k] = [motion.value, dragged.value !== null, picked.value];
        if (now.kind === "push" && k !== null && now.pushes[k]) {
            paintPush(context, now.pushes[k], -1, view, inks, true, true);
            if (drags) label(context, pushWords(now.pushes[k]), tip(now.pushes[k]), view, inks);
        }
        if (now.kind === "walk" && drags) paintWays(context, now.ways, view, inks, k);
        if (now.kind !== "go") return;
        const places = placesOf(now.decision).map((place, k) => ({ name: place.name, stay: kindOf(now.decision, k) === "goal", corners: cornersOf(place) }));
        if (drags) paintPlaces(context, places, view, inks, k);
        places.forEach(({ stay, corners }, j) => paintHandles(context, corners, view, inks, stay ? inks.goal : inks.exit, j === k));
    },
});

export function remove(k: number) {
    const now = standing.value;
    const without = <T>(all: T[]) => all.filter((_, j) => j !== k);
    picked.value = null;
    if (now.kind === "push") setMotion({ ...now, pushes: without(now.pushes) });
    if (now.kind === "walk") setMotion({ ...now, ways: without(now.ways), shares: now.shares && without(now.shares) });
    if (now.kind === "go") setDecision(removed(now.decision, k));
}
