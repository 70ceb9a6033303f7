// Names of bodies and joints over the picture, pushed apart; bodies first, what finds no room is left out.
import * as THREE from "three";

const LINE = 17;

export class Names {
  constructor(viewer) {
    this.viewer = viewer;
    this.on = { bodies: true, joints: false, markers: false };
    this.layer = document.createElement("div");
    this.layer.className = "names";
    viewer.stage.append(this.layer);
    const { info } = viewer;
    this.items = [
      ...info.labels.map((item) => this.make("bodies", item)),
      ...info.axes.map((item) => this.make("joints", item)),
      ...info.markers.map((item) => this.make("markers", item)),
    ];
  }

  make(kind, item) {
    const label = document.createElement("span");
    label.className = kind;
    label.textContent = item.name;
    this.layer.append(label);
    return { kind, label, body: item.body, at: new THREE.Vector3(...item.r) };
  }

  draw() {
    const { camera, nodes, stage } = this.viewer;
    const taken = [];
    const point = new THREE.Vector3();

    for (const { kind, label, body, at } of this.items) {
      const node = nodes.get(body);
      label.hidden = true;
      if (!this.on[kind] || !node) continue;
      point.copy(at).applyMatrix4(node.matrixWorld).project(camera);
      if (point.z > 1 || Math.abs(point.x) > 1 || Math.abs(point.y) > 1) continue;
      label.hidden = false;
      const width = label.offsetWidth + 6;
      const x = ((point.x + 1) / 2) * stage.clientWidth + 8;
      const y = ((1 - point.y) / 2) * stage.clientHeight - LINE / 2;
      const free = (top) =>
        taken.every((box) => x + width < box.x || box.x + box.width < x || top + LINE <= box.y || box.y + LINE <= top);
      const shift = [0, 1, -1, 2, -2, 3, -3].find((step) => free(y + step * LINE));
      if (shift === undefined) {
        label.hidden = true;
        continue;
      }
      const top = y + shift * LINE;
      taken.push({ x, y: top, width });
      label.style.transform = `translate(${x.toFixed(1)}px, ${top.toFixed(1)}px)`;
    }
  }
}
