// Files that the user opens: a zip or a folder, chosen or dropped. They stay on this machine.

import { MOST } from "./forms";
import { t } from "./language";
import { keysInUse, plan } from "./plan";
import { open } from "./scenes";
import { attempt, said } from "./session";
import { joined, keep, remove } from "./store";

const MOST_BYTES = 50e6;
const MOST_DEPTH = 10;

export interface Given {
    path: string;
    file: File;
}

/** Why a file is not taken whose name would not be there again after a reload. */
export function tooLong(name: string): string {
    return t('the name "{name}…" has more than {most} letters', { name: name.slice(0, 20), most: MOST.name });
}

/** Files as a request holds them, kept for a reload. */
export async function taken(given: File[]): Promise<string> {
    const size = given.reduce((sum, file) => sum + file.size, 0);
    if (size > MOST_BYTES) throw new Error(t("{name}: more than {most} MB", { name: given.length === 1 ? given[0]!.name : t("the files"), most: MOST_BYTES / 1e6 }));
    return keep(await joined(given), keysInUse());
}

/** Shows the Trial in a zip, or in the files of a folder. */
export async function openTrial(given: Given[]) {
    const first = given[0];
    if (!first) throw new Error(t("there is no file in it"));
    if (given.length > MOST.files) throw new Error(t("more than {most} files: a Trial has fewer than ten", { most: MOST.files }));
    const name = first.path.split("/")[0]!;
    // What is longer would not be there again after a reload.
    const long = given.find(({ path }) => path.length > MOST.path);
    if (name.length > MOST.name) throw new Error(tooLong(name));
    if (long) throw new Error(t('the path "{path}…" has more than {most} letters', { path: long.path.slice(0, 40), most: MOST.path }));
    const { made } = plan.value;
    const key = await taken(given.map(({ file }) => file));
    if (plan.value.made !== made) {
        said.value = t('"{name}" was not opened: another scene was chosen meanwhile.', { name });
        return remove(key);
    }
    const files = given.map(({ path, file }) => [path, file.size] as [string, number]);
    open(name, { base: { kind: "upload", name, files, key }, edits: [], motion: { kind: "own" } }, false, plan.value.crowd, true);
}

interface FileProps {
    label: string;
    accept?: string;
    folder?: boolean;
    several?: boolean;
    onFiles(given: Given[]): Promise<void>;
}

export function FileInput({ label, accept, folder, several, onFiles }: FileProps) {
    return (
        <label class="upload">
            {label}
            <input
                type="file"
                accept={accept}
                {...{ webkitdirectory: folder }}
                multiple={several}
                onChange={(event) => {
                    // Those of a folder know their path.
                    const files = [...(event.currentTarget.files ?? [])];
                    event.currentTarget.value = "";
                    const given = files.map((file) => ({ path: file.webkitRelativePath || file.name, file }));
                    if (given.length > 0) void attempt(() => onFiles(given));
                }}
            />
        </label>
    );
}

/** What was dropped: files, or folders with all that is in them. */
export async function dropped(data: DataTransfer): Promise<Given[]> {
    const files = [...data.files];
    const entries = [...data.items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
    const found: Given[] = [];
    // Some browsers tell no folders, only files.
    if (entries.length === 0) return files.map((file) => ({ path: file.name, file }));
    for (const entry of entries) await collect(entry, entry.name, found, 0);
    return found;
}

async function collect(entry: FileSystemEntry, path: string, found: Given[], depth: number) {
    if (found.length > MOST.files || depth > MOST_DEPTH) throw new Error(t("more than {most} files, or folders in folders too deep", { most: MOST.files }));
    if (entry.isFile) {
        const file = await new Promise<File>((done, failed) => (entry as FileSystemFileEntry).file(done, failed));
        found.push({ path, file });
        return;
    }
    const reader = (entry as FileSystemDirectoryEntry).createReader();
    // It gives some at a time.
    for (;;) {
        const some = await new Promise<FileSystemEntry[]>((done, failed) => reader.readEntries(done, failed));
        if (some.length === 0) return;
        for (const one of some) await collect(one, `${path}/${one.name}`, found, depth + 1);
    }
}

