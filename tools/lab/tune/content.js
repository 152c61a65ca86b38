/* SPDX-License-Identifier: MIT */
/* What the page of `svocl tune` shows: the answer, fronts of time, memory and errors, tables. */
"use strict";

const sections = [
  {
    group: "Settings",
    table: "tune",
    heading: "Time, memory and error",
    lead: "Every setting that was measured. Those that left early have fewer rounds and sample points."
  },
  {
    group: "Measurements",
    table: "tune-errors",
    heading: "All measures",
    lead: "Each measure of each setting, with its interval. Settings are numbered as in the table above, from 0."
  },
  {table: "tune-rounds", heading: "Rounds", lead: "The raw times."}
];

const absence = {file: "It was not measured.", run: "It was not measured."};

const origins = {
  exhaustive: "All settings were measured to the end.",
  halving: "Settings that cannot win left early (successive halving)."
};

/* Measures with a chart, where they were measured. */
const charted = [
  ["voxel-rms-units", "voxel centers to the surface, RMS, units"],
  ["surface-rms-units", "surface to voxel centers, RMS, units"],
  ["face-max-units", "faces to the surface, largest, units"],
  ["area", "area by faces, error, %"],
  ["volume", "volume, error, %"],
  ["color", "color, linear light, RMS"],
  ["delta-e", "color, CIEDE2000, mean"],
  ["normal", "normal, mean, degrees"],
  ["depth-rms-units", "rays to voxels, RMS, units"],
  ["silhouette", "silhouette, % of rays"],
  ["triangle", "other triangles, % of rays"],
  ["ao", "ambient occlusion, RMSE"],
  ["light", "light, RMSE, of the mean"],
  ["direct", "direct light, RMSE, of the mean"]
];

const data0 = JSON.parse(document.getElementById("data").textContent);
const tune0 = data0?.results.tables.find(table => table.id === "tune");

/* The column whose values name the curves: how light is gathered, else coverage, of what varies. */
const curvesOf = ["gather", "coverage", "weights", "builder", "form"].find(name => {
  const at = tune0?.columns.findIndex(column => column.name === name) ?? -1;
  return at >= 0 && new Set(tune0.rows.map(row => row[at])).size > 1;
}) ?? "standing";

function frontOf([measure, label], x, xLabel) {
  return {
    table: "tune",
    name: `${measure}-${x}`,
    caption: `${label[0].toUpperCase()}${label.slice(1)}, against ${x}.`,
    curves: curvesOf,
    x,
    ys: [measure],
    xLabel,
    yLabel: label,
    front: "all",
    hint: "command",
    scattered: true
  };
}

const figures = [
  ...charted.map(one => frontOf(one, "time", "time, ms")),
  frontOf(charted[0], "memory", "memory, bytes"),
  {...frontOf(["memory", "memory, bytes"], "time", "time, ms"), caption: "Memory against time."}
];

const colorOrder = ["blue", "orange", "green", "vermillion", "purple", "sky", "yellow", "gray"];
const markerOrder = ["circle", "square", "up", "diamond", "down"];

function styleOf(method, position) {
  return {color: `var(--method-${colorOrder[position % colorOrder.length]})`,
          marker: markerOrder[position % markerOrder.length]};
}

function sentenceOf(note) {
  return note === "" ? "" : `<p class="note">${escapeText(note[0].toUpperCase() + note.slice(1))}.</p>`;
}

function showAnswer({input, answer}) {
  const percent = share => `${Math.round(100 * share)} %`;
  const varied = answer.varied ? ` (${escapeText(answer.varied)})` : "";
  document.getElementById("input").append(input);
  document.getElementById("answer").innerHTML = `<p class="lead">${escapeText(answer.asked)}</p>` +
    (answer.command === undefined ? "" :
      `<p><code>${escapeText(answer.command)}</code></p><p><code>${escapeText(answer.c)}</code></p>` +
      sentenceOf(answer.note) +
      `<p class="note">It wins in ${percent(answer.sure)} of resampled sweeps and is within 5 % of the winner in ` +
      `${percent(answer.near)}.` +
      (answer.second === undefined ? "" : ` Second: <code>${escapeText(answer.second)}</code>${varied}`) + "</p>");
}

if (data0 !== null) {
  showAnswer(data0);
}
