// Side by side: a run that is kept beside the one that is changed, with the same clock.

import { computed, effect, signal, untracked } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { leftWords } from "./answer";
import { ByPlace, byPlace, mapKind } from "./byplace";
import { Client, Stopped } from "./client";
import { averaged, colourOf, isKnown, meanWords, scaleOf, shade, values } from "./colour";
import { inksOf, Painter, paintBar } from "./draw";
import { paintPlaces } from "./drawplaces";
import type { Film } from "./film";
import { frictionOf } from "./forms";
import { count, fixed, local, t } from "./language";
import { calmly, canvas } from "./layout";
import { fitted, look, view as shown } from "./look";
import { dampings, moduli } from "./mechanics";
import { mixWords } from "./mix";
import { openWords } from "./opentimes";
import { Button, digits, named } from "./parts";
import { type Made, plan, title } from "./plan";
import type { Opened } from "./protocol";
import { heightOf, sceneAt } from "./sections";
import { film, sent } from "./session";
import { walkingSeed } from "./sweep";
import { BOUND } from "./transport";
import type { View } from "./view";

/** The run, and facts of its scene. */
export const kept = signal<{ film: Film; facts: string[] } | null>(null);

// The clock stops when the later one of both has ended.
effect(() => {
    const now = film.value;
    const other = kept.value?.film;
    if (now) now.least = other ? Math.round(((other.emptied.value ?? 0) * other.scene.step) / now.scene.step) : 0;
});

/** The run that is kept, once another one is on the stage. */
export const beside = computed(() => (film.value && film.value !== kept.value?.film ? (kept.value?.film ?? null) : null));

// The page's worker has another scene now: one of its own computes the rest of it.
effect(() => {
    const run = beside.value;
    if (!run) return;
    const client = new Client();
    const rest = async () => run.goOn(client, await shownTo(client, run), run.scene.leaving > 0 ? BOUND : plan.peek().end);
    untracked(() => void rest().catch(() => {}));
    return () => client.close("stopped");
});

/** What a scene was made of, in a few words each. */
function factsOf({ base: crowd, motion, mechanics, edits }: Made): string[] {
    const parts = [`"${title.value}"`];
    if (crowd.kind === "crowd") {
        parts.push(crowd.number === null ? t("{density} people per m²", { density: crowd.density! }) : count(crowd.number, "{n} person", "{n} people"));
        for (const { width, open } of crowd.room.doors) parts.push([t("door {width} m", { width: Number(width.toFixed(3)) }), openWords(open)].filter(Boolean).join(", "));
        parts.push(crowd.material, t("friction {friction}", { friction: frictionOf(crowd) }), crowd.round ? t("round bodies") : crowd.levels ? t("disks in {levels} levels", { levels: crowd.levels }) : t("real bodies"), ...mixWords(crowd.mix));
        if (crowd.men !== 0.5) parts.push(t("{men} % men", { men: Math.round(100 * crowd.men) }));
    }
    if (edits.some((edit) => edit.do === "room")) parts.push(t("walls changed"));
    if (mechanics) parts.push(...moduli(mechanics), ...dampings(mechanics));
    if (mechanics?.time_step) parts.push(t("communication {step} s", { step: mechanics.time_step }));
    if (mechanics?.time_step_mechanical) parts.push(t("steps of {step} s", { step: mechanics.time_step_mechanical }));
    if (motion.kind === "go") {
        const { desired_speed, model, groups, start, exits } = motion.decision;
        parts.push(`${local(desired_speed)} m/s`, model);
        if (groups) parts.push(t("{share} % in groups", { share: Number((100 * groups.share).toFixed(1)) }));
        if (start) parts.push(t("starts from {min} to {max} s", { min: start.min, max: start.max }));
        for (const { name, open } of exits) if (open) parts.push(t("exit {name}: {times}", { name: named(name), times: openWords(open) }));
    }
    if (motion.kind === "walk" && motion.shares) parts.push(t("Shares of the ways: {shares}", { shares: motion.shares.map(local).join("; ") }));
    const walking = walkingSeed(motion);
    const drawn = [crowd.kind === "crowd" && t("seed {seed}", { seed: crowd.seed }), walking !== null && t("walking has the seed {seed}", { seed: walking })];
    parts.push(...drawn.filter((words) => words !== false));
    if (motion.kind === "push" && motion.pushes[0]) parts.push(`${motion.pushes[0].force} N`);
    return parts;
}

/** The scene on the stage, so. */
export function facts(): string[] {
    return factsOf(film.value?.made ?? plan.value.made);
}

/** What of some facts is not among the others. */
export function differing(some: string[], others: string[]): string {
    return some.filter((fact) => !others.includes(fact)).join(", ");
}

/** What is different on the stage. */
export function difference(): string {
    return differing(facts(), kept.value!.facts);
}

export function Keep() {
    const now = film.value;
    return (
        <div class="buttons">
            {now && now !== kept.value?.film && (
                <Button words={t("Keep this run to compare")} title={t("Keeps this run beside what you change next, with the same clock")} onClick={() => (kept.value = { film: now, facts: factsOf(now.made) })} />
            )}
            {kept.value && (
                <Button words={t("End the comparison")} onClick={() => (kept.value = null)} />
            )}
        </div>
    );
}

/** The frame of the run that is kept at the time of another one; its last one after its end. */
export function frameOf(other: Film, place: number, run: Film): number {
    return Math.min(run.frames.count - 1, (place * other.scene.step) / run.scene.step);
}

/** Shows the scene of a run to another lab: that of the page has another scene now. Returns the number of the run there. */
export async function shownTo(client: Client, { made: { base, edits, mechanics, motion } }: Film): Promise<number> {
    const [scene, bytes] = await sent(base);
    return (await client.ask<Opened>({ ask: "show", ...scene, edits, mechanics, motion }, bytes)).value.scene.run;
}

/** The map of the run that is kept. */
function useMap() {
    const [map, refused] = useMemo(() => [signal<ByPlace | null>(null), signal("")], []);
    const run = kept.value!.film;
    const kind = mapKind.value;
    const quantity = kind && (kind === "density" ? kind : "squeeze");
    useEffect(() => {
        if (!quantity) return;
        const client = new Client();
        const until = () => (film.value ? (film.value.computed.value - 1) * film.value.scene.step : 0);
        const begun = shownTo(client, run).then((number) => void (map.value = new ByPlace(client, run, quantity, number, until)));
        // The picture is then without a map.
        begun.catch((error: Error) => error instanceof Stopped || (refused.value = error.message));
        const follow = effect(() => void map.value?.follow((void plan.value.smooth, void run.computed.value, void until(), plan.value.span)));
        // Both have the colours of the greatest value of both.
        const together = effect(() => {
            if (byPlace.value) byPlace.value.beside.value = map.value;
        });
        return () => {
            follow();
            together();
            map.value?.end();
            [map.value, refused.value] = [null, ""];
            if (byPlace.peek()) byPlace.peek()!.beside.value = null;
            client.close("another map is wanted");
        };
    }, [run, quantity]);
    return { map, refused };
}

/** The picture of the run that is kept, and its numbers at the shown time. */
export function Beside({ now }: { now: Film }) {
    const element = useRef<HTMLCanvasElement>(null);
    const run = kept.value!.film;
    const height = heightOf(run);
    const painter = useMemo(() => new Painter(sceneAt(run.scene, height)), [run, height]);
    const { map, refused } = useMap();
    useEffect(() => {
        const on = element.current!;
        const size = signal(0);
        const paint = effect(() => {
            size.value;
            if (on.width === 0) return;
            const context = on.getContext("2d")!;
            const { unit } = plan.value;
            const colour = colourOf(now, plan.value.colour);
            const place = frameOf(now, now.place.value, run);
            const main = canvas.value ?? on;
            const view: View = { ...shown.value, x: shown.value.x + (on.width - main.width) / 2, y: shown.value.y + (on.height - main.height) / 2 };
            const inks = inksOf(on);
            // Both have the colours of the one that is changed.
            const scale = scaleOf(now, colour);
            const known = isKnown(run, colour);
            const shades = Array.from(values(run, Math.floor(place), colour), (value) => shade(scale, known ? value : NaN));
            context.setTransform(1, 0, 0, 1, 0, 0);
            context.clearRect(0, 0, on.width, on.height);
            const [kind, places] = [mapKind.value, map.value];
            const filled = byPlace.value?.filled.value ? byPlace.value : null;
            if (kind && filled) places?.paint(kind, context, view, filled.scale(kind));
            painter.walls(context, view, inks, place * run.scene.step);
            painter.people(context, { frame: run.frames.at(place), shades, paths: null, selected: null, overlapping: [], faint: kind !== null }, view, inks);
            paintPlaces(context, run.scene.targets, view, inks);
            if (kind) places?.paintMost(kind, context, view, inks);
            paintBar(context, view, unit, inks);
        });
        const end = fitted(on, () => (size.value += 1));
        return () => {
            end();
            paint();
        };
    }, [run, now, painter]);
    const { facts: all } = kept.value!;
    const drag = ({ buttons, movementX, movementY }: PointerEvent) => {
        if (buttons === 1) look({ ...shown.value, x: shown.value.x + movementX * devicePixelRatio, y: shown.value.y + movementY * devicePixelRatio });
    };
    return (
        <div class="beside">
            <canvas ref={element} onPointerMove={drag} role="img" aria-label={t("The run that is kept: {all}", { all: all.join(", ") })} />
            <p class="note">
                {t("Kept: {facts}.", { facts: differing(all, facts()) || all[0]! })} <Now film={run} of={now} /> {refused.value}
            </p>
        </div>
    );
}

/** Numbers of a run at the time of another one. */
export function Now({ film: run, of }: { film: Film; of: Film }) {
    const shown = calmly(of, of.shown);
    const wanted = (shown * of.scene.step) / run.scene.step;
    const k = Math.floor(frameOf(of, shown, run));
    const { leaving, step } = run.scene;
    const all = run.emptied.value;
    const over = all !== null && k >= all;
    const squeezes = run.frames.greatestMean(averaged(run)).subarray(0, k + 1);
    const most = digits(squeezes.reduce((one, other) => Math.max(one, other), 0), 3);
    const words = [
        !over && wanted > run.frames.count - 1 && t("(only computed up to {end} s)", { end: fixed((run.frames.count - 1) * step, 1) }),
        leaving > 0 && leftWords(run, k),
        over ? t("Greatest squeeze so far: {most} N", { most }) : t("Greatest squeeze: {now} N, so far {most} N", { now: digits(squeezes[k]!, 3), most }),
    ];
    return <>{`${words.filter(Boolean).join(" ")} (${meanWords(run, k)}).`}</>;
}
