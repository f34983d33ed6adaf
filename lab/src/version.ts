// The version of the page, and the commit it was built from, if that is known: build.mjs puts them in.

declare const __VERSION__: string;

export const VERSION = __VERSION__;
