// The language of the page. Texts are English in the code; another language has them in a dictionary, which is looked into
// where elements are made. Numbers in a text, and names in quotes, are # in its key, so that one entry holds for all. An
// element that holds what the visitor or a file says is not to be translated (`translate={false}`).

import { Fragment, options, type VNode } from "preact";
import { storage } from "./plan";

export const LANGUAGES = { en: "English", de: "Deutsch", fr: "Français" };
export type Language = keyof typeof LANGUAGES;

const KEY = "lemons-lab language";
const isLanguage = (name: string | null | undefined): name is Language => name != null && name in LANGUAGES;

/** What was chosen, or else what the browser asks for. */
function wanted(): Language {
    const chosen = storage("localStorage")?.getItem(KEY);
    const own = navigator.language.slice(0, 2);
    return isLanguage(chosen) ? chosen : isLanguage(own) ? own : "en";
}

export const language = wanted();
let words: Map<string, string> | null = null;
/** Texts without a translation: tests read them. */
const missing = new Set<string>();
Object.assign(window, { missing, translated });

/** The entry for a text, with or without its full stop; a text without words is its own. */
function whole(key: string): string | undefined {
    const sentence = key.endsWith(".") ? words!.get(key.slice(0, -1)) : undefined;
    return words!.get(key) ?? (sentence && `${sentence}.`) ?? (/[a-z]{2}/i.test(key) ? undefined : key);
}

/** The entry for a text, or those of its parts: the first part is as short as it can be and have one. */
function entry(key: string): string | undefined {
    const found = whole(key);
    if (found !== undefined) return found;
    for (const { 0: between, index } of key.matchAll(/, |: |; |\. /g)) {
        const first = whole(key.slice(0, index));
        const rest = first === undefined ? undefined : entry(key.slice(index + between.length));
        if (rest !== undefined) return first + between + rest;
    }
    return undefined;
}

/** A text in the language of the page; it stays English where there is no translation. */
export function translated(text: string): string {
    const inner = text.trim();
    if (!words || !/[a-z]{2}/i.test(inner)) return text;
    const given: string[] = [];
    const key = inner.replace(/"[^"]*"|(?:(?<![\w.])-)?\d+(\.\d+)?/g, (one) => {
        given.push(one);
        return "#";
    });
    const found = entry(key);
    if (found === undefined) {
        missing.add(key);
        return text;
    }
    return text.replace(inner, () => found.replace(/#/g, () => given.shift() ?? "#"));
}

const SAID = ["title", "aria-label", "aria-valuetext", "placeholder", "alt"];

function translate(vnode: VNode) {
    const props = vnode.props as Record<string, unknown>;
    if (props.translate === false) return;
    const child = (one: unknown): unknown => (typeof one === "string" ? translated(one) : one);
    if (typeof props.children === "string") props.children = translated(props.children);
    else if (Array.isArray(props.children)) props.children = props.children.map(child);
    for (const name of SAID) if (typeof props[name] === "string") props[name] = translated(props[name]);
}

/** Loads the dictionary; then elements are made in its language. */
export async function load() {
    document.documentElement.lang = language;
    if (language === "en") return;
    const { WORDS } = await import("./words");
    words = new Map(WORDS.map(([english, german, french]) => [english, language === "de" ? german : french]));
    const before = options.vnode;
    options.vnode = (vnode) => {
        if (typeof vnode.type === "string" || vnode.type === Fragment) translate(vnode);
        before?.(vnode);
    };
}

/** The page is loaded again, with all that is on it. */
export function choose(next: Language) {
    storage("localStorage")?.setItem(KEY, next);
    location.reload();
}
