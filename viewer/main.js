// The viewer of mbdfmi's pages: shows an animated GLB and what the page tells of it.
// `window.mbdfmiShow(glb, info)` starts it; `window.mbdfmi` is its handle, also for tests.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { Arrows } from "./arrows.js";
import { Lines, beds } from "./lines.js";
import { Names } from "./names.js";
import { Panel } from "./panel.js";
import { Paths } from "./paths.js";
import { Plots } from "./plots.js";
import { frames, grid, jointAxes, water } from "./scenery.js";

window.mbdfmiShow = async function (glb, info) {
  const page = document.getElementById("mbdfmi");
  const options = new URLSearchParams(location.hash.slice(1));

  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: options.has("picture") });
  } catch (error) {
    const words = document.createElement("p");
    words.className = "words";
    words.textContent =
      "This browser shows no 3D (WebGL is off or missing), so the machine cannot be drawn here. " +
      "Try another browser, or write a .glb for Blender or a .png: mbdfmi view --help.";
    page.append(words);
    page.dataset.state = "no WebGL";
    return;
  }

  const gltf = await new GLTFLoader().parseAsync(glb, "");
  const viewer = new Viewer(page, renderer, gltf, info, options);
  window.mbdfmi = viewer;
  page.dataset.state = "ready";
};

class Viewer {
  constructor(page, renderer, gltf, info, options) {
    Object.assign(this, { page, renderer, info });
    this.speed = 1;
    this.playing = false;
    this.follows = null;
    this.end = info.times ? info.times[1] : 0;
    this.begin = info.times ? info.times[0] : 0;
    this.time = this.begin;

    renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.stage = document.createElement("div");
    this.stage.className = "stage";
    this.stage.append(renderer.domElement);
    page.append(this.stage);

    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color("#f4f6f8");
    this.scene.add(gltf.scene);
    // the scene of the file > its root node, turned so that y is up > bodies
    this.root = gltf.scene.children[0];
    this.nodes = new Map();
    this.layers = { curves: [], surfaces: [], link: [] };
    this.root.traverse((node) => {
      const kind = node.userData.kind;
      if (kind === "body") this.nodes.set(info.bodies[this.nodes.size], node);
      else if (this.layers[kind]) this.layers[kind].push(node);
      if (node.isMesh) node.frustumCulled = false;
    });

    this.clip = gltf.animations[0];
    if (this.clip) {
      this.mixer = new THREE.AnimationMixer(gltf.scene);
      const action = this.mixer.clipAction(this.clip);
      action.setLoop(THREE.LoopOnce);
      action.clampWhenFinished = true;
      action.play();
    }

    this.light();
    this.extras = {
      grid: grid(this.scene, this.root, info),
      water: water(this.scene, info),
      beds: beds(this.scene, info),
      frames: frames(this.nodes, info),
      axes: jointAxes(this.nodes, info),
    };
    this.paths = new Paths(this);
    this.arrows = new Arrows(this.root, info);
    this.lines = new Lines(this);
    this.names = new Names(this);
    this.plots = new Plots(this, page);
    this.panel = new Panel(this, page, options.has("picture"));
    this.look();

    if (options.has("t")) this.seek(Number(options.get("t")));
    else this.seek(this.begin);
    if (options.has("picture")) page.classList.add("picture");
    else if (this.clip && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.play();

    new ResizeObserver(() => this.resize()).observe(this.stage);
    this.resize();
    this.last = performance.now();
    renderer.setAnimationLoop((now) => this.frame(now));
  }

  light() {
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#b8b2a8", 2.2));
    for (const [x, y, z, strength] of [[1, 2, 1.5, 1.6], [-1.5, 0.5, -1, 0.6]]) {
      const sun = new THREE.DirectionalLight("#ffffff", strength);
      sun.position.set(x, y, z);
      this.scene.add(sun);
    }
  }

  // the camera where all that moves is seen
  look() {
    const { centre, radius, eye } = this.info;
    this.camera = new THREE.PerspectiveCamera(35, 1, radius / 500, radius * 60);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.target.set(...centre);
    this.eye = new THREE.Vector3(...eye).normalize();
  }

  // how far away the eye must be for the ball around everything to fill the window
  stand() {
    const half = THREE.MathUtils.degToRad(this.camera.fov) / 2;
    const narrow = Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect));
    const distance = (this.info.radius / Math.sin(narrow)) * 0.95;
    this.camera.position.copy(this.controls.target).addScaledVector(this.eye, distance);
    this.controls.update();
    this.stood = true;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.stood) this.stand();
    this.draw();
  }

  play() {
    if (!this.clip) return;
    if (this.time >= this.end) this.seek(this.begin);
    this.playing = true;
    this.panel.update();
  }

  pause() {
    this.playing = false;
    this.panel.update();
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.begin), this.end);
    if (this.mixer) {
      const before = this.place();
      // the clock of the clip goes on from 0; a finished action must be woken again
      const action = this.mixer.existingAction(this.clip) ?? this.mixer.clipAction(this.clip);
      action.reset().play();
      this.mixer.setTime(this.time);
      this.moveAlong(before);
    }
    this.arrows.seek(this.time);
    this.lines.seek();
    this.extras.water?.seek(this.time);
    this.panel.update();
    this.plots.cursor();
  }

  // where what is followed is, in the world
  place() {
    if (!this.follows) return null;
    const node = this.nodes.get(this.follows);
    node.updateWorldMatrix(true, false);
    return new THREE.Vector3().setFromMatrixPosition(node.matrixWorld);
  }

  follow(body) {
    this.follows = body || null;
  }

  moveAlong(before) {
    if (!before) return;
    const moved = this.place().sub(before);
    this.controls.target.add(moved);
    this.camera.position.add(moved);
  }

  frame(now) {
    const passed = Math.min(0.1, (now - this.last) / 1000);
    this.last = now;
    if (this.playing) {
      const next = this.time + passed * this.speed;
      this.seek(next > this.end ? this.begin : next);
    }
    this.controls.update();
    this.draw();
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
    this.names.draw();
  }

  // pose of a body in the picture's frame: 16 numbers by column
  pose(body) {
    this.scene.updateMatrixWorld(true);
    const own = this.nodes.get(body).matrixWorld;
    return new THREE.Matrix4().copy(this.root.matrixWorld).invert().multiply(own).elements.slice();
  }
}
