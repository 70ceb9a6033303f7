// Paths of chosen points, through the rows of the run.
import * as THREE from "three";

const MOST = 3000;

export class Paths {
  constructor(viewer) {
    this.viewer = viewer;
    this.lines = new Map();
    for (const end of viewer.info.paths) this.show(end, true);
  }

  show(end, on) {
    if (this.lines.has(end)) {
      this.lines.get(end).removeFromParent();
      this.lines.delete(end);
    }
    const place = this.viewer.info.ends.find((item) => item.name === end);
    if (!on || !place || !this.viewer.clip) return;
    const colour = new THREE.Color().setHSL((0.58 + 0.27 * this.lines.size) % 1, 0.8, 0.4);
    const geometry = new THREE.BufferGeometry().setFromPoints(this.points(place));
    const line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: colour }));
    line.frustumCulled = false;
    this.lines.set(end, line);
    this.viewer.root.add(line);
  }

  // the point in the root's axes at every row
  points(place) {
    const { clip, nodes, root } = this.viewer;
    const chain = [];
    for (let node = nodes.get(place.body); node && node !== root; node = node.parent) chain.push(node);
    const tracks = chain.map((node) => ({
      node,
      r: clip.tracks.find((track) => track.name === `${node.name}.position` || track.name === `${node.uuid}.position`),
      q: clip.tracks.find((track) => track.name === `${node.name}.quaternion` || track.name === `${node.uuid}.quaternion`),
    }));
    const n = Math.max(1, ...tracks.flatMap(({ r, q }) => [r, q].filter(Boolean).map((track) => track.times.length)));
    const step = Math.ceil(n / MOST);
    const found = [];
    const turn = new THREE.Quaternion();
    for (let k = 0; k < n; k = k < n - 1 ? Math.min(n - 1, k + step) : n) {
      const point = new THREE.Vector3(...place.r);
      for (const { node, r, q } of tracks) {
        point.applyQuaternion(q ? turn.fromArray(q.values, 4 * k) : node.quaternion);
        point.add(r ? new THREE.Vector3().fromArray(r.values, 3 * k) : node.position);
      }
      found.push(point);
    }
    return found;
  }
}
