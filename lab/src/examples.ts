// Ready scenes to start from.

import { FIRST_CROWD, type KeptCrowd } from "./forms";
import { type Plain, t } from "./language";
import { FIRST_DECISION } from "./places";
import type { Made } from "./plan";
import type { Motion, Point, Push, WalkingModelName } from "./protocol";
import { rectangle } from "./roomshape";

export interface Example {
    /** Also that of its scene. */
    name: Plain;
    /** Of so many people. */
    question(people: number): string;
    sentence: string;
    /** When all have left, by which exits, or how hard people are squeezed; without, the first where people leave, else the last. */
    asks?: "exits" | "squeeze";
    made: Made;
}

function crowd(part: Partial<KeptCrowd>, motion: Motion): Made {
    return { base: { kind: "crowd", ...FIRST_CROWD, speed: 0, ...part }, edits: [], motion };
}

/** Exits as the page puts them beyond doors: 1 m away and 2 m longer. */
function leave(lines: Record<string, [Point, Point]>, model: WalkingModelName = "rotational"): Motion {
    const exits = Object.entries(lines).map(([name, line]) => ({ name, line, polygon: null, share: null, open: null }));
    return { kind: "go", decision: { ...FIRST_DECISION, model, exits } };
}

const shove: Omit<Push, "at"> = { radius: 0.75, direction: 0, force: 600, start: 0.2, duration: 0.6 };

/** A corridor, 5 m wide, narrows to 1.2 m. */
const bottleneck: Point[] = [
    [0, 0],
    [8, 0],
    [10, 1.9],
    [14, 1.9],
    [14, 3.1],
    [10, 3.1],
    [8, 5],
    [0, 5],
];

/** People before a door. */
function door(model: WalkingModelName): Made {
    const room = { outline: rectangle(8, 6), obstacles: [], doors: [{ at: [8, 3] as Point, width: 0.9 }] };
    return crowd({ number: 70, seed: 8, room, region: rectangle(5.5, 5.4, 0.3, 0.3) }, leave({ "door 1": [[9, 1.55], [9, 4.45]] }, model));
}

/** The ground before a tunnel, 2.5 m wide and 8 m long. */
const vomitory: Point[] = [
    [0, 0],
    [9, 0],
    [12, 2.75],
    [20, 2.75],
    [20, 5.25],
    [12, 5.25],
    [9, 8],
    [0, 8],
];

export const EXAMPLES: Example[] = [
    {
        name: "The door",
        question: (n) => t("How long do {n} people need to leave?", { n }),
        sentence: t("They walk to a door 0.9 m wide, an arch forms before it, and they leave one by one."),
        made: door("rotational"),
    },
    {
        name: "Nobody waits",
        question: () => t("What if nobody waits?"),
        sentence: t("The same room and people, who go straight on whoever is in the way, as in the paper. They press each other, and may block the way."),
        made: door("straight"),
    },
    {
        name: "Round and real bodies",
        question: () => t("What do round bodies miss?"),
        sentence: t("40 people go straight to a narrow gap. Keep the run, make bodies round, and compare; or set friction to 0.05."),
        made: crowd(
            {
                number: 40,
                seed: 3,
                room: { outline: rectangle(5, 5), obstacles: [], doors: [{ at: [5, 2.5], width: 0.8 }] },
                region: rectangle(3.5, 4.4, 0.3, 0.3),
            },
            leave({ "door 1": [[6, 1.1], [6, 3.9]] }, "straight"),
        ),
    },
    {
        name: "A push through a row",
        question: () => t("How hard does a push press?"),
        sentence: t("The last of five people in a row is pushed, and the push travels from back to back."),
        // As its drive.csv has it, which has no slider.
        made: { base: { kind: "example", name: "push" }, edits: [], motion: { kind: "push", pushes: [{ at: [0, 0], radius: 0.1, direction: 0, force: 1200, start: 0, duration: 0.6 }], balance: "none" } },
    },
    {
        name: "A dense square",
        question: () => t("What does a push do in a packed crowd?"),
        sentence: t("180 people stand on 5 m × 5 m, more than 7 per m². Those at the left are pushed, and a wave of pressure runs to the right."),
        made: crowd(
            { number: 180, room: { outline: rectangle(5, 5), obstacles: [], doors: [] }, direction: null },
            { kind: "push", pushes: [0.8, 2.5, 4.2].map((y) => ({ ...shove, at: [0.4, y] })), balance: "none" },
        ),
    },
    {
        name: "Two exits",
        question: () => t("Which exit do people take?"),
        asks: "exits",
        sentence: t("60 people go round a pillar and leave, each by the exit by which they expect to be out first."),
        made: crowd(
            {
                number: 60,
                room: { outline: rectangle(8, 6), obstacles: [rectangle(0.8, 0.8, 6, 2.6)], doors: [{ at: [8, 3], width: 1.2 }, { at: [2, 0], width: 1 }] },
                region: rectangle(5, 5.4, 0.3, 0.3),
            },
            leave({ right: [[9, 1.4], [9, 4.6]], below: [[0.5, -1], [3.5, -1]] }),
        ),
    },
    {
        name: "A bottleneck",
        question: () => t("Is faster slower?"),
        sentence: t("60 people walk along a corridor that narrows from 5 m to 1.2 m. Move the desired speed."),
        made: crowd(
            {
                number: 60,
                seed: 5,
                room: { outline: bottleneck, obstacles: [], doors: [{ at: [14, 2.5], width: 1.2 }] },
                region: rectangle(6.5, 4.6, 0.2, 0.2),
            },
            leave({ "door 1": [[15, 0.9], [15, 4.1]] }),
        ),
    },
    {
        name: "A stadium's vomitory",
        question: () => t("Where do spectators press?"),
        asks: "squeeze",
        sentence: t("130 spectators go round a pillar and leave through a tunnel, 2.5 m wide and 8 m long."),
        made: crowd(
            {
                number: 130,
                room: { outline: vomitory, obstacles: [rectangle(0.6, 1.6, 9.4, 3.2)], doors: [{ at: [20, 4], width: 2.5 }] },
                region: rectangle(7, 7.4, 0.3, 0.3),
            },
            leave({ "door 1": [[21, 1.75], [21, 6.25]] }),
        ),
    },
];

/** The name of a scene as it is shown: that of an example in the language of the page. */
export const titled = (name: string): string => (EXAMPLES.some((one) => one.name === name) ? t(name as Plain) : name);
