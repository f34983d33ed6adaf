// The room of a crowd: drawn on the picture, or written as numbers.

import { useEffect } from "preact/hooks";
import { MakeCrowd } from "./crowd";
import { edited, ready, shape } from "./drawn";
import { LengthField, length } from "./parts";
import { roomFits, type KeptCrowd, MOST } from "./forms";
import { change, plan } from "./plan";
import type { Outline, Point, Room } from "./protocol";
import { begin, insert, type Mode, mode, remove, roomTool, setRoom } from "./roomtool";
import { rectangle, rings } from "./roomshape";
import { client, made, notes } from "./session";
import { useTool } from "./tool";
import { FileInput, type Given } from "./upload";

/** The largest coordinate and side, in m. */
const FAR = 1000;

const MODES: [Mode, string, string][] = [
    ["outline", "Draw the outline", "Click the corners of the room. Enter, a double click or a click on the first corner ends it."],
    ["rectangle", "Draw an obstacle", "Press at one corner of a rectangle and draw to the other one."],
    ["polygon", "Draw an obstacle of any shape", "Click its corners. Enter, a double click or a click on the first corner ends it."],
    ["door", "Put a door", "Click on a wall."],
    ["region", "Draw where people stand", "Press at one corner of a rectangle and draw to the other one."],
];

export function RoomTab() {
    return ready() ? <Forms /> : <p role="status">One moment …</p>;
}

function Forms() {
    useEffect(() => () => begin("change"), []);
    useTool(roomTool);
    const { crowd, made: planned, unit } = plan.value;
    const { room } = crowd;
    const hint = MODES.find(([key]) => key === mode.value)?.[2];
    const same = planned.base.kind === "crowd" && JSON.stringify(planned.base.room) === JSON.stringify(room);
    return (
        <section class="panel" aria-label="Room">
            <h2>Room</h2>
            <Size room={room} />
            <div class="buttons" role="group" aria-label="Draw on the picture">
                {MODES.map(([key, words]) => (
                    <button key={key} type="button" aria-pressed={mode.value === key} onClick={() => begin(mode.value === key ? "change" : key)}>
                        {words}
                    </button>
                ))}
            </div>
            <p class="note" role="status">
                {hint
                    ? `${hint} Esc ends it without a change.${mode.value === "outline" || mode.value === "polygon" ? " Hold Shift for right angles." : ""}`
                    : "Drag corners and doors on the picture. A click on a wall makes a corner; the Delete key removes what is marked."}
            </p>
            <Ring title="Corners" name="Corner" room={room} ring={0} />
            <Doors room={room} />
            {room.obstacles.map((_, k) => (
                // Obstacles have no names but their places.
                <Ring key={k} title={`Obstacle ${k + 1}`} name={`Obstacle ${k + 1}, corner`} room={room} ring={k + 1} />
            ))}
            <Region crowd={crowd} />
            <FileInput label="Take the room of a Geometry.xml" accept=".xml" onFiles={geometry} />
            {made.value && same && (
                <p class="note">
                    The free ground has {made.value.area.toFixed(2)} m²{crowd.region && " where people stand"}.
                </p>
            )}
            <MakeCrowd />
            <p class="note">Outlines of up to {MOST.corners} corners; corners snap to {length(0.05, unit)}.</p>
        </section>
    );
}

async function geometry([given]: Given[]) {
    if (!given) return;
    if (given.file.size > 5e6) throw new Error(`${given.path} has more than 5 MB`);
    const bytes = new Uint8Array(await given.file.arrayBuffer());
    const { value } = await client.ask<Room & { notes: string[] }>({ ask: "geometry", name: given.path }, bytes);
    const { outline, obstacles, doors } = value;
    if (!roomFits({ outline, obstacles, doors })) {
        throw new Error(`${given.path}: this page takes outlines of up to ${MOST.corners} corners, up to ${MOST.parts} obstacles and up to ${MOST.parts} doors; this room has more`);
    }
    change({ crowd: { ...plan.value.crowd, room: { outline, obstacles, doors }, region: null } });
    notes.value = value.notes;
}

function Size({ room }: { room: Room }) {
    const { bounds, upright } = shape(room.outline);
    if (!upright) {
        return (
            <p class="note">
                A polygon with {room.outline.length} corners.{" "}
                <button type="button" onClick={() => setRoom({ outline: rectangle(4, 4), obstacles: [], doors: [] })}>
                    Make it a rectangle
                </button>
            </p>
        );
    }
    const [width, height, left, low] = bounds;
    const set = (wide: number, high: number) => {
        const { crowd } = plan.value;
        // The part of the room where people stand stays the same part of it.
        const stretched = ([x, y]: Point): Point => [left + ((x - left) * wide) / width, low + ((y - low) * high) / height];
        const region = crowd.region?.map((corner) => stretched(corner).map((place) => Number(place.toFixed(3))) as Point) ?? null;
        change({ crowd: { ...crowd, room: edited(room, { do: "stretch", width: wide, height: high }), region } });
    };
    return (
        <div class="row">
            <LengthField label="Room width" value={width} min={0.1} max={FAR} onChange={(value) => set(value, height)} />
            <LengthField label="Room height" value={height} min={0.1} max={FAR} onChange={(value) => set(width, value)} />
        </div>
    );
}

function PointFields({ name, at, onChange }: { name: string; at: Point; onChange(at: Point): void }) {
    return (
        <>
            <LengthField label={`${name}, x`} short="x" value={at[0]} min={-FAR} max={FAR} onChange={(x) => onChange([x, at[1]])} />
            <LengthField label={`${name}, y`} short="y" value={at[1]} min={-FAR} max={FAR} onChange={(y) => onChange([at[0], y])} />
        </>
    );
}

function Ring({ title, name, room, ring }: { title: string; name: string; room: Room; ring: number }) {
    const corners = rings(room)[ring]!;
    return (
        <details>
            <summary>
                {title} <span class="unit">({corners.length}{ring > 0 && " corners"})</span>
            </summary>
            {corners.map((at, k) => (
                <div class="row" key={k}>
                    <span class="which">{k + 1}</span>
                    <PointFields name={`${name} ${k + 1}`} at={at} onChange={(to) => setRoom(edited(room, { do: "move", ring, corner: k, to }))} />
                    <button type="button" aria-label={`Insert a corner after ${name.toLowerCase()} ${k + 1}`} onClick={() => setRoom(insert(room, ring, k))}>
                        +
                    </button>
                    <button type="button" aria-label={`Delete ${name.toLowerCase()} ${k + 1}`} disabled={corners.length <= 3} onClick={() => remove({ kind: "corner", ring, k })}>
                        ×
                    </button>
                </div>
            ))}
            {ring > 0 && (
                <button type="button" onClick={() => setRoom(edited(room, { do: "clear", ring }))}>
                    Delete {title.toLowerCase()}
                </button>
            )}
        </details>
    );
}

function Doors({ room }: { room: Room }) {
    const { doors } = room;
    const set = (k: number, part: Partial<Room["doors"][number]>) => setRoom({ ...room, doors: doors.map((door, j) => (j === k ? { ...door, ...part } : door)) });
    const add = () => setRoom({ ...room, doors: [...doors, { at: shape(room.outline).middles[1]!, width: 1 }] });
    return (
        <details open={doors.length > 0}>
            <summary>
                Doors <span class="unit">({doors.length})</span>
            </summary>
            {doors.map((door, k) => (
                <div class="row" key={k}>
                    <span class="which">{k + 1}</span>
                    <LengthField label={`Door ${k + 1}, width`} short="width" value={door.width} min={0.1} max={100} onChange={(width) => set(k, { width })} />
                    <PointFields name={`Door ${k + 1}`} at={door.at} onChange={(at) => set(k, { at })} />
                    <button type="button" aria-label={`Delete door ${k + 1}`} onClick={() => remove({ kind: "door", k })}>
                        ×
                    </button>
                </div>
            ))}
            {doors.length < MOST.parts && (
                <button type="button" onClick={add}>
                    Add a door by numbers
                </button>
            )}
            <p class="note">A door is a gap in the wall that is nearest to x and y.</p>
        </details>
    );
}

/** Where people are placed. */
function Region({ crowd }: { crowd: KeptCrowd }) {
    const { region, room } = crowd;
    const around = region && shape(region);
    const set = (next: Point[] | null) => change({ crowd: { ...crowd, region: next } });
    return (
        <details open={region !== null}>
            <summary>
                Where people stand <span class="unit">({region ? "a part of the room" : "the whole room"})</span>
            </summary>
            {around?.upright && <RegionFields bounds={around.bounds} set={set} />}
            {region ? (
                <button type="button" onClick={() => set(null)}>
                    Use the whole room
                </button>
            ) : (
                <button type="button" onClick={() => set(rectangle(...shape(room.outline).bounds))}>
                    Use a rectangle, by numbers
                </button>
            )}
        </details>
    );
}

function RegionFields({ bounds: [width, height, left, low], set }: { bounds: Outline["bounds"]; set(region: Point[]): void }) {
    const clean = (value: number) => Number(value.toFixed(3));
    return (
        <div class="row two">
            <LengthField label="Region, left" short="left" value={clean(left)} min={-FAR} max={FAR} onChange={(value) => set(rectangle(width, height, value, low))} />
            <LengthField label="Region, low" short="low" value={clean(low)} min={-FAR} max={FAR} onChange={(value) => set(rectangle(width, height, left, value))} />
            <LengthField label="Region, width" short="width" value={clean(width)} min={0.1} max={FAR} onChange={(value) => set(rectangle(value, height, left, low))} />
            <LengthField label="Region, height" short="height" value={clean(height)} min={0.1} max={FAR} onChange={(value) => set(rectangle(width, value, left, low))} />
        </div>
    );
}
