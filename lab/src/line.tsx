// The line over which people are counted, and the area in which they are: drawn, or written.

import { type Inks, label, strokes, through } from "./draw";
import { draws, sides } from "./handles";
import { t } from "./language";
import { Button, PointFields } from "./parts";
import { change, plan } from "./plan";
import type { Point } from "./protocol";
import { distance } from "./roomshape";
import { endOf, mode, turn } from "./tool";
import { inMetres, type View } from "./view";

type Line = [Point, Point];
type Kind = "line" | "area";

const isArea = (points: Point[], drags: boolean) => points.length > 1 && !drags;

draws({
    measure: {
        points: [2, 2],
        drag: true,
        place: ({ at }) => at.map((place) => Number(place.toFixed(3))) as Point,
        fits: ([from, to], { reach }, drags) => (drags ? distance(from!, to!) > reach : [0, 1].every((axis) => Math.abs(from![axis]! - to![axis]!) > reach)),
        done: ([from, to], drags) => put(drags ? "line" : "area", [from!, to!]),
        paint: (context, points, view, inks, drags) => points[1] && (isArea(points, drags) ? paintArea : paintLine)(context, points as Line, view, inks),
        words: (points, drags) => (isArea(points, drags) ? sides(points) : undefined),
    },
});

const put = (kind: Kind, line: Line) => change({ chart: kind === "line" ? "flow" : "density", [kind]: line });

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

export const MEASURE = t("Draw a line to count who crosses it, or click two opposite corners of an area.");

export function MeasureButtons() {
    const { line, area } = plan.value;
    const remove = t("Remove the line and the area");
    return (
        <>
            <Button words={t("Measure here")} title={MEASURE} aria-pressed={mode.value === "measure"} onClick={() => turn("measure")} />
            {(line || area) && <Button words="×" aria-label={remove} title={remove} onClick={() => change({ line: null, area: null })} />}
        </>
    );
}

/** The points of a line or an area as numbers. */
export function MeasureFields({ kind }: { kind: Kind }) {
    const line = plan.value[kind] ?? (mode.value === "measure" ? ([[0, 0], [1, kind === "area" ? 1 : 0]] as Line) : null);
    if (!line) return null;
    const name = kind === "line" ? t("Line") : t("Area");
    return (
        <fieldset class="fields four">
            <legend>{kind === "line" ? t("Line from A to B") : t("Area between two corners")}</legend>
            {line.map((at, end) => (
                <PointFields key={end} name={`${name} ${"AB"[end]}`} at={at} onChange={(to) => (endOf(["measure"]), put(kind, line.map((old, k) => (k === end ? to : old)) as Line))} />
            ))}
        </fieldset>
    );
}
