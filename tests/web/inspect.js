/* SPDX-License-Identifier: MIT */
/* Goes into a copy of a page of svocl export-web, uses it, and leaves what it found in the document, in elements with
   the names of what they hold. pictures: those of svocl render, by view, as data: addresses. */
"use strict";

const complaints = [];
addEventListener("error", event => complaints.push(event.message));
addEventListener("unhandledrejection", event => complaints.push(event.reason));
document.addEventListener("securitypolicyviolation", event => complaints.push(event.blockedURI));

/* The browser writes the document out when it is loaded, for which it waits for a frame that is still written to. */
let unfinished = null;
addEventListener("DOMContentLoaded", () => {
  unfinished = document.body.appendChild(document.createElement("iframe"));
  unfinished.contentDocument.open();
});

function leave(name, text) {
  const element = document.createElement("pre");
  element.id = `found-${name}`;
  element.textContent = text;
  element.hidden = true;
  document.body.append(element, "\n");
}

async function finish(shown) {
  do {
    await new Promise(requestAnimationFrame);
  } while (shown.scheduled);
}

function readCanvas(shown) {
  const {gl} = shown.drawing;
  const pixels = new Uint8Array(4 * canvas.width * canvas.height);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return pixels;
}

/* The same, of a picture of the canvas's size; from the bottom up. */
async function readPicture(source) {
  const image = new Image();
  image.src = source;
  await image.decode();
  const flat = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
  flat.canvas.width = image.width;
  flat.canvas.height = image.height;
  flat.setTransform(1, 0, 0, -1, 0, image.height);
  flat.drawImage(image, 0, 0);
  return flat.getImageData(0, 0, image.width, image.height).data;
}

/* The mean difference of a component, of 255. */
function distance(one, other) {
  const sum = one.reduce((total, value, i) => total + Math.abs(value - other[i]), 0);
  return one.length === other.length ? (sum / one.length).toFixed(2) : "another size";
}

/* The share of pixels that differ by more than 8 of 255 in a component, in percent. */
function compare(one, other) {
  let different = 0;
  for (let i = 0; i < one.length; i += 4) {
    different += [0, 1, 2].some(part => Math.abs(one[i + part] - other[i + part]) > 8);
  }
  return one.length === other.length ? (100 * different / (one.length / 4)).toFixed(2) : "another size";
}

function describeProbes(shown) {
  const {eye, footprint} = shown.look();
  const lines = shown.probe(64, 64).map(({direction, met, node, level}) =>
    [...eye.map(Math.fround), ...direction, Number(met), node, level].join(" "));
  return [Math.fround(footprint), ...lines].join("\n");
}

/* Clicks where a ray of the middle row ends; returns whether the page names the node that it ends at. */
function pickOne(shown) {
  const hits = shown.probe(64, 64);
  const index = hits.findIndex((hit, i) => i >= 32 * 64 && hit.met);
  const bounds = canvas.getBoundingClientRect();
  const place = {
    pointerId: 1,
    clientX: bounds.left + (index % 64 + 0.5) / 64 * bounds.width,
    clientY: bounds.top + (Math.floor(index / 64) + 0.5) / 64 * bounds.height
  };
  canvas.dispatchEvent(new PointerEvent("pointerdown", place));
  canvas.dispatchEvent(new PointerEvent("pointerup", place));
  const text = get("picked").textContent;
  return text.startsWith(`Level ${hits[index].level}, node ${formatCount(hits[index].node)}, after `) || text;
}

/* What mouse and fingers do to the camera: the names of those that do something else. */
function moveCamera(shown) {
  const send = (type, pointerId, clientX, more = {}) =>
    canvas.dispatchEvent(new PointerEvent(type, {pointerId, clientX, clientY: 50, ...more}));
  const wrong = [];
  const expect = (name, act, isRight) => {
    const before = shown.camera;
    act();
    if (!isRight(before, shown.camera)) {
      wrong.push(name);
    }
  };
  const drag = more => {
    send("pointerdown", 1, 20, more);
    send("pointermove", 1, 40, more);
    send("pointerup", 1, 40, more);
  };
  const isSame = (a, b) => a.every((value, axis) => Math.abs(value - b[axis]) < 1e-9);
  expect("drag", () => drag({buttons: 1}), (before, after) =>
    after.yaw < before.yaw && after.pitch === before.pitch && isSame(after.target, before.target));
  expect("drag with the right button", () => drag({buttons: 2, button: 2}), (before, after) =>
    after.yaw === before.yaw && !isSame(after.target, before.target));
  expect("two fingers", () => {
    send("pointerdown", 1, 40);
    send("pointerdown", 2, 60);
    send("pointermove", 1, 30);
    send("pointermove", 2, 70);
    send("pointerup", 1, 30);
    send("pointerup", 2, 70);
  }, (before, after) => Math.abs(after.distance / before.distance - 0.5) < 1e-9 && after.yaw === before.yaw);
  expect("wheel", () => canvas.dispatchEvent(new WheelEvent("wheel", {deltaY: -120, cancelable: true})),
    (before, after) => after.distance < before.distance);
  expect("Home", () => get("home").click(), (before, after) =>
    isSame(after.target, frameTree(shown.nodes, canvas.width / canvas.height).target));
  return wrong.join(", ");
}

async function inspect(shown) {
  canvas.setPointerCapture = () => undefined; /* the test's pointers do not exist */
  canvas.style.width = "128px";
  canvas.style.height = "96px";
  shown.resize();
  const seen = [];
  for (let view = 0; view < 5; ++view) {
    document.querySelector(`#views input[value="${view}"]`).click();
    await finish(shown);
    seen.push(readCanvas(shown));
  }
  for (const [view, source] of pictures.entries()) {
    const picture = await readPicture(source);
    leave(`differs-${view}`, compare(seen[view], picture));
    leave(`distance-${view}`, distance(seen[view], picture));
  }
  shown.approach(0.6); /* so near that nodes of several levels are as large as a pixel */
  leave("probes-pixel", describeProbes(shown));
  get("pixels").click();
  leave("probes-leaf", describeProbes(shown));
  leave("picked", pickOne(shown));
  const before = readCanvas(shown);
  dispatchEvent(new KeyboardEvent("keydown", {key: "ArrowRight"}));
  await finish(shown);
  const turned = readCanvas(shown);
  dispatchEvent(new KeyboardEvent("keydown", {key: "["}));
  await finish(shown);
  leave("turned", Number(compare(before, turned)) > 1);
  leave("coarser", Number(compare(turned, readCanvas(shown))) > 1);
  leave("moved", moveCamera(shown));
}

addEventListener("DOMContentLoaded", async () => {
  const shown = await viewer.catch(() => null);
  if (shown !== null && typeof pictures !== "undefined") {
    await inspect(shown);
  }
  await new Promise(done => setTimeout(done, 300)); /* a lost device tells it later */
  leave("words", get("words").textContent);
  leave("outside", performance.getEntriesByType("resource").filter(({name}) => !name.startsWith("data:")).length);
  leave("complaints", complaints.join("; "));
  leave("wide", document.documentElement.scrollWidth > innerWidth);
  unfinished.contentDocument.close();
});
