// A sweep: the scene with many values of a parameter and many seeds, in workers of its own.

import { signal } from "@preact/signals";
import { Client, Stopped } from "./client";
import { table } from "./csv";
import { meanFlow } from "./flow";
import { ofAllPairs } from "./forms";
import { Frames } from "./frames";
import { about, inWords, type Plain, t } from "./language";
import { beyond } from "./places";
import { type Made, plan, title } from "./plan";
import type { Advanced, Edit, Motion, Opened } from "./protocol";
import { film, sent } from "./session";
import type { Parameter } from "./sliders";

/** Seconds that an answer should take, so that a sweep can be stopped. */
const ANSWER = 0.2;
const MOST_WORKERS = 8;

/** Measures of a run: NaN where there is none. */
export const MEASURES = {
    all_left: ["Time until all have left", "s"],
    left: ["Have left", "people"],
    flow: ["Mean flow", "1/s"],
    greatest_mean_of_1_s: ["Greatest squeeze, mean of 1 s", "N"],
    "greatest_mean_of_0.1_s": ["Greatest squeeze, mean of 0.1 s", "N"],
    mean_squeeze: ["Mean squeeze", "N"],
    deepest_overlap: ["Deepest overlap", "mm"],
} as const satisfies Record<string, [Plain, string]>;
export type Measure = keyof typeof MEASURES;

export interface Run {
    value: number;
    seed: number;
    /** What ran. */
    made: Made;
    /** Changes by hand that did not fit, in words. */
    leftOut: string[];
    measures: Record<Measure, number>;
}

export interface Sweep {
    /** Name of the scene. */
    scene: string;
    made: Made;
    parameter: Parameter;
    until: number;
    wanted: number;
    runs: Run[];
    failed: string[];
    stopped: boolean;
}

/** The latest one. */
export const sweep = signal<Sweep | null>(null);

let clients: Client[] = [];

export function stop() {
    for (const client of clients) client.close("stopped");
    if (sweep.value) sweep.value = { ...sweep.value, stopped: true };
}

/** The seed of who walks how and where; null if nothing of it is drawn. */
export function walkingSeed(motion: Motion): number | null {
    if (motion.kind === "go") return motion.decision.seed;
    return motion.kind === "walk" && motion.shares ? motion.seed : null;
}

/** The scene with a value and the k-th seed after its own. */
function variant(made: Made, parameter: Parameter, value: number, k: number): { made: Made; seed: number } {
    const other = parameter.with(value);
    const base = made.base.kind === "crowd" ? { ...made.base, ...("crowd" in other ? other.crowd : {}), seed: made.base.seed + k } : made.base;
    const mechanics = "crowd" in other && other.crowd.friction !== undefined ? ofAllPairs(made.mechanics, base.kind === "crowd" ? base.material : "") : made.mechanics;
    let motion = "motion" in other ? other.motion : made.motion;
    if (motion.kind === "go") motion = { kind: "go", decision: { ...motion.decision, seed: motion.decision.seed + k } };
    if (motion.kind === "walk" && motion.shares) motion = { ...motion, seed: motion.seed + k };
    const seed = base.kind === "crowd" ? base.seed : (walkingSeed(motion) ?? 0);
    return { made: { ...made, base, mechanics, motion }, seed };
}

/** What a change by hand is called. */
function called(edit: Edit): string {
    if (edit.do === "room") return t("walls");
    const { id } = edit;
    return { move: t('person "{id}" moved', { id }), copy: t('person "{id}" copied', { id }), put: t('person "{id}" put in', { id }), delete: t('person "{id}" deleted', { id }) }[edit.do];
}

/** `from`: the scene that is swept. */
async function run(client: Client, from: Made, made: Made, doors: unknown[], until: number): Promise<Pick<Run, "made" | "measures" | "leftOut">> {
    const [scene, bytes] = await sent(made.base);
    // People may be others, and walls may stand elsewhere: what was done by hand is done where it still fits.
    const fitting = JSON.stringify(from.base) !== JSON.stringify(made.base);
    const show = (motion: Motion) => client.ask<Opened>({ ask: "show", ...scene, edits: made.edits, fitting, mechanics: made.mechanics, motion }, bytes);
    let opened = await show(made.motion);
    const out = new Map(opened.value.left_out);
    const edits = made.edits.filter((_, k) => !out.has(k));
    const lines = doors.map((line) => JSON.stringify(line));
    const motion = beyond(made.motion, ({ line }) => lines.indexOf(JSON.stringify(line)), opened.value.scene.beyond_doors);
    if (JSON.stringify(motion) !== JSON.stringify(made.motion)) opened = await show(motion);
    const { agents, further, leaving, step, run, overlap } = opened.value.scene;
    const frames = new Frames(agents.length, further);
    frames.add(new Float64Array(opened.bytes), 1);
    const [last, ofTenth, ofSecond] = [until, 0.1, 1].map((seconds) => Math.max(1, Math.round(seconds / step))) as [number, number, number];
    const left = () => frames.curve("left");
    const ended = () => frames.count > last || (leaving > 0 && left().at(-1)! >= leaving);
    let [deepest, atOnce] = [overlap, 1];
    while (!ended()) {
        const steps = Math.min(atOnce, last + 1 - frames.count);
        const { value, bytes, seconds } = await client.ask<Advanced>({ ask: "advance", run, steps });
        const numbers = new Float64Array(bytes);
        // Answers may be longer than needed: how long depends on the machine.
        for (let k = 0; k < steps && !ended(); k++) {
            frames.add(numbers.subarray(k * frames.whole), 1);
            deepest = value.overlaps[k]!;
        }
        frames.forget([ofTenth, ofSecond]);
        atOnce = Math.max(1, Math.min(1000, Math.round((ANSWER * steps) / Math.max(seconds, 1e-4))));
    }
    const count = left();
    const total = count.at(-1)!;
    const all = leaving > 0 && total >= leaving;
    const flow = meanFlow(total, count.findIndex((one) => one > 0), count.indexOf(total), step);
    const greatest = (mean: number) => frames.greatestMean(mean).reduce((one, other) => Math.max(one, other), 0);
    const squeezes = frames.curve("squeeze").subarray(1, all ? -1 : undefined);
    return {
        made: { ...made, edits, motion },
        leftOut: [...out].map(([k, why]) => about(called(made.edits[k]!), inWords(why))),
        measures: {
            all_left: all ? (count.length - 1) * step : NaN,
            left: total,
            flow: flow ?? NaN,
            greatest_mean_of_1_s: greatest(ofSecond),
            "greatest_mean_of_0.1_s": greatest(ofTenth),
            mean_squeeze: squeezes.reduce((sum, one) => sum + one, 0) / Math.max(1, squeezes.length),
            deepest_overlap: 1000 * deepest,
        },
    };
}

/** The values and seeds that a sweep may have together. */
export const MOST_RUNS = 1000;

/** Begins one of the scene on the stage; what ran before is ended. */
export function begin(parameter: Parameter, values: number[], seeds: number, until: number) {
    stop();
    const { made } = plan.peek();
    const doors = film.peek()?.scene.beyond_doors ?? [];
    const waiting = values.flatMap((value) => Array.from({ length: seeds }, (_, k) => ({ value, ...variant(made, parameter, value, k) })));
    sweep.value = { scene: title.peek(), made, parameter, until, wanted: waiting.length, runs: [], failed: [], stopped: false };
    const workers = Math.max(1, Math.min(MOST_WORKERS, (navigator.hardwareConcurrency || 2) - 1, waiting.length));
    const mine = Array.from({ length: workers }, () => new Client());
    clients = mine;
    for (const client of mine) {
        void (async () => {
            for (let next = waiting.shift(); next; next = waiting.shift()) {
                const { value, seed } = next;
                try {
                    const ran = await run(client, made, next.made, doors, until);
                    if (clients !== mine) return;
                    const runs = [...sweep.value!.runs, { value, seed, ...ran }].sort((one, other) => one.value - other.value || one.seed - other.seed);
                    sweep.value = { ...sweep.value!, runs };
                } catch (error) {
                    if (clients !== mine || (error instanceof Stopped && error.message === "stopped")) return;
                    sweep.value = { ...sweep.value!, failed: [...sweep.value!.failed, t("{value}, seed {seed}: {message}", { value, seed, message: (error as Error).message })] };
                }
            }
            client.close("done");
        })();
    }
}

/** A quantile of sorted numbers, between two of them in proportion: as NumPy and R (type 7) do it. */
export function quantile(sorted: number[], share: number): number {
    const at = share * (sorted.length - 1);
    const low = sorted[Math.floor(at)]!;
    return low + (at - Math.floor(at)) * (sorted[Math.ceil(at)]! - low);
}

const QUANTILES: readonly number[] = [0.1, 0.5, 0.9];
/** What is shown of so many runs of a value: of few, outer quantiles would say more than is known. */
export const sharesOf = (runs: number) => (runs < 10 ? [0, 0.5, 1] : QUANTILES);

export interface Row {
    value: number;
    runs: Run[];
    /** Sorted; fewer than runs, if some have none. */
    numbers: number[];
}

/** The numbers of a measure, for each value in order. */
export function rows({ runs }: Sweep, measure: Measure): Row[] {
    return [...new Set(runs.map(({ value }) => value))].map((value) => {
        const mine = runs.filter((run) => run.value === value);
        const numbers = mine.map(({ measures }) => measures[measure]).filter((number) => !Number.isNaN(number));
        return { value, runs: mine, numbers: numbers.sort((one, other) => one - other) };
    });
}

/** Quantiles of the runs with a value: not a number where no run has the measure. Whoever is still there leaves later than the
 * end, if ever: such a quantile is infinite. */
export function quantiles({ runs, numbers }: Row, measure: Measure, shares = QUANTILES): number[] {
    const later = measure === "all_left" ? Array<number>(runs.length - numbers.length).fill(Infinity) : [];
    const all = [...numbers, ...later];
    if (all.length === 0) return shares.map(() => NaN);
    return shares.map((share) => (all[Math.ceil(share * (all.length - 1))] === Infinity ? Infinity : quantile(all, share)));
}

const KEYS = Object.keys(MEASURES) as Measure[];
export const named = (name: string, unit: string) => (unit ? `${name} [${unit}]` : name);

/** All runs as a table. */
export function runsCsv({ runs, parameter }: Sweep): string {
    const head = [named(parameter.label, parameter.unit), "crowd_seed", "walking_seed", ...KEYS.map((key) => named(key, MEASURES[key][1])), "changes_left_out"];
    const row = ({ value, made: { base, motion }, measures, leftOut }: Run) => [
        value,
        base.kind === "crowd" ? base.seed : NaN,
        walkingSeed(motion) ?? NaN,
        ...KEYS.map((key) => measures[key]),
        leftOut.length,
    ];
    return table([head, ...runs.map(row)]);
}

/** Quantiles of all measures for each value. */
export function quantilesCsv(of: Sweep): string {
    const head = [named(of.parameter.label, of.parameter.unit), "measure", "unit", "runs", "runs_with_a_number", ...QUANTILES.map((share) => `quantile_${share}`)];
    const row = (measure: Measure) => (one: Row) => [one.value, measure, MEASURES[measure][1], one.runs.length, one.numbers.length, ...quantiles(one, measure).map((number) => (number === Infinity ? "inf" : number))];
    return table([head, ...KEYS.flatMap((measure) => rows(of, measure).map(row(measure)))]);
}
