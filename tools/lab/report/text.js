/* SPDX-License-Identifier: MIT */
/* Markup that escapes what is put into it, numbers as people read them, and columns of tables. report/text.h has the
   same rules for numbers and units. */
"use strict";

class Markup {
  constructor(text) {
    this.text = text;
  }
}

function escapeText(text) {
  return String(text).replace(/[&<>"]/g, character => `&#${character.charCodeAt(0)};`);
}

function joinMarkup(value) {
  if (value instanceof Markup) {
    return value.text;
  }
  if (Array.isArray(value)) {
    return value.map(joinMarkup).join("");
  }
  return value === null || value === undefined || value === false ? "" : escapeText(value);
}

/* A tag for template literals: html`<p>${text}</p>` escapes the text. Markup and arrays of it stay as they are. */
function html(strings, ...values) {
  return new Markup(strings.reduce((all, part, index) => all + joinMarkup(values[index - 1]) + part));
}

/* "10⁻⁸" */
function formatPower(exponent) {
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const superscript = [...String(Math.abs(exponent))].map(digit => digits[digit]).join("");
  return `10${exponent < 0 ? "⁻" : ""}${superscript}`;
}

/* "2.2×10⁻⁸" */
function formatScientific(number) {
  const [mantissa, exponent] = number.toExponential(1).split("e");
  return `${mantissa}×${formatPower(Number(exponent))}`;
}

/* At least three significant digits; counts in full, with separators; powers of ten for very small and large ones. */
function formatNumber(number) {
  const size = Math.abs(number);
  if (size >= 1e15 || (size < 1e-3 && size > 0)) {
    return formatScientific(number);
  }
  if (size >= 1000 || (number >= 0 && Number.isInteger(number))) {
    return Math.round(number).toLocaleString("en-US");
  }
  return number.toFixed(2 - Math.floor(Math.log10(size)));
}

function isNumber(value) {
  return typeof value === "number";
}

/* Bytes are shown in the unit that suits the largest of them; other units stay. */
function chooseUnit(unit, values) {
  const most = Math.max(0, ...values.filter(isNumber));
  if (unit !== "B") {
    return {name: unit, divisor: 1};
  }
  return most >= 2 ** 20 ? {name: "MiB", divisor: 2 ** 20}
       : most >= 2 ** 13 ? {name: "KiB", divisor: 2 ** 10}
                         : {name: "bytes", divisor: 1};
}

/* ---- tables of results: {id, title, note, columns: [{name, unit}], rows: [[text, number or null]]} ---- */

function findColumn(table, name) {
  return table.columns.findIndex(column => column.name === name);
}

/* Whether the two columns after this one hold its quartiles, or an interval. */
function hasQuartiles(table, column) {
  const [{name}, low, high] = table.columns.slice(column, column + 3);
  return low !== undefined && high !== undefined && [["q1", "q3"], ["low", "high"]].some(([first, last]) =>
    low.name === `${name} ${first}` && high.name === `${name} ${last}`);
}
