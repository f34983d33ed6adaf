// A crowd in three dimensions: bodies, walls, ground. Bodies are those that the lab gives; here they are placed and
// coloured.

import {
    Box3,
    BufferAttribute,
    BufferGeometry,
    Color,
    ConeGeometry,
    DoubleSide,
    Group,
    LineBasicMaterial,
    LineSegments,
    Mesh,
    MeshBasicMaterial,
    MeshLambertMaterial,
    type Object3D,
    Raycaster,
    RingGeometry,
    Vector2,
    Vector3,
} from "three";
import { kindShade, round, type Scale, shade, THINGS } from "./colour";
import { isOpen } from "./draw";
import { type Bodies, COLUMNS, isThere, type Scene } from "./protocol";
import { free, setColour, type Space } from "./space";

/** Low enough to look over. */
const WALL = 0.9;

/** A surface as the lab gives it: coordinates as float32, then corners as uint32. */
export function surface(bytes: ArrayBuffer, at: number, vertices: number, triangles: number): BufferGeometry {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(bytes, at, 3 * vertices), 3));
    geometry.setIndex(new BufferAttribute(new Uint32Array(bytes, at + 12 * vertices, 3 * triangles), 1));
    // For light only.
    geometry.computeVertexNormals();
    geometry.computeBoundingSphere();
    return geometry;
}

export function lines(points: number[]): BufferGeometry {
    return new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
}

/** Distance of the lines on the ground, in m: a round number, so that there are at most about a hundred each way. */
function spacing(size: number) {
    if (size <= 100) return size > 60 ? 5 : 1;
    return round(size / 100, [1, 2, 5]);
}

/** A material with another colour at each level, up to the pixel; its own is above and below them. */
function banded(levels: Scene["levels"], bands: Color[]): MeshLambertMaterial {
    const material = new MeshLambertMaterial();
    const count = levels.length;
    if (count === 0) return material;
    material.onBeforeCompile = (shader) => {
        Object.assign(shader.uniforms, { ends: { value: levels.map(([bottom, top]) => new Vector2(bottom, top)) }, bands: { value: bands } });
        const begin = "void main() {";
        shader.vertexShader = shader.vertexShader.replace(begin, `varying float height;\n${begin}\nheight = position.z;`);
        shader.fragmentShader = shader.fragmentShader
            .replace(begin, `varying float height;\nuniform vec2 ends[${count}];\nuniform vec3 bands[${count}];\n${begin}`)
            .replace("#include <color_fragment>", `for (int k = 0; k < ${count}; k++) if (height >= ends[k].x && height < ends[k].y) diffuseColor.rgb = bands[k];`);
    };
    return material;
}

export class Crowd3d {
    /** All walls, people at the start, and where they walk to. */
    readonly box: Box3;
    /** Distance of the lines on the ground, in m. */
    readonly grid: number;
    #bodies: Mesh<BufferGeometry, MeshLambertMaterial>[] = [];
    /** Of each body the colours of its levels. */
    #bands: Color[][] = [];
    #fills: string[] = [];
    #still = new Group();
    /** Walls that open, each with what is drawn of it while it is closed. */
    #doors: { wall: Scene["walls"][number]; parts: Object3D[] }[] = [];
    #pick = new MeshBasicMaterial({ side: DoubleSide });
    /** Who is selected: a ring at the feet, an arrow's tip over the head. */
    #mark = new Group();
    #known = new Map<string, Color>();

    constructor(
        readonly space: Space,
        readonly scene: Scene,
        first: Float32Array,
    ) {
        const [low, high] = [new Vector2(Infinity, Infinity), new Vector2(-Infinity, -Infinity)];
        const see = (x: number, y: number) => {
            low.min({ x: x - 1, y: y - 1 } as Vector2);
            high.max({ x: x + 1, y: y + 1 } as Vector2);
        };
        for (const { corners } of scene.walls) for (const [x, y] of corners) see(x, y);
        scene.agents.forEach((_, a) => isThere(first, a) && see(first[COLUMNS * a]!, first[COLUMNS * a + 1]!));
        for (const { x, y } of scene.ways.flat()) see(x, y);
        if (low.x > high.x) see(0, 0);
        this.box = new Box3(new Vector3(low.x + 0.5, low.y + 0.5, 0), new Vector3(high.x - 0.5, high.y - 0.5, 1.8));
        this.grid = spacing(low.distanceTo(high));
        this.#mark.visible = false;
        const tip = new Mesh(new ConeGeometry(0.13, 0.3, 24).rotateX(-Math.PI / 2), this.#pick);
        tip.position.z = 2.35;
        this.#mark.add(new Mesh(new RingGeometry(0.38, 0.47, 48), this.#pick), tip);
        const fixed = this.scene.walls.filter(({ open }) => !open);
        this.#doors = this.scene.walls.filter(({ open }) => open).map((wall) => ({ wall, parts: this.#walls([wall]) }));
        this.#still.add(this.#ground(low, high), ...this.#walls(fixed), ...this.#doors.flatMap(({ parts }) => parts));
        space.scene.add(this.#still, this.#mark);
        this.recolour();
    }

    #ground(low: Vector2, high: Vector2) {
        const step = this.grid;
        const [left, right] = [Math.floor(low.x / step) * step, Math.ceil(high.x / step) * step];
        const [near, far] = [Math.floor(low.y / step) * step, Math.ceil(high.y / step) * step];
        const points: number[] = [];
        for (let x = left; x <= right + step / 2; x += step) points.push(x, near, 0, x, far, 0);
        for (let y = near; y <= far + step / 2; y += step) points.push(left, y, 0, right, y, 0);
        const grid = new LineSegments(lines(points), new LineBasicMaterial());
        grid.name = "--edge";
        return grid;
    }

    #walls(walls: Scene["walls"]) {
        const [panels, edges]: [number[], number[]] = [[], []];
        for (const { corners } of walls) {
            corners.slice(1).forEach(([x2, y2], k) => {
                const [x1, y1] = corners[k]!;
                panels.push(x1, y1, 0, x2, y2, 0, x2, y2, WALL, x1, y1, 0, x2, y2, WALL, x1, y1, WALL);
                edges.push(x1, y1, WALL, x2, y2, WALL, x1, y1, 0, x2, y2, 0, x1, y1, 0, x1, y1, WALL, x2, y2, 0, x2, y2, WALL);
            });
        }
        const panel = new Mesh(lines(panels), new MeshBasicMaterial({ transparent: true, opacity: 0.12, side: DoubleSide, depthWrite: false }));
        const edge = new LineSegments(lines(edges), new LineBasicMaterial());
        [panel.name, edge.name] = ["--ink", "--ink"];
        return [panel, edge];
    }

    /** Their colours are those of the style sheet. */
    recolour() {
        for (const part of this.#still.children as Mesh<BufferGeometry, MeshBasicMaterial>[]) part.material.color.copy(this.space.colour(part.name));
        this.#pick.color.copy(this.space.colour("--pick"));
    }

    /** The surfaces of all agents. */
    dress(bodies: Bodies, bytes: ArrayBuffer) {
        let at = 0;
        for (const [vertices, triangles] of bodies.agents) {
            const bands = this.scene.levels.map(() => new Color());
            this.#bands.push(bands);
            const body = new Mesh(surface(bytes, at, vertices, triangles), banded(this.scene.levels, bands));
            at += 12 * (vertices + triangles);
            this.#bodies.push(body);
            this.space.scene.add(body);
        }
        bodies.things.forEach(([vertices, triangles], a) => {
            if (triangles === 0) return;
            const material = this.scene.agents[a]?.things?.find((thing) => thing !== null) ?? "frame";
            const colour = new Color();
            setColour(colour, THINGS[material as keyof typeof THINGS]);
            // Its edges are sharp.
            const flat = new MeshLambertMaterial({ color: colour, flatShading: true });
            this.#bodies[a]!.add(new Mesh(surface(bytes, at, vertices, triangles), flat));
            at += 12 * (vertices + triangles);
        });
        this.#fills = this.#bodies.map(() => "");
    }

    /** Places and colours them at a time in s: of each a value, or one for each level. */
    place(frame: Float32Array, values: Float64Array[], scale: Scale, selected: number | null, time: number) {
        for (const { wall, parts } of this.#doors) for (const part of parts) part.visible = !isOpen(wall.open, time);
        this.#bodies.forEach((body, a) => {
            const at = COLUMNS * a;
            body.visible = isThere(frame, a);
            if (!body.visible) return;
            body.position.set(frame[at]!, frame[at + 1]!, 0);
            body.rotation.z = frame[at + 2]!;
            const fills = values.map((of) => shade(scale, of[a]!).fill);
            const all = fills.join();
            if (all === this.#fills[a]) return;
            this.#fills[a] = all;
            body.material.color.copy(this.#colour(fills.length > 1 ? kindShade(-1).fill : all));
            this.#bands[a]!.forEach((band, k) => band.copy(this.#colour(fills[k] ?? all)));
        });
        this.#mark.visible = selected !== null && isThere(frame, selected);
        if (selected !== null && this.#mark.visible) this.#mark.position.set(frame[COLUMNS * selected]!, frame[COLUMNS * selected + 1]!, 0.01);
        this.space.draw();
    }

    /** Colours are few, and their texts need not be read again and again. */
    #colour(text: string) {
        let colour = this.#known.get(text);
        if (!colour) {
            colour = new Color();
            setColour(colour, text);
            this.#known.set(text, colour);
        }
        return colour;
    }

    /** The agent at a place of the canvas, in pixels of the page. */
    at(x: number, y: number): number | null {
        const { canvas, camera } = this.space;
        const ray = new Raycaster();
        ray.setFromCamera(new Vector2((2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight), camera);
        // It also finds what is not visible.
        const there = this.#bodies.filter(({ visible }) => visible);
        const first = ray.intersectObjects(there, true)[0]?.object;
        // What goes along is part of its body.
        const place = this.#bodies.findIndex((body) => body === first || body === first?.parent);
        return place < 0 ? null : place;
    }

    dispose() {
        for (const part of [...this.#bodies, this.#still, this.#mark]) free(part);
    }
}
