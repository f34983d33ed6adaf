// The run: the picture, and what plays it.

import { signal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { COLOURS, fitting, Painter, SCALES, type View } from "./draw";
import type { Film } from "./film";
import { Choice, digits, Facts } from "./parts";
import { type Colour, change, plan } from "./plan";
import { COLUMNS } from "./protocol";

const selected = signal<number | null>(null);

const PACES = [0.1, 0.25, 0.5, 1, 2, 4].map((pace) => [String(pace), `${pace} ×`] as const);

export function Stage({ film }: { film: Film }) {
    const canvas = useRef<HTMLCanvasElement>(null);
    const view = useRef<View>({ scale: 1, x: 0, y: 0 });
    const painter = useRef<Painter | null>(null);
    if (painter.current?.scene !== film.scene) painter.current = new Painter(film.scene);

    const paint = () => {
        const on = canvas.current;
        if (!on) return;
        const scale = SCALES[plan.value.colour];
        painter.current!.paint(on, film.frame(film.shown.value), view.current, scale, selected.value);
    };
    useEffect(() => {
        selected.value = null;
        const on = canvas.current!;
        const observer = new ResizeObserver(() => {
            [on.width, on.height] = [on.clientWidth * devicePixelRatio, on.clientHeight * devicePixelRatio];
            view.current = fitting(film.scene, film.frame(0), on.width, on.height);
            paint();
        });
        observer.observe(on);
        return () => observer.disconnect();
    }, [film]);
    useSignalEffect(paint);
    useEffect(() => {
        let last = performance.now();
        let handle = requestAnimationFrame(function next(now) {
            // The time of a picture may be before that of its request.
            if (film.playing.value) film.tick(Math.max(0, now - last) / 1000, plan.value.pace);
            last = now;
            handle = requestAnimationFrame(next);
        });
        return () => cancelAnimationFrame(handle);
    }, [film]);

    const { scene } = film;
    const time = film.shown.value * scene.step;
    const decimals = Math.max(2, Math.min(6, Math.ceil(-Math.log10(scene.step))));
    const scale = SCALES[plan.value.colour];
    return (
        <section class="stage" aria-label="Run">
            <canvas
                ref={canvas}
                role="img"
                aria-label={`${scene.agents.length} people from above, ${time.toFixed(2)} s after the start`}
                onClick={(event) => {
                    const on = canvas.current!;
                    const [x, y] = [event.offsetX * devicePixelRatio, event.offsetY * devicePixelRatio];
                    selected.value = painter.current!.at(on, film.frame(film.shown.value), view.current, x, y);
                }}
            />
            <div class="legend">
                <span>{scale.label}: 0</span>
                <span class="ramp" aria-hidden="true">
                    {COLOURS.map((colour, k) => (
                        <svg key={colour} viewBox="0 0 1 1" preserveAspectRatio="none">
                            <rect width="1" height="1" fill={COLOURS[k]} />
                        </svg>
                    ))}
                </span>
                <span>
                    {scale.most} {scale.unit} and more
                </span>
            </div>
            <div class="controls">
                <button type="button" class="main" onClick={() => (film.playing.value = !film.playing.value)}>
                    {film.playing.value ? "Pause" : "Play"}
                </button>
                <button type="button" onClick={() => film.show(0)}>
                    To the start
                </button>
                <button type="button" onClick={() => film.show(film.shown.value - 1)}>
                    Step back
                </button>
                <button type="button" onClick={() => void film.next()}>
                    Step
                </button>
                <label class="scrub">
                    <span>
                        Time <span class="time">{time.toFixed(decimals)} s</span>
                    </span>
                    <input type="range" aria-valuetext={`${time.toFixed(decimals)} s`} min={0} max={film.computed.value - 1} value={film.shown.value} onInput={(event) => film.show(event.currentTarget.valueAsNumber)} />
                </label>
                <Choice label="Pace" value={String(plan.value.pace)} choices={PACES} onChange={(pace) => change({ pace: Number(pace) })} />
                <Choice
                    label="Colour"
                    value={plan.value.colour}
                    choices={(Object.keys(SCALES) as Colour[]).map((key) => [key, key[0]!.toUpperCase() + key.slice(1)] as const)}
                    onChange={(colour) => change({ colour })}
                />
            </div>
            {film.failed.value && <p role="alert">{film.failed.value}</p>}
            <Numbers film={film} />
        </section>
    );
}

function Numbers({ film }: { film: Film }) {
    const { scene } = film;
    const advanced = film.advanced.value;
    const frame = film.frame(film.shown.value);
    const who = selected.value !== null && selected.value < scene.agents.length ? selected.value : null;
    const of = (column: number) => frame[COLUMNS * who! + column]!;
    const perStep = 1e9 * film.cost.value * (scene.mechanical_step / scene.step) / scene.agents.length;
    const rows: [string, string][] = [
        ["People", String(scene.agents.length)],
        ["Communication step", `${scene.step} s`],
        ["Mechanical step", `${scene.mechanical_step} s${scene.stable ? ` (stable up to ${digits(scene.stable, 2)} s)` : ""}`],
        ["Shown", film.playing.value ? `${film.pace.value.toFixed(2)} simulated seconds per second` : "paused"],
        ["Time to compute", advanced ? `${digits(perStep, 2)} ns per person and mechanical step` : "–"],
        ["Deepest overlap so far", advanced ? `${digits(1000 * advanced.overlap, 2)} mm` : "–"],
    ];
    if (who !== null) {
        rows.push(
            [`Person ${scene.agents[who]!.id}`, `${digits(scene.agents[who]!.mass, 3)} kg at (${of(0).toFixed(2)}, ${of(1).toFixed(2)}) m`],
            ["Speed", `${of(3).toFixed(2)} m/s`],
            ["Squeeze", `${of(4).toFixed(0)} N, ${of(5)} contacts`],
        );
    }
    return <Facts rows={rows} />;
}
