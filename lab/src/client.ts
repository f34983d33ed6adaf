// Asks the worker. What is stopped, and what breaks it, is told to those who wait.

import { signal } from "@preact/signals";
import { inWords, t } from "./language";
import type { Asked, Progress, Request, Told } from "./protocol";

export interface Answer<T> {
    value: T;
    bytes: ArrayBuffer;
    /** Processor time that it took. */
    seconds: number;
}

/** A request that takes long. */
export interface Slow {
    ask: Request["ask"];
    progress: Progress | null;
}

export class Refused extends Error {}
/** The worker was ended: nothing of its lab is left. */
export class Stopped extends Error {}

interface Waiting {
    ask: Request["ask"];
    since: number;
    progress: Progress | null;
    done(answer: Answer<never>): void;
    failed(error: Error): void;
}

/** It broke as often as this at the same kind of request: it would be started again and again. */
const MOST_CRASHES = 5;
/** After so many seconds a request can be stopped. */
const PATIENCE = 0.5;

export class Client {
    /** None after too many crashes. */
    #worker: Worker | null = this.#start();
    #waiting = new Map<number, Waiting>();
    #last = 0;
    /** The last answer, if it took long. */
    #long: Request["ask"] | null = null;
    /** How many workers there were before: what one knows, the next does not. */
    generation = 0;
    #crashes = 0;
    /** At which request it crashed: an answer to another one does not say that it works again. */
    #crashedAt: Request["ask"] | undefined;
    /** What the worker has been at for longer than half a second. */
    readonly slow = signal<Slow | null>(null);
    /** The share of the lab that has come. */
    readonly loaded = signal<number | undefined>(undefined);
    readonly module = signal<WebAssembly.Module | null>(null);
    /** Called after a worker ended by itself. */
    broken = (_why: string) => {};

    #start() {
        const worker = new Worker("worker.js?__BUILD__", { type: "module" });
        // What an ended worker still says does not count.
        const hear = (told: Told) => {
            if (worker === this.#worker) this.#hear(told);
        };
        worker.onmessage = ({ data }: MessageEvent<Told>) => hear(data);
        worker.onerror = (event) => hear({ broken: event.message || t("it could not be started") });
        return worker;
    }

    #hear(told: Told) {
        if ("broken" in told) {
            this.#crashes += 1;
            this.#crashedAt = this.#first()?.ask;
            this.stop(told.broken);
            return this.broken(told.broken);
        }
        if ("loading" in told) return void (this.loaded.value = told.loading);
        if ("module" in told) return void (this.module.value ??= told.module);
        const waiting = this.#waiting.get(told.id);
        if (!waiting) return;
        if ("progress" in told) {
            waiting.progress = told.progress;
            return this.#look();
        }
        this.#waiting.delete(told.id);
        if (waiting.ask === this.#crashedAt) this.#crashes = 0;
        // The next one begins only now.
        const now = performance.now();
        this.#long = now - waiting.since < 1000 * PATIENCE ? null : waiting.ask;
        const next = this.#first();
        if (next) next.since = now;
        // After a long one, another of its kind may follow: the button to stop it should not flicker.
        setTimeout(() => this.#look(), this.#long ? 100 : 0);
        if ("refused" in told) waiting.failed(new Refused(inWords(told.refused)));
        else waiting.done(told as Answer<never> & { id: number });
    }

    /** The worker answers in the order of the requests. */
    #first(): Waiting | undefined {
        return this.#waiting.values().next().value;
    }

    #look() {
        const first = this.#first();
        const long = first && (first.ask === this.#long || performance.now() - first.since >= 1000 * PATIENCE);
        if (long) this.slow.value = { ask: first.ask, progress: first.progress };
        else if (this.slow.value) this.slow.value = null;
    }

    ask<T>(request: Request, bytes?: Uint8Array): Promise<Answer<T>> {
        const id = ++this.#last;
        const worker = this.#worker;
        if (!worker) return Promise.reject(new Refused(t("nothing is computed any more, because the computation ended too often: load this page again")));
        return new Promise<Answer<T>>((done, failed) => {
            this.#waiting.set(id, { ask: request.ask, since: performance.now(), progress: null, done, failed });
            const asked: Asked = { id, request, bytes };
            worker.postMessage(asked);
            setTimeout(() => this.#waiting.has(id) && this.#look(), 1000 * PATIENCE + 10);
        });
    }

    /** Whether something can be asked. */
    get works() {
        return this.#worker !== null;
    }

    /** Ends the worker and whatever it does, for good. */
    close(why: string) {
        this.#crashes = MOST_CRASHES;
        this.stop(why);
    }

    /** Ends the worker and whatever it does, and starts another one. */
    stop(why: string) {
        this.#worker?.terminate();
        const waiting = [...this.#waiting.values()];
        this.#waiting.clear();
        this.generation += 1;
        this.slow.value = null;
        this.#long = null;
        this.#worker = this.#crashes < MOST_CRASHES ? this.#start() : null;
        for (const { failed } of waiting) failed(new Stopped(why));
    }
}
