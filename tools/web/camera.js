/* SPDX-License-Identifier: MIT */
/* A camera that turns around a target, or looks around. Lengths are in cells of the grid. Its frame is three axes, of
   which the second is up. */
"use strict";

const homeHalfFov = 0.28; /* radians; as svo_camera_frame has it, like the direction below and the margin */
const homeDirection = [0.406, 0.375, 0.833];
const frameMargin = 1.04;
const steepest = 1.55; /* radians above the horizon: short of the pole */

const add = (a, b) => a.map((value, axis) => value + b[axis]);
const scale = (a, factor) => a.map(value => value * factor);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const normalize = a => scale(a, 1 / Math.hypot(...a));
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

/* The axes of cameras for which a direction is up; x stays across where it can. */
function frameOf(direction) {
  const up = normalize(direction);
  const back = normalize(cross(Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 0, -1], up));
  return [cross(up, back), up, back];
}

const homeLens = {halfFov: homeHalfFov, frame: frameOf([0, 1, 0])};

/* How the page's camera sees: its angle of view, and what is up. */
function lensOf(tree) {
  return {halfFov: tree.camera.fov > 0 ? tree.camera.fov / 2 : homeHalfFov, frame: frameOf(tree.camera.up)};
}

function axesOf({yaw, pitch, frame}) {
  const blend = parts => parts.map((part, axis) => scale(frame[axis], part)).reduce(add);
  const level = Math.cos(pitch);
  const forward = blend([-level * Math.sin(yaw), -Math.sin(pitch), -level * Math.cos(yaw)]);
  const right = blend([Math.cos(yaw), 0, -Math.sin(yaw)]);
  return {forward, right, up: cross(right, forward)};
}

/* The angles of the direction back from the target to the eye. */
function anglesOf(back, frame) {
  const [right, up, behind] = frame.map(axis => dot(axis, normalize(back)));
  return {yaw: Math.atan2(right, behind), pitch: Math.asin(clamp(up, -1, 1))};
}

/* Frames a box as svo_camera_frame does: the least distance from which all corners are in view, and the target moved
   until they are centered. */
function frameBox(low, high, aspect, lens = homeLens) {
  const camera = {...lens, ...anglesOf(homeDirection.map((part, axis) => scale(lens.frame[axis], part)).reduce(add),
    lens.frame)};
  const axes = axesOf(camera);
  const tangentUp = Math.tan(lens.halfFov) / frameMargin;
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

/* The camera that the page was made with; null: none. */
function startOf(tree) {
  if (tree.camera.eye === undefined) {
    return null;
  }
  const lens = lensOf(tree);
  const cells = point => point.map((value, axis) => (value - tree.origin[axis]) / tree.edge);
  const [eye, target] = [cells(tree.camera.eye), cells(tree.camera.at)];
  const back = add(eye, scale(target, -1));
  return {...lens, ...anglesOf(back, lens.frame), target, distance: Math.hypot(...back)};
}

function eyeOf(camera) {
  return add(camera.target, scale(axesOf(camera).forward, -camera.distance));
}

/* The directions of pixels, and the width of a pixel's cone per unit of distance. */
function raysOf(camera, width, height) {
  const axes = axesOf(camera);
  const tangent = Math.tan(camera.halfFov);
  const pixel = 2 * tangent / height;
  return {
    eye: eyeOf(camera),
    corner: add(add(axes.forward, scale(axes.up, tangent)), scale(axes.right, -0.5 * pixel * width)),
    across: scale(axes.right, pixel),
    down: scale(axes.up, -pixel),
    footprint: pixel
  };
}

/* The sun of a picture: above, to the right, and behind the camera. */
function sunOf(camera) {
  const axes = axesOf(camera);
  return normalize(add(scale(camera.frame[1], 0.85), add(scale(axes.right, 0.5), scale(axes.forward, -0.38))));
}

/* right, up: radians. */
function turn(camera, right, up) {
  return {...camera, yaw: camera.yaw - right, pitch: clamp(camera.pitch + up, -steepest, steepest)};
}

/* right, up: parts of the picture's height. */
function move(camera, right, up) {
  const axes = axesOf(camera);
  const height = 2 * Math.tan(camera.halfFov) * camera.distance;
  return {...camera, target: add(camera.target, add(scale(axes.right, right * height), scale(axes.up, up * height)))};
}

function approach(camera, factor, cells) {
  return {...camera, distance: clamp(camera.distance * factor, 0.5, 16 * cells)};
}

/* Turns around the eye. right, up: radians. */
function lookAround(camera, right, up) {
  const looking = turn(camera, right, up);
  return {...looking, target: add(eyeOf(camera), scale(axesOf(looking).forward, camera.distance))};
}

/* way: to the right, up and forward. */
function fly(camera, way) {
  const axes = axesOf(camera);
  const moved = [axes.right, camera.frame[1], axes.forward].map((axis, i) => scale(axis, way[i])).reduce(add);
  return {...camera, target: add(camera.target, moved)};
}
