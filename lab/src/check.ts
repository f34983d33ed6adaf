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

/** Takes what passes a test, as it is. */
function only<T>(passes: (given: unknown) => boolean): Check<T> {
    return (given) => {
        if (!passes(given)) throw new Unfit();
        return given as T;
    };
}

export const number = only<number>(Number.isFinite);
export const within = (low: number, high: number) => only<number>((given) => Number.isFinite(given) && (given as number) >= low && (given as number) <= high);
export const flag = only<boolean>((given) => typeof given === "boolean");
export const text = (most = 200) => only<string>((given) => typeof given === "string" && given.length <= most);
export const one = <const T extends string>(...values: T[]) => only<T>((given) => values.includes(given as T));
const array = (least: number, most: number) => only<unknown[]>((given) => Array.isArray(given) && given.length >= least && given.length <= most);
const object = only<Record<string, unknown>>((given) => typeof given === "object" && given !== null && !Array.isArray(given));

/** Older links do not have everything. */
export const nullable = <T>(check: Check<T>): Check<T | null> => (given) => (given == null ? null : check(given));
/** What is not there is left out: plans are compared as text. */
export const optional = <T>(check: Check<T>): Check<T | undefined> => (given) => (given === undefined ? undefined : check(given));

export function list<T>(item: Check<T>, most: number, least = 0): Check<T[]> {
    return (given) => array(least, most)(given).map(item);
}

export function tuple<T extends unknown[]>(...items: { [K in keyof T]: Check<T[K]> }): Check<T> {
    return (given) => {
        const found = array(items.length, items.length)(given);
        return items.map((item, k) => item(found[k])) as T;
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

/** Only the parts that are named are taken. */
export function record<T extends object>(parts: Parts<T>): Check<T> {
    return (given) => {
        const from = object(given);
        const taken = Object.entries<Check<unknown>>(parts).map(([key, check]) => [key, check(from[key])]);
        return Object.fromEntries(taken) as T;
    };
}

/** A form, and what has it at first. */
export type Row<T> = readonly [form: Check<T>, first: T];
export const row = <T>(form: Check<T>, first: NoInfer<T>): Row<T> => [form, first];
export type OfRows<R> = { -readonly [K in keyof R]: R[K] extends Row<infer T> ? T : never };
const column = (rows: object, k: 0 | 1) => Object.fromEntries(Object.entries(rows).map(([key, one]) => [key, one[k]])) as unknown;
export const forms = <R extends object>(rows: R) => column(rows, 0) as Parts<OfRows<R>>;
export const firsts = <R extends object>(rows: R) => column(rows, 1) as OfRows<R>;

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
