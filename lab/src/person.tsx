// One person: measures, the five disks, the body, and where the person stands in the survey. Or a bicycle.

import { computed, signal, useSignalEffect } from "@preact/signals";
import "./person.css";
import { Distribution } from "./distribution";
import { add } from "./handtool";
import { capital, nameOf, t } from "./language";
import { Latest } from "./latest";
import { Drawing, extents, Gaze, pathOf } from "./outline";
import { Button, Check, Choice, digits, Facts, in3d, length, NumberField, Range } from "./parts";
import { change, plan } from "./plan";
import { type BicycleShown, isChild, type MeasureShown, type PersonRequest, type PersonShown, type Surface } from "./protocol";
import { client, film } from "./session";
import type { TurningProps } from "./turning";

const person = signal<PersonShown | null>(null);
const body = signal<TurningProps["body"]>(null);
const bicycle = signal<BicycleShown | null>(null);
const refused = signal("");
const riding = signal(false);

/** The altitude while its slider moves: one step of Undo for the whole way. */
const sliding = signal<number | null>(null);

const altitude = computed(() => sliding.value ?? plan.value.person.altitude);
/** It changes only if what is asked for does. */
const wanted = computed(() => JSON.stringify({ ...plan.value.person, altitude: altitude.value }));
const surfaceOf = computed(() => JSON.stringify({ ...plan.value.person, altitude: null }));

const KEYS = ["breadth", "depth", "stature", "mass"] as const;
const MEDIANS = { breadth: null, depth: null, stature: null, mass: null };
/** A child of about six years. */
const CHILD = { breadth: 0.29, depth: 0.16, stature: 1.2, mass: 23 };
const KINDS = [
    ["female", t("Woman")],
    ["male", t("Man")],
    ["child", t("Child")],
    ["bicycle", t("Bicycle")],
] as const;

/** What is asked of the lab: one thing after the other. */
const shapes = new Latest<PersonRequest>(async (asked) => {
    try {
        person.value = (await client.ask<PersonShown>({ ask: "person", ...asked })).value;
        refused.value = "";
    } catch (error) {
        refused.value = (error as Error).message;
        // There are fields to mend it in.
        if (person.value?.sex !== asked.sex) person.value = (await client.ask<PersonShown>({ ask: "person", ...asked, ...MEDIANS, altitude: null })).value;
    }
});
const surfaces = new Latest<PersonRequest>(async (asked) => {
    try {
        const { value, bytes } = await client.ask<Surface>({ ask: "body", ...asked });
        body.value = { surface: value, bytes };
    } catch {
        // The disks say what is wrong.
    }
});

async function askBicycle() {
    try {
        bicycle.value ??= (await client.ask<BicycleShown>({ ask: "bicycle" })).value;
    } catch (error) {
        refused.value = (error as Error).message;
    }
}

export function PersonTab() {
    useSignalEffect(() => void (riding.value ? askBicycle() : shapes.want(JSON.parse(wanted.value))));
    useSignalEffect(() => {
        if (!riding.value) void surfaces.want(JSON.parse(surfaceOf.value));
    });
    const { person: asked } = plan.value;
    const is = person.value;
    const kind = isChild(asked) ? "child" : asked.sex;
    return (
        <div class="persons">
            <form class="panel" aria-label={t("Measures")} onSubmit={(event) => event.preventDefault()}>
                <Choice
                    label={t("Who")}
                    value={riding.value ? "bicycle" : kind}
                    choices={KINDS}
                    onChange={(next) => {
                        riding.value = next === "bicycle";
                        if (next === "bicycle" || next === kind) return;
                        change({ person: { ...asked, ...(next === "child" ? CHILD : { ...MEDIANS, sex: next }) } });
                    }}
                />
                {!riding.value && is && <MeasureFields is={is} asked={asked} />}
                {riding.value && (
                    <p class="note">{t("This is the paper's bicycle. Those of a crowd have measures of their own.")}</p>
                )}
            </form>
            {riding.value ? bicycle.value && <BicycleDrawing is={bicycle.value} /> : is && <Shape is={is} asked={asked} />}
            {!riding.value && is && <Body3d stature={measured(is, "stature")} altitude={altitude.value} />}
            {!riding.value && is && <Survey is={is} />}
        </div>
    );
}

function measured(is: PersonShown, key: (typeof KEYS)[number]) {
    return is.measures[KEYS.indexOf(key)]!.value;
}

/** From the measure's own unit to the one that is shown. */
function shownIn(measure: MeasureShown): [by: number, unit: string] {
    return measure.unit === "m" && plan.value.unit === "cm" ? [100, "cm"] : [1, measure.unit];
}

function MeasureFields({ is, asked }: { is: PersonShown; asked: PersonRequest }) {
    const set = (part: Partial<PersonRequest>) => change({ person: { ...asked, ...part } });
    return (
        // Until the measures of the other sex come, a number that is typed would be lost with its field.
        <fieldset class="measures" disabled={is.sex !== asked.sex}>
            {is.measures.map((measure, k) => {
                const [by, unit] = shownIn(measure);
                const decimals = unit === "m" ? 3 : 1;
                const clean = (value: number) => Number((value * by).toFixed(decimals));
                return (
                    <NumberField
                        key={`${is.sex} ${measure.name}`}
                        label={capital(nameOf(measure.name))}
                        unit={unit}
                        // Also what the lab refuses stays there.
                        value={clean(asked[KEYS[k]!] ?? measure.value)}
                        min={clean(measure.possible[0])}
                        max={clean(measure.possible[1])}
                        step={10 ** -decimals}
                        onChange={(value) => set({ [KEYS[k]!]: value / by })}
                    />
                );
            })}
            {refused.value && (
                <p role="alert" class="problem">
                    {refused.value}. {t("The drawings show the last person that is possible.")}
                </p>
            )}
            <div class="buttons">
                <Button words={t("Medians of the survey")} onClick={() => set(MEDIANS)} />
                {film.value && !refused.value && (
                    <Button words={t("Put into the crowd")} title={t("One person more on the stage, where most room is: drag it from there")} onClick={putThere} />
                )}
            </div>
        </fieldset>
    );
}

function putThere() {
    const { person } = plan.value;
    change({ tab: "crowd" });
    add(person, null);
}

function Shape({ is, asked }: { is: PersonShown; asked: PersonRequest }) {
    const { unit } = plan.value;
    const size = extents(is.disks);
    const highest = measured(is, "stature");
    const area = unit === "cm" ? `${digits(is.area * 1e4, 4)} cm²` : `${digits(is.area, 3)} m²`;
    const at = altitude.value;
    const set = (altitude: number | null) => {
        sliding.value = null;
        change({ person: { ...asked, altitude } });
    };
    return (
        <section class="panel" aria-label={t("From above")}>
            <h2>{t("From above")}</h2>
            <Drawing size={size} words={(metres) => length(metres, unit)} label={t("The five disks, from above; the gaze goes up")}>
                {is.disks.map(([x, y, r], k) => (
                    <circle key={k} cx={-y} cy={-x} r={r} class="disk" />
                ))}
                {is.sections && at !== null && <path d={pathOf(is.sections)} class="section" fill-rule="evenodd" />}
                <Gaze length={0.6 * size.front} />
            </Drawing>
            <Check label={t("Section of the body")} value={at !== null} onChange={(on) => set(on ? Number((0.75 * highest).toFixed(2)) : null)} />
            {at !== null && (
                <label class="field">
                    <span>
                        {t("{length} above the ground", { length: length(at, unit) })}{is.sections?.length === 0 && t(": the body ends below")}
                    </span>
                    <Range aria-label={t("Altitude of the section")} aria-valuetext={length(at, unit)} min={0} max={Number((1.02 * highest).toFixed(2))} step={0.01} value={at} onSlide={(to) => (sliding.value = to)} onChange={set} />
                </label>
            )}
            <Facts
                rows={[
                    [t("Area of the disks"), area],
                    [t("Moment of inertia"), `${digits(is.inertia, 4)} kg m²`],
                    [t("Disks, across"), is.disks.map(([, , r]) => length(2 * r, unit).replace(/ c?m$/, "")).join(", ") + ` ${unit}`],
                ]}
            />
        </section>
    );
}

const Turning = in3d<TurningProps>(() => import("./turning"));

function Body3d({ stature, altitude }: { stature: number; altitude: number | null }) {
    return (
        <section class="panel" aria-label={t("The body")}>
            <h2>{t("The body")}</h2>
            <Turning body={body.value} stature={stature} altitude={altitude} />
        </section>
    );
}

function Survey({ is }: { is: PersonShown }) {
    return (
        <section class="panel survey" aria-label={t("In the survey")}>
            <div>
                <h2>{t("In the survey")}</h2>
                <p>
                    {is.sex === "male" ? t("ANSUR II: {n} men of the US Army, measured in 2012.", { n: is.surveyed }) : t("ANSUR II: {n} women of the US Army, measured in 2012.", { n: is.surveyed })}{" "}
                    {isChild(plan.value.person) ? t("The line is this child.") : is.sex === "male" ? t("The line is this man.") : t("The line is this woman.")}
                </p>
            </div>
            {is.measures.map((measure) => {
                const [by, unit] = shownIn(measure);
                return <Distribution key={measure.name} measure={measure} by={by} unit={unit} sex={is.sex} />;
            })}
        </section>
    );
}

function BicycleDrawing({ is }: { is: BicycleShown }) {
    const { unit } = plan.value;
    const size = extents(is.rectangles.flat().map(([x, y]) => [x, y, 0]));
    return (
        <section class="panel" aria-label={t("From above")}>
            <h2>{t("From above")}</h2>
            <Drawing size={size} words={(metres) => length(metres, unit)} label={t("The two rectangles of a bicycle, from above; it goes up")}>
                {is.rectangles.map((rectangle, k) => (
                    <path key={k} d={pathOf([rectangle])} class="disk" />
                ))}
                <Gaze length={0.5 * size.front} />
            </Drawing>
            <Facts
                rows={is.measures.map(({ name, unit: own, value }) => {
                    const words = own === "m" ? length(value, unit) : `${digits(value, 3)} ${own}`;
                    return [capital(nameOf(name)), words];
                })}
            />
        </section>
    );
}
