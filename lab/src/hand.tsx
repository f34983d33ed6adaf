// The panel for single people. Dragging is in handtool.ts.

import { useEffect } from "preact/hooks";
import { chosen, copy, drop, forget, handTool, movable, put, said } from "./handtool";
import { count, t } from "./language";
import { Button, FAR, LengthField, NumberField } from "./parts";
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
        <section class="panel" aria-label={t("By hand")}>
            <h2>{t("By hand")}</h2>
            {movable.value ? <Chosen /> : <AtStart />}
            {edits.length > 0 && (
                <p class="note">
                    {count(edits.length, "{n} change by hand.", "{n} changes by hand.")}{" "}
                    <Button words={t("Take all back")} onClick={() => choose({ edits: all.filter((edit) => edit.do === "room") }, false)} />
                </p>
            )}
        </section>
    );
}

function AtStart() {
    return (
        <p class="note">
            {t("People can be moved where they start.")}{" "}
            <Button words={t("Go to the start")} onClick={() => film.value?.show(0)} />
        </p>
    );
}

function Chosen() {
    const now = chosen.value;
    if (!now) return <p class="note">{t("Drag a person on the picture, or select one to turn, copy or delete it.")}</p>;
    const { scene } = film.value!;
    const degrees = Number(((now.theta * 180) / Math.PI).toFixed(1));
    return (
        <>
            <p class="note">{t("Person {id}. Drag it, or the handle before it to turn it. Keys on the picture: Shift with arrows moves by 5 cm, Delete removes.", { id: scene.agents[now.agent]!.id })}</p>
            <div class="row">
                <LengthField of={t("Person")} label="x" value={now.x} min={-FAR} max={FAR} onChange={(x) => put({ ...(chosen.peek() ?? now), x })} />
                <LengthField of={t("Person")} label="y" value={now.y} min={-FAR} max={FAR} onChange={(y) => put({ ...(chosen.peek() ?? now), y })} />
                <NumberField
                    of={t("Person")}
                    label={t("faces")}
                    unit="°"
                    value={degrees}
                    min={-360}
                    max={360}
                    step={5}
                    onChange={(angle) => put({ ...(chosen.peek() ?? now), theta: (angle * Math.PI) / 180 })}
                />
            </div>
            <div class="buttons">
                <Button words={t("Copy person")} onClick={() => copy(now)} />
                <Button words={t("Delete person")} disabled={scene.agents.length < 2} onClick={() => drop(now)} />
            </div>
            <p role="status" class="note">
                {said.value}
            </p>
        </>
    );
}
