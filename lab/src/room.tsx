// Rooms: that of a crowd, and the walls of an opened Trial. Drawn on the picture, or written as numbers.

import { batch } from "@preact/signals";
import { useState } from "preact/hooks";
import { BackdropForms } from "./backdrop";
import { MakeCrowd } from "./crowd";
import { DrawingPanel } from "./drawing";
import { edited, ready, shape } from "./drawn";
import { inner, local, t } from "./language";
import { NewRoom } from "./newroom";
import { OpenTimes } from "./opentimes";
import { brief, Button, Choice, FAR, length, LengthField, PointFields } from "./parts";
import { type KeptCrowd, MOST } from "./forms";
import { change, plan } from "./plan";
import { openPlan, PLANS } from "./plans";
import type { Outline, Point, Room } from "./protocol";
import { aim, clear, fixed, insert, isChanged, picked, remove, room as present, roomTool, setRoom, takeBack, target } from "./roomtool";
import { canLose, closes, rectangle, rings, wallAt } from "./roomshape";
import { made } from "./session";
import { ROOM, useTool } from "./tool";
import { FileInput } from "./upload";

/** The largest coordinate in m: that of a Trial's is larger. */
const far = () => (target.value === "trial" ? 1e6 : FAR);
/** Of more walls, only the fields of the one that is marked are shown. */
const MANY = 50;

export function RoomTab() {
    return ready() ? <Forms /> : <p role="status">{t("One moment …")}</p>;
}

function Forms() {
    useTool(roomTool, ROOM);
    const { base } = plan.value.made;
    return (
        <section class="panel" aria-label={t("Room")}>
            <h2>{t("Room")}</h2>
            <div class="buttons">
                <NewRoom />
            </div>
            {base.kind !== "crowd" && (
                <Choice
                    label={t("What is changed")}
                    value={target.value}
                    choices={[
                        ["trial", t("The walls of this Trial")],
                        ["forms", t("A new room, for a new crowd")],
                    ]}
                    onChange={aim}
                />
            )}
            {target.value === "trial" ? <TrialForms /> : <CrowdForms />}
            <h2>{t("Plans and pictures")}</h2>
            <p class="note">{t("A plan (DXF, GeoJSON, WKT, SVG, Geometry.xml) becomes a room; a picture (PNG, JPEG, WebP, SVG) lies under it.")}</p>
            <FileInput label={t("Open a plan or a picture")} accept={PLANS} onFiles={async ([given]) => given && openPlan(given.file)} />
            <DrawingPanel />
            <BackdropForms />
        </section>
    );
}

/** What the mouse and keys do without a tool. */
function Hands() {
    return (
        <>
            <p class="note">{t("Drag corners and doors on the picture. A click on a wall makes a corner; the Delete key removes what is marked.")}</p>
            <p class="note">{t("Shift and Delete remove all of an obstacle or a wall; Shift and arrows move what is marked by 5 cm.")}</p>
        </>
    );
}

/** The lines of a room as forms, the outline first if there is one. */
function Lines({ room }: { room: Room }) {
    const first = room.outline.length > 0 ? 0 : 1;
    const all = rings(room).map((_, ring) => ring).slice(first);
    const marked = picked.value?.kind === "corner" ? picked.value.ring : null;
    const many = all.length > MANY;
    /** They have no names but their places. */
    const title = (ring: number) => {
        const k = ring - room.obstacles.length;
        return ring === 0 ? t("Corners") : k <= 0 ? t("Obstacle {n}", { n: ring }) : t("Wall {n}", { n: k });
    };
    return (
        <>
            {many && <p class="note">{t("There are {n} walls. Mark a corner on the picture to see the numbers of its wall.", { n: all.length })}</p>}
            {all
                .filter((ring) => !many || ring === marked)
                .map((ring) => (
                    <Ring key={ring} title={title(ring)} room={room} ring={ring} />
                ))}
        </>
    );
}

/** The walls of the Trial on the stage. */
function TrialForms() {
    const room = present.value;
    if (fixed.value) return <p class="warning">{fixed.value}</p>;
    return (
        <>
            <p class="note">{t("People, materials and what moves people stay as they are. New walls are of the material of the first one.")}</p>
            <Hands />
            <Doors room={room} />
            <Lines room={room} />
            {isChanged.value ? (
                <p class="note">
                    {t("The walls are changed.")}{" "}
                    <Button words={t("Take the walls of the Trial again")} onClick={takeBack} />
                </p>
            ) : (
                <p class="note">{t("The walls are those of the Trial.")}</p>
            )}
        </>
    );
}

function CrowdForms() {
    const { crowd, made: planned, unit } = plan.value;
    const { room } = crowd;
    const same = planned.base.kind === "crowd" && JSON.stringify(planned.base.room) === JSON.stringify(room);
    return (
        <>
            <Size room={room} />
            <Hands />
            <Doors room={room} />
            <Lines room={room} />
            <Region crowd={crowd} />
            {made.value && same && (
                <p class="note">
                    {t("The free ground has")} {local(made.value.area.toFixed(2))} m²{crowd.region && t(" where people stand")}.
                </p>
            )}
            <MakeCrowd />
            <p class="note">{t("Walls of up to {outline} corners; corners snap to {length}.", { outline: MOST.outline, length: length(0.05, unit) })}</p>
        </>
    );
}

function Size({ room }: { room: Room }) {
    const { bounds, upright } = shape(room.outline);
    if (!upright) {
        return (
            <p class="note">
                {t("A polygon with")} {room.outline.length} {t("corners.")}{" "}
                <Button words={t("Make it a rectangle")} onClick={() => batch(() => (setRoom({ outline: rectangle(4, 4), obstacles: [], doors: [] }), change({ drawn: null })))} />
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
            <LengthField label={t("Room width")} value={width} min={0.1} max={FAR} onChange={(value) => set(value, height)} />
            <LengthField label={t("Room height")} value={height} min={0.1} max={FAR} onChange={(value) => set(width, value)} />
        </div>
    );
}

function Ring({ title, room, ring }: { title: string; room: Room; ring: number }) {
    // Many fields take long to make.
    const [open, setOpen] = useState(false);
    const all = rings(room)[ring]!;
    const wall = wallAt(room, ring);
    // The last corner of a closed wall is the first one.
    const corners = wall && closes(all) ? all.slice(0, -1) : all;
    const name = (n: number) => (ring === 0 ? t("Corner {n}", { n }) : `${title}, ${t("corner {n}", { n })}`);
    return (
        <details onToggle={(event) => setOpen(event.currentTarget.open)}>
            <summary>
                {title} {wall?.of != null && `"${brief(wall.of)}" `}
                <span class="unit">({ring > 0 ? t("{n} corners", { n: corners.length }) : corners.length})</span>
            </summary>
            {open &&
                corners.map((at, k) => (
                    <div class="row" key={k}>
                        <span class="which">{k + 1}</span>
                        <PointFields name={name(k + 1)} far={far()} at={at} onChange={(to) => setRoom(edited(room, { do: "move", ring, corner: k, to }))} />
                        <Button words="+" aria-label={t("Insert a corner after {name}", { name: inner(name(k + 1)) })} disabled={k + 1 >= all.length && wall !== undefined} onClick={() => setRoom(insert(room, ring, k))} />
                        <Button words="×" aria-label={t("Delete {name}", { name: inner(name(k + 1)) })} disabled={!canLose(room, ring)} onClick={() => remove({ kind: "corner", ring, k })} />
                    </div>
                ))}
            {ring > 0 && (
                <Button words={t("Delete {name}", { name: inner(title) })} onClick={() => clear(ring)} />
            )}
        </details>
    );
}

function Doors({ room }: { room: Room }) {
    const { doors } = room;
    const set = (k: number, part: Partial<Room["doors"][number]>) => setRoom({ ...room, doors: doors.map((door, j) => (j === k ? { ...door, ...part } : door)) });
    const some = room.outline.length > 0 ? room.outline : room.walls?.[0]?.corners;
    const add = (wall: Point[]) => {
        const { middles } = shape(wall);
        setRoom({ ...room, doors: [...doors, { at: middles[1] ?? middles[0]!, width: 1 }] });
    };
    return (
        <details open={doors.length > 0}>
            <summary>
                {t("Doors")} <span class="unit">({doors.length})</span>
            </summary>
            {doors.map((door, k) => {
                const name = t("Door {n}", { n: k + 1 });
                return (
                    <div key={k}>
                        <div class="row">
                            <span class="which">{k + 1}</span>
                            <LengthField of={name} label={t("width")} value={door.width} min={0.1} max={100} onChange={(width) => set(k, { width })} />
                            <PointFields name={name} far={far()} at={door.at} onChange={(at) => set(k, { at })} />
                            <Button words="×" aria-label={t("Delete {name}", { name: inner(name) })} onClick={() => remove({ kind: "door", k })} />
                        </div>
                        <OpenTimes name={name} times={door.open ?? null} onChange={(open) => set(k, { open: open ?? undefined })} />
                    </div>
                );
            })}
            {some && doors.length < MOST.parts && (
                <Button words={t("Add a door by numbers")} onClick={() => add(some)} />
            )}
            <p class="note">{t("A door is a gap in the wall that is nearest to x and y. A wall closes it while it is not open.")}</p>
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
                {t("Where people stand")} <span class="unit">({region ? t("a part of the room") : t("the whole room")})</span>
            </summary>
            {around?.upright && <RegionFields bounds={around.bounds} set={set} />}
            {region ? (
                <Button words={t("Use the whole room")} onClick={() => set(null)} />
            ) : (
                <Button words={t("Use a rectangle, by numbers")} onClick={() => set(rectangle(...shape(room.outline).bounds))} />
            )}
        </details>
    );
}

function RegionFields({ bounds: [width, height, left, low], set }: { bounds: Outline["bounds"]; set(region: Point[]): void }) {
    const clean = (value: number) => Number(value.toFixed(3));
    return (
        <div class="row two">
            <LengthField of={t("Region")} label={t("left")} value={clean(left)} min={-FAR} max={FAR} onChange={(value) => set(rectangle(width, height, value, low))} />
            <LengthField of={t("Region")} label={t("low")} value={clean(low)} min={-FAR} max={FAR} onChange={(value) => set(rectangle(width, height, left, value))} />
            <LengthField of={t("Region")} label={t("width")} value={clean(width)} min={0.1} max={FAR} onChange={(value) => set(rectangle(value, height, left, low))} />
            <LengthField of={t("Region")} label={t("height")} value={clean(height)} min={0.1} max={FAR} onChange={(value) => set(rectangle(width, value, left, low))} />
        </div>
    );
}
