// What plays a run, and the legend of its colours.

import { COLOURS, largest, meanWords, scaleOf } from "./colour";
import type { Film } from "./film";
import { beat } from "./layout";
import { Check, Choice, digits, NumberField } from "./parts";
import { type Colour, change, plan } from "./plan";

const PACES = [0.1, 0.25, 0.5, 1, 2, 4].map((pace) => [String(pace), `${pace} ×`] as const);
const COLOURED: [Colour, string][] = [
    ["speed", "Speed"],
    ["squeeze", "Squeeze"],
    ["contacts", "Contacts"],
];

export function Transport({ film }: { film: Film }) {
    const playing = film.playing.value;
    return (
        <div class="controls" role="group" aria-label="Run">
            <button type="button" class="main play" onClick={() => (film.playing.value = !playing)}>
                {playing ? "Pause" : "Play"}
            </button>
            <button type="button" onClick={() => film.show(0)}>
                To the start
            </button>
            <button type="button" onClick={() => film.show(Math.ceil(film.place.value) - 1)}>
                Step back
            </button>
            <button type="button" onClick={() => void film.next()}>
                Step
            </button>
            <Clock film={film} />
            <Choice label="Pace" value={String(plan.value.pace)} choices={PACES} onChange={(pace) => change({ pace: Number(pace) })} />
        </div>
    );
}

function Clock({ film }: { film: Film }) {
    const { step } = film.scene;
    // The page is laid out again when a text changes, so not for each picture.
    const playing = film.playing.value;
    const k = playing ? (beat.value, film.shown.peek()) : film.shown.value;
    const computed = playing ? film.computed.peek() : film.computed.value;
    const decimals = Math.max(2, Math.min(6, Math.ceil(-Math.log10(step))));
    const time = `${(k * step).toFixed(decimals)} s`;
    return (
        <label class="scrub">
            <span>
                Time <span class="time">{time}</span>
            </span>
            <input
                type="range"
                aria-valuetext={time}
                min={0}
                max={computed - 1}
                value={k}
                onInput={(event) => film.show(event.currentTarget.valueAsNumber)}
            />
        </label>
    );
}

/** How many have left in the frame that is shown. */
export function Leaving({ film }: { film: Film }) {
    const { leaving, step } = film.scene;
    if (leaving === 0) return null;
    const k = film.playing.value ? (beat.value, film.shown.peek()) : film.shown.value;
    const time = (frame: number) => `${(frame * step).toFixed(2)} s`;
    const emptied = film.emptied.value;
    const all = emptied !== null && k >= emptied;
    return (
        <p class="note">
            {film.frames.curve("left")[k]} of {leaving} have left, at {time(k)}. {/* Only the end is told to those who do not see it. */}
            <strong role="status">{all && `All ${leaving} have left after ${time(emptied)}.`}</strong>
        </p>
    );
}

/** What the colours mean. Their upper end follows the run, until it is fixed. */
export function Legend({ film }: { film: Film }) {
    if (film.playing.value) beat.value;
    else film.computed.value;
    const { colour, most } = plan.value;
    const scale = scaleOf(film, colour);
    const fixed = most[colour] !== null;
    const clipped = fixed && largest(film, colour) > scale.most;
    const fix = (value: number | null) => change({ most: { ...most, [colour]: value } });
    const number = (value: number) => `${Number(digits(value, 3)).toLocaleString("en")}${scale.unit && ` ${scale.unit}`}`;
    return (
        <div class="legend">
            <Choice label="Colour" value={colour} choices={COLOURED} onChange={(next) => change({ colour: next })} />
            {colour === "squeeze" && <span class="note">{meanWords(film)}</span>}
            <span class="scale">
                0
                <svg class="ramp" viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true">
                    <linearGradient id="ramp">
                        {COLOURS.map((shade, k) => (
                            <stop key={shade} offset={k / (COLOURS.length - 1)} stop-color={shade} />
                        ))}
                    </linearGradient>
                    <rect width="100" height="10" fill="url(#ramp)" />
                </svg>
                {number(scale.most)}
                {clipped && " and more"}
            </span>
            <Check label="Fix this scale" value={fixed} onChange={(on) => fix(on ? scale.most : null)} />
            {fixed && (
                <NumberField label="Upper end" unit={scale.unit} value={scale.most} min={1e-3} max={1e7} step={scale.least} onChange={fix} />
            )}
            {clipped && <span class="note">The largest value so far is {number(largest(film, colour))}.</span>}
        </div>
    );
}
