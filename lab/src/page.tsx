// The page: its parts and what is above them.

import { signal } from "@preact/signals";
import { render } from "preact";
import { Busy } from "./busy";
import { CrowdTab } from "./crowd";
import { canvas } from "./layout";
import { MotionTab } from "./motion";
import { PersonTab } from "./person";
import { canRedo, canUndo, change, link, type Plan, plan, redo, undo, unlinked } from "./plan";
import { RoomTab } from "./room";
import { attempt, begin, client, film, notes, problem, said } from "./session";
import { Stage } from "./stage";
import { StartTab } from "./start";
import { TakeTab } from "./take";
import { dropped, openTrial } from "./upload";

const TABS: [Plan["tab"], string][] = [
    ["start", "Start"],
    ["room", "Room"],
    ["crowd", "Crowd"],
    ["motion", "Motion"],
    ["person", "Person"],
    ["take", "Take away"],
];

function Header() {
    const { tab, unit } = plan.value;
    return (
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
                <button type="button" onClick={() => void attempt(copyLink)}>
                    Copy link
                </button>
            </div>
        </header>
    );
}

async function copyLink() {
    if (!navigator.clipboard) throw new Error(`This browser copies nothing from such a page; the link is ${link()}`);
    await navigator.clipboard.writeText(link());
    const files = unlinked(plan.value).join(" and ");
    said.value = files ? `The link is copied. It does not hold ${files}: who opens it elsewhere needs the file.` : "The link is copied. It holds the whole scene.";
}

function Panel() {
    const shown = film.value;
    switch (plan.value.tab) {
        case "start":
            return <StartTab />;
        case "room":
            return <RoomTab />;
        case "crowd":
            return <CrowdTab />;
        case "motion":
            return <MotionTab />;
        default:
            return shown && <TakeTab film={shown} client={client} canvas={() => canvas.value} said={(words) => (said.value = words)} />;
    }
}

/** Whether something is dragged over the page. */
const over = signal(false);

function Page() {
    const { tab } = plan.value;
    const shown = film.value;
    return (
        <>
            <Header />
            <main>
                <div class="news">
                    <p role="status">{said.value}</p>
                    <Busy />
                </div>
                {problem.value && (
                    <div role="alert" class="problem">
                        <pre>{problem.value}</pre>
                        <button type="button" aria-label="Close this message" onClick={() => (problem.value = "")}>
                            ×
                        </button>
                    </div>
                )}
                {notes.value.length > 0 && (
                    <ul class="notes" aria-label="Notes">
                        {notes.value.map((note) => (
                            <li key={note}>{note}</li>
                        ))}
                    </ul>
                )}
                {tab === "person" ? (
                    <PersonTab client={client} />
                ) : (
                    <div class="columns">
                        <Panel />
                        {shown ? <Stage key="stage" film={shown} /> : <p role="status">{problem.value ? "" : "One moment …"}</p>}
                    </div>
                )}
            </main>
            <footer>
                Computed in your browser: nothing that you open leaves this machine. <a href="licences.txt">Licences</a>
            </footer>
            {over.value && <p class="drop">Drop a zip or a folder with a Trial</p>}
        </>
    );
}

addEventListener("keydown", (event) => {
    // In a field they are the field's own.
    const typing = event.target instanceof HTMLInputElement && event.target.type === "number";
    if (typing) return;
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !event.shiftKey) undo();
    else if ((event.ctrlKey || event.metaKey) && (event.key === "y" || event.key.toLowerCase() === "z")) redo();
});
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
    void attempt(async () => openTrial(await files));
});

begin();
render(<Page />, document.getElementById("lab")!);
