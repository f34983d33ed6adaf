// The run: the picture and all around it.

import { useEffect, useMemo } from "preact/hooks";
import { Answer } from "./answer";
import { ByPlace, byPlace, mapKind } from "./byplace";
import { Canvas } from "./canvas";
import { Charts } from "./charts";
import { play } from "./event";
import type { Film } from "./film";
import { Hints } from "./hints";
import { t } from "./language";
import { Chains, paintTrails, trailsNote } from "./layers";
import { beat, empty, type Layers, presents } from "./layout";
import { meanWords } from "./colour";
import { Beside, difference, kept, Now } from "./kept";
import { Legend } from "./legend";
import { fit, fits, zoom } from "./look";
import { MapLegend } from "./map";
import { MeasureButtons } from "./line";
import { Menu } from "./menu";
import { Button, Check, Choice, digits, in3d, length, LengthField, Range } from "./parts";
import { change, type Plan, plan } from "./plan";
import { heightOf, levelAt, Sections } from "./sections";
import { Sliders } from "./sliders";
import { viewed } from "./storage";
import { ToolHint, Tools } from "./tools";
import { Transport } from "./transport";

/** Milliseconds between two beats. */
const BEAT = 100;

export function Stage({ film }: { film: Film }) {
    useEffect(() => {
        let last = performance.now();
        let beaten = last;
        let handle = requestAnimationFrame(function next(now) {
            // The time of a picture may be before that of its request.
            if (film.playing.value) play(film, Math.max(0, now - last) / 1000);
            if (film.playing.value && now - beaten > BEAT) {
                beaten = now;
                beat.value += 1;
            }
            last = now;
            handle = requestAnimationFrame(next);
        });
        return () => cancelAnimationFrame(handle);
    }, [film]);
    const chains = useMemo(() => new Chains(film), [film]);
    const sections = useMemo(() => new Sections(film), [film]);
    const { view } = plan.value;
    const kind = mapKind.value;
    const quantity = kind && (kind === "density" ? kind : "squeeze");
    const places = useMemo(() => quantity && new ByPlace(film.client, film, quantity), [film, quantity]);
    useEffect(() => {
        byPlace.value = places;
        return () => places?.end();
    }, [places]);
    const alone = viewed || presents.value;
    return (
        <section class="stage" aria-label={t("Stage")}>
            {!alone && <Bar film={film} />}
            {view === "section" && <Altitude film={film} sections={sections} />}
            <div class={kept.value && view !== "3d" ? "frame two" : "frame"}>
                {kept.value && view !== "3d" && <Beside now={film} />}
                {view === "3d" ? <Stage3d film={film} /> : <Picture film={film} chains={chains} sections={sections} />}
                {view !== "3d" && (plan.value.more || !fits.value) && <Zoom />}
                <Answer film={film} />
                <Menu />
                <div class="over">
                    <Hints film={film} />
                    <ToolHint />
                    {kept.value && kept.value.film !== film && (
                        <p class="note">
                            {difference() && `${difference()}. `}
                            <Now film={film} of={film} />
                        </p>
                    )}
                    {view !== "3d" && <Widest chains={chains} />}
                    {view !== "3d" && plan.value.trails && trailsNote(film) && <p class="note">{trailsNote(film)}</p>}
                    {film.failed.value && <p role="alert">{film.failed.value}</p>}
                </div>
            </div>
            <p id="canvas-keys" class="hidden">
                {t("Arrow keys, N and P select people; plus and minus zoom, 0 shows all; the space bar plays; Shift+F10 opens the menu of who is selected.")}
            </p>
            {plan.value.more && <Legend film={film} />}
            {places && kind && <MapLegend film={film} places={places} kind={kind} />}
            <Transport film={film} />
            {viewed ? <Sliders most={2} /> : <Charts film={film} />}
        </section>
    );
}

function Picture({ film, chains, sections }: { film: Film; chains: Chains; sections: Sections }) {
    const { forces, trails } = plan.value;
    const layers = useMemo<Layers>(
        () => ({
            below: (context, now) => {
                if (mapKind.value) byPlace.value?.paint(mapKind.value, context, now);
                if (trails && !empty.value) paintTrails(context, film, film.shown.value, now);
            },
            above: (context, now) => {
                // They are of all heights.
                if (!forces || heightOf(film) !== null) return;
                chains.update(film.shown.value);
                chains.paint(context, now);
            },
            paths: () => {
                sections.facts.value;
                return sections.paths();
            },
        }),
        [film, forces, trails, chains, sections],
    );
    return <Canvas film={film} layers={layers} />;
}

function Widest({ chains }: { chains: Chains }) {
    if (!plan.value.forces || chains.largest === 0 || heightOf(chains.film) !== null) return null;
    return <p class="note">{t("Lines between people: the wider, the more they press at this moment. The widest is {largest} N; the colours are a {mean}.", { largest: digits(chains.largest, 3), mean: meanWords(chains.film) })}</p>;
}

function Altitude({ film, sections }: { film: Film; sections: Sections }) {
    const { altitude, unit } = plan.value;
    const n = film.scene.agents.length;
    const inLevels = heightOf(film) !== null;
    const level = film.scene.levels[levelAt(film, altitude)]?.map((end) => length(end, unit));
    useEffect(() => void sections.ask(altitude), [altitude, sections]);
    const facts = sections.facts.value;
    const set = (value: number) => change({ altitude: value });
    return (
        <>
            <div class="controls">
                <label class="scrub">
                    <span>{inLevels ? t("Height: {length} above the ground", { length: length(altitude, unit) }) : t("Altitude of the section: {length} above the ground", { length: length(altitude, unit) })}</span>
                    <Range min={0} max={2.2} step={0.01} value={altitude} onSlide={set} />
                </label>
                <LengthField label={t("Altitude")} value={altitude} min={0} max={2.5} onChange={set} />
            </div>
            {facts && (
                <p class="note">
                    {inLevels
                        ? t("{cut} of {n} people have disks at this height, with an area of {area} m².", { cut: facts.cut, n, area: digits(facts.area, 3) })
                        : t("The plane cuts {cut} of {n} bodies; the sections have an area of {area} m².", { cut: facts.cut, n, area: digits(facts.area, 3) })}{" "}
                    {inLevels && (level ? t("The level is from {low} to {high}.", { low: level[0]!, high: level[1]! }) : t("There is no level."))}
                    {facts.estimated && t("Sex and measures are not known: these are bodies that fit the disks, height and mass.")}
                </p>
            )}
            {sections.refused.value && <p role="alert">{sections.refused.value}</p>}
        </>
    );
}

const Stage3d = in3d<{ film: Film }>(() => import("./three"));

const views = ({ scene }: Film): [Plan["view"], string][] => [
    ["2d", t("From above")],
    ["3d", "3D"],
    ["section", scene.levels.length > 0 ? t("At a height") : t("Sections")],
];

function Zoom() {
    return (
        <div class="zoom" role="group" aria-label={t("Zoom")}>
            <Button words="−" aria-label={t("Zoom out")} onClick={() => zoom(0.8)} />
            <Button words="+" aria-label={t("Zoom in")} onClick={() => zoom(1.25)} />
            <Button words={t("Fit")} onClick={fit} />
        </div>
    );
}

/** All tools, or those of the tab; also what is shown besides, to end it. */
function Bar({ film }: { film: Film }) {
    const { view, forces, trails, line, area, tab, more } = plan.value;
    if (!more && view === "2d" && !forces && !trails && !line && !area) {
        return tab === "room" || tab === "crowd" || tab === "motion" ? (
            <div class="controls bar">
                <Tools />
            </div>
        ) : null;
    }
    return (
        <div class="controls bar">
            <Choice label={t("View")} value={view} choices={views(film)} onChange={(next) => change({ view: next })} />
            {view !== "3d" && (
                <>
                    <Tools />
                    {heightOf(film) === null && <Check label={t("Forces")} value={forces} onChange={(on) => change({ forces: on })} />}
                    <Check label={t("Trails")} value={trails} onChange={(on) => change({ trails: on })} />
                    <MeasureButtons />
                </>
            )}
        </div>
    );
}
