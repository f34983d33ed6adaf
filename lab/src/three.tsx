// The run in three dimensions. A file of its own, which is loaded when it is needed.

import { signal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { byPart, scaleOf } from "./colour";
import { Crowd3d } from "./crowd3d";
import type { Film } from "./film";
import { t } from "./language";
import { show } from "./layout";
import { SpaceCanvas } from "./parts";
import { plan } from "./plan";
import type { Bodies } from "./protocol";
import { selected } from "./session";
import { NoWebGL, Space } from "./space";

const HOW = matchMedia("(pointer: coarse)").matches
    ? t("Drag to turn; with two fingers, move and zoom.")
    : t("Drag to turn, with the right button to move, wheel to zoom; click to select.");

/** Pixels that a click may move. */
const STILL = 4;

export default function Stage3d({ film }: { film: Film }) {
    // A canvas whose place was given back cannot be drawn on again.
    return <One key={film.scene.run} film={film} />;
}

function One({ film }: { film: Film }) {
    const canvas = useRef<HTMLCanvasElement>(null);
    const [crowd] = useState(() => signal<Crowd3d | null>(null));
    const [words, setWords] = useState(t("Bodies are made …"));
    const [missing, setMissing] = useState("");
    const [grid, setGrid] = useState(1);
    useEffect(() => {
        const on = canvas.current!;
        let space: Space;
        try {
            space = new Space(on);
        } catch (error) {
            return setMissing(error instanceof NoWebGL ? error.message : t("3D cannot be shown: {message}", { message: (error as Error).message }));
        }
        const made = new Crowd3d(space, film.scene, film.frames.frame(0));
        space.onTheme = () => made.recolour();
        space.look(made.box);
        setGrid(made.grid);
        const hide = show(on);
        let gone = false;
        film.client
            .ask<Bodies>({ ask: "bodies", run: film.scene.run })
            .then(({ value, bytes }) => {
                if (gone) return;
                made.dress(value, bytes);
                crowd.value = made;
                setWords(value.estimated ? t("Sex and measures are not known: bodies that fit the disks, height and mass.") : "");
            })
            .catch((error: Error) => !gone && setWords(t("No bodies: {message}", { message: error.message })));
        return () => {
            gone = true;
            crowd.value = null;
            hide();
            made.dispose();
            space.dispose();
        };
    }, []);
    useSignalEffect(() => {
        const scale = scaleOf(film, plan.value.colour);
        const frame = film.frames.at(film.place.value);
        crowd.value?.place(frame, byPart(film, film.shown.value, plan.value.colour), scale, selected.value, film.place.value * film.scene.step);
    });
    const pressed = useRef<[number, number]>([0, 0]);
    return (
        <SpaceCanvas
            canvas={canvas}
            missing={missing}
            label={t("{n} people in three dimensions. Arrow keys turn the picture, with Shift they move it; plus and minus zoom, 0 shows all.", { n: film.scene.agents.length })}
            onPointerDown={(event) => (pressed.current = [event.offsetX, event.offsetY])}
            onClick={(event) => {
                const [x, y] = pressed.current;
                if (Math.hypot(event.offsetX - x, event.offsetY - y) < STILL) selected.value = crowd.value?.at(event.offsetX, event.offsetY) ?? null;
            }}
        >
            <p class="note">
                {t("Lines on the ground: {grid} m apart.", { grid })} {HOW} <span role="status">{words}</span>
            </p>
        </SpaceCanvas>
    );
}
