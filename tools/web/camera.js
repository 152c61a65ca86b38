/* SPDX-License-Identifier: MIT */
/* A camera that turns around a target. Lengths are in cells of the grid; y is up. */
"use strict";

const halfFov = 0.28; /* radians; as svo_camera_frame has it, like the direction below and the margin */
const homeDirection = [0.406, 0.375, 0.833];
const frameMargin = 1.04;
const frameLevel = 7; /* SVO_FRAME_LEVEL_MAX */
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

/* The number of bits that are set below the one at index, 0 .. 127, of the four words that begin there. */
function countBitsBelow(words, begin, index) {
  let count = 0;
  for (let word = 0; word <= index >> 5; ++word) {
    let bits = words[begin + word] & (word < index >> 5 ? ~0 : (1 << (index & 31)) - 1);
    for (; bits !== 0; bits &= bits - 1) {
      ++count;
    }
  }
  return count;
}

/* How far the occupied cells of frameLevel reach along a direction, in cells of the page's level. Nodes that may reach
   farther than what was found are opened, the one ahead first. */
function reachOf({level, masks, directory}, along) {
  const ahead = along.reduce((octant, value, axis) => value > 0 ? octant | 1 << axis : octant, 0);
  const deepest = Math.min(level, frameLevel);
  let farthest = -Infinity;
  const visit = (node, depth, cell) => {
    const width = 2 ** (level - depth);
    const reach = dot(along, cell.map((low, axis) => width * (low + (ahead >> axis & 1))));
    if (reach <= farthest) {
      return;
    }
    const mask = depth < deepest ? masks[node >> 2] >> 8 * (node & 3) & 255 : 0;
    if (mask === 0) {
      farthest = reach;
    }
    for (let k = 0; k < 8; ++k) {
      const octant = ahead ^ k;
      if ((mask >> octant & 1) !== 0) {
        const child = directory[node >> 4] + countBitsBelow(masks, node >> 4 << 2, 8 * (node & 15) + octant);
        visit(child, depth + 1, cell.map((low, axis) => 2 * low + (octant >> axis & 1)));
      }
    }
  };
  visit(0, 0, [0, 0, 0]);
  return farthest;
}

/* Frames the occupied cells of a tree as svo_camera_frame does: the farthest points along four directions place the
   eye. */
function frameTree(tree, aspect) {
  const direction = normalize(homeDirection);
  const camera = {yaw: Math.atan2(direction[0], direction[2]), pitch: Math.asin(direction[1])};
  const axes = axesOf(camera);
  const tangentUp = Math.tan(halfFov) / frameMargin;
  const back = scale(axes.forward, -1);
  const fit = (side, tangent) => {
    const [first, second] = [1, -1].map(sign => reachOf(tree, add(scale(side, sign), scale(back, tangent))));
    return {between: (first - second) / 2, depth: -(first + second) / (2 * tangent)};
  };
  const right = fit(axes.right, tangentUp * aspect);
  const up = fit(axes.up, tangentUp);
  const middle = (reachOf(tree, axes.forward) - reachOf(tree, back)) / 2;
  const across = add(scale(axes.right, right.between), scale(axes.up, up.between));
  return {...camera, target: add(across, scale(axes.forward, middle)), distance: middle - Math.min(right.depth, up.depth)};
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
