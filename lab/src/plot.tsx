// One chart over the time of a run.

import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import "./charts.css";
import { dark } from "./colour";
import type { Film } from "./film";
import { local } from "./language";

export interface Line {
    label: string;
    /** A colour of charts.css. */
    colour: string;
    /** A count: it changes in steps. */
    counts?: boolean;
}

interface PlotProps {
    film: Film;
    title: string;
    unit: string;
    lines: Line[];
    /** Seconds, and a row of numbers for each line. */
    data: uPlot.AlignedData;
    /** The unit of the axis, if it is not that of the time. */
    along?: string;
    /** Where the axis ends: that of the time, in s, as the timeline's. */
    end: number;
    /** Value of each line at the shown time. */
    now: string[];
    /** All of it in words. */
    summary: string;
}

const HEIGHT = 118;
/** In pixels: what is at the left of the timeline, too (style.css). */
const GUTTER = 76;
/** Distances of ticks of counts. */
const WHOLE = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000];

/** Frames that a chart of limited width shows: groups of equal length, by their last frames. */
export function groups(count: number, most = 1000): { size: number; ends: number[] } {
    const size = Math.max(1, Math.ceil(count / most));
    const ends: number[] = [];
    for (let end = size - 1; end < count - 1; end += size) ends.push(end);
    ends.push(count - 1);
    return { size, ends };
}

/** A number for each group: of its frames the greatest, or the mean. */
export function grouped(value: (k: number) => number, ends: number[], kind: "mean" | "greatest"): (number | null)[] {
    let k = 0;
    return ends.map((end) => {
        let [sum, greatest, count] = [0, 0, 0];
        for (; k <= end; k++) {
            const one = value(k);
            // Of who has left, there is no number.
            if (Number.isNaN(one)) continue;
            sum += one;
            count += 1;
            if (one > greatest) greatest = one;
        }
        if (count === 0) return null;
        return kind === "mean" ? sum / count : greatest;
    });
}

function colourOf(element: Element, name: string) {
    return getComputedStyle(element).getPropertyValue(name);
}

export function Plot({ film, title, unit, lines, data, end, now, summary, along }: PlotProps) {
    const place = useRef<HTMLDivElement>(null);
    const plot = useRef<uPlot | null>(null);
    const last = useRef(end);
    last.current = end;
    const shape = lines.map(({ label, colour, counts }) => `${label} ${colour} ${counts}`).join();
    useEffect(() => {
        const on = place.current!;
        const ink = () => colourOf(on, "--ink");
        const grid = { stroke: () => colourOf(on, "--grid"), width: 1 };
        const axis = { stroke: ink, grid, ticks: { ...grid, size: 4 }, font: "12px system-ui, sans-serif" };
        const made = new uPlot(
            {
                width: Math.max(120, on.clientWidth),
                height: HEIGHT,
                // The axis of time lies under the timeline.
                padding: [null, 24, null, 0],
                legend: { show: false },
                cursor: { drag: { x: false, y: false }, y: false, points: { show: false } },
                scales: { x: { time: false, range: () => [0, last.current] }, y: { range: (_, __, most) => [0, most > 0 ? 1.05 * most : 1] } },
                axes: [
                    { ...axis, size: 26, gap: 2, values: (_, values) => values.map((value) => `${local(value)} ${along ?? "s"}`) },
                    { ...axis, size: GUTTER, gap: 4, incrs: lines.some(({ counts }) => counts) ? WHOLE : undefined },
                ],
                series: [
                    {},
                    ...lines.map(({ label, colour, counts }) => ({
                        label,
                        stroke: () => colourOf(on, colour),
                        width: 2,
                        points: { show: false },
                        paths: counts ? uPlot.paths.stepped!({ align: 1 }) : undefined,
                    })),
                ],
            },
            data,
            on,
        );
        plot.current = made;
        const marker = document.createElement("div");
        marker.className = "shown";
        made.over.append(marker);
        marker.hidden = along !== undefined;
        const mark = () => {
            const x = made.valToPos(film.shown.value * film.scene.step, "x");
            // While it plays, the lines follow a little later.
            marker.style.transform = `translateX(${Math.min(x, made.bbox.width / uPlot.pxRatio)}px)`;
        };
        made.hooks.draw = [mark];
        const stopMarking = effect(mark);
        made.over.addEventListener("click", (event) => {
            if (!along) void film.show(Math.round(made.posToVal(event.offsetX, "x") / film.scene.step));
        });
        const observer = new ResizeObserver(() => made.setSize({ width: Math.max(120, on.clientWidth), height: HEIGHT }));
        observer.observe(on);
        const stopColouring = effect(() => (dark.value, made.redraw(false, true)));
        return () => {
            stopMarking();
            observer.disconnect();
            stopColouring();
            made.destroy();
        };
    }, [film, shape]);
    useEffect(() => {
        if (plot.current && data.length === lines.length + 1) plot.current.setData(data);
    }, [data, end, shape]);
    return (
        <figure class="chart">
            <figcaption>
                <span class="title">
                    {title}
                    {unit && ` [${unit}]`}
                </span>
                {lines.map(({ label, colour }, k) => (
                    <span key={label} class="line">
                        <svg viewBox="0 0 10 10" class={`swatch ${colour.slice(2)}`} aria-hidden="true">
                            <rect y="3" width="10" height="4" />
                        </svg>
                        {label} <span class="number">{now[k]}</span>
                    </span>
                ))}
            </figcaption>
            <div ref={place} role="img" aria-label={summary} />
        </figure>
    );
}
