/* SPDX-License-Identifier: MIT */
/* Fly mode: the camera looks around from where it stands, and moves while keys are held. */
"use strict";

const flyKeys = { /* right, up, forward */
  KeyW: [0, 0, 1], ArrowUp: [0, 0, 1],
  KeyS: [0, 0, -1], ArrowDown: [0, 0, -1],
  KeyA: [-1, 0, 0], ArrowLeft: [-1, 0, 0],
  KeyD: [1, 0, 0], ArrowRight: [1, 0, 0],
  KeyE: [0, 1, 0], PageUp: [0, 1, 0],
  KeyQ: [0, -1, 0], PageDown: [0, -1, 0]
};
const flySeconds = 12; /* from one end of the tree to the other, at first */
const flyFaster = 4; /* with Shift */
const flyStepMost = 0.1; /* seconds: on a slow device, the next picture is not elsewhere */
const mouseTurn = 0.0025; /* radians for a pixel of the mouse */

class Flight {
  constructor(viewer) {
    const {low, high} = viewer.tree;
    this.viewer = viewer;
    this.extent = Math.max(...high.map((end, axis) => end - low[axis]));
    this.speed = this.extent / flySeconds; /* cells a second */
    this.on = false;
    this.held = new Set(); /* codes of keys */
    this.faster = false;
    this.moved = null; /* when; null: it stands */
    document.addEventListener("mousemove", event => {
      if (this.on && document.pointerLockElement === canvas) {
        this.look(mouseTurn * event.movementX, -mouseTurn * event.movementY);
      }
    });
    addEventListener("keyup", event => {
      this.held.delete(event.code);
      this.faster = event.shiftKey;
    });
    addEventListener("blur", () => this.held.clear());
  }

  turn(on) {
    this.on = on;
    this.held.clear();
    get("fly").setAttribute("aria-pressed", on);
    get("picked").textContent = on ? this.describe() : pickWords;
    if (!on && document.pointerLockElement === canvas) {
      document.exitPointerLock();
    }
  }

  describe() {
    const speed = (this.speed * this.viewer.tree.edge).toPrecision(3);
    return `Flying, ${speed} units a second (wheel). W A S D, Q and E move. Drag to look around, or click and use ` +
      "the mouse.";
  }

  /* The mouse looks around without a button until Escape; where a browser does not allow that, dragging still does. */
  lock() {
    Promise.resolve(canvas.requestPointerLock?.()).catch(() => undefined);
  }

  change(factor) {
    this.speed = clamp(this.speed * factor, this.extent / 2000, this.extent * 2);
    get("picked").textContent = this.describe();
  }

  /* right, up: radians. */
  look(right, up) {
    this.viewer.change(lookAround(this.viewer.camera, right, up));
  }

  /* right, forward: parts of the picture's height, as two fingers move. */
  slide(right, forward) {
    this.viewer.change(fly(this.viewer.camera, scale([right, 0, forward], 2 * this.speed)));
  }

  /* Returns whether the key moves. */
  press(event) {
    if (!this.on || flyKeys[event.code] === undefined) {
      return false;
    }
    this.held.add(event.code);
    this.faster = event.shiftKey;
    if (this.moved === null) {
      this.moved = performance.now();
      requestAnimationFrame(now => this.step(now));
    }
    return true;
  }

  step(now) {
    if (this.held.size === 0) {
      this.moved = null;
      return;
    }
    const seconds = clamp((now - this.moved) / 1000, 0, flyStepMost);
    const way = [...this.held].map(code => flyKeys[code]).reduce(add);
    this.moved = now;
    this.viewer.change(fly(this.viewer.camera, scale(way, seconds * this.speed * (this.faster ? flyFaster : 1))));
    requestAnimationFrame(next => this.step(next));
  }
}
