// Drawing exits and goals on the picture.

import { label } from "./draw";
import { middleOf, paintHandles, paintPlaces } from "./drawplaces";
import { MOST } from "./forms";
import { addPoint, dragged, motion, picked, setMotion, standing, toolKey } from "./motionstate";
import { length } from "./parts";
import { added, changed, cornersOf, type Kind, kindOf, placesOf, removed, shaped } from "./places";
import { plan } from "./plan";
import type { DecisionConfig, Motion, Point } from "./protocol";
import { distance, snapped, squared } from "./roomshape";
import { film } from "./session";
import { begin, clicks, hover, mode, type Pointer, sketch, type Tool } from "./tool";

/** What is dragged: a corner by its number, or all of it. */
let part: number | "all" = "all";
/** As it was pressed on. */
let pressed: Point[] = [];

/** What is drawn now; null: nothing. */
function drawn(): { kind: Kind; line: boolean } | null {
    const [kind, shape] = mode.value.split(" ");
    return kind === "exit" || kind === "goal" ? { kind, line: shape === "line" } : null;
}

function decisionOf(of: Motion): DecisionConfig | null {
    return of.kind === "go" ? of.decision : null;
}

export function setDecision(decision: DecisionConfig) {
    setMotion({ kind: "go", decision });
}

export function remove(k: number) {
    const decision = decisionOf(standing.value);
    picked.value = null;
    if (decision) setDecision(removed(decision, k));
}

function finish() {
    const making = drawn();
    const corners = sketch.value;
    const decision = decisionOf(standing.value);
    begin("change");
    if (!making || !decision || corners.length < (making.line ? 2 : 3)) return;
    const next = added(decision, making.kind, corners);
    picked.value = making.kind === "exit" ? decision.exits.length : next.exits.length + decision.goals.length;
    setDecision(next);
}

/** Level with or straight above the corner before, if Shift is held. */
function aimed({ at, shift }: Pointer, from: Point | undefined): Point {
    return snapped(shift && from ? squared(at, from) : at);
}

function click(pointer: Pointer) {
    const [first] = sketch.value;
    const near = first && distance(pointer.at, first) < 1.5 * pointer.reach;
    if (drawn()!.line) {
        // Two clicks at one place are no line.
        if (!near) addPoint({ ...pointer, at: aimed(pointer, first), double: false }, 2, finish);
    } else if (near && sketch.value.length >= 3) finish();
    else addPoint({ ...pointer, at: aimed(pointer, sketch.value.at(-1)) }, MOST.corners, finish);
}

function grab(decision: DecisionConfig, { at, reach }: Pointer): boolean {
    for (const [k, place] of placesOf(decision).entries()) {
        const corners = cornersOf(place);
        const corner = corners.findIndex((point) => distance(at, point) < reach);
        if (corner < 0 && distance(at, middleOf(corners)) >= 1.5 * reach) continue;
        [picked.value, part, pressed] = [k, corner < 0 ? "all" : corner, corners];
        return true;
    }
    return false;
}

function dragTo(pointer: Pointer) {
    const decision = dragged.value && decisionOf(dragged.value);
    const k = picked.value;
    if (!decision || k === null) return;
    const middle = middleOf(pressed);
    const corners = pressed.map((corner, j): Point => {
        if (part === "all") return snapped([corner[0] + pointer.at[0] - middle[0], corner[1] + pointer.at[1] - middle[1]]);
        return j === part ? aimed(pointer, pressed.at(j - 1)) : corner;
    });
    dragged.value = { kind: "go", decision: changed(decision, k, shaped(placesOf(decision)[k]!, corners)) };
}

export const exitTool: Tool = {
    draws: () => mode.value !== "change",
    down(pointer) {
        clicks.held = null;
        const now = standing.value;
        if (now.kind !== "go") return false;
        if (drawn()) {
            clicks.held = pointer;
            return true;
        }
        if (!grab(now.decision, pointer)) return false;
        dragged.value = now;
        return true;
    },
    move(pointer, drags) {
        hover.value = aimed(pointer, sketch.value.at(-1));
        if (drags && dragged.value) dragTo(pointer);
    },
    cancel() {
        clicks.held = null;
        dragged.value = null;
    },
    up() {
        const { held } = clicks;
        clicks.held = null;
        if (held && drawn()) click(held);
        const next = dragged.value;
        if (!next) return;
        begin("change");
        setMotion(next);
    },
    key: (event) => toolKey(event, finish, remove),
    // There should be room for exits beyond doors.
    extent: () => film.value?.scene.beyond_doors.flat() ?? [],
    paint(context, view, inks) {
        const decision = decisionOf(motion.value);
        if (!decision) return;
        const places = placesOf(decision).map((place, k) => ({ name: place.name, stay: kindOf(decision, k) === "goal", corners: cornersOf(place) }));
        if (dragged.value) paintPlaces(context, places, view, inks, picked.value);
        places.forEach(({ stay, corners }, k) => paintHandles(context, corners, view, inks, stay ? inks.goal : inks.exit, k === picked.value));
        const making = drawn();
        const to = hover.value;
        if (!making || !to) return;
        const { unit } = plan.value;
        const last = sketch.value.at(-1);
        paintPlaces(context, [{ name: "", stay: making.kind === "goal", corners: [...sketch.value, to] }], view, inks, 0);
        const words = last ? length(distance(last, to), unit) : `${length(to[0], unit)}, ${length(to[1], unit)}`;
        label(context, words, last ? [(last[0] + to[0]) / 2, (last[1] + to[1]) / 2] : [to[0], to[1] - (18 * devicePixelRatio) / view.scale], view, inks);
    },
};
