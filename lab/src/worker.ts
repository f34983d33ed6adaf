// Computes: asks the lab in WebAssembly, one request after the other.

import type { Asked, Progress, Request, Told } from "./protocol";

interface Lab {
    memory: WebAssembly.Memory;
    lab_room(length: number): number;
    lab_ask(): number;
    lab_length(): number;
}

let current = 0;
let told = 0;

function say(message: Told, transfer: Transferable[] = []) {
    postMessage(message, { transfer });
}

/** Called while people are placed. The page stops a placing by ending this worker. */
function lab_progress(stage: number, iteration: number, limit: number, overlap: number, density: number) {
    const now = performance.now();
    if (now - told > 50) {
        told = now;
        const progress: Progress = { stage, iteration, limit, overlap, density };
        say({ id: current, progress });
    }
    return 0;
}

async function load(): Promise<Lab> {
    const module = await WebAssembly.compileStreaming(fetch("lemons_lab.wasm"));
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

const lab = load();

/** JSON with its length before it, then bytes, as crates/lab/src/boundary.rs reads them. */
function answer(lab: Lab, request: Request, bytes: Uint8Array) {
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

onmessage = async ({ data }: MessageEvent<Asked>) => {
    try {
        const loaded = await lab;
        current = data.id;
        const begun = performance.now();
        const { value, bytes } = answer(loaded, data.request, data.bytes ?? new Uint8Array());
        if ("refused" in value) say({ id: data.id, refused: value.refused });
        else say({ id: data.id, value: value.ok, bytes, seconds: (performance.now() - begun) / 1000 }, [bytes]);
    } catch (error) {
        say({ broken: String(error) });
    }
};
