// The line over which people are counted, and the area in which they are: drawn, or written.

import { Fragment } from "preact";
import { type Inks, label, strokes, through } from "./draw";
import { t } from "./language";
import { Button, PointFields } from "./parts";
import { change, type Plan, plan } from "./plan";
import type { Point } from "./protocol";
import { begin, drawingKey, hover, mode, over, sketch, type Tool, turn } from "./tool";
import { inMetres, type View } from "./view";

type Line = [Point, Point];
type Kind = "line" | "area";

/** Both are drawn from one point to another one: of an area, opposite corners. */
function drawing(kind: Kind, paint: typeof paintLine): Tool {
    return {
        draws: () => true,
        down: ({ at }) => {
            sketch.value = [at];
            return true;
        },
        move: ({ at }) => void (hover.value = at),
        cancel: () => void (sketch.value = []),
        up: ({ at, reach }) => {
            const [from] = sketch.value;
            sketch.value = [];
            if (!from || Math.hypot(at[0] - from[0], at[1] - from[1]) < reach) return;
            if (kind === "area" && Math.min(Math.abs(at[0] - from[0]), Math.abs(at[1] - from[1])) < reach) return;
            put(kind, [from, at].map(([x, y]) => [Number(x.toFixed(3)), Number(y.toFixed(3))]) as Line);
        },
        key: (event) => drawingKey(event, () => {}),
        paint: (context, view, inks) => {
            const [from] = sketch.value;
            if (from && hover.value) paint(context, [from, hover.value], view, inks);
        },
    };
}

over.line = drawing("line", (...all) => paintLine(...all));
over.area = drawing("area", (...all) => paintArea(...all));
const CHARTS: Record<Kind, Plan["chart"]> = { line: "flow", area: "density" };

function put(kind: Kind, line: Line) {
    begin("change");
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

export function MeasureButtons() {
    return (
        <>
            {(["line", "area"] as const).map((kind) => {
                const there = plan.value[kind] !== null;
                const on = mode.value === kind;
                const [seen, first, again, remove] = WORDS[kind];
                const name = there ? again : first;
                return (
                    <Fragment key={kind}>
                        <Button words={seen} aria-label={name} title={name} aria-pressed={on} onClick={() => turn(kind)} />
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
    const on = mode.value === kind;
    const line = plan.value[kind] ?? (on ? ([[0, 0], [1, kind === "area" ? 1 : 0]] as Line) : null);
    if (!line) return null;
    const name = kind === "line" ? t("Line") : t("Area");
    const draw = kind === "line" ? t("Draw the line on the picture, or write where it is") : t("Draw the area on the picture, or write where it is");
    return (
        <fieldset class="fields four">
            <legend>{on ? draw : kind === "line" ? t("Line from A to B") : t("Area between two corners")}</legend>
            {line.map((at, end) => (
                <PointFields key={end} name={`${name} ${"AB"[end]}`} at={at} onChange={(to) => put(kind, line.map((old, k) => (k === end ? to : old)) as Line)} />
            ))}
        </fieldset>
    );
}
