// Exits and goals, as forms.

import { middleOf } from "./drawplaces";
import { inner, t } from "./language";
import { picked } from "./motionstate";
import { remove, setDecision } from "./motiontool";
import { MOST } from "./forms";
import { OpenTimes } from "./opentimes";
import { Button, Check, Choice, Field, named, NumberField, PointRow } from "./parts";
import { added, changed, cornersOf, hasShares, type Kind, kindOf, placesOf, ROTATIONAL, shaped } from "./places";
import type { BalanceName, DecisionConfig, Place, Point, Rotational } from "./protocol";
import { film, selected } from "./session";
import { MODEL_NAMES, MODELS } from "./walkingmodels";

const BALANCES: [BalanceName, string][] = [
    ["none", t("None: the ground stops them")],
    ["pendulum", t("Pendulum")],
    ["two-level", t("Two-level model")],
];

/** How people who stand keep their balance. */
export function BalanceChoice({ value, onChange }: { value: BalanceName; onChange(value: BalanceName): void }) {
    return (
        <>
            <Choice label={t("Balance of those who stand")} value={value} choices={BALANCES} onChange={onChange} />
            {value !== "none" && <p class="note">{t("Who is pushed leans, steps or falls. The picture shows the feet, and a line from there to the centre of mass.")}</p>}
        </>
    );
}

export function Exits({ decision, middle }: { decision: DecisionConfig; middle: Point }) {
    const places = placesOf(decision);
    return (
        <>
            <Choice label={t("How they walk among others")} value={decision.model} choices={MODEL_NAMES.map((name) => [name, MODELS[name].name])} onChange={(model) => setDecision({ ...decision, model, rotational: null })} />
            <p class="note">{MODELS[decision.model].use}</p>
            {decision.model === "rotational" && <Constants decision={decision} />}
            <BalanceChoice value={decision.balance} onChange={(balance) => setDecision({ ...decision, balance })} />
            <Check label={t("Limit how hard people push ahead")} value={decision.push !== null} onChange={(on) => setDecision({ ...decision, push: on ? 100 : null })} />
            {decision.push !== null && <NumberField label={t("Greatest push")} unit="N" value={decision.push} min={0} max={1e5} step={10} onChange={(push) => setDecision({ ...decision, push })} />}
            <Check label={t("Who waits leans on who is in front")} value={decision.queue !== null} onChange={(on) => setDecision({ ...decision, queue: on ? { push: 100, push_time: 20 } : null })} />
            {decision.queue !== null && <NumberField label={t("Force of leaning")} unit="N" value={decision.queue.push} min={0} max={500} step={10} onChange={(push) => setDecision({ ...decision, queue: { push, push_time: decision.queue!.push_time } })} />}
            <Check label={t("Some walk in groups, such as families")} value={decision.groups !== null} onChange={(on) => setDecision({ ...decision, groups: on ? { share: 0.5 } : null })} />
            {decision.groups !== null && <NumberField label={t("People in groups")} unit="%" value={Math.round(100 * decision.groups.share)} min={0} max={100} step={5} onChange={(percent) => setDecision({ ...decision, groups: { share: percent / 100 } })} />}
            <Check label={t("Not all start at once")} value={decision.start !== null} onChange={(on) => setDecision({ ...decision, start: on ? { min: 0, max: 30 } : null })} />
            {decision.start !== null && <Starts start={decision.start} onChange={(start) => setDecision({ ...decision, start })} />}
            <div class="row">
                <NumberField label={t("Desired speed")} unit="m/s" value={decision.desired_speed} min={0} max={20} step={0.1} onChange={(desired_speed) => setDecision({ ...decision, desired_speed })} />
                <NumberField label={t("Seed")} value={decision.seed} min={0} max={2 ** 53 - 1} step={1} onChange={(seed) => setDecision({ ...decision, seed })} />
            </div>
            <KindSpeeds />
            {places.length < MOST.places && <Write decision={decision} middle={middle} />}
            <p class="note">{t("Drag corners on the picture, or all of it by its name; Delete removes what is marked.")}</p>
            {places.length === 0 && <p class="note">{t("There is no exit yet: nobody walks. Put exits about 1 m beyond doors, where they hold nobody up.")}</p>}
            {decision.exits.length > 1 && (
                <Check
                    label={t("Each exit gets a share of the people")}
                    value={hasShares(decision)}
                    onChange={(on) => setDecision({ ...decision, exits: decision.exits.map((exit) => ({ ...exit, share: on ? 1 : null })) })}
                />
            )}
            {places.map((place, k) => (
                <Fields key={k} decision={decision} place={place} k={k} />
            ))}
            {places.length > 0 && <p class="note">{whoGoesWhere(decision)}</p>}
            {places.length > 1 && <Own decision={decision} />}
        </>
    );
}

/** From when to when people start to walk, which is their premovement time. */
function Starts({ start: { min, max }, onChange }: { start: NonNullable<DecisionConfig["start"]>; onChange(start: NonNullable<DecisionConfig["start"]>): void }) {
    return (
        <>
            <div class="row">
                <NumberField label={t("First start")} unit="s" value={min} min={0} max={max - 0.1} step={0.5} onChange={(first) => onChange({ min: first, max })} />
                <NumberField label={t("Last start")} unit="s" value={max} min={min + 0.1} max={1e5} step={0.5} onChange={(last) => onChange({ min, max: last })} />
            </div>
            <p class="note">{t("Each starts at a time between both; all are as likely, and the seed chooses. They stand before.")}</p>
        </>
    );
}

/** Who has another desired speed. */
export function KindSpeeds() {
    const kinds = film.value?.scene.people && film.value.scene.agents.some(({ kind }) => kind !== null);
    return kinds ? <p class="note">{t("People of kinds have the desired speed of their kind (click one for it). This one is for those whom you put there by hand.")}</p> : null;
}

/** Constants of the rotational model: name, unit, the least, the step. */
const CONSTANTS: [keyof Rotational, string, string, number, number][] = [
    ["time_gap", t("Time gap"), "s", 0.05, 0.05],
    ["standstill_gap", t("Gap of those who stand"), "m", 0, 0.01],
    ["reaction_time", t("Reaction time"), "s", 0, 0.05],
    ["speed_noise", t("Noise of the speed"), "m/s", 0, 0.01],
    ["acceleration", t("Greatest acceleration"), "m/s²", 0.1, 0.1],
];

function Constants({ decision }: { decision: DecisionConfig }) {
    const now = decision.rotational ?? ROTATIONAL;
    return (
        <details>
            <summary>{t("Constants of the model")}</summary>
            {CONSTANTS.map(([key, label, unit, min, step]) => (
                <NumberField key={key} label={label} unit={unit} value={now[key]} min={min} max={100} step={step} onChange={(value) => setDecision({ ...decision, rotational: { ...now, [key]: value } })} />
            ))}
        </details>
    );
}

function whoGoesWhere(decision: DecisionConfig) {
    const { exits, goals } = decision;
    if (exits.length === 0) return goals.length > 1 ? t("Everybody goes to the goal that is nearest on foot at the start.") : t("Everybody goes to the goal.");
    const exit = hasShares(decision) ? t("Exits are taken by their shares; the seed chooses by whom.") : exits.length > 1 ? t("Everybody takes the exit by which they expect to be out first, by distance and queue.") : t("Everybody takes the exit.");
    return goals.length > 0 ? `${exit} ${t("To a goal go those for whom you choose it here.")}` : exit;
}

function Write({ decision, middle: [x, y] }: { decision: DecisionConfig; middle: Point }) {
    const doors = film.value?.scene.beyond_doors ?? [];
    const known = decision.exits.map(({ line }) => JSON.stringify(line));
    const missing = doors.filter((line) => !known.includes(JSON.stringify(line)));
    const add = (kind: Kind) => setDecision(added(decision, kind, [[x, y - 0.5], [x, y + 0.5]]));
    return (
        <>
            <div class="buttons">
                <Button words={t("Put an exit beyond each door")} disabled={missing.length === 0} onClick={() => setDecision(missing.reduce((all, line) => added(all, "exit", line, "door"), decision))} />
                <Button words={t("Add an exit by numbers")} onClick={() => add("exit")} />
                <Button words={t("Add a goal by numbers")} onClick={() => add("goal")} />
            </div>
            {doors.length === 0 && <p class="note">{t("The room on the picture has no doors of the tab Room.")}</p>}
        </>
    );
}

function Fields({ decision, place, k }: { decision: DecisionConfig; place: Place; k: number }) {
    const kind = kindOf(decision, k);
    const title = kind === "exit" ? t("Exit {n}", { n: k + 1 }) : t("Goal {n}", { n: k + 1 - decision.exits.length });
    const corners = cornersOf(place);
    const set = (next: Place) => setDecision(changed(decision, k, next));
    const move = (j: number, to: Point) => set(shaped(place, corners.map((corner, i) => (i === j ? to : corner))));
    return (
        <fieldset class={picked.value === k ? "fields marked" : "fields"} onFocusCapture={() => (picked.value = k)}>
            <legend>{title}</legend>
            <label class="field">
                <span>
                    <span class="hidden">{title}, </span>{t("name")}
                </span>
                <Field
                    type="text"
                    value={place.name}
                    maxLength={MOST.name}
                    onChange={(event) => {
                        const name = event.currentTarget.value.trim();
                        if (name) set({ ...place, name });
                    }}
                />
            </label>
            {place.share !== null && <NumberField of={title} label={t("share")} value={place.share} min={0} max={1e6} step={0.5} onChange={(share) => set({ ...place, share })} />}
            {kind === "exit" && <OpenTimes name={title} times={place.open} onChange={(open) => set({ ...place, open })} />}
            {corners.map((corner, j) => {
                const name = `${title}, ${corners.length === 2 ? t("end {n}", { n: j + 1 }) : t("corner {n}", { n: j + 1 })}`;
                const lose = () => set(shaped(place, corners.filter((_, i) => i !== j)));
                return <PointRow key={j} k={j} name={name} at={corner} onChange={(to) => move(j, to)} onDelete={corners.length > 3 ? lose : undefined} />;
            })}
            <div class="buttons">
                {corners.length > 2 && corners.length < MOST.corners && (
                    <Button words={t("Add a corner")} onClick={() => set(shaped(place, [...corners, middleOf([corners[0]!, corners.at(-1)!])]))} />
                )}
                <Button words={t("Delete {name}", { name: inner(title) })} onClick={() => remove(k)} />
            </div>
        </fieldset>
    );
}

/** Where the selected person goes. */
function Own({ decision }: { decision: DecisionConfig }) {
    const agent = selected.value === null ? undefined : film.value?.scene.agents[selected.value];
    if (!agent) return <p class="note">{t("Select a person to send this one to another place than the others.")}</p>;
    const { id } = agent;
    const own = decision.agents[id];
    const places = placesOf(decision);
    const chosen = places.findIndex(({ name }, k) => (kindOf(decision, k) === "exit" ? own?.exit : own?.goal) === name);
    return (
        <Choice
            label={t("Person {id} goes to", { id: named(id) })}
            value={chosen < 0 ? "" : String(chosen)}
            choices={[["", t("where the others go")], ...places.map(({ name }, k): [string, string] => [String(k), kindOf(decision, k) === "exit" ? t("exit {name}", { name: JSON.stringify(name) }) : t("goal {name}", { name: JSON.stringify(name) })])]}
            onChange={(key) => send(decision, id, key === "" ? null : Number(key))}
        />
    );
}

/** Sends a person to one of the places; null: where the others go. */
export function send(decision: DecisionConfig, id: string, k: number | null) {
    const { [id]: _, ...agents } = decision.agents;
    const place = k === null ? undefined : placesOf(decision)[k];
    if (k === null || !place) return setDecision({ ...decision, agents });
    const exit = kindOf(decision, k) === "exit";
    setDecision({ ...decision, agents: { ...agents, [id]: { exit: exit ? place.name : null, goal: exit ? null : place.name } } });
}
