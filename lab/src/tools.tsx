// Tools beside the picture: each opens the forms that it belongs to, and draws.

import { t } from "./language";
import { MEASURE } from "./line";
import { kindOf, setKind } from "./motion";
import { Button } from "./parts";
import { change, plan } from "./plan";
import type { Motion } from "./protocol";
import { aim, fixed, target } from "./roomtool";
import { begin, type Mode, mode } from "./tool";

const ENDS = t("Enter, a double click or a click on the first corner ends it.");
const RECTANGLE = t("Press at one corner of a rectangle and draw to the other one.");
const CORNERS = `${t("Click its corners.")} ${ENDS} ${t("Hold Shift for right angles.")}`;
/** Whether it is offered in all tabs; its name, and how it is used; what moves people with it. */
const TOOLS: [all: boolean, mode: Mode, name: string, hint: string, kind?: Motion["kind"]][] = [
    [false, "outline", t("Outline"), CORNERS],
    [true, "door", t("Door"), t("Click on a wall.")],
    [true, "wall", t("Wall"), CORNERS],
    [true, "rectangle", t("Obstacle"), RECTANGLE],
    [false, "polygon", t("Any shape"), CORNERS],
    [true, "region", t("People"), RECTANGLE],
    [true, "push", t("Push"), t("Press at the middle of the circle and draw the arrow: 1 m of it is 500 N."), "push"],
    [false, "way", t("Way"), t("Click its points one after the other. Enter or a double click ends it."), "walk"],
    [true, "exit line", t("Exit"), t("Click both ends of the line that people cross to leave."), "go"],
    [false, "exit area", t("Exit area"), t("Click the corners of the area in which people leave. {ends}", { ends: ENDS }), "go"],
    [false, "goal line", t("Goal"), t("Click both ends of the line where people stay."), "go"],
    [false, "goal area", t("Goal area"), t("Click the corners of the area in which people stay. {ends}", { ends: ENDS }), "go"],
];

export function Tools() {
    const { tab, made } = plan.value;
    // People are placed in crowds of this page only, and some walls of a Trial are only seen.
    const ofCrowd = made.base.kind === "crowd";
    const can = (tool: Mode) => ofCrowd || (tab === "room" && target.value === "forms") || (tool !== "region" && tool !== "outline" && !fixed.value);
    const there = TOOLS.filter(([all, tool, , , kind]) => (kind ? tab !== "room" : tab !== "motion" && can(tool)) && (all || tab === "room" || (tab === "motion" && kindOf() === kind)));
    return (
        <div class="together" role="group" aria-label={t("Draw")}>
            {there.map(([, tool, name, hint, kind]) => (
                <Button key={tool} words={name} title={hint} aria-pressed={mode.value === tool} onClick={() => (mode.value === tool ? begin("change") : take(tool, kind))} />
            ))}
        </div>
    );
}

/** How the tool that draws now is used. */
export function ToolHint() {
    const hint = mode.value === "measure" ? MEASURE : TOOLS.find(([, tool]) => tool === mode.value)?.[3];
    return <p role="status">{hint && `${hint} ${t("Esc ends it without a change.")}`}</p>;
}

function take(tool: Mode, kind?: Motion["kind"]) {
    const { tab, made } = plan.value;
    if (!kind && made.base.kind !== "crowd" && tab !== "room") aim("trial");
    if (kind && kindOf() !== kind) setKind(kind);
    change({ tab: kind ? "motion" : "room" });
    begin(tool);
}
