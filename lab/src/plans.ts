// Files with a plan or a picture: what they are, and where they go.

import { isPicture, setPicture } from "./backdrop";
import { understand } from "./drawing";
import { t } from "./language";
import { change } from "./plan";
import { openFile } from "./scenes";

/** In m byte: the largest drawing that the lab reads is smaller. */
const MOST_BYTES = 64e6;

const DRAWINGS = /\.(dxf|geojson|json|wkt|txt|svg|xml)$/i;
/** What a field for such files offers. */
export const PLANS = ".dxf,.geojson,.json,.wkt,.txt,.svg,.xml,.png,.jpg,.jpeg,.webp";

/** Whether a file by itself is a plan or a picture, and no Trial. */
export function isPlan({ name }: File): boolean {
    return isPicture(name) || DRAWINGS.test(name);
}

/** A picture lies under the room; of a drawing it is told what it holds. A scene's own file is opened as such. */
export async function openPlan(file: File) {
    if (isPicture(file.name)) {
        change({ tab: "room" });
        return setPicture(file);
    }
    if (!DRAWINGS.test(file.name)) throw new Error(t('"{name}" is no plan: its name must end in .dxf, .geojson, .wkt, .svg or .xml', { name: file.name }));
    if (file.size > MOST_BYTES) throw new Error(t('"{name}" has more than {most} MB', { name: file.name, most: MOST_BYTES / 1e6 }));
    const bytes = new Uint8Array(await file.arrayBuffer());
    if (/\.json$/i.test(file.name) && !isGeoJson(bytes)) return openFile(file);
    change({ tab: "room" });
    await understand({ file, bytes });
}

/** Each object of GeoJSON has a type; a scene has none. */
function isGeoJson(bytes: Uint8Array): boolean {
    try {
        const { type } = JSON.parse(new TextDecoder().decode(bytes)) as { type?: unknown };
        return typeof type === "string";
    } catch {
        return false;
    }
}
