// A movie of the frames that were computed, recorded by the browser while they are shown.

import type { Film } from "./film";
import { t } from "./language";
import { canvas } from "./layout";
import { compose } from "./picture";
import { withDuration } from "./webm";

const KINDS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];
const BITS_PER_SECOND = 8e6;
/** Seconds that the last picture stays, or players would not show it. */
const STAY = 0.25;

/** Why the browser records no movies; empty if it does. */
export function whyNoMovie(): string {
    if (!("MediaRecorder" in globalThis) || !HTMLCanvasElement.prototype.captureStream) return t("This browser cannot record a canvas.");
    return KINDS.some((kind) => MediaRecorder.isTypeSupported(kind)) ? "" : t("This browser does not record WebM.");
}

export class Movie {
    #stopped = false;

    constructor(
        readonly film: Film,
        /** Simulated seconds in a second. */
        readonly pace: number,
        /** Is told which share is recorded. */
        readonly tell: (share: number) => void,
    ) {}

    stop() {
        this.#stopped = true;
    }

    /** Plays all frames once; null if it was stopped. */
    async record(): Promise<Blob | null> {
        const { film } = this;
        const picture = document.createElement("canvas");
        const paint = () => {
            if (canvas.value) compose(picture, canvas.value, film);
        };
        void film.show(0);
        await nextPicture();
        paint();
        const stream = picture.captureStream();
        const recorder = new MediaRecorder(stream, {
            mimeType: KINDS.find((kind) => MediaRecorder.isTypeSupported(kind)),
            videoBitsPerSecond: BITS_PER_SECOND,
        });
        const parts: Blob[] = [];
        recorder.ondataavailable = ({ data }) => parts.push(data);
        const ended = new Promise<void>((done, failed) => {
            recorder.onstop = () => done();
            recorder.onerror = () => failed(new Error(t("the browser could not record the movie")));
        });
        // No pictures come while the page is hidden.
        let [recorded, since] = [0, 0];
        const hidden = () => {
            if (document.hidden && recorder.state === "recording") {
                recorder.pause();
                recorded += performance.now() - since;
            } else if (!document.hidden && recorder.state === "paused") {
                recorder.resume();
                since = performance.now();
            }
        };
        document.addEventListener("visibilitychange", hidden);
        recorder.start(1000);
        since = performance.now();
        try {
            await this.#play(paint);
            if (!this.#stopped) await new Promise((done) => setTimeout(done, 1000 * STAY));
        } finally {
            document.removeEventListener("visibilitychange", hidden);
            if (recorder.state === "recording") recorded += performance.now() - since;
            if (recorder.state !== "inactive") recorder.stop();
            for (const track of stream.getTracks()) track.stop();
        }
        await ended;
        return this.#stopped || this.film.over ? null : withDuration(new Blob(parts, { type: "video/webm" }), recorded / 1000);
    }

    async #play(paint: () => void) {
        const { film, pace } = this;
        const end = film.reached.value;
        let place = 0;
        let before = await nextPicture();
        while (!this.#stopped && !film.over && place < end) {
            const now = await nextPicture();
            // After a pause, it goes on where it was.
            place = Math.min(end, place + (Math.min(0.25, (now - before) / 1000) * pace) / film.scene.step);
            before = now;
            void film.show(place);
            paint();
            this.tell(end ? place / end : 1);
        }
    }
}

function nextPicture() {
    return new Promise<number>((done) => requestAnimationFrame(done));
}
