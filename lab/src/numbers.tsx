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
import { COLUMNS, FEET, isChild, isThere, type MeasureShown, type PersonRequest, type PersonShown } from "./protocol";
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

type Rows = [name: string, value: ComponentChildren, meaning?: string][];

function ofRun(film: Film, k: number): Rows {
    const { scene } = film;
    const rows: Rows = [
        ["People", String(scene.agents.length), "At the start, also those who leave later"],
        ["Deepest overlap so far", `${digits(1000 * film.overlaps[k]!, 2)} mm`, "How far disks of different people, or a disk and a wall, lay within each other at most: bodies give way so far"],
    ];
    if (scene.pushed.length > 0) rows.push(["Pushed", people(scene.pushed.length), "Those on whom a force acts at some time"]);
    if (scene.ways.length + scene.targets.length > 0 && scene.leaving < scene.agents.length) rows.push(["Arrived or left", `${film.arrived[k]} of ${scene.agents.length}`, "Who has reached the last point of the way, a goal or an exit"]);
    if (scene.leaving > 0) rows.push(["Have left", `${film.frames.curve("left")[k]} of ${scene.leaving}`, "Of all who have an exit, those who have crossed it: they are gone"]);
    return rows;
}

function details(film: Film, playing: boolean): Rows {
    const { scene } = film;
    const { stable } = scene;
    const computed = (playing ? film.computed.peek() : film.computed.value) > 1;
    const cost = film.cost.peek();
    const perStep = (1e9 * cost * (scene.mechanical_step / scene.step)) / Math.max(1, scene.agents.length);
    return [
        ["Communication step", `${scene.step} s`, "From one frame to the next; people decide once in it"],
        ["Mechanical step", `${scene.mechanical_step} s${stable === null ? "" : `, ${scene.mechanical_step < stable ? "" : "not "}stable (up to ${digits(stable, 2)} s)`}`, "The step with which forces and motion are integrated; longer than the stable one, contacts create energy"],
        ["Shown pace", playing ? `${film.pace.peek().toFixed(2)} s per second` : "paused", "Simulated seconds in a second"],
        ["Time to compute a step", computed ? `${digits(1000 * cost, 2)} ms` : "–", "A communication step of all people, on this machine"],
        ["… per person and mechanical step", computed ? `${digits(perStep, 2)} ns` : "–", "The same time, divided by the people and by the mechanical steps"],
    ];
}

/** Whole newtons, as long as they can be read. */
function newtons(value: number) {
    return `${value < 1e9 ? Math.round(value) : digits(value, 3)} N`;
}

function people(count: number) {
    return `${count} ${count === 1 ? "person" : "people"}`;
}

function ofPerson(film: Film, k: number, a: number): Rows {
    const agent = film.scene.agents[a];
    if (!agent) return [];
    const { unit } = plan.value;
    const frame = film.frame(k);
    const of = (column: number) => frame[COLUMNS * a + column]!;
    const person = film.scene.people?.[a];
    const there = isThere(frame, a);
    const rows: Rows = [
        ["Id", <span translate={false}>{brief(agent.id, 200)}</span>],
        ...ofKind(film, a),
        ["Mass", `${digits(agent.mass, 3)} kg`],
        ["Place", there ? `x ${length(of(0), unit)}, y ${length(of(1), unit)}` : "has left", "The centre of mass"],
    ];
    // Who has left has no numbers: 0 would be one.
    if (there) {
        rows.push(
            ["Speed", `${Math.hypot(of(3), of(4)).toFixed(2)} m/s`],
            [`Squeeze, ${meanWords(film, k)}`, newtons(film.frames.squeezeMean(k, averaged(film))[a]!), "Sum of the normal forces on the person, from all sides"],
        );
        const byWalls = film.frames.meanOf(k, averaged(film), a, BY_WALLS);
        if (byWalls >= 0.5) rows.push(["Of it by walls", newtons(byWalls), "The part of the squeeze that walls exert"]);
        rows.push(["Contacts", String(of(7)), "Disks of others and walls that the person's disks touch"]);
        if (!Number.isNaN(of(FEET))) rows.push(["Lean", length(Math.hypot(of(0) - of(FEET), of(1) - of(FEET + 1)), unit), "From the middle of the feet to the centre of mass, seen from above"]);
    }
    if (person) {
        const sizes = `${length(person.breadth, unit)} × ${length(person.depth, unit)}, ${length(person.stature, unit)} tall`;
        rows.push(["Body", `${isChild(person) ? "child" : person.sex === "male" ? "man" : "woman"}, ${sizes}`, "Shoulder breadth × chest depth, and stature"]);
    }
    return rows;
}

/** The kind, what goes along, and the desired speed. */
function ofKind({ scene }: Film, a: number): Rows {
    const { kind, things, speed, mass } = scene.agents[a]!;
    const rows: Rows = [];
    if (kind !== null) rows.push(["Kind", <KindName kind={kind} />]);
    const of = [...new Set(things?.flatMap((thing) => thing ?? []))].join(", ");
    const known = kind !== null && Object.hasOwn(scene.kinds, kind) ? scene.kinds[kind] : undefined;
    const parts = known?.map((part) => (of && part !== "child" ? `${part} (${of})` : part)).join(", ") || of;
    if (parts) rows.push(["With", <>{parts}</>]);
    const person = scene.people?.[a];
    if (person && mass - person.mass > 0.05) rows.push(["Mass of the person", `${digits(person.mass, 3)} kg`]);
    if (speed !== null) rows.push(["Desired speed", `${speed.toFixed(2)} m/s`, "At which this person would walk alone"]);
    return rows;
}

const ranks = signal<{ of: string; measures: MeasureShown[] } | null>(null);

/** Where the selected person stands in the survey. Of the people of a Trial only the disks are known. */
function InSurvey({ film, agent }: { film: Film; agent: number }) {
    const person = film.scene.people?.[agent];
    const asked: PersonRequest | null = person ? { ...person, sex: person.sex === "male" ? "male" : "female", altitude: null } : null;
    const of = JSON.stringify(asked);
    useEffect(() => {
        if (!asked) return;
        film.client
            .ask<PersonShown>({ ask: "person", ...asked })
            .then(({ value }) => (ranks.value = { of, measures: value.measures }))
            // Who is outside of what is possible has no place there.
            .catch(() => (ranks.value = null));
    }, [of]);
    if (!asked) return <p class="note">Of this person only disks, mass and height are known.</p>;
    const found = ranks.value?.of === of ? ranks.value.measures : [];
    return (
        <>
            <Facts rows={found.map(({ name, rank }) => [capital(name), `more than ${(100 * rank).toFixed(0)} % of the ${asked.sex === "male" ? "men" : "women"}`, "Of those in the survey ANSUR II"])} />
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
