// Names of kinds of people, in words. A kind of somebody's own keeps its name.

import { type Plain, t } from "./language";

const NAMES: Record<string, Plain> = {
    adult: "Adult",
    backpack: "With a backpack",
    bicycle: "On a bicycle",
    child: "Child",
    elderly: "Elderly",
    "powered-wheelchair": "Powered wheelchair",
    stroller: "With a stroller",
    suitcase: "With a suitcase",
    walker: "With a walker",
    wheelchair: "Wheelchair",
    "with-child": "With a child",
};

/** The kinds of the program, adults first. */
export const KINDS = Object.keys(NAMES);

/** The id of the name of a kind of the program. */
export function kindName(kind: string): Plain {
    return NAMES[kind]!;
}

export function kindWords(kind: string): string {
    return isOwn(kind) ? kind : t(kindName(kind));
}

/** Whether it is one of somebody's own. */
export function isOwn(kind: string): boolean {
    // Not `in`: "constructor" may be somebody's kind.
    return !Object.hasOwn(NAMES, kind);
}
