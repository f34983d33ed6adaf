// A movie of the frames that were computed, encoded by the browser: each picture at its time, however long it takes.

import type { Film } from "./film";
import { t } from "./language";
import { canvas } from "./layout";
import { compose } from "./picture";

/** VP9 in 8 bits, for pictures up to 4096 × 2176. */
const CODEC = "vp09.00.50.08";
const BITS_PER_SECOND = 8e6;
/** Pictures in a second. */
const RATE = 30;
/** Pictures that may wait for the encoder, and from one that needs no other to the next. */
const [WAITING, APART] = [4, 60];
/** Seconds that the last picture stays, or players would not show it. */
const STAY = 0.25;

/** Why the browser makes no movies; empty if it does. */
export function whyNoMovie(): string {
    return "VideoEncoder" in globalThis ? "" : t("This browser cannot record a canvas.");
}

/** All frames once, at a pace for each: simulated seconds in a second; null if it was stopped. `tell` hears which share is there. */
export async function movie(film: Film, paceAt: (frame: number) => number, tell: (share: number) => void, stop: AbortSignal): Promise<Blob | null> {
    const { ArrayBufferTarget, Muxer } = await import("webm-muxer");
    const picture = document.createElement("canvas");
    const end = film.reached.value;
    const paint = (place: number) => {
        void film.show(place);
        if (canvas.value) compose(picture, canvas.value, film);
    };
    paint(0);
    const { width, height } = picture;
    const muxer = new Muxer({ target: new ArrayBufferTarget(), video: { codec: "V_VP9", width, height, frameRate: RATE } });
    let failed: Error | null = null;
    const encoder = new VideoEncoder({ output: (chunk, meta) => muxer.addVideoChunk(chunk, meta), error: (error) => (failed = error) });
    encoder.configure({ codec: CODEC, width, height, bitrate: BITS_PER_SECOND, framerate: RATE });
    const encode = (seconds: number, keyFrame: boolean) => {
        const frame = new VideoFrame(picture, { timestamp: 1e6 * seconds });
        encoder.encode(frame, { keyFrame });
        frame.close();
    };
    for (let [k, place] = [0, -1]; place < end; k++) {
        place = k === 0 ? 0 : Math.min(end, place + paceAt(place) / RATE / film.scene.step);
        paint(place);
        encode(k / RATE, k % APART === 0);
        if (place === end) encode(k / RATE + STAY, false);
        tell(place / end);
        // The page is heard meanwhile.
        do await new Promise((done) => setTimeout(done));
        while (encoder.encodeQueueSize > WAITING);
        if (failed) throw failed;
        if (stop.aborted || film.over) break;
    }
    await encoder.flush();
    encoder.close();
    muxer.finalize();
    return stop.aborted || film.over ? null : new Blob([muxer.target.buffer], { type: "video/webm" });
}
