// A crowd: who, how many, in which room.

import { signal } from "@preact/signals";
import { NumberField } from "./parts";
import { change, plan } from "./plan";
import type { CrowdWanted, Progress } from "./protocol";

export const progress = signal<Progress | null>(null);

const STAGES = ["growing", "spreading", "shaking", "pressing", "thinning"];

export function CrowdTab({ make, stop }: { make(): void; stop(): void }) {
    const { crowd, unit } = plan.value;
    const set = (part: Partial<CrowdWanted>) => change({ crowd: { ...crowd, ...part } });
    const by = unit === "cm" ? 100 : 1;
    const side = (k: 0 | 1, value: number): [number, number] => (k ? [crowd.room[0], value] : [value, crowd.room[1]]);
    return (
        <form
            class="panel"
            aria-label="Crowd"
            noValidate
            onSubmit={(event) => {
                event.preventDefault();
                if (!event.currentTarget.querySelector("[aria-invalid=true]")) make();
            }}
        >
            <NumberField label="People" value={crowd.number} min={1} max={5000} step={1} onChange={(number) => set({ number })} />
            {([0, 1] as const).map((k) => (
                <NumberField
                    key={k}
                    label={k ? "Room, up" : "Room, across"}
                    unit={unit}
                    value={Number((crowd.room[k] * by).toFixed(3))}
                    min={0.5 * by}
                    max={200 * by}
                    step={0.01 * by}
                    onChange={(value) => set({ room: side(k, value / by) })}
                />
            ))}
            <p class="note">{(crowd.number / (crowd.room[0] * crowd.room[1])).toFixed(2)} people per m²</p>
            <NumberField label="Men" unit="%" value={Math.round(100 * crowd.men)} min={0} max={100} step={1} onChange={(men) => set({ men: men / 100 })} />
            <NumberField label="Seed" value={crowd.seed} min={0} max={2 ** 32} step={1} onChange={(seed) => set({ seed })} />
            <label class="check">
                <input
                    type="checkbox"
                    checked={crowd.direction !== null}
                    onChange={(event) => set(event.currentTarget.checked ? { direction: 0, speed: 1 } : { direction: null, speed: 0 })}
                />
                All walk one way
            </label>
            {crowd.direction !== null && (
                <>
                    <NumberField label="Direction" unit="°" value={crowd.direction} min={-180} max={360} step={1} onChange={(direction) => set({ direction })} />
                    <NumberField label="Speed at which each would walk" unit="m/s" value={crowd.speed} min={0} max={3} step={0.1} onChange={(speed) => set({ speed })} />
                </>
            )}
            {progress.value ? (
                <>
                    <button type="button" onClick={stop}>
                        Stop
                    </button>
                    <p>
                        {STAGES[progress.value.stage]}, round {progress.value.iteration}: {progress.value.density.toFixed(2)} people per m², overlaps up to{" "}
                        {(1000 * progress.value.overlap).toFixed(1)} mm
                    </p>
                </>
            ) : (
                <button type="submit" class="main">
                    Make this crowd
                </button>
            )}
        </form>
    );
}
