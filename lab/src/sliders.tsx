// What can be asked of the scene at once: sliders that act while it runs.

import { edited } from "./drawn";
import type { KeptCrowd } from "./forms";
import { change, plan } from "./plan";
import type { Motion, Wishes } from "./protocol";
import { choose, film } from "./session";

interface Slider {
    label: string;
    unit: string;
    value: number;
    range: [number, number, number];
    set(value: number): void;
}

function inCrowd(part: Partial<KeptCrowd>) {
    change({ crowd: { ...plan.value.crowd, ...part } });
}

function inMotion(motion: Motion) {
    choose({ motion }, film.value?.playing.value ?? false);
}

function ofCrowd(crowd: KeptCrowd): Slider[] {
    const { number, room, men } = crowd;
    const [door] = room.doors;
    const found: Slider[] = [];
    if (number !== null) found.push({ label: "People", unit: "", value: number, range: [1, Math.max(200, number), 1], set: (number) => inCrowd({ number }) });
    if (door) {
        found.push({
            label: room.doors.length > 1 ? "Width of door 1" : "Width of the door",
            unit: "m",
            value: door.width,
            range: [0.5, 3, 0.05],
            // The same way of writing a room as after an edit with the mouse.
            set: (width) => inCrowd({ room: edited({ ...room, doors: [{ ...door, width }, ...room.doors.slice(1)] }, { do: "move", ring: 0, corner: 0, to: room.outline[0]! }) }),
        });
    }
    found.push({ label: "Men", unit: "%", value: Math.round(100 * men), range: [0, 100, 5], set: (share) => inCrowd({ men: share / 100 }) });
    return found;
}

function ofMotion(motion: Motion): Slider[] {
    if (motion.kind === "push") {
        const [first] = motion.pushes;
        const set = (force: number) => inMotion({ ...motion, pushes: motion.pushes.map((push) => ({ ...push, force })) });
        return first ? [{ label: "Force of the pushes", unit: "N", value: first.force, range: [50, Math.max(2000, first.force), 50], set }] : [];
    }
    if (motion.kind === "walk") return [{ label: "Desired speed", unit: "m/s", value: motion.speed, range: [0, 3, 0.05], set: (speed) => inMotion({ ...motion, speed }) }];
    if (motion.kind !== "go") return [];
    const { wishes } = motion;
    const set = (part: Partial<Wishes>) => inMotion({ kind: "go", wishes: { ...wishes, ...part } });
    return [{ label: "Desired speed", unit: "m/s", value: wishes.desired_speed, range: [0, 3, 0.05], set: (desired_speed) => set({ desired_speed }) }];
}

export function Sliders() {
    const { made, crowd } = plan.value;
    const sliders = [...(made.base.kind === "crowd" ? ofCrowd(crowd) : []), ...ofMotion(made.motion)];
    return (
        <div class="sliders">
            {sliders.map(({ label, unit, value, range: [min, max, step], set }) => (
                <label key={label} class="scrub">
                    <span>
                        {label}: <strong>{Number(value.toFixed(2))}</strong> {unit}
                    </span>
                    <input type="range" min={min} max={Math.max(max, value)} step={step} value={value} onInput={(event) => set(event.currentTarget.valueAsNumber)} />
                </label>
            ))}
        </div>
    );
}
