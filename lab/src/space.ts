// A place in three dimensions: a canvas, a camera that people turn, light. Loaded with three.js, when it is needed.

import {
    type Box3,
    type BufferGeometry,
    Color,
    DirectionalLight,
    HemisphereLight,
    type Material,
    Object3D,
    PerspectiveCamera,
    Scene,
    SRGBColorSpace,
    Vector3,
    WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { t } from "./language";

const TURN = Math.PI / 24;
const ZOOM = 0.9;
/** Share of the view that a key moves. */
const MOVE = 0.05;

/** Pixels per pixel of CSS while something moves too slowly, where the processor draws. */
const COARSE = 0.5;
/** Milliseconds from picture to picture that are too slow. */
const SLOW = 40;
/** Milliseconds after which it is still. */
const STILL = 250;

/** Whether the processor draws, not a graphics card: more slowly by far. Found out once. */
let slow: boolean | undefined;

function drawsSlowly(): boolean {
    const probe = document.createElement("canvas").getContext("webgl2");
    if (!probe) return true;
    const info = probe.getExtension("WEBGL_debug_renderer_info");
    const name = info ? String(probe.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
    probe.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

/** The browser cannot draw in three dimensions. */
export class NoWebGL extends Error {
    constructor() {
        super(t("This browser has no WebGL, which 3D needs. 2D and sections show the same people."));
    }
}

/** Its numbers are those of the style sheet, "#rrggbb" or "rgb(r g b)". */
export function setColour(colour: Color, text: string) {
    const parts = text.trim().startsWith("#")
        ? [1, 3, 5].map((at) => Number.parseInt(text.trim().slice(at, at + 2), 16))
        : (text.match(/[\d.]+/g) ?? []).map(Number);
    const [red = 0, green = 0, blue = 0] = parts;
    colour.setRGB(red / 255, green / 255, blue / 255, SRGBColorSpace);
}

/** Frees what an object and those below it hold. */
export function free(object: Object3D) {
    object.traverse((part) => {
        const { geometry, material } = part as Partial<{ geometry: BufferGeometry; material: Material }>;
        geometry?.dispose();
        material?.dispose();
    });
    object.removeFromParent();
}

export class Space {
    readonly scene = new Scene();
    readonly camera = new PerspectiveCamera(40, 1, 0.05, 2000);
    readonly controls: OrbitControls;
    /** Called when light and dark change. */
    onTheme = () => {};
    /** Called before each picture, with the seconds since the one before. True: a further picture follows. */
    before = (_seconds: number): boolean => false;
    readonly #renderer: WebGLRenderer;
    readonly #observer: ResizeObserver;
    readonly #dark = matchMedia("(prefers-color-scheme: dark)");
    #waiting = 0;
    #last = 0;
    #drawn = 0;
    #interval = 0;
    #coarse = false;
    #timer: ReturnType<typeof setTimeout> | undefined;
    #home = () => {};

    constructor(readonly canvas: HTMLCanvasElement) {
        // Kept, or the canvas could not be saved as a picture.
        slow ??= drawsSlowly();
        const context = canvas.getContext("webgl2", { antialias: !slow, preserveDrawingBuffer: true });
        if (!context) throw new NoWebGL();
        this.#renderer = new WebGLRenderer({ canvas, context });
        this.#renderer.setPixelRatio(this.#pixels(false));
        this.camera.up.set(0, 0, 1);
        // Bright enough that colours are still those of the legend.
        const sun = new DirectionalLight(0xffffff, 1.5);
        sun.position.set(-2, -3, 4);
        this.scene.add(new HemisphereLight(0xffffff, 0x9a9aa2, 2.3), sun);
        this.controls = new OrbitControls(this.camera, canvas);
        this.controls.maxPolarAngle = 0.495 * Math.PI;
        this.controls.addEventListener("change", this.draw);
        canvas.addEventListener("keydown", this.#key);
        this.#dark.addEventListener("change", this.#theme);
        this.#observer = new ResizeObserver(() => this.#fit());
        this.#observer.observe(canvas);
        this.#fit();
    }

    #pixels(moves: boolean) {
        return moves && this.#coarse ? COARSE : Math.min(devicePixelRatio, slow ? 1 : 2);
    }

    /** A colour of the style sheet. */
    colour(name: string): Color {
        const colour = new Color();
        setColour(colour, getComputedStyle(this.canvas).getPropertyValue(name));
        return colour;
    }

    #theme = () => {
        this.scene.background = this.colour("--space");
        this.onTheme();
        this.draw();
    };

    #fit() {
        const { clientWidth: width, clientHeight: height } = this.canvas;
        if (!width || !height) return;
        this.#renderer.setSize(width, height, false);
        this.camera.aspect = width / height;
        this.camera.updateProjectionMatrix();
        this.#theme();
    }

    /** Looks at a box from a side and above, as near as all of it is seen. */
    look(box: Box3, from = new Vector3(-0.35, -1, 0.75)) {
        this.#home = () => {
            const { camera, controls } = this;
            const up = Math.tan((camera.fov * Math.PI) / 360);
            box.getCenter(controls.target);
            camera.position.copy(controls.target).add(from);
            camera.lookAt(controls.target);
            camera.updateMatrixWorld();
            const [right, above, back] = [new Vector3(), new Vector3(), new Vector3()];
            camera.matrixWorld.extractBasis(right, above, back);
            let distance = 0;
            for (let k = 0; k < 8; k++) {
                const corner = new Vector3(k & 1 ? box.min.x : box.max.x, k & 2 ? box.min.y : box.max.y, k & 4 ? box.min.z : box.max.z);
                corner.sub(controls.target);
                const wide = Math.max(Math.abs(corner.dot(above)) / up, Math.abs(corner.dot(right)) / (up * camera.aspect));
                distance = Math.max(distance, wide + corner.dot(back));
            }
            camera.position.copy(controls.target).addScaledVector(back, 1.04 * distance);
            controls.minDistance = 0.3;
            controls.maxDistance = 10 * distance;
            controls.update();
            this.draw();
        };
        this.#home();
    }

    #key = (event: KeyboardEvent) => {
        const { controls } = this;
        const steps: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
        const step = steps[event.key];
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        if (step && event.shiftKey) {
            const size = MOVE * this.canvas.clientHeight;
            controls.pan(-size * step[0], size * step[1]);
        } else if (step) {
            controls.rotateLeft(TURN * step[0]);
            controls.rotateUp(TURN * step[1]);
        } else if (event.key === "+" || event.key === "=") controls.dollyIn(ZOOM);
        else if (event.key === "-") controls.dollyOut(ZOOM);
        else if (event.key === "0" || event.key === "Home") this.#home();
        else return;
        event.preventDefault();
        event.stopPropagation();
    };

    /** With the next picture of the screen. */
    draw = () => {
        this.#waiting ||= requestAnimationFrame((now) => {
            this.#waiting = 0;
            const again = this.before(this.#last ? Math.min(0.1, Math.max(0, now - this.#last) / 1000) : 0);
            this.#last = again ? now : 0;
            const since = now - this.#drawn;
            this.#drawn = now;
            if (since < STILL) this.#interval += 0.2 * (since - this.#interval);
            this.#coarse ||= slow === true && this.#interval > SLOW;
            this.#sharpen(since < STILL);
            this.#renderer.render(this.scene, this.camera);
            if (again) this.draw();
        });
    };

    /** Coarser while it moves, if it must be; fine when it is still again. */
    #sharpen(moves: boolean) {
        clearTimeout(this.#timer);
        const wanted = this.#pixels(moves);
        if (this.#renderer.getPixelRatio() !== wanted) this.#renderer.setPixelRatio(wanted);
        if (wanted === COARSE) this.#timer = setTimeout(this.draw, STILL + 10);
    }

    dispose() {
        cancelAnimationFrame(this.#waiting);
        clearTimeout(this.#timer);
        this.#waiting = -1;
        this.canvas.removeEventListener("keydown", this.#key);
        this.#dark.removeEventListener("change", this.#theme);
        this.#observer.disconnect();
        this.controls.dispose();
        free(this.scene);
        this.#renderer.dispose();
        // The browser allows few at a time.
        this.#renderer.forceContextLoss();
    }
}
