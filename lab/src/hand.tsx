// The panel for single people. Dragging is in handtool.ts.

import { useEffect } from "preact/hooks";
import { chosen, copy, drop, forget, handTool, movable, put, said } from "./handtool";
import { LengthField, NumberField } from "./parts";
import { plan } from "./plan";
import { choose, film } from "./session";
import { useTool } from "./tool";

export function Hand() {
    useTool(handTool);
    useEffect(() => forget, []);
    const shown = film.value;
    useEffect(forget, [shown]);
    const all = plan.value.made.edits;
    // Walls belong to the tab Room.
    const edits = all.filter((edit) => edit.do !== "room");
    if (!shown) return null;
    return (
        <section class="panel" aria-label="By hand">
            <h2>By hand</h2>
            {movable.value ? <Chosen /> : <AtStart />}
            {edits.length > 0 && (
                <p class="note">
                    {edits.length} {edits.length === 1 ? "change" : "changes"} by hand.{" "}
                    <button type="button" onClick={() => choose({ edits: all.filter((edit) => edit.do === "room") }, false)}>
                        Take all back
                    </button>
                </p>
            )}
        </section>
    );
}

function AtStart() {
    return (
        <p class="note">
            People can be moved where they start.{" "}
            <button type="button" onClick={() => film.value?.show(0)}>
                Go to the start
            </button>
        </p>
    );
}

function Chosen() {
    const now = chosen.value;
    if (!now) return <p class="note">Drag a person on the picture, or select one to turn, copy or delete it.</p>;
    const { scene } = film.value!;
    const degrees = Number(((now.theta * 180) / Math.PI).toFixed(1));
    return (
        <>
            <p class="note">
                Person <span translate={false}>{scene.agents[now.agent]!.id}</span>. Drag it, or the handle before it to turn it. Keys on the picture: Shift with arrows moves by 5 cm, Delete removes.
            </p>
            <div class="row">
                <LengthField label="Person, x" short="x" value={now.x} min={-1000} max={1000} onChange={(x) => put({ ...(chosen.peek() ?? now), x })} />
                <LengthField label="Person, y" short="y" value={now.y} min={-1000} max={1000} onChange={(y) => put({ ...(chosen.peek() ?? now), y })} />
                <NumberField
                    label="Person, faces"
                    short="faces"
                    unit="°"
                    value={degrees}
                    min={-360}
                    max={360}
                    step={5}
                    onChange={(angle) => put({ ...(chosen.peek() ?? now), theta: (angle * Math.PI) / 180 })}
                />
            </div>
            <div class="buttons">
                <button type="button" onClick={() => copy(now)}>
                    Copy person
                </button>
                <button type="button" disabled={scene.agents.length < 2} onClick={() => drop(now)}>
                    Delete person
                </button>
            </div>
            <p role="status" class="note">
                {said.value}
            </p>
        </>
    );
}
