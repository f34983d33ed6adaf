// One person: measures, the five disks, and where the person stands in the survey.

import { signal, useSignalEffect } from "@preact/signals";
import type { Client } from "./client";
import { Choice, digits, Facts, NumberField } from "./parts";
import { change, plan } from "./plan";
import type { Measure, Person, PersonWanted } from "./protocol";

const person = signal<Person | null>(null);
const refused = signal("");

const KEYS = ["breadth", "depth", "stature", "mass"] as const;

export function PersonTab({ client }: { client: Client }) {
    useSignalEffect(() => {
        client
            .ask<Person>({ ask: "person", ...plan.value.person })
            .then(({ value }) => {
                person.value = value;
                refused.value = "";
            })
            .catch((error: Error) => {
                refused.value = error.message;
            });
    });
    const { person: wanted, unit } = plan.value;
    const set = (part: Partial<PersonWanted>) => change({ person: { ...wanted, ...part } });
    const factor = (measure: Measure) => (measure.unit === "m" && unit === "cm" ? 100 : 1);
    const is = person.value;
    return (
        <div class="columns three">
            <form class="panel" aria-label="Measures" onSubmit={(event) => event.preventDefault()}>
                <Choice
                    label="Sex"
                    value={wanted.sex}
                    choices={[
                        ["female", "Woman"],
                        ["male", "Man"],
                    ]}
                    onChange={(sex) => set({ sex, breadth: null, depth: null, stature: null, mass: null })}
                />
                {is?.measures.map((measure, k) => {
                    const by = factor(measure);
                    return (
                        <NumberField
                            key={measure.name}
                            label={measure.name[0]!.toUpperCase() + measure.name.slice(1)}
                            unit={by === 100 ? "cm" : measure.unit}
                            value={Number((measure.value * by).toFixed(by === 100 ? 1 : 3))}
                            min={measure.possible[0] * by}
                            max={measure.possible[1] * by}
                            step={by === 100 || measure.unit === "kg" ? 0.1 : 0.001}
                            onChange={(value) => set({ [KEYS[k]!]: value / by })}
                        />
                    );
                })}
                <button type="button" onClick={() => set({ breadth: null, depth: null, stature: null, mass: null })}>
                    Medians of the survey
                </button>
                {refused.value && <p role="alert">{refused.value}</p>}
            </form>
            {is && <Body person={is} />}
            {is && (
                <section class="panel" aria-label="In the survey">
                    <h2>In the survey</h2>
                    <p>
                        ANSUR II, {is.surveyed} {is.sex === "male" ? "men" : "women"} of the US Army, measured in 2012.
                    </p>
                    {is.measures.map((measure) => (
                        <Distribution key={measure.name} measure={measure} />
                    ))}
                </section>
            )}
        </div>
    );
}

function Body({ person: is }: { person: Person }) {
    const half = 1.1 * Math.max(...is.disks.map(([x, y, r]) => Math.max(Math.abs(x), Math.abs(y)) + r));
    return (
        <figure class="panel">
            {/* Seen from above; the gaze goes up. */}
            <svg viewBox={`${-half} ${-half} ${2 * half} ${2 * half}`} role="img" aria-label="The five disks, from above">
                {is.disks.map(([x, y, r], k) => (
                    <circle key={k} cx={-y} cy={-x} r={r} class="disk" />
                ))}
                <path d={`M0 ${-0.35 * half}v${-0.5 * half}m${-0.05 * half} ${0.08 * half}l${0.05 * half} ${-0.08 * half}l${0.05 * half} ${0.08 * half}`} class="gaze" />
            </svg>
            <figcaption>
                <Facts
                    rows={[
                        ["Area", `${digits(is.area * 1e4, 4)} cm²`],
                        ["Moment of inertia", `${digits(is.inertia, 4)} kg m²`],
                        ["Largest disk", `${digits(200 * Math.max(...is.disks.map(([, , r]) => r)), 3)} cm across`],
                    ]}
                />
            </figcaption>
        </figure>
    );
}

/** How often a measure occurs: steep quantiles are rare. */
function Distribution({ measure }: { measure: Measure }) {
    const { quantiles, value, rank } = measure;
    const [low, high] = [quantiles[0]!, quantiles.at(-1)!];
    const bins = 40;
    const counts = new Array<number>(bins).fill(0);
    quantiles.forEach((quantile, k) => {
        if (k) counts[Math.min(bins - 1, Math.floor(((quantile + quantiles[k - 1]!) / 2 - low) / ((high - low) / bins)))]! += 1;
    });
    const most = Math.max(...counts);
    const place = Math.max(0, Math.min(100, (100 * (value - low)) / (high - low)));
    const percent = rank <= 0 ? "less than all" : rank >= 1 ? "more than all" : `more than ${(100 * rank).toFixed(0)} %`;
    return (
        <figure class="distribution">
            <figcaption>
                {measure.name}: {percent}
            </figcaption>
            <svg viewBox="0 0 100 20" preserveAspectRatio="none" aria-hidden="true">
                {counts.map((count, k) => (
                    <rect key={k} x={(100 * k) / bins} y={20 - (18 * count) / most} width={90 / bins} height={(18 * count) / most} class="bar" />
                ))}
                <line x1={place} x2={place} y1="0" y2="20" class="here" />
            </svg>
        </figure>
    );
}
