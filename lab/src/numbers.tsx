// Numbers beside the picture: of the run, and of the person that is selected.

import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { worstWords } from "./answer";
import { averaged, meanWords } from "./colour";
import { moreThan } from "./distribution";
import type { Film } from "./film";
import { BY_WALLS } from "./frames";
import { capital, count, fixed, local, nameOf, t } from "./language";
import { calmly } from "./layout";
import { Limit } from "./limit";
import { MeasureFields } from "./line";
import { MechanicsForm } from "./mechanics";
import { KindName } from "./mix";
import { brief, Button, Choice, digits, Facts, length } from "./parts";
import { change, plan } from "./plan";
import { CHEST, COLUMNS, FEET, isChild, isThere, LEVELS, type MeasureShown, type PersonRequest, type PersonShown } from "./protocol";
import { selected } from "./session";
import { Stuck } from "./stuck";

export function Numbers({ film }: { film: Film }) {
    const playing = film.playing.value;
    const { more } = plan.value;
    // Nobody reads sixty numbers in a second.
    const k = calmly(film, film.shown);
    return (
        <section class="numbers" aria-label={t("Numbers")}>
            <h2>{t("Run")}</h2>
            <Facts rows={ofRun(film, k)} />
            <Stuck film={film} k={k} />
            {more && (
                <>
                    <Limit film={film} />
                    <details>
                        <summary>{t("Steps and cost")}</summary>
                        <Facts rows={details(film, playing)} />
                    </details>
                    <details>
                        <summary>{t("Materials and steps")}</summary>
                        <MechanicsForm film={film} />
                    </details>
                </>
            )}
            <Overlapping film={film} />
            {(more || selected.value !== null) && (
                <>
                    <h2>{t("Person")}</h2>
                    <Who film={film} />
                </>
            )}
            {more && selected.value === null && <p class="note">{t("Choose one here, or on the picture.")}</p>}
            {selected.value !== null && <Facts rows={ofPerson(film, k, selected.value)} />}
            {selected.value !== null && <InSurvey film={film} agent={selected.value} />}
            {plan.value.view !== "3d" && (["line", "area"] as const).map((kind) => <MeasureFields key={kind} kind={kind} />)}
        </section>
    );
}

type Rows = [name: string, value: ComponentChildren, meaning?: string][];

/** At first only what neither sliders nor the answer say. */
function ofRun(film: Film, k: number): Rows {
    const { scene } = film;
    const { more } = plan.value;
    const rows: Rows = !more ? [] : [
        [t("People"), String(scene.agents.length), t("At the start, also those who leave later")],
        [t("Deepest overlap so far"), `${digits(1000 * film.overlaps[k]!, 2)} mm`, t("How far disks of different people, or a disk and a wall, lay within each other at most: bodies give way so far")],
    ];
    const squeeze = worstWords(film);
    if (squeeze) rows.push([t("Greatest squeeze, mean of 1 s"), squeeze, t("Of anybody, up to the last frame that was shown or asked for")]);
    if (scene.pushed.length > 0) rows.push([t("Pushed"), count(scene.pushed.length, "{n} person", "{n} people"), t("Those on whom a force acts at some time")]);
    if (scene.ways.length + scene.targets.length > 0 && scene.leaving < scene.agents.length) rows.push([t("Arrived or left"), t("{part} of {n}", { part: film.arrived[k]!, n: scene.agents.length }), t("Who has reached the last point of the way, a goal or an exit")]);
    if (more && scene.leaving > 0) rows.push([t("Have left"), t("{part} of {n}", { part: film.frames.curve("left")[k]!, n: scene.leaving }), t("Of all who have an exit, those who have crossed it: they are gone")]);
    return rows;
}

function details(film: Film, playing: boolean): Rows {
    const { scene } = film;
    const { stable } = scene;
    const computed = (playing ? film.computed.peek() : film.computed.value) > 1;
    const cost = film.cost.peek();
    const perStep = (1e9 * cost * (scene.mechanical_step / scene.step)) / Math.max(1, scene.agents.length);
    return [
        [t("Communication step"), `${local(scene.step)} s`, t("From one frame to the next; people decide once in it")],
        [t("Mechanical step"), `${local(scene.mechanical_step)} s${stable === null ? "" : `, ${scene.mechanical_step < stable ? t("stable (up to {stable} s)", { stable: digits(stable, 2) }) : t("not stable (up to {stable} s)", { stable: digits(stable, 2) })}`}`, t("The step with which forces and motion are integrated; longer than the stable one, contacts create energy")],
        [t("Shown pace"), playing ? t("{pace} s per second", { pace: fixed(film.pace.peek(), 2) }) : t("paused"), t("Simulated seconds in a second")],
        [t("Time to compute a step"), computed ? `${digits(1000 * cost, 2)} ms` : "–", t("A communication step of all people, on this machine")],
        [t("… per person and mechanical step"), computed ? `${digits(perStep, 2)} ns` : "–", t("The same time, divided by the people and by the mechanical steps")],
    ];
}

/** Whole newtons, as long as they can be read. */
function newtons(value: number) {
    return `${value < 1e9 ? Math.round(value) : digits(value, 3)} N`;
}

function ofPerson(film: Film, k: number, a: number): Rows {
    const agent = film.scene.agents[a];
    if (!agent) return [];
    const { unit } = plan.value;
    const frame = film.frames.frame(k);
    const of = (column: number) => frame[COLUMNS * a + column]!;
    const person = film.scene.people?.[a];
    const there = isThere(frame, a);
    const rows: Rows = [
        ["Id", brief(agent.id, 200)],
        ...ofKind(film, a),
        [t("Mass"), `${digits(agent.mass, 3)} kg`],
        [t("Place"), there ? `x ${length(of(0), unit)}, y ${length(of(1), unit)}` : t("has left"), t("The centre of mass")],
    ];
    // Who has left has no numbers: 0 would be one.
    if (there) {
        rows.push(
            [t("Speed"), `${fixed(Math.hypot(of(3), of(4)), 2)} m/s`],
            [t("Squeeze, {mean}", { mean: meanWords(film, k) }), newtons(film.frames.means(k, averaged(film))[a]!), t("Sum of the normal forces on the person, from all sides")],
        );
        const byWalls = film.frames.meanOf(k, averaged(film), a, BY_WALLS);
        if (byWalls >= 0.5) rows.push([t("Of it by walls"), newtons(byWalls), t("The part of the squeeze that walls exert")]);
        const mean = (column: number) => film.frames.meanOf(k, averaged(film), a, column);
        if (film.scene.chests) {
            rows.push([t("Load on the chest"), newtons(mean(CHEST)), t("Sum of the normal forces on the chest, from all sides")]);
            if (mean(CHEST + 1) >= 0.5) rows.push([t("On the chest by walls"), newtons(mean(CHEST + 1)), t("The part of the load on the chest that walls exert")]);
            rows.push(
                [t("Chest, front–back"), newtons(mean(CHEST + 2)), t("What presses the chest together along the gaze; below 0, it is pulled apart")],
                [t("Chest, side–side"), newtons(mean(CHEST + 3)), t("What presses the chest together across the gaze; below 0, it is pulled apart")],
                [t("Chest, from all sides"), newtons(mean(CHEST + 4)), t("What presses the chest together at least, in any direction; below 0, it is pulled apart in one")],
            );
        }
        const { levels } = film.scene;
        if (levels.length > 1) rows.push([t("Squeeze by level"), `${levels.map((_, level) => newtons(mean(LEVELS + level)).slice(0, -2)).join(" · ")} N`, t("Of the normal forces on each level, from the lowest to the highest: means of communication points")]);
        rows.push([t("Contacts"), String(of(7)), t("Disks of others and walls that the person's disks touch")]);
        if (!Number.isNaN(of(FEET))) rows.push([t("Lean"), length(Math.hypot(of(0) - of(FEET), of(1) - of(FEET + 1)), unit), t("From the middle of the feet to the centre of mass, seen from above")]);
    }
    if (person) {
        const sizes = `${length(person.breadth, unit)} × ${length(person.depth, unit)}, ${t("{stature} tall", { stature: length(person.stature, unit) })}`;
        rows.push([t("Body"), `${isChild(person) ? t("child") : person.sex === "male" ? t("man") : t("woman")}, ${sizes}`, t("Shoulder breadth × chest depth, and stature")]);
    }
    return rows;
}

/** The kind, what goes along, and the desired speed. */
function ofKind({ scene }: Film, a: number): Rows {
    const { kind, things, speed, mass } = scene.agents[a]!;
    const rows: Rows = [];
    if (kind !== null) rows.push([t("Kind"), <KindName kind={kind} />]);
    const of = [...new Set(things?.flatMap((thing) => thing ?? []))].map(nameOf).join(", ");
    const known = kind !== null && Object.hasOwn(scene.kinds, kind) ? scene.kinds[kind] : undefined;
    const parts = known?.map((part) => nameOf(part) + (of && part !== "child" ? ` (${of})` : "")).join(", ") || of;
    if (parts) rows.push([t("With"), <>{parts}</>]);
    const person = scene.people?.[a];
    if (person && mass - person.mass > 0.05) rows.push([t("Mass of the person"), `${digits(person.mass, 3)} kg`]);
    if (speed !== null) rows.push([t("Desired speed"), `${fixed(speed, 2)} m/s`, t("At which this person would walk alone")]);
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
    if (!asked) return <p class="note">{t("Of this person only disks, mass and height are known.")}</p>;
    const found = ranks.value?.of === of ? ranks.value.measures : [];
    return (
        <>
            <Facts rows={found.map(({ name, rank }) => [capital(nameOf(name)), moreThan(`${(100 * rank).toFixed(0)} %`, asked.sex), t("Of those in the survey ANSUR II")])} />
            <Button words={t("Show in the tab Person")} onClick={() => change({ person: asked, tab: "person" })} />
        </>
    );
}

function Who({ film }: { film: Film }) {
    return (
        <Choice
            label={t("Person")}
            hidden
            value={String(selected.value ?? "")}
            choices={[["", t("nobody")], ...film.scene.agents.map(({ id }, a) => [String(a), brief(id)] as const)]}
            onChange={(value) => (selected.value = value === "" ? null : Number(value))}
        />
    );
}

/** Said also where colours are not seen. */
function Overlapping({ film: { scene } }: { film: Film }) {
    const people = scene.overlapping.length;
    if (people === 0) return null;
    return (
        <p class="warning">
            {count(people, "At the start {n} person overlaps", "At the start {n} people overlap")}
            {t(", by up to {overlap} mm. They are hatched.", { overlap: digits(1000 * scene.overlap, 2) })}
        </p>
    );
}
