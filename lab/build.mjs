// Bundles the page into dist/. `build.sh` makes the WebAssembly before.
import { build } from "esbuild";
import { cp, mkdir, readFile, rm, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";

const here = fileURLToPath(new URL(".", import.meta.url));
const out = `${here}dist/`;
const [wasm, licences] = process.argv.slice(2);
if (!licences) throw new Error("usage: node build.mjs LEMONS_LAB.wasm THIRD-PARTY.txt");
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
    absWorkingDir: here,
});
for (const file of ["index.html", "icon.svg", "style.css"]) await cp(`${here}src/${file}`, out + file);
await cp(wasm, `${out}lemons_lab.wasm`);
// What is bundled from npm, and its licences; then what is in the WebAssembly.
const parts = [];
for (const name of ["preact", "@preact/signals", "@preact/signals-core"]) {
    const { version } = JSON.parse(await readFile(`${here}node_modules/${name}/package.json`, "utf8"));
    parts.push(`${name} ${version}\n\n${await readFile(`${here}node_modules/${name}/LICENSE`, "utf8")}`);
}
const line = `\n${"-".repeat(80)}\n\n`;
await writeFile(`${out}licences.txt`, [...parts, await readFile(licences, "utf8")].join(line));
