// Charts beside a run: the crowd, the selected person, the flow over a line.

import { effect, signal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Client } from "./client";
import type { Film } from "./film";
import { Flow } from "./flow";
import { digits } from "./parts";
import { grouped, groups, type Line, Plot } from "./plot";
import type { Point } from "./protocol";

/** Milliseconds between two updates while it plays. */
const PAUSE = 200;

interface ChartsProps {
    film: Film;
    selected: number | null;
    line: [Point, Point] | null;
    client: Client;
}

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

export function Charts({ film, selected, line, client }: ChartsProps) {
    useSlowly(film);
    const { frames, scene } = film;
    const { ends } = groups(frames.count);
    const seconds = ends.map((k) => k * scene.step);
    const shown = Math.min(film.shown.peek(), frames.count - 1);
    const agent = selected !== null && selected < scene.agents.length ? selected : null;
    const name = agent !== null ? `Person ${scene.agents[agent]!.id}` : "";
    const speed = (k: number) => Math.hypot(frames.number(k, agent!, 3), frames.number(k, agent!, 4));
    const squeeze = (k: number) => frames.number(k, agent!, 6);
    const whole = `over ${digits(seconds.at(-1)!, 3)} s`;

    const curves = (title: string, unit: string, decimals: number, given: [Line, (k: number) => number, "mean" | "greatest"][]) => {
        const rows = given.map(([, value, kind]) => grouped(value, ends, kind));
        const now = given.map(([, value]) => value(shown).toFixed(decimals));
        const range = (row: number[]) => `${Math.min(...row).toFixed(decimals)} to ${Math.max(...row).toFixed(decimals)} ${unit}`;
        const words = given.map(([{ label }], k) => `${label}: now ${now[k]} ${unit}, ${range(rows[k]!)} ${whole}`);
        return (
            <Plot
                film={film}
                title={title}
                unit={unit}
                lines={given.map(([one]) => one)}
                data={[seconds, ...rows]}
                now={now}
                summary={`${title}. ${words.join(". ")}.`}
            />
        );
    };
    const of = (curve: Parameters<typeof frames.curve>[0]) => {
        const numbers = frames.curve(curve);
        return (k: number) => numbers[k]!;
    };
    return (
        <section class="charts" aria-label="Charts">
            {curves("Speed", "m/s", 2, [
                [{ label: "Mean of all", colour: "--one" }, of("speed"), "mean"],
                ...(agent === null ? [] : [[{ label: name, colour: "--three" }, speed, "mean"] as [Line, typeof speed, "mean"]]),
            ])}
            {curves("Mean squeeze", "N", 0, [[{ label: "Of all", colour: "--one" }, of("squeeze"), "mean"]])}
            {curves("Greatest squeeze", "N", 0, [
                [{ label: "Of all", colour: "--two" }, of("greatest"), "greatest"],
                ...(agent === null ? [] : [[{ label: name, colour: "--three" }, squeeze, "mean"] as [Line, typeof squeeze, "mean"]]),
            ])}
            {scene.leaving > 0 && curves("Have left", "people", 0, [[{ label: "People", colour: "--one" }, of("left"), "greatest"]])}
            {line && <FlowChart film={film} line={line} client={client} ends={ends} />}
            <p class="note">
                Squeeze is the sum of the normal forces on a person. The charts show its mean over each communication step. Disks with stiff springs touch here, so
                short impacts have higher peaks than soft bodies would.
            </p>
        </section>
    );
}

function FlowChart({ film, line, client, ends }: { film: Film; line: [Point, Point]; client: Client; ends: number[] }) {
    const flow = useMemo(() => new Flow(client, film, line), [client, film, JSON.stringify(line)]);
    const { step } = film.scene;
    useEffect(() => void flow.follow());
    if (flow.refused.value) return <p role="alert">{flow.refused.value}</p>;
    const counted = Math.max(1, flow.counted.value);
    const there = ends.filter((k) => k < counted);
    const ways = [1, -1] as const;
    const rows = ways.map((way) => flow.counts(way, there));
    const now = ways.map((way) => String(flow.counts(way, [Math.min(film.shown.peek(), counted - 1)])[0]));
    const words = ways.map((way) => {
        const mean = flow.mean(way);
        const total = flow.crossings[way].length;
        return `${flow.arrow(way)} ${total} people${mean === null ? "" : `, ${digits(mean, 3)} per second`}`;
    });
    return (
        <div>
            <Plot
                film={film}
                title="Crossed the line"
                unit=""
                lines={ways.map((way, k) => ({ label: flow.arrow(way), colour: k ? "--two" : "--one", counts: true }))}
                data={[there.map((k) => k * step), ...rows]}
                now={now}
                summary={`People who crossed the line in ${digits(counted * step, 3)} s: ${words.join("; ")}.`}
            />
            <p class="note">{words.join("; ")} (mean flow from the first to the last of them)</p>
        </div>
    );
}
