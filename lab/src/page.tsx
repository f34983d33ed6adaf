// The page: what is shown where, and which run is the present one.

import { computed, effect, signal, untracked } from "@preact/signals";
import { render } from "preact";
import { Client, Stopped } from "./client";
import { CrowdTab, progress } from "./crowd";
import { Film } from "./film";
import { save } from "./parts";
import { PersonTab } from "./person";
import { canRedo, canUndo, change, FIRST, link, type Plan, plan, redo, type Source, undo } from "./plan";
import type { Scene } from "./protocol";
import { Stage } from "./stage";

const client = new Client();
client.broken = (why) => {
    problem.value = `The computation ended (${why}). What was shown is opened again, from its start.`;
    if (client.generation < 5) back();
};
const film = signal<Film | null>(null);
const said = signal("");
const problem = signal("");
const notes = signal<string[]>([]);
/** Whether an upload is shown instead of what the plan says. */
const uploaded = signal(false);

const EXAMPLES: [string, Source][] = [
    ["A push through a row", { kind: "example", name: "push" }],
    ["A hundred people walk against a wall", { kind: "crowd", made: { number: 100, seed: 1, room: [8, 4], men: 0.5, direction: 0, speed: 1 } }],
];

/** What is shown; undone changes of the form do not matter to it. */
let present: Source | null = null;

function show(next: Film, plays: boolean) {
    film.value?.end();
    film.value = next;
    next.playing.value = plays && !matchMedia("(prefers-reduced-motion: reduce)").matches;
}

async function attempt(what: () => Promise<void>) {
    problem.value = "";
    try {
        await what();
    } catch (error) {
        if (error instanceof Stopped && error.message === "stopped") return;
        problem.value = (error as Error).message;
        // A link or a former visit may hold what cannot be made.
        if (!film.value && plan.value.source !== FIRST.source) {
            const why = problem.value;
            change({ source: FIRST.source });
            problem.value = why;
        }
    }
}

interface Opened {
    scene: Scene;
    notes: string[];
}

async function open(source: Source) {
    notes.value = [];
    said.value = "";
    uploaded.value = false;
    if (source.kind === "example") {
        const { value, bytes } = await client.ask<Opened>({ ask: "example", name: source.name });
        present = source;
        return show(new Film(client, value.scene, bytes), true);
    }
    said.value = "People are placed …";
    progress.value = { stage: 0, iteration: 0, limit: 0, overlap: 0, density: 0 };
    try {
        const request = { ask: "crowd" as const, ...source.made };
        const { value, bytes, seconds } = await client.ask<Opened>(request, undefined, (now) => (progress.value = now));
        present = source;
        said.value = `${source.made.number} people placed in ${seconds.toFixed(2)} s`;
        show(new Film(client, value.scene, bytes), false);
    } catch (error) {
        said.value = "";
        throw error;
    } finally {
        progress.value = null;
    }
}

/** Makes it the present run; again from the start, if it is. */
function choose(source: Source) {
    const before = plan.value.source;
    if (JSON.stringify(before) === JSON.stringify(source)) void attempt(() => open(source));
    else change({ source });
}

/** Ends a placing. The lab's run ends with its worker: what was there before is opened again. */
function stop() {
    client.stop("stopped");
    back();
}

/** To what was shown; if nothing was, to the first example. An upload that a worker took with it is gone. */
function back() {
    const source = present ?? FIRST.source;
    const same = JSON.stringify(source) === JSON.stringify(plan.value.source);
    if (!same) change({ source });
    else void attempt(() => open(source));
}

/** A zip of the user's. It stays on this machine, so it is no part of the plan or its link. */
async function upload(file: File) {
    if (file.size > 50e6) throw new Error(`${file.name} has more than 50 MB`);
    const bytes = new Uint8Array(await file.arrayBuffer());
    const { value, bytes: first } = await client.ask<Opened>({ ask: "open", name: file.name }, bytes);
    notes.value = value.notes;
    uploaded.value = true;
    said.value = `${file.name}: ${value.scene.agents.length} people`;
    show(new Film(client, value.scene, first), false);
    change({ tab: "run" });
}

async function takeTrial(run: number) {
    const { value, bytes } = await client.ask<{ name: string }>({ ask: "take", run, wanted: { file: "trial" } });
    save(value.name, bytes);
}

async function takeFmu(run: number, version: 2 | 3) {
    const list = await fetch("binaries.json");
    if (!list.ok) throw new Error("this lab was built without libraries for FMUs (lab/build.sh says how)");
    const names = (await list.json()) as Record<string, string>;
    const files = await Promise.all(
        Object.entries(names).map(async ([platform, file]) => {
            const library = await fetch(file);
            if (!library.ok) throw new Error(`the library for ${platform} is missing here`);
            return [platform, new Uint8Array(await library.arrayBuffer())] as const;
        }),
    );
    const binaries = files.map(([platform, content]) => [platform, content.length] as [string, number]);
    const all = new Uint8Array(await new Blob(files.map(([, content]) => content)).arrayBuffer());
    const { value, bytes } = await client.ask<{ name: string }>({ ask: "take", run, wanted: { file: "fmu", version, binaries } }, all);
    save(value.name.replace(/\.fmu$/, `-fmi${version}.fmu`), bytes);
}

function taking(what: (run: number) => Promise<void>) {
    return attempt(async () => {
        if (film.value) await what(film.value.scene.run);
    });
}

const TABS: [Plan["tab"], string][] = [
    ["run", "Run"],
    ["crowd", "Crowd"],
    ["person", "Person"],
];

function Page() {
    const { tab, source, unit } = plan.value;
    return (
        <>
            <header>
                <h1>LEMONS lab</h1>
                <nav aria-label="Parts">
                    {TABS.map(([key, words]) => (
                        <button key={key} type="button" aria-current={tab === key ? "page" : undefined} onClick={() => change({ tab: key })}>
                            {words}
                        </button>
                    ))}
                </nav>
                <div class="tools">
                    <button type="button" disabled={!canUndo.value} onClick={undo}>
                        Undo
                    </button>
                    <button type="button" disabled={!canRedo.value} onClick={redo}>
                        Redo
                    </button>
                    <button type="button" onClick={() => change({ unit: unit === "m" ? "cm" : "m" })}>
                        Show lengths in {unit === "m" ? "cm" : "m"}
                    </button>
                    <button type="button" onClick={() =>
                            void attempt(async () => {
                                if (!navigator.clipboard) throw new Error(`this browser copies nothing from such a page; the link is ${link()}`);
                                await navigator.clipboard.writeText(link());
                                said.value = uploaded.value ? "The link is copied. It does not hold the Trial that you opened." : "The link is copied.";
                            })
                        }>
                        Copy link
                    </button>
                </div>
            </header>
            <main>
                <p role="status">{said.value}</p>
                {problem.value && (
                    <pre role="alert" class="problem">
                        {problem.value}
                    </pre>
                )}
                {notes.value.length > 0 && (
                    <ul class="notes">
                        {notes.value.map((note) => (
                            <li key={note}>{note}</li>
                        ))}
                    </ul>
                )}
                {tab === "person" ? (
                    <PersonTab client={client} />
                ) : (
                    <div class="columns">
                        {tab === "crowd" ? (
                            <CrowdTab
                                make={() => choose({ kind: "crowd", made: plan.value.crowd })}
                                stop={stop}
                            />
                        ) : (
                            <section class="panel" aria-label="Trials">
                                <h2>Start from</h2>
                                {EXAMPLES.map(([words, example]) => (
                                    <button
                                        key={words}
                                        type="button"
                                        aria-pressed={!uploaded.value && JSON.stringify(source) === JSON.stringify(example)}
                                        onClick={() => choose(example)}
                                    >
                                        {words}
                                    </button>
                                ))}
                                <label class="upload">
                                    Open your Trial
                                    <input
                                        type="file"
                                        accept=".zip"
                                        onChange={(event) => {
                                            const input = event.currentTarget;
                                            const file = input.files?.[0];
                                            if (file) void attempt(() => upload(file));
                                            input.value = "";
                                        }}
                                    />
                                </label>
                                <h2>Take away</h2>
                                <button type="button" onClick={() => void taking(takeTrial)}>
                                    Trial (zip)
                                </button>
                                <button type="button" onClick={() => void taking((run) => takeFmu(run, 2))}>
                                    FMU, FMI 2.0
                                </button>
                                <button type="button" onClick={() => void taking((run) => takeFmu(run, 3))}>
                                    FMU, FMI 3.0
                                </button>
                                <button type="button" disabled={!film.value} onClick={() => film.value && save(`${film.value.scene.name}.csv`, film.value.table())}>
                                    Poses (CSV)
                                </button>
                            </section>
                        )}
                        {film.value ? <Stage key={film.value} film={film.value} /> : <p role="status">One moment …</p>}
                    </div>
                )}
            </main>
            <footer>
                Computed in your browser: nothing that you open leaves this machine. <a href="licences.txt">Licences</a>
            </footer>
        </>
    );
}

const source = computed(() => JSON.stringify(plan.value.source));
effect(() => {
    // Also when it is brought back: by undo, a link, the browser's storage.
    const wanted = JSON.parse(source.value) as Source;
    untracked(() => void attempt(() => open(wanted)));
});

addEventListener("keydown", (event) => {
    // In a field they are the field's own.
    const typing = event.target instanceof HTMLInputElement && event.target.type === "number";
    if (typing) return;
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !event.shiftKey) undo();
    else if ((event.ctrlKey || event.metaKey) && (event.key === "y" || event.key.toLowerCase() === "z")) redo();
});

render(<Page />, document.getElementById("lab")!);
