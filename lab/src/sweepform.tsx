// A sweep as a form, a chart and a table.

import { batch } from "@preact/signals";
import { saveTable } from "./csv";
import { MOST } from "./forms";
import { kept } from "./kept";
import { about, local, t } from "./language";
import { Button, Choice, digits, NumberField } from "./parts";
import { change, crowdOf, type Made, type Plan, plan } from "./plan";
import { open } from "./scenes";
import { film } from "./session";
import { type Parameter, parameters } from "./sliders";
import { begin, type Measure, MEASURES, MOST_RUNS, named, quantile, quantiles, quantilesCsv, type Row, rows, type Run, runsCsv, sharesOf, stop, type Sweep, sweep, walkingSeed } from "./sweep";

/** In s: so long people may need to leave. */
const PATIENCE = 120;
/** Runs whose changes that did not fit are listed. */
const MOST_LISTED = 50;

function set(part: Partial<Plan["sweep"]>) {
    change({ sweep: { ...plan.value.sweep, ...part } });
}

export function SweepForm() {
    const { end, made, sweep: form } = plan.value;
    const { seeds } = form;
    const found = parameters();
    const parameter = found.find(({ label }) => label === form.parameter) ?? found.find(({ label }) => label.startsWith("Width")) ?? found[0];
    if (!parameter || !film.value) return null;
    // Of another parameter the values are no values of this one.
    const text = (parameter.label === form.parameter ? form.values : null) ?? proposal(parameter);
    const [values, wrong] = parsed(text, parameter, seeds);
    const until = form.until ?? (film.value.scene.leaving > 0 ? Math.max(PATIENCE, end, longest()) : end);
    const now = sweep.value;
    const running = now !== null && !now.stopped && now.runs.length + now.failed.length < now.wanted;
    const start = () => {
        // The values stay when the slider moves.
        set({ parameter: parameter.label, values: text });
        begin(parameter, values, seeds, until);
    };
    const { base, edits } = made;
    return (
        <details>
            <summary>{t("A sweep: many values, many seeds")}</summary>
            <div class="panel">
                <Choice
                    label={t("Parameter")}
                    value={parameter.label}
                    choices={found.map(({ label, unit }) => [label, named(t(label), unit)] as const)}
                    onChange={(label) => set({ parameter: label, values: null })}
                />
                <label class="field">
                    <span>{t("{values}, with commas between", { values: named(t("Values"), parameter.unit) })}</span>
                    <input type="text" value={text} aria-invalid={wrong !== ""} maxLength={MOST.list} onInput={(event) => set({ parameter: parameter.label, values: event.currentTarget.value })} />
                </label>
                {wrong && (
                    <p class="note" role="alert">
                        {wrong}
                    </p>
                )}
                <NumberField label={t("Seeds for each value")} value={seeds} min={1} max={MOST.seeds} step={1} onChange={(count) => set({ seeds: count })} />
                <NumberField label={t("Until all have left, at most")} unit="s" value={until} min={0.1} max={1e5} step={5} onChange={(seconds) => set({ until: seconds })} />
                <p class="note">{seedWords(made, seeds)}</p>
                <p class="note">{t("Each seed has other people at other places. Runs are computed beside what you see.")}</p>
                {base.kind === "crowd" && edits.length > 0 && <p class="note">{t("Changes by hand stay where they fit: of people with these Ids, to places where they overlap nobody.")}</p>}
                <div class="buttons act">
                    <Button words={t("Begin the sweep")} class="main" disabled={wrong !== ""} onClick={start} />
                    {running && (
                        <Button words={t("Stop the sweep")} onClick={stop} />
                    )}
                </div>
                {now && <Results of={now} running={running} />}
            </div>
        </details>
    );
}

const unitWords = (unit: string) => (unit === "people" ? t("people") : unit);

/** Twice the time of the longest run of those that were seen and that all have left, in tens of s: other values may need more. */
function longest(): number {
    const seen = [film.value, kept.value?.film].map((run) => (run?.emptied.value ?? 0) * (run?.scene.step ?? 0));
    const swept = sweep.value?.runs.map(({ measures }) => measures.all_left || 0) ?? [];
    return 10 * Math.ceil(Math.max(...seen, ...swept) / 5);
}

/** The seeds that the runs of each value have. */
function seedWords({ base, motion }: Made, runs: number): string {
    const walking = walkingSeed(motion);
    const of = (seed: number) => ({ from: seed, to: seed + runs - 1 });
    const all: string[] = [];
    if (base.kind === "crowd") all.push(runs === 1 ? t("the crowd has the seed {seed}", { seed: base.seed }) : t("the crowd has the seeds {from} to {to}", of(base.seed)));
    if (walking !== null) all.push(runs === 1 ? t("walking has the seed {seed}", { seed: walking }) : t("walking has the seeds {from} to {to}", of(walking)));
    if (all.length === 0) return t("Nothing is drawn by chance in this scene: all runs of a value are the same.");
    if (all.length === 2 && runs > 1) all.push(t("each run has the next one of both"));
    return t("In the runs of each value, {seeds}.", { seeds: all.join("; ") });
}

/** Some values around the present one. */
function proposal({ value, range: [min, max, step] }: Parameter) {
    const near = [0.75, 1, 1.25, 1.5].map((factor) => Number((Math.round((factor * value) / step) * step).toFixed(6)));
    return [...new Set(near.map((one) => Math.max(min, Math.min(max, one))))].join(", ");
}

/** The values, and what is wrong with them. */
function parsed(text: string, { range: [min, max, step] }: Parameter, seeds: number): [number[], string] {
    const parts = text.split(/[,;\s]+/).filter((part) => part !== "");
    const values = [...new Set(parts.map(Number))].sort((one, other) => one - other);
    const bad = parts.find((part) => !(Number(part) >= min && Number(part) <= max) || (step === 1 && !Number.isInteger(Number(part))));
    const wrong = { name: bad?.slice(0, 20) ?? "", min, max };
    if (bad !== undefined) return [values, step === 1 ? t("{name}: whole numbers, {min} to {max}", wrong) : t("{name}: {min} to {max}", wrong)];
    if (values.length === 0) return [values, t("At least one value")];
    if (values.length * seeds > MOST_RUNS) return [values, t("{n} runs: at most {most}", { n: values.length * seeds, most: MOST_RUNS })];
    return [values, ""];
}

function Results({ of, running }: { of: Sweep; running: boolean }) {
    const chosen = plan.value.sweep.measure;
    const measure = Object.hasOwn(MEASURES, chosen) ? (chosen as Measure) : of.runs.some(({ measures }) => measures.left > 0) ? "all_left" : "greatest_mean_of_1_s";
    const found = rows(of, measure);
    const [label] = MEASURES[measure];
    const { parameter, wanted, runs, failed } = of;
    const show = ({ value, seed, made }: Run) =>
        batch(() => {
            const { sweep, drawn } = plan.value;
            open(t("{scene}, {label} {value}, seed {seed}", { scene: of.scene, label: t(parameter.label), value, seed }), made, true, crowdOf(made.base) ?? undefined);
            change({ sweep, drawn });
        });
    const give = (what: string, content: string) => {
        const { made, until, scene, stopped } = of;
        const values = [...new Set(runs.map(({ value }) => value))];
        saveTable(`${scene}-sweep-${parameter.label.toLowerCase().replaceAll(" ", "-")}-${what}-${until}s.csv`, content, { scene, parameter: parameter.label, unit: parameter.unit, values, runs: runs.length, wanted, stopped, longest_time_s: until, made });
    };
    return (
        <section aria-label={t("Results of the sweep")}>
            <p role="status" class="note">
                {t('"{scene}": {n} of {wanted} runs until {until} s', { scene: of.scene, n: runs.length, wanted, until: of.until })}
                {of.stopped && t(", stopped")}.
            </p>
            {running && <progress aria-label={t("Sweep")} max={wanted} value={runs.length + failed.length} />}
            {failed.length > 0 && <p class="warning">{failed.slice(0, 3).join("; ")}{failed.length > 3 && t("; and {n} more", { n: failed.length - 3 })}</p>}
            <LeftOut of={of} />
            {runs.length > 0 && (
                <>
                    <Choice label={t("Measure")} value={measure} choices={Object.entries(MEASURES).map(([key, [words, unit]]) => [key as Measure, named(t(words), unitWords(unit))] as const)} onChange={(next) => set({ measure: next })} />
                    <Chart found={found} measure={measure} words={about(t(label), t(parameter.label))} onShow={show} />
                    <SweepTable of={of} measure={measure} onShow={show} />
                    <div class="buttons">
                        <Button words={t("Runs of the sweep (CSV)")} onClick={() => give("runs", runsCsv(of))} />
                        <Button words={t("Quantiles of the sweep (CSV)")} onClick={() => give("quantiles", quantilesCsv(of))} />
                    </div>
                </>
            )}
        </section>
    );
}

/** Changes by hand that did not fit. */
function LeftOut({ of: { parameter, runs } }: { of: Sweep }) {
    const some = runs.filter(({ leftOut }) => leftOut.length > 0);
    if (some.length === 0) return null;
    return (
        <details>
            <summary>{t("Not all changes by hand fit in {n} of {n2} runs", { n: some.length, n2: runs.length })}</summary>
            <ul class="notes">
                {some.slice(0, MOST_LISTED).map(({ value, seed, leftOut }) => (
                    <li key={`${value} ${seed}`}>{t("{label}: {value}, seed {seed}: {leftOut}", { label: parameter.label, value, seed, leftOut: leftOut.join("; ") })}</li>
                ))}
                {some.length > MOST_LISTED && <li>…</li>}
            </ul>
        </details>
    );
}

/** Quantiles for each value. */
export function SweepTable({ of, measure, onShow }: { of: Sweep; measure: Measure; onShow?(run: Run): void }) {
    const { label, unit } = of.parameter;
    const [words, unitOf] = MEASURES[measure];
    const stayed = measure === "all_left" ? of.runs.filter(({ measures }) => Number.isNaN(measures.all_left)).length : 0;
    const found = rows(of, measure);
    const shares = sharesOf(Math.max(0, ...found.map(({ runs }) => runs.length)));
    const names: Record<number, string> = { 0: t("least"), 1: t("greatest") };
    const shown = (number: number) => (Number.isNaN(number) ? "–" : number === Infinity ? `> ${local(of.until)}` : digits(number, 3));
    return (
        <>
            {stayed > 0 && (
                <p class="note">
                    <strong>{t("In {stayed} of {n} runs not all had left after {until} s.", { stayed, n: of.runs.length, until: of.until })}</strong>
                </p>
            )}
            <table class="sweep">
                <caption>{t("{measure}: quantiles of the runs", { measure: named(t(words), unitWords(unitOf)) })}</caption>
                <thead>
                    <tr>
                        <th scope="col">{named(t(label), unit)}</th>
                        <th scope="col">{t("runs")}</th>
                        {shares.map((share) => (
                            <th key={share} scope="col">
                                {names[share] ?? `${100 * share} %`}
                            </th>
                        ))}
                    </tr>
                </thead>
                <tbody>
                    {found.map((row) => {
                        const { value, runs, numbers } = row;
                        return (
                            <tr key={value}>
                                <th scope="row">
                                    {onShow ? (
                                        <Button words={local(value)} title={t("Shows its first run on the stage")} onClick={() => onShow(runs[0]!)} />
                                    ) : (
                                        local(value)
                                    )}
                                </th>
                                <td>{numbers.length === runs.length ? runs.length : t("{n} of {n2}", { n: numbers.length, n2: runs.length })}</td>
                                {quantiles(row, measure, shares).map((number, k) => (
                                    <td key={k}>{shown(number)}</td>
                                ))}
                            </tr>
                        );
                    })}
                </tbody>
            </table>
        </>
    );
}

const [WIDE, HIGH, LEFT, LOW] = [260, 150, 40, 20];

/** Each run as a point, the line of the medians, and the band between the outer quantiles. */
function Chart({ found, measure, words, onShow }: { found: Row[]; measure: Measure; words: string; onShow(run: Run): void }) {
    const all = found.flatMap(({ numbers }) => numbers);
    if (all.length === 0) return <p class="note">{t("No run has this measure.")}</p>;
    const most = Math.max(...all) * 1.05 || 1;
    const [first, last] = [found[0]!.value, found.at(-1)!.value];
    const x = (value: number) => (last > first ? LEFT + 12 + ((WIDE - LEFT - 24) * (value - first)) / (last - first) : (WIDE + LEFT) / 2);
    const y = (number: number) => HIGH - LOW - ((HIGH - LOW - 8) * number) / most;
    const measured = found.filter(({ numbers }) => numbers.length > 0);
    const [low, middle, high] = sharesOf(Math.max(...found.map(({ runs }) => runs.length))) as [number, number, number];
    const line = (share: number) => measured.map(({ value, numbers }) => `${x(value)},${y(quantile(numbers, share))}`);
    return (
        <svg class="runs" viewBox={`0 0 ${WIDE} ${HIGH}`} role="img" aria-label={words}>
            <polygon points={[...line(low), ...line(high).reverse()].join(" ")} class="band" />
            <polyline points={line(middle).join(" ")} class="median" />
            {[0, most / 2.1, most / 1.05].map((number) => (
                <g key={number}>
                    <line x1={LEFT} x2={WIDE} y1={y(number)} y2={y(number)} class="grid" />
                    <text x={LEFT - 4} y={y(number) + 4} text-anchor="end">
                        {digits(number, 2)}
                    </text>
                </g>
            ))}
            {found.map(({ value, runs }) => (
                <g key={value}>
                    <text x={x(value)} y={HIGH - 5} text-anchor="middle">
                        {local(value)}
                    </text>
                    {runs.map((run) =>
                        Number.isNaN(run.measures[measure]) ? null : (
                            <circle key={run.seed} cx={x(value)} cy={y(run.measures[measure])} r={3.5} onClick={() => onShow(run)}>
                                <title>{t("seed {seed}: {value}", { seed: run.seed, value: digits(run.measures[measure], 4) })}</title>
                            </circle>
                        ),
                    )}
                </g>
            ))}
        </svg>
    );
}
