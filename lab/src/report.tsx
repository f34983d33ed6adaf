// A report to print: the scene, what it assumes, its picture and numbers, and what they do not say.

import { effect, signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useMemo } from "preact/hooks";
import { Client } from "./client";
import type { Film } from "./film";
import { frictionOf } from "./forms";
import { difference, differing, facts, kept, shownTo } from "./kept";
import { about, count, inWords, local, t } from "./language";
import { Squeeze } from "./legend";
import { dampings, moduli } from "./mechanics";
import { mixWords } from "./mix";
import { openWords } from "./opentimes";
import { brief, Button, Facts, Field, length, Link } from "./parts";
import { change, type Made, NAME, plan, title } from "./plan";
import type { Block, Report as Told } from "./protocol";
import { VERSION } from "./version";
import { shape } from "./drawn";
import { film } from "./session";
import { SweepTable } from "./sweepform";
import { type Sweep, sweep } from "./sweep";

/** The report that is shown, and that of the run that is kept. */
export const report = signal<{ own: Told; other: Told | null } | null>(null);

// It is of one run.
effect(() => {
    film.value;
    report.value = null;
});

/** Asks for the report up to the last frame that was shown or asked for, of one of these runs; the run is made again. */
async function told(client: Client, run: number, ...films: Film[]): Promise<Told> {
    const { force, seconds } = plan.value.limit;
    return (await client.ask<Told>({ ask: "report", run, until: Math.max(...films.map(({ reached, scene }) => reached.peek() * scene.step)), limit: [force, seconds] })).value;
}

export async function makeReport(now: Film) {
    const { tab } = plan.value;
    const own = await told(now.client, now.scene.run, now);
    const run = kept.value?.film;
    const client = run && run !== now ? new Client() : null;
    try {
        const other = client && (await told(client, await shownTo(client, run!), run!, now));
        // Who went elsewhere meanwhile stays there.
        if (!now.over && plan.value.tab === tab) report.value = { own, other };
    } finally {
        client?.close("it has told");
    }
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
            [t("Bodies"), `${mixed ? t("disks by kind") : base.round ? t("one disk each") : base.levels ? t("disks in {levels} levels", { levels: base.levels }) : t("five disks each")}, ${base.material}, ${t("friction {friction}", { friction: frictionOf(base) })}`],
        );
        if (mixed) rows.push([t("Kinds"), mixWords(base.mix).join(", ")]);
    } else rows.push(["Trial", `"${brief(base.name, 60)}"`]);
    const ofPeople = edits.filter((edit) => edit.do !== "room");
    if (ofPeople.length > 0) rows.push([t("Changes by hand"), String(ofPeople.length)]);
    if (ofPeople.length < edits.length) rows.push([t("Walls"), t("changed")]);
    if (motion.kind === "go") {
        const { model, desired_speed, push, seed, groups, start } = motion.decision;
        if (groups) rows.push([t("People in groups"), `${local(Number((100 * groups.share).toFixed(1)))} %`]);
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

/** The plan of which the room was made. */
function drawnFrom(): [string, ComponentChildren][] {
    const { drawn } = plan.value;
    return drawn === null ? [] : [["Plan", drawn]];
}

function ofRun(film: Film): [string, ComponentChildren][] {
    const rows: [string, ComponentChildren][] = [[t("People"), String(film.scene.agents.length)], ...drawnFrom(), ...assumptions(film.made)];
    const { warnings } = film.scene;
    return warnings.length > 0 ? [...rows, [t("Warnings"), warnings.map(inWords).join("; ")]] : rows;
}

/** What a sweep was made of: it may be another scene than the one on the stage. */
function ofSweep({ made, parameter, until, runs }: Sweep): [string, string][] {
    const all = (of: (run: Sweep["runs"][number]) => number) => [...new Set(runs.map(of))].sort((a, b) => a - b).map(local).join("; ");
    const rows: [string, string][] = [[t("Parameter"), about(t(parameter.label), `${all(({ value }) => value)} ${parameter.unit}`.trim())], [t("Seeds"), all(({ seed }) => seed)], [t("Until all have left, at most"), `${local(until)} s`]];
    const { base, mechanics } = made;
    if (base.kind === "crowd") rows.push([t("People"), base.number === null ? t("{density} per m²", { density: base.density! }) : String(base.number)]);
    rows.push(...assumptions(made));
    const [step, mechanical] = [mechanics?.time_step, mechanics?.time_step_mechanical];
    if (step || mechanical) rows.push([t("Changed steps"), [step && t("communication {step} s", { step }), mechanical && t("mechanical {mechanical} s", { mechanical })].filter(Boolean).join(", ")]);
    return rows;
}

/** Value and unit of each row of the results. */
function results({ sections }: Told): Map<string, string> {
    const block = sections.find(({ heading }) => heading.id === "report.results")?.blocks[0];
    const rows = block?.kind === "table" ? block.rows : [];
    return new Map(rows.map(([name, value, unit]) => [inWords(name!), `${inWords(value!)} ${inWords(unit!)}`.trim()]));
}

/** The numbers of the run on the stage beside those of the run that is kept. */
function Compared({ own, other }: { own: Told; other: Told }) {
    const [mine, theirs] = [results(own), results(other)];
    const rows = [[t("What is different"), difference() || "–", differing(kept.value?.facts ?? [], facts()) || "–"]];
    for (const name of new Set([...mine.keys(), ...theirs.keys()])) rows.push([name, mine.get(name) ?? "–", theirs.get(name) ?? "–"]);
    const pictures = other.sections.flatMap(({ blocks }) => blocks.filter((block) => block.kind === "picture"));
    return (
        <>
            <Table caption="" head={["", t("This run"), t("The run that is kept")]} rows={rows} numbers={[]} />
            {pictures.map(({ svg, caption }) => <Picture key={caption.text} svg={svg} words={about(t("The run that is kept"), inWords(caption))} />)}
        </>
    );
}

function Table({ caption, head, rows, numbers }: { caption: string; head: string[]; rows: string[][]; numbers: boolean[] }) {
    const name = (k: number) => (numbers[k] ? "number" : undefined);
    return (
        <table class={head.length > 0 ? "facts compared" : "facts"}>
            <caption class="note">{caption}</caption>
            {head.length > 0 && <thead><tr>{head.map((words, k) => words ? <th key={k} scope="col" class={name(k)}>{words}</th> : <td key={k} />)}</tr></thead>}
            <tbody>
                {rows.map(([first, ...cells], n) => (
                    <tr key={n}>
                        <th scope="row">{first}</th>
                        {cells.map((cell, k) => <td key={k} class={name(k + 1)}>{cell}</td>)}
                    </tr>
                ))}
            </tbody>
        </table>
    );
}

function Part({ block }: { block: Block }) {
    if (block.kind === "text") return <p>{inWords(block.text)}</p>;
    if (block.kind === "list") return <ul>{block.items.map((item, k) => <li key={k}>{inWords(item)}</li>)}</ul>;
    if (block.kind === "table") return <Table caption={inWords(block.caption)} head={block.head.map(inWords)} rows={block.rows.map((row) => row.map((cell) => (cell.id ? inWords(cell) : local(cell.text))))} numbers={block.numbers} />;
    return <Picture svg={block.svg} words={inWords(block.caption)} />;
}

function Picture({ svg, words }: { svg: string; words: string }) {
    const address = useMemo(() => URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" })), [svg]);
    useEffect(() => () => URL.revokeObjectURL(address), [address]);
    return (
        <figure>
            <img src={address} alt={words} />
            <figcaption class="note">{words}</figcaption>
        </figure>
    );
}

export function Report({ film }: { film: Film }) {
    const { own, other } = report.value!;
    const swept = sweep.value;
    return (
        <main class="report" aria-label={t("Report")}>
            <div class="buttons">
                <Button words={t("Print")} class="main" onClick={() => print()} />
                <Button words={t("Back to the lab")} onClick={() => (report.value = null)} />
            </div>
            <h1>{title.value}</h1>
            <label class={plan.value.author ? "field author" : "field author none"}>
                <span>{t("Author")}</span>
                <Field type="text" maxLength={NAME} value={plan.value.author} onChange={(event) => change({ author: event.currentTarget.value.trim() })} />
            </label>
            <p>
                {t("Made with the LEMONS lab {version} on {date}: pedestrians as rigid bodies of disks with damped springs and friction, in two dimensions.", { version: VERSION, date: new Date().toISOString().slice(0, 10) })}{" "}
                <Link query="?view" words={t("This scene as a link")} />.
            </p>
            {own.notices.map((notice, k) => <p key={k} class="warning">{inWords(notice)}</p>)}
            {own.sections.map(({ heading, blocks }) => (
                <section key={heading.id}>
                    <h2>{inWords(heading)}</h2>
                    {heading.id === "report.assumed" && <Facts rows={ofRun(film)} />}
                    {heading.id === "report.results" && other && <Compared own={own} other={other} />}
                    {blocks.map((block, k) => <Part key={k} block={block} />)}
                </section>
            ))}
            {swept && swept.runs.length > 0 && (
                <>
                    <h2>{t('Sweep of "{scene}"', { scene: swept.scene })}</h2>
                    {JSON.stringify(swept.made) !== JSON.stringify(plan.value.made) && <p class="note">{t("The scene was changed since: what was assumed in the sweep is below.")}</p>}
                    <Facts rows={ofSweep(swept)} />
                    <SweepTable of={swept} measure="all_left" />
                    <SweepTable of={swept} measure="greatest_mean_of_1_s" />
                </>
            )}
            <Squeeze film={film} />
        </main>
    );
}
