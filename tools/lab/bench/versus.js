/* SPDX-License-Identifier: MIT */
/* What the page of `svocl bench gl-vs-cl` shows. */
"use strict";

const sections = [
  {
    group: "The answer",
    table: "gl-vs-cl-methods",
    heading: "List, share and builder",
    lead: "Every combination at the center of the design."
  },
  {table: "gl-vs-cl-stages", heading: "Where the time is"},
  {table: "gl-vs-cl-effects", heading: "Which factor explains how much"},
  {
    group: "Factors",
    table: "gl-vs-cl-payload",
    heading: "Needs, weights and coverage"
  },
  {table: "gl-vs-cl-depth", heading: "Depth"},
  {table: "gl-vs-cl-scene", heading: "Scenes"},
  {
    group: "Beside a build",
    table: "gl-vs-cl-start",
    heading: "Starts and memory"
  },
  {table: "gl-vs-cl-clocks", heading: "Clocks"},
  {
    group: "Raw",
    table: "gl-vs-cl-series",
    heading: "Times by depth and scene"
  },
  {table: "gl-vs-cl-cells", heading: "Cells"},
  {table: "gl-vs-cl-rounds", heading: "Rounds"},
  {table: "gl-vs-cl-starts", heading: "Processes that build one tree"}
];

const absence = {rounds: "It was not measured."};

const origins = {rounds: "Rounds of all cells, interleaved, in several processes."};

const figures = [
  {
    table: "gl-vs-cl-stages",
    name: "wall",
    caption: "Wall time of a build at the center, with 95 % intervals.",
    curves: "method",
    ys: ["wall"],
    unit: "ms"
  },
  {
    table: "gl-vs-cl-effects",
    name: "effects",
    caption: "What each factor and pair explains of the times, of methods and payload at the center.",
    only: ["design", "methods and payload"],
    curves: "factor",
    ys: ["share"],
    unit: "%"
  },
  {
    table: "gl-vs-cl-series",
    name: "by-depth",
    caption: "By depth, the central scene.",
    only: ["central scene", "yes"],
    curves: "method",
    x: "depth",
    ys: ["wall"],
    xLabel: "depth",
    yLabel: "time, ms"
  },
  {
    table: "gl-vs-cl-series",
    name: "by-triangles",
    caption: "By triangles, the central depth.",
    only: ["central depth", "yes"],
    curves: "method",
    x: "triangles",
    ys: ["wall"],
    xLabel: "triangles",
    yLabel: "time, ms"
  }
];

const colorOrder = ["blue", "orange", "green", "vermillion", "purple", "sky", "yellow", "gray"];
const markerOrder = ["circle", "square", "up", "diamond", "down"];

function styleOf(method, position) {
  return {color: `var(--method-${colorOrder[position % colorOrder.length]})`,
          marker: markerOrder[position % markerOrder.length]};
}
