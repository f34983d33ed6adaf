// The picture: what is drawn on it, and what the pointer and keys do there.

import { effect, signal, untracked } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { paintBackdrop, reachOfBackdrop } from "./backdrop";
import { byPlace, mapKind, NAMES, pointed } from "./byplace";
import { averaged, colourOf, isForce, scaleOf, shade, values } from "./colour";
import { type Inks, inksOf, label, Painter, paintBar, paintPush, paintWays } from "./draw";
import { paintPlaces } from "./drawplaces";
import type { Film } from "./film";
import { kept } from "./kept";
import { about, count, fixed, t } from "./language";
import { empty, hovered, type Layers, show } from "./layout";
import { paintArea, paintLine } from "./line";
import { fit, fits, fitted, look, view, zoom } from "./look";
import { menu, openMenu } from "./menu";
import { brief, digits } from "./parts";
import { plan } from "./plan";
import { COLUMNS, isThere, type Point } from "./protocol";
import { heightOf, sceneAt } from "./sections";
import { film, selected } from "./session";
import { paintStuck } from "./stuck";
import { active, type Pointer, type Tool, tool } from "./tool";
import { fitting, inMetres, toMetres, toPixels, type View, zoomed } from "./view";

export function Canvas({ film, layers }: { film: Film; layers: Layers }) {
    const element = useRef<HTMLCanvasElement>(null);
    const size = useMemo(() => signal(0), []);
    const inks = useRef<Inks | null>(null);
    const height = heightOf(film);
    const painter = useMemo(() => new Painter(sceneAt(film.scene, height)), [film, height]);

    const frame = () => {
        const now = film.frames.at(film.place.value);
        return tool.value?.frame?.(now) ?? now;
    };
    const paint = () => {
        size.value;
        const on = element.current;
        if (!on || on.width === 0) return;
        if (fits.value) {
            const further = [...reach(film), ...(tool.value?.extent?.() ?? [])];
            const next = fitting(film.scene, film.frames.frame(0), further, on.width, on.height);
            untracked(() => (view.value = next));
        }
        const context = on.getContext("2d")!;
        const now = view.value;
        inks.current ??= inksOf(on);
        context.setTransform(1, 0, 0, 1, 0, 0);
        context.clearRect(0, 0, on.width, on.height);
        picture(context, film, painter, frame(), layers, now, inks.current);
    };
    // Painted again when something changes that it reads. It has captured this film and these layers.
    useEffect(() => effect(paint), [film, layers, painter]);
    // Who is under the mouse is somebody else now.
    useEffect(() => () => (hovered.value = menu.value = null), [film]);

    useEffect(() => {
        const on = element.current!;
        const hide = show(on);
        const end = fitted(on, () => {
            inks.current = null;
            size.value += 1;
        });
        return () => {
            end();
            hide();
        };
    }, []);

    const hands = useHands((at: Point) => painter.at(element.current!.getContext("2d")!, frame(), at));
    return (
        <canvas
            ref={element}
            class={active.value?.draws?.() ? "draws" : hovered.value !== null ? "over-person" : undefined}
            tabIndex={0}
            role="application"
            aria-label={count(film.scene.agents.length, "{n} person from above", "{n} people from above")}
            aria-describedby="canvas-keys"
            onKeyDown={(event) => key(event, film)}
            {...hands}
        />
    );
}

/** What should be seen besides people and walls: the corners of exits and goals, the walls of a run beside it and, while they
 * are changed, the points of ways. Circles may be much larger than the room. */
function reach({ scene }: Film): Point[] {
    const beside = kept.value?.film.scene;
    const places = [...scene.targets, ...(beside?.targets ?? []), ...(beside?.walls ?? [])].flatMap(({ corners }) => corners);
    if (plan.value.tab === "room") return [...places, ...reachOfBackdrop()];
    return plan.value.tab === "motion" ? [...places, ...scene.ways.flat().map(({ x, y }): Point => [x, y])] : places;
}

function picture(context: CanvasRenderingContext2D, film: Film, painter: Painter, frame: Float32Array, layers: Layers, now: View, inks: Inks) {
    const { scene } = film;
    const { tab, colour, unit, view: kind, line, area } = plan.value;
    const helper = tool.value;
    // While it plays, a picture follows anyway: none is needed because frames were computed.
    const scale = film.playing.value ? untracked(() => scaleOf(film, colour)) : scaleOf(film, colour);
    const shades = Array.from(values(film, film.shown.value, colour), (value) => shade(scale, value));
    const atStart = film.place.value === 0 ? scene.overlapping : [];
    paintBackdrop(context, now);
    layers.below(context, now);
    painter.walls(context, now, inks, film.place.value * scene.step);
    if (!empty.value) {
        painter.people(
            context,
            {
                frame,
                shades,
                paths: kind === "section" && heightOf(film) === null ? layers.paths() : null,
                selected: selected.value,
                overlapping: helper?.overlapping?.() ?? atStart,
                faint: helper?.faint?.() ?? mapKind.value !== null,
            },
            now,
            inks,
        );
        layers.above(context, now);
    }
    const { motion } = plan.value.made;
    const time = film.place.value * scene.step;
    paintWays(context, scene.ways, now, inks, null, tab === "motion");
    for (const [, at] of scene.crossed) label(context, t("✕ wall"), at, now, inks);
    paintPlaces(context, scene.targets, now, inks);
    if (motion.kind === "push" && !empty.value) for (const push of motion.pushes) paintPush(context, push, time, now, inks, false, tab === "motion");
    if (line) paintLine(context, line, now, inks);
    if (area) paintArea(context, area, now, inks);
    inMetres(context, now);
    if (!empty.value) paintStuck(context, film, frame, inks.mark, devicePixelRatio / now.scale);
    if (mapKind.value) byPlace.value?.paintMost(mapKind.value, context, now, inks);
    paintBar(context, now, unit, inks);
    // What follows is of this moment, and of who looks.
    if (empty.value) return;
    const under = hovered.value;
    const value = mapKind.value && pointed.value && under === null ? valueAt(pointed.value) : "";
    if (value) label(context, value, above(pointed.value!, 22, 24, now), now, inks);
    if (under !== null && isThere(frame, under)) {
        const at: Point = [frame[COLUMNS * under]!, frame[COLUMNS * under + 1]!];
        label(context, told(film, under), above(at, (0.45 * now.scale) / devicePixelRatio, (0.45 * now.scale) / devicePixelRatio, now), now, inks);
    }
    for (const one of new Set([helper, active.value])) {
        inMetres(context, now);
        one?.paint?.(context, now, inks);
    }
}

/** What the map shows at a place. */
export function valueAt(at: Point): string {
    const [kind, places] = [mapKind.value, byPlace.value];
    const value = kind && places ? places.at(kind, at) : NaN;
    return Number.isNaN(value) ? "" : `${about(t(NAMES[kind!]), digits(value, 3))} ${places!.scale(kind!).unit}`;
}

/** So many pixels above a place; where the picture ends there, so many below it. */
function above(at: Point, up: number, down: number, now: View): Point {
    const [x, y] = toPixels(now, at);
    const high = y - up * devicePixelRatio;
    return toMetres(now, x, high < 9 * devicePixelRatio ? y + down * devicePixelRatio : high);
}

/** The numbers of the person under the mouse. */
function told(film: Film, agent: number): string {
    const k = film.shown.value;
    const of = (column: number) => film.frames.number(k, agent, column);
    const squeeze = film.frames.means(k, averaged(film))[agent]!;
    const contacts = of(7);
    let touching = count(contacts, "{n} contact", "{n} contacts");
    const { colour } = plan.value;
    if (colour !== "squeeze" && isForce(colourOf(film, colour))) touching += `, ${about(scaleOf(film, colour).label, digits(values(film, k, colour)[agent]!, 3))} N`;
    return about(brief(film.scene.agents[agent]!.id), `${fixed(Math.hypot(of(3), of(4)), 2)} m/s, ${digits(squeeze, 3)} N, ${touching}`);
}

/** Opens the menu of a place. */
function openAt(on: HTMLCanvasElement, at: Point, agent: number | null) {
    const [x, y] = toPixels(view.value, at);
    // Side by side, it is not at the corner of the frame in which the menu lies.
    openMenu({ left: on.offsetLeft + Math.min(x / devicePixelRatio, on.clientWidth - 230), top: on.offsetTop + Math.min(y / devicePixelRatio, on.clientHeight - 130), at, agent });
}

/** The menu of who is selected, for those who have no mouse. */
function openByKey(on: HTMLCanvasElement, film: Film) {
    const frame = film.frames.frame(film.shown.value);
    const agent = selected.value !== null && isThere(frame, selected.value) ? selected.value : null;
    const at: Point = agent === null ? toMetres(view.value, on.width / 2, on.height / 2) : [frame[COLUMNS * agent]!, frame[COLUMNS * agent + 1]!];
    openAt(on, at, agent);
}

/** Selects with arrows, N and P. */
function key(event: KeyboardEvent, film: Film) {
    const helper = active.value;
    if (helper?.key?.(event)) return event.preventDefault();
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const people = film.scene.agents.length;
    const step = (by: number) => {
        const shown = film.frames.frame(film.shown.value);
        let next = selected.value ?? (by > 0 ? -1 : people);
        // Past those who have left.
        for (let tries = 0; tries < people; tries++) {
            next = (next + by + people) % people;
            if (isThere(shown, next)) break;
        }
        selected.value = people > 0 ? next : null;
    };
    const directions: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const direction = directions[event.key];
    if (direction) towards(film, direction);
    else if (event.key === "n" || event.key === "N") step(1);
    else if (event.key === "p" || event.key === "P") step(-1);
    else if (event.key === "+" || event.key === "=") zoom(1.25);
    else if (event.key === "-") zoom(0.8);
    else if (event.key === "0") fit();
    else if (event.key === "Escape") selected.value = null;
    else if (event.key === " ") film.playing.value = !film.playing.value;
    else if (event.key === "ContextMenu" || (event.key === "F10" && event.shiftKey)) openByKey(event.currentTarget as HTMLCanvasElement, film);
    else return;
    event.preventDefault();
}

/** The next person that way: near, and not far off the line. */
function towards(film: Film, [dx, dy]: Point) {
    const frame = film.frames.frame(film.shown.value);
    const from = selected.value;
    if (from === null) {
        selected.value = 0;
        return;
    }
    let [best, least] = [from, Infinity];
    for (let a = 0; a < film.scene.agents.length; a++) {
        const [x, y] = [frame[COLUMNS * a]! - frame[COLUMNS * from]!, frame[COLUMNS * a + 1]! - frame[COLUMNS * from + 1]!];
        const [along, off] = [x * dx + y * dy, Math.abs(x * dy - y * dx)];
        if (a !== from && along > off / 2 && along + 2 * off < least) [best, least] = [a, along + 2 * off];
    }
    selected.value = best;
}

/** Fingers and the mouse: a tool's, or else moving, pinching and selecting. */
function useHands(agentAt: (at: Point) => number | null) {
    const state = useRef({
        fingers: new Map<number, Point>(),
        mode: "none" as "none" | "pressed" | "tool" | "ground" | "moving" | "pinch",
        /** Who took the press. */
        tool: null as Tool | null,
        start: [0, 0] as Point,
        last: { time: 0, at: [0, 0] as Point },
    }).current;
    const pixel = (event: PointerEvent): Point => [event.offsetX * devicePixelRatio, event.offsetY * devicePixelRatio];
    const pointer = (event: PointerEvent, double = false): Pointer => {
        const at = toMetres(view.value, ...pixel(event));
        return {
            at,
            reach: ((event.pointerType === "touch" ? 22 : 10) * devicePixelRatio) / view.value.scale,
            shift: event.shiftKey,
            get agent() {
                return agentAt(at);
            },
            double,
        };
    };
    const pair = () => {
        const [one, other] = [...state.fingers.values()] as [Point, Point];
        return { x: (one[0] + other[0]) / 2, y: (one[1] + other[1]) / 2, wide: Math.hypot(one[0] - other[0], one[1] - other[1]) };
    };
    /** What is drawn on should not move, nor people meanwhile. */
    const still = () => {
        if (!state.tool?.keeps) fits.value = false;
        if (film.value) film.value.playing.value = false;
    };
    /** What a tool began is as before. */
    const giveUp = () => {
        if (state.mode === "pressed" || state.mode === "tool") state.tool?.cancel?.();
    };
    const onPointerDown = (event: PointerEvent) => {
        if (event.button > 1) return;
        const on = event.currentTarget as HTMLCanvasElement;
        on.setPointerCapture(event.pointerId);
        const at = pixel(event);
        state.fingers.set(event.pointerId, at);
        if (state.fingers.size >= 2) {
            giveUp();
            state.mode = "pinch";
            return;
        }
        const near = Math.hypot(at[0] - state.last.at[0], at[1] - state.last.at[1]) < 8 * devicePixelRatio;
        const double = near && event.timeStamp - state.last.time < 350;
        state.last = { time: event.timeStamp, at };
        state.start = at;
        state.tool = active.value;
        state.mode = event.button === 0 && state.tool?.down?.(pointer(event, double)) ? "pressed" : "ground";
        if (state.mode === "pressed" && state.tool?.draws?.()) still();
    };
    const onPointerMove = (event: PointerEvent) => {
        const at = pixel(event);
        const before = state.fingers.get(event.pointerId);
        if (!before) {
            const where = pointer(event);
            pointed.value = where.at;
            hovered.value = event.pointerType === "mouse" ? where.agent : null;
            return active.value?.move?.(where, false);
        }
        hovered.value = null;
        if (state.mode === "pinch" && state.fingers.size === 2) {
            const from = pair();
            state.fingers.set(event.pointerId, at);
            const to = pair();
            const moved = { ...view.value, x: view.value.x + to.x - from.x, y: view.value.y + to.y - from.y };
            return look(zoomed(moved, to.wide / Math.max(1, from.wide), to.x, to.y));
        }
        state.fingers.set(event.pointerId, at);
        // A hand trembles: a click moves nothing.
        if (Math.hypot(at[0] - state.start[0], at[1] - state.start[1]) > 4 * devicePixelRatio) {
            if (state.mode === "pressed") {
                still();
                state.mode = "tool";
            }
            if (state.mode === "ground") state.mode = "moving";
        }
        if (state.mode === "tool") return state.tool?.move?.(pointer(event), true);
        if (state.mode === "moving") look({ ...view.value, x: view.value.x + at[0] - before[0], y: view.value.y + at[1] - before[1] });
    };
    const end = (event: PointerEvent, whole: boolean) => {
        if (!state.fingers.delete(event.pointerId)) return;
        const drags = state.mode === "pressed" || state.mode === "tool";
        if (drags && whole) state.tool?.up?.(pointer(event));
        else if (drags) giveUp();
        else if (state.mode === "ground" && whole) selected.value = pointer(event).agent;
        if (state.fingers.size === 0) state.mode = "none";
    };
    const onContextMenu = (event: MouseEvent) => {
        event.preventDefault();
        // That of the keyboard has no place: `openByKey`.
        if ((event as PointerEvent).pointerType === "") return;
        const where = pointer(event as PointerEvent);
        openAt(event.currentTarget as HTMLCanvasElement, where.at, where.agent);
    };
    return {
        onContextMenu,
        onPointerDown,
        onPointerMove,
        onPointerLeave: () => (hovered.value = pointed.value = null),
        onPointerUp: (event: PointerEvent) => end(event, true),
        onPointerCancel: (event: PointerEvent) => end(event, false),
    };
}
