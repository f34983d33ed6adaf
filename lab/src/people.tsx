// Who the people of a crowd are: as surveyed, from statistics of the user's, or measured people.

import { signal } from "@preact/signals";
import { inner, t } from "./language";
import { Choice, Field, Head } from "./parts";
import { type KeptPeople, MOST } from "./forms";
import { plan } from "./plan";
import type { Four, Normal, Sex } from "./protocol";
import { FileInput, type Given, taken, tooLong } from "./upload";

type Statistics = Extract<KeptPeople, { kind: "statistics" }>;
type Table = Extract<KeptPeople, { kind: "table" }>;

const MEASURES = [
    ["breadth", t("Bideltoid breadth")],
    ["depth", t("Chest depth")],
    ["stature", t("Stature")],
    ["mass", t("Mass")],
] as const;
const SEXES = [
    ["male", t("Men")],
    ["female", t("Women")],
] as const;
const VALUES = [t("mean"), t("SD"), t("least"), t("most")];

const FIRST: Statistics = {
    kind: "statistics",
    male: { breadth: [0.51, 0.02, 0.3, 0.65], depth: [0.26, 0.02, 0.15, 0.45], stature: [1.78, 0.08, 1.4, 2.4], mass: [85, 15, 30, 160] },
    female: { breadth: [0.45, 0.015, 0.3, 0.6], depth: [0.24, 0.015, 0.15, 0.45], stature: [1.64, 0.07, 1.4, 2.1], mass: [67, 11, 30, 130] },
};

/** What was there before another kind was chosen. */
const before = signal<{ statistics: Statistics; table: Table | null }>({ statistics: FIRST, table: null });
/** Tables are wanted, but none is there yet. */
const waiting = signal(false);

export function People({ people, onChange }: { people: KeptPeople; onChange(people: KeptPeople): void }) {
    const kind = waiting.value ? "table" : people.kind;
    const choose = (next: KeptPeople["kind"]) => {
        if (people.kind === "statistics") before.value = { ...before.value, statistics: people };
        if (people.kind === "table") before.value = { ...before.value, table: people };
        waiting.value = next === "table" && !before.value.table;
        if (next === "survey") onChange({ kind: "survey" });
        else if (next === "statistics") onChange(before.value.statistics);
        else if (before.value.table) onChange(before.value.table);
    };
    return (
        <>
            <Choice
                label={t("Who they are")}
                value={kind}
                choices={[
                    ["survey", t("As in the survey ANSUR II")],
                    ["statistics", t("From statistics of your own")],
                    ["table", t("From tables of measured people")],
                ]}
                onChange={choose}
            />
            {kind === "statistics" && people.kind === "statistics" && <StatisticsTable people={people} onChange={onChange} />}
            {kind === "table" && (
                <>
                    <p class="note">
                        {people.kind === "table" ? t("They are drawn from {files}.", { files: people.files.map(([, name]) => `"${name}"`).join(t(" and ")) }) : t("Until a table is chosen, people are as in the survey.")} {t("Tables have the columns of ANSUR_II_MALE_Public.csv and ANSUR_II_FEMALE_Public.csv; FEMALE or MALE in the name says whom they hold.")}
                    </p>
                    <FileInput
                        label={t("Choose tables (one or two)")}
                        accept=".csv,text/csv"
                        several
                        onFiles={async (given) => {
                            onChange(await table(given));
                            waiting.value = false;
                        }}
                    />
                </>
            )}
        </>
    );
}

/** The sex of a table is in its name. */
function sexOf(name: string): Sex {
    if (/female|women/i.test(name)) return "female";
    if (/male|men/i.test(name)) return "male";
    throw new Error(t("{name}: the name says neither MALE nor FEMALE", { name }));
}

async function table(given: Given[]): Promise<Table> {
    const files = given.map(({ file }) => [sexOf(file.name), file.name, file.size] as [Sex, string, number]);
    if (files.length > 2 || (files.length === 2 && files[0]![0] === files[1]![0])) throw new Error(t("choose one table of men, one of women, or both"));
    const long = files.find(([, name]) => name.length > MOST.name);
    if (long) throw new Error(tooLong(long[1]));
    return { kind: "table", files, key: await taken(given.map(({ file }) => file)) };
}

function StatisticsTable({ people, onChange }: { people: Statistics; onChange(people: Statistics): void }) {
    const { unit } = plan.value;
    const set = (sex: Sex, measure: keyof Four, k: number, value: number) => {
        const row = people[sex][measure].map((old, j) => (j === k ? value : old)) as Normal;
        onChange({ ...people, [sex]: { ...people[sex], [measure]: row } });
    };
    return (
        <div class="wide">
            {SEXES.map(([sex, who]) => (
                <table class="statistics" key={sex}>
                    <caption>{t("{who}: normal distributions between the least and the most", { who })}</caption>
                    <Head of={[t("Measure"), ...VALUES]} />
                    <tbody>
                        {MEASURES.map(([measure, words]) => (
                            <tr key={measure}>
                                <th scope="row">
                                    {words} <span class="unit">[{measure === "mass" ? "kg" : unit}]</span>
                                </th>
                                {VALUES.map((value, k) => (
                                    <td key={value}>
                                        <Cell
                                            label={`${who}, ${inner(words)}, ${value}`}
                                            value={people[sex][measure][k]!}
                                            by={measure === "mass" || unit === "m" ? 1 : 100}
                                            onChange={(next) => set(sex, measure, k, next)}
                                        />
                                    </td>
                                ))}
                            </tr>
                        ))}
                    </tbody>
                </table>
            ))}
        </div>
    );
}

/** The lab says which values make sense together, when the crowd is made. */
function Cell({ label, value, by, onChange }: { label: string; value: number; by: number; onChange(value: number): void }) {
    const shown = Number((value * by).toFixed(3));
    return (
        <Field
            type="number"
            aria-label={label}
            value={shown}
            min={0}
            step="any"
            onChange={(event) => {
                const number = event.currentTarget.valueAsNumber;
                if (number >= 0 && number <= 1000) onChange(number / by);
            }}
        />
    );
}
