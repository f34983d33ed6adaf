// Draws a frame. Shapes are the disks that the engine uses, or the sections that it gives; only turning, moving and
// scaling happens here.

import { type Shade, THINGS } from "./colour";
import { local } from "./language";
import { type AgentShown, COLUMNS, type Disk, FEET, isThere, type OpenTime, type Point, type Push, type Scene, type Waypoint } from "./protocol";
import { inMetres, toMetres, toPixels, type View } from "./view";

/** Whether a wall is open at a time in s. A rounding error is none. */
export function isOpen(open: OpenTime[] | undefined, time: number): boolean {
    return open?.some(([from, to]) => time + 1e-9 >= from && time + 1e-9 < to) ?? false;
}

/** Begins a path through corners. */
export function through(context: CanvasRenderingContext2D, corners: readonly Point[], closed = false) {
    context.beginPath();
    corners.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
    if (closed) context.closePath();
}

/** Strokes it several times: a thinner line lies on a wider one. */
export function strokes(context: CanvasRenderingContext2D, pens: readonly (readonly [colour: string, width: number])[]) {
    for (const [colour, width] of pens) {
        context.strokeStyle = colour;
        context.lineWidth = width;
        context.stroke();
    }
}

/** Begins a circle. */
export function circle(context: CanvasRenderingContext2D, [x, y]: Point, radius: number) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
}

/** A handle: a square that can be dragged. */
export function handle(context: CanvasRenderingContext2D, [x, y]: Point, half: number, fill: string) {
    context.fillStyle = fill;
    context.fillRect(x - half, y - half, 2 * half, 2 * half);
    context.strokeRect(x - half, y - half, 2 * half, 2 * half);
}

export function outline(disks: Disk[]): Path2D {
    const path = new Path2D();
    for (const [x, y, radius] of disks) {
        path.moveTo(x + radius, y);
        path.arc(x, y, radius, 0, 2 * Math.PI);
    }
    return path;
}

/** Colours of the style sheet. */
export interface Inks {
    ink: string;
    paper: string;
    mark: string;
    pick: string;
    way: string;
    exit: string;
    goal: string;
}

export function inksOf(canvas: HTMLCanvasElement): Inks {
    const style = getComputedStyle(canvas);
    const named = (name: string) => style.getPropertyValue(`--${name}`);
    return { ink: named("ink"), paper: named("paper"), mark: named("mark"), pick: named("pick"), way: named("way"), exit: named("exit"), goal: named("goal") };
}

export interface Picture {
    frame: Float32Array;
    /** Colours of each person. */
    shades: Shade[];
    /** Instead of the disks. */
    paths: Path2D[] | null;
    selected: number | null;
    overlapping: readonly number[];
    /** People fade where something else is looked at. */
    faint: boolean;
}

/** Half the side of the largest square that is drawn instead of a circle, in pixels of the canvas. */
const SQUARE = 2.5;

interface Group {
    disks: Disk[];
    fill: string;
}

/** The disks of things of each material, with its colour. */
export function thingsOf({ disks, things }: Pick<AgentShown, "disks" | "things">): Group[] | null {
    if (!things) return null;
    return (["frame", "luggage"] as const).map((material) => ({ disks: disks.filter((_, k) => things[k] === material), fill: THINGS[material] })).filter(({ disks }) => disks.length > 0);
}

export class Painter {
    #paths: Path2D[];
    /** Disks of things and of bodies, of those with whom something goes along. */
    #things: (Group[] | null)[];
    #bodies: (Disk[] | null)[];

    constructor(readonly scene: Scene) {
        this.#things = scene.agents.map(thingsOf);
        this.#bodies = scene.agents.map(({ things, disks, seated }) => things && [...disks.filter((_, k) => things[k] === null), ...(seated ?? [])]);
        const known = new Map<string, Path2D>();
        this.#paths = scene.agents.map(({ disks }) => {
            const key = JSON.stringify(disks);
            const path = known.get(key) ?? outline(disks);
            known.set(key, path);
            return path;
        });
    }

    #place(context: CanvasRenderingContext2D, frame: Float32Array, a: number, view: View) {
        const [x, y, turn] = [frame[COLUMNS * a]!, frame[COLUMNS * a + 1]!, frame[COLUMNS * a + 2]!];
        const [cos, sin] = [view.scale * Math.cos(turn), view.scale * Math.sin(turn)];
        // Up is up: pixels count downwards.
        context.setTransform(cos, -sin, -sin, -cos, view.x + view.scale * x, view.y - view.scale * y);
    }

    /** Things first, then bodies, also those that sit in things. */
    #disks(context: CanvasRenderingContext2D, { frame, shades }: Picture, view: View, rim: number, only: number | null = null) {
        context.setTransform(1, 0, 0, 1, 0, 0);
        this.scene.agents.forEach(({ disks }, a) => {
            if (!isThere(frame, a) || (only !== null && only !== a)) return;
            for (const { disks: own, fill } of this.#things[a] ?? []) this.#fill(context, own, frame, a, view, rim, { fill, rim: "#1b1b1b" });
            this.#fill(context, this.#bodies[a] ?? disks, frame, a, view, rim, shades[a]!);
        });
    }

    /** Twice filled, in pixels, each disk for itself: without a graphics card browsers take much longer for strokes, for
     * arcs that are turned, and for paths of several arcs. */
    #fill(context: CanvasRenderingContext2D, disks: Disk[], frame: Float32Array, a: number, view: View, rim: number, shade: Shade) {
        const [x, y] = [view.x + view.scale * frame[COLUMNS * a]!, view.y - view.scale * frame[COLUMNS * a + 1]!];
        const turn = frame[COLUMNS * a + 2]!;
        const [cos, sin] = [view.scale * Math.cos(turn), view.scale * Math.sin(turn)];
        for (const wider of [rim, 0]) {
            context.fillStyle = wider ? shade.rim : shade.fill;
            for (const [dx, dy, radius] of disks) {
                const [right, down] = [x + cos * dx - sin * dy, y - sin * dx - cos * dy];
                const half = view.scale * radius + wider;
                // So small, a square looks the same.
                if (half < SQUARE) {
                    context.fillRect(right - half, down - half, 2 * half, 2 * half);
                    continue;
                }
                circle(context, [right, down], half);
                context.fill();
            }
        }
    }

    #sections(context: CanvasRenderingContext2D, paths: Path2D[], { frame, shades }: Picture, view: View, width: number) {
        context.lineWidth = width / view.scale;
        // Things have no sections: they are there, but pale.
        const alpha = context.globalAlpha;
        context.globalAlpha = 0.3 * alpha;
        context.setTransform(1, 0, 0, 1, 0, 0);
        this.#things.forEach((things, a) => {
            if (isThere(frame, a)) for (const { disks, fill } of things ?? []) this.#fill(context, disks, frame, a, view, width / 2, { fill, rim: "#1b1b1b" });
        });
        context.globalAlpha = alpha;
        paths.forEach((path, a) => {
            if (!isThere(frame, a)) return;
            this.#place(context, frame, a, view);
            context.strokeStyle = shades[a]!.rim;
            context.fillStyle = shades[a]!.fill;
            context.stroke(path);
            context.fill(path);
        });
    }

    people(context: CanvasRenderingContext2D, picture: Picture, view: View, inks: Inks) {
        const { frame, shades } = picture;
        const selected = picture.selected !== null && isThere(frame, picture.selected) ? picture.selected : null;
        const paths = picture.paths ?? this.#paths;
        const rim = 0.5 * Math.max(1, Math.min(2, view.scale / 40)) * devicePixelRatio;
        context.globalAlpha = picture.faint ? 0.35 : 1;
        if (picture.paths) this.#sections(context, picture.paths, picture, view, 2 * rim);
        else this.#disks(context, picture, view, rim);
        this.#gazes(context, frame, view);
        this.#legs(context, frame, view);
        if (selected !== null && paths[selected]) {
            this.#place(context, frame, selected, view);
            context.lineWidth = (5 * devicePixelRatio) / view.scale;
            context.strokeStyle = inks.pick;
            context.stroke(paths[selected]);
            if (picture.paths) {
                context.fillStyle = shades[selected]!.fill;
                context.fill(paths[selected]);
            } else this.#disks(context, picture, view, rim, selected);
        }
        for (const a of picture.overlapping) if (paths[a] && isThere(frame, a)) this.#overlap(context, paths[a], frame, a, view, inks);
        context.globalAlpha = 1;
        if (selected !== null) this.#halo(context, frame, selected, view, inks);
    }

    /** Where they look, if there is room for it. */
    #gazes(context: CanvasRenderingContext2D, frame: Float32Array, view: View) {
        if (view.scale < 40 * devicePixelRatio) return;
        inMetres(context, view);
        context.beginPath();
        for (let k = 0; k < frame.length; k += COLUMNS) {
            if (!this.scene.agents[k / COLUMNS]!.disks.length) continue;
            const [x, y, turn] = [frame[k]!, frame[k + 1]!, frame[k + 2]!];
            const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
            context.moveTo(x + 0.03 * cos + 0.06 * sin, y + 0.03 * sin - 0.06 * cos);
            context.lineTo(x + 0.1 * cos, y + 0.1 * sin);
            context.lineTo(x + 0.03 * cos - 0.06 * sin, y + 0.03 * sin + 0.06 * cos);
        }
        // Light on dark, or it would not be seen on half of the colours.
        const pixel = devicePixelRatio / view.scale;
        strokes(context, [["rgb(0 0 0 / 0.6)", 3 * pixel], ["#ffffff", 1.5 * pixel]]);
    }

    /** Feet, as if they were seen through the bodies, and lines from there to the centres of mass. */
    #legs(context: CanvasRenderingContext2D, frame: Float32Array, view: View) {
        const [feet, leans] = [new Path2D(), new Path2D()];
        for (let k = 0; k < frame.length; k += COLUMNS) {
            const [x, y, turn, fx, fy] = [frame[k]!, frame[k + 1]!, frame[k + 2]!, frame[k + FEET]!, frame[k + FEET + 1]!];
            if (Number.isNaN(x) || Number.isNaN(fx)) continue;
            const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
            for (const aside of [-0.09, 0.09]) {
                feet.moveTo(fx - 0.085 * cos - aside * sin, fy - 0.085 * sin + aside * cos);
                feet.lineTo(fx + 0.085 * cos - aside * sin, fy + 0.085 * sin + aside * cos);
            }
            leans.moveTo(fx, fy);
            leans.lineTo(x, y);
        }
        inMetres(context, view);
        context.lineCap = "round";
        const pixel = devicePixelRatio / view.scale;
        const [width, rim] = [0.09, Math.min(pixel, 0.018)];
        for (const [path, colour, wide] of [
            [feet, "rgb(28 43 64 / 0.6)", width],
            [feet, "rgb(255 255 255 / 0.7)", width - 2 * rim],
            [leans, "rgb(255 255 255 / 0.7)", 3 * rim],
            [leans, "#1c2b40", 1.2 * rim],
        ] as const) {
            context.strokeStyle = colour;
            context.lineWidth = wide;
            context.stroke(path);
        }
    }

    /** Hatched, with a thick rim. */
    #overlap(context: CanvasRenderingContext2D, path: Path2D, frame: Float32Array, a: number, view: View, inks: Inks) {
        context.save();
        this.#place(context, frame, a, view);
        context.clip(path);
        context.strokeStyle = inks.mark;
        const pixel = devicePixelRatio / view.scale;
        context.lineWidth = Math.max(0.015, 1.5 * pixel);
        context.beginPath();
        for (let k = -1; k <= 1; k += Math.max(0.06, 5 * pixel)) {
            context.moveTo(k, -0.5);
            context.lineTo(k + 1, 0.5);
        }
        context.stroke();
        context.lineWidth = Math.max(0.03, 3 * pixel);
        context.stroke(path);
        context.restore();
    }

    #halo(context: CanvasRenderingContext2D, frame: Float32Array, a: number, view: View, inks: Inks) {
        const [x, y] = [frame[COLUMNS * a]!, frame[COLUMNS * a + 1]!];
        inMetres(context, view);
        circle(context, [x, y], 0.4);
        context.setLineDash([0.08, 0.05]);
        strokes(context, [[inks.pick, (2 * devicePixelRatio) / view.scale]]);
        context.setLineDash([]);
    }

    /** Walls that are open at a time in s are dashed. */
    walls(context: CanvasRenderingContext2D, view: View, inks: Inks, time: number) {
        inMetres(context, view);
        context.strokeStyle = inks.ink;
        context.lineWidth = (3 * devicePixelRatio) / view.scale;
        context.lineCap = "round";
        const pixel = devicePixelRatio / view.scale;
        const lines = (all: Point[][], dashed: boolean) => {
            context.setLineDash(dashed ? [2 * pixel, 8 * pixel] : []);
            context.beginPath();
            for (const line of all) line.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
            context.stroke();
        };
        const { walls, grounds, links } = this.scene;
        context.fillStyle = inks.ink;
        context.globalAlpha = 0.2;
        for (const { corners } of walls.filter(({ obstacle }) => obstacle)) {
            through(context, corners);
            context.fill();
        }
        context.globalAlpha = 1;
        for (const dashed of [false, true]) {
            lines(walls.filter(({ open }) => isOpen(open, time) === dashed).map(({ corners }) => corners as Point[]), dashed);
        }
        context.globalAlpha = 0.4;
        context.lineWidth = pixel;
        lines(grounds as Point[][], false);
        lines(links as Point[][], true);
        context.globalAlpha = 1;
        context.setLineDash([]);
    }

    /** The agent at a place; the one that is drawn last counts. */
    at(context: CanvasRenderingContext2D, frame: Float32Array, [right, up]: Point): number | null {
        context.setTransform(1, 0, 0, 1, 0, 0);
        for (let a = this.#paths.length - 1; a >= 0; a--) {
            const [dx, dy, turn] = [right - frame[COLUMNS * a]!, up - frame[COLUMNS * a + 1]!, frame[COLUMNS * a + 2]!];
            // Who has left is nowhere: no number.
            if (!(dx * dx + dy * dy <= 1)) continue;
            const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
            if (context.isPointInPath(this.#paths[a]!, cos * dx + sin * dy, cos * dy - sin * dx)) return a;
        }
        return null;
    }
}

/** Newtons for each metre of a push's arrow. */
export const ARROW = 500;

/** Where the arrow of a push ends. */
export function tip({ at, direction, force }: Push, most = Infinity): Point {
    const [length, angle] = [Math.min(most, force / ARROW), (direction * Math.PI) / 180];
    return [at[0] + length * Math.cos(angle), at[1] + length * Math.sin(angle)];
}

/** The share of its greatest force with which a push acts at a time: half a sine. */
export function pulse({ start, duration }: Push, time: number) {
    return time > start && time < start + duration ? Math.sin((Math.PI * (time - start)) / duration) : 0;
}

export function paintPush(context: CanvasRenderingContext2D, push: Push, time: number, view: View, inks: Inks, picked = false, handles = false) {
    inMetres(context, view);
    const pixel = devicePixelRatio / view.scale;
    const acting = pulse(push, time);
    context.strokeStyle = inks.mark;
    context.fillStyle = inks.mark;
    circle(context, push.at, push.radius);
    // People in it are seen.
    context.globalAlpha = 0.08;
    context.fill();
    context.globalAlpha = 1;
    context.lineWidth = (picked ? 3 : 1.5 + 2 * acting) * pixel;
    context.setLineDash([6 * pixel, 4 * pixel]);
    context.stroke();
    context.setLineDash([]);
    // Where its tip is no handle, it stays on the picture.
    paintArrow(context, push.at, tip(push, handles ? Infinity : context.canvas.width / (4 * view.scale)), (3 + 3 * acting) * pixel, inks.mark, inks.paper);
}

/** In metres; with a thin rim of another colour, to be seen on people. */
function paintArrow(context: CanvasRenderingContext2D, from: Point, to: Point, width: number, ink: string, rim: string) {
    const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
    const head = Math.min(5 * width, Math.hypot(to[0] - from[0], to[1] - from[1]));
    const back = (turn: number): Point => [to[0] - head * Math.cos(angle + turn), to[1] - head * Math.sin(angle + turn)];
    context.lineCap = "round";
    through(context, [from, to]);
    context.moveTo(...back(0.5));
    context.lineTo(...to);
    context.lineTo(...back(-0.5));
    strokes(context, [[rim, 2 * width], [ink, width]]);
}

export function paintWays(context: CanvasRenderingContext2D, ways: Waypoint[][], view: View, inks: Inks, picked: number | null = null, numbered = true) {
    const pixel = devicePixelRatio / view.scale;
    ways.forEach((way, w) => {
        inMetres(context, view);
        context.strokeStyle = inks.way;
        context.fillStyle = inks.way;
        context.lineWidth = (w === picked ? 3.5 : 2) * pixel;
        through(context, way.map(({ x, y }) => [x, y]));
        context.stroke();
        for (const { x, y, radius } of way) {
            circle(context, [x, y], radius);
            context.globalAlpha = 0.12;
            context.fill();
            context.globalAlpha = 1;
            context.setLineDash([5 * pixel, 4 * pixel]);
            context.stroke();
            context.setLineDash([]);
        }
        if (numbered) way.forEach(({ x, y }, k) => label(context, `${w + 1}.${k + 1}`, [x, y], view, inks));
    });
}

/** A short text on a ground of its own. */
export function label(context: CanvasRenderingContext2D, text: string, at: Point, view: View, inks: Inks) {
    const [place, y] = toPixels(view, at);
    const size = 12 * devicePixelRatio;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.font = `${size}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    const width = context.measureText(text).width + 0.6 * size;
    // Whole, also at the edge.
    const most = context.canvas.width;
    const x = place >= 0 && place <= most ? Math.max(width / 2, Math.min(place, most - width / 2)) : place;
    context.fillStyle = inks.paper;
    context.globalAlpha = 0.85;
    context.fillRect(x - width / 2, y - 0.7 * size, width, 1.4 * size);
    context.globalAlpha = 1;
    context.fillStyle = inks.ink;
    context.fillText(text, x, y);
}

/** A bar of a round length, at the lower left. */
export function paintBar(context: CanvasRenderingContext2D, view: View, unit: "m" | "cm", inks: Inks) {
    const height = context.canvas.height;
    const pixel = devicePixelRatio;
    const most = (Math.min(140, context.canvas.width / pixel / 3) * pixel) / view.scale;
    const size = 10 ** Math.floor(Math.log10(most));
    const length = [5, 2, 1].find((by) => by * size <= most)! * size;
    const [left, low, right] = [12 * pixel, height - 12 * pixel, 12 * pixel + length * view.scale];
    context.setTransform(1, 0, 0, 1, 0, 0);
    const words = unit === "cm" && length < 10 ? `${Number((100 * length).toPrecision(2))} cm` : `${local(Number(length.toPrecision(2)))} m`;
    context.lineCap = "butt";
    through(context, [[left, low - 5 * pixel], [left, low], [right, low], [right, low - 5 * pixel]]);
    strokes(context, [[inks.paper, 5 * pixel], [inks.ink, 2 * pixel]]);
    label(context, words, toMetres(view, (left + right) / 2, low - 12 * pixel), view, inks);
}
