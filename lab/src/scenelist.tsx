// The visitor's scenes as a list, and the name of the one on the stage.

import { Field, save } from "./parts";
import { canUndo, deleted, NAME, scene } from "./plan";
import { bringBack, duplicate, file, openFile, openKept, remove, rename, scenes, unkept } from "./scenes";
import { Sketch } from "./sketch";
import { FileInput } from "./upload";

/** The name of the scene, and whether it is kept. */
export function Title() {
    const { id, name } = scene.value;
    const state = unkept.value ? "not saved" : id !== null ? "saved" : canUndo.value ? "not saved" : "not saved yet";
    const words = unkept.value ? `Not saved: ${unkept.value}.` : id !== null ? "Saved in this browser." : "It is saved in this browser when you change it.";
    return (
        <div class="name">
            <Field type="text" aria-label="Name of the scene" value={name} maxLength={NAME} onChange={(event) => rename(event.currentTarget.value)} />
            <span class={unkept.value ? "state bad" : "state"} role="status" title={words}>
                {state}
            </span>
        </div>
    );
}

export function Scenes() {
    const all = scenes.value;
    return (
        <>
            <h2>Your scenes</h2>
            {unkept.value && (
                <p class="warning">
                    The scene on the stage is not saved: {unkept.value}. Save it as a file.
                </p>
            )}
            {all.length === 0 && <p class="note">None yet: a scene is kept in this browser as soon as you change it.</p>}
            <ul class="scenes" aria-label="Your scenes">
                {all.map(({ id, kept }) => (
                    <li key={id}>
                        <button type="button" class="card" aria-pressed={scene.value.id === id} onClick={() => openKept(id, kept)}>
                            <Sketch base={kept.plan.made.base} />
                            <strong translate={false}>{kept.name}</strong>
                            <span translate={false}>{new Date(kept.changed).toLocaleString()}</span>
                        </button>
                        <div class="buttons">
                            <button type="button" aria-label={`Copy "${kept.name}"`} onClick={() => duplicate(kept)}>
                                Copy
                            </button>
                            <button type="button" aria-label={`Delete "${kept.name}"`} onClick={() => remove(id)}>
                                Delete
                            </button>
                        </div>
                    </li>
                ))}
            </ul>
            {deleted.value && (
                <p class="note">
                    {`"${deleted.value.name}" is deleted.`}{" "}
                    <button type="button" onClick={bringBack}>
                        Bring it back
                    </button>
                </p>
            )}
            <button type="button" onClick={() => save(...file())}>
                Save the scene as a file
            </button>
            <FileInput label="Open a scene's file" accept=".json,application/json" onFiles={async ([given]) => given && openFile(given.file)} />
        </>
    );
}
