// Mooring lines: between where the bodies are, in the shape that the page's table has for the distances of their ends.
import * as THREE from "three";
import { floats } from "./numbers.js";

const ALONG = new THREE.Vector3(0, 1, 0);

export class Lines {
  constructor(viewer) {
    const { info, root } = viewer;
    this.viewer = viewer;
    this.group = new THREE.Group();
    this.items = [];
    root.add(this.group);
    if (!info.lines) return;
    const { radius, colours, up } = info.lines;
    this.up = new THREE.Vector3(...up);
    this.colours = Object.fromEntries(Object.entries(colours).map(([name, colour]) => [name, new THREE.Color(colour)]));
    const rod = new THREE.CylinderGeometry(radius, radius, 1, 8, 1, true);
    const bead = new THREE.SphereGeometry(1, 20, 14);
    const material = () => new THREE.MeshStandardMaterial({ roughness: 0.6, metalness: 0.1 });
    for (const item of info.lines.items) {
      const { table } = item;
      const count = floats(table.mean).length / 2;
      const rods = new THREE.InstancedMesh(rod, material(), count - 1);
      rods.frustumCulled = false;
      const balls = item.balls.map(({ radius: size, floats: swims }) => {
        const ball = new THREE.Mesh(bead, material());
        ball.material.color = this.colours[swims ? "buoy" : "weight"];
        ball.scale.setScalar(size);
        return ball;
      });
      this.group.add(rods, ...balls);
      this.items.push({
        ...item, count, rods, beads: balls,
        table: { ...table, shares: table.shares.map(floats), mean: floats(table.mean), modes: floats(table.modes) },
        points: Array.from({ length: count }, () => new THREE.Vector3()),
      });
    }
  }

  // an end in the root's axes; those of bodies as they are now
  end({ body, r }) {
    const point = new THREE.Vector3(...r);
    if (body === null) return point;
    for (let node = this.viewer.nodes.get(body); node && node !== this.viewer.root; node = node.parent) {
      point.applyQuaternion(node.quaternion).add(node.position);
    }
    return point;
  }

  // (across, up) of each point from the first end, for distances of the ends
  shape({ table, count }, x, z) {
    const [nx, nz] = table.nodes;
    const place = (value, k, n) => Math.min(Math.max((value - table.first[k]) / table.step[k], 0), n - 1);
    const px = place(x, 0, nx);
    const pz = place(z, 1, nz);
    const i = Math.min(Math.floor(px), Math.max(nx - 2, 0));
    const j = Math.min(Math.floor(pz), Math.max(nz - 2, 0));
    const corners = [
      [i, j, (1 - px + i) * (1 - pz + j)], [i, j + 1, (1 - px + i) * (pz - j)],
      [i + 1, j, (px - i) * (1 - pz + j)], [i + 1, j + 1, (px - i) * (pz - j)],
    ].filter(([, , weight]) => weight !== 0);
    const flat = Float64Array.from(table.mean);
    table.shares.forEach((shares, mode) => {
      let share = 0;
      for (const [a, b, weight] of corners) share += weight * shares[a * nz + b];
      for (let k = 0; k < 2 * count; k++) flat[k] += share * table.modes[2 * count * mode + k];
    });
    return flat;
  }

  seek() {
    const turn = new THREE.Quaternion();
    const matrix = new THREE.Matrix4();
    const along = new THREE.Vector3();
    const middle = new THREE.Vector3();
    const size = new THREE.Vector3(1, 1, 1);
    for (const item of this.items) {
      const [a, b] = item.ends.map((end) => this.end(end));
      const span = b.clone().sub(a);
      const z = span.dot(this.up);
      const away = span.addScaledVector(this.up, -z);
      const x = away.length();
      away.normalize();
      const flat = this.shape(item, x, z);
      const { count, points, rods } = item;
      // what the table is off at the ends is taken along the line, so that it begins and ends where its ends are
      const [x0, z0] = flat;
      const dx = x - (flat[2 * count - 2] - x0);
      const dz = z - (flat[2 * count - 1] - z0);
      const heights = points.map((point, k) => {
        const share = k / (count - 1);
        let height = flat[2 * k + 1] - z0 + share * dz;
        if (item.bed && k < count - 1) height = Math.max(height, 0);
        point.copy(a).addScaledVector(away, flat[2 * k] - x0 + share * dx).addScaledVector(this.up, height);
        return height;
      });
      points[count - 1].copy(b);
      for (let k = 0; k < count - 1; k++) {
        along.copy(points[k + 1]).sub(points[k]);
        size.y = along.length();
        if (size.y > 0) turn.setFromUnitVectors(ALONG, along.divideScalar(size.y));
        middle.copy(points[k]).add(points[k + 1]).multiplyScalar(0.5);
        rods.setMatrixAt(k, matrix.compose(middle, turn, size));
        const lies = item.bed && Math.max(heights[k], heights[k + 1]) < 2 * item.off;
        rods.setColorAt(k, this.colours[lies ? "lying" : "line"]);
      }
      rods.instanceMatrix.needsUpdate = true;
      rods.instanceColor.needsUpdate = true;
      item.balls.forEach(({ at }, k) => item.beads[k].position.copy(points[at]));
    }
  }
}

// the bed of the sea, faint, where lines may lie on it
export function beds(scene, info) {
  if (!info.lines?.beds.length) return null;
  const group = new THREE.Group();
  for (const [centre, radius] of info.lines.beds) {
    const disk = new THREE.Mesh(
      new THREE.CircleGeometry(radius, 64),
      new THREE.MeshStandardMaterial({
        color: info.lines.bed.colour, transparent: true, opacity: info.lines.bed.opacity, side: THREE.DoubleSide, depthWrite: false, roughness: 1,
      }),
    );
    disk.rotation.x = -Math.PI / 2;
    disk.position.set(...centre);
    disk.renderOrder = 1;
    group.add(disk);
  }
  scene.add(group);
  return group;
}
