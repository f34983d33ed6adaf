// What plays a run: buttons, and the timeline.

import { leavings } from "./csv";
import { eventOf, paceAt } from "./event";
import type { Film } from "./film";
import { fixed, local, t } from "./language";
import { calmly } from "./layout";
import { Legend } from "./legend";
import { Button, Choice, Icon, NumberField, Range } from "./parts";
import { change, FIRST, plan } from "./plan";

const PACES = [0.1, 0.25, 0.5, 1, 2, 4].map((pace) => [String(pace), `${local(pace)} ×`] as const);
const ICONS = {
    play: "M4 2.5v11l9.5-5.5z",
    pause: "M4 3h3v10H4zM9 3h3v10H9z",
    start: "M3 3h2v10H3zM13 3v10L5.5 8z",
    back: "M10 3v10L3 8zM11 3h2v10h-2z",
    step: "M6 3v10l7-5zM3 3h2v10H3z",
};

export function Transport({ film }: { film: Film }) {
    const playing = film.playing.value;
    const { more } = plan.value;
    const button = (name: string, icon: keyof typeof ICONS, press: () => void) => (
        <button type="button" class={icon === "play" || icon === "pause" ? "main" : undefined} aria-label={name} title={name} onClick={press}>
            <Icon path={ICONS[icon]} />
        </button>
    );
    return (
        <div class="transport" role="group" aria-label={t("Run")}>
            <div class="controls">
                {button(t("To the start"), "start", () => void film.show(0))}
                {more && button(t("Step back"), "back", () => void film.show(Math.ceil(film.place.value) - 1))}
                {button(playing ? "Pause" : t("Play"), playing ? "pause" : "play", () => (film.playing.value = !playing))}
                {more && button(t("Step"), "step", () => void film.show(film.shown.value + 1))}
                <Choice label={t("Pace")} value={String(plan.value.pace)} choices={[["0", t("{pace} × by itself", { pace: plan.value.pace ? 1 : paceAt(film, calmly(film, film.shown)) })], ...PACES]} onChange={(pace) => change({ pace: Number(pace) })} />
                {more && <NumberField label={t("End of the timeline")} short={t("timeline")} unit="s" value={Number(endOf(film).toFixed(3))} min={film.scene.step} max={1e5} step={5} onChange={(end) => change({ end })} />}
                {more && <UntilLeft film={film} />}
                {!more && <Legend film={film} />}
            </div>
            {more && <Status film={film} />}
            <Timeline film={film} />
        </div>
    );
}

/** In s: where the timeline ends, unless it was played further. */
const endOf = (film: Film) => (plan.value.end === FIRST.end ? eventOf(film)?.[1] : undefined) ?? plan.value.end;

/** The last frame of the timeline and the charts: where the user wants it, or later if it was played further. */
export function lastOf(film: Film): number {
    return Math.max(Math.ceil(endOf(film) / film.scene.step - 1e-9), film.playing.value ? film.reached.peek() : film.reached.value);
}

/** In s: a run in which somebody is stuck would go on for ever. */
export const BOUND = 600;

/** Computes until all have left, or stops it. */
export function UntilLeft({ film }: { film: Film }) {
    if (film.scene.leaving === 0) return null;
    const there = calmly(film, film.computed) - 1;
    const emptied = film.emptied.value;
    if (film.bound.value !== null && film.wanted.value > there && !film.failed.value) return <Button words={t("Stop computing")} onClick={() => film.stop()} />;
    // Tables and the report end at the last frame that was shown or asked for.
    const over = (emptied !== null && calmly(film, film.reached) >= emptied) || there * film.scene.step >= BOUND || there >= film.most - 1;
    return <Button words={t("Until all have left")} disabled={over} title={t("Computes until nobody who has an exit is left, at most up to {most} s", { most: BOUND })} onClick={() => void film.computeUntilLeft(BOUND)} />;
}

function Timeline({ film }: { film: Film }) {
    const { step } = film.scene;
    // The page is laid out again when a text changes, so not for each picture.
    const [k, computed] = [calmly(film, film.shown), calmly(film, film.computed)];
    const last = lastOf(film);
    const decimals = Math.max(2, Math.min(6, Math.ceil(-Math.log10(step))));
    const time = `${fixed(k * step, decimals)} s`;
    const { motion } = plan.value.made;
    const pushes = motion.kind === "push" ? motion.pushes : [];
    const x = (frame: number) => (1000 * Math.min(frame, last)) / Math.max(1, last);
    return (
        <label class="scrub">
            <span class="hidden">{t("Time")}</span>
            <span class="time">{time}</span>
            <span class="track">
                <svg viewBox="0 0 1000 10" preserveAspectRatio="none" aria-hidden="true">
                    <rect width="1000" height="10" class="whole" />
                    <rect width={x(computed - 1)} height="10" class="computed" />
                    <rect width={x(k)} height="10" class="played" />
                    {pushes.map(({ start, duration }, j) => (
                        <rect key={j} x={x(start / step)} y="0" width={Math.max(2, x((start + duration) / step) - x(start / step))} height="10" class="pushed" />
                    ))}
                    <path d={leavings(film, computed - 1).map(({ frame }) => `M${x(frame)} 0V10`).join("")} class="left" />
                </svg>
                <Range aria-valuetext={time} min={0} max={last} value={k} onSlide={(to) => void film.show(to)} />
            </span>
        </label>
    );
}

/** How far it is computed: a line of its own, which moves nothing. */
function Status({ film }: { film: Film }) {
    return <p class="note status">{t("computed: {computed} s", { computed: fixed((calmly(film, film.computed) - 1) * film.scene.step, 1) })}</p>;
}
