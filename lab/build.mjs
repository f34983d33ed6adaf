// Bundles the page into dist/, or into another folder. `build.sh` makes the WebAssembly before.
import { build } from "esbuild";
import { cp, mkdir, rm } from "node:fs/promises";
import { resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = fileURLToPath(new URL(".", import.meta.url));
const [wasm, licences, folder = `${here}dist`] = process.argv.slice(2);
if (!licences) throw new Error("usage: node build.mjs LEMONS_LAB.wasm THIRD-PARTY.txt [FOLDER]");
const out = `${resolve(folder)}/`;
await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
await build({
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
for (const file of ["index.html", "icon.svg", "style.css"]) await cp(`${here}src/${file}`, out + file);
await cp(wasm, `${out}lemons_lab.wasm`);
await cp(licences, `${out}licences.txt`);
