// Small parts of forms.

import type { ComponentChildren } from "preact";
import { useId, useState } from "preact/hooks";

interface NumberProps {
    label: string;
    unit?: string;
    value: number;
    min: number;
    max: number;
    step: number;
    onChange(value: number): void;
}

/** A number with its unit. What is out of range is not taken; it stays there, with the reason. */
export function NumberField({ label, unit, value, min, max, step, onChange }: NumberProps) {
    // What was typed, as long as the value is not changed in another way.
    const [typed, setTyped] = useState<{ text: string; instead: number } | null>(null);
    const wrong = typed?.instead === value;
    const id = useId();
    return (
        <div class="field">
            <label for={id}>
                {label}
                {unit && <span class="unit"> [{unit}]</span>}
            </label>
            <input
                id={id}
                type="number"
                value={wrong ? typed!.text : value}
                min={min}
                max={max}
                step={step}
                aria-invalid={wrong}
                aria-describedby={wrong ? `${id}-why` : undefined}
                onChange={(event) => {
                    const number = event.currentTarget.valueAsNumber;
                    // Between two steps of the arrows is fine, but people are whole.
                    const fits = number >= min && number <= max && (step !== 1 || Number.isInteger(number));
                    setTyped(fits ? null : { text: event.currentTarget.value, instead: value });
                    if (fits) onChange(number);
                }}
            />
            {wrong && (
                <p id={`${id}-why`} class="note" role="alert">
                    {label}: {step === 1 ? "a whole number, " : ""}
                    {min} to {max}
                    {unit && ` ${unit}`}
                </p>
            )}
        </div>
    );
}

interface ChoiceProps<T extends string> {
    label: string;
    value: T;
    choices: readonly (readonly [T, string])[];
    onChange(value: T): void;
}

export function Choice<T extends string>({ label, value, choices, onChange }: ChoiceProps<T>) {
    return (
        <label class="field">
            <span>{label}</span>
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

export function Facts({ rows }: { rows: [string, ComponentChildren][] }) {
    return (
        <table class="facts">
            <tbody>
                {rows.map(([name, value]) => (
                    <tr key={name}>
                        <th scope="row">{name}</th>
                        <td>{value}</td>
                    </tr>
                ))}
            </tbody>
        </table>
    );
}

/** A number with this many significant digits. */
export function digits(value: number, count: number) {
    if (value === 0) return "0";
    const size = Math.floor(Math.log10(Math.abs(value)));
    return size < -4 ? value.toExponential(count - 1) : value.toFixed(Math.max(0, count - 1 - size));
}

/** Gives a file to the user. */
export function save(name: string, content: BlobPart) {
    const url = URL.createObjectURL(new Blob([content]));
    const anchor = document.createElement("a");
    anchor.href = url;
    anchor.download = name;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(url), 60_000);
}
