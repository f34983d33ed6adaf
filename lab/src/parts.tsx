// Small parts of forms.

import { signal, useSignal, useSignalEffect } from "@preact/signals";
import { type ComponentChildren, type ComponentProps, type ComponentType, h, type Ref, type TargetedEvent } from "preact";
import { useEffect, useId, useState } from "preact/hooks";
import { inner, local, t } from "./language";
import { link, plan } from "./plan";
import type { Point } from "./protocol";

interface NumberProps {
    /** What it is a number of, if that is seen elsewhere. */
    of?: string;
    label: string;
    /** What is seen, if the whole label is too long for it. */
    short?: string;
    unit?: string;
    /** What it is. */
    title?: string;
    value: number;
    min: number;
    max: number;
    /** Instead of the greatest number, which an empty field stands for. */
    most?: string;
    step: number;
    onChange(value: number): void;
}

/** Whether it is a key of Undo or Redo. */
export const isUndo = ({ ctrlKey, metaKey, key }: KeyboardEvent) => (ctrlKey || metaKey) && ["z", "Z", "y"].includes(key);

/** A field that keeps its text while it has the focus and nothing was taken: its value may change meanwhile, as that of a run that
 * plays. While something is typed, keys of Undo are its own (page.tsx). */
export function Field({ onChange, ...props }: ComponentProps<"input">) {
    const [draft, setDraft] = useState<{ text: string; typed: boolean } | null>(null);
    const keep = (typed: boolean) => (event: { currentTarget: HTMLInputElement }) => setDraft({ text: event.currentTarget.value, typed });
    const end = () => setDraft(null);
    const own = {
        onFocus: keep(false),
        onInput: keep(true),
        onBlur: end,
        onKeyDown: (event: KeyboardEvent) => isUndo(event) && !draft?.typed && end(),
        onChange: (event: TargetedEvent<HTMLInputElement>) => (onChange?.(event), end()),
    };
    return <input {...props} {...own} value={draft?.text ?? props.value} data-typed={draft?.typed} />;
}

/** A number with its unit. What is out of range is not taken; it stays there, with the reason. */
export function NumberField({ of, label, short, unit, title, value, min, max, most, step, onChange }: NumberProps) {
    // What was typed, as long as the value is not changed in another way.
    const [typed, setTyped] = useState<{ text: string; instead: number } | null>(null);
    const wrong = typed?.instead === value;
    const id = useId();
    const range = { name: of ? `${of}, ${label}` : label, min, max: unit ? `${local(max)} ${unit}` : max };
    return (
        <div class="field">
            <label for={id} title={title}>
                {of && <span class="hidden">{of}, </span>}
                {short ?? label}
                {unit && <span class="unit"> [{unit}]</span>}
            </label>
            <Field
                id={id}
                type="number"
                aria-label={short && label}
                value={wrong ? typed!.text : most && value === max ? "" : value}
                placeholder={most}
                min={min}
                max={max}
                step={step}
                aria-invalid={wrong}
                aria-describedby={wrong ? `${id}-why` : undefined}
                onChange={(event) => {
                    const { value: text, valueAsNumber } = event.currentTarget;
                    const number = most && text === "" ? max : valueAsNumber;
                    // Between two steps of the arrows is fine, but people are whole.
                    const fits = number >= min && number <= max && (step !== 1 || Number.isInteger(number));
                    setTyped(fits ? null : { text, instead: value });
                    if (fits) onChange(number);
                }}
            />
            {wrong && (
                <p id={`${id}-why`} class="note" role="alert">
                    {step === 1 ? t("{name}: a whole number, {min} to {max}", range) : t("{name}: {min} to {max}", range)}
                </p>
            )}
        </div>
    );
}

type LengthProps = Omit<NumberProps, "unit" | "step">;

/** A length in m, shown in the unit that the user has chosen. */
export function LengthField({ value, min, max, onChange, ...words }: LengthProps) {
    const { unit } = plan.value;
    const by = unit === "cm" ? 100 : 1;
    const clean = (length: number) => Number((length * by).toFixed(unit === "cm" ? 2 : 4));
    return (
        <NumberField
            {...words}
            unit={unit}
            value={clean(value)}
            min={clean(min)}
            max={clean(max)}
            // Whole centimetres need not be whole.
            step={unit === "cm" ? 5 : 0.05}
            onChange={(length) => onChange(length / by)}
        />
    );
}

/** In m: the largest coordinate of what is drawn. */
export const FAR = 1000;

interface PointProps {
    name: string;
    at: Point;
    far?: number;
    onChange(at: Point): void;
}

export function PointFields({ name, at: [x, y], far = FAR, onChange }: PointProps) {
    return (
        <>
            <LengthField of={name} label="x" value={x} min={-far} max={far} onChange={(to) => onChange([to, y])} />
            <LengthField of={name} label="y" value={y} min={-far} max={far} onChange={(to) => onChange([x, to])} />
        </>
    );
}

/** One point of several, with its number; without `onDelete` it stays. */
export function PointRow({ k, children, onDelete, ...point }: PointProps & { k: number; children?: ComponentChildren; onDelete?(): void }) {
    return (
        <div class="row">
            <span class="which">{k + 1}</span>
            <PointFields {...point} />
            {children}
            {onDelete && <Button words="×" aria-label={t("Delete {name}", { name: inner(point.name) })} onClick={onDelete} />}
        </div>
    );
}

/** A length in m as it is read. */
export function length(value: number, unit: "m" | "cm") {
    return unit === "cm" ? `${local(Number((100 * value).toFixed(1)))} cm` : `${local(Number(value.toFixed(3)))} m`;
}

export function Check({ label, value, onChange }: { label: ComponentChildren; value: boolean; onChange(value: boolean): void }) {
    return (
        <label class="check">
            <input type="checkbox" checked={value} onChange={(event) => onChange(event.currentTarget.checked)} />
            {label}
        </label>
    );
}

type RangeProps = Record<"value" | "min" | "max", number> & { step?: number; "aria-label"?: string; "aria-valuetext"?: string; onSlide?(value: number): void; onChange?(value: number): void };

/** A slider: `onSlide` hears it move, `onChange` where it is let go. */
export function Range({ onSlide, onChange, ...given }: RangeProps) {
    return <input type="range" {...given} onInput={(event) => onSlide?.(event.currentTarget.valueAsNumber)} onChange={(event) => onChange?.(event.currentTarget.valueAsNumber)} />;
}

/** A button with words, or a sign, on it. */
export function Button({ words, ...given }: { words: string | number } & ComponentProps<"button">) {
    return (
        <button type="button" {...given}>
            {words}
        </button>
    );
}

interface ChoiceProps<T extends string> {
    label: ComponentChildren;
    /** Its label is only heard. */
    hidden?: boolean;
    value: T;
    choices: readonly (readonly [T, string, ...unknown[]])[];
    onChange(value: T): void;
}

export function Choice<T extends string>({ label, hidden, value, choices, onChange }: ChoiceProps<T>) {
    return (
        <label class="field">
            <span class={hidden ? "hidden" : undefined}>{label}</span>
            <select value={value} onChange={(event) => onChange(event.currentTarget.value as T)}>
                {choices.map(([key, words]) => (
                    <option key={key} value={key}>
                        {words}
                    </option>
                ))}
            </select>
        </label>
    );
}

export function Head({ of }: { of: readonly string[] }) {
    return (
        <thead>
            <tr>
                {of.map((words) => (
                    <th key={words} scope="col">
                        {words}
                    </th>
                ))}
            </tr>
        </thead>
    );
}

/** What names mean: for those who have no mouse that shows titles. */
export function Meanings({ of }: { of: [string, string][] }) {
    if (of.length === 0 || !plan.value.more) return null;
    return (
        <details>
            <summary>{t("What these words mean")}</summary>
            <dl class="note">
                {of.map(([name, meaning]) => (
                    <>
                        <dt>{name}</dt>
                        <dd>{meaning}</dd>
                    </>
                ))}
            </dl>
        </details>
    );
}

/** Names and values, and what a name means. */
export function Facts({ rows }: { rows: [string, ComponentChildren, string?][] }) {
    return (
        <>
            <table class="facts">
                <tbody>
                    {rows.map(([name, value, meaning]) => (
                        <tr key={name}>
                            <th scope="row" title={meaning}>{name}</th>
                            <td>{value}</td>
                        </tr>
                    ))}
                </tbody>
            </table>
            <Meanings of={rows.flatMap(([name, _, meaning]): [string, string][] => (meaning ? [[name, meaning]] : []))} />
        </>
    );
}

/** A drawing on a button, which has its name in words. */
export function Icon({ path }: { path: string }) {
    return (
        <svg class="icon" viewBox="0 0 16 16" aria-hidden="true">
            <path d={path} />
        </svg>
    );
}

/** A part in three dimensions, whose file is loaded when it is first wanted. */
export function in3d<P extends object>(load: () => Promise<{ default: ComponentType<P> }>) {
    const found = signal<ComponentType<P> | null>(null);
    const missing = signal("");
    return function Part(props: P) {
        useEffect(() => {
            if (found.value) return;
            load().then(
                (file) => (found.value = file.default),
                ({ message }: Error) => (missing.value = t("3D could not be loaded: {message}", { message })),
            );
        }, []);
        if (found.value) return h(found.value, props);
        if (!missing.value) return <p role="status">{t("3D is loaded …")}</p>;
        return (
            <p role="alert">
                {missing.value} <Button words={t("Load the page again")} onClick={() => location.reload()} />
            </p>
        );
    };
}

interface SpaceProps {
    canvas: Ref<HTMLCanvasElement>;
    /** Why there is no picture; empty if there is one. */
    missing: string;
    label: string;
    children: ComponentChildren;
    onPointerDown?(event: PointerEvent): void;
    onClick?(event: MouseEvent): void;
}

/** A canvas in three dimensions, with what belongs to it below. */
export function SpaceCanvas({ canvas, missing, label, children, ...hands }: SpaceProps) {
    if (missing) return <p role="alert">{missing}</p>;
    return (
        <div class="space">
            <canvas ref={canvas} tabIndex={0} role="application" aria-label={label} {...hands} />
            {children}
        </div>
    );
}

/** A number with this many significant digits. */
export function digits(value: number, count: number) {
    if (value === 0) return "0";
    if (!Number.isFinite(value)) return String(value);
    const size = Math.floor(Math.log10(Math.abs(value)));
    return local(size < -4 || size > 8 ? value.toExponential(count - 1) : value.toFixed(Math.max(0, count - 1 - size)));
}

/** A name from outside, which may have any length. */
export function brief(name: string, most = 24) {
    return name.length > most ? `${name.slice(0, most)}…` : name;
}

/** A name from outside in a sentence: in quotes, unless it is a number. */
export function named(name: string) {
    return /^\d+$/.test(name) ? name : `"${brief(name)}"`;
}

/** Gives a file to the user. Returns its name: browsers would replace some letters themselves. */
export function save(called: string, content: BlobPart): string {
    const name = called.replace(/[\\/:*?"<>|]/g, "_");
    const url = URL.createObjectURL(new Blob([content]));
    const anchor = document.createElement("a");
    anchor.href = url;
    anchor.download = name;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(url), 60_000);
    return name;
}

/** A link to the scene on the stage. */
export function Link({ query, words, target }: { query: Parameters<typeof link>[0]; words: string; target?: string }) {
    const address = useSignal<string | undefined>(undefined);
    useSignalEffect(() => void link(query).then((to) => (address.value = to)));
    return <a href={address.value} target={target} rel="noopener">{words}</a>;
}

/** Puts a text into the clipboard. */
export async function copy(text: string) {
    if (!navigator.clipboard) throw new Error(t("This browser copies nothing from such a page; this was to be copied: {text}", { text }));
    await navigator.clipboard.writeText(text);
}

/** A text as the value of an attribute in HTML. */
export function attribute(text: string) {
    return text.replaceAll("&", "&amp;").replaceAll('"', "&quot;").replaceAll("<", "&lt;");
}
