// Asks the worker. What is stopped, and what breaks it, is told to those who wait.

import type { Asked, Progress, Request, Told } from "./protocol";

export interface Answer<T> {
    value: T;
    bytes: ArrayBuffer;
    /** Processor time that it took. */
    seconds: number;
}

export class Refused extends Error {}
/** The worker was ended: nothing of its lab is left. */
export class Stopped extends Error {}

interface Waiting {
    done(answer: Answer<never>): void;
    failed(error: Error): void;
    watch?(progress: Progress): void;
}

export class Client {
    #worker = this.#start();
    #waiting = new Map<number, Waiting>();
    #last = 0;
    /** How many workers there were before: what one knows, the next does not. */
    generation = 0;
    /** Called after a worker ended by itself. */
    broken = (_why: string) => {};

    #start() {
        const worker = new Worker("worker.js", { type: "module" });
        // What an ended worker still says does not count.
        const hear = (told: Told) => {
            if (worker === this.#worker) this.#hear(told);
        };
        worker.onmessage = ({ data }: MessageEvent<Told>) => hear(data);
        worker.onerror = (event) => hear({ broken: event.message || "it could not be started" });
        return worker;
    }

    #hear(told: Told) {
        if ("broken" in told) {
            this.stop(told.broken);
            return this.broken(told.broken);
        }
        const waiting = this.#waiting.get(told.id);
        if (!waiting) return;
        if ("progress" in told) return waiting.watch?.(told.progress);
        this.#waiting.delete(told.id);
        if ("refused" in told) waiting.failed(new Refused(told.refused));
        else waiting.done(told as Answer<never> & { id: number });
    }

    ask<T>(request: Request, bytes?: Uint8Array, watch?: (progress: Progress) => void): Promise<Answer<T>> {
        const id = ++this.#last;
        return new Promise<Answer<T>>((done, failed) => {
            this.#waiting.set(id, { done, failed, watch });
            const asked: Asked = { id, request, bytes };
            this.#worker.postMessage(asked);
        });
    }

    /** Ends the worker and whatever it does, and starts another one. */
    stop(why: string) {
        this.#worker.terminate();
        for (const { failed } of this.#waiting.values()) failed(new Stopped(why));
        this.#waiting.clear();
        this.generation += 1;
        // One that cannot even begin would be started again and again.
        if (this.generation < 100) this.#worker = this.#start();
    }
}
