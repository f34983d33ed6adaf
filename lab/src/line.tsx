// The line over which people are counted, and the area in which they are: drawn, or written.

import { signal } from "@preact/signals";
import { Fragment } from "preact";
import { type Inks, label, strokes, through } from "./draw";
import { t } from "./language";
import { begin as beginMotion } from "./motionstate";
import { Button, LengthField } from "./parts";
import { change, type Plan, plan } from "./plan";
import type { Point } from "./protocol";
import { begin as beginRoom } from "./roomtool";
import { lineTool, type Tool } from "./tool";
import { inMetres, type View } from "./view";

type Line = [Point, Point];
type Kind = "line" | "area";

const drawn = signal<Line | null>(null);

/** Both are drawn from one point to another one: of an area, opposite corners. */
function drawing(kind: Kind, paint: typeof paintLine): Tool {
    return {
        draws: () => true,
        down: ({ at }) => {
            drawn.value = [at, at];
            return true;
        },
        move: ({ at }, pressed) => {
            if (pressed && drawn.value) drawn.value = [drawn.value[0], at];
        },
        cancel: () => void (drawn.value = null),
        up: ({ at, reach }) => {
            const line = drawn.value;
            drawn.value = null;
            if (!line || Math.hypot(at[0] - line[0][0], at[1] - line[0][1]) < reach) return;
            if (kind === "area" && Math.min(Math.abs(at[0] - line[0][0]), Math.abs(at[1] - line[0][1])) < reach) return;
            lineTool.value = null;
            put(kind, [line[0], at].map(([x, y]) => [Number(x.toFixed(3)), Number(y.toFixed(3))]) as Line);
        },
        key: (event) => {
            if (event.key !== "Escape") return false;
            lineTool.value = null;
            return true;
        },
        paint: (context, view, inks) => {
            if (drawn.value) paint(context, drawn.value, view, inks);
        },
    };
}

const TOOLS: Record<Kind, Tool> = { line: drawing("line", (...all) => paintLine(...all)), area: drawing("area", (...all) => paintArea(...all)) };
const CHARTS: Record<Kind, Plan["chart"]> = { line: "flow", area: "density" };

function put(kind: Kind, line: Line) {
    change({ chart: CHARTS[kind], [kind]: line });
}

export function paintArea(context: CanvasRenderingContext2D, [from, to]: Line, view: View, inks: Inks) {
    inMetres(context, view);
    const pixel = devicePixelRatio / view.scale;
    context.strokeStyle = inks.pick;
    context.lineWidth = 2 * pixel;
    context.setLineDash([8 * pixel, 5 * pixel]);
    context.strokeRect(from[0], from[1], to[0] - from[0], to[1] - from[1]);
    context.setLineDash([]);
    label(context, t("area"), [(from[0] + to[0]) / 2, Math.max(from[1], to[1])], view, inks);
}

export function paintLine(context: CanvasRenderingContext2D, [from, to]: Line, view: View, inks: Inks) {
    inMetres(context, view);
    const pixel = devicePixelRatio / view.scale;
    through(context, [from, to]);
    strokes(context, [[inks.paper, 6 * pixel], [inks.pick, 3 * pixel]]);
    label(context, "A", from, view, inks);
    label(context, "B", to, view, inks);
}

/** What is seen, and the whole names. */
const WORDS: Record<Kind, [string, string, string, string]> = {
    line: [t("Line"), t("Count over a line"), t("Draw the line anew"), t("Remove the line")],
    area: [t("Area"), t("Measure an area"), t("Draw the area anew"), t("Remove the area")],
};

function begin(kind: Kind, on: boolean) {
    // Two tools cannot draw at once.
    beginRoom("change");
    beginMotion("change");
    lineTool.value = on ? null : TOOLS[kind];
}

export function MeasureButtons() {
    return (
        <>
            {(["line", "area"] as const).map((kind) => {
                const there = plan.value[kind] !== null;
                const on = lineTool.value === TOOLS[kind];
                const [seen, first, again, remove] = WORDS[kind];
                const name = there ? again : first;
                return (
                    <Fragment key={kind}>
                        <Button words={seen} aria-label={name} title={name} aria-pressed={on} onClick={() => begin(kind, on)} />
                        {there && (
                            <Button words="×" aria-label={remove} title={remove} onClick={() => change({ [kind]: null })} />
                        )}
                    </Fragment>
                );
            })}
        </>
    );
}

/** The points of a line or an area as numbers. */
export function MeasureFields({ kind }: { kind: Kind }) {
    const on = lineTool.value === TOOLS[kind];
    const line = plan.value[kind] ?? (on ? ([[0, 0], [1, kind === "area" ? 1 : 0]] as Line) : null);
    if (!line) return null;
    const set = (end: 0 | 1, axis: 0 | 1, value: number) => {
        const next: Line = [[...line[0]], [...line[1]]];
        next[end][axis] = value;
        lineTool.value = null;
        put(kind, next);
    };
    const name = kind === "line" ? t("Line") : t("Area");
    const draw = kind === "line" ? t("Draw the line on the picture, or write where it is") : t("Draw the area on the picture, or write where it is");
    return (
        <fieldset class="fields four">
            <legend>{on ? draw : kind === "line" ? t("Line from A to B") : t("Area between two corners")}</legend>
            {([0, 1] as const).flatMap((end) =>
                ([0, 1] as const).map((axis) => {
                    const short = `${"AB"[end]}, ${"xy"[axis]}`;
                    return (
                        <LengthField
                            key={short}
                            label={`${name} ${short}`}
                            short={short}
                            value={line[end][axis]}
                            min={-1000}
                            max={1000}
                            onChange={(value) => set(end, axis, value)}
                        />
                    );
                }),
            )}
        </fieldset>
    );
}
