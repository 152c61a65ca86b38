/* SPDX-License-Identifier: MIT */
/* The data of the page: base64 and gzip to the arrays that shaders read, level by level, while they arrive.
   tools/web/pack.h has their layout. */
"use strict";

/* What the reader of the page is told, in words. */
class Refusal extends Error {}

function decodeLetters(letters) {
  const text = atob(letters);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) {
    bytes[i] = text.charCodeAt(i);
  }
  return bytes;
}

function allocate(byteCount) {
  try {
    return new Uint8Array(byteCount);
  } catch {
    throw new Refusal(`This browser has no room for ${formatBytes(byteCount)} of nodes.`);
  }
}

/* ---- levels ---- */

/* The texels of each texture that the nodes down to a level take; -1: none. */
function countTexels(tree, level) {
  const nodes = tree.nodes[level] ?? 0;
  const payload = range => {
    if (range === null || level < 1) {
      return 0;
    }
    return range.stride === 0 ? 1 : Math.max(Math.min(nodes, range.first + range.count) - range.first, 0);
  };
  const directory = Math.ceil((tree.nodes[level - 1] ?? 0) / 16);
  return {
    masks: directory,
    directory,
    colors: payload(tree.colors),
    normals: payload(tree.normals),
    light: 6 * payload(tree.light)
  };
}

const texelBytes = {masks: 16, directory: 4, colors: 4, normals: 2, light: 4};

/* The bytes of a level as arrays, in their order in the data. */
function splitLevel(tree, level, bytes) {
  const before = countTexels(tree, level - 1);
  const after = countTexels(tree, level);
  let at = 0;
  return Object.fromEntries(Object.entries(texelBytes).map(([name, each]) => {
    const from = at;
    at += each * (after[name] - before[name]);
    const part = bytes.slice(from, at);
    return [name, name === "masks" || name === "directory" ? new Uint32Array(part.buffer) : part];
  }));
}

function levelBytes(tree, level) {
  const before = countTexels(tree, level - 1);
  const after = countTexels(tree, level);
  return Object.entries(texelBytes).reduce((sum, [name, each]) => sum + each * (after[name] - before[name]), 0);
}

/* ---- arrival ---- */

/*
 * Takes blocks of the data as the parser of the page reaches them, and hands levels over as they are complete. The
 * blocks are one gzip stream, so they are decoded one after the other.
 */
class Arrival {
  constructor(tree) {
    if (typeof DecompressionStream === "undefined") {
      throw new Refusal("This browser has no DecompressionStream, which unpacks the nodes. Newer ones have it.");
    }
    const stream = new DecompressionStream("gzip");
    this.tree = tree;
    this.writer = stream.writable.getWriter();
    this.reader = stream.readable.getReader();
    this.part = new Uint8Array(0); /* what was unpacked and not taken yet */
    this.packed = 0; /* bytes that have come */
    this.cut = false; /* whether the file ended before the data */
    this.written = Promise.resolve();
  }

  /* How much has come: 0 to 1. */
  share() {
    return Math.min(this.packed / this.tree.packed, 1);
  }

  write(bytes) {
    this.written = this.written.then(() => this.writer.write(bytes()));
    this.written.catch(error => this.writer.abort(error)).catch(() => undefined); /* so the reader fails, too */
  }

  /* letters: base64 of a block. */
  take(letters) {
    this.packed += letters.length / 4 * 3 - (letters.endsWith("==") ? 2 : letters.endsWith("=") ? 1 : 0);
    this.write(() => decodeLetters(letters));
  }

  /* No block will follow. An empty one is written when all before it have been read, which an error would discard. */
  end() {
    this.cut = this.packed < this.tree.packed;
    this.write(() => new Uint8Array(0));
    this.written.then(() => this.writer.close()).catch(() => undefined);
  }

  /* Fills bytes with what comes next. */
  async readInto(bytes) {
    for (let used = 0; used < bytes.length;) {
      if (this.part.length === 0) {
        const {done, value} = await this.reader.read();
        if (done) {
          throw new Refusal("The data of this page are damaged: they are too short.");
        }
        this.part = value;
      }
      const fitting = this.part.subarray(0, bytes.length - used);
      bytes.set(fitting, used);
      used += fitting.length;
      this.part = this.part.subarray(fitting.length);
    }
  }

  /* show(level, arrays, first) gets each level when it is complete. Returns when all are, or the file is cut off. */
  async read(show) {
    const {tree} = this;
    try {
      for (let level = 1; level <= tree.level; ++level) {
        const bytes = allocate(levelBytes(tree, level));
        await this.readInto(bytes);
        show(level, splitLevel(tree, level, bytes), countTexels(tree, level - 1));
      }
      if (this.part.length > 0 || !(await this.reader.read()).done) {
        throw new Refusal("The data of this page are damaged: they are too long.");
      }
    } catch (error) {
      if (!this.cut) {
        throw error instanceof Refusal ? error : new Refusal(`The data of this page are damaged (${error.message}).`);
      }
    }
  }
}

/* ---- figures ---- */

function formatCount(count) {
  return count.toLocaleString("en");
}

function formatBytes(bytes) {
  return bytes < 1 << 20 ? `${(bytes / 1024).toFixed(1)} KiB` : `${(bytes / (1 << 20)).toFixed(1)} MiB`;
}
