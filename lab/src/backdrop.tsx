// A picture under the room, to draw over: a floor plan, a photograph. It is no part of the mechanics.

import { computed, effect, signal, untracked } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { strokes, through } from "./draw";
import { ready, shape } from "./drawn";
import type { Backdrop } from "./forms";
import { MOST } from "./forms";
import { draws, handles } from "./handles";
import { t } from "./language";
import { Button, LengthField, Range } from "./parts";
import { change, keysInUse, opened, plan } from "./plan";
import type { Point } from "./protocol";
import { distance, rings } from "./roomshape";
import { room } from "./roomtool";
import { bases, problem, said } from "./session";
import { brief, keep, kept } from "./store";
import { begin, endOf, mode, over, sketch, turn } from "./tool";
import { FileInput, tooLong } from "./upload";
import { toPixels, type View } from "./view";

/** In byte: the largest file; in pixels: the largest picture, its longest side as it is kept, and that of a drawing. */
const MOST_BYTES = 20e6;
const MOST_PIXELS = 100e6;
const LONGEST = 4096;
const DRAWN = 2048;
/** In m: its least and its greatest width. */
const [NARROWEST, WIDEST] = [0.1, 10_000];
/** How much of it is seen at first. */
const FAINT = 0.5;

const TYPES: Record<string, string> = { png: "image/png", jpg: "image/jpeg", jpeg: "image/jpeg", webp: "image/webp", svg: "image/svg+xml" };
const typeOf = (name: string) => TYPES[name.toLowerCase().split(".").at(-1)!];

/** Whether a file can be a picture only. */
export function isPicture(name: string) {
    return typeOf(name) !== undefined && !isVector(name);
}

export function isVector(name: string) {
    return /\.svg$/i.test(name);
}

/** What is drawn, and why it is not. */
const image = signal<ImageBitmap | null>(null);
const absent = signal(false);
const key = computed(() => plan.value.backdrop?.key ?? null);

effect(() => {
    const wanted = key.value;
    image.value = null;
    absent.value = false;
    if (wanted !== null) void load(wanted);
});

async function load(wanted: string) {
    const bytes = await kept(wanted);
    const found = bytes && (await createImageBitmap(new Blob([bytes as Uint8Array<ArrayBuffer>])).catch(() => null));
    if (key.peek() !== wanted) return;
    image.value = found;
    absent.value = !found;
}

/** Lays a picture under the room, in the place of the one that is there. Only pixels of it are kept: a drawing may hold
 * scripts and addresses, which nobody runs or asks. */
export async function setPicture(file: File) {
    const { name } = file;
    if (file.size > MOST_BYTES) throw new Error(t('"{name}" has more than {most} MB', { name, most: MOST_BYTES / 1e6 }));
    if (name.length > MOST.name) throw new Error(tooLong(name));
    const url = URL.createObjectURL(new Blob([file], { type: typeOf(name) }));
    try {
        const picture = new Image();
        await new Promise((done, failed) => {
            picture.onload = done;
            picture.onerror = () => failed(new Error(t('"{name}" is no picture that this browser can show', { name })));
            picture.src = url;
        });
        const [width, height] = [picture.naturalWidth, picture.naturalHeight];
        if (!(width > 0 && height > 0)) throw new Error(t('"{name}" does not say how large it is', { name }));
        if (width * height > MOST_PIXELS) throw new Error(t('"{name}" has {width} × {height} pixels: at most {most} million are allowed', { name, width, height, most: MOST_PIXELS / 1e6 }));
        const scale = isVector(name) ? DRAWN / Math.max(width, height) : Math.min(1, LONGEST / Math.max(width, height));
        const whole = !isVector(name) && scale === 1;
        const bytes = whole ? await file.arrayBuffer() : await pixels(picture, width * scale, height * scale, name);
        lay(name, await keep(new Uint8Array(bytes), keysInUse()), height / width);
    } finally {
        URL.revokeObjectURL(url);
    }
}

async function pixels(picture: HTMLImageElement, width: number, height: number, name: string): Promise<ArrayBuffer> {
    const on = document.createElement("canvas");
    [on.width, on.height] = [Math.max(1, Math.round(width)), Math.max(1, Math.round(height))];
    on.getContext("2d")!.drawImage(picture, 0, 0, on.width, on.height);
    const made = await new Promise<Blob | null>((done, failed) => {
        try {
            on.toBlob(done, "image/png");
        } catch {
            failed(new Error(t('"{name}" holds parts that this browser does not give away as pixels', { name })));
        }
    });
    if (!made) throw new Error(t('"{name}" is too large for a picture of this browser', { name }));
    return made.arrayBuffer();
}

function lay(name: string, key: string, aspect: number) {
    const before = plan.value.backdrop;
    // Another picture of the same plan lies as the one before.
    const corners = rings(room.value).flat();
    const [wide, , left, low] = corners.length > 0 && ready() ? shape(corners).bounds : [10, 10, 0, 0];
    const place = before ? { at: before.at, width: before.width, opacity: before.opacity } : { at: [left, low] as Point, width: Math.max(1, wide), opacity: FAINT };
    change({ backdrop: { name, key, ...place, aspect } });
    said.value = brief.has(key) ? t("\"{name}\" lies under the room. This browser's storage has no room for it: it is there until the page is closed.", { name }) : t('"{name}" lies under the room. Set its scale.', { name });
}

/** While it is moved. */
const moved = signal<Backdrop | null>(null);

export function paintBackdrop(context: CanvasRenderingContext2D, view: View) {
    const now = moved.value ?? plan.value.backdrop;
    const picture = image.value;
    if (!now || !picture) return;
    const [x, y] = toPixels(view, [now.at[0], now.at[1] + now.width * now.aspect]);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalAlpha = now.opacity;
    context.drawImage(picture, x, y, now.width * view.scale, now.width * now.aspect * view.scale);
    context.globalAlpha = 1;
}

/** Its corners, to be seen while rooms are drawn. */
export function reachOfBackdrop(): Point[] {
    const now = plan.value.backdrop;
    return now ? [now.at, [now.at[0] + now.width, now.at[1] + now.width * now.aspect]] : [];
}

draws({
    // Its ends stay until its length is known.
    scale: {
        points: [2, 2],
        place: ({ at }) => at,
        done(ends) {
            begin("scale");
            sketch.value = ends;
        },
        paint(context, ends, view, inks) {
            through(context, ends);
            strokes(context, [[inks.mark, (3 * devicePixelRatio) / view.scale]]);
        },
    },
});

over.move = handles<Backdrop, Point>({
    draws: () => true,
    now: () => plan.value.backdrop,
    dragged: moved,
    grab: (_, { at }) => ({ part: at }),
    drag: (start, { at }, from) => ({ ...from, at: [0, 1].map((k) => Number((from.at[k]! + at[k]! - start[k]!).toFixed(3))) as Point }),
    put: (backdrop) => change({ backdrop }),
});

const end = () => endOf(["scale", "move"]);

// They are of one picture, which lies under one room.
effect(() => {
    key.value;
    bases.value;
    opened.value;
    untracked(end);
});

/** The line gets this length; its first end stays where it is. */
function setLength(now: Backdrop, known: number) {
    const [from, to] = sketch.value as [Point, Point];
    const by = known / distance(from, to);
    const width = Number((by * now.width).toFixed(4));
    if (!(width >= NARROWEST && width <= WIDEST)) {
        problem.value = t("So the picture would be {width} m wide: {least} to {most} m are allowed.", { width: Number(width.toPrecision(3)), least: NARROWEST, most: WIDEST });
        return;
    }
    const at = [0, 1].map((k) => Number((from[k]! + by * (now.at[k]! - from[k]!)).toFixed(4))) as Point;
    end();
    change({ backdrop: { ...now, at, width } });
}

export function BackdropForms() {
    const now = plan.value.backdrop;
    // Of another tab, nobody could end them.
    useEffect(() => () => void end(), []);
    if (!now) return null;
    const set = (part: Partial<Backdrop>) => change({ backdrop: { ...now, ...part } });
    const measuring = mode.value === "scale";
    const [from, to] = measuring ? sketch.value : [];
    return (
        <fieldset class="fields">
            <legend>
                {t("Picture")} "{now.name}"
            </legend>
            {absent.value && (
                <>
                    <p class="warning">{t("This picture is not kept in this browser: a link or a file of a scene holds no pictures. Open it again here.")}</p>
                    <FileInput label={t("Open the picture again")} accept=".png,.jpg,.jpeg,.webp,.svg" onFiles={async ([given]) => given && setPicture(given.file)} />
                </>
            )}
            <div class="buttons">
                <Button words={t("Set the scale by a known length")} aria-pressed={measuring} onClick={() => turn("scale")} />
                <Button words={t("Move it with the mouse")} aria-pressed={mode.value === "move"} onClick={() => turn("move")} />
                <Button words={t("Remove the picture")} onClick={() => (end(), change({ backdrop: null }))} />
            </div>
            {measuring && !to && <p class="note" role="status">{from ? t("Click the other end of the line.") : t("Click one end of a line whose length you know.")}</p>}
            {measuring && from && to && <LengthField label={t("Real length of the line")} value={distance(from, to)} min={0.01} max={10000} onChange={(known) => setLength(now, known)} />}
            <LengthField label={t("Width of the picture")} value={now.width} min={NARROWEST} max={WIDEST} onChange={(width) => set({ width })} />
            <div class="row">
                <LengthField of={t("Picture")} label={t("left")} value={now.at[0]} min={-1e6} max={1e6} onChange={(x) => set({ at: [x, now.at[1]] })} />
                <LengthField of={t("Picture")} label={t("low")} value={now.at[1]} min={-1e6} max={1e6} onChange={(y) => set({ at: [now.at[0], y] })} />
            </div>
            <label class="scrub">
                <span>{t("How much of it is seen")}</span>
                <Range min={0.05} max={1} step={0.05} value={now.opacity} onChange={(opacity) => set({ opacity })} />
            </label>
            <p class="note">{t("The picture is drawn under the room and changes nothing else. It is kept with the scene in this browser, and is in no link.")}</p>
        </fieldset>
    );
}
