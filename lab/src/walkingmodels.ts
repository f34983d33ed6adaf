// The walking models as the page offers them, in this order.

import { t } from "./language";
import type { WalkingModelName } from "./protocol";

/** `tsc` refuses a model without words. */
export const MODELS: Record<WalkingModelName, { name: string; use: string }> = {
    rotational: { name: "Rotational", use: t("People see where others will be, step aside and turn their shoulders. Take this model for evacuation, corridors, counterflow and single file.") },
    "collision-free-speed": { name: t("Collision-free speed"), use: t("People turn aside from others and from walls, and keep a distance in time. Flows through doors are about half of what people reach.") },
    "social-force": { name: t("Social force"), use: t("Others and walls repel. Flows through doors are several times too great: not for evacuation times.") },
    straight: { name: t("Straight on"), use: t("The paper's rule: people go on, whoever is in the way, and push. It shows pressure, not evacuation times.") },
};

export const MODEL_NAMES = Object.keys(MODELS) as WalkingModelName[];
