// Places and rooms. Lengths in m.

export type Point = [number, number];

/** From and to which time in s something is open. */
export type OpenTime = [number, number];

/** A gap in the wall nearest to `at`, with its middle there. */
export interface Door {
    at: Point;
    width: number;
    /** When it is open; without, always. */
    open?: OpenTime[];
}

/** A wall that need not be closed: a closed one repeats its first corner. */
export interface Further {
    corners: Point[];
    /** The Id of the Trial's wall that it was: it keeps Id and material. */
    of: string | null;
}

/** Outlines do not repeat their first corner. */
export interface Room {
    /** Without corners where the walls of a Trial are changed. */
    outline: Point[];
    obstacles: Point[][];
    walls?: Further[];
    doors: Door[];
}

/** A change of a room. Ring 0 is its outline, obstacles and further walls follow; side 0 begins at corner 0. Doors stay on
 * their walls. */
export type RoomEdit =
    | { do: "move"; ring: number; corner: number; to: Point }
    | { do: "insert"; ring: number; side: number; at: Point }
    | { do: "remove"; ring: number; corner: number }
    /** An obstacle or a further wall goes away, with its doors. */
    | { do: "clear"; ring: number }
    /** The outline gets this size; its left and low ends stay. */
    | { do: "stretch"; width: number; height: number };

/** A room as it is drawn. */
export interface Drawn {
    room: Room;
    /** The way of each door along its wall, from end to end. */
    doors: Point[][];
    rings: Outline[];
    /** The place on a wall that is nearest to the place that was asked for. */
    near: { ring: number; side: number; at: Point; away: number } | null;
}

export interface Outline {
    /** Width, height, left and low of the rectangle around it. */
    bounds: [number, number, number, number];
    /** Whether it is this rectangle. */
    upright: boolean;
    /** Middles of its sides. */
    middles: Point[];
}
