// The bar of time below, and what can be shown or hidden.
const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

export class Panel {
  constructor(viewer, page) {
    this.viewer = viewer;
    const { info } = viewer;
    viewer.stage.append(element("h1", { textContent: info.title }));
    if (info.notes.length) {
      const notes = info.notes.map((text) => element("li", { textContent: text }));
      viewer.stage.append(element("ul", { className: "notes" }, ...notes));
    }
    this.menu(viewer.stage);
    if (viewer.clip) this.bar(page);
    addEventListener("keydown", (event) => this.key(event));
  }

  bar(page) {
    const { viewer } = this;
    this.button = element("button", { title: "play or pause (space)", id: "play" });
    this.button.onclick = () => (viewer.playing ? viewer.pause() : viewer.play());
    this.slider = element("input", { type: "range", min: 0, max: 1, step: "any", id: "time", title: "time" });
    this.slider.oninput = () => {
      // read before pausing puts it back
      const time = viewer.begin + this.slider.value * (viewer.end - viewer.begin);
      viewer.pause();
      viewer.seek(time);
    };
    this.clock = element("output", { id: "clock" });
    const speeds = SPEEDS.map((speed) => element("option", { value: speed, textContent: `${speed} x` }));
    const speed = element("select", { title: "speed", id: "speed" }, ...speeds);
    speed.value = 1;
    speed.onchange = () => (viewer.speed = Number(speed.value));
    page.append(element("div", { className: "bar" }, this.button, this.slider, this.clock, speed));
  }

  menu(stage) {
    const { viewer } = this;
    const { info, names, extras, layers, arrows, lines, paths, plots } = viewer;
    const rows = [
      this.check("names of bodies", names.on.bodies, (on) => (names.on.bodies = on)),
      this.check("names of joints", false, (on) => (names.on.joints = on)),
      info.axes.length && this.check("joint axes", false, (on) => (extras.axes.visible = on)),
      info.markers.length && this.check("frames of markers", false, (on) => {
        extras.frames.visible = on;
        names.on.markers = on;
      }),
      extras.grid && this.check(`grid (${extras.grid.userData.cell} m)`, true, (on) => (extras.grid.visible = on)),
      lines.items.length && this.check("mooring lines", true, (on) => (lines.group.visible = on)),
      extras.beds && this.check("sea bed", true, (on) => (extras.beds.visible = on)),
      extras.water && this.check("water", true, (on) => (extras.water.visible = on)),
      ...Object.entries({ curves: "curves", surfaces: "surfaces", link: "springs and rods" }).map(
        ([layer, words]) =>
          layers[layer].length &&
          this.check(words, true, (on) => layers[layer].forEach((node) => (node.visible = on))),
      ),
      ...this.forces(arrows),
      this.followed(),
      this.list("paths", viewer.clip ? info.ends.map((end) => end.name) : [], info.paths, (end, on) => paths.show(end, on)),
      this.list("plots", [...plots.known.keys()], [...plots.shown.keys()], (name, on) => plots.show(name, on)),
      element("p", { className: "help", textContent: "drag: turn, right: move, wheel: nearer" }),
    ].filter(Boolean);
    const menu = element("details", { className: "menu" }, element("summary", { textContent: "show" }), ...rows);
    stage.append(menu);
  }

  forces(arrows) {
    const kinds = new Set(arrows.items.map((item) => `${item.source} ${item.what}`));
    const rows = [...kinds].map((kind) =>
      this.check(`arrows: ${kind}`, false, (on) => {
        arrows.kinds[on ? "add" : "delete"](kind);
        arrows.seek(this.viewer.time);
      }),
    );
    if (!rows.length) return [];
    const length = element("input", { type: "range", min: -1.5, max: 1.5, step: 0.05, value: 0, title: "length of arrows" });
    length.oninput = () => {
      arrows.length = 10 ** Number(length.value);
      arrows.seek(this.viewer.time);
    };
    return [...rows, element("label", {}, "their length ", length)];
  }

  followed() {
    const { viewer } = this;
    const options = [element("option", { value: "", textContent: "nothing" })];
    for (const body of viewer.info.follow) options.push(element("option", { value: body, textContent: body }));
    const choice = element("select", { id: "follow" }, ...options);
    choice.value = viewer.info.followed;
    viewer.follow(choice.value);
    choice.onchange = () => viewer.follow(choice.value);
    return viewer.clip && element("label", {}, "follow ", choice);
  }

  check(words, on, change) {
    const box = element("input", { type: "checkbox", checked: on });
    box.onchange = () => change(box.checked);
    return element("label", {}, box, " ", words);
  }

  list(words, names, shown, change) {
    if (!names.length) return null;
    const rows = names.map((name) => this.check(name, shown.includes(name), (on) => change(name, on)));
    const open = element("details", {}, element("summary", { textContent: words }), element("div", { className: "list" }, ...rows));
    return open;
  }

  key(event) {
    if (!this.button || /^(INPUT|SELECT|BUTTON|SUMMARY)$/.test(event.target.tagName)) return;
    const { viewer } = this;
    const step = (viewer.end - viewer.begin) / 200;
    if (event.key === " ") this.button.click();
    else if (event.key === "ArrowRight") viewer.seek(viewer.time + step);
    else if (event.key === "ArrowLeft") viewer.seek(viewer.time - step);
    else return;
    event.preventDefault();
  }

  update() {
    if (!this.button) return;
    const { viewer } = this;
    this.button.textContent = viewer.playing ? "pause" : "play";
    this.slider.value = (viewer.time - viewer.begin) / (viewer.end - viewer.begin);
    this.clock.value = `${viewer.time.toFixed(viewer.end - viewer.begin < 2 ? 3 : 2)} s`;
  }
}
