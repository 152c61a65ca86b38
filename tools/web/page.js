/* SPDX-License-Identifier: MIT */
/* Controls, words and the camera of the page, and the order in which it comes to life. */
"use strict";

const backgrounds = {
  light: {skyAbove: [0.75, 0.80, 0.86], skyBelow: [0.86, 0.85, 0.83], blank: [1, 1, 1]},
  dark: {skyAbove: [0.010, 0.013, 0.018], skyBelow: [0.028, 0.028, 0.030], blank: [0.08, 0.09, 0.10]}
};
const turnPerHeight = 3.2; /* radians, for a drag over the picture's height */
const keyTurn = 0.09; /* radians */
const keyMove = 0.05; /* of the picture's height */
const pixelsMost = 1 << 24; /* of a picture: beyond, fewer than the screen has */
const patience = 10; /* seconds without data */
const pickWords = "Click the picture to see where a ray ends.";

const get = id => document.getElementById(id);
const canvas = get("picture");
const dark = matchMedia("(prefers-color-scheme: dark)");

/* ---- words ---- */

function say(words) {
  get("words").textContent = words;
  get("words").hidden = words === "";
}

/* "117,010 leaves at depth 8, a grid of 256³, with colors. 154,867 nodes: 0.4 MiB of this page, 0.9 MiB unpacked." */
function describeSize(tree) {
  const payload = ["colors", "normals", "light"].filter(name => tree[name] !== null).join(" and ")
    .replace(" and normals and", ", normals and");
  const held = `${formatCount(tree.leaves)} leaves at depth ${tree.level}, a grid of ${formatCount(2 ** tree.level)}³` +
    `${payload !== "" ? `, with ${payload}` : ""}.`;
  const cut = tree.level < tree.depth
    ? ` The whole tree has depth ${tree.depth} and ${formatCount(tree.voxels)} voxels; its deeper levels are not here.`
    : "";
  return `${held}${cut} ${formatCount(tree.nodes[tree.level])} nodes: ${formatBytes(tree.packed)} of this page, ` +
    `${formatBytes(tree.bytes)} unpacked.`;
}

/* What a ray found, and where that is in the world. */
function describeHit(tree, look, {met, node, level, steps, direction, distance}) {
  if (!met) {
    return `Nothing here: the ray left the grid after ${formatCount(steps)} steps.`;
  }
  const world = direction.map((along, axis) =>
    (tree.origin[axis] + tree.edge * (look.eye[axis] + distance * along)).toPrecision(6));
  return `Level ${level}, node ${formatCount(node)}, after ${formatCount(steps)} steps, at ${world.join(", ")}.`;
}

/* ---- the page ---- */

class Viewer {
  constructor(tree, drawing) {
    this.tree = tree;
    this.drawing = drawing;
    this.scheduled = false;
    this.level = 0; /* the last that has come */
    this.start = startOf(tree);
    this.camera = null;
    this.sun = null;
    this.touched = false; /* whether the camera was moved; until then it frames the tree in any window */
    this.nodes = {level: tree.level, known: 0, masks: [], directory: []}; /* the levels by which it does */
    this.pointers = new Map();
    this.flight = new Flight(this);
    get("deepest").max = tree.level;
    get("deepest").value = tree.level;
    get("full").hidden = tree.light === null;
    get("start").hidden = this.start === null;
    document.querySelector(`#views input[value="${tree.view}"]`).checked = true;
    this.listen();
    this.resize();
    this.goToStart();
  }

  /* A level that has come, and the texels of the levels before it. */
  addLevel(level, arrays, first) {
    this.drawing.fill(arrays, first);
    this.level = level;
    if (level <= frameLevel) {
      this.nodes.known = level;
      this.nodes.masks.push(...arrays.masks);
      this.nodes.directory.push(...arrays.directory);
    }
    if (level <= frameLevel && !this.touched) {
      this.goHome();
    }
    this.draw();
  }

  /* The values of uniforms that make the present picture. */
  look() {
    const rays = raysOf(this.camera, canvas.width, canvas.height);
    return {
      ...rays,
      ...backgrounds[dark.matches ? "dark" : "light"],
      footprint: get("pixels").checked ? rays.footprint : 0,
      pagePixel: rays.footprint * canvas.height / Math.max(canvas.clientHeight, 1),
      sun: this.sun,
      view: Number(document.forms.controls.view.value),
      deepest: Math.min(Number(get("deepest").value), this.level)
    };
  }

  draw() {
    get("deepest").nextElementSibling.value = get("deepest").value;
    if (this.level === 0) {
      return;
    }
    this.drawing.show(this.look());
    if (!this.scheduled) {
      this.scheduled = true;
      requestAnimationFrame(now => this.step(now));
    }
  }

  step(now) {
    this.scheduled = this.drawing.step(now);
    get("refined").style.width = `${100 * this.drawing.progress()}%`;
    get("refined").hidden = !this.scheduled;
    if (this.scheduled) {
      requestAnimationFrame(next => this.step(next));
    }
  }

  resize() {
    const {clientWidth, clientHeight} = canvas;
    const pixels = Math.min(devicePixelRatio, Math.sqrt(pixelsMost / Math.max(clientWidth * clientHeight, 1)));
    canvas.width = Math.max(1, Math.round(clientWidth * pixels));
    canvas.height = Math.max(1, Math.round(clientHeight * pixels));
    this.drawing.present(); /* setting its size has cleared the canvas */
    if (!this.touched) {
      this.goHome();
    }
    this.draw();
  }

  goHome() {
    this.flight.turn(false);
    this.camera = frameTree(this.nodes, canvas.width / canvas.height, lensOf(this.tree));
    this.sun = sunOf(this.camera);
    this.touched = false;
    this.draw();
  }

  /* Where the page was asked to begin: inside of a tree, flying. */
  goToStart() {
    if (this.start === null) {
      return;
    }
    const {low, high} = this.tree;
    this.sun = sunOf(this.start);
    this.change(this.start);
    this.flight.turn(eyeOf(this.start).every((value, axis) => value > low[axis] && value < high[axis]));
  }

  moveSun() {
    this.sun = sunOf(this.camera);
    this.draw();
  }

  change(camera) {
    this.camera = camera;
    this.touched = true;
    this.draw();
  }

  approach(factor) {
    this.change(approach(this.camera, factor, 2 ** this.tree.level));
  }

  /* The rays of columns x rows pixels spread over the picture. */
  probe(columns, rows) {
    const stride = [canvas.width / columns, canvas.height / rows];
    return this.drawing.probe(this.look(), stride.map(pixels => (pixels - 1) / 2), stride, columns, rows);
  }

  pick(event) {
    const look = this.look();
    const bounds = canvas.getBoundingClientRect();
    const place = [(event.clientX - bounds.left) * canvas.width / bounds.width,
      (event.clientY - bounds.top) * canvas.height / bounds.height];
    const [hit] = this.drawing.probe(look, place.map(pixels => pixels - 0.5), [1, 1], 1, 1);
    get("picked").textContent = describeHit(this.tree, look, hit);
  }

  /* ---- mouse and touch ---- */

  hold(event) {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({preventScroll: true});
    this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
    this.clicking = this.pointers.size === 1 && event.button === 0 && !event.shiftKey;
  }

  release(event) {
    const clicked = this.pointers.delete(event.pointerId) && this.clicking && event.type === "pointerup";
    if (clicked && !this.flight.on) {
      this.pick(event);
    } else if (clicked && event.pointerType === "mouse") {
      this.flight.lock();
    }
    this.clicking = false;
  }

  /* Where the fingers are on average, and how far from there. */
  spread() {
    const points = [...this.pointers.values()];
    const x = points.reduce((sum, point) => sum + point.x, 0) / points.length;
    const y = points.reduce((sum, point) => sum + point.y, 0) / points.length;
    return {x, y, radius: Math.max(...points.map(point => Math.hypot(point.x - x, point.y - y)))};
  }

  drag(event) {
    if (!this.pointers.has(event.pointerId)) {
      return;
    }
    const before = this.spread();
    this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
    const after = this.spread();
    const right = (after.x - before.x) / canvas.clientHeight;
    const down = (after.y - before.y) / canvas.clientHeight;
    this.clicking = this.clicking && Math.hypot(right, down) * canvas.clientHeight < 2;
    if (this.clicking) {
      return;
    }
    if (this.flight.on) {
      const follow = -2 * this.camera.halfFov; /* what is grabbed stays below the finger */
      if (this.pointers.size > 1) {
        this.flight.slide(-right, -down);
      } else {
        this.flight.look(follow * right, -follow * down);
      }
    } else if (this.pointers.size > 1) {
      this.change(move(this.camera, -right, down));
      this.approach(after.radius > 0 ? before.radius / after.radius : 1);
    } else if (event.shiftKey || (event.buttons & 6) !== 0) {
      this.change(move(this.camera, -right, down));
    } else {
      this.change(turn(this.camera, turnPerHeight * right, turnPerHeight * down));
    }
  }

  /* ---- keys ---- */

  press(event) {
    const inControl = event.target.matches?.("input") && /^(Arrow|Home)/.test(event.key);
    if (inControl || event.ctrlKey || event.altKey || event.metaKey) {
      return;
    }
    if (this.flight.press(event)) {
      event.preventDefault();
      return;
    }
    const arrow = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
    if (arrow !== undefined) {
      this.change(event.shiftKey ? move(this.camera, keyMove * arrow[0], keyMove * arrow[1])
        : turn(this.camera, keyTurn * arrow[0], keyTurn * arrow[1]));
    } else if (!this.pressLetter(event.key)) {
      return;
    }
    event.preventDefault();
  }

  /* Returns whether the key has a meaning. */
  pressLetter(key) {
    const deepest = get("deepest");
    const nearer = factor => this.flight.on ? this.flight.change(1 / factor) : this.approach(factor);
    const actions = {
      "+": () => nearer(0.9),
      "=": () => nearer(0.9),
      "-": () => nearer(1 / 0.9),
      "[": () => deepest.stepDown(),
      "]": () => deepest.stepUp(),
      p: () => get("pixels").click(),
      l: () => this.moveSun(),
      f: () => this.flight.turn(!this.flight.on),
      Home: () => this.goHome()
    };
    const view = document.querySelectorAll("#views label:not([hidden]) input")[Number(key) - 1];
    if (view !== undefined) {
      view.checked = true;
    } else if (actions[key] === undefined) {
      return false;
    } else {
      actions[key]();
    }
    this.draw();
    return true;
  }

  /* Pixels of the screen change with the zoom, and from screen to screen, where the page keeps its size. */
  watchPixels() {
    matchMedia(`(resolution: ${devicePixelRatio}dppx)`).addEventListener("change", () => {
      this.resize();
      this.watchPixels();
    }, {once: true});
  }

  listen() {
    canvas.addEventListener("pointerdown", event => this.hold(event));
    canvas.addEventListener("pointermove", event => this.drag(event));
    canvas.addEventListener("pointerup", event => this.release(event));
    canvas.addEventListener("pointercancel", event => this.release(event));
    canvas.addEventListener("contextmenu", event => event.preventDefault());
    canvas.addEventListener("wheel", event => {
      event.preventDefault();
      const factor = Math.exp(clamp(event.deltaY, -120, 120) / 600);
      if (this.flight.on) {
        this.flight.change(1 / factor);
      } else {
        this.approach(factor);
      }
    }, {passive: false});
    addEventListener("keydown", event => this.press(event));
    get("controls").addEventListener("input", () => this.draw());
    get("home").addEventListener("click", () => this.goHome());
    get("start").addEventListener("click", () => this.goToStart());
    get("fly").addEventListener("click", () => this.flight.turn(!this.flight.on));
    get("sun").addEventListener("click", () => this.moveSun());
    dark.addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.watchPixels();
  }
}

/* Says how much has come until all has, and what is missing if the file ended before. A browser does not tell a page
   that its connection broke: so the page says when nothing comes. */
class Announcer {
  constructor(arrival, viewer) {
    this.arrival = arrival;
    this.viewer = viewer;
    this.timer = null;
  }

  say() {
    const {level, tree} = this.viewer;
    const words = `Level ${level} of ${tree.level}, ${Math.floor(100 * this.arrival.share())} % has come`;
    clearTimeout(this.timer);
    get("coming").hidden = level === tree.level;
    if (this.arrival.cut && level < tree.level) {
      get("coming").textContent =
        `The file of this page was cut off: level ${level} of ${tree.level} is the last here.`;
      return;
    }
    get("coming").textContent = words;
    this.timer = setTimeout(() => {
      get("coming").textContent = `${words}, and nothing more for ${patience} seconds. Was the page cut off?`;
    }, 1000 * patience);
  }
}

let arrival = null;
let take = () => undefined; /* called behind each block of data */

async function begin() {
  const tree = JSON.parse(get("tree").textContent);
  document.title = `${tree.name} – svocl`;
  get("name").textContent = tree.name;
  get("size").textContent = describeSize(tree);
  canvas.setAttribute("aria-label", `Picture of ${tree.name}`);
  say("Waiting for the nodes …");
  canvas.addEventListener("webglcontextlost", () => say("The graphics device was lost. Load the page again to go on."));
  arrival = new Arrival(tree);
  const viewer = new Viewer(tree, new Drawing(canvas, tree));
  const announcer = new Announcer(arrival, viewer);
  take = () => {
    const block = document.currentScript.previousElementSibling;
    arrival.take(block.textContent);
    block.remove();
    announcer.say();
  };
  document.addEventListener("DOMContentLoaded", () => arrival.end());
  await arrival.read((level, arrays, first) => {
    say("");
    viewer.addLevel(level, arrays, first);
    announcer.say();
  });
  if (viewer.level === 0) {
    throw new Refusal("The file of this page was cut off before its first level. Load it again.");
  }
  announcer.say();
  return viewer;
}

/* What is missing is said where the picture would be. */
function refuse(error) {
  document.body.classList.add("refused");
  get("coming").hidden = true;
  if (error instanceof Refusal) {
    say(error.message);
  } else {
    say(`The page failed: ${error.message}`);
    console.error(error);
  }
}

const viewer = begin();
viewer.catch(refuse);
