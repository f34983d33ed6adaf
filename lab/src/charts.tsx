// Charts beside a run: the crowd, the selected person, the flow over a line.

import { effect, signal } from "@preact/signals";
import { type ComponentChildren, Fragment } from "preact";
import { useEffect, useMemo } from "preact/hooks";
import { askedOf } from "./answer";
import { Inside } from "./area";
import { averaged, meanWords } from "./colour";
import { byRow, eventOf } from "./event";
import type { Film } from "./film";
import { Flow } from "./flow";
import { SQUEEZE } from "./frames";
import { beside } from "./kept";
import { count, local, t } from "./language";
import { Choice, digits, named } from "./parts";
import { change, type Plan, plan } from "./plan";
import { grouped, groups, type Line, Plot } from "./plot";
import { CHEST, type Point } from "./protocol";
import { selected } from "./session";
import { lastOf } from "./transport";

/** Milliseconds between two updates while it plays. */
const PAUSE = 200;

/** Counts up when there are other frames or another one is shown, but not more often than every `PAUSE`. */
function useSlowly(film: Film) {
    const turn = useMemo(() => signal(0), [film]);
    useEffect(() => {
        let timer: ReturnType<typeof setTimeout> | undefined;
        let last = 0;
        const stop = effect(() => {
            void film.computed.value;
            void film.shown.value;
            timer ??= setTimeout(
                () => {
                    timer = undefined;
                    last = performance.now();
                    turn.value += 1;
                },
                Math.max(0, last + PAUSE - performance.now()),
            );
        });
        return () => {
            stop();
            clearTimeout(timer);
        };
    }, [film]);
    return turn.value;
}

export function Charts({ film }: { film: Film }) {
    useSlowly(film);
    const { frames, scene } = film;
    const { ends } = groups(frames.count);
    const seconds = ends.map((k) => k * scene.step);
    const end = lastOf(film) * scene.step;
    const shown = Math.min(film.shown.peek(), frames.count - 1);
    const agent = selected.value !== null && selected.value < scene.agents.length ? selected.value : null;
    const name = agent !== null ? t("Person {id}", { id: named(scene.agents[agent]!.id) }) : "";
    const there = (k: number) => !Number.isNaN(frames.number(k, agent!, 0));
    const speed = (k: number) => (there(k) ? Math.hypot(frames.number(k, agent!, 3), frames.number(k, agent!, 4)) : NaN);
    const last = averaged(film);
    const force = (column: number) => (k: number) => (there(k) ? frames.meanOf(k, last, agent!, column) : NaN);
    const whole = digits(seconds.at(-1)!, 3);

    const { area, line } = plan.value;
    const inside = useMemo(() => area && new Inside(film, area), [film, JSON.stringify(area)]);
    inside?.follow();
    const time = digits(shown * scene.step, 3);

    const curves = (title: string, unit: string, decimals: number, given: [Line, (k: number) => number, "mean" | "greatest"][]) => {
        const rows = given.map(([, value, kind]) => grouped(value, ends, kind));
        const fixed = (value: number) => (Number.isNaN(value) ? "–" : value < 1e9 ? local(value.toFixed(decimals)) : digits(value, 3));
        const now = given.map(([, value]) => fixed(value(shown)));
        const range = (row: (number | null)[]) => {
            const known = row.filter((value) => value !== null);
            return { least: fixed(Math.min(...known)), most: fixed(Math.max(...known)) };
        };
        const words = given.map(([{ label }], k) => t("{label}: now {now} {unit}, {least} to {most} {unit} over {whole} s", { label, now: now[k]!, unit, whole, ...range(rows[k]!) }));
        return (
            <Plot
                film={film}
                title={title}
                unit={unit}
                lines={given.map(([one]) => one)}
                data={[seconds, ...rows]}
                end={end}
                now={now}
                summary={`${title}. ${words.join(". ")}.`}
            />
        );
    };
    const of = (curve: Parameters<typeof frames.curve>[0]) => {
        const numbers = frames.curve(curve);
        return (k: number) => numbers[k]!;
    };
    const left = of("left");
    const other = beside.value;
    /** The same of the run that is kept, at the same times. */
    const ofKept = (row: (run: Film) => ArrayLike<number>, kind: "mean" | "greatest", counts = false): [Line, (k: number) => number, typeof kind][] => {
        if (!other) return [];
        const [numbers, gone] = [row(other), other.frames.curve("left")];
        const at = (k: number) => Math.round((k * scene.step) / other.scene.step);
        return [[{ label: t("The run that is kept"), colour: "--four" }, (k) => (counts || gone[at(k)]! < other.scene.agents.length ? (numbers[at(k)] ?? NaN) : NaN), kind]];
    };
    /** Nothing of nobody. */
    const ofThose = (value: (k: number) => number) => (k: number) => (left(k) < scene.agents.length ? value(k) : NaN);
    /** Of all the greatest mean of a force, and that of who is selected. */
    const greatest = (title: string, column: number) => {
        const most = frames.greatestMean(last, column);
        return curves(title, "N", 0, [
            [{ label: t("Of all"), colour: "--two" }, ofThose((k) => most[k]!), "greatest"],
            ...(column === CHEST && !other?.scene.chests ? [] : ofKept((run) => run.frames.greatestMean(averaged(run), column), "greatest")),
            ...(agent === null ? [] : [[{ label: name, colour: "--three" }, force(column), "greatest"] as [Line, (k: number) => number, "greatest"]]),
        ]);
    };
    const charts: Record<Chart, () => ComponentChildren> = {
        speed: () =>
            curves(t("Speed"), "m/s", 2, [
                [{ label: t("Mean of all"), colour: "--one" }, ofThose(of("speed")), "mean"],
                ...ofKept((run) => run.frames.curve("speed"), "mean"),
                ...(agent === null ? [] : [[{ label: name, colour: "--three" }, speed, "mean"] as [Line, typeof speed, "mean"]]),
            ]),
        mean: () => curves(t("Mean squeeze"), "N", 0, [[{ label: t("Of all"), colour: "--one" }, ofThose(of("squeeze")), "mean"], ...ofKept((run) => run.frames.curve("squeeze"), "mean")]),
        greatest: () => greatest(t("Greatest squeeze ({mean})", { mean: meanWords(film) }), SQUEEZE),
        chest: () => scene.chests && greatest(t("Greatest load on a chest ({mean})", { mean: meanWords(film) }), CHEST),
        left: () => scene.leaving > 0 && curves(t("Have left"), t("people"), 0, [[{ label: t("People"), colour: "--one" }, left, "greatest"], ...ofKept((run) => run.frames.curve("left"), "greatest", true)]),
        density: () => area && inside && (
            <>
                {curves(t("In the area"), t("per m²"), 2, [[{ label: t("People"), colour: "--one" }, (k) => inside.counts[k]! / inside.size, "mean"]])}
                <p class="note">
                    {t("{n} people on {area} m²", { n: inside.counts[shown]!, area: digits(inside.size, 3) })}
                    {!Number.isNaN(inside.squeezes[shown]!) && t(", their mean squeeze {squeeze} N", { squeeze: digits(inside.squeezes[shown]!, 3) })} {t("(centres of mass inside; {time} s)", { time })}
                </p>
            </>
        ),
        rows: () => {
            const [far, ...rows] = byRow(film, shown);
            const [now, most] = rows.map((row) => String(Math.round(Math.max(...row))));
            const lines = [{ label: t("Now"), colour: "--one" }, { label: t("Greatest so far"), colour: "--two" }];
            const summary = t("Squeeze by row, up to {time} s: at most {most} N; now {now} N.", { time, most: most!, now: now! });
            return <Plot film={film} title={t("Squeeze by row")} unit="N" lines={lines} data={[far, ...rows]} end={far.at(-1) || 1} now={[now!, most!]} summary={summary} along="m" />;
        },
        flow: () => line && <FlowChart film={film} line={line} ends={ends} end={end} />,
    };
    const offered = CHARTS.filter(([key]) => (key === "left" ? scene.leaving > 0 : key === "density" ? area : key === "rows" ? eventOf(film) : key === "chest" ? scene.chests : key !== "flow" || line));
    const { chart } = plan.value;
    const asked = askedOf(film) === "squeeze" ? "greatest" : "left";
    const chosen = chart === "all" || offered.some(([key]) => key === chart) ? (chart as Chart | "all") : asked;
    return (
        <section class="charts" aria-label={t("Charts")}>
            <Choice label={t("Chart")} value={chosen} choices={[...offered, ["all", t("All of them")]]} onChange={(chart) => change({ chart })} />
            {chosen === "all" ? offered.map(([key]) => <Fragment key={key}>{charts[key]()}</Fragment>) : charts[chosen]()}
        </section>
    );
}

type Chart = Exclude<Plan["chart"], "all" | "asked">;
const CHARTS: [Chart, string][] = [
    ["greatest", t("Greatest squeeze [N]")],
    ["mean", t("Mean squeeze [N]")],
    ["chest", t("Load on a chest [N]")],
    ["speed", t("Speed [m/s]")],
    ["left", t("Have left [people]")],
    ["rows", t("Squeeze by row [N]")],
    ["flow", t("Crossed the line")],
    ["density", t("In the area [people per m²]")],
];

function FlowChart({ film, line, ends, end }: { film: Film; line: [Point, Point]; ends: number[]; end: number }) {
    const flow = useMemo(() => new Flow(film, line), [film, JSON.stringify(line)]);
    const { step } = film.scene;
    useEffect(() => void flow.follow());
    if (flow.refused.value) return <p role="alert">{flow.refused.value}</p>;
    const counted = Math.max(1, flow.counted.value);
    const there = ends.filter((k) => k < counted);
    const ways = [1, -1] as const;
    const rows = ways.map((way) => flow.counts(way, there));
    const now = ways.map((way) => String(flow.counts(way, [Math.min(film.shown.peek(), counted - 1)])[0]));
    const until = Math.min(film.shown.peek(), counted - 1);
    const words = ways.map((way) => {
        const mean = flow.mean(way, until);
        const total = flow.counts(way, [until])[0]!;
        return `${flow.arrow(way)} ${count(total, "{n} person", "{n} people")}${mean === null ? "" : t(", {flow} per second", { flow: digits(mean, 3) })}`;
    });
    return (
        <div>
            <Plot
                film={film}
                title={t("Crossed the line")}
                unit=""
                lines={ways.map((way, k) => ({ label: flow.arrow(way), colour: k ? "--two" : "--one", counts: true }))}
                data={[there.map((k) => k * step), ...rows]}
                end={end}
                now={now}
                summary={t("People who crossed the line in {until} s: {words}.", { until: digits(until * step, 3), words: words.join("; ") })}
            />
            <p class="note">{words.join("; ")} {t("(until {until} s; mean flow from the first to the last of them)", { until: digits(until * step, 3) })}</p>
        </div>
    );
}
