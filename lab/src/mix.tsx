// Kinds of people of a crowd: shares that stay at 100 % together, with a picture of each from above.

import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Stopped } from "./client";
import { thingsOf } from "./draw";
import { isOwn, KINDS, kindWords } from "./kindwords";
import { about, local, t } from "./language";
import { brief, Check, Field, Range } from "./parts";
import { plan } from "./plan";
import type { Disk, KindShown } from "./protocol";
import { client } from "./session";

export type Mix = Record<string, number>;

/** What a mix begins with. */
const FIRST: Mix = { adult: 70, child: 15, elderly: 10, wheelchair: 5 };

/** What the lab says of kinds; empty until it has. */
const kinds = signal<KindShown[]>([]);

/** Asks for them. Who stops something else must not lose them. */
async function learn() {
    try {
        kinds.value = (await client.ask<KindShown[]>({ ask: "kinds" })).value;
    } catch (error) {
        if (error instanceof Stopped && client.works) await learn();
    }
}

/** The name of a kind; that of somebody's own stays as it is. */
export function KindName({ kind }: { kind: string }) {
    return <>{isOwn(kind) ? brief(kind) : kindWords(kind)}</>;
}

/** Another share of a kind: the others keep their proportions, and all are whole and 100 together. */
export function shared(mix: Mix, kind: string, share: number): Mix {
    const others = Object.keys(mix).filter((name) => name !== kind && mix[name]! > 0);
    const sum = others.reduce((sum, name) => sum + mix[name]!, 0);
    const rest = 100 - share;
    // Nobody else is there: then adults are, or children beside adults.
    if (sum === 0) return rest === 0 ? { [kind]: 100 } : { [kind]: share, [kind === "adult" ? "child" : "adult"]: rest };
    const exact = others.map((name) => (mix[name]! * rest) / sum);
    const whole = exact.map(Math.floor);
    let left = rest - whole.reduce((sum, part) => sum + part, 0);
    // The largest remainders get what is left.
    const order = exact.map((part, k) => [part - whole[k]!, k] as const).sort(([one], [other]) => other - one);
    for (const [, k] of order) if (left-- > 0) whole[k]! += 1;
    return Object.fromEntries([...others.map((name, k) => [name, whole[k]!] as const), [kind, share] as const].filter(([, part]) => part > 0));
}

/** Shares as they are shown: of 100. What a link says may have any sum. */
export function percent(mix: Mix): Mix {
    const sum = Object.values(mix).reduce((sum, share) => sum + share, 0);
    const known = Object.values(mix).every(Number.isInteger) && sum === 100;
    return known || !(sum > 0) ? mix : shared({ ...mix, "": 0 }, "", 0);
}

/** Kinds and their shares in words; the name of somebody's own is in quotes. */
export function mixWords(mix: Mix): string[] {
    return Object.entries(percent(mix)).map(([kind, share]) => about(isOwn(kind) ? `"${brief(kind)}"` : kindWords(kind), `${local(share)} %`));
}

export function MixForm({ mix, onChange }: { mix: Mix; onChange(mix: Mix): void }) {
    const on = Object.keys(mix).length > 0;
    useEffect(() => {
        if (on && kinds.value.length === 0) void learn();
    }, [on]);
    return (
        <fieldset class="fields mix">
            <legend>
                {t("Kinds of people")} <span class="unit">[%]</span>
            </legend>
            <Check label={t("Children, elderly, luggage, wheelchairs")} value={on} onChange={(wanted) => onChange(wanted ? FIRST : {})} />
            {on && <Shares mix={percent(mix)} onChange={onChange} />}
        </fieldset>
    );
}

function Shares({ mix, onChange }: { mix: Mix; onChange(mix: Mix): void }) {
    const names = [...KINDS, ...Object.keys(mix).filter((kind) => !KINDS.includes(kind))];
    return (
        <>
            {names.map((kind) => (
                // Another change may come before this is drawn again.
                <Share key={kind} kind={kind} share={mix[kind] ?? 0} onChange={(share) => onChange(shared(percent(plan.peek().crowd.mix), kind, share))} />
            ))}
            <details>
                <summary>{t("Sources of these kinds")}</summary>
                <ul class="notes">
                    {kinds.value.map(({ kind, sources }) => (
                        <li key={kind}>
                            <KindName kind={kind} />: {sources.join("; ")}
                        </li>
                    ))}
                </ul>
            </details>
            <p class="note">{t("Shares stay at 100 % together. Each person is drawn by chance: of 80 people with 10 % of a kind, 8 ± 3 have it. The numbers of kinds have sources or are assumptions (docs/people.md).")}</p>
        </>
    );
}

function Share({ kind, share, onChange }: { kind: string; share: number; onChange(share: number): void }) {
    const found = kinds.value.find((one) => one.kind === kind);
    const name = kindWords(kind);
    const set = (value: number) => {
        if (Number.isFinite(value)) onChange(Math.max(0, Math.min(100, Math.round(value))));
    };
    return (
        <div class="share">
            <FromAbove kind={found} />
            <span class="name">
                <KindName kind={kind} />
            </span>
            <Range min={0} max={100} step={1} value={share} aria-label={t("{name}, share", { name })} onChange={set} />
            <Field type="number" min={0} max={100} step={1} value={share} aria-label={`${name}, %`} onChange={(event) => set(event.currentTarget.valueAsNumber)} />
        </div>
    );
}

/** Somebody of a kind, who looks up. */
function FromAbove({ kind }: { kind: KindShown | undefined }) {
    const size = 0.75;
    if (!kind) return <svg class="from-above" viewBox="-1 -1 2 2" aria-hidden="true" />;
    const circles = (disks: Disk[], grown: number) => disks.map(([x, y, radius], k) => <circle key={k} cx={-y} cy={-x} r={radius + grown} />);
    const bodies = [...kind.disks.filter((_, k) => kind.things[k] === null), ...(kind.seated ?? [])];
    const groups = [...(thingsOf(kind) ?? []).map(({ disks, fill }) => ({ disks, fill })), { disks: bodies, fill: "var(--main)" }];
    return (
        <svg class="from-above" viewBox={`${-size} ${-size} ${2 * size} ${2 * size}`} aria-hidden="true">
            {groups.map(({ disks, fill }, k) => (
                <g key={k}>
                    <g fill="var(--ink)">{circles(disks, 0.015)}</g>
                    <g fill={fill}>{circles(disks, 0)}</g>
                </g>
            ))}
        </svg>
    );
}
