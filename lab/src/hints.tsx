// What is odd about a scene, told at once: nobody moves, or people are to walk through walls.

import type { Film } from "./film";
import { t } from "./language";
import { plan } from "./plan";
import type { Point, Scene } from "./protocol";

/** On which side of the line from `a` to `b` a point lies: left is positive. */
function side(a: Point, b: Point, at: Point) {
    return (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0]);
}

/** Where two segments cross; null if they do not. */
function crossing(a: Point, b: Point, c: Point, d: Point): Point | null {
    const [from, to] = [side(c, d, a), side(c, d, b)];
    if (from * to >= 0 || side(a, b, c) * side(a, b, d) >= 0) return null;
    const share = from / (from - to);
    return [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
}

interface Crossing {
    way: number;
    at: Point;
}

const known = new WeakMap<Scene, Crossing[]>();

/** Where ways cross walls, with the numbers of the ways. People walk straight from point to point. */
export function throughWalls(scene: Scene): Crossing[] {
    const found = known.get(scene) ?? crossings(scene);
    known.set(scene, found);
    return found;
}

function crossings({ ways, walls }: Scene): Crossing[] {
    return ways.flatMap((way, w) =>
        way.slice(1).flatMap((to, k) =>
            // A wall that opens is a door.
            walls.flatMap(({ corners, open }) => open ? [] :
                corners.slice(1).flatMap((end, j) => {
                    const from = way[k]!;
                    const at = crossing([from.x, from.y], [to.x, to.y], corners[j]!, end);
                    return at ? [{ way: w, at }] : [];
                }),
            ),
        ),
    );
}

/** Whether nobody of a crowd of this page can move. (What an opened Trial drives people with, only the engine knows.) */
function isMotionless({ scene }: Film): boolean {
    const { base, motion } = plan.value.made;
    if (base.kind !== "crowd" || scene.overlapping.length > 0) return false;
    return motion.kind === "none" || (motion.kind === "own" && (base.direction === null || base.speed === 0));
}

export function Hints({ film }: { film: Film }) {
    const ways = [...new Set(throughWalls(film.scene).map(({ way }) => way + 1))];
    return (
        <>
            {isMotionless(film) && <p class="note">{t("Nobody moves here: the tab Motion says what moves them.")}</p>}
            {ways.length > 0 && (
                <p class="warning">{`${ways.length === 1 ? t("Way goes through a wall") : t("Ways go through a wall")}: ${ways.join(", ")}. ${t("The cross shows where: people walk straight from point to point.")}`}</p>
            )}
        </>
    );
}
