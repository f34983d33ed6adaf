// The legend of the colours, and what squeeze is.

import { useId } from "preact/hooks";
import { type Kind, NAMES } from "./byplace";
import { colourOf, isForce, isKnown, kindShade, meanWords, QUANTILE, type Scale, scaleOf, THINGS } from "./colour";
import type { Film } from "./film";
import { local, type Plain, t } from "./language";
import { beat } from "./layout";
import { KindName } from "./mix";
import { Check, Choice, length, NumberField } from "./parts";
import { type Colour, change, type Plan, plan } from "./plan";

const COLOURED: [Colour, string][] = [
    ["speed", t("Speed")],
    ["squeeze", t("Squeeze")],
    ["contacts", t("Contacts")],
    ["kind", t("Kind")],
    ["chest", t("Load on the chest")],
    ["compression", t("Chest, front–back")],
    ["level", t("Squeeze by level")],
];
const MAPS: [Plan["map"], string][] = [["none", t("none")], ...(Object.entries(NAMES) as [Kind, Plain][]).map(([kind, name]): [Kind, string] => [kind, t(name)])];
const MEANS: [string, string][] = [
    ["0.1", `${local(0.1)} s`],
    ["1", "1 s"],
];

/** A number and its unit; a large one is rounded. */
export function shown(value: number, unit: string) {
    return `${local(Number(value.toPrecision(3)))}${unit && ` ${unit}`}`;
}

/** What the colours mean. Their upper end follows the run, until it is fixed. */
export function Legend({ film }: { film: Film }) {
    if (film.playing.value) beat.value;
    else film.computed.value;
    const { most, smooth, map, view, more: all } = plan.value;
    const colour = colourOf(film, plan.value.colour);
    const choices = COLOURED.filter(([key]) => isKnown(film, key));
    const scale = scaleOf(film, colour);
    const fixed = most[colour] !== null;
    const fix = (value: number | null) => change({ most: { ...most, [colour]: value } });
    const more = scale.largest > scale.high;
    return (
        <div class="legend">
            <Choice label={t("Colour")} value={colour} choices={choices} onChange={(next) => change({ colour: next })} />
            {view !== "3d" && (all || map !== "none") && <Choice label={t("Map")} value={map} choices={MAPS} onChange={(next) => change({ map: next })} />}
            {(all || smooth !== 0.1) && (isForce(colour) || map === "mean" || map === "greatest") && <Choice label={t("mean of")} value={String(smooth)} choices={MEANS} onChange={(next) => change({ smooth: Number(next) })} />}
            {scale.kinds ? <Kinds kinds={scale.kinds} /> : <Numeric scale={scale} more={more} />}
            <Things film={film} />
            {colour === "level" && view === "3d" && (
                <span>
                    <span class="swatch" style={{ background: kindShade(-1).fill }} /> {t("in no level")}
                </span>
            )}
            {/* Opened, it lies over the picture and moves nothing. */}
            {!scale.kinds && <details class="about">
                <summary>{t("About this scale")}</summary>
                <div>
                    <p>
                        {fixed ? t("You have fixed this scale.") : t("The scale ends at the {quantile} % quantile of all values that are not 0, of people and steps so far.", { quantile: 100 * QUANTILE })}{" "}
                        {t("The greatest value so far is {value}.", { value: shown(scale.largest, scale.unit) })}
                    </p>
                    <Check label={t("Fix this scale")} value={fixed} onChange={(on) => fix(on ? scale.high : null)} />
                    {fixed && <NumberField label={t("Upper end")} unit={scale.unit} value={scale.high} min={1e-3} max={1e7} step={1e-3} onChange={fix} />}
                    {colour === "squeeze" ? <Squeeze film={film} /> : isForce(colour) && <Parts film={film} colour={colour} />}
                </div>
            </details>}
        </div>
    );
}

/** From what to how much. */
function Numeric({ scale, more }: { scale: Scale; more: boolean }) {
    return (
        <span class="scale">
            {scale.low > 0 ? t("up to {value}", { value: shown(scale.low, scale.unit) }) : 0}
            <Bar scale={scale} />
            {shown(scale.high, scale.unit)}
            {more && ` ${t("and more")}`}
        </span>
    );
}

/** Kinds of people, with the colour and the number of each. */
function Kinds({ kinds }: { kinds: NonNullable<Scale["kinds"]> }) {
    return (
        <ul class="kinds">
            {kinds.map(({ name, count, shade }) => (
                <li key={name}>
                    <span class="swatch" style={{ background: shade.fill }} />
                    <KindName kind={name} /> <span class="unit">({count})</span>
                </li>
            ))}
        </ul>
    );
}

/** What things look like, where there are some. */
function Things({ film: { scene } }: { film: Film }) {
    const there = (["frame", "luggage"] as const).filter((material) => scene.agents.some(({ things }) => things?.includes(material)));
    if (there.length === 0) return null;
    return (
        <ul class="kinds">
            {there.map((material) => (
                <li key={material}>
                    <span class="swatch" style={{ background: THINGS[material] }} />
                    {material === "frame" ? t("Frames") : t("Luggage")}
                </li>
            ))}
        </ul>
    );
}

export function Bar({ scale: { ramp } }: { scale: Scale }) {
    const id = useId();
    return (
        <svg class="ramp" viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true">
            <linearGradient id={id}>
                {ramp.map((shade, k) => (
                    <stop key={shade} offset={k / (ramp.length - 1)} stop-color={shade} />
                ))}
            </linearGradient>
            <rect width="100" height="10" fill={`url(#${id})`} />
        </svg>
    );
}

/** What the load on parts of people is. */
function Parts({ film, colour }: { film: Film; colour: Colour }) {
    const mean = meanWords(film);
    const ends = film.scene.levels.map((level) => level.map((end) => length(end, plan.value.unit)).join("–")).join(", ");
    if (colour === "level") {
        return <p>{t("The squeeze of a level is the sum of the normal forces on a person's disks there, at communication points ({mean}). Levels: {ends}. In 3D each level of a body has its own colour, and grey is in none. From above people have the colour of their greatest one, at a height that of the level there.", { mean, ends })}</p>;
    }
    return (
        <>
            {colour === "chest" && <p>{t("The load on the chest is the sum of the normal forces on it, of people and walls, from all sides ({mean}).", { mean })}</p>}
            {colour === "compression" && <p>{t("Opposing forces press the chest together along the gaze: two that press with F each count as F ({mean}). A chest that is pulled apart has the first colour.", { mean })}</p>}
            <p>{ends ? t("Of people in levels, the chest has the forces of the level that holds it. Who has no disks there, as in a wheelchair, has 0.") : t("In the plan the chest is the whole body: it has all forces.")}</p>
        </>
    );
}

/** What squeeze is and is not. */
export function Squeeze({ film }: { film: Film }) {
    return (
        <>
            <p>{t("Squeeze is the sum of the normal forces on a person, from all sides; the colours and the chart of the greatest squeeze show its {mean}. Disks with stiff springs touch here, so short impacts have higher peaks than soft bodies would.", { mean: meanWords(film) })}</p>
            <p>{t("Measured of people, and none of it a squeeze: men tolerated 623 N against a flat bar 100 mm wide (Evans and Hayden 1971, as reported by Lee and Hughes 2006); 1112 N for 4 to 6 minutes are estimated to be fatal (Hopkins et al. 1993, ibid.).")}</p>
            <p>{t("It is no pressure on the chest: a force that enters at one side leaves at the other, and both are counted. What a person bears depends on where, how long and how evenly the force acts, and differs from person to person. No number here says who is hurt.")}</p>
        </>
    );
}
