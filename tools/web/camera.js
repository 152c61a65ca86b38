/* SPDX-License-Identifier: MIT */
/* A camera that turns around a target, or looks around. Lengths are in cells of the grid. Its frame is three axes, of
   which the second is up. */
"use strict";

const homeHalfFov = 0.28; /* radians; as svo_camera_fit has it, like the direction below and the margin */
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

/* The angles of the direction back from the target to the eye. */
function anglesOf(back, frame) {
  const [right, up, behind] = frame.map(axis => dot(axis, normalize(back)));
  return {yaw: Math.atan2(right, behind), pitch: Math.asin(clamp(up, -1, 1))};
}

/* How far the occupied cells of frameLevel, or of the last level that is known, reach along a direction, in cells of
   the page's level. Nodes that may reach farther than what was found are opened, the one ahead first. */
function reachOf({level, known, masks, directory}, along) {
  const ahead = along.reduce((octant, value, axis) => value > 0 ? octant | 1 << axis : octant, 0);
  const deepest = Math.min(known, frameLevel);
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

/* Frames the occupied cells of a tree as svo_camera_fit does: the farthest points along four directions place the
   eye. */
function frameTree(tree, aspect, lens = homeLens) {
  const camera = {...lens, ...anglesOf(homeDirection.map((part, axis) => scale(lens.frame[axis], part)).reduce(add),
    lens.frame)};
  const axes = axesOf(camera);
  const tangentUp = Math.tan(lens.halfFov) / frameMargin;
  const back = scale(axes.forward, -1);
  const fit = (side, tangent) => {
    const [first, second] = [1, -1].map(sign => reachOf(tree, add(scale(side, sign), scale(back, tangent))));
    return {between: (first - second) / 2, depth: -(first + second) / (2 * tangent)};
  };
  const right = fit(axes.right, tangentUp * aspect);
  const up = fit(axes.up, tangentUp);
  const middle = (reachOf(tree, axes.forward) - reachOf(tree, back)) / 2;
  const across = add(scale(axes.right, right.between), scale(axes.up, up.between));
  const distance = middle - Math.min(right.depth, up.depth);
  return {...camera, target: add(across, scale(axes.forward, middle)), distance};
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
