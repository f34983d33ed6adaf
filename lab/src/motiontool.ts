// Drawing pushes and ways on the picture.

import { ARROW, label, paintPush, paintWays, tip } from "./draw";
import { MOST } from "./forms";
import { addPoint, dragged, motion, picked, setMotion, standing, toolKey } from "./motionstate";
import type { Motion, Point, Push, Waypoint } from "./protocol";
import { distance, snapped } from "./roomshape";
import { begin, clicks, hover, mode, type Pointer, sketch, type Tool } from "./tool";

/** Which part is dragged: of a push its middle, rim or tip; of a way the number of a point. */
let part: "middle" | "rim" | "tip" | number = "middle";

export const FIRST_PUSH: Push = { at: [0, 0], radius: 0.5, direction: 0, force: 500, start: 0.2, duration: 0.3 };
export const FIRST_RADIUS = 0.5;

function wayOf(points: Point[]) {
    return points.map(([x, y]) => ({ x, y, radius: FIRST_RADIUS }));
}

type Walk = Extract<Motion, { kind: "walk" }>;

/** With another way, which gets a share where the others have one. */
export function withWay(now: Walk, way: Waypoint[]): Walk {
    return { ...now, ways: [...now.ways, way], shares: now.shares && [...now.shares, 1] };
}

function finish() {
    const way = wayOf(sketch.value);
    const now = standing.value;
    begin("change");
    if (now.kind !== "walk" || way.length === 0) return;
    picked.value = now.ways.length;
    setMotion(withWay(now, way));
}

/** An arrow of no length would push nobody. */
const LEAST = 10;

/** A push whose arrow ends there. */
function aimed(push: Push, to: Point): Push {
    const [dx, dy] = [to[0] - push.at[0], to[1] - push.at[1]];
    const force = Math.max(LEAST, Math.round((ARROW * Math.hypot(dx, dy)) / 10) * 10);
    return { ...push, force, direction: Math.round((Math.atan2(dy, dx) * 180) / Math.PI) };
}

function grab({ at, reach }: Pointer): boolean {
    const now = standing.value;
    if (now.kind === "push") {
        for (const [k, push] of now.pushes.entries()) {
            const away = distance(at, push.at);
            if (distance(at, tip(push)) < reach) part = "tip";
            else if (away < reach) part = "middle";
            else if (Math.abs(away - push.radius) < reach) part = "rim";
            else continue;
            picked.value = k;
            return true;
        }
    }
    if (now.kind === "walk") {
        for (const [w, way] of now.ways.entries()) {
            const k = way.findIndex(({ x, y }) => distance(at, [x, y]) < 1.5 * reach);
            if (k < 0) continue;
            [picked.value, part] = [w, k];
            return true;
        }
    }
    return false;
}

function dragTo({ at }: Pointer) {
    const now = dragged.value;
    if (now?.kind === "push") {
        const pushes = now.pushes.map((push, k) => {
            if (k !== picked.value) return push;
            if (part === "tip") return aimed(push, at);
            if (part === "rim") return { ...push, radius: Math.max(0.1, Number(distance(at, push.at).toFixed(2))) };
            return { ...push, at: snapped(at) };
        });
        dragged.value = { ...now, pushes };
    } else if (now?.kind === "walk") {
        const [x, y] = snapped(at);
        const ways = now.ways.map((way, w) => (w === picked.value ? way.map((point, k) => (k === part ? { ...point, x, y } : point)) : way));
        dragged.value = { ...now, ways };
    }
}

function press(pointer: Pointer): boolean {
    const now = standing.value;
    clicks.held = null;
    if (mode.value === "push" && now.kind === "push") {
        part = "tip";
        picked.value = now.pushes.length;
        const push: Push = { ...FIRST_PUSH, at: snapped(pointer.at), force: LEAST };
        dragged.value = { ...now, pushes: [...now.pushes, push].slice(0, MOST.parts) };
        return true;
    }
    if (mode.value === "way" && now.kind === "walk") {
        clicks.held = pointer;
        return true;
    }
    if (!grab(pointer)) return false;
    dragged.value = now;
    return true;
}

export const motionTool: Tool = {
    draws: () => mode.value !== "change",
    down: press,
    move(pointer, pressed) {
        hover.value = snapped(pointer.at);
        if (pressed && dragged.value) dragTo(pointer);
    },
    cancel() {
        clicks.held = null;
        if (dragged.value && mode.value === "push") picked.value = null;
        dragged.value = null;
    },
    up() {
        const { held } = clicks;
        clicks.held = null;
        if (held && mode.value === "way") addPoint(held, MOST.points, finish);
        const next = dragged.value;
        if (!next) return;
        const drawn = mode.value === "push";
        begin("change");
        if (next.kind !== "push") return setMotion(next);
        // A click without an arrow is a push with the usual force.
        const usual = (push: Push) => (drawn && push.force <= LEAST ? { ...push, force: FIRST_PUSH.force } : push);
        setMotion({ ...next, pushes: next.pushes.map((push, k) => (k === picked.value ? usual(push) : push)) });
    },
    key: (event) => toolKey(event, finish, remove),
    paint(context, view, inks) {
        const now = motion.value;
        if (now.kind === "push") {
            const drag = dragged.value !== null;
            now.pushes.forEach((push, k) => {
                if (k !== picked.value) return;
                paintPush(context, push, -1, view, inks, true);
                if (drag) label(context, `${push.force} N, ${push.direction}°`, tip(push), view, inks);
            });
        }
        if (now.kind === "walk") {
            if (dragged.value) paintWays(context, now.ways, view, inks, picked.value);
            if (mode.value === "way") {
                const next = hover.value ? [hover.value] : [];
                paintWays(context, [wayOf([...sketch.value, ...next])], view, inks, 0);
            }
        }
    },
};

export function remove(k: number) {
    const now = standing.value;
    picked.value = null;
    if (now.kind === "push") setMotion({ ...now, pushes: now.pushes.filter((_, j) => j !== k) });
    if (now.kind === "walk") setMotion({ ...now, ways: now.ways.filter((_, j) => j !== k), shares: now.shares && now.shares.filter((_, j) => j !== k) });
}
