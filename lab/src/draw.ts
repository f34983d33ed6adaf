// Draws a frame. Shapes are the disks that the engine uses; only turning, moving and scaling happens here.

import type { Colour } from "./plan";
import { COLUMNS, type Disk, type Scene } from "./protocol";

/** Colours of viridis (Smith, van der Walt), from low to high. */
const VIRIDIS = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];

export interface Scale {
    label: string;
    unit: string;
    column: number;
    most: number;
}

export const SCALES: Record<Colour, Scale> = {
    speed: { label: "Speed", unit: "m/s", column: 3, most: 2 },
    squeeze: { label: "Squeeze, mean of a communication step", unit: "N", column: 4, most: 2000 },
    contacts: { label: "Contacts", unit: "", column: 5, most: 8 },
};

export function colourOf(share: number) {
    const k = Math.round(Math.max(0, Math.min(1, share)) * (VIRIDIS.length - 1));
    return VIRIDIS[k]!;
}

export const COLOURS = VIRIDIS;

export function outline(disks: Disk[]): Path2D {
    const path = new Path2D();
    for (const [x, y, radius] of disks) {
        path.moveTo(x + radius, y);
        path.arc(x, y, radius, 0, 2 * Math.PI);
    }
    return path;
}

/** From metres to pixels. */
export interface View {
    scale: number;
    x: number;
    y: number;
}

/** Everything is visible: walls, and people where they start. */
export function fitting(scene: Scene, frame: Float64Array, width: number, height: number): View {
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    const see = (x: number, y: number, margin: number) => {
        left = Math.min(left, x - margin);
        right = Math.max(right, x + margin);
        low = Math.min(low, y - margin);
        high = Math.max(high, y + margin);
    };
    for (const wall of scene.walls) for (const [x, y] of wall.corners) see(x, y, 0.15);
    for (let k = 0; k < frame.length; k += COLUMNS) see(frame[k]!, frame[k + 1]!, 0.6);
    const scale = Math.min(width / (right - left), height / (high - low));
    return { scale, x: width / 2 - (scale * (left + right)) / 2, y: height / 2 + (scale * (low + high)) / 2 };
}

export class Painter {
    #paths: Path2D[];

    constructor(readonly scene: Scene) {
        const known = new Map<string, Path2D>();
        this.#paths = scene.agents.map(({ disks }) => {
            const key = JSON.stringify(disks);
            const path = known.get(key) ?? outline(disks);
            known.set(key, path);
            return path;
        });
    }

    paint(canvas: HTMLCanvasElement, frame: Float64Array, view: View, scale: Scale, selected: number | null) {
        const context = canvas.getContext("2d")!;
        const style = getComputedStyle(canvas);
        const [ink, mark] = [style.getPropertyValue("--ink"), style.getPropertyValue("--mark")];
        context.setTransform(1, 0, 0, 1, 0, 0);
        context.clearRect(0, 0, canvas.width, canvas.height);
        this.#paths.forEach((path, a) => {
            const [x, y, turn] = [frame[COLUMNS * a]!, frame[COLUMNS * a + 1]!, frame[COLUMNS * a + 2]!];
            const [cos, sin] = [view.scale * Math.cos(turn), view.scale * Math.sin(turn)];
            // Up is up: pixels count downwards.
            context.setTransform(cos, -sin, -sin, -cos, view.x + view.scale * x, view.y - view.scale * y);
            context.fillStyle = colourOf(frame[COLUMNS * a + scale.column]! / scale.most);
            // The outline of all disks is what is left of their rims around the filled shape.
            context.strokeStyle = a === selected ? mark : ink;
            context.lineWidth = (a === selected ? 6 : 2) / view.scale;
            context.stroke(path);
            context.fill(path);
        });
        context.setTransform(view.scale, 0, 0, -view.scale, view.x, view.y);
        context.strokeStyle = ink;
        context.lineWidth = 2 / view.scale;
        context.beginPath();
        for (const { corners } of this.scene.walls) {
            corners.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
        }
        context.stroke();
    }

    /** The agent at a pixel. */
    at(canvas: HTMLCanvasElement, frame: Float64Array, view: View, x: number, y: number): number | null {
        const context = canvas.getContext("2d")!;
        const [right, up] = [(x - view.x) / view.scale, (view.y - y) / view.scale];
        for (let a = this.#paths.length - 1; a >= 0; a--) {
            const turn = frame[COLUMNS * a + 2]!;
            const [dx, dy] = [right - frame[COLUMNS * a]!, up - frame[COLUMNS * a + 1]!];
            const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
            context.setTransform(1, 0, 0, 1, 0, 0);
            if (context.isPointInPath(this.#paths[a]!, cos * dx + sin * dy, cos * dy - sin * dx)) return a;
        }
        return null;
    }
}
