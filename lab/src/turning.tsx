// One body in three dimensions, turning. Loaded with three.js, when it is needed.

import { useSignal, useSignalEffect } from "@preact/signals";
import { Box3, Color, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, PlaneGeometry, Vector3 } from "three";
import { useEffect, useRef, useState } from "preact/hooks";
import { lines, surface } from "./crowd3d";
import { t } from "./language";
import { Check, SpaceCanvas } from "./parts";
import type { Surface } from "./protocol";
import { free, Space } from "./space";

export interface TurningProps {
    body: { surface: Surface; bytes: ArrayBuffer } | null;
    /** In m; what is seen is as high as that. */
    stature: number;
    /** Altitude of a plane, in m; null: none. */
    altitude: number | null;
}

/** Radians per second. */
const SPEED = 0.5;
/** Half of the ground's side, in m. */
const GROUND = 0.5;

/** What is always there: ground with lines 0.5 m apart, and a plane. */
class Still {
    readonly group = new Group();
    readonly grid: LineSegments<ReturnType<typeof lines>, LineBasicMaterial>;
    readonly plane = new Mesh(
        new PlaneGeometry(2 * GROUND, 2 * GROUND),
        new MeshBasicMaterial({ transparent: true, opacity: 0.25, side: DoubleSide, depthWrite: false }),
    );

    constructor(readonly space: Space) {
        const points: number[] = [];
        for (let k = -2; k <= 2; k++) {
            const at = (k * GROUND) / 2;
            points.push(at, -GROUND, 0, at, GROUND, 0, -GROUND, at, 0, GROUND, at, 0);
        }
        this.grid = new LineSegments(lines(points), new LineBasicMaterial());
        this.group.add(this.grid, this.plane);
        space.scene.add(this.group);
    }

    recolour() {
        this.grid.material.color.copy(this.space.colour("--edge"));
        this.plane.material.color.copy(this.space.colour("--mark"));
    }
}

export default function Turning({ body, stature, altitude }: TurningProps) {
    const canvas = useRef<HTMLCanvasElement>(null);
    const [missing, setMissing] = useState("");
    const turns = useSignal(!matchMedia("(prefers-reduced-motion: reduce)").matches);
    const made = useRef<{ space: Space; still: Still; person: Mesh | null; skin: Color; angle: number } | null>(null);
    useEffect(() => {
        let space: Space;
        try {
            space = new Space(canvas.current!);
        } catch (error) {
            return setMissing((error as Error).message);
        }
        const still = new Still(space);
        const now = { space, still, person: null as Mesh | null, skin: new Color(), angle: 0 };
        made.current = now;
        const { skin } = now;
        const recolour = () => {
            still.recolour();
            skin.copy(space.colour("--main")).lerp(new Color(1, 1, 1), 0.3);
            (now.person?.material as MeshLambertMaterial | undefined)?.color.copy(skin);
        };
        space.onTheme = recolour;
        recolour();
        space.before = (seconds) => {
            if (turns.peek()) now.angle += SPEED * seconds;
            if (now.person) now.person.rotation.z = now.angle;
            return turns.peek();
        };
        return () => {
            made.current = null;
            if (now.person) free(now.person);
            space.dispose();
        };
    }, []);
    // The camera stays where it was put, unless the person outgrows the picture.
    const height = 0.2 * Math.ceil(stature / 0.2);
    useEffect(() => {
        const box = new Box3(new Vector3(-0.3, -0.3, -0.12), new Vector3(0.3, 0.3, height));
        made.current?.space.look(box, new Vector3(1, -0.35, 0.25));
    }, [height]);
    useEffect(() => {
        const now = made.current;
        if (!now || !body) return;
        if (now.person) free(now.person);
        const { vertices, triangles } = body.surface;
        now.person = new Mesh(surface(body.bytes, 0, vertices, triangles), new MeshLambertMaterial({ color: now.skin }));
        now.space.scene.add(now.person);
        now.space.draw();
    }, [body]);
    useEffect(() => {
        const now = made.current;
        if (!now) return;
        now.still.plane.visible = altitude !== null;
        now.still.plane.position.z = altitude ?? 0;
        now.space.draw();
    }, [altitude]);
    useSignalEffect(() => {
        if (turns.value) made.current?.space.draw();
    });
    return (
        <SpaceCanvas canvas={canvas} missing={missing} label={t("The body in three dimensions. Arrow keys turn the picture, plus and minus zoom, 0 shows all.")}>
            <Check label={t("Turn")} value={turns.value} onChange={(on) => (turns.value = on)} />
        </SpaceCanvas>
    );
}
