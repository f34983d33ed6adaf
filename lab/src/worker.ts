// Computes: asks the lab in WebAssembly, one request after the other.

import type { Asked, Progress, Told } from "./protocol";
import { answer, compile, load } from "./wasm";

let current = 0;
let told = 0;

function say(message: Told, transfer: Transferable[] = []) {
    postMessage(message, { transfer });
}

/** Called during long work. The page stops it by ending this worker. */
function lab_progress(stage: number, iteration: number, limit: number, overlap: number, density: number) {
    const now = performance.now();
    if (now - told > 50) {
        told = now;
        const progress: Progress = { stage, iteration, limit, overlap, density };
        say({ id: current, progress });
    }
    return 0;
}

const lab = compile(location.search, (loading) => say({ loading })).then((module) => {
    say({ module });
    return load(module, lab_progress);
});

onmessage = async ({ data }: MessageEvent<Asked>) => {
    try {
        const loaded = await lab;
        current = data.id;
        const begun = performance.now();
        const { value, bytes } = answer(loaded, data.request, data.bytes);
        if ("refused" in value) say({ id: data.id, refused: value.refused });
        else say({ id: data.id, value: value.ok, bytes, seconds: (performance.now() - begun) / 1000 }, [bytes]);
    } catch (error) {
        say({ broken: String(error) });
    }
};
