// The answer to the question of the scene, over the stage.

import { perExit } from "./csv";
import { EXAMPLES } from "./examples";
import type { Film } from "./film";
import { SQUEEZE } from "./frames";
import { about, fixed, t } from "./language";
import { calmly } from "./layout";
import { worst } from "./limit";
import { brief, Button, named } from "./parts";
import { plan, scene } from "./plan";
import type { Sustained } from "./protocol";
import { selected } from "./session";
import { viewed } from "./storage";
import { UntilLeft } from "./transport";

/** The example on the stage, as long as it has its name, or that of a copy. */
export const example = () => EXAMPLES.find(({ name }) => [name, t("{name} (copy)", { name: t(name) })].includes(scene.value.name));

/** The question of the scene in words, also before it is on the stage; empty if there is none. */
export function questionOf(film: Film | null): string {
    const { base, motion } = plan.value.made;
    const n = film?.scene.agents.length ?? (base.kind === "crowd" ? (base.number ?? 0) : 0);
    return example()?.question(n) ?? (motion.kind === "go" && n > 0 ? t("How long do {n} people need to leave?", { n }) : "");
}

/** What is asked of the scene on the stage. */
export function askedOf({ scene: { leaving } }: Film) {
    return leaving > 0 ? (example()?.asks ?? "left") : "squeeze";
}

/** How many have left in a frame, or when all had. */
export function leftWords({ frames, emptied, scene: { leaving, step } }: Film, k: number): string {
    const end = emptied.value;
    return end !== null && k >= end ? t("All {n} have left after {time} s.", { n: leaving, time: fixed(end * step, 2) }) : t("{left} of {n} have left.", { left: frames.curve("left")[k]!, n: leaving });
}

/** The greatest squeeze of long duration, and whose; empty if there is none yet. */
export function worstWords(film: Film): string {
    const found = worst(film);
    return found ? t("{squeeze} N ({id}, at {at} s)", { squeeze: Math.round(found.squeeze), id: brief(film.scene.agents[found.who]!.id), at: fixed(found.at, 2) }) : "";
}

/** The frame of the second of a mean in which who has it is pressed most: at its end nothing may be seen any more. */
function hardest({ frames, scene: { step } }: Film, { at, who }: Sustained): number {
    const end = Math.min(frames.count - 1, Math.round(at / step));
    let best = end;
    for (let k = end; k > 0 && k * step > at - 1; k--) if (frames.number(k, who, SQUEEZE) > frames.number(best, who, SQUEEZE)) best = k;
    return best;
}

interface Known {
    words: string;
    /** When it was so, and of whom, if of one. */
    frame: number;
    who?: number;
}

/** What is known, also of frames that were computed but not shown; else what is to be told until then. */
function known(film: Film): Known | string {
    const { step } = film.scene;
    const asked = askedOf(film);
    if (asked === "squeeze") {
        const found = worst(film);
        const name = t("Greatest squeeze, mean of 1 s");
        if (!found) return about(name, "–");
        return { words: about(name, worstWords(film)), frame: hardest(film, found), who: found.who };
    }
    const [emptied, computed] = [film.emptied.value, calmly(film, film.computed) - 1];
    const k = emptied ?? calmly(film, film.shown);
    const wordsAt = (k: number) => {
        const exits = asked === "exits" ? perExit(film, k).map(({ name, people }) => about(named(name), people)) : [];
        return [leftWords(film, k), exits.join(", ")].filter(Boolean).join(" ");
    };
    const words = wordsAt(k);
    if (emptied !== null) return { words, frame: emptied };
    const gaveUp = film.bound.value !== null && computed === film.wanted.value;
    const ends = t("Not all have left after {time} s: it ends there.", { time: fixed(computed * step, 2) });
    return gaveUp ? { words: `${ends} ${wordsAt(computed)}`, frame: computed } : words;
}

export function Answer({ film }: { film: Film }) {
    const found = known(film);
    const question = !viewed && <small class="phone">{questionOf(film)}</small>;
    if (typeof found === "string") {
        return (
            <p class="answer">
                {question} {found} {!plan.value.more && <UntilLeft film={film} />}
            </p>
        );
    }
    const { words, frame, who } = found;
    const show = () => {
        void film.show(frame);
        if (who !== undefined) selected.value = who;
    };
    return (
        // What is known once and for all is told to those who do not see it.
        <p class="answer known" role={who === undefined ? "status" : undefined}>
            {question} <Button words={words} title={t("Shows this moment")} onClick={show} />
        </p>
    );
}
