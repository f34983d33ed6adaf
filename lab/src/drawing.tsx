// A plan of another program: what was understood of it, with the options that matter, before it becomes a room.

import { batch, effect, signal } from "@preact/signals";
import { useState } from "preact/hooks";
import { Refused } from "./client";
import { isVector, setPicture } from "./backdrop";
import { crowdFits, MOST, roomFits } from "./forms";
import { about, inWords, nameOf, t } from "./language";
import { Button, Check, Choice, NumberField } from "./parts";
import { FIRST_DECISION, shaped } from "./places";
import { arrived, change, plan } from "./plan";
import type { DrawingRequest, Door, Motion, Proposed, Understood } from "./protocol";
import { distance } from "./roomshape";
import { open } from "./scenes";
import { attempt, bases, client, film } from "./session";
import { Sketch } from "./sketch";

interface Given {
    file: File;
    bytes: Uint8Array;
}

interface Drawing {
    given: Given;
    wanted: DrawingRequest;
    found: Understood | null;
    /** Why nothing was understood. */
    refused: string;
    /** Whether what was found is not of these options yet. */
    asking: boolean;
}

const drawing = signal<Drawing | null>(null);
/** Whether exits of the plan become exits, and its people stand where it says. */
const exits = signal(true);
const region = signal(true);
/** Whether the room is as it is drawn, though that is in doubt. */
const asDrawn = signal(false);
/** The base that is made of it. It is no longer shown when that is on the stage. */
let making = "";

effect(() => {
    film.value;
    if (making && JSON.stringify(plan.peek().made.base) === making && film.value) {
        making = "";
        close();
    }
});

/** Counts what is asked, and panels that are closed. */
let latest = 0;
/** What the last answer made. */
let answered: Drawing | null = null;

/** Asks what is in a plan. Of answers, only that to the last question counts. */
export async function understand(given: Given, options: Partial<DrawingRequest> = {}) {
    const number = ++latest;
    const before = drawing.peek()?.given === given ? drawing.peek() : null;
    const first = { name: given.file.name, unit: null, close: null, deviation: null, origin: false, walls: [], enclosed: false, obstacles: [], widest: null, doors: [] };
    const wanted: DrawingRequest = { ...first, ...before?.wanted, ...options };
    const now = { given, wanted, found: null, refused: "", asking: false };
    if (!before) asDrawn.value = false;
    // The next option is changed beside this one, also before the answer.
    drawing.value = before && { ...before, wanted, asking: true };
    try {
        const { value } = await client.ask<Understood>({ ask: "drawing", ...wanted }, given.bytes);
        if (number === latest) drawing.value = answered = { ...now, found: value };
    } catch (error) {
        if (number !== latest) return;
        if (error instanceof Refused) drawing.value = answered = { ...now, refused: error.message };
        else {
            drawing.value = before && answered;
            throw error;
        }
    }
}

let seen = [arrived.peek(), bases.peek()];
// It belongs to the scene beside which it was opened. If its own could not be made, that is there again, with the same base.
effect(() => {
    const now = [arrived.value, bases.value];
    const other = now.every((count, k) => count !== seen[k]);
    seen = now;
    if (other) close();
});

function make({ given, found }: Drawing) {
    if (!found?.room) return;
    const { room, distributions, area } = found;
    if (!roomFits(room)) {
        throw new Error(t('"{name}": this page takes up to {walls} walls, each with up to {outline} corners, and up to {parts} doors; this room has more', { name: given.file.name, walls: MOST.walls, outline: MOST.outline, parts: MOST.parts }));
    }
    const { crowd } = plan.value;
    // Not more than stand at ease.
    const number = Math.max(1, Math.min(crowd.number ?? 40, Math.floor(area ?? 40)));
    const next = { ...crowd, room, region: (region.value && distributions[0]) || null, number, density: null };
    const places = exits.value ? found.exits.map(({ name, corners }) => shaped({ name: name.slice(0, MOST.name), line: null, polygon: null, share: null, open: null }, corners)) : [];
    const large = places.length > MOST.places || places.some(({ polygon }) => (polygon?.length ?? 0) > MOST.corners);
    if (large) throw new Error(t('"{name}": this page takes up to {places} exits with up to {corners} corners: leave its exits out', { name: given.file.name, places: MOST.places, corners: MOST.corners }));
    const motion: Motion = places.length > 0 ? { kind: "go", decision: { ...FIRST_DECISION, exits: places } } : { kind: "none" };
    if (!crowdFits(next)) throw new Error(t('"{name}": this page takes up to {corners} corners of the area where people stand: leave that area out', { name: given.file.name, corners: MOST.corners }));
    const base = { kind: "crowd" as const, ...next };
    making = JSON.stringify(base);
    // At once: what is changed afterwards would be kept before it is shown.
    batch(() => {
        open(given.file.name.replace(/\.\w+$/, ""), { base, edits: [], motion }, false, next, true);
        change({ drawn: given.file.name.slice(-MOST.name) }, false);
    });
}

const UNITS = [
    ["", t("as the file says")],
    ["1", "m"],
    ["0.01", "cm"],
    ["0.001", "mm"],
    ["0.0254", t("in")],
    ["0.3048", t("ft")],
    ["other", t("another length")],
] as const;

export function DrawingPanel() {
    const now = drawing.value;
    if (!now) return null;
    const { given, wanted, found, refused, asking } = now;
    const { name } = given.file;
    const again = (options: Partial<DrawingRequest>) => void attempt(() => understand(given, options));
    const unit = UNITS.find(([key]) => key === String(wanted.unit ?? ""))?.[0] ?? "other";
    return (
        <fieldset class="fields plan">
            <legend>
                Plan "{name}"
            </legend>
            {refused && (
                <p role="alert">{refused}</p>
            )}
            {found?.room && (!found.doubt || asDrawn.value) && <Sketch base={{ kind: "crowd", ...plan.value.crowd, room: found.room, region: (region.value && found.distributions[0]) || null }} exits={exits.value ? found.exits.map(({ corners }) => corners) : []} />}
            {found && (
                <table class="facts" aria-label={t("What was understood")}>
                    <tbody>
                        {found.said.map(([what, how], k) => (
                            // Several things can be left out.
                            <tr key={k} class={what === "warning" ? "warned" : undefined}>
                                <th scope="row">{what}</th>
                                <td>{how}</td>
                            </tr>
                        ))}
                    </tbody>
                </table>
            )}
            {!name.endsWith(".xml") && (
                <>
                    <Choice label={t("Unit of the plan")} value={unit} choices={UNITS} onChange={(key) => again({ unit: key === "" ? null : key === "other" ? 0.05 : Number(key) })} />
                    {unit === "other" && <NumberField label={t("Length of a unit")} unit="m" value={wanted.unit!} min={1e-6} max={1e6} step={0.01} onChange={(length) => again({ unit: length })} />}
                    <NumberField label={t("Close gaps up to")} unit="cm" value={Number((100 * (wanted.close ?? 0)).toFixed(4))} min={0} max={1000} step={0.5} onChange={(gap) => again({ close: gap > 0 ? gap / 100 : null })} />
                    <Check label={t("Lower left corner at 0, 0")} value={wanted.origin} onChange={(origin) => again({ origin })} />
                </>
            )}
            {found?.proposal && <Proposals key={`${asking}`} wanted={wanted} found={found} proposal={found.proposal} again={again} />}
            {found && !wanted.enclosed && found.layers.length > 1 && <Layers wanted={wanted} layers={found.layers} again={again} />}
            {found && found.exits.length > 0 && <Check label={t("Take its exits ({n})", { n: found.exits.length })} value={exits.value} onChange={(on) => (exits.value = on)} />}
            {found && found.distributions.length > 0 && <Check label={t("People stand where the plan says")} value={region.value} onChange={(on) => (region.value = on)} />}
            {found && found.distributions.length > 1 && <p class="note">{t("The plan has {n} areas where people stand; the page takes the first one.", { n: found.distributions.length })}</p>}
            {found && found.waypoints > 0 && <p class="note">{t("Way-points of a plan are not used here.")}</p>}
            <div class="buttons">
                {found?.room && (
                    <Button words={t("Make this room")} class="main" disabled={asking || (found.doubt !== null && !asDrawn.value)} onClick={() => void attempt(async () => make(now))} />
                )}
                {isVector(name) && (
                    <Button words={t("Lay it under the room as a picture")} onClick={() => void attempt(() => setPicture(given.file).then(close))} />
                )}
                <Button words={t("Leave it")} onClick={close} />
            </div>
        </fieldset>
    );
}

function close() {
    latest += 1;
    drawing.value = null;
}

const USES = [
    ["walls", t("walls")],
    ["obstacles", t("obstacles")],
    ["", t("left out")],
] as const;
type Use = (typeof USES)[number][0];

interface ProposalsProps {
    wanted: DrawingRequest;
    found: Understood;
    proposal: Proposed;
    again(options: Partial<DrawingRequest>): void;
}

/** What a plan seems to be, where it is in doubt: each part is taken or left before the room is made. */
function Proposals({ wanted, found, proposal, again }: ProposalsProps) {
    const taken = wanted.enclosed;
    const of = (name: string): Use => (proposal.walls.includes(name) ? "walls" : proposal.obstacles.includes(name) ? "obstacles" : "");
    const [uses, setUses] = useState(() => new Map(proposal.layers.map(({ name }) => [name, of(name)])));
    const isSame = (a: Door, b: Door) => distance(a.at, b.at) < 0.01;
    const first = proposal.gaps.filter(({ kind, door, outside }) => (taken ? outside && wanted.doors.some((one) => isSame(one, door)) : kind === "door"));
    const [doors, setDoors] = useState(() => first.map(({ door }) => door));
    const layers = (use: Use) => proposal.layers.map(({ name }) => name).filter((name) => uses.get(name) === use);
    const take = (now: Door[] = doors) => again({ walls: layers("walls"), enclosed: true, obstacles: layers("obstacles"), widest: proposal.widest, close: wanted.close ?? proposal.close, doors: now });
    const [outline, ...obstacles] = proposal.ground;
    return (
        <fieldset class="fields">
            <legend>{t("Proposals")}</legend>
            {found.doubt && (
                <p role="alert">{inWords(found.doubt)}</p>
            )}
            {!taken && outline && <Sketch base={{ kind: "crowd", ...plan.value.crowd, room: { outline, obstacles, doors }, region: null }} />}
            {!taken && <p class="note">{t("The plan is in doubt: choose what its layers and gaps are.")}</p>}
            {proposal.layers.map(({ name, sort, lines }) => (
                <label class="field" key={name}>
                    <span title={about(nameOf(sort), lines)}>
                        {name || "—"} ({nameOf(sort)})
                    </span>
                    <select value={uses.get(name)} aria-label={t('Layer "{name}"', { name })} onChange={(event) => setUses(new Map(uses).set(name, event.currentTarget.value as Use))}>
                        {USES.map(([key, words]) => (
                            <option key={key} value={key}>
                                {words}
                            </option>
                        ))}
                    </select>
                </label>
            ))}
            {proposal.gaps.map(({ kind, door, outside, said }) =>
                outside ? (
                    <label class="check" key={String(door.at)}>
                        <input
                            type="checkbox"
                            checked={doors.some((one) => isSame(one, door))}
                            onChange={({ currentTarget: { checked } }) => {
                                const now = doors.filter((one) => !isSame(one, door)).concat(checked ? [door] : []);
                                setDoors(now);
                                if (taken) take(now);
                            }}
                        />
                        <span>
                            {nameOf(kind)}: {inWords(said)}
                        </span>
                    </label>
                ) : (
                    <p class="note" key={String(door.at)}>
                        {nameOf(kind)}: {inWords(said)}
                    </p>
                ),
            )}
            {proposal.questions.length > 0 && (
                <ul class="note" aria-label={t("Questions")}>
                    {proposal.questions.map((question) => (
                        <li key={question}>{question}</li>
                    ))}
                </ul>
            )}
            <div class="buttons">
                <Button words={t("Take what is chosen")} class={taken ? undefined : "main"} disabled={layers("walls").length === 0} onClick={() => take()} />
                <button
                    type="button"
                    onClick={() => {
                        asDrawn.value = true;
                        again({ enclosed: false, obstacles: [], widest: null, doors: [], walls: [], close: null });
                    }}
                >
                    {t("Take it as it is drawn")}
                </button>
            </div>
        </fieldset>
    );
}

/** Layers that are taken as walls: all of them at first. */
function Layers({ wanted, layers, again }: { wanted: DrawingRequest; layers: string[]; again(options: Partial<DrawingRequest>): void }) {
    const taken = wanted.walls.length > 0 ? wanted.walls : layers;
    const set = (layer: string, on: boolean) => {
        const next = layers.filter((one) => (one === layer ? on : taken.includes(one)));
        if (next.length > 0) again({ walls: next.length === layers.length ? [] : next });
    };
    return (
        <fieldset class="fields">
            <legend>{t("Layers with walls")}</legend>
            {layers.map((layer) => (
                <Check key={layer} label={layer || "—"} value={taken.includes(layer)} onChange={(on) => set(layer, on)} />
            ))}
        </fieldset>
    );
}
