// A run: frames that were computed, and which of them is shown. It computes ahead of that.

import { batch, computed, signal } from "@preact/signals";
import { type Client, Stopped } from "./client";
import { Frames } from "./frames";
import { fixed, t } from "./language";
import type { Made } from "./plan";
import type { Advanced, Scene } from "./protocol";

/** Bytes of frames that are kept; then the run ends. */
const MOST_BYTES = 800e6;
/** Seconds that an answer should take, so that the page is heard between them. */
const ANSWER = 0.03;
/** Seconds of a run that are computed ahead of what is shown, while it plays. */
const AHEAD = 60;

export class Film {
    readonly playing = signal(false);
    /** The frame that is shown, from 0. */
    readonly shown = signal(0);
    /** As `shown`, with the fraction of a frame: `frameAt` moves smoothly with it. */
    readonly place = signal(0);
    readonly computed = signal(1);
    /** Deepest overlap until each frame in m, and how many of those who walk have arrived or left. */
    readonly overlaps: number[];
    readonly arrived = [0];
    /** The first frame in which all have left who have an exit; null: none yet. */
    readonly emptied = signal<number | null>(null);
    /** Processor time for a communication step. */
    readonly cost = signal(ANSWER);
    readonly failed = signal<string | null>(null);
    /** Simulated seconds in a second that were really shown. */
    readonly pace = signal(0);
    readonly frames: Frames;
    /** The last frame that is to be computed, whether it is shown or not. */
    readonly wanted = signal(0);
    /** In s: up to where it is to be computed if not all have left before; null: that is not asked for. */
    readonly bound = signal<number | null>(null);
    /** The last frame that was shown. */
    readonly #seen = signal(0);
    /** The last frame that was shown or asked for: tables and movies end there. What is computed ahead depends on the machine. */
    readonly reached = computed(() => Math.max(this.#seen.value, Math.min(this.wanted.value, this.computed.value - 1)));
    /** The frame up to which it plays, even if all have left before: a run beside it takes longer. */
    least = 0;
    /** The place that is to be shown. */
    #sought = 0;
    #computing: Promise<void> | null = null;
    #old = false;
    #generation: number;

    #run: number;

    constructor(
        public client: Client,
        readonly scene: Scene,
        /** What the scene was made of. What is wanted may have changed since. */
        readonly made: Made,
        first: ArrayBuffer,
    ) {
        this.overlaps = [scene.overlap];
        this.frames = new Frames(scene.agents.length, scene.further);
        this.frames.add(new Float64Array(first), 1);
        this.#generation = client.generation;
        this.#run = scene.run;
        this.#look();
    }

    /** Another film took its place, or its worker ended. */
    get over() {
        return this.#old || this.#generation !== this.client.generation;
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
        if (this.bound.value !== null) this.wanted.value = this.emptied.value;
    }

    /** The frame at which it stops; null: none yet. */
    get #end(): number | null {
        return this.emptied.value === null ? null : Math.max(this.emptied.value, this.least);
    }

    /** Frames that are to be computed now: up to what was asked for and, while it plays, some time ahead of what is shown. */
    #goal(): number {
        const end = this.#end;
        const ahead = this.place.value + AHEAD / this.scene.step;
        // Who plays it beyond its end sees how it goes on.
        const ends = end !== null && this.place.value < end;
        const played = !this.playing.value ? 0 : ends ? Math.min(end, ahead) : ahead;
        return Math.min(this.most, 1 + Math.ceil(Math.max(this.wanted.value, this.#sought, played)));
    }

    /** Computes up to the goal, which may change meanwhile. Answers call for the next ones, not pictures: it goes on in a
     * hidden tab, too. */
    async #compute() {
        const behind = () => this.frames.count < this.#goal() && !this.over && !this.failed.value;
        if (!behind()) return;
        this.#computing ??= (async () => {
            while (behind()) await this.#ask(this.#goal());
            this.#computing = null;
        })();
        await this.#computing;
    }

    /** Computes no further than it shows. */
    stop() {
        this.bound.value = null;
        this.wanted.value = 0;
    }

    /** Computes until all have left who have an exit, or up to a time in s. */
    async computeUntilLeft(seconds: number) {
        this.bound.value = seconds;
        this.wanted.value = this.emptied.value ?? Math.min(Math.round(seconds / this.scene.step), this.most - 1);
        this.#sought = 0;
        await this.#compute();
    }

    async #ask(wanted: number) {
        const most = Math.max(1, Math.floor(ANSWER / Math.max(this.cost.value, 1e-4)));
        const steps = Math.max(1, Math.min(most, wanted - this.frames.count, 1000));
        try {
            const { value, bytes, seconds } = await this.client.ask<Advanced>({ ask: "advance", run: this.#run, steps });
            if (this.over) return;
            this.frames.add(new Float64Array(bytes), steps);
            this.overlaps.push(...value.overlaps);
            this.arrived.push(...value.arrived);
            batch(() => {
                this.cost.value = seconds / steps;
                this.computed.value = this.frames.count;
                this.#look();
            });
        } catch (error) {
            if (!this.over && !(error instanceof Stopped)) this.failed.value = t("the run ended: {message}", { message: (error as Error).message });
            this.playing.value = false;
        }
    }

    /** Goes on by real seconds. Called for each picture while it plays. */
    tick(seconds: number, pace: number) {
        const from = this.place.value;
        const wanted = from + (seconds * pace) / this.scene.step;
        const end = this.#end;
        if (end !== null && from < end && wanted >= end) {
            // The run ends here. Who plays it again sees how it goes on.
            return void this.show(end);
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
                this.failed.value = t("the run ends here, at {end} s: its frames fill {most} MB", { end: fixed(there * this.scene.step, 2), most: MOST_BYTES / 1e6 });
            }
            return;
        }
        void this.#compute();
    }

    #go(place: number) {
        const within = Math.max(0, Math.min(place, this.frames.count - 1));
        batch(() => {
            this.place.value = within;
            if (within > this.#seen.peek()) this.#seen.value = Math.floor(within);
            this.shown.value = Math.floor(within);
        });
    }

    /** Shows a place; nothing plays then. What is not there yet is computed before. */
    async show(place: number) {
        this.playing.value = false;
        this.#sought = place;
        this.#go(place);
        if (Math.ceil(place) < this.frames.count) return;
        await this.#compute();
        // Unless another place was asked for meanwhile.
        if (this.#sought === place && !this.playing.value) this.#go(place);
    }

    /** Another worker, whose run of this scene is at its start, computes what is not there yet, until all have left or up to a time
     * in s. That is not asked for: tables and movies do not end there. */
    async goOn(client: Client, run: number, seconds: number) {
        for (let behind = this.frames.count - 1; behind > 0; behind -= 1000) await client.ask({ ask: "advance", run, steps: Math.min(behind, 1000) });
        [this.client, this.#run, this.#generation, this.#old] = [client, run, client.generation, false];
        const last = Math.min(Math.round(seconds / this.scene.step) + 1, this.most);
        while (this.emptied.value === null && this.frames.count < last && !this.over && !this.failed.value) await this.#ask(last);
    }

    /** Another film takes its place. */
    end() {
        this.#old = true;
        this.playing.value = false;
    }
}
