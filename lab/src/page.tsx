// The page: its parts and what is above them.

import { effect, signal } from "@preact/signals";
import { type JSX, render } from "preact";
import { questionOf } from "./answer";
import { Busy } from "./busy";
import { CrowdTab } from "./crowd";
import { about, choose, language, type Language, LANGUAGES, t, unloaded } from "./language";
import { present, presents } from "./layout";
import { follow } from "./live";
import { MotionTab } from "./motion";
import { Numbers } from "./numbers";
import { Button, copy, Icon, isUndo, Link } from "./parts";
import { PersonTab } from "./person";
import { canRedo, canUndo, change, link, onlyHere, type Plan, plan, redo, title, undo, unlinked } from "./plan";
import { isPlan, openPlan } from "./plans";
import { Report, report } from "./report";
import { RoomTab } from "./room";
import { Title } from "./scenelist";
import { begin as keepScenes } from "./scenes";
import { attempt, begin, client, film, notes, problem, said } from "./session";
import { Sketch } from "./sketch";
import { Stage } from "./stage";
import { StartTab } from "./start";
import { embedded, viewed } from "./storage";
import { TakeTab } from "./take";
import { Tour } from "./tour";
import { dropped, openTrial } from "./upload";

const TABS: [Plan["tab"], string][] = [
    ["start", t("Start")],
    ["room", t("Room")],
    ["crowd", t("Crowd")],
    ["motion", t("Motion")],
    ["person", t("Person")],
    ["take", t("Take away")],
];

/** Above the stage alone. */
function Bare() {
    return (
        <header class="bare">
            <h1>{title.value}</h1>
            <p>{questionOf(film.value)}</p>
            <div class="tools">
                {viewed ? (
                    <Link query="?lab" words={t("Open in the lab")} target={embedded ? "_blank" : undefined} />
                ) : (
                    <Button words={t("End the presentation")} onClick={() => present(false)} />
                )}
            </div>
        </header>
    );
}

function Header() {
    const { tab, unit, more } = plan.value;
    const other = unit === "m" ? "cm" : "m";
    return (
        <header>
            <h1>{t("LEMONS lab")}</h1>
            <Title />
            <nav aria-label={t("Parts")}>
                {TABS.map(([key, words]) => (
                    <Button key={key} words={words} aria-current={tab === key ? "page" : undefined} onClick={() => go(key)} />
                ))}
                <Button words={t("Numbers")} class="phone" aria-pressed={sheet.value === "numbers"} onClick={() => (sheet.value = sheet.value === "numbers" ? null : "numbers")} />
            </nav>
            <div class="tools">
                <button type="button" aria-label={t("Undo")} title={t("Undo (Ctrl+Z)")} disabled={!canUndo.value} onClick={undo}>
                    <Icon path="M6 2L2 6l4 4V7h4a2 2 0 0 1 0 4H6v2h4a4 4 0 0 0 0-8H6z" />
                </button>
                <button type="button" aria-label={t("Redo")} title={t("Redo (Ctrl+Y)")} disabled={!canRedo.value} onClick={redo}>
                    <Icon path="M10 2l4 4-4 4V7H6a2 2 0 0 0 0 4h4v2H6a4 4 0 0 1 0-8h4z" />
                </button>
                {more && <Button words={unit} aria-label={about(unit, t("show lengths in {unit}", { unit: other }))} title={t("Show lengths in {unit}", { unit: other })} onClick={() => change({ unit: other })} />}
                {more && <Button words={t("Present")} class="large" title={t("Shows the stage alone (F); Escape ends it")} onClick={() => present(true)} />}
                <Button words={t("More")} title={t("Shows all tools, numbers and settings")} aria-pressed={more} onClick={() => change({ more: !more })} />
                <Button words={t("Copy link")} onClick={() => void attempt(copyLink)} />
            </div>
        </header>
    );
}

/** Chosen again, its sheet is closed. */
function go(tab: Plan["tab"]) {
    sheet.value = sheet.value === "forms" && plan.value.tab === tab ? null : "forms";
    report.value = null;
    change({ tab });
}

async function copyLink() {
    await copy(await link("?view"));
    const files = unlinked(plan.value).map((name) => `"${name}"`).join(t(" and "));
    const holds = files ? t("It does not hold {files}: who opens it elsewhere needs the file.", { files }) : t("It holds the whole scene.");
    said.value = [t("The link is copied."), holds, onlyHere].filter(Boolean).join(" ");
}

const PANELS: Partial<Record<Plan["tab"], () => JSX.Element>> = { start: StartTab, room: RoomTab, crowd: CrowdTab, motion: MotionTab };

function Panel() {
    const shown = film.value;
    const Forms = PANELS[plan.value.tab];
    return Forms ? <Forms /> : shown && <TakeTab film={shown} />;
}

/** Whether something is dragged over the page. */
const over = signal(false);

/** On a phone, forms and numbers lie over the lower part of the stage, when they are wanted. */
const sheet = signal<"forms" | "numbers" | null>(null);

function Page() {
    const { tab, more } = plan.value;
    const shown = film.value;
    const alone = viewed || presents.value;
    const open = (which: "forms" | "numbers") => (sheet.value === which ? "sheet open" : "sheet");
    return (
        <>
            {!alone && <Button words={t("To the stage")} class="skip" onClick={() => document.querySelector<HTMLElement>(".frame canvas")?.focus()} />}
            {alone ? <Bare /> : <Header />}
            {report.value && shown ? (
                <Report film={shown} />
            ) : tab === "person" && !alone ? (
                <main class="whole">
                    <PersonTab />
                </main>
            ) : (
                <main class={alone ? `columns alone${viewed ? " view" : ""}` : more ? "columns" : "columns few"}>
                    {!alone && (
                        <div key={tab} class={open("forms")}>
                            <Panel />
                        </div>
                    )}
                    {shown ? <Stage key="stage" film={shown} /> : <Poster />}
                    {!alone && <div class={open("numbers")}>{shown && <Numbers film={shown} />}</div>}
                </main>
            )}
            <News />
            <Tour />
            <footer hidden={alone}>
                <p role="status">{said.value}</p>
                <Busy />
                <select aria-label={t("Language")} value={language} onChange={(event) => choose(event.currentTarget.value as Language)}>
                    {Object.entries(LANGUAGES).map(([key, name]) => (
                        <option key={key} value={key} lang={key}>
                            {name}
                        </option>
                    ))}
                </select>
                {more && (
                    <span class="unit">
                        {t("Computed in your browser: nothing that you open leaves this machine.")} <a href="licences.txt">{t("Licences")}</a>
                    </span>
                )}
            </footer>
            {over.value && <p class="drop">{t("Drop a zip or a folder with a Trial, a plan, or a picture")}</p>}
        </>
    );
}

/** The scene as a drawing until it is there, and how much of the lab is loaded. */
function Poster() {
    if (problem.value) return <p role="status" />;
    return (
        <div class="poster">
            <Sketch base={plan.value.made.base} />
            <p role="status">{t("One moment …")}</p>
            <progress aria-label={t("Progress")} value={client.loaded.value} />
        </div>
    );
}

/** What went wrong and what is to be known, over the stage: it moves nothing. */
function News() {
    return (
        <div class="news">
            {problem.value && (
                <div role="alert" class="problem">
                    <pre>{problem.value}</pre>
                    <Button words="×" aria-label={t("Close this message")} onClick={() => (problem.value = "")} />
                </div>
            )}
            {notes.value.length > 0 && (
                <div class="problem note">
                    <ul class="notes" aria-label={t("Notes")}>
                        {notes.value.map((note) => (
                            <li key={note}>{note}</li>
                        ))}
                    </ul>
                    <Button words="×" aria-label={t("Close these notes")} onClick={() => (notes.value = [])} />
                </div>
            )}
        </div>
    );
}

addEventListener("keydown", (event) => {
    const { target, key } = event;
    const inField = target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && ["number", "text"].includes(target.type));
    if (isUndo(event)) {
        // What is being typed, the field takes back itself.
        if (inField && target.dataset.typed === "true") return;
        event.preventDefault();
        if (key.toLowerCase() === "z" && !event.shiftKey) undo();
        else redo();
    } else if (inField) return;
    else if (key === "Escape" && presents.value) present(false);
    else if (key.toLowerCase() === "f" && !event.ctrlKey && !event.metaKey && !event.altKey) present(!presents.value);
});
document.addEventListener("fullscreenchange", () => (presents.value = document.fullscreenElement !== null));
addEventListener("dragover", (event) => {
    if (!event.dataTransfer?.types.includes("Files")) return;
    event.preventDefault();
    over.value = true;
});
addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) over.value = false;
});
addEventListener("drop", (event) => {
    over.value = false;
    const data = event.dataTransfer;
    // Dropped on a field for files, it is that field's.
    if (!data?.types.includes("Files") || (event.target instanceof HTMLInputElement && event.target.type === "file")) return;
    event.preventDefault();
    // What was dropped can be read only now.
    const files = dropped(data);
    void attempt(async () => {
        const given = await files;
        const [first] = given;
        // A plan, a picture or a scene's own file; or else a Trial.
        await (given.length === 1 && isPlan(first!.file) ? openPlan(first!.file) : openTrial(given));
    });
});

// `lemons lab` gives the page on another port each time: nothing would be found again there.
if (location.hostname !== "127.0.0.1" && !viewed) navigator.serviceWorker?.register("offline.js").catch(() => {});
begin();
follow();
keepScenes();
if (unloaded) problem.value = `The language could not be loaded: ${unloaded}`;
effect(() => void (document.title = about(title.value, t("LEMONS lab"))));
const lab = document.getElementById("lab")!;
lab.replaceChildren();
render(<Page />, lab);
