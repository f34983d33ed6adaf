// A crowd: who and how many; then its statistics, and single people by hand.

import { ready } from "./drawn";
import { Hand } from "./hand";
import { Check, Choice, digits, Head, NumberField } from "./parts";
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
    if (base.kind === "crowd") return isPlaced() ? null : <p class="note">The picture shows the people as they could be placed last.</p>;
    return (
        <>
            <p class="note">The scene is no crowd of this page. From here on, people are placed again whenever something changes here.</p>
            <button type="submit" class="main" disabled={client.slow.value?.ask === "show" || !ready()} onClick={(event) => fits(event.currentTarget) && place(true)}>
                Make this crowd
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
                aria-label="Crowd"
                noValidate
                onSubmit={(event) => event.preventDefault()}
            >
                <h2>Crowd</h2>
                <Choice
                    label="How many"
                    value={crowd.number === null ? "density" : "number"}
                    choices={[
                        ["number", "A number of people"],
                        ["density", "People per m²"],
                    ]}
                    onChange={(by) => set(by === "number" ? { number: 40, density: null } : { number: null, density: 3 })}
                />
                {crowd.number !== null && <NumberField label="People" value={crowd.number} min={1} max={5000} step={1} onChange={(number) => set({ number })} />}
                {crowd.density !== null && <NumberField label="Density" unit="1/m²" value={crowd.density} min={0.01} max={20} step={0.5} onChange={(density) => set({ density })} />}
                <MixForm mix={crowd.mix} onChange={(mix) => set({ mix, ...(Object.keys(mix).length > 0 ? { round: false } : {}) })} />
                <People people={crowd.people} onChange={(people) => set({ people })} />
                <NumberField label="Men" unit="%" value={Number((100 * crowd.men).toFixed(2))} min={0} max={100} step={5} onChange={(men) => set({ men: men / 100 })} />
                <div class="row">
                    <NumberField label="Seed" value={crowd.seed} min={0} max={2 ** 53 - 1} step={1} onChange={(seed) => set({ seed })} />
                    <button type="button" class="words" onClick={() => set({ seed: Math.floor(Math.random() * 1e6) })}>
                        Another seed
                    </button>
                </div>
                <Check
                    label="All face one way"
                    value={crowd.direction !== null}
                    onChange={(on) => set(on ? { direction: 0, speed: 1 } : { direction: null, speed: 0 })}
                />
                {crowd.direction !== null && (
                    <>
                        <NumberField label="Direction" unit="°" value={crowd.direction} min={-360} max={360} step={5} onChange={(direction) => set({ direction })} />
                        <NumberField label="Speed at which each would walk" unit="m/s" value={crowd.speed} min={0} max={20} step={0.1} onChange={(speed) => set({ speed })} />
                    </>
                )}
                {crowd.direction !== null && !["own", "none"].includes(plan.value.made.motion.kind) && <p class="note">Now the tab Motion says what moves them.</p>}
                <Choice
                    label="Material"
                    value={crowd.material}
                    choices={[
                        ["human_naked", "Skin"],
                        ["human_clothes", "Clothes"],
                        ["human_soft", "A softer chest"],
                    ]}
                    onChange={(material) => set({ material, friction: null })}
                />
                <NumberField label="Friction" value={frictionOf(crowd)} min={0} max={2} step={0.05} onChange={(friction) => set({ friction })} />
                {Object.keys(crowd.mix).length === 0 && <Check label="Round bodies: one disk each, of the same area" value={crowd.round} onChange={(round) => set({ round })} />}
                <MakeCrowd />
            </form>
            <Hand />
            {made.value && <Placed made={made.value} />}
        </div>
    );
}

function Placed({ made: { density, area, largest_overlap, statistics } }: { made: PlacedCrowd }) {
    return (
        <section class="panel" aria-label="As it was placed">
            <h2>As it was placed</h2>
            <p>
                {density.toFixed(2)} people per m², on {area.toFixed(2)} m². Deepest overlap: {digits(1000 * largest_overlap, 2)} mm.
            </p>
            <div class="wide" tabIndex={0} role="region" aria-label="Statistics">
                <table class="statistics">
                    <Head of={["Measure", "Mean", "SD", "Least", "Most"]} />
                    {statistics.map((kind) => (
                        <Kind key={kind.kind} {...kind} />
                    ))}
                </table>
            </div>
        </section>
    );
}

const KINDS: Record<string, string> = { male: "Men", female: "Women" };

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
                const cell = (value: number | null) => (value === null ? "–" : (value * (inCm ? 100 : 1)).toFixed(places));
                return (
                    <tr key={measure}>
                        <th scope="row">
                            {measure} <span class="unit">[{inCm ? "cm" : unit}]</span>
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
