// Numbers beside the picture: of the run, and of the person that is selected.

import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { averaged, meanWords } from "./colour";
import { capital } from "./distribution";
import type { Film } from "./film";
import { BY_WALLS } from "./frames";
import { beat } from "./layout";
import { Limit } from "./limit";
import { MeasureFields } from "./line";
import { MechanicsForm } from "./mechanics";
import { KindName } from "./mix";
import { brief, digits, Facts, length } from "./parts";
import { change, plan } from "./plan";
import { COLUMNS, FEET, isChild, isThere, type Measure, type Person, type PersonWanted } from "./protocol";
import { selected } from "./session";
import { Stuck } from "./stuck";

export function Numbers({ film }: { film: Film }) {
    const playing = film.playing.value;
    // Nobody reads sixty numbers in a second.
    const k = playing ? (beat.value, film.shown.peek()) : film.shown.value;
    return (
        <section class="numbers" aria-label="Numbers">
            <h2>Run</h2>
            <Facts rows={ofRun(film, k)} />
            <Stuck film={film} k={k} />
            <Limit film={film} />
            <details>
                <summary>Steps and cost</summary>
                <Facts rows={details(film, playing)} />
            </details>
            <details>
                <summary>Materials and steps</summary>
                <MechanicsForm film={film} />
            </details>
            <Overlapping film={film} />
            <h2>Person</h2>
            <Who film={film} />
            {selected.value === null && <p class="note">Choose one here, or on the picture.</p>}
            {selected.value !== null && <Facts rows={ofPerson(film, k, selected.value)} />}
            {selected.value !== null && <InSurvey film={film} agent={selected.value} />}
            {plan.value.view !== "3d" && (["line", "area"] as const).map((kind) => <MeasureFields key={kind} kind={kind} />)}
        </section>
    );
}

function ofRun(film: Film, k: number): [string, ComponentChildren][] {
    const { scene } = film;
    const rows: [string, ComponentChildren][] = [
        ["People", String(scene.agents.length)],
        ["Deepest overlap so far", `${digits(1000 * film.overlaps[k]!, 2)} mm`],
    ];
    if (scene.pushed.length > 0) rows.push(["Pushed", people(scene.pushed.length)]);
    if (scene.ways.length + scene.targets.length > 0 && scene.leaving < scene.agents.length) rows.push(["Arrived or left", `${film.arrived[k]} of ${scene.agents.length}`]);
    if (scene.leaving > 0) rows.push(["Have left", `${film.frames.curve("left")[k]} of ${scene.leaving}`]);
    return rows;
}

function details(film: Film, playing: boolean): [string, ComponentChildren][] {
    const { scene } = film;
    const computed = (playing ? film.computed.peek() : film.computed.value) > 1;
    const cost = film.cost.peek();
    const perStep = (1e9 * cost * (scene.mechanical_step / scene.step)) / Math.max(1, scene.agents.length);
    return [
        ["Communication step", `${scene.step} s`],
        ["Mechanical step", scene.stable ? `${scene.mechanical_step} s (stable up to ${digits(scene.stable, 2)} s)` : `${scene.mechanical_step} s`],
        ["Shown pace", playing ? `${film.pace.peek().toFixed(2)} s per second` : "paused"],
        ["Time to compute a step", computed ? `${digits(1000 * cost, 2)} ms` : "–"],
        ["… per person and mechanical step", computed ? `${digits(perStep, 2)} ns` : "–"],
    ];
}

/** Whole newtons, as long as they can be read. */
function newtons(value: number) {
    return `${value < 1e9 ? Math.round(value) : digits(value, 3)} N`;
}

function people(count: number) {
    return `${count} ${count === 1 ? "person" : "people"}`;
}

function ofPerson(film: Film, k: number, a: number): [string, ComponentChildren][] {
    const agent = film.scene.agents[a];
    if (!agent) return [];
    const { unit } = plan.value;
    const frame = film.frame(k);
    const of = (column: number) => frame[COLUMNS * a + column]!;
    const person = film.scene.people?.[a];
    const there = isThere(frame, a);
    const rows: [string, ComponentChildren][] = [
        ["Id", <span translate={false}>{brief(agent.id, 200)}</span>],
        ...ofKind(film, a),
        ["Mass", `${digits(agent.mass, 3)} kg`],
        ["Place", there ? `x ${length(of(0), unit)}, y ${length(of(1), unit)}` : "has left"],
    ];
    // Who has left has no numbers: 0 would be one.
    if (there) {
        rows.push(
            ["Speed", `${Math.hypot(of(3), of(4)).toFixed(2)} m/s`],
            [`Squeeze, ${meanWords(film, k)}`, newtons(film.frames.squeezeMean(k, averaged(film))[a]!)],
        );
        const byWalls = film.frames.meanOf(k, averaged(film), a, BY_WALLS);
        if (byWalls >= 0.5) rows.push(["Of it by walls", newtons(byWalls)]);
        rows.push(["Contacts", String(of(7))]);
        if (!Number.isNaN(of(FEET))) rows.push(["Lean", length(Math.hypot(of(0) - of(FEET), of(1) - of(FEET + 1)), unit)]);
    }
    if (person) {
        const sizes = `${length(person.breadth, unit)} × ${length(person.depth, unit)}, ${length(person.stature, unit)} tall`;
        rows.push(["Body", `${isChild(person) ? "child" : person.sex === "male" ? "man" : "woman"}, ${sizes}`]);
    }
    return rows;
}

/** The kind, what goes along, and the desired speed. */
function ofKind({ scene }: Film, a: number): [string, ComponentChildren][] {
    const { kind, things, speed, mass } = scene.agents[a]!;
    const rows: [string, ComponentChildren][] = [];
    if (kind !== null) rows.push(["Kind", <KindName kind={kind} />]);
    const of = [...new Set(things?.flatMap((thing) => thing ?? []))].join(", ");
    const known = kind !== null && Object.hasOwn(scene.kinds, kind) ? scene.kinds[kind] : undefined;
    const parts = known?.map((part) => (of && part !== "child" ? `${part} (${of})` : part)).join(", ") || of;
    if (parts) rows.push(["With", <>{parts}</>]);
    const person = scene.people?.[a];
    if (person && mass - person.mass > 0.05) rows.push(["Mass of the person", `${digits(person.mass, 3)} kg`]);
    if (speed !== null) rows.push(["Desired speed", `${speed.toFixed(2)} m/s`]);
    return rows;
}

const ranks = signal<{ of: string; measures: Measure[] } | null>(null);

/** Where the selected person stands in the survey. Of the people of a Trial only the disks are known. */
function InSurvey({ film, agent }: { film: Film; agent: number }) {
    const person = film.scene.people?.[agent];
    const asked: PersonWanted | null = person ? { ...person, sex: person.sex === "male" ? "male" : "female", altitude: null } : null;
    const of = JSON.stringify(asked);
    useEffect(() => {
        if (!asked) return;
        film.client
            .ask<Person>({ ask: "person", ...asked })
            .then(({ value }) => (ranks.value = { of, measures: value.measures }))
            // Who is outside of what is possible has no place there.
            .catch(() => (ranks.value = null));
    }, [of]);
    if (!asked) return <p class="note">Of this person only disks, mass and height are known.</p>;
    const found = ranks.value?.of === of ? ranks.value.measures : [];
    return (
        <>
            <Facts rows={found.map(({ name, rank }) => [capital(name), `more than ${(100 * rank).toFixed(0)} % of the ${asked.sex === "male" ? "men" : "women"}`])} />
            <button type="button" onClick={() => change({ person: asked, tab: "person" })}>
                Show in the tab Person
            </button>
        </>
    );
}

function Who({ film }: { film: Film }) {
    return (
        <label class="field">
            <span class="hidden">Person</span>
            <select
                value={selected.value === null ? "" : String(selected.value)}
                onChange={(event) => {
                    const { value } = event.currentTarget;
                    selected.value = value === "" ? null : Number(value);
                }}
            >
                <option value="">nobody</option>
                {film.scene.agents.map(({ id }, a) => (
                    <option key={id} value={String(a)} translate={false}>
                        {brief(id)}
                    </option>
                ))}
            </select>
        </label>
    );
}

/** Said also where colours are not seen. */
function Overlapping({ film: { scene } }: { film: Film }) {
    const count = scene.overlapping.length;
    if (count === 0) return null;
    return (
        <p class="warning">
            {`At the start ${people(count)} ${count === 1 ? "overlaps" : "overlap"}, by up to ${digits(1000 * scene.overlap, 2)} mm. They are hatched.`}
        </p>
    );
}
