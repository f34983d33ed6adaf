// What can be asked of the scene at once: sliders that act while it runs. A sweep takes many values of one of them.

import { signal } from "@preact/signals";
import { edited } from "./drawn";
import { frictionOf, type KeptCrowd } from "./forms";
import { isOwn, kindName } from "./kindwords";
import { about, local, type Plain, t } from "./language";
import { type Mix, percent, shared } from "./mix";
import { Check, Range } from "./parts";
import { change, plan } from "./plan";
import type { DecisionConfig, Motion } from "./protocol";
import { choose, playsOn, goOn } from "./session";

/** A number of the scene. */
export interface Parameter {
    label: Plain;
    unit: string;
    value: number;
    range: [number, number, number];
    /** What is another one with another value. */
    with(value: number): { crowd: Partial<KeptCrowd> } | { motion: Motion };
}

function ofCrowd(crowd: KeptCrowd): Parameter[] {
    const { number, room, men } = crowd;
    const [door] = room.doors;
    const found: Parameter[] = [];
    if (number !== null) found.push({ label: "People", unit: "", value: number, range: [1, Math.max(200, number), 1], with: (number) => ({ crowd: { number } }) });
    if (door) {
        found.push({
            label: room.doors.length > 1 ? "Width of door 1" : "Width of the door",
            unit: "m",
            value: door.width,
            range: [0.5, 3, 0.05],
            // The same way of writing a room as after an edit with the mouse.
            with: (width) => ({ crowd: { room: edited({ ...room, doors: [{ ...door, width }, ...room.doors.slice(1)] }, { do: "move", ring: 0, corner: 0, to: room.outline[0]! }) } }),
        });
    }
    found.push({ label: "Friction", unit: "", value: frictionOf(crowd), range: [0, 1, 0.05], with: (friction) => ({ crowd: { friction } }) });
    found.push({ label: "Men", unit: "%", value: Math.round(100 * men), range: [0, 100, 5], with: (share) => ({ crowd: { men: share / 100 } }) });
    return found;
}

/** The mix before a slider is moved, until it is let go: on the way a kind may have no share, and comes back. */
const held = signal<Mix | null>(null);
const letGo = () => void (held.value = null);
// Also when the slider itself is gone.
for (const name of ["pointerup", "pointercancel"]) addEventListener(name, letGo);

/** Shares of all kinds that are there but adults. */
function ofKinds({ mix }: KeptCrowd): Parameter[] {
    const [now, from] = [percent(mix), percent(held.value ?? mix)];
    const kinds = Object.keys(from).filter((kind) => kind !== "adult" && !isOwn(kind));
    return kinds.map((kind) => ({ label: kindName(kind), unit: "%", value: now[kind] ?? 0, range: [0, 100, 1], with: (share) => ({ crowd: { mix: shared(from, kind, share) } }) }));
}

function ofMotion(motion: Motion): Parameter[] {
    const speed = (value: number, set: (speed: number) => Motion): Parameter => ({ label: "Desired speed", unit: "m/s", value, range: [0, 3, 0.01], with: (speed) => ({ motion: set(speed) }) });
    if (motion.kind === "push" && motion.pushes[0]) {
        const { force } = motion.pushes[0];
        const set = (force: number): Motion => ({ ...motion, pushes: motion.pushes.map((push) => ({ ...push, force })) });
        return [{ label: "Force of the pushes", unit: "N", value: force, range: [50, Math.max(2000, force), 50], with: (force) => ({ motion: set(force) }) }];
    }
    if (motion.kind === "walk") return [speed(motion.speed, (speed) => ({ ...motion, speed }))];
    if (motion.kind !== "go") return [];
    const { decision } = motion;
    const set = (part: Partial<DecisionConfig>): Motion => ({ kind: "go", decision: { ...decision, ...part } });
    return [speed(decision.desired_speed, (desired_speed) => set({ desired_speed }))];
}

/** Those of the scene on the stage. */
export function parameters(): Parameter[] {
    const { made, crowd } = plan.value;
    if (made.base.kind !== "crowd") return ofMotion(made.motion);
    // Those of a kind have the desired speed of their kind.
    return [...ofCrowd(crowd), ...ofKinds(crowd), ...ofMotion(made.motion).filter(({ label }) => label !== "Desired speed" || Object.keys(crowd.mix).length === 0)];
}

/** Gives one of them another value on the stage. The whole way of a slider is one step of Undo. */
function slide(parameter: Parameter, value: number) {
    const other = parameter.with(value);
    goOn();
    const asStep = held.value === null;
    held.value ??= plan.value.crowd.mix;
    if ("crowd" in other) change({ crowd: { ...plan.value.crowd, ...other.crowd } }, asStep);
    else choose(other, playsOn(), plan.value.crowd, "", asStep);
}

/** What most questions are about. */
const FIRST: Plain[] = ["Force of the pushes", "Width of the door", "Width of door 1", "Desired speed", "People"];

/** All, or not more than `most` of those that matter first. */
export function Sliders({ most }: { most?: number }) {
    const all = parameters();
    const shown = most ? FIRST.flatMap((first) => all.filter(({ label }) => label === first)).slice(0, most) : all;
    return (
        <div class="sliders">
            {shown.map((parameter) => {
                const { label, unit, value, range } = parameter;
                const [min, max, step] = range;
                return (
                    <label key={label} class="scrub">
                        <span>
                            {about(t(label), "")}<strong>{local(Number(value.toFixed(2)))}</strong> {unit}
                        </span>
                        <Range min={min} max={Math.max(max, value)} step={step} value={value} onSlide={(to) => slide(parameter, to)} onChange={letGo} />
                    </label>
                );
            })}
            {!most && plan.value.made.base.kind === "crowd" && Object.keys(plan.value.crowd.mix).length === 0 && (
                <Check label={<span title={t("Round bodies: one disk each, of the same area")}>{t("Round bodies")}</span>} value={plan.value.crowd.round} onChange={(round) => change({ crowd: { ...plan.value.crowd, round } })} />
            )}
        </div>
    );
}
