// Exits and goals on the picture.

import { handle, type Inks, label, through } from "./draw";
import type { Point, Scene } from "./protocol";
import { inMetres, type View } from "./view";

type Drawn = Scene["targets"][number];

/** Between its corners: the handle by which all of it moves. */
export function middleOf(corners: Point[]): Point {
    const mean = (axis: 0 | 1) => corners.reduce((sum, corner) => sum + corner[axis], 0) / Math.max(1, corners.length);
    return [mean(0), mean(1)];
}

/** Exits are whole lines, goals dashed ones, with their names. */
export function paintPlaces(context: CanvasRenderingContext2D, places: Drawn[], view: View, inks: Inks, picked: number | null = null) {
    const pixel = devicePixelRatio / view.scale;
    places.forEach(({ stay, corners }, k) => {
        inMetres(context, view);
        const area = corners.length > 2;
        through(context, corners, area);
        const ink = stay ? inks.goal : inks.exit;
        if (area) {
            context.fillStyle = ink;
            context.globalAlpha = 0.14;
            context.fill();
            context.globalAlpha = 1;
        }
        const width = k === picked ? 6 : 4;
        context.lineCap = "butt";
        for (const [colour, wide] of [[inks.paper, width + 3], [ink, width]] as const) {
            context.strokeStyle = colour;
            context.lineWidth = wide * pixel;
            if (stay && colour === ink) context.setLineDash([9 * pixel, 5 * pixel]);
            context.stroke();
            context.setLineDash([]);
        }
    });
    for (const { name, corners } of places) label(context, name, middleOf(corners), view, inks);
}

/** Squares at the corners that can be dragged. */
export function paintHandles(context: CanvasRenderingContext2D, corners: Point[], view: View, inks: Inks, ink: string, marked: boolean) {
    inMetres(context, view);
    const pixel = devicePixelRatio / view.scale;
    const half = (marked ? 6 : 4.5) * pixel;
    context.strokeStyle = ink;
    context.lineWidth = 2 * pixel;
    for (const corner of corners) handle(context, corner, half, marked ? inks.mark : inks.paper);
}
