// Tables of what the page itself knows of a run.

import { averaged } from "./colour";
import type { Film } from "./film";
import { meanFlow } from "./flow";
import { type Curve, SQUEEZE } from "./frames";
import { save } from "./parts";
import { title } from "./plan";
import { CHEST, COLUMNS, type Point } from "./protocol";
import { away } from "./roomshape";
import { VERSION } from "./version";

/** As `lemons run` writes times: without the rounding of products. */
function time(film: Film, k: number) {
    return Number((k * film.scene.step).toPrecision(12));
}

/** A name from a link or a file must be no formula for spreadsheets. */
function quoted(given: string) {
    const text = /^[=+@-]/.test(given) && Number.isNaN(Number(given)) ? `'${given}` : given;
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

export function table(rows: (string | number)[][]) {
    return rows.map((row) => `${row.map((cell) => (typeof cell === "string" ? quoted(cell) : Number.isNaN(cell) ? "" : cell)).join(",")}\n`).join("");
}

/** Gives a table to the user, and beside it a file that says where it comes from. A comment in the table would be a row of
 * data for spreadsheets, pandas and R. Its name and form are those of W3C's CSV on the Web, which has such a file, too. */
export function saveTable(called: string, content: BlobPart, settings: Record<string, unknown>): string {
    const name = save(called, content);
    const told = { "@context": "http://www.w3.org/ns/csvw", url: encodeURIComponent(name), "dc:creator": `LEMONS lab ${VERSION}`, "dc:created": new Date().toISOString(), notes: [settings] };
    save(`${name}-metadata.json`, JSON.stringify(told, null, 1));
    return name;
}

/** What a table of a run comes from: the scene as it is, and the time in s. */
export function origin(film: Film, from: number, to: number): Record<string, unknown> {
    const { agents, step, mechanical_step, warnings } = film.scene;
    return { scene: title.peek(), from_s: from, to_s: to, people: agents.length, communication_step_s: step, mechanical_step_s: mechanical_step, warnings: warnings.map(({ text }) => text), made: film.made };
}

/** A table of the run up to the last frame that was shown or asked for; its name says of which scene and time it is. */
export function saveOfRun(film: Film, what: string, content: string, settings = {}): string {
    const to = time(film, film.reached.peek());
    return saveTable(`${title.peek()}-${what}-0-${to}s.csv`, content, { ...origin(film, 0, to), ...settings });
}

/** The curves of the charts, a row for each frame up to the last one that was shown or asked for. */
export function curvesCsv(film: Film, agent: number | null): string {
    const { frames } = film;
    const curve = (name: Curve, k: number) => frames.curve(name)[k]!;
    const means = frames.greatestMean(averaged(film));
    const chests = film.scene.chests ? frames.greatestMean(averaged(film), CHEST) : null;
    const over = Number((averaged(film) * film.scene.step).toPrecision(6));
    const id = agent === null ? "" : film.scene.agents[agent]!.id;
    const own = agent === null ? [] : [`speed_of_${id} [m/s]`, `squeeze_of_${id} [N]`, ...(chests ? [`chest_of_${id} [N]`] : [])];
    const rows: (string | number)[][] = [["t [s]", "mean_speed [m/s]", "mean_squeeze [N]", "greatest_squeeze [N]", `greatest_mean_of_${over}_s [N]`, "mean_contacts", "left", ...(chests ? [`greatest_chest_mean_of_${over}_s [N]`] : []), ...own]];
    for (let k = 0; k <= film.reached.value; k++) {
        const row = [time(film, k), curve("speed", k), curve("squeeze", k), curve("greatest", k), means[k]!, curve("contacts", k), curve("left", k), ...(chests ? [chests[k]!] : [])];
        if (agent !== null) {
            const of = (column: number) => (Number.isNaN(frames.number(k, agent, 0)) ? NaN : frames.number(k, agent, column));
            row.push(Math.hypot(of(3), of(4)), of(SQUEEZE), ...(chests ? [of(CHEST)] : []));
        }
        rows.push(row);
    }
    return table(rows);
}

interface Leaving {
    agent: number;
    /** The first one in which the person is not there. */
    frame: number;
    /** The exit that was nearest before. */
    exit: string;
}

/** What was found of a film, up to a frame. */
const found = new WeakMap<Film, { k: number; all: Leaving[]; gone: Set<number> }>();

/** Who has left, in this order, up to a frame. */
export function leavings(film: Film, last: number): Leaving[] {
    const { frames, scene } = film;
    const left = frames.curve("left");
    const exits = scene.targets.filter(({ stay }) => !stay);
    const known = found.get(film) ?? { k: 0, all: [], gone: new Set<number>() };
    found.set(film, known);
    while (known.k < last) {
        const k = (known.k += 1);
        if (!(left[k]! > left[k - 1]!)) continue;
        const [before, now] = [frames.frame(k - 1).slice(), frames.frame(k)];
        for (let agent = 0; agent < scene.agents.length; agent++) {
            // Who has not come yet has no velocity either.
            if (known.gone.has(agent) || !Number.isNaN(now[COLUMNS * agent]!) || Number.isNaN(now[COLUMNS * agent + 3]!)) continue;
            known.gone.add(agent);
            const at: Point = [before[COLUMNS * agent]!, before[COLUMNS * agent + 1]!];
            const near = exits.reduce((best, exit) => (away(at, exit.corners) < away(at, best.corners) ? exit : best), exits[0]!);
            known.all.push({ agent, frame: k, exit: near?.name ?? "" });
        }
    }
    return known.all.filter(({ frame }) => frame <= last);
}

export function leavingCsv(film: Film): string {
    const rows = leavings(film, film.reached.value).map(({ agent, frame, exit }) => [film.scene.agents[agent]!.id, time(film, frame), exit]);
    return table([["id", "left [s]", "exit"], ...rows]);
}

/** How many have left by each exit, and people per second from the first to the last of them. */
export function perExit(film: Film, last = film.reached.value): { name: string; people: number; flow: number | null }[] {
    const all = leavings(film, last);
    return film.scene.targets
        .filter(({ stay }) => !stay)
        .map(({ name }) => {
            const frames = all.filter(({ exit }) => exit === name).map(({ frame }) => frame);
            return { name, people: frames.length, flow: meanFlow(frames.length, frames[0] ?? 0, frames.at(-1) ?? 0, film.scene.step) };
        });
}
