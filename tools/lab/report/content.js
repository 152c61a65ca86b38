/* SPDX-License-Identifier: MIT */
/* What the page shows: its sections, which charts are made from which table, and the colors of methods. */
"use strict";

/* A table without a section gets one at the end. group: a heading above the section. */
const sections = [
  {
    group: "Accuracy and run time",
    table: "e1-voxelization",
    heading: "E1: voxelization",
    lead: "Which voxels does a triangle touch? Rasterizers and float32 overlap tests give approximate answers. svocl " +
      "decides in integers, and every front end returns the same set."
  },
  {
    table: "e2-rays",
    heading: "E2: rays",
    lead: "Random rays rarely find the gaps of an intersection test. Rays aimed at vertices, at edges and along " +
      "surfaces do."
  },
  {
    table: "e3-attributes",
    heading: "E3: attributes",
    lead: "A voxel's color and normal represent all of the surface inside it. Running averages in 8 bits drift and " +
      "depend on the order of the samples; integer sums do not."
  },
  {
    table: "e4-detail",
    heading: "E4: level of detail",
    lead: "The error of a tree that stops at a depth: distance from voxel centers to the surface, surface area, and " +
      "enclosed volume."
  },
  {
    table: "e5-conditioning",
    heading: "E5: ill-conditioned meshes",
    lead: "Float32 methods fail on thin triangles, on coordinates far from the origin, and on large ratios of sizes."
  },
  {
    table: "e7-cones",
    heading: "E7: cones",
    lead: "Ambient occlusion and light after one bounce, gathered by cones from a tree's voxels, against paths " +
      "through the triangles. Exact rays are the alternative."
  },
  {
    table: "e7-alternatives",
    heading: "E7: cones or rays",
    lead: "How many exact rays or paths a point needs for the error of the cones, and what takes longer."
  },
  {
    table: "e7-directions",
    heading: "E7: few directions",
    lead: "The error of a set of cones if each of them were exact."
  },
  {
    table: "e7-equal",
    heading: "E7: kinds of light",
    lead: "Ambient occlusion, the sky's light, a source by way of one surface, of several, and lamps that are " +
      "surfaces, one by one: by cones and by rays, and how long rays take to err as much as the cones."
  },
  {
    table: "e7-light",
    heading: "E7: kinds of light, by every method",
    lead: "From one cone to 64, and from 16 paths a point to 1,024, against thousands of paths through the triangles."
  },
  {
    table: "e7-embree",
    heading: "E7: Embree",
    lead: "Rays in the same directions from the same points, by svocl and by Embree."
  },
  {
    table: "e8-probes",
    heading: "E8: probes",
    lead: "Rays through light field probes instead of the triangles: what they find, what they miss, and what they " +
      "cannot know, beside exact rays in the same rounds."
  },
  {
    table: "e8-choices",
    heading: "E8: which probes a ray tries",
    lead: "The field lists the probes that see each cell. The published choice takes the eight around the ray's origin."
  },
  {
    table: "e8-light",
    heading: "E8: light by probes",
    lead: "Light after one bounce by rays through probes and from prefiltered probes, beside cones and few paths."
  },
  {
    group: "Front ends and builders",
    table: "voxelize",
    heading: "Front ends",
    lead: "The same fragments from OpenCL alone and from OpenGL's rasterizer."
  },
  {
    table: "builders",
    heading: "Builders",
    lead: "The same octree, bit for bit: top-down (cl), bottom-up (sorted), and with OpenGL compute shaders " +
      "(gl-compute)."
  },
  {table: "share", heading: "Interop", lead: "The cost of moving OpenGL's fragment list to OpenCL."},
  {table: "filter", heading: "Attributes", lead: "Colors, normals, materials and fill under each weighting."},
  {
    table: "startup",
    heading: "Start-up",
    lead: "From the start of the process to its end, with cold and with warm driver caches."
  },
  {
    group: "Cost of each request",
    table: "e6-leaving-out",
    heading: "E6: needs",
    lead: "svocl omits every buffer, pass and kernel that a request does not use. The table shows what each costs."
  },
  {table: "scene-sizes", heading: "Scene sizes", lead: "From an empty mesh to a million triangles."},
  {
    table: "memory",
    heading: "Memory",
    lead: "Device memory of an occupancy-only octree, compared with methods that store every node or fragment."
  },
  {
    group: "Larger than memory, and in motion",
    table: "parts",
    heading: "Trees in parts",
    lead: "The same file from builds that may take a quarter, a sixteenth and a sixty-fourth of the memory."
  },
  {
    table: "parts-large",
    heading: "Trees larger than memory",
    lead: "A hundred million leaves and more, with a limit far below the size of the file."
  },
  {
    table: "parts-workers",
    heading: "Trees in parts: workers",
    lead: "Several workers build one tree, part by part. A model says how long more of them would take if none " +
      "disturbed another."
  },
  {
    table: "moving",
    heading: "Scenes that move",
    lead: "An update makes anew what moved and keeps the rest. Its tree is the one that a full build makes of the " +
      "same vertices."
  },
  {
    table: "moving-rays",
    heading: "Rays through scenes that move",
    lead: "After an update the BVHs of objects that moved are refit. A BVH of the whole mesh, made anew, has the " +
      "same hits."
  },
  {
    table: "moving-light",
    heading: "Light of scenes that move",
    lead: "Photons are shot again where something moved in their way; the others are kept. The light is the same as " +
      "one from nothing."
  },
  {
    table: "paged",
    heading: "Paged trees",
    lead: "Pictures of a file of which only a share is in memory. A stop of the camera is complete when a picture " +
      "misses nothing; then it is the picture of the whole tree."
  },
  {
    group: "Comparison with older systems",
    table: "thesis-2020",
    heading: "Octree building (thesis, 2020)",
    lead: "Similar scenes of the same size, next to the figures published in a master's thesis on an octree-building " +
      "library for the GPU."
  },
  {
    table: "thesis-2016",
    heading: "Voxel cone tracing (thesis, 2016)",
    lead: "The same grids and measures, next to the figures published in a master's thesis on voxel cone tracing."
  },
  {
    table: "light-stages",
    heading: "Light: stages (thesis, 2016)",
    lead: "Opacity, photons and their filtering in a tree, next to the figures of the same thesis."
  },
  {
    table: "light-bytes",
    heading: "Light: bytes",
    lead: "A tree stores light where there are nodes, a dense pyramid everywhere."
  },
  {
    table: "light-frames",
    heading: "Light: frames (thesis, 2016)",
    lead: "Five cones for each pixel, next to the figures of the same thesis."
  },
  {
    group: "Comparison with other libraries",
    table: "rays",
    heading: "Ray tracing: Embree",
    lead: "The same rays against the same triangles."
  },
  {
    table: "ray-calls",
    heading: "Ray tracing: Embree, call by call",
    lead: "Packets of 1, 8 and 16 rays, and Embree's other builds. Below a ratio of 1 Embree leads."
  },
  {
    table: "peer-embree",
    heading: "Build time and memory: Embree",
    lead: "The octree with its BVH, and Embree's BVH, of the same triangles."
  },
  {
    table: "peer-openvdb",
    heading: "Volumes: OpenVDB",
    lead: "The octree and an OpenVDB grid of the same resolution."
  },
  {
    table: "solid",
    heading: "Solids: OpenVDB",
    lead: "What is inside of closed meshes, and OpenVDB's level set of the same triangles. Both are compared with an " +
      "exact reference."
  }
];

const absence = {
  file: "The file of results has no such table.",
  run: "This program or machine cannot measure it."
};

const origins = {
  file: "The results were measured earlier and read from a file.",
  quick: "A quick run, with smaller scenes and fewer repetitions than the full run.",
  full: "The full run."
};

// What charts of probes by time have in common.
const lightErrors = {
  table: "e7-light",
  panels: "scene",
  curves: "method",
  x: "time",
  ys: ["RMSE"],
  xLabel: "time, µs a point",
  yLabel: "error, RMSE",
  front: "all"
};

const probeErrors = {
  table: "e8-probes",
  panels: "rays",
  curves: "method",
  x: "time",
  ys: ["wrong"],
  xLabel: "time, ns per ray",
  yLabel: "wrong hits and misses, %",
  front: "all"
};

/*
 * A figure has one panel for each text in its panel column, and all panels share their axes.
 *   table, name: where the values come from; the charts' ids begin with the name
 *   only: [column, text]: rows with that text; most: rows with that column's largest number
 *   without: curves whose names begin so are left out
 *   curves: the column that names the curve or, without x, the bar; none: each of ys is a curve
 *   front: "all": the Pareto front of points with equal `size`; "each": one per curve
 *   apart: each of ys has panels of its own
 */
const figures = [
  {
    table: "e1-voxelization",
    name: "e1",
    caption: "Wrong voxels against time. Each point is one grid, with half the voxel size of the one before. Rings " +
      "mark the Pareto front of each grid.",
    panels: "scene",
    curves: "method",
    x: "time",
    ys: ["error"],
    xLabel: "time, ms",
    yLabel: "false negatives and positives, %",
    front: "all",
    size: "grid edge"
  },
  {
    table: "e2-rays",
    name: "e2",
    caption: "Wrong rays against time. Each point is one mesh; rings mark its Pareto front. Voxels alone report no " +
      "triangle and appear in the next figure only.",
    without: "voxels alone",
    panels: "rays",
    curves: "method",
    x: "time",
    ys: ["error"],
    xLabel: "time, ns per ray",
    yLabel: "missed and wrong rays, %",
    front: "all",
    size: "triangles"
  },
  {
    table: "e2-rays",
    name: "e2t",
    caption: "Mean relative error of t over rays with a correct hit.",
    panels: "rays",
    curves: "method",
    x: "time",
    ys: ["error of t, mean"],
    xLabel: "time, ns per ray",
    yLabel: "|t − exact| / exact, mean",
    front: "all",
    size: "triangles"
  },
  {
    table: "e3-attributes",
    name: "e3",
    caption: "Mean error of a voxel's attribute against time. Each point is one depth; rings mark its Pareto front.",
    panels: "attribute",
    curves: "method",
    x: "time",
    ys: ["error, mean"],
    xLabel: "time, ms",
    yLabel: "mean error",
    front: "all",
    size: "depth"
  },
  {
    table: "e3-attributes",
    name: "e3o",
    caption: "The largest difference between two orders of the same samples.",
    panels: "attribute",
    curves: "method",
    x: "time",
    ys: ["order, largest"],
    xLabel: "time, ms",
    yLabel: "largest difference",
    front: "all",
    size: "depth"
  },
  {
    table: "e4-detail",
    name: "e4",
    caption: "Error of each depth against build time. Each point is one depth; rings mark the Pareto front of each " +
      "measure.",
    panels: "scene",
    x: "time",
    ys: ["distance of centers", "area by faces, error", "volume, error", "area by fill, error"],
    xLabel: "time, ms",
    yLabel: "error, %",
    front: "each"
  },
  {
    table: "e5-conditioning",
    name: "e5v",
    caption: "Voxelization as the condition of the triangles worsens: a method fails where its curve rises.",
    only: ["problem", "voxelization"],
    panels: "conditioning",
    curves: "method",
    x: "value",
    ys: ["error"],
    xLabel: "conditioning",
    yLabel: "false negatives and positives, %"
  },
  {
    table: "e5-conditioning",
    name: "e5r",
    caption: "Rays as the condition of the mesh worsens.",
    only: ["problem", "rays"],
    panels: "conditioning",
    curves: "method",
    x: "value",
    ys: ["error"],
    xLabel: "conditioning",
    yLabel: "missed and wrong rays, %"
  },
  {
    table: "e5-conditioning",
    name: "e5vt",
    caption: "Error of the same voxelizations against time. Rings mark the Pareto front of each mesh.",
    only: ["problem", "voxelization"],
    panels: "conditioning",
    curves: "method",
    x: "time",
    ys: ["error"],
    xLabel: "time, ms",
    yLabel: "false negatives and positives, %",
    front: "all",
    size: "value"
  },
  {
    table: "e5-conditioning",
    name: "e5rt",
    caption: "Error of the same rays against time. Rings mark the Pareto front of each mesh.",
    only: ["problem", "rays"],
    panels: "conditioning",
    curves: "method",
    x: "time",
    ys: ["error"],
    xLabel: "time, ms",
    yLabel: "missed and wrong rays, %",
    front: "all",
    size: "value"
  },
  {
    table: "e7-cones",
    name: "e7",
    caption: "Error of ambient occlusion against time. The points of \"cones\" have 1, 5, 6, 16 and 64 cones; those " +
      "of exact rays 1, 4, 16, 64 and 256 rays. Rings mark the Pareto front of each scene.",
    panels: "scene",
    curves: "method",
    x: "time",
    ys: ["AO, RMSE"],
    xLabel: "time, ms",
    yLabel: "error of ambient occlusion, RMSE",
    front: "all"
  },
  {
    table: "e7-cones",
    name: "e7l",
    caption: "Error of the irradiance after one bounce, relative to its mean, against time. Rings mark the Pareto " +
      "front of each scene.",
    panels: "scene",
    curves: "method",
    x: "time with light",
    ys: ["light, RMSE"],
    xLabel: "time, ms",
    yLabel: "error of irradiance, RMSE",
    front: "all"
  },
  {
    ...lightErrors,
    name: "e7a",
    caption: "Ambient occlusion: error against time. The points of \"cones\" have 1, 5, 6, 16 and 64 cones, those of " +
      "\"rays\" 16, 64, 256 and 1,024 paths. Rings mark the Pareto front of each scene.",
    only: ["light", "AO"]
  },
  {
    ...lightErrors,
    name: "e7s",
    caption: "The sky's light: error, relative to the mean irradiance, against time.",
    only: ["light", "skylight"]
  },
  {
    ...lightErrors,
    name: "e7b",
    caption: "A source and the sky after four bounces: error, relative to the mean irradiance, against time. Cones " +
      "have one bounce.",
    only: ["light", "four bounces"]
  },
  {
    ...probeErrors,
    name: "e8",
    caption: "Wrong hits and misses against time, in the atrium. The points of a curve are resolutions. Rings mark " +
      "the Pareto front of each kind of rays.",
    only: ["scene", "atrium"]
  },
  {
    table: "e8-probes",
    name: "e8u",
    caption: "Rays of which nothing is known, in the atrium, by the resolution of the probes.",
    only: ["scene", "atrium"],
    panels: "rays",
    curves: "method",
    x: "resolution",
    ys: ["unknown"],
    xLabel: "texels along a side",
    yLabel: "unknown, %"
  },
  {
    ...probeErrors,
    name: "e8c",
    caption: "Wrong hits and misses against time, in the Cornell box.",
    only: ["scene", "cornell"]
  },
  {
    table: "e8-light",
    name: "e8l",
    caption: "Error of the irradiance after one bounce, relative to its mean, against time. Rings mark the Pareto " +
      "front of each scene.",
    panels: "scene",
    curves: "method",
    x: "time",
    ys: ["RMSE"],
    xLabel: "time, ms",
    yLabel: "error of irradiance, RMSE",
    front: "all"
  },
  {
    table: "light-stages",
    name: "light",
    caption: "Time of each stage.",
    panels: "form",
    curves: "stage",
    x: "depth",
    ys: ["time"],
    xLabel: "depth",
    yLabel: "time, ms"
  },
  {
    table: "builders",
    name: "builders",
    caption: "Time per stage: subdividing nodes level by level, packing sorted leaf lists, filtering attributes from " +
      "the leaves to the root, and all stages from the fragment list to the finished tree.",
    panels: "scene",
    curves: "builder",
    x: "depth",
    ys: ["subdivide", "pack", "filter", "list to tree"],
    xLabel: "depth",
    apart: true
  },
  {
    table: "e6-leaving-out",
    name: "e6",
    caption: "For each request: time from the mesh to the finished tree, peak device memory, and the size of the tree.",
    panels: "scene",
    curves: "need",
    ys: ["build", "peak", "tree"],
    apart: true
  },
  {
    table: "memory",
    name: "memory",
    caption: "Device memory by depth.",
    x: "depth",
    ys: ["full octree", "list of 36 bytes", "fragment list", "peak", "tree"],
    xLabel: "depth",
    yLabel: "bytes"
  },
  {
    table: "parts",
    name: "parts",
    caption: "Time and peak memory of builds in one piece, and in parts with a limit that is a share of its buffers. " +
      "The peak includes the driver and all libraries.",
    panels: "scene",
    curves: "form",
    ys: ["build", "peak"],
    most: "depth",
    apart: true
  },
  {
    table: "parts-workers",
    name: "workers",
    caption: "From the mesh to the file of the whole tree, by workers of one thread each: what was measured, and the " +
      "model.",
    panels: "scene",
    x: "workers",
    ys: ["time", "model"],
    most: "depth",
    xLabel: "workers",
    yLabel: "time, ms"
  },
  {
    table: "moving",
    name: "moving",
    caption: "An update and a full build, by the share of the scene that moved.",
    panels: "scene",
    x: "changed",
    ys: ["update", "build"],
    most: "depth",
    xLabel: "changed, %",
    yLabel: "time, ms"
  },
  {
    table: "moving",
    name: "movings",
    caption: "Stages of an update. The first three cost what moved; the others run through the whole scene.",
    panels: "scene",
    x: "changed",
    ys: ["move", "voxelize", "weigh", "merge", "nodes", "payload"],
    most: "depth",
    xLabel: "changed, %",
    yLabel: "time, ms"
  },
  {
    table: "paged",
    name: "paged",
    caption: "A flight around the scene with room for a share of the file: stops with a complete picture, pages that " +
      "were missed, and what was read.",
    panels: "scene",
    curves: "room",
    ys: ["complete stops", "misses", "read"],
    most: "depth",
    apart: true
  }
];

/*
 * Color and marker of known methods. The colors are --method-NAME in page.css: Okabe and Ito, "Color Universal Design",
 * 2008. svocl's own methods are blue in every chart.
 */
const methodStyles = {
  "exact integers, cl": ["blue", "circle"],
  "exact integers, gl-expand": ["sky", "circle"],
  "exact integers, gl-hw": ["sky", "diamond"],
  "integers of 20 bits (as until 0.1)": ["blue", "square"],
  "float32 test, box-centered": ["green", "square"],
  "float32 test, world coordinates": ["orange", "diamond"],
  "expansion alone": ["purple", "up"],
  "4x multisampling": ["vermillion", "down"],
  "plain rasterization": ["gray", "square"],
  "svocl": ["blue", "circle"],
  "Möller-Trumbore, float32": ["vermillion", "down"],
  "watertight, float32": ["green", "square"],
  "Embree, fast": ["orange", "diamond"],
  "Embree, robust": ["purple", "up"],
  "voxels alone, coarse": ["gray", "circle"],
  "voxels alone, medium": ["gray", "diamond"],
  "voxels alone, fine": ["gray", "square"],
  "RGBA8 running average": ["vermillion", "down"],
  "float atomics": ["orange", "diamond"],
  "integers, uniform": ["sky", "square"],
  "integers, at the center": ["green", "up"],
  "integers, by area": ["blue", "circle"],
  "distance of centers": ["vermillion", "down"],
  "area by fill, error": ["blue", "circle"],
  "area by faces, error": ["orange", "diamond"],
  "volume, error": ["green", "square"],
  "cones": ["blue", "circle"],
  "cones, longer steps": ["blue", "square"],
  "cones, lower depths": ["blue", "diamond"],
  "cones, full opacity": ["sky", "circle"],
  "cones, bricks": ["sky", "square"],
  "cones, voxels": ["sky", "diamond"],
  "published march": ["vermillion", "down"],
  "exact rays, svocl": ["green", "up"],
  "paths, svocl": ["green", "up"],
  "exact rays, Embree": ["orange", "up"],
  "field, 2³": ["sky", "circle"],
  "field, 4³": ["blue", "circle"],
  "field, 8³": ["purple", "circle"],
  "other field, 4³": ["blue", "square"],
  "eight, 2³": ["orange", "down"],
  "eight, 4³": ["vermillion", "down"],
  "eight, 8³": ["gray", "down"],
  "exact rays": ["green", "up"],
  "paths": ["green", "up"],
  "rays through 2³ probes": ["sky", "circle"],
  "rays through 4³ probes": ["blue", "circle"],
  "rays through 8³ probes": ["purple", "circle"],
  "2³ prefiltered probes": ["sky", "square"],
  "4³ prefiltered probes": ["blue", "square"],
  "8³ prefiltered probes": ["purple", "square"],
  "cl": ["blue", "circle"],
  "sorted": ["green", "square"],
  "gl-compute": ["orange", "diamond"],
  "update": ["blue", "circle"],
  "build": ["orange", "diamond"],
  "time": ["blue", "circle"],
  "model": ["gray", "square"]
};

const colorOrder = ["blue", "sky", "green", "orange", "vermillion", "purple", "yellow", "gray"];
const markerOrder = ["circle", "square", "up", "diamond", "down"];

/* Unknown methods get a style by their position among the curves. */
function styleOf(method, position) {
  const [color, marker] = Object.hasOwn(methodStyles, method) ? methodStyles[method]
    : [colorOrder[position % colorOrder.length], markerOrder[position % markerOrder.length]];
  return {color: `var(--method-${color})`, marker};
}
