// Take away: what a run gives to other programs, and to people.

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import "./take.css";
import { Stopped } from "./client";
import { colourOf, isForce, scaleOf, values } from "./colour";
import { lasts, paceAt } from "./event";
import type { Film } from "./film";
import { about, count, local, rich, t } from "./language";
import { canvas } from "./layout";
import { movie, whyNoMovie } from "./movie";
import { curvesCsv, leavingCsv, origin, perExit, saveOfRun, saveTable } from "./csv";
import { attribute, Button, copy, digits, named, NumberField, save } from "./parts";
import { compose, png } from "./picture";
import { link, onlyHere, plan, title } from "./plan";
import type { FileRequest, NamedFile } from "./protocol";
import { makeReport } from "./report";
import { heightOf } from "./sections";
import { client, said, selected } from "./session";
import { joined } from "./store";

/** The libraries that this lab packs into FMUs, and their licences. */
async function libraries(): Promise<[string, Uint8Array<ArrayBuffer>][]> {
    const list = await fetch("binaries.json");
    if (!list.ok) throw new Error(t("this lab was built without libraries for FMUs (lab/build.sh says how)"));
    const names = (await list.json()) as Record<string, string>;
    return Promise.all(
        Object.entries(names).map(async ([platform, file]): Promise<[string, Uint8Array<ArrayBuffer>]> => {
            const library = await fetch(file);
            if (!library.ok) throw new Error(t("the library for {platform} is missing here", { platform }));
            return [platform, new Uint8Array(await library.arrayBuffer())];
        }),
    );
}

export function TakeTab({ film }: { film: Film }) {
    const busy = useSignal(false);
    /** The share of the movie that is recorded. */
    const recorded = useSignal<number | null>(null);
    const problem = useSignal("");
    const until = useSignal<number | null>(null);
    const recording = useRef<AbortController | null>(null);
    useEffect(() => {
        until.value = null;
        // A movie is of what the stage shows: it ends where that is left.
        return () => recording.current?.abort();
    }, [film]);
    const { scene } = film;
    const run = scene.run;
    /** A Trial with ways needs a second FMU: the crowd alone would not walk. */
    const decided = scene.walk;
    /** The name of a file about the frame that is shown. */
    const timed = (name: string) => name.replace(/\.\w+$/, (ending) => `-${Number((film.shown.peek() * scene.step).toFixed(6))}s${ending}`);
    const shown = () => film.frames.copy(film.shown.peek(), film.shown.peek() + 1);

    /** What the lab makes and takes long, the page shows and stops (busy.tsx). */
    const making = async (what: string, make: () => Promise<string | null | void>) => {
        problem.value = "";
        busy.value = true;
        try {
            const name = await make();
            if (name !== undefined) said.value = name ? t('"{name}" is made.', { name }) : t("Stopped.");
        } catch (error) {
            if (!(error instanceof Stopped)) problem.value = about(what, (error as Error).message);
        } finally {
            busy.value = false;
        }
    };
    /** A file that the lab makes. */
    const take = async (wanted: FileRequest, bytes?: Uint8Array, of = (name: string) => name) => {
        const answer = await client.ask<NamedFile>({ ask: "take", run, wanted }, bytes);
        return save(of(answer.value.name), answer.bytes);
    };

    const fmu = async (version: 2 | 3) => {
        const files = await libraries();
        const binaries = files.map(([platform, content]) => [platform, content.length] as [string, number]);
        return take({ file: "fmu", version, binaries }, await joined(files.map(([, content]) => content)), (name) => name.replace(/\.fmu$/, `-fmi${version}.fmu`));
    };
    const svg = async () => {
        const { low, high, largest, label, unit, kinds } = scaleOf(film, plan.value.colour);
        const k = film.shown.peek();
        const height = heightOf(film) ?? undefined;
        const wanted: FileRequest = { file: "svg", range: [low, high], beyond: largest > high, from_grey: isForce(colourOf(film, plan.value.colour)), label, unit, time: k * scene.step, forces: plan.value.forces && height === undefined, height, by_kind: kinds !== undefined };
        return take(wanted, await joined([shown(), values(film, k, plan.value.colour).slice()]), timed);
    };
    const picture = async () => {
        const from = canvas.value;
        if (!from) throw new Error(t("the stage shows no picture"));
        return save(timed(`${scene.name}.png`), await png((onto) => compose(onto, from, film)));
    };
    const record = async () => {
        recording.current = new AbortController();
        recorded.value = 0;
        const blob = await movie(film, (frame) => paceAt(film, frame), (share) => (recorded.value = share), recording.current.signal).finally(() => (recorded.value = null));
        return blob && save(`${scene.name}.webm`, blob);
    };
    /** A table that the lab makes. */
    const table = async (wanted: FileRequest, end: number, of = (name: string) => name) => {
        const settings = origin(film, 0, end);
        const answer = await client.ask<NamedFile>({ ask: "take", run, wanted }, undefined);
        return saveTable(of(answer.value.name), answer.bytes, settings);
    };
    const chosen = selected.value === null ? undefined : scene.agents[selected.value]?.id;
    const ofChosen = chosen === undefined ? "" : `-person-${chosen.slice(0, 24)}`;
    const size = (each: number) => Math.ceil(each * scene.agents.length);
    const leaves = perExit(film).map(({ name, people, flow }) => `${about(named(name), count(people, "{n} person", "{n} people"))}${flow === null ? "" : t(", {flow} per second", { flow: digits(flow, 3) })}`);
    const end = until.value ?? film.reached.value * scene.step;
    const steps = Math.max(1, Math.round(end / scene.step));
    const last = Number((steps * scene.step).toPrecision(12));
    const trajectories = () => table({ file: "trajectories", steps }, last, (name) => name.replace(/\.csv$/, `-0-${last}s.csv`));

    const noMovie = whyNoMovie();
    const seconds = lasts(film, film.reached.value * scene.step);
    const pace = plan.value.pace || (seconds > film.reached.value * scene.step ? `${local(0.1)}–1` : 1);
    const item = (name: string, make: () => Promise<string | null | void>, words: ComponentChildren, not = "", field: ComponentChildren = null) => (
        <li>
            <Button words={name} disabled={busy.value || not !== ""} onClick={() => void making(name, make)} />
            <p class="note">
                {words} {not && <strong>{not}</strong>}
            </p>
            {field}
        </li>
    );
    return (
        <section class="panel take" aria-label={t("Take away")}>
            {recorded.value !== null && (
                <div class="work">
                    <p role="status">{t("The movie is recorded …")}</p>
                    <progress aria-label={t("Movie")} value={recorded.value} />
                    <Button words={t("Stop")} onClick={() => recording.current?.abort()} />
                </div>
            )}
            {problem.value && (
                <p role="alert" class="problem">
                    {problem.value}
                </p>
            )}
            <h2>{t("To compute with")}</h2>
            <ul>
                {item(
                    t("Trial (zip)"),
                    () => take({ file: "trial" }),
                    decided
                        ? rich("The XML files and {decision}, which says where people walk. {run} computes the same numbers from it. {decide} makes the FMU that decides from this Trial, and {connect} couples both; this page opens it again.", {
                              decision: <code>decision.toml</code>,
                              run: <code>lemons run</code>,
                              decide: <code>lemons decide</code>,
                              connect: <code>lemons connect</code>,
                          })
                        : rich("The XML files and what drives people. {run} computes the same numbers from it; this page opens it again.", { run: <code>lemons run</code> }),
                )}
                {item(
                    "FMU, FMI 2.0",
                    () => fmu(2),
                    `${t("For simulation programs that read FMI 2.0: FMPy, OpenModelica, Simulink and others.")} ${decided ? t("It holds the crowd only, not who decides.") : ""}`,
                )}
                {item("FMU, FMI 3.0", () => fmu(3), t("The same for programs that read FMI 3.0: all people in a few array variables."))}
            </ul>
            <h2>{t("To look at")}</h2>
            <ul>
                {item(
                    t("Copy code to embed"),
                    async () => {
                        await copy(`<iframe src="${attribute(await link("?embed"))}" title="${attribute(title.peek())}" width="800" height="600" allow="fullscreen"></iframe>`);
                        said.value = [t("The code is copied."), onlyHere].filter(Boolean).join(" ");
                    },
                    <>
                        {t("An element of HTML that shows the stage, alone and alive, in a page of yours. It holds the scene, but no files.")} <strong>{onlyHere}</strong>
                    </>,
                )}
                {item(t("Report to print"), () => makeReport(film), t("A picture of the moment of the greatest squeeze, what the scene assumes, its numbers up to the last frame that was shown, and what they do not say. The browser prints it, also as PDF."))}
                {item(t("Picture (SVG)"), svg, t("The frame that is shown, as lines and shapes: for papers, and for Inkscape. It shows people from above."))}
                {item(t("Picture (PNG)"), picture, t("What the stage shows now, as pixels: for slides and messages."))}
                {item(
                    t("Movie (WebM)"),
                    record,
                    film.reached.value < 1
                        ? t("All frames up to the last one that was shown, as the stage shows them. Play the run first.")
                        : t("All frames up to the last one that was shown or asked for, as the stage shows them: {seconds} s at the pace {pace} ×. Browsers, VLC and ffmpeg read it.", { seconds: digits(seconds, 2), pace }),
                    film.reached.value < 1 ? "" : noMovie,
                )}
            </ul>
            <h2>{t("Bodies")}</h2>
            <ul>
                {item(
                    t("Bodies (OBJ)"),
                    () => take({ file: "mesh", format: "obj" }, shown(), timed),
                    t("Everybody's body in the frame that is shown, each part with a name: Blender and MeshLab read it. About {size} MB.", { size: size(0.45) }),
                )}
                {item(
                    t("Bodies (STL)"),
                    () => take({ file: "mesh", format: "stl" }, shown(), timed),
                    t("The same as bare triangles: for printing and for CAD. About {size} MB.", { size: size(0.68) }),
                )}
            </ul>
            <h2>{t("Tables")}</h2>
            <ul>
                {item(
                    t("Trajectories (CSV)"),
                    trajectories,
                    decided
                        ? rich("The run, in which people walk, computed again from the start, as a table of the form that {run} writes. R, pandas and spreadsheets read it.", { run: <code>lemons run</code> })
                        : rich("The table that {run} writes from the Trial, to the last bit, computed again from the start. R, pandas and spreadsheets read it.", { run: <code>lemons run</code> }),
                    "",
                    <NumberField
                        label={t("Until")}
                        unit="s"
                        value={last}
                        min={scene.step}
                        max={Number((1e6 * scene.step).toPrecision(12))}
                        step={scene.step}
                        onChange={(value) => (until.value = value)}
                    />,
                )}
                {item(
                    t("Curves (CSV)"),
                    async () => saveOfRun(film, `curves${ofChosen}`, curvesCsv(film, selected.value), { person: chosen, squeeze_is_a_mean_over_s: plan.value.smooth }),
                    t("What the charts show, for each communication step up to the last one that was shown or asked for: mean speed, squeeze, contacts, how many have left; of the selected person, too."),
                )}
                {item(
                    t("Who left when (CSV)"),
                    async () => saveOfRun(film, "leaving", leavingCsv(film)),
                    leaves.length > 0 ? t("Up to the last frame that was shown or asked for: {leaves}.", { leaves: leaves.join("; ") }) : t("When each person left, and by which exit."),
                    scene.leaving === 0 ? t("Nobody leaves in this scene.") : "",
                )}
                {item(
                    t("People (CSV)"),
                    () => table({ file: "population" }, 0),
                    rich("Sex and measures of everybody, as {crowd} writes them.", { crowd: <code>lemons crowd</code> }),
                    scene.people ? "" : t("Only of crowds that this page has made: others do not say them."),
                )}
            </ul>
        </section>
    );
}
