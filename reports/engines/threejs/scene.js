// A gallery: a bumpy glossy floor and wall, a fence of thin bars, and a column that slides past; the camera drifts.

import * as THREE from "three";

const SURFACE = 4; // metres that a repeat of the maps covers

function plane(width, height) {
    const geometry = new THREE.PlaneGeometry(width, height);
    const uv = geometry.attributes.uv;
    for (let i = 0; i < uv.count; i++) uv.setXY(i, (uv.getX(i) * width) / SURFACE, (uv.getY(i) * height) / SURFACE);
    return geometry;
}

/** The scene under one material of its floor and wall; all else is plain. */
export class Gallery {
    constructor(width, height) {
        this.scene = new THREE.Scene();
        this.camera = new THREE.PerspectiveCamera(45, width / height, 0.1, 100);
        this.surfaces = [new THREE.Mesh(plane(60, 24)), new THREE.Mesh(plane(60, 12))];
        this.surfaces[0].rotation.x = -Math.PI / 2;
        this.surfaces[1].position.set(0, 6, -10);
        const paint = (color) => new THREE.MeshStandardMaterial({ color, roughness: 0.8 });
        const bar = new THREE.BoxGeometry(0.015, 1.2, 0.015), dark = paint(0x101010);
        const bars = Array.from({ length: 60 }, (_, i) => {
            const mesh = new THREE.Mesh(bar, dark);
            mesh.position.set(-6 + 0.2 * i, 0.6, -6);
            mesh.rotation.z = 0.1;
            return mesh;
        });
        this.column = new THREE.Mesh(new THREE.CylinderGeometry(0.4, 0.4, 6, 48), paint(0x304878));
        const sun = new THREE.DirectionalLight(0xffffff, 2);
        sun.position.set(2, 5, -8);
        const front = new THREE.DirectionalLight(0xffffff, 1);
        front.position.set(-3, 4, 6);
        this.scene.add(...this.surfaces, ...bars, this.column, sun, front, new THREE.AmbientLight(0xffffff, 0.6));
    }

    /** Everything as it stands in a frame; -1 is before the first. */
    pose(frame) {
        this.camera.position.set(0.023 * frame, 1.7 + 0.004 * frame, 4 - 0.03 * frame);
        this.camera.rotation.set(-0.12, 0.0015 * frame, 0);
        this.column.position.set(-1.6 + 0.06 * frame, 3, -3);
        this.scene.updateMatrixWorld();
        this.camera.updateMatrixWorld();
    }

    wear(material) {
        for (const mesh of this.surfaces) mesh.material = material;
    }
}
