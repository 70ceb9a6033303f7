// Plots of chosen variables beside the picture, under the same time cursor.
import { floats } from "./numbers.js";

const COLOURS = ["#4e79a7", "#e15759", "#59a14f", "#f28e2b"];

export class Plots {
  constructor(viewer, page) {
    this.viewer = viewer;
    this.column = document.createElement("div");
    this.column.className = "plots";
    this.column.hidden = true;
    page.append(this.column);
    this.shown = new Map();
    const { plots } = viewer.info;
    this.times = plots ? floats(plots.times) : [];
    this.known = new Map((plots ? plots.items : []).map((item) => [item.name, item]));
    for (const name of plots ? plots.shown : []) this.show(name, true);
  }

  // an item may have several lines: the components of an array
  show(name, on) {
    if (!on) {
      this.shown.get(name)?.box.remove();
      this.shown.delete(name);
    } else if (this.known.has(name) && !this.shown.has(name)) {
      const item = this.known.get(name);
      const box = document.createElement("div");
      box.className = "plot";
      const head = document.createElement("div");
      head.className = "head";
      const canvas = document.createElement("canvas");
      box.append(head, canvas);
      this.column.append(box);
      const lines = item.lines.map((line) => ({ label: line.label, values: floats(line) }));
      this.shown.set(name, { item, box, head, canvas, lines });
      canvas.addEventListener("pointerdown", (event) => this.grab(canvas, event));
      canvas.addEventListener("pointermove", (event) => event.buttons && this.grab(canvas, event));
    }
    this.column.hidden = !this.shown.size;
    for (const plot of this.shown.values()) this.draw(plot);
  }

  grab(canvas, event) {
    const { viewer } = this;
    viewer.pause();
    const part = (event.clientX - canvas.getBoundingClientRect().left) / canvas.clientWidth;
    viewer.seek(viewer.begin + part * (viewer.end - viewer.begin));
  }

  cursor() {
    for (const plot of this.shown.values()) this.draw(plot);
  }

  draw({ item, head, canvas, lines }) {
    const ratio = Math.min(window.devicePixelRatio, 2);
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    if (!width) return;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const { begin, end, time } = this.viewer;
    let low = Infinity;
    let high = -Infinity;
    for (const { values } of lines) {
      for (const value of values) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
    if (high - low < 1e-12 * Math.max(Math.abs(low), Math.abs(high), 1e-300)) [low, high] = [low - 1, high + 1];
    const x = (t) => ((t - begin) / (end - begin || 1)) * width;
    const y = (value) => 4 + ((high - value) / (high - low)) * (height - 8);

    if (low < 0 && high > 0) {
      pen.strokeStyle = "#cfd9e2";
      pen.beginPath();
      pen.moveTo(0, y(0));
      pen.lineTo(width, y(0));
      pen.stroke();
    }
    lines.forEach(({ values }, k) => {
      pen.strokeStyle = COLOURS[k % COLOURS.length];
      pen.lineWidth = 1.3;
      pen.beginPath();
      values.forEach((value, i) => pen.lineTo(x(this.times[i]), y(value)));
      pen.stroke();
    });
    pen.strokeStyle = "#1c2b3a";
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(x(time), 0);
    pen.lineTo(x(time), height);
    pen.stroke();
    pen.fillStyle = "#6b7b8a";
    pen.font = "10px system-ui, sans-serif";
    pen.fillText(high.toPrecision(3), 2, 11);
    pen.fillText(low.toPrecision(3), 2, height - 3);

    head.replaceChildren(`${item.name}${item.unit ? ` [${item.unit}]` : ""} `);
    lines.forEach(({ label, values }, k) => {
      const value = document.createElement("span");
      value.style.color = COLOURS[k % COLOURS.length];
      value.textContent = ` ${label}${label ? " " : ""}${this.at(values, time).toPrecision(5)}`;
      head.append(value);
    });
  }

  at(values, time) {
    const { times } = this;
    let low = 0;
    let high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle;
      else high = middle;
    }
    const part = high > low ? Math.min(1, Math.max(0, (time - times[low]) / (times[high] - times[low]))) : 0;
    return values[low] + part * (values[high] - values[low]);
  }
}
