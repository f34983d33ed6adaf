// How often the values of a measure are in the survey.

import { round } from "./colour";
import { about, capital, fixed, local, nameOf, t } from "./language";
import type { MeasureShown, Sex } from "./protocol";

const [WIDTH, HEIGHT, FOOT] = [320, 70, 18];
/** Most bars and ticks. */
const [BARS, TICKS] = [40, 8];

/** The share of the people below a value; quantiles have equal distances of rank. */
function below(quantiles: number[], value: number): number {
    const last = quantiles.length - 1;
    if (value <= quantiles[0]!) return 0;
    if (value >= quantiles[last]!) return 1;
    const k = quantiles.findIndex((quantile) => quantile > value) - 1;
    const [from, to] = [quantiles[k]!, quantiles[k + 1]!];
    return (k + (to > from ? (value - from) / (to - from) : 0)) / last;
}

interface Bar {
    from: number;
    to: number;
    share: number;
}

function barsOf(quantiles: number[], by: number): Bar[] {
    const [low, high] = [by * quantiles[0]!, by * quantiles.at(-1)!];
    const step = round((high - low) / BARS, [1, 2, 5]);
    const bars: Bar[] = [];
    for (let k = Math.floor(low / step); k * step < high; k++) {
        const [from, to] = [k * step, (k + 1) * step];
        bars.push({ from, to, share: below(quantiles, to / by) - below(quantiles, from / by) });
    }
    return bars;
}

interface DistributionProps {
    measure: MeasureShown;
    /** From the measure's unit to the one that is shown. */
    by: number;
    unit: string;
    sex: Sex;
}

export function Distribution({ measure, by, unit, sex }: DistributionProps) {
    const { quantiles, value, rank } = measure;
    const name = nameOf(measure.name);
    const bars = barsOf(quantiles, by);
    const [low, high] = [bars[0]!.from, bars.at(-1)!.to];
    const step = bars[0]!.to - low;
    const most = Math.max(...bars.map(({ share }) => share));
    const x = (value: number) => (WIDTH * (value - low)) / (high - low);
    const decimals = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
    const words = (value: number) => fixed(value, decimals);
    const here = Math.max(0, Math.min(WIDTH, x(by * value)));
    const tick = round((high - low) / TICKS, [1, 2, 5]);
    const ticks: number[] = [];
    for (let k = Math.ceil(low / tick - 1e-9); k * tick <= high + 1e-9; k++) ticks.push(k * tick);
    const median = fixed(by * quantiles[Math.floor(quantiles.length / 2)]!, 1);
    const men = sex === "male";
    const all = rank <= 0 ? (men ? t("less than all men") : t("less than all women")) : men ? t("more than all men") : t("more than all women");
    const share = rank > 0 && rank < 1 ? moreThan(percent(rank), sex) : all;
    const half = { median, unit };
    return (
        <figure class="distribution">
            <figcaption>
                <strong>
                    {capital(name)} [{unit}]
                </strong>
                {about("", share)}
            </figcaption>
            <svg
                viewBox={`-14 0 ${WIDTH + 28} ${HEIGHT + FOOT}`}
                role="img"
                aria-label={`${t("{name} in {unit}, from {low} to {high}: {share}.", { name, unit, low: words(low), high: words(high), share })} ${men ? t("Half of the men have less than {median} {unit}.", half) : t("Half of the women have less than {median} {unit}.", half)}`}
            >
                {bars.map(({ from, to, share }) => {
                    const height = (HEIGHT * share) / most;
                    return (
                        <rect key={from} x={x(from) + 0.5} width={Math.max(0.5, x(to) - x(from) - 1)} y={HEIGHT - height} height={height} class="bar">
                            <title>{t("{from} to {to} {unit}: {share}", { from: words(from), to: words(to), unit, share: percent(share) })}</title>
                        </rect>
                    );
                })}
                <path d={`M0 ${HEIGHT}H${WIDTH}${ticks.map((at) => `M${x(at)} ${HEIGHT}v4`).join("")}`} class="axis" />
                {ticks.map((at) => (
                    <text key={at} x={x(at)} y={HEIGHT + 15} text-anchor="middle">
                        {local(Number(at.toPrecision(6)))}
                    </text>
                ))}
                <path d={`M${here} 0V${HEIGHT}`} class="here" />
            </svg>
        </figure>
    );
}

/** How many of the survey have less. */
export function moreThan(share: string, sex: Sex) {
    return sex === "male" ? t("more than {share} of the men", { share }) : t("more than {share} of the women", { share });
}

function percent(share: number) {
    const value = 100 * share;
    return `${value < 1 || value > 99 ? fixed(value, 1) : value.toFixed(0)} %`;
}
