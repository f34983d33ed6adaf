// Bodies cut by a level plane. The polygons are asked for; here they only become paths.

import { signal } from "@preact/signals";
import type { Film } from "./film";
import { Latest } from "./latest";
import { plan } from "./plan";
import type { Point, Scene, Sections as Cut } from "./protocol";

export type SectionFacts = Omit<Cut, "bodies">;

/** The height in m at which the disks of people in levels are drawn; null: those of all heights. */
export function heightOf({ scene }: Film): number | null {
    return plan.value.view === "section" && scene.levels.length > 0 ? plan.value.altitude : null;
}

const within = (height: number, [bottom, top]: [number, number]) => height >= bottom && height < top;

/** Of a scene the disks and walls at a height in m. */
export function sceneAt(scene: Scene, height: number | null): Scene {
    if (height === null) return scene;
    const agents = scene.agents.map((agent) => {
        const own = <T,>(of: T[]) => of.filter((_, k) => within(height, agent.heights![k]!));
        return { ...agent, disks: own(agent.disks), things: agent.things && own(agent.things), seated: null };
    });
    return { ...scene, agents, walls: scene.walls.filter(({ heights }) => !heights || within(height, heights)) };
}

/** The level at a height, from 0; -1: none. */
export function levelAt({ scene }: Film, height: number): number {
    return scene.levels.findIndex((ends) => within(height, ends));
}

export class Sections {
    /** How many bodies the plane cuts, and with which area; null before the first answer. */
    readonly facts = signal<SectionFacts | null>(null);
    readonly refused = signal("");
    #paths: Path2D[] | null = null;
    #there: number | null = null;
    #asked = new Latest<number>(async (altitude) => {
        if (this.film.over || altitude === this.#there) return;
        try {
            const { value } = await this.film.client.ask<Cut>({ ask: "sections", run: this.film.scene.run, altitude });
            const { bodies, ...facts } = value;
            this.#paths = bodies.map(pathOf);
            this.facts.value = facts;
            this.refused.value = "";
        } catch (error) {
            if (!this.film.over) this.refused.value = (error as Error).message;
        }
        this.#there = altitude;
    });

    constructor(readonly film: Film) {}

    /** Asks for the sections at an altitude in m. While one answer is awaited, only the last altitude counts. */
    ask(altitude: number): Promise<void> {
        return this.#asked.want(altitude);
    }

    /** One of each agent, in its frame; null before the first answer. Read `facts` to hear of further ones. */
    paths(): Path2D[] | null {
        return this.#paths;
    }
}

function pathOf(polygons: Point[][]): Path2D {
    const path = new Path2D();
    for (const polygon of polygons) {
        polygon.forEach(([x, y], k) => (k ? path.lineTo(x, y) : path.moveTo(x, y)));
        path.closePath();
    }
    return path;
}
