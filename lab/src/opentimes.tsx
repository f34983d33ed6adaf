// When an exit or a door is open, as fields.

import { MOST } from "./forms";
import { inner, t } from "./language";
import { Button, Check, NumberField } from "./parts";
import type { OpenTime } from "./protocol";
import { film } from "./session";

/** How long it is closed, or open, if a time is added, in s. */
const OPEN = 60;
/** Later than any run, in s: what is open up to it stays open. */
const LATEST = 1e5;

/** In words; empty if it is always open. */
export function openWords(times?: OpenTime[] | null): string {
    return (times ?? []).map(([from, to]) => (to < LATEST ? t("open from {from} to {to} s", { from, to }) : t("open from {from} s on", { from }))).join(", ");
}

/** One time more, up to the end. What was open up to there closes before. */
function further(times: OpenTime[]): OpenTime[] {
    const [from, to] = times.at(-1)!;
    const closes = to < LATEST ? to : from + OPEN;
    return [...times.slice(0, -1), [from, closes], [closes + OPEN, LATEST]];
}

/** Of what is open, by its name; without times it always is. */
export function OpenTimes({ name, times: given, onChange }: { name: string; times: OpenTime[] | null; onChange(times: OpenTime[] | null): void }) {
    const times = given ?? [];
    const step = film.value?.scene.step ?? 0.01;
    const put = (next: OpenTime[]) => onChange(next.length > 0 ? next : null);
    return (
        <>
            <Check label={[<span class="hidden">{name}, </span>, t("open at times only")]} value={given !== null} onChange={(on) => put(on ? [[0, LATEST]] : [])} />
            {times.map(([from, to], j) => {
                const opening = `${name}, ${t("opening {n}", { n: j + 1 })}`;
                const turn = (part: OpenTime) => put(times.map((old, i) => (i === j ? part : old)));
                return (
                    <div class="row" key={j}>
                        <NumberField of={opening} label={t("from")} unit="s" value={from} min={j > 0 ? times[j - 1]![1] + step : 0} max={to - step} step={5} onChange={(next) => turn([next, to])} />
                        <NumberField of={opening} label={t("to")} unit="s" value={to} min={from + step} max={j + 1 < times.length ? times[j + 1]![0] - step : LATEST} most={j + 1 < times.length ? undefined : t("the end")} step={5} onChange={(next) => turn([from, next])} />
                        <Button words="×" aria-label={t("Delete {name}", { name: inner(opening) })} onClick={() => put(times.filter((_, i) => i !== j))} />
                    </div>
                );
            })}
            {given && times.length < MOST.times && further(times).at(-1)![0] < LATEST && (
                <div class="buttons">
                    <Button words={t("Add a time")} onClick={() => put(further(times))} />
                </div>
            )}
        </>
    );
}
