// The menu of a place on the picture: what can be done with the person there, or with the floor.

import { signal } from "@preact/signals";
import { useLayoutEffect, useRef } from "preact/hooks";
import { send } from "./exits";
import { add, chosen, copy, drop, movable } from "./handtool";
import { t } from "./language";
import { named } from "./parts";
import { change, plan } from "./plan";
import { placesOf } from "./places";
import type { Point } from "./protocol";
import { film, selected } from "./session";

interface Place {
    /** In pixels of the page, from the corner of the frame around the pictures. */
    left: number;
    top: number;
    /** In m. */
    at: Point;
    agent: number | null;
}

export const menu = signal<Place | null>(null);

type Item = [words: string, act: () => void];

function items({ at, agent }: Place): Item[] {
    const shown = film.value!;
    const { motion } = plan.value.made;
    const found: Item[] = [];
    if (agent !== null) {
        const { id } = shown.scene.agents[agent]!;
        if (movable.value) found.push([t("Copy"), () => copy(chosen.value!)]);
        if (movable.value && shown.scene.agents.length > 1) found.push([t("Delete"), () => drop(chosen.value!)]);
        if (motion.kind === "go") {
            const { decision } = motion;
            placesOf(decision).forEach(({ name }, k) => found.push([t("Send to {name}", { name: named(name) }), () => send(decision, id, k)]));
            if (decision.agents[id]) found.push([t("Send where the others go"), () => send(decision, id, null)]);
        }
    }
    if (!movable.value) found.push([t("Go to the start, to move people"), () => void shown.show(0)]);
    else if (agent === null) {
        found.push([t("Put the person of the tab Person here"), () => add(plan.value.person, at)]);
        if (plan.value.made.base.kind === "crowd") found.push([t("Turn, move and copy people"), () => change({ tab: "crowd" })]);
    }
    return found;
}

export function Menu() {
    const now = menu.value;
    const list = useRef<HTMLDivElement>(null);
    useLayoutEffect(() => list.current?.querySelector("button")?.focus(), [now]);
    if (!now || !film.value) return null;
    const close = () => (menu.value = null);
    const title = now.agent === null ? t("The floor") : t("Person {id}", { id: named(film.value.scene.agents[now.agent]?.id ?? "") });
    const step = (by: number) => {
        const buttons = [...list.current!.querySelectorAll("button")];
        const at = buttons.indexOf(document.activeElement as HTMLButtonElement);
        buttons[(at + by + buttons.length) % buttons.length]?.focus();
    };
    return (
        <div
            ref={list}
            class="menu"
            role="menu"
            aria-label={title}
            // The policy for contents allows no style in the text of the page; this is set by the script.
            style={{ left: `${now.left}px`, top: `${now.top}px` }}
            onKeyDown={(event) => {
                if (event.key === "Escape") close();
                else if (event.key === "ArrowDown") step(1);
                else if (event.key === "ArrowUp") step(-1);
                else return;
                event.preventDefault();
                event.stopPropagation();
            }}
            onFocusOut={(event) => {
                if (!list.current?.contains(event.relatedTarget as Node | null)) close();
            }}
        >
            <strong>{title}</strong>
            {items(now).map(([words, act]) => (
                <button
                    key={words}
                    type="button"
                    role="menuitem"
                    onClick={() => {
                        close();
                        act();
                    }}
                >
                    {words}
                </button>
            ))}
        </div>
    );
}

/** Opens it; the one whom it is about is selected. */
export function openMenu(place: Place) {
    if (place.agent !== null) selected.value = place.agent;
    menu.value = place;
}
