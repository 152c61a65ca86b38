/* SPDX-License-Identifier: MIT */
/* A camera that turns around a target. Lengths are in cells of the grid; y is up. */
"use strict";

const halfFov = 0.28; /* radians; as svo_camera_frame has it, like the direction below and the margin */
const homeDirection = [0.406, 0.375, 0.833];
const frameMargin = 1.04;
const steepest = 1.55; /* radians above the horizon: short of the pole */

const add = (a, b) => a.map((value, axis) => value + b[axis]);
const scale = (a, factor) => a.map(value => value * factor);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const normalize = a => scale(a, 1 / Math.hypot(...a));
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

function axesOf(camera) {
  const level = Math.cos(camera.pitch);
  const back = [level * Math.sin(camera.yaw), Math.sin(camera.pitch), level * Math.cos(camera.yaw)];
  const forward = scale(back, -1);
  const right = normalize(cross(forward, [0, 1, 0]));
  return {forward, right, up: cross(right, forward)};
}

/* Frames a box as svo_camera_frame does: the least distance from which all corners are in view, and the target moved
   until they are centered. */
function frameBox(low, high, aspect) {
  const direction = normalize(homeDirection);
  const camera = {yaw: Math.atan2(direction[0], direction[2]), pitch: Math.asin(direction[1])};
  const axes = axesOf(camera);
  const tangentUp = Math.tan(halfFov) / frameMargin;
  const tangentRight = tangentUp * aspect;
  let target = scale(add(low, high), 0.5);
  let distance = 0;
  for (let pass = 0; pass < 4; ++pass) {
    const corners = [...Array(8).keys()].map(k => {
      const offset = [0, 1, 2].map(axis => ((k >> axis & 1) !== 0 ? high : low)[axis] - target[axis]);
      return {right: dot(offset, axes.right), up: dot(offset, axes.up), beyond: dot(offset, axes.forward)};
    });
    distance = Math.max(...corners.map(({right, up, beyond}) =>
      Math.max(Math.abs(right) / tangentRight, Math.abs(up) / tangentUp) - beyond));
    const middle = side => {
      const seen = corners.map(corner => corner[side] / (distance + corner.beyond));
      return distance * (Math.min(...seen) + Math.max(...seen)) / 2;
    };
    if (pass < 3) {
      target = add(target, add(scale(axes.right, middle("right")), scale(axes.up, middle("up"))));
    }
  }
  return {...camera, target, distance};
}

/* The directions of pixels, and the width of a pixel's cone per unit of distance. */
function raysOf(camera, width, height) {
  const axes = axesOf(camera);
  const tangent = Math.tan(halfFov);
  const pixel = 2 * tangent / height;
  return {
    eye: add(camera.target, scale(axes.forward, -camera.distance)),
    corner: add(add(axes.forward, scale(axes.up, tangent)), scale(axes.right, -0.5 * pixel * width)),
    across: scale(axes.right, pixel),
    down: scale(axes.up, -pixel),
    footprint: pixel
  };
}

/* The sun of a picture: above, to the right, and behind the camera. */
function sunOf(camera) {
  const axes = axesOf(camera);
  return normalize(add([0, 0.85, 0], add(scale(axes.right, 0.5), scale(axes.forward, -0.38))));
}

/* right, up: radians. */
function turn(camera, right, up) {
  return {...camera, yaw: camera.yaw - right, pitch: clamp(camera.pitch + up, -steepest, steepest)};
}

/* right, up: parts of the picture's height. */
function move(camera, right, up) {
  const axes = axesOf(camera);
  const height = 2 * Math.tan(halfFov) * camera.distance;
  return {...camera, target: add(camera.target, add(scale(axes.right, right * height), scale(axes.up, up * height)))};
}

function approach(camera, factor, cells) {
  return {...camera, distance: clamp(camera.distance * factor, 0.5, 16 * cells)};
}
