// What the colours of a map mean, of which time it is, and its files.

import { useEffect } from "preact/hooks";
import { type ByPlace, type Kind, NAMES, pointed } from "./byplace";
import { valueAt } from "./canvas";
import { origin, saveTable } from "./csv";
import type { Film } from "./film";
import { about, t } from "./language";
import { beat, canvas, presents } from "./layout";
import { Bar, shown } from "./legend";
import { Button, Check, NumberField, save } from "./parts";
import { composeMap, png } from "./picture";
import { change, plan, title } from "./plan";
import { COLUMNS, isThere } from "./protocol";
import { attempt, selected } from "./session";
import { viewed } from "./storage";

interface MapProps {
    film: Film;
    places: ByPlace;
    kind: Kind;
}

export function MapLegend({ film, places, kind }: MapProps) {
    if (film.playing.value) beat.value;
    else film.computed.value;
    const { span } = plan.value;
    useEffect(() => void places.follow(span));
    const there = places.filled.value !== null;
    const scale = places.scale(kind);
    return (
        <section class="legend" aria-label={t("Map")}>
            <span class="scale">
                {about(t(NAMES[kind]), 0)}
                <Bar scale={scale} />
                {shown(scale.high, scale.unit)}
            </span>
            {!viewed && !presents.value && <Controls film={film} places={places} kind={kind} />}
            <p class="note" aria-busy={places.busy.value}>
                {`${places.words()}. ${there ? t("Greatest value: {largest}; {cells}", { largest: shown(scale.largest, scale.unit), cells: places.cells() }) : ""}`}
            </p>
            {/* The picture shows it at the mouse. */}
            <p class="hidden">{pointed.value && valueAt(pointed.value)}</p>
            <AtSelected film={film} />
            {places.refused.value && <p role="alert">{places.refused.value}</p>}
        </section>
    );
}

/** Its value where the selected person is: so it can be read without a mouse. */
function AtSelected({ film }: { film: Film }) {
    const frame = film.frames.frame(film.shown.value);
    const agent = selected.value;
    if (agent === null || !isThere(frame, agent)) return null;
    const value = valueAt([frame[COLUMNS * agent]!, frame[COLUMNS * agent + 1]!]);
    return (
        value && (
            <p class="note">{t("At the selected person: {value}", { value })}</p>
        )
    );
}

/** Of which time it is, and its files. */
function Controls({ film, places, kind }: MapProps) {
    const [from, to] = plan.value.span;
    const computed = () => Number(((film.computed.peek() - 1) * film.scene.step).toPrecision(9));
    const there = places.filled.value !== null;
    const of = kind === "density" ? "" : `-means-of-${plan.value.smooth}s`;
    const time = (k: number) => Number((k * film.scene.step).toPrecision(9));
    const span = () => {
        const { first, last } = places.filled.value!;
        return [time(first), time(last)] as const;
    };
    const name = () => `${title.value}-${NAMES[kind].toLowerCase().replace(" ", "-")}${of}-${span().join("-")}s`;
    const csv = () => {
        const { frames, stride, grid } = places.filled.value!;
        const squeeze = kind === "density" ? {} : { squeeze_is_a_mean_over_s: plan.value.smooth };
        saveTable(`${name()}.csv`, places.csv(), { ...origin(film, ...span()), frames, one_frame_of: stride, cell_m: grid.cell, ...squeeze });
    };
    const picture = async () => void save(`${name()}.png`, await png((onto) => composeMap(onto, canvas.value!, places, kind)));
    return (
        <>
            <NumberField label={t("Map from")} short={t("from")} unit="s" value={from ?? 0} min={0} max={to ?? 1e5} step={0.5} onChange={(next) => change({ span: [next || null, to] })} />
            {to !== null && <NumberField label={t("Map to")} short={t("to")} unit="s" value={to} min={from ?? 0} max={1e5} step={0.5} onChange={(next) => change({ span: [from, next] })} />}
            <Check label={t("to what is computed")} value={to === null} onChange={(on) => change({ span: [from, on ? null : Math.max(computed(), from ?? 0)] })} />
            <Button words={t("Map (CSV)")} disabled={!there || places.busy.value} onClick={csv} />
            <Button words={t("Map (PNG)")} disabled={!there || places.busy.value} onClick={() => void attempt(picture)} />
        </>
    );
}
