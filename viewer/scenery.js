// What is drawn beside the bodies: grid, water, frames of markers, axes of joints.
import * as THREE from "three";

export function grid(scene, root, info) {
  if (!info.grid) return null;
  const cell = info.grid;
  const half = Math.ceil((2.2 * info.radius) / cell);
  const lines = new THREE.GridHelper(2 * half * cell, 2 * half, "#9fb0bf", "#d5dde4");
  const [x, , z] = info.centre;
  lines.position.set(Math.round(x / cell) * cell, info.floor, Math.round(z / cell) * cell);
  lines.userData.cell = cell;
  scene.add(lines);
  return lines;
}

// cells along the water, and how many of them the shortest wave that is shown has
const CELLS = 80;
const SHORTEST = 3;

// The waves of the sea as they are at a time: info.waves holds amplitude, frequency, phase and wave numbers of each component. The cosine
// of a sum is taken apart, so that a new time costs no cosine for each point.
function moves(plane, size, info) {
  const longest = (2 * Math.PI) / ((SHORTEST * size) / CELLS);
  const waves = (info.waves ?? []).filter(([, , , kx, ky]) => Math.hypot(kx, ky) < longest);
  const points = plane.geometry.attributes.position;
  const across = waves.map(([a, , phase, kx, ky]) => {
    const part = new Float32Array(2 * points.count);
    for (let i = 0; i < points.count; i++) {
      // the plane lies along x and -z of the world: x and y of the scene
      const place = kx * (points.getX(i) + info.centre[0]) + ky * (points.getY(i) - info.centre[2]);
      part[2 * i] = a * Math.cos(phase - place);
      part[2 * i + 1] = a * Math.sin(phase - place);
    }
    return part;
  });
  plane.seek = (time) => {
    if (!waves.length) return;
    const turn = waves.map(([, omega]) => [Math.cos(omega * time), Math.sin(omega * time)]);
    for (let i = 0; i < points.count; i++) {
      let height = 0;
      for (let p = 0; p < waves.length; p++) height += turn[p][0] * across[p][2 * i] - turn[p][1] * across[p][2 * i + 1];
      points.setZ(i, height);
    }
    points.needsUpdate = true;
    plane.geometry.computeVertexNormals();
  };
}

export function water(scene, info) {
  if (info.water === null) return null;
  const size = 8 * info.radius;
  const cells = info.waves ? CELLS : 1;
  const plane = new THREE.Mesh(
    new THREE.PlaneGeometry(size, size, cells, cells),
    new THREE.MeshStandardMaterial({
      color: "#3d8fc4", transparent: true, opacity: 0.42, side: THREE.DoubleSide, depthWrite: false, roughness: 0.3,
    }),
  );
  plane.rotation.x = -Math.PI / 2;
  plane.position.set(info.centre[0], info.water, info.centre[2]);
  plane.renderOrder = 2;
  moves(plane, size, info);
  scene.add(plane);
  return plane;
}

function group(nodes, items, make) {
  const made = items.filter((item) => nodes.has(item.body)).map((item) => {
    const object = make(item);
    object.position.set(...item.r);
    object.visible = false;
    nodes.get(item.body).add(object);
    return object;
  });
  return { get visible() { return made.some((object) => object.visible); },
    set visible(on) { for (const object of made) object.visible = on; } };
}

export function frames(nodes, info) {
  return group(nodes, info.markers, (marker) => {
    const axes = new THREE.AxesHelper(0.12 * info.radius);
    axes.quaternion.set(...marker.q);
    axes.material.depthTest = false;
    axes.renderOrder = 3;
    return axes;
  });
}

export function jointAxes(nodes, info) {
  return group(nodes, info.axes, (joint) => {
    const along = new THREE.Vector3(...joint.axis).normalize().multiplyScalar(0.3 * info.radius);
    const points = [along.clone().negate(), along];
    const material = new THREE.LineDashedMaterial({
      color: "#c0392b", dashSize: 0.03 * info.radius, gapSize: 0.015 * info.radius, depthTest: false,
    });
    const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), material);
    line.computeLineDistances();
    line.renderOrder = 3;
    return line;
  });
}
