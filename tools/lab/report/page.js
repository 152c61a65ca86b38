/* SPDX-License-Identifier: MIT */
/* Makes the page from the results: facts, contents, pictures, sections with their charts and tables. */
"use strict";

const foldedRows = 24;
const figureSpace = "\u2007"; /* as wide as a digit */
const pointSpace = "\u2008"; /* as wide as a point */

function put(id, markup) {
  document.getElementById(id).insertAdjacentHTML("beforeend", joinMarkup(markup));
}

/* Letters and digits; anything else becomes '-'. The same as for the names of CSV files. */
function anchorOf(id) {
  return id.replace(/[^A-Za-z0-9]+/g, "-").replace(/^-|-$/g, "");
}

/* ---- tables ---- */

function countDecimals(text) {
  const point = text.indexOf(".");
  return point < 0 || text.includes("×") ? 0 : text.length - point - 1;
}

function describeColumn(table, index) {
  const values = table.rows.map(row => row[index]);
  const unit = chooseUnit(table.columns[index].unit, values);
  const numbers = values.filter(isNumber);
  return {
    index,
    unit,
    name: table.columns[index].name,
    number: numbers.length > 0,
    quartiles: hasQuartiles(table, index),
    hidden: (index > 0 && hasQuartiles(table, index - 1)) || (index > 1 && hasQuartiles(table, index - 2)),
    decimals: Math.max(0, ...numbers.map(number => countDecimals(formatNumber(number / unit.divisor))))
  };
}

function drawHead(column) {
  const unit = column.unit.name !== "" && html` <span class="unit">${column.unit.name}</span>`;
  return html`<th class="${column.number ? "n" : ""}"${column.quartiles && new Markup(' colspan="2"')}>${
    column.name}${unit}</th>`;
}

/* Blanks as wide as the decimals that other numbers of the column have align the points. */
function padNumber(text, decimals) {
  const own = countDecimals(text);
  const point = decimals > 0 && own === 0 ? pointSpace : "";
  return text.includes("×") ? text : text + point + figureSpace.repeat(decimals - own);
}

function drawCell(row, column, repeated) {
  const value = row[column.index];
  const text = isNumber(value) ? padNumber(formatNumber(value / column.unit.divisor), column.decimals) : value ?? "–";
  const kinds = [column.number && "n", repeated && "same"].filter(Boolean).join(" ");
  return html`<td class="${kinds}">${text}</td>`;
}

function drawQuartiles(row, column) {
  const [low, high] = row.slice(column.index + 1, column.index + 3);
  const format = number => formatNumber(number / column.unit.divisor);
  return html`<td class="q">${isNumber(low) && isNumber(high) && `${format(low)}–${format(high)}`}</td>`;
}

/* Leading cells that repeat those above are faint; a new value in the first column begins a group. */
function drawRow(row, above, columns) {
  const repeats = above === undefined ? 0 : row.findIndex((value, index) => value !== above[index]);
  const repeated = index => above !== undefined && (repeats < 0 || index < repeats);
  const cells = columns.filter(column => !column.hidden)
    .map(column => [drawCell(row, column, repeated(column.index)), column.quartiles && drawQuartiles(row, column)]);
  return html`<tr class="${above !== undefined && repeats === 0 ? "group" : ""}">${cells}</tr>`;
}

function drawTable(table) {
  const columns = table.columns.map((_, index) => describeColumn(table, index));
  const rows = table.rows.map((row, index) => drawRow(row, table.rows[index - 1], columns));
  const drawn = html`<div class="scroll"><table id="table-${anchorOf(table.id)}"><thead><tr>${
    columns.filter(column => !column.hidden).map(drawHead)}</tr></thead><tbody>${rows}</tbody></table></div>`;
  return rows.length > foldedRows
    ? html`<details><summary>Table: ${rows.length} rows</summary>${drawn}</details>` : drawn;
}

/* ---- sections ---- */

/* As a sentence; what stands between backticks is code. */
function drawNote(note) {
  const end = note.endsWith(".") ? "" : ".";
  const parts = note.split("`").map((part, index) => index % 2 === 1 ? html`<code>${part}</code>` : part);
  return note !== "" && html`<p class="note">${parts}${end}</p>`;
}

function drawContent(table) {
  const charts = figures.filter(figure => figure.table === table.id).map(figure => drawFigure(figure, table));
  const values = table.rows.length > 0 ? drawTable(table) : html`<p class="missing">Nothing was measured.</p>`;
  return [charts, values, drawNote(table.note)];
}

function drawSection(section, table, why) {
  const content = table !== undefined ? drawContent(table) : html`<p class="missing">Missing. ${why}</p>`;
  const group = section.group !== undefined && html`<h2>${section.group}</h2>`;
  const lead = section.lead !== undefined && html`<p>${section.lead}</p>`;
  return html`${group}<section id="${anchorOf(section.table)}"><h3>${section.heading}</h3>${lead}${content}</section>`;
}

function drawContents(all, tables) {
  const starts = all.flatMap((section, index) => section.group !== undefined ? [index] : []);
  const groups = starts.map((start, index) => all.slice(start, starts[index + 1]));
  const link = section => html`<li><a href="#${anchorOf(section.table)}" class="${
    tables.has(section.table) ? "" : "absent"}">${section.heading}</a></li>`;
  const further = html`<div><h3>Further</h3><ul><li><a href="#pictures">Pictures</a></li><li><a href="#reading">How to
    read this page</a></li></ul></div>`;
  return [groups.map(group => html`<div><h3>${group[0].group}</h3><ul>${group.map(link)}</ul></div>`), further];
}

function drawMachine(machine) {
  const facts = [
    ["OpenCL device", machine.device], ["Driver", machine.driver], ["Platform", machine.platform],
    ["OpenGL renderer", machine.renderer], ["Processor", machine.processor],
    ["Clock", machine.clock], ["Memory", machine.memory], ["CPU threads", machine.cpu_threads],
    ["Instruction set", machine.instruction_set], ["svocl", machine.svocl],
    ["Date", machine.date]
  ];
  return facts.filter(([, text]) => text !== undefined && text !== "")
    .map(([name, text]) => html`<div><dt>${name}</dt><dd>${text}</dd></div>`);
}

function drawPicture(picture) {
  return html`<figure class="picture ${picture.name}"><img alt="${picture.caption}" width="${picture.width}" height="${
    picture.height}" src="${picture.source}"><figcaption>${picture.caption}</figcaption></figure>`;
}

/* Tables without a section of their own. */
function otherSections(tables) {
  const others = tables.filter(table => !sections.some(section => section.table === table.id));
  return others.map((table, index) =>
    ({group: index === 0 ? "Other tables" : undefined, table: table.id, heading: table.title}));
}

/* ---- behavior ---- */

/* A method in the legend that the pointer is on stands out in the charts of its figure. */
function highlight(event) {
  const item = event.target.closest?.(".legend li");
  document.querySelectorAll("g.faded").forEach(curve => curve.classList.remove("faded"));
  item?.closest("figure").querySelectorAll("g[data-curve]").forEach(curve =>
    curve.classList.toggle("faded", curve.dataset.curve !== item.dataset.curve));
}

function makePage({results, pictures, origin}) {
  const tables = new Map(results.tables.map(table => [table.id, table]));
  const all = [...sections, ...otherSections(results.tables)];
  const why = origin === "file" ? absence.file : absence.run;
  put("machine", drawMachine(results.machine));
  put("origin", origins[origin]);
  put("contents", drawContents(all, tables));
  document.querySelector(".pictures").innerHTML = joinMarkup(pictures.map(drawPicture));
  put("sections", all.map(section => drawSection(section, tables.get(section.table), why)));
  document.addEventListener("pointerover", highlight);
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach(folded => folded.open = true));
  if (location.hash !== "") {
    document.getElementById(location.hash.slice(1))?.scrollIntoView();
  }
}

const data = JSON.parse(document.getElementById("data").textContent);
if (data === null) {
  put("origin", "This is the template: it has no results.");
} else {
  makePage(data);
}
