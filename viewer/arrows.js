// Arrows of forces and moments over time; off until they are asked for.
import * as THREE from "three";
import { floats } from "./numbers.js";

const COLOURS = { load: "#d35400", spring: "#7a5195", reaction: "#0b7a75", input: "#c2185b" };

export class Arrows {
  constructor(root, info) {
    this.kinds = new Set();
    this.length = 1;
    this.times = info.arrows ? floats(info.arrows.times) : [];
    this.items = (info.arrows ? info.arrows.items : []).map((item) => {
      const at = floats(item.at);
      const values = floats(item.values);
      const arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 1, 0), new THREE.Vector3(), 1, COLOURS[item.source]);
      arrow.visible = false;
      for (const part of [arrow.line, arrow.cone]) {
        part.material.depthTest = false;
        part.renderOrder = 4;
        part.frustumCulled = false;
      }
      root.add(arrow);
      return { ...item, at, values, arrow };
    });
    this.largest = {};
    for (const { what, values } of this.items) {
      for (let k = 0; k < values.length; k += 3) {
        this.largest[what] = Math.max(this.largest[what] ?? 0, Math.hypot(values[k], values[k + 1], values[k + 2]));
      }
    }
    this.unit = 0.6 * info.radius;
  }

  seek(time) {
    this.time = time;
    if (!this.items.length) return;
    const { times } = this;
    let k = times.findIndex((t) => t > time);
    k = Math.max(0, (k < 0 ? times.length : k) - 1);
    const next = Math.min(k + 1, times.length - 1);
    const part = next > k ? (time - times[k]) / (times[next] - times[k]) : 0;
    const mix = (values) =>
      new THREE.Vector3().fromArray(values, 3 * k).lerp(new THREE.Vector3().fromArray(values, 3 * next), part);

    for (const item of this.items) {
      item.arrow.visible = false;
      if (!this.kinds.has(`${item.source} ${item.what}`)) continue;
      const value = mix(item.values);
      const size = value.length();
      const length = (this.unit * this.length * size) / (this.largest[item.what] || 1);
      if (length < 0.004 * this.unit) continue;
      item.arrow.visible = true;
      item.arrow.position.copy(mix(item.at));
      item.arrow.setDirection(value.divideScalar(size));
      item.arrow.setLength(length, Math.min(0.25 * length, 0.12 * this.unit), Math.min(0.12 * length, 0.05 * this.unit));
    }
  }
}
