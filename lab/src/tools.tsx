// Tools beside the picture: each opens the forms that it belongs to, and draws.

import { t } from "./language";
import { kindOf, setKind } from "./motion";
import { begin as beginMotion, mode as motionMode, type Mode as MotionMode } from "./motionstate";
import { Button } from "./parts";
import { change, plan } from "./plan";
import type { Motion } from "./protocol";
import { aim, begin as beginRoom, fixed, mode as roomMode, type Mode as RoomMode } from "./roomtool";

type ToolOf = { name: string; title: string } & ({ room: RoomMode } | { motion: MotionMode; kind: Motion["kind"] });

const TOOLS: ToolOf[] = [
    { name: t("Door"), title: t("Put a door into a wall"), room: "door" },
    { name: t("Wall"), title: t("Draw a wall: click its corners"), room: "wall" },
    { name: t("Obstacle"), title: t("Draw an obstacle: a rectangle from corner to corner"), room: "rectangle" },
    { name: t("People"), title: t("Draw where people stand: a rectangle from corner to corner"), room: "region" },
    { name: t("Push"), title: t("Draw a push: from the middle of its circle to the tip of its arrow"), motion: "push", kind: "push" },
    { name: t("Exit"), title: t("Draw an exit: click both ends of its line"), motion: "exit line", kind: "go" },
];

export function Tools() {
    // People are placed in crowds of this page only, and some walls of a Trial are only seen.
    const ofCrowd = plan.value.made.base.kind === "crowd";
    const there = TOOLS.filter((tool) => "motion" in tool || ofCrowd || (tool.room !== "region" && !fixed.value));
    return (
        <div class="together" role="group" aria-label={t("Draw")}>
            {there.map((tool) => {
                const on = "room" in tool ? plan.value.tab === "room" && roomMode.value === tool.room : plan.value.tab === "motion" && motionMode.value === tool.motion;
                return (
                    <Button key={tool.name} words={tool.name} title={tool.title} aria-pressed={on} onClick={() => (on ? end() : take(tool))} />
                );
            })}
        </div>
    );
}

function end() {
    beginRoom("change");
    beginMotion("change");
}

function take(tool: ToolOf) {
    end();
    if ("room" in tool) {
        if (plan.value.made.base.kind !== "crowd") aim("trial");
        change({ tab: "room" });
        return beginRoom(tool.room);
    }
    if (kindOf() !== tool.kind) setKind(tool.kind);
    change({ tab: "motion" });
    beginMotion(tool.motion);
}
