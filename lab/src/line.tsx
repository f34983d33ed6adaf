// The line over which people are counted: drawn, or written.

import { signal } from "@preact/signals";
import type { Inks } from "./draw";
import { label } from "./draw";
import { LengthField } from "./parts";
import { change, plan } from "./plan";
import type { Point } from "./protocol";
import { lineTool, type Tool } from "./tool";
import { inMetres, type View } from "./view";

type Line = [Point, Point];

const drawn = signal<Line | null>(null);

const drawing: Tool = {
    draws: () => true,
    down: ({ at }) => {
        drawn.value = [at, at];
        return true;
    },
    move: ({ at }, pressed) => {
        if (pressed && drawn.value) drawn.value = [drawn.value[0], at];
    },
    cancel: () => {
        drawn.value = null;
    },
    up: ({ at, reach }) => {
        const line = drawn.value;
        drawn.value = null;
        if (!line || Math.hypot(at[0] - line[0][0], at[1] - line[0][1]) < reach) return;
        lineTool.value = null;
        change({ chart: "flow", line: [line[0], at].map(([x, y]) => [Number(x.toFixed(3)), Number(y.toFixed(3))]) as Line });
    },
    key: (event) => {
        if (event.key !== "Escape") return false;
        lineTool.value = null;
        return true;
    },
    paint: (context, view, inks) => {
        if (drawn.value) paintLine(context, drawn.value, view, inks);
    },
};

export function paintLine(context: CanvasRenderingContext2D, [from, to]: Line, view: View, inks: Inks) {
    inMetres(context, view);
    const pixel = devicePixelRatio / view.scale;
    for (const [colour, width] of [[inks.paper, 6], [inks.pick, 3]] as const) {
        context.strokeStyle = colour;
        context.lineWidth = width * pixel;
        context.beginPath();
        context.moveTo(...from);
        context.lineTo(...to);
        context.stroke();
    }
    label(context, "A", from, view, inks);
    label(context, "B", to, view, inks);
}

export function LineButton() {
    const { line } = plan.value;
    const on = lineTool.value !== null;
    return (
        <>
            <button
                type="button"
                aria-pressed={on}
                onClick={() => {
                    lineTool.value = on ? null : drawing;
                }}
            >
                {line ? "Draw the line anew" : "Count over a line"}
            </button>
            {line && (
                <button type="button" onClick={() => change({ line: null })}>
                    Remove the line
                </button>
            )}
        </>
    );
}

export function LineFields() {
    const on = lineTool.value !== null;
    const line = plan.value.line ?? (on ? ([[0, 0], [1, 0]] as Line) : null);
    if (!line) return null;
    const set = (end: 0 | 1, axis: 0 | 1, value: number) => {
        const next: Line = [[...line[0]], [...line[1]]];
        next[end][axis] = value;
        lineTool.value = null;
        change({ line: next });
    };
    return (
        <fieldset class="fields four">
            <legend>{on ? "Draw the line on the picture, or write where it is" : "Line from A to B"}</legend>
            {([0, 1] as const).flatMap((end) =>
                ([0, 1] as const).map((axis) => {
                    const short = `${"AB"[end]}, ${"xy"[axis]}`;
                    return (
                        <LengthField
                            key={short}
                            label={`Line ${short}`}
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
