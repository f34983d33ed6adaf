// Rooms while they are drawn, by a lab of the page's own: the mouse cannot wait until the worker has time, and a room must
// be changed before the next key or click. An answer takes a fraction of a millisecond. It also counts the time above a limit,
// which is written with the frame that is shown.

import { effect, signal } from "@preact/signals";
import { inWords, t } from "./language";
import type { Drawn, Limit, LimitRequest, Outline, Point, Room, RoomEdit } from "./protocol";
import { client } from "./session";
import { answer, type Lab, load } from "./wasm";

const lab = signal<Lab | null>(null);
effect(() => {
    if (client.module.value) void load(client.module.value, () => 0).then((loaded) => (lab.value = loaded));
});

/** Whether rooms can be drawn. */
export function ready() {
    return lab.value !== null;
}

function ask(room: Room, edit: RoomEdit | null, near: Point | null): Drawn {
    if (!lab.value) throw new Error(t("the lab is not loaded yet"));
    const { value } = answer(lab.value, { ask: "room", room, edit, near });
    if ("refused" in value) throw new Error(inWords(value.refused));
    return value.ok;
}

/** Adds squeezes to what is known of a limit. */
export function limit(wanted: LimitRequest, squeezes: Uint8Array<ArrayBuffer>): Limit {
    const { value } = answer(lab.value!, { ask: "limit", ...wanted }, squeezes);
    if ("refused" in value) throw new Error(inWords(value.refused));
    return value.ok;
}

/** What of it is seen, and which wall is near to a place. */
export function drawn(room: Room, near: Point | null = null): Drawn {
    return ask(room, null, near);
}

export function edited(room: Room, edit: RoomEdit): Room {
    const { outline, obstacles, walls, doors } = ask(room, edit, null).room;
    // Plans are compared as text: parts have an order, and what is not there is left out.
    const further = walls?.map(({ corners, of }) => ({ corners, of }));
    return { outline, obstacles, ...(further && { walls: further }), doors: doors.map(({ at, width, open }) => ({ at, width, ...(open && { open }) })) };
}

/** The shape of an outline alone. */
export function shape(outline: Point[]): Outline {
    return drawn({ outline, obstacles: [], doors: [] }).rings[0]!;
}
