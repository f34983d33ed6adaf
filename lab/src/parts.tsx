// Small parts of forms.

import type { ComponentChildren } from "preact";

interface NumberProps {
    label: string;
    unit?: string;
    value: number;
    min: number;
    max: number;
    step: number;
    onChange(value: number): void;
}

/** A number with its unit; a value out of range is not taken, and the browser says why. */
export function NumberField({ label, unit, value, min, max, step, onChange }: NumberProps) {
    return (
        <label class="field">
            <span>
                {label}
                {unit && <span class="unit"> [{unit}]</span>}
            </span>
            <input
                type="number"
                value={value}
                min={min}
                max={max}
                step={step}
                onChange={(event) => {
                    const input = event.currentTarget;
                    if (input.value !== "" && input.checkValidity()) onChange(input.valueAsNumber);
                    else {
                        input.reportValidity();
                        input.value = String(value);
                    }
                }}
            />
        </label>
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
