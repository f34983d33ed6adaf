// The lab in WebAssembly: how it is loaded and asked, in the worker and in the page.

import type { Request } from "./protocol";

export interface Lab {
    memory: WebAssembly.Memory;
    lab_room(length: number): number;
    lab_ask(): number;
    lab_length(): number;
}

type Watch = (stage: number, iteration: number, limit: number, overlap: number, density: number) => number;

/** `lab_progress` is called during long work; it returns whether to stop. `build` ends the address: that of this page. */
export async function load(lab_progress: Watch, build: string): Promise<Lab> {
    const file = await fetch(`lemons_lab.wasm${build}`);
    if (!file.ok) throw new Error(`lemons_lab.wasm: the host answers ${file.status}`);
    // Some hosts give another type, which only the slower way takes.
    const typed = file.headers.get("Content-Type")?.startsWith("application/wasm");
    const module = await (typed ? WebAssembly.compileStreaming(file) : file.arrayBuffer().then((bytes) => WebAssembly.compile(bytes)));
    // A library asks for functions of wasm-bindgen that nobody calls.
    const imports: Record<string, Record<string, () => never>> = {};
    for (const { module: from, name } of WebAssembly.Module.imports(module)) {
        (imports[from] ??= {})[name] = () => {
            throw new Error(`${from}.${name} is not there`);
        };
    }
    const page = { page: { lab_progress } };
    const instance = await WebAssembly.instantiate(module, { ...imports, ...page });
    return instance.exports as unknown as Lab;
}

/** JSON with its length before it, then bytes, as crates/lab/src/boundary.rs reads them. */
export function answer(lab: Lab, request: Request, bytes: Uint8Array = new Uint8Array()) {
    const text = new TextEncoder().encode(JSON.stringify(request));
    const place = lab.lab_room(4 + text.length + bytes.length) >>> 0;
    new DataView(lab.memory.buffer).setUint32(place, text.length, true);
    const room = new Uint8Array(lab.memory.buffer, place);
    room.set(text, 4);
    room.set(bytes, 4 + text.length);
    const at = lab.lab_ask() >>> 0;
    const end = at + (lab.lab_length() >>> 0);
    const length = new DataView(lab.memory.buffer).getUint32(at, true);
    const value = JSON.parse(new TextDecoder().decode(new Uint8Array(lab.memory.buffer, at + 4, length)));
    return { value, bytes: lab.memory.buffer.slice(at + 4 + length, end) };
}
