// The visitor's scenes as a list, and the name of the one on the stage.

import { titled } from "./examples";
import { t } from "./language";
import { Button, Field, save } from "./parts";
import { canUndo, deleted, NAME, scene, title } from "./plan";
import { bringBack, duplicate, file, openFile, openKept, remove, rename, scenes, unkept } from "./scenes";
import { Sketch } from "./sketch";
import { FileInput } from "./upload";

/** The name of the scene, and whether it is kept. */
export function Title() {
    const { id } = scene.value;
    const state = unkept.value ? t("not saved") : id !== null ? t("saved") : canUndo.value ? t("not saved") : t("not saved yet");
    const words = unkept.value ? t("Not saved: {why}.", { why: unkept.value }) : id !== null ? t("Saved in this browser.") : t("It is saved in this browser when you change it.");
    return (
        <div class="name">
            <Field type="text" aria-label={t("Name of the scene")} value={title.value} maxLength={NAME} onChange={(event) => rename(event.currentTarget.value)} />
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
            <h2>{t("Your scenes")}</h2>
            {unkept.value && (
                <p class="warning">{t("The scene on the stage is not saved: {why}. Save it as a file.", { why: unkept.value })}</p>
            )}
            {all.length === 0 && <p class="note">{t("None yet: a scene is kept in this browser as soon as you change it.")}</p>}
            <ul class="scenes" aria-label={t("Your scenes")}>
                {all.map(({ id, kept }) => (
                    <li key={id}>
                        <button type="button" class="card" aria-pressed={scene.value.id === id} onClick={() => openKept(id, kept)}>
                            <Sketch base={kept.plan.made.base} />
                            <strong>{titled(kept.name)}</strong>
                            <span>{new Date(kept.changed).toLocaleString()}</span>
                        </button>
                        <div class="buttons">
                            <Button words={t("Copy")} aria-label={t('Copy "{name}"', { name: titled(kept.name) })} onClick={() => duplicate(kept)} />
                            <Button words={t("Delete")} aria-label={t('Delete "{name}"', { name: titled(kept.name) })} onClick={() => remove(id)} />
                        </div>
                    </li>
                ))}
            </ul>
            {deleted.value && (
                <p class="note">
                    {t('"{name}" is deleted.', { name: titled(deleted.value.name) })}{" "}
                    <Button words={t("Bring it back")} onClick={bringBack} />
                </p>
            )}
            <Button words={t("Save the scene as a file")} onClick={() => save(...file())} />
            <FileInput label={t("Open a scene's file")} accept=".json,application/json" onFiles={async ([given]) => given && openFile(given.file)} />
        </>
    );
}
