// Bundles the page into dist/, or into another folder. `build.sh` makes the WebAssembly before.
import { build } from "esbuild";
import { spawnSync } from "node:child_process";
import { existsSync } from "node:fs";
import { createHash } from "node:crypto";
import { cp, mkdir, readdir, readFile, rm, stat, writeFile } from "node:fs/promises";
import { resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const here = fileURLToPath(new URL(".", import.meta.url));
const [wasm, licences, folder = `${here}dist`] = process.argv.slice(2);
if (!licences) throw new Error("usage: node build.mjs LEMONS_LAB.wasm THIRD-PARTY.txt [FOLDER]");
const out = `${resolve(folder)}/`;
await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
const version = /^version = "(.*)"$/m.exec(await readFile(`${here}../Cargo.toml`, "utf8"))[1];
// As build.rs does it: packagers without .git set it, and a .git above belongs to another project.
const ofGit = () => existsSync(`${here}../.git`) && spawnSync("git", ["rev-parse", "--short=8", "HEAD"], { cwd: here, encoding: "utf8" }).stdout?.trim();
const commit = process.env.LEMONS_COMMIT ?? ofGit();
await build({
    define: { __VERSION__: JSON.stringify(commit ? `${version} (${commit})` : version), __WASM_BYTES__: String((await stat(wasm)).size) },
    // The page's CSS is of the modules that it imports; `style.css` is loaded before.
    entryPoints: { page: "src/page.tsx", worker: "src/worker.ts" },
    outdir: out,
    bundle: true,
    minify: true,
    format: "esm",
    // What is imported when it is needed (three.js) becomes files of its own.
    splitting: true,
    chunkNames: "[name]-[hash]",
    target: "es2022",
    jsx: "automatic",
    jsxImportSource: "preact",
    legalComments: "linked",
    absWorkingDir: here,
});
for (const file of ["index.html", "icon.svg", "style.css", "offline.js"]) await cp(`${here}src/${file}`, out + file);
await cp(wasm, `${out}lemons_lab.wasm`);
await cp(licences, `${out}licences.txt`);

// The build is part of addresses: a browser cannot mix two of them.
const files = (await readdir(out)).sort();
const hash = createHash("sha256");
for (const file of files) hash.update(await readFile(out + file));
const stamp = hash.digest("hex").slice(0, 16);
const named = ["page.js", "page.css", "style.css", "worker.js", "lemons_lab.wasm"];
const addresses = ["./", ...files.filter((file) => !["index.html", "offline.js"].includes(file)).map((file) => (named.includes(file) ? `${file}?${stamp}` : file))];
for (const file of files.filter((name) => /\.(html|js)$/.test(name))) {
    const text = await readFile(out + file, "utf8");
    await writeFile(out + file, text.replaceAll("__BUILD__", stamp).replaceAll("__FILES__", addresses.join(" ")));
}
// For hosts that give compressed files, and for `lemons lab`.
for (const file of files.filter((name) => name !== "offline.js")) await writeFile(`${out}${file}.gz`, gzipSync(await readFile(out + file), { level: 9 }));
