/* SPDX-License-Identifier: MIT */
/* The data of the page: base64 and gzip to the arrays that shaders read. tools/web/pack.h has their layout. */
"use strict";

const lettersAtOnce = 1 << 20; /* of base64; a multiple of 4 */

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

async function feed(letters, writable) {
  const writer = writable.getWriter();
  for (let at = 0; at < letters.length; at += lettersAtOnce) {
    await writer.write(decodeLetters(letters.slice(at, at + lettersAtOnce)));
  }
  await writer.close();
}

async function drain(readable, bytes) {
  const reader = readable.getReader();
  let used = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    if (part.value.length > bytes.length - used) {
      throw new Refusal("The data of this page are damaged: they are too long.");
    }
    bytes.set(part.value, used);
    used += part.value.length;
  }
  if (used < bytes.length) {
    throw new Refusal("The data of this page are damaged: they are too short. Was it saved whole?");
  }
}

function allocate(byteCount) {
  try {
    return new Uint8Array(byteCount);
  } catch {
    throw new Refusal(`This browser has no room for ${formatBytes(byteCount)} of nodes.`);
  }
}

/* letters: base64 of a gzip stream. */
async function unpackData(tree, letters) {
  if (typeof DecompressionStream === "undefined") {
    throw new Refusal("This browser has no DecompressionStream, which unpacks the nodes. Newer ones have it.");
  }
  const bytes = allocate(tree.bytes);
  const stream = new DecompressionStream("gzip");
  try {
    await Promise.all([feed(letters, stream.writable), drain(stream.readable, bytes)]);
  } catch (error) {
    throw error instanceof Refusal ? error : new Refusal(`The data of this page are damaged (${error.message}).`);
  }
  return bytes;
}

/* The arrays that follow each other in the data; null where the tree has none. */
function splitData(tree, bytes) {
  let at = 0;
  const next = (Kind, count) => {
    const array = count > 0 ? new Kind(bytes.buffer, at, count) : null;
    at += count * Kind.BYTES_PER_ELEMENT;
    return array;
  };
  return {
    masks: next(Uint32Array, 4 * tree.directory),
    directory: next(Uint32Array, tree.directory),
    colors: next(Uint8Array, 4 * (tree.colors?.count ?? 0)),
    normals: next(Uint8Array, 2 * (tree.normals?.count ?? 0))
  };
}

/* ---- figures ---- */

function formatCount(count) {
  return count.toLocaleString("en");
}

function formatBytes(bytes) {
  return bytes < 1 << 20 ? `${(bytes / 1024).toFixed(1)} KiB` : `${(bytes / (1 << 20)).toFixed(1)} MiB`;
}
