// Bundles the page into dist/. `build.sh` makes the WebAssembly before.
import { build } from "esbuild";
import { cp, mkdir, rm } from "node:fs/promises";

const out = new URL("dist/", import.meta.url).pathname;
const wasm = process.argv[2];
if (!wasm) throw new Error("usage: node build.mjs LEMONS_LAB.wasm");
await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
await build({
    entryPoints: { page: "src/page.tsx", worker: "src/worker.ts" },
    outdir: out,
    bundle: true,
    minify: true,
    format: "esm",
    target: "es2022",
    jsx: "automatic",
    jsxImportSource: "preact",
    legalComments: "linked",
    absWorkingDir: new URL(".", import.meta.url).pathname,
});
for (const file of ["index.html", "icon.svg", "style.css"]) await cp(new URL(`src/${file}`, import.meta.url), out + file);
await cp(wasm, `${out}lemons_lab.wasm`);
