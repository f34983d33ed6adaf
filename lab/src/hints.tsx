// What is odd about a scene, told at once: nobody moves, or people are to walk through walls.

import { eventOf, pushTool } from "./event";
import type { Film } from "./film";
import { about, t } from "./language";
import { canUndo, plan } from "./plan";
import { tool } from "./tool";

/** Whether nobody of a crowd of this page can move. (What an opened Trial drives people with, only the engine knows.) */
function isMotionless({ scene }: Film): boolean {
    const { base, motion } = plan.value.made;
    if (base.kind !== "crowd" || scene.overlapping.length > 0) return false;
    return motion.kind === "none" || (motion.kind === "own" && (base.direction === null || base.speed === 0));
}

export function Hints({ film }: { film: Film }) {
    const ways = [...new Set(film.scene.crossed.map(([way]) => way + 1))];
    return (
        <>
            {tool.value === pushTool && eventOf(film) && !canUndo.value && <p class="note">{t("Drag a person to push.")}</p>}
            {isMotionless(film) && <p class="note">{t("Nobody moves here: the tab Motion says what moves them.")}</p>}
            {ways.length > 0 && (
                <p class="warning">{`${about(ways.length === 1 ? t("Way goes through a wall") : t("Ways go through a wall"), ways.join(", "))}. ${t("The cross shows where: people walk straight from point to point.")}`}</p>
            )}
        </>
    );
}
