// A run: frames that were computed, and which of them is shown. It asks for further ones while it plays.

import { batch, signal } from "@preact/signals";
import { type Client, Stopped } from "./client";
import { type Advanced, COLUMNS, type Scene } from "./protocol";

/** Bytes of frames that are kept; then the run ends. */
const MOST_BYTES = 400e6;
/** Seconds that an answer should take, so that the page is heard between them. */
const ANSWER = 0.03;

export class Film {
    readonly playing = signal(false);
    /** The frame that is shown, from 0. */
    readonly shown = signal(0);
    readonly computed = signal(1);
    readonly advanced = signal<Advanced | null>(null);
    /** Processor time for a communication step. */
    readonly cost = signal(ANSWER);
    readonly failed = signal<string | null>(null);
    /** Simulated seconds in a second that were really shown. */
    readonly pace = signal(0);
    #frames: Float64Array[];
    #asking = false;
    #place = 0;
    #old = false;
    #generation: number;

    constructor(
        readonly client: Client,
        readonly scene: Scene,
        first: ArrayBuffer,
    ) {
        this.#frames = [new Float64Array(first)];
        this.#generation = client.generation;
    }

    /** Another film took its place, or its worker ended. */
    get over() {
        return this.#old || this.#generation !== this.client.generation;
    }

    frame(k: number): Float64Array {
        return this.#frames[Math.min(k, this.#frames.length - 1)]!;
    }

    get most() {
        return Math.floor(MOST_BYTES / (8 * COLUMNS * this.scene.agents.length));
    }

    /** Computes until there are at least this many frames. */
    async until(count: number) {
        while (this.#frames.length < Math.min(count, this.most) && !this.over && !this.failed.value) await this.#ask(count);
    }

    async #ask(wanted: number) {
        if (this.over) return;
        if (this.#asking) return new Promise((done) => setTimeout(done, 5));
        this.#asking = true;
        const most = Math.max(1, Math.floor(ANSWER / Math.max(this.cost.value, 1e-4)));
        const steps = Math.min(most, wanted - this.#frames.length, 1000);
        try {
            const { value, bytes, seconds } = await this.client.ask<Advanced>({ ask: "advance", run: this.scene.run, steps });
            if (this.over) return;
            const length = COLUMNS * this.scene.agents.length;
            const numbers = new Float64Array(bytes);
            for (let k = 0; k < steps; k++) this.#frames.push(numbers.slice(k * length, (k + 1) * length));
            batch(() => {
                this.advanced.value = value;
                this.cost.value = seconds / steps;
                this.computed.value = this.#frames.length;
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
        const from = this.#place;
        const wanted = from + (seconds * pace) / this.scene.step;
        const there = this.#frames.length - 1;
        this.#place = Math.min(wanted, there);
        const smooth = 0.9;
        const real = seconds > 0 ? ((this.#place - from) * this.scene.step) / seconds : 0;
        this.pace.value = smooth * this.pace.value + (1 - smooth) * real;
        this.shown.value = Math.floor(this.#place);
        if (this.#frames.length >= this.most) {
            if (this.shown.value >= there) {
                this.playing.value = false;
                this.failed.value = `the run ends here, at ${(there * this.scene.step).toFixed(2)} s: its frames fill ${MOST_BYTES / 1e6} MB`;
            }
            return;
        }
        const ahead = Math.ceil((0.3 * pace) / this.scene.step) + 2;
        if (!this.#asking && there < wanted + ahead) void this.#ask(Math.ceil(wanted) + ahead + 1);
    }

    show(k: number) {
        this.playing.value = false;
        this.#place = Math.max(0, Math.min(k, this.#frames.length - 1));
        this.shown.value = this.#place;
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

    /** Poses of all frames as a table. Numbers are read back as the same doubles. */
    table(): Blob {
        const lines = ["t,id,x,y,theta,speed,mean_normal_force,contacts\n"];
        this.#frames.forEach((frame, k) => {
            this.scene.agents.forEach((agent, a) => {
                const numbers = frame.subarray(COLUMNS * a, COLUMNS * (a + 1)).join(",");
                lines.push(`${k * this.scene.step},${quoted(agent.id)},${numbers}\n`);
            });
        });
        return new Blob(lines, { type: "text/csv" });
    }
}

function quoted(text: string) {
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
