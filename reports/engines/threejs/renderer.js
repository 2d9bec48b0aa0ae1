// Three builds of the gallery, the reference, and its geometry: what a frame's surfaces did since the frame before.

import * as THREE from "three";
import { makeMaterials } from "./material.js";
import { Gallery } from "./scene.js";

// Samples are a pixel's, as rows and columns of a grid; edges: samples of the hardware's antialiasing.
const BUILDS = {
    aliased: { material: "unfiltered", grid: 1, edges: 0 },
    filtered: { material: "filtered", grid: 1, edges: 4 },
    supersampled: { material: "unfiltered", grid: 2, edges: 0 },
    reference: { material: "unfiltered", grid: 8, edges: 0 },
};

// Red and green: NDC now - NDC before, as three.js' own VelocityNode has it. Blue: metres along the camera's axis.
const GEOMETRY = {
    vertexShader: `
        uniform mat4 before; // from the model to clip space, in the frame before
        varying vec4 now, then;
        void main() {
            now = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
            then = before * vec4(position, 1.0);
            gl_Position = now;
        }`,
    fragmentShader: `
        varying vec4 now, then;
        void main() { gl_FragColor = vec4(now.xy / now.w - then.xy / then.w, now.w, 1.0); }`,
};

export class Renderer {
    constructor(width, height) {
        [this.width, this.height] = [width, height];
        this.gallery = new Gallery(width, height);
        this.materials = makeMaterials();
        this.webgl = new THREE.WebGLRenderer();
        this.targets = {
            0: new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType }),
            4: new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, samples: 4 }),
        };
        const gl = this.webgl.getContext();
        this.version = `three.js ${THREE.REVISION}, ${gl.getParameter(gl.VERSION)}`;
    }

    /** A frame under a build: linear radiance, the mean of its samples, Float32 [H, W, 4]. */
    draw(build, frame) {
        const { material, grid, edges } = BUILDS[build];
        this.gallery.pose(frame);
        this.gallery.wear(this.materials[material]);
        const sum = new Float32Array(4 * this.width * this.height);
        for (let row = 0; row < grid; row++)
            for (let column = 0; column < grid; column++) {
                const x = (column + 0.5) / grid - 0.5, y = (row + 0.5) / grid - 0.5;
                this.gallery.camera.setViewOffset(this.width, this.height, x, y, this.width, this.height);
                const pixels = this.render(this.targets[edges]);
                for (let i = 0; i < sum.length; i++) sum[i] += pixels[i] / grid ** 2;
            }
        this.gallery.camera.clearViewOffset();
        return sum;
    }

    /** Motion and depth of what is seen at the middle of each pixel: x, y, depth, 1. */
    drawGeometry(frame) {
        const { scene, camera } = this.gallery, worn = new Map();
        this.gallery.pose(frame - 1);
        scene.traverse((mesh) => {
            if (!mesh.isMesh) return;
            const before = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).multiply(mesh.matrixWorld);
            worn.set(mesh, mesh.material);
            mesh.material = new THREE.ShaderMaterial({ ...GEOMETRY, uniforms: { before: { value: before } } });
        });
        this.gallery.pose(frame);
        const pixels = this.render(this.targets[0]);
        for (const [mesh, material] of worn) {
            mesh.material.dispose();
            mesh.material = material;
        }
        return pixels;
    }

    render(target) {
        const pixels = new Float32Array(4 * this.width * this.height);
        this.webgl.setRenderTarget(target);
        this.webgl.render(this.gallery.scene, this.gallery.camera);
        this.webgl.readRenderTargetPixels(target, 0, 0, this.width, this.height, pixels);
        return pixels;
    }
}
