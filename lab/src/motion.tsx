// What moves the people: their own drive, nothing, pushes, ways that they walk, or exits and goals.

import { effect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { BalanceChoice, Exits, KindSpeeds } from "./exits";
import { MOST } from "./forms";
import { t } from "./language";
import { motion, picked, setMotion } from "./motionstate";
import { FIRST_PUSH, FIRST_RADIUS, motionTool, remove, withWay } from "./motiontool";
import { Button, Check, Choice, LengthField, NumberField, PointFields, PointRow } from "./parts";
import { FIRST_DECISION } from "./places";
import { isThere, type Motion, type Push, type Waypoint } from "./protocol";
import { bases, film } from "./session";
import { begin, MOTION, useTool } from "./tool";

const KINDS: [Motion["kind"], name: string, sentence: string][] = [
    ["own", t("As the scene itself says"), t("An example or an opened Trial brings its own drive; people of a crowd walk one way if the tab Crowd says so.")],
    ["none", t("Nobody moves by themselves"), t("People stand. They move only if they overlap at the start.")],
    ["push", t("Some are pushed"), t("A push acts on each whose middle is in its circle at the start. The force on each rises and falls like half a sine.")],
    ["walk", t("All walk along ways"), t("Everybody takes the way whose first point is nearest, or ways have shares. People go to the next point when near enough to one.")],
    ["go", t("All walk to exits and goals"), t("People walk around walls. At an exit they leave; at a goal they stay.")],
];

/** What was chosen before comes back. */
const before = new Map<Motion["kind"], Motion>();
// Not in another place.
effect(() => {
    bases.value;
    before.clear();
});

function starting(kind: Motion["kind"]): Motion {
    const known = before.get(kind);
    if (known) return known;
    if (kind === "push") return { kind, pushes: [], balance: "none" };
    if (kind === "walk") return { kind, speed: 1.3, ways: [], shares: null, seed: 1 };
    if (kind === "go") return { kind, decision: FIRST_DECISION };
    return { kind };
}

export const kindOf = () => motion.value.kind;

export function setKind(kind: Motion["kind"]) {
    before.set(motion.value.kind, motion.value);
    begin("change");
    picked.value = null;
    setMotion(starting(kind));
}

export function MotionTab() {
    useEffect(() => () => void (picked.value = null), []);
    const now = motion.value;
    useTool(motionTool, MOTION);
    return (
        <section class="panel" aria-label={t("Motion")}>
            <h2>{t("Motion")}</h2>
            <Choice
                label={t("What moves them")}
                value={now.kind}
                choices={KINDS}
                onChange={setKind}
            />
            <p class="note">{KINDS.find(([kind]) => kind === now.kind)![2]}</p>
            {now.kind === "push" && <BalanceChoice value={now.balance} onChange={(balance) => setMotion({ ...now, balance })} />}
            {now.kind === "push" && <Pushes now={now} />}
            {now.kind === "walk" && <Walk now={now} />}
            {now.kind === "go" && <Exits decision={now.decision} middle={middle()} />}
        </section>
    );
}

/** Somewhere in the picture, for those who write numbers. */
function middle(): [number, number] {
    const frame = film.value?.frames.frame(0);
    return frame?.length && isThere(frame, 0) ? [Number(frame[0]!.toFixed(2)), Number(frame[1]!.toFixed(2))] : [0, 0];
}

/** Beside what is drawn on the picture. */
function Write({ words, onClick }: { words: string; onClick(): void }) {
    return (
        <>
            <div class="buttons">
                <Button words={words} onClick={onClick} />
            </div>
            <p class="note">{t("What is drawn can be dragged on the picture; Delete removes what is marked.")}</p>
        </>
    );
}

/** What is drawn, each with its fields. */
function Drawn<T>({ parts, name, none, children }: { parts: T[]; name(n: number): string; none: string; children(part: T, k: number): ComponentChildren }) {
    if (parts.length === 0) return <p class="note">{none}</p>;
    return parts.map((part, k) => (
        <fieldset class={picked.value === k ? "fields marked" : "fields"} key={k} onFocusCapture={() => (picked.value = k)}>
            <legend>{name(k + 1)}</legend>
            {children(part, k)}
        </fieldset>
    ));
}

function Pushes({ now }: { now: Extract<Motion, { kind: "push" }> }) {
    const { pushes } = now;
    const set = (k: number, part: Partial<Push>) => setMotion({ ...now, pushes: pushes.map((push, j) => (j === k ? { ...push, ...part } : push)) });
    return (
        <>
            {pushes.length < MOST.parts && <Write words={t("Add a push by numbers")} onClick={() => setMotion({ ...now, pushes: [...pushes, { ...FIRST_PUSH, at: middle() }] })} />}
            <Drawn parts={pushes} name={(n) => t("Push {n}", { n })} none={t("There is no push yet: nobody moves.")}>
                {(push, k) => {
                    const name = t("Push {n}", { n: k + 1 });
                    return (
                        <>
                            <PointFields name={name} at={push.at} onChange={(at) => set(k, { at })} />
                            <LengthField of={name} label={t("radius")} value={push.radius} min={0.05} max={100} onChange={(radius) => set(k, { radius })} />
                            <NumberField of={name} label={t("direction")} unit="°" value={push.direction} min={-360} max={360} step={5} onChange={(direction) => set(k, { direction })} />
                            <NumberField of={name} label={t("greatest force")} unit="N" value={push.force} min={1} max={1e5} step={50} onChange={(force) => set(k, { force })} />
                            <NumberField of={name} label={t("start")} unit="s" value={push.start} min={0} max={1000} step={0.1} onChange={(start) => set(k, { start })} />
                            <NumberField of={name} label={t("duration")} unit="s" value={push.duration} min={0.01} max={100} step={0.05} onChange={(duration) => set(k, { duration })} />
                            <Pulse push={push} />
                            <Button words={t("Delete push {n}", { n: k + 1 })} onClick={() => remove(k)} />
                        </>
                    );
                }}
            </Drawn>
        </>
    );
}

/** Its force over time. */
function Pulse({ push: { start, duration, force } }: { push: Push }) {
    const end = 1.15 * (start + duration);
    const points = Array.from({ length: 41 }, (_, k) => {
        const share = k / 40;
        return `${(100 * (start + share * duration)) / end} ${24 - 20 * Math.sin(Math.PI * share)}`;
    });
    const words = t("The force rises from 0 at {start} s to {force} N and is 0 again at {end} s.", { start, force, end: Number((start + duration).toFixed(3)) });
    return (
        <figure class="pulse">
            <svg viewBox="0 0 100 28" preserveAspectRatio="none" role="img" aria-label={words}>
                <path d="M0 24H100" class="axis" />
                <path d={`M0 24H${(100 * start) / end}L${points.join("L")}H100`} class="curve" />
            </svg>
            <figcaption class="note">{t("0 to {end} s; {force} N at {time} s", { end: Number(end.toFixed(2)), force, time: Number((start + duration / 2).toFixed(3)) })}</figcaption>
        </figure>
    );
}

function Walk({ now }: { now: Extract<Motion, { kind: "walk" }> }) {
    const { speed, ways, shares, seed } = now;
    const setWay = (w: number, way: Waypoint[]) => (way.length > 0 ? setMotion({ ...now, ways: ways.map((old, j) => (j === w ? way : old)) }) : remove(w));
    const add = () => {
        const [x, y] = middle();
        setMotion(withWay(now, [{ x, y, radius: FIRST_RADIUS }]));
    };
    return (
        <>
            <NumberField label={t("Desired speed")} unit="m/s" value={speed} min={0} max={20} step={0.1} onChange={(next) => setMotion({ ...now, speed: next })} />
            <KindSpeeds />
            {ways.length < MOST.ways && <Write words={t("Add a way by numbers")} onClick={add} />}
            {(ways.length > 1 || shares) && <Check label={t("Each way gets a share of the people")} value={shares !== null} onChange={(on) => setMotion({ ...now, shares: on ? ways.map(() => 1) : null })} />}
            {shares && <NumberField label={t("Seed")} value={seed} min={0} max={2 ** 53 - 1} step={1} onChange={(next) => setMotion({ ...now, seed: next })} />}
            <Drawn parts={ways} name={(n) => t("Way {n}", { n })} none={t("There is no way yet: nobody walks.")}>
                {(way, w) => (
                    <>
                        {shares && <NumberField of={t("Way {n}", { n: w + 1 })} label={t("share")} value={shares[w]!} min={0} max={1e6} step={0.5} onChange={(share) => setMotion({ ...now, shares: shares.map((old, j) => (j === w ? share : old)) })} />}
                        {way.map((point, k) => {
                            const name = `${t("Way {n}", { n: w + 1 })}, ${t("point {n}", { n: k + 1 })}`;
                            const put = (part: Partial<Waypoint>) => setWay(w, way.map((old, j) => (j === k ? { ...old, ...part } : old)));
                            return (
                                <PointRow key={k} k={k} name={name} at={[point.x, point.y]} onChange={([x, y]) => put({ x, y })} onDelete={() => setWay(w, way.filter((_, j) => j !== k))}>
                                    <LengthField of={name} label={t("radius")} value={point.radius} min={0.05} max={100} onChange={(radius) => put({ radius })} />
                                </PointRow>
                            );
                        })}
                        <div class="buttons">
                            {way.length < MOST.points && (
                                <Button words={t("Add a point")} onClick={() => setWay(w, [...way, { ...way.at(-1)!, x: way.at(-1)!.x + 1 }])} />
                            )}
                            <Button words={t("Delete way {n}", { n: w + 1 })} onClick={() => remove(w)} />
                        </div>
                    </>
                )}
            </Drawn>
        </>
    );
}
