/* SPDX-License-Identifier: MIT */
/*
 * Charts as SVG. An axis is logarithmic where its values span more than a decade; zero then has a line of its own
 * below the least other value.
 */
"use strict";

const chartWidth = 460;
const chartHeight = 300;
const frame = {left: 70, right: 450, top: 10, bottom: 250};
const barHeight = 20;
const letterWidth = 6.4; /* of 12 px text, generously */

/* Paths of about two units around 0,0. */
const markerPaths = {
  circle: "M-1 0a1 1 0 1 0 2 0a1 1 0 1 0-2 0z",
  square: "M-.9-.9h1.8v1.8h-1.8z",
  up: "M0-1.2L1.1.8H-1.1z",
  down: "M0 1.2L1.1-.8H-1.1z",
  diamond: "M0-1.3L1.3 0 0 1.3-1.3 0z"
};

/* ---- axes ---- */

/* Times are always logarithmic, depths never. */
function measureAxis(values, label) {
  const positive = values.filter(value => value > 0);
  const hasZero = positive.length < values.length;
  const least = positive.length > 0 ? Math.min(...positive) : 1;
  const most = positive.length > 0 ? Math.max(...positive) : 1;
  const logarithmic = label !== "depth" && (most > 10 * least || hasZero || label.startsWith("time"));
  const bottom = 10 ** Math.floor(Math.log10(least));
  return {least, most, hasZero, logarithmic, floor: hasZero ? bottom / 10 : bottom};
}

function labelPower(at, power) {
  if (power < -3 || power > 4) {
    const factor = Math.round(at / 10 ** power);
    return factor === 1 ? formatPower(power) : `${factor}×${formatPower(power)}`;
  }
  return power < 0 ? String(Number(at.toPrecision(2))) : formatNumber(at);
}

/* Powers of ten; over few decades two and five times these as well; over many every other one is labeled. */
function logTicks(low, high) {
  const decades = Math.log10(high / low);
  const last = Math.ceil(Math.log10(high));
  const ticks = [];
  for (let power = Math.floor(Math.log10(low)); power <= last; ++power) {
    for (let digit = 1; digit <= 9; ++digit) {
      const at = digit * 10 ** power;
      const major = digit === 1 || (decades < 2.2 && (digit === 2 || digit === 5));
      if (at >= low * 0.999 && at <= high * 1.001 && (major || decades < 5)) {
        const labeled = major && (decades <= 7.5 || (last - power) % 2 === 0);
        ticks.push({at, major, label: labeled ? labelPower(at, power) : ""});
      }
    }
  }
  return ticks;
}

/* Multiples of 1, 2 or 5 times a power of ten, about five of them. */
function linearTicks(low, high) {
  const raw = (high - low) / 5;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5].find(factor => factor * power >= raw) ?? 10);
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high * 1.0001; ++i) {
    ticks.push({at: i * step, major: true, label: String(Number((i * step).toPrecision(6)))});
  }
  return ticks;
}

function logScale(axis, isY, start, end) {
  const low = !isY ? axis.least / 1.4 : axis.hasZero ? axis.floor * 0.7 : axis.floor;
  const high = isY ? 10 ** Math.ceil(Math.log10(axis.most * 1.05)) : axis.most * 1.4;
  const span = Math.log(high / low);
  const zero = isY && axis.hasZero ? [{at: 0, major: true, zero: true, label: "0"}] : [];
  return {
    place: value => start + (end - start) * Math.log(Math.max(value, axis.floor) / low) / span,
    ticks: [...zero, ...logTicks(zero.length > 0 ? axis.floor * 5 : low, high)]
  };
}

function linearScale(axis, isY, start, end) {
  const low = isY ? 0 : axis.least - 0.3;
  const high = isY ? axis.most * 1.1 : axis.most + 0.3;
  const ticks = linearTicks(low, high).filter(tick => isY || Number.isInteger(tick.at));
  return {place: value => start + (end - start) * (value - low) / (high - low), ticks};
}

function makeScale(axis, isY) {
  const [start, end] = isY ? [frame.bottom, frame.top] : [frame.left, frame.right];
  return (axis.logarithmic ? logScale : linearScale)(axis, isY, start, end);
}

function round(number) {
  return Math.round(number * 100) / 100;
}

function drawXAxis(scale, label) {
  const ticks = scale.ticks.map(tick => {
    const x = round(scale.place(tick.at));
    return [
      tick.major && html`<path class="grid" d="M${x} ${frame.top}V${frame.bottom}"/>`,
      html`<path class="axis" d="M${x} ${frame.bottom}v${tick.major ? 5 : 3}"/>`,
      tick.label !== "" && html`<text x="${x}" y="${frame.bottom + 19}" text-anchor="middle">${tick.label}</text>`
    ];
  });
  const middle = (frame.left + frame.right) / 2;
  return html`<g>${ticks}<path class="axis" d="M${frame.left} ${frame.bottom}H${frame.right}"/><text class="label"
    x="${middle}" y="${frame.bottom + 42}" text-anchor="middle">${label}</text></g>`;
}

function drawYAxis(scale, label) {
  const middle = (frame.top + frame.bottom) / 2;
  const ticks = scale.ticks.map(tick => {
    const y = round(scale.place(tick.at));
    return [
      tick.major && html`<path class="grid${tick.zero ? " zero" : ""}" d="M${frame.left} ${y}H${frame.right}"/>`,
      html`<path class="axis" d="M${frame.left} ${y}h${tick.major ? -5 : -3}"/>`,
      tick.label !== "" && html`<text x="${frame.left - 9}" y="${y + 4}" text-anchor="end">${tick.label}</text>`
    ];
  });
  return html`<g>${ticks}<path class="axis" d="M${frame.left} ${frame.top}V${frame.bottom}"/><text class="label"
    transform="rotate(-90)" x="${-middle}" y="13" text-anchor="middle">${label}</text></g>`;
}

/* ---- points and curves ---- */

/* On the front: no other point is at most as large in both coordinates and smaller in one. */
function isOnFront(points, mine, front) {
  return !points.some(other =>
    (front === "each" ? other.curve === mine.curve : other.size === mine.size) && other.x <= mine.x &&
    other.y <= mine.y && (other.x < mine.x || other.y < mine.y));
}

function drawMarker(x, y, style, size, title) {
  return html`<path d="${markerPaths[style.marker]}" transform="translate(${round(x)} ${round(y)}) scale(${size})"
    fill="${style.color}">${title}</path>`;
}

function drawCurve(figure, points, name, style, x, y) {
  const own = points.filter(point => point.curve === name);
  const at = own.map(point => [x.place(point.x), y.place(point.y)]);
  const line = at.map(([px, py]) => `${round(px)} ${round(py)}`).join("L");
  const marks = own.map((point, index) => {
    const [px, py] = at[index];
    const title = html`<title>${name}: ${figure.xLabel} ${formatNumber(point.x)}, ${figure.yLabel} ${
      formatNumber(point.y)}${point.hint !== undefined && `\n${point.hint}`}</title>`;
    return [
      point.low !== null && html`<path class="spread" stroke="${style.color}" d="M${round(px)} ${
        round(y.place(point.low))}V${round(y.place(point.high))}"/>`,
      drawMarker(px, py, style, 3.6, title)
    ];
  });
  return own.length > 0 &&
    html`<g data-curve="${name}">${!figure.scattered && html`<path class="curve" stroke="${style.color}"
      d="M${line}"/>`}${marks}</g>`;
}

function drawRings(figure, points, x, y) {
  return points.filter(point => figure.front !== undefined && isOnFront(points, point, figure.front))
    .map(point => html`<circle class="ring" cx="${round(x.place(point.x))}" cy="${round(y.place(point.y))}" r="6.5"/>`);
}

function wrapChart(id, label, height, content) {
  return html`<svg class="chart" id="${id}" role="img" viewBox="0 0 ${chartWidth} ${height}" aria-label="${label}">${
    content}</svg>`;
}

/* all: the points of the whole figure, for axes and styles. The first curve lies above the others. */
function drawCurves(figure, points, all, id, label) {
  const x = makeScale(measureAxis(all.map(point => point.x), figure.xLabel), false);
  const y = makeScale(measureAxis(all.map(point => point.y), figure.yLabel), true);
  const curves = curveNames(all).map((name, index) => drawCurve(figure, points, name, styleOf(name, index), x, y))
    .reverse();
  return wrapChart(id, label, chartHeight,
    [drawXAxis(x, figure.xLabel), drawYAxis(y, figure.yLabel), curves, drawRings(figure, points, x, y)]);
}

function curveNames(points) {
  return [...new Set(points.map(point => point.curve))];
}

function drawLegend(points) {
  const items = curveNames(points).map((name, index) => {
    const style = styleOf(name, index);
    return html`<li data-curve="${name}"><svg class="key" viewBox="-16 -8 32 16" aria-hidden="true"><path class="curve"
      d="M-15 0H15" stroke="${style.color}"/>${drawMarker(0, 0, style, 4)}</svg>${name}</li>`;
  });
  return html`<ul class="legend">${items}</ul>`;
}

/* "time, ms"; counts have no unit. */
function labelOf(name, unit) {
  return unit !== "" ? `${name}, ${unit}` : name;
}

/* ---- bars ---- */

function drawBar(point, index, left, scale, unit) {
  const y = index * barHeight + 6;
  const end = left + point.y * scale;
  const middle = y + barHeight / 2 - 2;
  const most = point.low !== null ? left + point.high * scale : end;
  return html`<g><text x="${left - 8}" y="${middle + 4}" text-anchor="end">${point.curve}</text><rect x="${left}"
    y="${y}" width="${round(end - left)}" height="${barHeight - 4}" fill="var(--method-blue)"><title>${point.curve}: ${
    formatNumber(point.y / unit.divisor)} ${unit.name}</title></rect>${point.low !== null && html`<path class="whisker"
    d="M${round(left + point.low * scale)} ${middle - 4}v8m0 -4H${round(most)}m0 -4v8"/>`}<text x="${round(most + 6)}"
    y="${middle + 4}">${formatNumber(point.y / unit.divisor)}</text></g>`;
}

function drawBars(figure, points, all, id, label) {
  const unit = chooseUnit(figure.unit, all.map(point => point.y));
  const left = 20 + letterWidth * Math.max(...all.map(point => point.curve.length));
  const most = Math.max(...all.map(point => Math.max(point.y, point.high ?? 0))) || 1;
  const scale = (chartWidth - left - 66) / most;
  const bars = points.map((point, index) => drawBar(point, index, left, scale, unit));
  const height = points.length * barHeight + 34;
  return wrapChart(id, label, height, [
    bars, html`<path class="axis" d="M${left} 3V${height - 29}"/><text class="label" x="${left}" y="${height - 10}">${
      labelOf(figure.ys[0], unit.name)}</text>`
  ]);
}

/* ---- figures ---- */

function numberAt(row, column) {
  return isNumber(row[column]) ? row[column] : null;
}

/* The points of one row: one per y. A point that lacks a coordinate is left out. */
function pointsOfRow(figure, table, row) {
  const at = name => row[findColumn(table, name)];
  return figure.ys.flatMap(name => {
    const column = findColumn(table, name);
    const curve = figure.curves !== undefined ? at(figure.curves) : name;
    const x = figure.x !== undefined ? at(figure.x) : 0;
    if (!isNumber(x) || !isNumber(row[column]) || (figure.without !== undefined && curve.startsWith(figure.without))) {
      return [];
    }
    const ranged = hasQuartiles(table, column);
    const low = ranged ? numberAt(row, column + 1) : null;
    const high = low !== null ? numberAt(row, column + 2) : null;
    const size = figure.size !== undefined ? at(figure.size) : 0;
    const hint = figure.hint !== undefined ? at(figure.hint) : undefined;
    return [{curve, x, y: row[column], size, low: high !== null ? low : null, high, hint}];
  });
}

function drawPanel(figure, name, points, all, id) {
  const title = name !== "" && figure.title !== undefined ? `${name}: ${figure.title}` : name;
  const label = [title, figure.caption].filter(text => text !== "").join(". ");
  const draw = figure.x !== undefined ? drawCurves : drawBars;
  return html`<div class="panel">${title !== "" && html`<h4>${title}</h4>`}${points.length > 0
    ? draw(figure, points, all, id, label) : html`<p class="missing">Nothing was measured here.</p>`}</div>`;
}

/* Every panel on the same axes. */
function drawPanels(figure, table, rows) {
  const panelOf = row => figure.panels !== undefined ? String(row[findColumn(table, figure.panels)]) : "";
  const pointsOf = some => some.flatMap(row => pointsOfRow(figure, table, row));
  const all = pointsOf(rows);
  return [...new Set(rows.map(panelOf))].map((name, index) =>
    drawPanel(figure, name, pointsOf(rows.filter(row => panelOf(row) === name)), all, `${figure.name}_${index + 1}`));
}

/* The panels of one y after the other. */
function drawApart(figure, table, rows) {
  return figure.ys.map((name, index) => {
    const unit = table.columns[findColumn(table, name)].unit;
    const chartName = `${figure.name}_${index + 1}`;
    const one = {...figure, name: chartName, ys: [name], title: name, yLabel: labelOf(name, unit), unit};
    return drawPanels(one, table, rows);
  });
}

/* The rows that a figure shows. */
function selectRows(figure, table) {
  const rows = table.rows.filter(row =>
    figure.only === undefined || row[findColumn(table, figure.only[0])] === figure.only[1]);
  if (figure.most === undefined) {
    return rows;
  }
  const column = findColumn(table, figure.most);
  const most = Math.max(...rows.map(row => row[column]));
  return rows.filter(row => row[column] === most);
}

/* Nothing where the table lacks a column of the figure or has no rows. */
function drawFigure(figure, table) {
  const wanted = [figure.panels, figure.curves, figure.x, figure.size, figure.only?.[0], figure.most, ...figure.ys];
  const rows = selectRows(figure, table);
  if (rows.length === 0 || wanted.some(name => name !== undefined && findColumn(table, name) < 0)) {
    return null;
  }
  const points = rows.flatMap(row => pointsOfRow(figure, table, row));
  return html`<figure>${figure.x !== undefined && drawLegend(points)}<div class="panels">${figure.apart
    ? drawApart(figure, table, rows) : drawPanels(figure, table, rows)}</div><figcaption>${
    figure.caption}</figcaption></figure>`;
}
