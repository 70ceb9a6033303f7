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

export function water(scene, info) {
  if (info.water === null) return null;
  const size = 8 * info.radius;
  const plane = new THREE.Mesh(
    new THREE.PlaneGeometry(size, size),
    new THREE.MeshStandardMaterial({
      color: "#3d8fc4", transparent: true, opacity: 0.42, side: THREE.DoubleSide, depthWrite: false, roughness: 0.3,
    }),
  );
  plane.rotation.x = -Math.PI / 2;
  plane.position.set(info.centre[0], info.water, info.centre[2]);
  plane.renderOrder = 2;
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
