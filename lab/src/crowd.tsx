// A crowd: who and how many; then its statistics, and single people by hand.

import { ready } from "./drawn";
import { Hand } from "./hand";
import { fixed, nameOf, t } from "./language";
import { Button, Check, Choice, digits, Head, NumberField } from "./parts";
import { frictionOf, type KeptCrowd } from "./forms";
import { isPlaced, place } from "./live";
import { KindName, MixForm } from "./mix";
import { change, plan } from "./plan";
import { People } from "./people";
import type { PlacedCrowd } from "./protocol";
import { client, made } from "./session";

function set(part: Partial<KeptCrowd>) {
    change({ crowd: { ...plan.value.crowd, ...part } });
}

/** What is to be done before people stand as the forms say; nothing in a scene that is live. */
export function MakeCrowd() {
    const { base } = plan.value.made;
    if (base.kind === "crowd") return isPlaced() ? null : <p class="note">{t("The picture shows the people as they could be placed last.")}</p>;
    return (
        <>
            <p class="note">{t("The scene is no crowd of this page. From here on, people are placed again whenever something changes here.")}</p>
            <button type="submit" class="main" disabled={client.slow.value?.ask === "show" || !ready()} onClick={(event) => fits(event.currentTarget) && place(true)}>
                {t("Make this crowd")}
            </button>
        </>
    );
}

/** What is out of range is not taken, so it is not made either. */
function fits(button: HTMLElement) {
    return !button.closest(".panel")?.querySelector("[aria-invalid=true]");
}

export function CrowdTab() {
    const { crowd } = plan.value;
    return (
        <div class="panels">
            <form
                class="panel"
                aria-label={t("Crowd")}
                noValidate
                onSubmit={(event) => event.preventDefault()}
            >
                <h2>{t("Crowd")}</h2>
                <Choice
                    label={t("How many")}
                    value={crowd.number === null ? "density" : "number"}
                    choices={[
                        ["number", t("A number of people")],
                        ["density", t("People per m²")],
                    ]}
                    onChange={(by) => set(by === "number" ? { number: 40, density: null } : { number: null, density: 3 })}
                />
                {crowd.number !== null && <NumberField label={t("People")} value={crowd.number} min={1} max={5000} step={1} onChange={(number) => set({ number })} />}
                {crowd.density !== null && <NumberField label={t("Density")} unit="1/m²" value={crowd.density} min={0.01} max={20} step={0.5} onChange={(density) => set({ density })} />}
                <MixForm mix={crowd.mix} onChange={(mix) => set({ mix, ...(Object.keys(mix).length > 0 ? { round: false } : {}) })} />
                <People people={crowd.people} onChange={(people) => set({ people })} />
                <NumberField label={t("Men")} unit="%" value={Number((100 * crowd.men).toFixed(2))} min={0} max={100} step={5} onChange={(men) => set({ men: men / 100 })} />
                <div class="row">
                    <NumberField label={t("Seed")} value={crowd.seed} min={0} max={2 ** 53 - 1} step={1} onChange={(seed) => set({ seed })} />
                    <Button words={t("Another seed")} class="words" onClick={() => set({ seed: Math.floor(Math.random() * 1e6) })} />
                </div>
                <Check
                    label={t("All face one way")}
                    value={crowd.direction !== null}
                    onChange={(on) => set(on ? { direction: 0, speed: 1 } : { direction: null, speed: 0 })}
                />
                {crowd.direction !== null && (
                    <>
                        <NumberField label={t("Direction")} unit="°" value={crowd.direction} min={-360} max={360} step={5} onChange={(direction) => set({ direction })} />
                        <NumberField label={t("Speed at which each would walk")} unit="m/s" value={crowd.speed} min={0} max={20} step={0.1} onChange={(speed) => set({ speed })} />
                    </>
                )}
                {crowd.direction !== null && !["own", "none"].includes(plan.value.made.motion.kind) && <p class="note">{t("Now the tab Motion says what moves them.")}</p>}
                <Choice
                    label={t("Material")}
                    value={crowd.material}
                    choices={[
                        ["human_naked", t("Skin")],
                        ["human_clothes", t("Clothes")],
                        ["human_soft", t("A softer chest")],
                    ]}
                    onChange={(material) => set({ material, friction: null })}
                />
                <NumberField label={t("Friction")} value={frictionOf(crowd)} min={0} max={2} step={0.05} onChange={(friction) => set({ friction })} />
                {Object.keys(crowd.mix).length === 0 && <Check label={t("Round bodies: one disk each, of the same area")} value={crowd.round} onChange={(round) => set({ round, ...(round ? { levels: null } : {}) })} />}
                {!crowd.round && (
                    <Choice
                        label={t("Levels")}
                        value={String(crowd.levels ?? 1)}
                        choices={[
                            ["1", t("As seen from above")],
                            ["2", "2"],
                            ["3", "3"],
                            ["5", "5"],
                        ]}
                        onChange={(levels) => set({ levels: levels === "1" ? null : Number(levels) })}
                    />
                )}
                <MakeCrowd />
            </form>
            <Hand />
            {made.value && <Placed made={made.value} />}
        </div>
    );
}

function Placed({ made: { density, area, largest_overlap, statistics } }: { made: PlacedCrowd }) {
    return (
        <section class="panel" aria-label={t("As it was placed")}>
            <h2>{t("As it was placed")}</h2>
            <p>{t("{density} people per m², on {area} m². Deepest overlap: {overlap} mm.", { density: fixed(density, 2), area: fixed(area, 2), overlap: digits(1000 * largest_overlap, 2) })}</p>
            <div class="wide" tabIndex={0} role="region" aria-label={t("Statistics")}>
                <table class="statistics">
                    <Head of={[t("Measure"), t("Mean"), t("SD"), t("Least"), t("Most")]} />
                    {statistics.map((kind) => (
                        <Kind key={kind.kind} {...kind} />
                    ))}
                </table>
            </div>
        </section>
    );
}

const KINDS: Record<string, string> = { male: t("Men"), female: t("Women") };

function Kind({ kind, count, measures }: PlacedCrowd["statistics"][number]) {
    return (
        <tbody>
            <tr>
                <th colSpan={5} scope="rowgroup" class="kind">
                    {KINDS[kind] ?? <KindName kind={kind} />} ({count})
                </th>
            </tr>
            {measures.map(({ measure, unit, ...row }) => {
                const inCm = unit === "m" && plan.value.unit === "cm";
                const places = unit === "m" && !inCm ? 3 : 1;
                const cell = (value: number | null) => (value === null ? "–" : fixed(value * (inCm ? 100 : 1), places));
                return (
                    <tr key={measure}>
                        <th scope="row">
                            {nameOf(measure)} <span class="unit">[{inCm ? "cm" : unit}]</span>
                        </th>
                        {[row.mean, row.sd, row.min, row.max].map((value, k) => (
                            <td key={k}>{cell(value)}</td>
                        ))}
                    </tr>
                );
            })}
        </tbody>
    );
}
