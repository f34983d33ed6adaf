// Takes only what has the right form, because links and storage may hold anything. Whether values make sense, the lab
// in WebAssembly says.

export class Unfit extends Error {}

/** What it returns has the form; it throws `Unfit` if what is given does not. */
export type Check<T> = (given: unknown) => T;

export function fits(check: Check<unknown>, given: unknown): boolean {
    try {
        check(given);
        return true;
    } catch {
        return false;
    }
}

export const number: Check<number> = (given) => {
    if (typeof given !== "number" || !Number.isFinite(given)) throw new Unfit();
    return given;
};

export function within(low: number, high: number): Check<number> {
    return (given) => {
        const found = number(given);
        if (found < low || found > high) throw new Unfit();
        return found;
    };
}

export const flag: Check<boolean> = (given) => {
    if (typeof given !== "boolean") throw new Unfit();
    return given;
};

export function text(most = 200): Check<string> {
    return (given) => {
        if (typeof given !== "string" || given.length > most) throw new Unfit();
        return given;
    };
}

export function one<const T extends string>(...values: T[]): Check<T> {
    return (given) => {
        const found = values.find((value) => value === given);
        if (found === undefined) throw new Unfit();
        return found;
    };
}

export function nullable<T>(check: Check<T>): Check<T | null> {
    return (given) => (given === null ? null : check(given));
}

export function list<T>(item: Check<T>, most: number, least = 0): Check<T[]> {
    return (given) => {
        if (!Array.isArray(given) || given.length > most || given.length < least) throw new Unfit();
        return given.map(item);
    };
}

export function tuple<T extends unknown[]>(...items: { [K in keyof T]: Check<T[K]> }): Check<T> {
    return (given) => {
        if (!Array.isArray(given) || given.length !== items.length) throw new Unfit();
        return items.map((item, k) => item(given[k])) as T;
    };
}

/** Any names, each with a value. */
export function dictionary<T>(item: Check<T>, most: number): Check<Record<string, T>> {
    return (given) => {
        const from = Object.entries(object(given));
        if (from.length > most) throw new Unfit();
        return Object.fromEntries(from.map(([name, value]) => [name, item(value)]));
    };
}

type Parts<T> = { [K in keyof T]-?: Check<T[K]> };

function object(given: unknown): Record<string, unknown> {
    if (typeof given !== "object" || given === null || Array.isArray(given)) throw new Unfit();
    return given as Record<string, unknown>;
}

/** Only the parts that are named are taken. */
export function record<T extends object>(parts: Parts<T>): Check<T> {
    return (given) => {
        const from = object(given);
        const taken = Object.entries<Check<unknown>>(parts).map(([key, check]) => [key, check(from[key])]);
        return Object.fromEntries(taken) as T;
    };
}

/** As `record`, but what is unfit is taken from `instead`; `left` is told what was there and did not fit. */
export function patched<T extends object>(parts: Parts<T>, instead: T): (given: unknown, left: (key: keyof T) => void) => T {
    return (given, left) => {
        const from = object(given);
        const taken = Object.entries<Check<unknown>>(parts).map(([key, check]) => {
            try {
                return [key, check(from[key])];
            } catch {
                if (Object.hasOwn(from, key)) left(key as keyof T);
                return [key, instead[key as keyof T]];
            }
        });
        return Object.fromEntries(taken) as T;
    };
}

/** One of several forms; the value of `tag` says which. */
export function tagged<K extends string, T extends Record<K, string>>(
    tag: K,
    forms: { [V in T[K]]: Check<Omit<Extract<T, Record<K, V>>, K>> },
): Check<T> {
    return (given) => {
        const kind = object(given)[tag];
        if (typeof kind !== "string" || !Object.hasOwn(forms, kind)) throw new Unfit();
        return { [tag]: kind, ...forms[kind as T[K]](given) } as unknown as T;
    };
}
