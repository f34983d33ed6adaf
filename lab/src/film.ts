// A run: frames that were computed, and which of them is shown. It asks for further ones while it plays.

import { batch, signal } from "@preact/signals";
import { type Client, Stopped } from "./client";
import { Frames } from "./frames";
import type { Advanced, Scene } from "./protocol";

/** Bytes of frames that are kept; then the run ends. */
const MOST_BYTES = 800e6;
/** Seconds that an answer should take, so that the page is heard between them. */
const ANSWER = 0.03;

export class Film {
    readonly playing = signal(false);
    /** The frame that is shown, from 0. */
    readonly shown = signal(0);
    /** As `shown`, with the fraction of a frame: `frameAt` moves smoothly with it. */
    readonly place = signal(0);
    readonly computed = signal(1);
    readonly advanced = signal<Advanced | null>(null);
    /** The first frame in which all have left who have an exit; null: none yet. */
    readonly emptied = signal<number | null>(null);
    /** Processor time for a communication step. */
    readonly cost = signal(ANSWER);
    readonly failed = signal<string | null>(null);
    /** Simulated seconds in a second that were really shown. */
    readonly pace = signal(0);
    readonly frames: Frames;
    #asking = false;
    #old = false;
    #generation: number;

    constructor(
        readonly client: Client,
        readonly scene: Scene,
        first: ArrayBuffer,
    ) {
        this.frames = new Frames(scene.agents.length);
        this.frames.add(new Float64Array(first), 1);
        this.#generation = client.generation;
        this.#look();
    }

    /** Another film took its place, or its worker ended. */
    get over() {
        return this.#old || this.#generation !== this.client.generation;
    }

    /** Its numbers, not to be changed. */
    frame(k: number): Float32Array {
        return this.frames.frame(k);
    }

    /** Between two frames; valid until the next call. */
    frameAt(place: number): Float32Array {
        return this.frames.at(place);
    }

    /** For each agent the mean squeeze over the last seconds up to frame `k`; valid until the next call. */
    squeezeMean(k: number, seconds: number): Float64Array {
        return this.frames.squeezeMean(k, Math.max(1, Math.round(seconds / this.scene.step)));
    }

    /** The part of that mean of an agent by walls. */
    wallMean(k: number, seconds: number, agent: number): number {
        return this.frames.wallMean(k, Math.max(1, Math.round(seconds / this.scene.step)), agent);
    }

    get most() {
        return Math.floor(MOST_BYTES / this.frames.bytes);
    }

    /** Whether all have left. */
    #look() {
        const { leaving } = this.scene;
        const left = this.frames.curve("left");
        if (leaving === 0 || this.emptied.value !== null || left.at(-1)! < leaving) return;
        this.emptied.value = left.findIndex((count) => count >= leaving);
    }

    /** Computes until there are at least this many frames. */
    async until(count: number) {
        while (this.frames.count < Math.min(count, this.most) && !this.over && !this.failed.value) await this.#ask(count);
    }

    async #ask(wanted: number) {
        if (this.over) return;
        if (this.#asking) return new Promise((done) => setTimeout(done, 5));
        this.#asking = true;
        const most = Math.max(1, Math.floor(ANSWER / Math.max(this.cost.value, 1e-4)));
        const steps = Math.max(1, Math.min(most, wanted - this.frames.count, 1000));
        try {
            const { value, bytes, seconds } = await this.client.ask<Advanced>({ ask: "advance", run: this.scene.run, steps });
            if (this.over) return;
            this.frames.add(new Float64Array(bytes), steps);
            batch(() => {
                this.advanced.value = value;
                this.cost.value = seconds / steps;
                this.computed.value = this.frames.count;
                this.#look();
            });
        } catch (error) {
            if (!this.over && !(error instanceof Stopped)) this.failed.value = `the run ended: ${(error as Error).message}`;
            this.playing.value = false;
        } finally {
            this.#asking = false;
        }
    }

    /** Goes on by real seconds. Called for each picture while it plays. */
    tick(seconds: number, pace: number) {
        const from = this.place.value;
        const wanted = from + (seconds * pace) / this.scene.step;
        const emptied = this.emptied.value;
        if (emptied !== null && from < emptied && wanted >= emptied) {
            // The run ends here. Who plays it again sees how it goes on.
            return this.show(emptied);
        }
        const there = this.frames.count - 1;
        const smooth = 0.9;
        const real = seconds > 0 ? ((Math.min(wanted, there) - from) * this.scene.step) / seconds : 0;
        batch(() => {
            this.#go(wanted);
            this.pace.value = smooth * this.pace.value + (1 - smooth) * real;
        });
        if (this.frames.count >= this.most) {
            if (this.shown.value >= there) {
                this.playing.value = false;
                this.failed.value = `the run ends here, at ${(there * this.scene.step).toFixed(2)} s: its frames fill ${MOST_BYTES / 1e6} MB`;
            }
            return;
        }
        const ahead = Math.ceil((0.3 * pace) / this.scene.step) + 2;
        if (!this.#asking && there < wanted + ahead) void this.#ask(Math.ceil(wanted) + ahead + 1);
    }

    #go(place: number) {
        const within = Math.max(0, Math.min(place, this.frames.count - 1));
        batch(() => {
            this.place.value = within;
            this.shown.value = Math.floor(within);
        });
    }

    /** Shows a place among the frames that are there; nothing plays then. */
    show(place: number) {
        this.playing.value = false;
        this.#go(place);
    }

    async next() {
        const k = this.shown.value + 1;
        this.playing.value = false;
        await this.until(k + 1);
        this.show(k);
    }

    /** Another film takes its place. */
    end() {
        this.#old = true;
        this.playing.value = false;
    }
}
