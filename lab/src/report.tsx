// A report to print: the scene, what it assumes, its picture and numbers, and what they do not say.

import { effect, signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { perExit } from "./csv";
import { middleOf } from "./drawplaces";
import type { Film } from "./film";
import { frictionOf } from "./forms";
import { difference, differing, facts, kept, openWords } from "./kept";
import { count, inWords, t } from "./language";
import { canvas } from "./layout";
import { Squeeze } from "./legend";
import { aboveLimit, framesOf } from "./limit";
import { dampings, moduli } from "./mechanics";
import { mixWords } from "./mix";
import { brief, Button, digits, Facts, Field, length, named } from "./parts";
import { compose, png } from "./picture";
import { change, link, type Made, NAME, plan, scene } from "./plan";
import type { Point } from "./protocol";
import { distance } from "./roomshape";
import { VERSION } from "./version";
import { shape } from "./drawn";
import { film } from "./session";
import { SweepTable } from "./sweepform";
import { type Sweep, sweep } from "./sweep";

/** The picture of the report that is shown, as an address, and its time in s. */
export const report = signal<{ picture: string; time: number } | null>(null);

// It has the picture of one run.
effect(() => {
    film.value;
    report.value = null;
});

export async function makeReport(film: Film) {
    const from = canvas.value;
    if (!from) throw new Error(t("the stage shows no picture"));
    const before = film.place.peek();
    // At the end there may be nobody; at the start all are there.
    const k = (greatest(film, plan.value.limit.seconds) ?? greatest(film, SHORT))?.k ?? film.reached.peek();
    await film.show(k);
    // The effects of what is shown draw, those of the page after the next picture.
    for (let pictures = 0; pictures < 2; pictures++) await new Promise((done) => requestAnimationFrame(done));
    const blob = await png((onto) => compose(onto, canvas.value ?? from, film));
    await film.show(before);
    if (film.over) return;
    const picture = URL.createObjectURL(blob);
    report.value = { picture, time: k * film.scene.step };
}

/** In s: over so long a peak is a mean. */
const SHORT = 0.1;

/** The greatest squeeze of anybody up to the last frame that was shown, and in which frame it is; null if the run is
 * shorter than the mean: over less, it may be an impact. */
function greatest({ frames, scene, reached }: Film, seconds: number): { most: number; k: number } | null {
    const span = framesOf({ scene }, seconds);
    const last = reached.peek();
    if (last < span) return null;
    const means = frames.greatestMean(span).subarray(span, last + 1);
    const most = means.reduce((one, other) => Math.max(one, other), 0);
    return { most, k: span + Math.max(0, means.indexOf(most)) };
}

const POPULATIONS = { survey: t("survey ANSUR II"), statistics: t("statistics of one's own"), table: t("tables of measured people") };

/** What was chosen, with names as in the forms. */
function assumptions({ base, motion, edits, mechanics }: Made): [string, string][] {
    const { unit } = plan.value;
    const rows: [string, string][] = [];
    const mixed = base.kind === "crowd" && Object.keys(base.mix).length > 0;
    if (base.kind === "crowd") {
        const [width, height] = shape(base.room.outline).bounds;
        rows.push(
            [t("Room"), `${length(width, unit)} × ${length(height, unit)}, ${count(base.room.obstacles.length, "{n} obstacle", "{n} obstacles")}`],
            [t("Doors"), base.room.doors.map((door) => [length(door.width, unit), openWords(door.open)].filter(Boolean).join(", ")).join("; ") || t("none")],
            [t("Drawn from"), t("{population}, {men} % men, seed {seed}", { population: POPULATIONS[base.people.kind], men: Math.round(100 * base.men), seed: base.seed })],
            [t("Bodies"), `${mixed ? t("disks by kind") : base.round ? t("one disk each") : t("five disks each")}, ${base.material}, ${t("friction {friction}", { friction: frictionOf(base) })}`],
        );
        if (mixed) rows.push([t("Kinds"), mixWords(base.mix).join(", ")]);
    } else rows.push(["Trial", `"${brief(base.name, 60)}"`]);
    const ofPeople = edits.filter((edit) => edit.do !== "room");
    if (ofPeople.length > 0) rows.push([t("Changes by hand"), String(ofPeople.length)]);
    if (ofPeople.length < edits.length) rows.push([t("Walls"), t("changed")]);
    if (motion.kind === "go") {
        const { model, desired_speed, push, seed, groups, start } = motion.decision;
        if (groups) rows.push([t("People in groups"), `${Number((100 * groups.share).toFixed(1))} %`]);
        if (start) rows.push([t("They start"), t("from {min} to {max} s, each time as likely", { min: start.min, max: start.max })]);
        rows.push([t("They walk"), `${model}, ${mixed ? t("desired speeds by kind") : `${desired_speed} m/s`}, ${t("seed {seed}", { seed })}${push === null ? "" : t(", pushing ahead with at most {push} N", { push })}`]);
    }
    if (motion.kind === "go") {
        const { model, rotational, balance } = motion.decision;
        if (model === "rotational") rows.push([t("Constants of the model"), rotational ? Object.entries(rotational).map(([name, value]) => `${name} ${value}`).join(", ") : t("those of this version")]);
        if (balance !== "none") rows.push([t("Balance"), balance]);
    }
    if (motion.kind === "walk" && motion.shares) rows.push([t("Shares of the ways"), `${motion.shares.join(", ")}; ${t("seed {seed}", { seed: motion.seed })}`]);
    if (motion.kind === "walk") rows.push([t("They walk"), `${count(motion.ways.length, "on {n} way", "on {n} ways")}, ${mixed ? t("desired speeds by kind") : `${motion.speed} m/s`}`]);
    if (motion.kind === "push") rows.push([t("Pushes"), motion.pushes.map(({ force, duration }) => t("{force} N over {duration} s", { force, duration })).join("; ")]);
    if (mechanics) {
        if (mechanics.materials.length > 0) rows.push([t("Changed moduli, Young and shear"), moduli(mechanics).join("; ")]);
        if (mechanics.contacts.length > 0) rows.push([t("Changed damping, normal and tangential"), dampings(mechanics).join("; ")]);
    }
    return rows;
}

/** Where exits are, how wide, and when they are open. */
function exits({ scene: { targets } }: Film): [string, string][] {
    const at = ([x, y]: Point) => `(${Number(x.toFixed(3))}, ${Number(y.toFixed(3))})`;
    return targets
        .filter(({ stay }) => !stay)
        .map(({ name, corners, open }) => {
            const [from, to, ...more] = corners as [Point, Point];
            const line = { from: at(from), to: at(to), width: length(distance(from, to), plan.value.unit) };
            const place = more.length > 0 ? t("area around {middle} m", { middle: at(middleOf(corners)) }) : t("line from {from} to {to} m, {width} wide", line);
            const times = openWords(open);
            return [t("Exit {name}", { name: named(name) }), `${place}${times && `, ${times}`}`];
        });
}

/** The plan of which the room was made. */
function drawnFrom(): [string, ComponentChildren][] {
    const { drawn } = plan.value;
    return drawn === null ? [] : [["Plan", drawn]];
}

function ofRun(film: Film): [string, ComponentChildren][] {
    const { agents, step, mechanical_step, warnings } = film.scene;
    const rows: [string, ComponentChildren][] = [[t("People"), String(agents.length)], ...drawnFrom(), ...assumptions(film.made), ...exits(film), [t("Steps"), t("communication {step} s, mechanical {mechanical} s", { step, mechanical: mechanical_step })]];
    return warnings.length > 0 ? [...rows, [t("Warnings"), warnings.map(inWords).join("; ")]] : rows;
}

/** What a sweep was made of: it may be another scene than the one on the stage. */
function ofSweep({ made, parameter, until, runs }: Sweep): [string, string][] {
    const all = (of: (run: Sweep["runs"][number]) => number) => [...new Set(runs.map(of))].sort((a, b) => a - b).join(", ");
    const rows: [string, string][] = [[t("Parameter"), `${t(parameter.label)}: ${all(({ value }) => value)} ${parameter.unit}`.trim()], [t("Seeds"), all(({ seed }) => seed)], [t("Until all have left, at most"), `${until} s`]];
    const { base, mechanics } = made;
    if (base.kind === "crowd") rows.push([t("People"), base.number === null ? t("{density} per m²", { density: base.density! }) : String(base.number)]);
    rows.push(...assumptions(made));
    const [step, mechanical] = [mechanics?.time_step, mechanics?.time_step_mechanical];
    if (step || mechanical) rows.push([t("Changed steps"), [step && t("communication {step} s", { step }), mechanical && t("mechanical {mechanical} s", { mechanical })].filter(Boolean).join(", ")]);
    return rows;
}

function numbers(film: Film): [string, ComponentChildren][] {
    const { frames, scene: shown, emptied } = film;
    const last = film.reached.value;
    const time = (k: number) => `${(k * shown.step).toFixed(2)} s`;
    const squeeze = (seconds: number) => {
        const found = greatest(film, seconds);
        return found ? t("{most} N, at {time}", { most: digits(found.most, 3), time: time(found.k) }) : t("nothing yet: the run is shorter than {seconds} s", { seconds });
    };
    const rows: [string, ComponentChildren][] = [[t("Computed"), last > 0 ? time(last) : t("nothing yet: play the run first")]];
    const { force, seconds } = plan.value.limit;
    if (last > 0) {
        rows.push(
            [t("Greatest squeeze of anybody, mean of {seconds} s", { seconds }), squeeze(seconds)],
            [t("Limit of the squeeze"), t("{force} N, mean of {seconds} s", { force, seconds })],
            ...aboveLimit(film),
            [t("Greatest squeeze of anybody, mean of 0.1 s: it may be an impact"), squeeze(SHORT)],
            [t("Deepest overlap"), `${digits(1000 * film.overlaps[last]!, 2)} mm`],
        );
    }
    if (shown.leaving === 0) return rows;
    const all = emptied.value !== null && emptied.value <= last;
    rows.push([t("Have left"), all ? t("all {n} after {time}", { n: shown.leaving, time: time(emptied.value!) }) : t("{part} of {n}", { part: frames.curve("left")[last]!, n: shown.leaving })]);
    for (const { name, people, flow } of perExit(film)) rows.push([t("By {name}", { name: named(name) }), `${count(people, "{n} person", "{n} people")}${flow === null ? "" : t(", {flow} per second from the first to the last", { flow: digits(flow, 3) })}`]);
    return rows;
}

/** The numbers of the run on the stage, and beside them those of a run that is kept. */
function Results({ film }: { film: Film }) {
    const mine = numbers(film);
    const other = kept.value;
    if (!other || other.film === film) return <Facts rows={mine} />;
    const theirs = new Map(numbers(other.film));
    const names = [...new Set([...mine.map(([name]) => name), ...theirs.keys()])];
    const own = new Map(mine);
    return (
        <table class="facts compared">
            <thead>
                <tr>
                    <td />
                    <th scope="col">{t("This run")}</th>
                    <th scope="col">{t("The run that is kept")}</th>
                </tr>
            </thead>
            <tbody>
                <tr>
                    <th scope="row">{t("What is different")}</th>
                    <td>{difference() || "–"}</td>
                    <td>{differing(other.facts, facts()) || "–"}</td>
                </tr>
                {names.map((name) => (
                    <tr key={name}>
                        <th scope="row">{name}</th>
                        <td>{own.get(name) ?? "–"}</td>
                        <td>{theirs.get(name) ?? "–"}</td>
                    </tr>
                ))}
            </tbody>
        </table>
    );
}

export function Report({ film }: { film: Film }) {
    const { picture, time } = report.value!;
    useEffect(() => () => URL.revokeObjectURL(picture), [picture]);
    const swept = sweep.value;
    return (
        <main class="report" aria-label={t("Report")}>
            <div class="buttons">
                <Button words={t("Print")} class="main" onClick={() => print()} />
                <Button words={t("Back to the lab")} onClick={() => (report.value = null)} />
            </div>
            <h1>{scene.value.name}</h1>
            <label class={plan.value.author ? "field author" : "field author none"}>
                <span>{t("Author")}</span>
                <Field type="text" maxLength={NAME} value={plan.value.author} onChange={(event) => change({ author: event.currentTarget.value.trim() })} />
            </label>
            <p>
                {t("Made with the LEMONS lab {version} on {date}: pedestrians as rigid bodies of disks with damped springs and friction, in two dimensions.", { version: VERSION, date: new Date().toISOString().slice(0, 10) })}{" "}
                <a href={link()}>{t("This scene as a link")}</a>.
            </p>
            <img src={picture} alt={t("The scene at {time} s", { time: time.toFixed(2) })} />
            <p class="note">{t("The scene at {time} s", { time: time.toFixed(2) })}{time > 0 && t(", the moment of the greatest squeeze")}</p>
            <h2>{t("What was assumed")}</h2>
            <Facts rows={ofRun(film)} />
            <h2>{t("What came out")}</h2>
            <Results film={film} />
            {swept && swept.runs.length > 0 && (
                <>
                    <h2>{t('Sweep of "{scene}"', { scene: swept.scene })}</h2>
                    {JSON.stringify(swept.made) !== JSON.stringify(plan.value.made) && <p class="note">{t("The scene was changed since: what was assumed in the sweep is below.")}</p>}
                    <Facts rows={ofSweep(swept)} />
                    <SweepTable of={swept} measure="all_left" />
                    <SweepTable of={swept} measure="greatest_mean_of_1_s" />
                </>
            )}
            <h2>{t("What these numbers do not say")}</h2>
            <ul>
                <li>{t("One run is one sample. Other seeds place other people: times and forces differ, and the greatest ones differ most. A sweep shows by how much.")}</li>
                <li>{t("The survey is of soldiers of 18 to 50 years. Children, the elderly, wheelchairs and luggage are not in it.")}</li>
                {film.scene.agents.some(({ kind }) => kind) && <li>{t("Numbers of kinds of people are of other sources, or assumptions (docs/people.md). Nobody yields to a wheelchair or helps another.")}</li>}
                <li>{t("Bodies move on a plane. Nobody falls, climbs or bends, unless the scene says that those who stand may lose balance.")}</li>
                <li>{t("Times of leaving were compared with experiments for doors and corridors, without panic (docs/validation.md). They are no proof for a building.")}</li>
            </ul>
            <Squeeze film={film} />
        </main>
    );
}
