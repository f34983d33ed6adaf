// The lab in WebAssembly: how it is loaded and asked, in the worker and in the page.

import type { Request } from "./protocol";

export interface Lab {
    memory: WebAssembly.Memory;
    lab_room(length: number): number;
    lab_ask(): number;
    lab_length(): number;
}

type Watch = (stage: number, iteration: number, limit: number, overlap: number, density: number) => number;

/** Hosts say how long the file is as it is sent, which may be compressed. */
declare const __WASM_BYTES__: number;

/** Tells how many bytes have come. */
async function count(body: ReadableStream<Uint8Array>, tell: (share: number) => void) {
    const reader = body.getReader();
    let read = 0;
    for (let part = await reader.read(); !part.done; part = await reader.read()) tell((read += part.value.length) / __WASM_BYTES__);
}

/** `build` ends the address: that of this page. */
export async function compile(build: string, tell: (share: number) => void): Promise<WebAssembly.Module> {
    const file = await fetch(`lemons_lab.wasm${build}`);
    if (!file.ok) throw new Error(`lemons_lab.wasm: the host answers ${file.status}`);
    // What breaks off here does so below, too.
    count(file.clone().body!, tell).catch(() => {});
    // Some hosts give another type, which only the slower way takes.
    const typed = file.headers.get("Content-Type")?.startsWith("application/wasm");
    return typed ? WebAssembly.compileStreaming(file) : WebAssembly.compile(await file.arrayBuffer());
}

/** `lab_progress` is called during long work; it returns whether to stop. */
export async function load(module: WebAssembly.Module, lab_progress: Watch): Promise<Lab> {
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
