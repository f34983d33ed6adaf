// Asks again and again, but one answer after the other: of what was wanted meanwhile, only the last counts.

export class Latest<T> {
    #next: { wanted: T } | null = null;
    #running: Promise<void> | null = null;

    constructor(readonly run: (wanted: T) => Promise<void>) {}

    /** Ends when nothing more is wanted. */
    want(wanted: T): Promise<void> {
        this.#next = { wanted };
        this.#running ??= this.#follow();
        return this.#running;
    }

    async #follow() {
        try {
            while (this.#next) {
                const { wanted } = this.#next;
                this.#next = null;
                await this.run(wanted);
            }
        } finally {
            this.#running = null;
        }
    }
}
