// The language of the page. A text stands in English where it is used, with named places for values; it is its own id in the
// catalogs of other languages (words/de.json, words/fr.json), as with gettext. `tsc` refuses an id without an entry.

import type { ComponentChildren } from "preact";
import type { Message } from "./generated";
import { storage } from "./storage";
import type german from "./words/de.json";

export const LANGUAGES = { en: "English", de: "Deutsch", fr: "Français" };
export type Language = keyof typeof LANGUAGES;

type Id = keyof typeof german;
type Places<I extends string> = I extends `${string}{${infer Place}}${infer Rest}` ? Place | Places<Rest> : never;
/** What is given with an id: a value for each of its places. */
type Values<I extends string, V> = [Places<I>] extends [never] ? [] : [values: Record<Places<I>, V>];
/** Ids without places. */
export type Plain = { [I in Id]: [Places<I>] extends [never] ? I : never }[Id];
/** Ids with a number. */
type Counted = { [I in Id]: [Places<I>] extends ["n"] ? ("n" extends Places<I> ? I : never) : never }[Id];

const KEY = "lemons-lab language";
const isLanguage = (name: string | null | undefined): name is Language => name != null && name in LANGUAGES;

/** What was chosen, or else what the browser asks for. */
function wanted(): Language {
    const chosen = storage("localStorage")?.getItem(KEY);
    const own = navigator.language.slice(0, 2);
    return isLanguage(chosen) ? chosen : isLanguage(own) ? own : "en";
}

type Catalog = Record<string, string>;
const CATALOGS: Record<Language, () => Promise<{ default: Catalog }[]>> = {
    en: async () => [],
    de: () => Promise.all([import("./words/de.json"), import("./words/engine.de.json")]),
    fr: () => Promise.all([import("./words/fr.json"), import("./words/engine.fr.json")]),
};

export const language = wanted();
document.documentElement.lang = language;
/** Why the page is in English instead; empty if it is not. */
export let unloaded = "";
// Texts are also made while modules are loaded: those that import this one wait for it.
const [words, engine] = await CATALOGS[language]().catch((error: Error) => {
    unloaded = error.message;
    return [];
});

/** A number, or some in a text, with the decimal comma where the language has one. */
export const local = (number: number | string) => (language === "en" ? String(number) : String(number).replace(/(?<![\w.])(\d+)\.(?=\d+(e[-+]?\d+)?(?![\w.]))/g, "$1,"));
export const fixed = (number: number, decimals: number) => local(number.toFixed(decimals));

/** A text with elements in its places. */
export function rich<I extends Id>(id: I, ...[values]: Values<I, ComponentChildren>): ComponentChildren[] {
    const parts = (words?.default[id] ?? id).split(/\{(\w+)\}/);
    const given = (place: string) => (values as Record<string, ComponentChildren>)[place];
    return parts.map((part, k) => (k % 2 === 0 ? part : typeof given(part) === "number" ? local(given(part) as number) : given(part)));
}

/** A text in the language of the page. */
export function t<I extends Id>(id: I, ...values: Values<I, string | number>): string {
    return rich(id, ...values).join("");
}

/** What begins with a capital, inside of a text: German nouns keep it. */
export const inner = (words: string) => (language === "de" ? words : words.charAt(0).toLowerCase() + words.slice(1));

/** What does not, at the beginning of one. */
export const capital = (words: string) => words.charAt(0).toUpperCase() + words.slice(1);

const rules = new Intl.PluralRules(language);

/** A text about so many: of one, or of several. */
export function count(n: number, one: Counted, several: Counted): string {
    return t(rules.select(n) === "one" ? one : several, { n });
}

/** The page is loaded again, with all that is on it. */
export function choose(next: Language) {
    storage("localStorage")?.setItem(KEY, next);
    location.reload();
}

/** What the engine says, in the language of the page: by the id of its sentence (words/engine.de.json, …), with its values. A
 * text without an id, as of a reader of files, stays English. */
export function inWords({ id, values, text }: Message): string {
    const own = engine?.default[id];
    return own?.replace(/\{(\w+)\}/g, (_, place: string) => inWords(values[place]!)) ?? (/^\D?\d+\.\d+( \S+)?$/.test(text) ? local(text) : text);
}

/** What is said of something with this name: French has a space before the colon. */
export const about = (name: string, what: string | number) => `${name}${language === "fr" ? "\u00a0" : ""}: ${typeof what === "number" ? local(what) : what}`;

/** A name of a table of the engine: a measure, a thing that goes along. */
export const nameOf = (name: string) => engine?.default[`name.${name}`] ?? name;
