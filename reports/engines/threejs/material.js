// A specular normal map, and the chains of mip levels that a build may filter it by.

import * as THREE from "three";

const SIDE = 256; // texels
const ROUGHNESS = 0.3; // as three.js has it: GGX's alpha is its square

/** Normals of random bumps, as Float64 [SIDE * SIDE * 3], unit, z up; they repeat. */
function bumps() {
    let state = 7;
    const random = () => (state = (1664525 * state + 1013904223) >>> 0) / 2 ** 32;
    const heights = Float64Array.from({ length: SIDE * SIDE }, random);
    const height = (x, y) => heights[((y + SIDE) % SIDE) * SIDE + ((x + SIDE) % SIDE)];
    const normals = new Float64Array(SIDE * SIDE * 3);
    for (let y = 0; y < SIDE; y++)
        for (let x = 0; x < SIDE; x++) {
            const dx = (height(x + 1, y) - height(x - 1, y)) / 4;
            const dy = (height(x, y + 1) - height(x, y - 1)) / 4;
            const length = Math.hypot(dx, dy, 1);
            normals.set([-dx / length, -dy / length, 1 / length], 3 * (y * SIDE + x));
        }
    return normals;
}

/** The mean of four texels each. */
function halved(texels, side) {
    const half = side / 2, means = new Float64Array(half * half * 3);
    for (let y = 0; y < half; y++)
        for (let x = 0; x < half; x++)
            for (let c = 0; c < 3; c++) {
                const at = 3 * (2 * y * side + 2 * x) + c;
                means[3 * (y * half + x) + c] =
                    (texels[at] + texels[at + 3] + texels[at + 3 * side] + texels[at + 3 * side + 3]) / 4;
            }
    return means;
}

/** Toksvig's roughness: where normals differ their mean is short, and the lobe gets as much wider. */
function widened(length) {
    const power = 2 / ROUGHNESS ** 4 - 2;
    const kept = length / (length + power * (1 - length));
    return (2 / (kept * power + 2)) ** 0.25;
}

/** One mip level of both maps: normals, and roughness in green, where three.js reads it. */
function level(texels, side) {
    const normals = new Uint8Array(4 * side * side).fill(255), roughness = normals.slice();
    for (let texel = 0; texel < side * side; texel++) {
        const normal = texels.subarray(3 * texel, 3 * texel + 3), length = Math.min(Math.hypot(...normal), 1);
        for (let c = 0; c < 3; c++) normals[4 * texel + c] = Math.round(255 * (0.5 + (0.5 * normal[c]) / length));
        roughness[4 * texel + 1] = Math.round(255 * widened(length));
    }
    return [normals, roughness].map((data) => ({ data, width: side, height: side }));
}

function texture(levels, filtered) {
    const map = new THREE.DataTexture(levels[0].data, SIDE, SIDE);
    map.wrapS = map.wrapT = THREE.RepeatWrapping;
    map.magFilter = map.minFilter = THREE.LinearFilter;
    if (filtered) {
        map.mipmaps = levels;
        map.minFilter = THREE.LinearMipmapLinearFilter;
        map.anisotropy = 16;
    }
    map.needsUpdate = true;
    return map;
}

/** Two materials that differ in nothing but how their maps are filtered. */
export function makeMaterials() {
    const chain = [];
    for (let texels = bumps(), side = SIDE; side >= 1; texels = halved(texels, side), side /= 2)
        chain.push(level(texels, side));
    const make = (filtered) => new THREE.MeshStandardMaterial({
        color: 0x806040,
        metalness: 0.5,
        normalMap: texture(chain.map(([normals]) => normals), filtered),
        roughnessMap: texture(chain.map(([, roughness]) => roughness), filtered),
    });
    return { unfiltered: make(false), filtered: make(true) };
}
