/* SPDX-License-Identifier: MIT */
/* The tree on the graphics device: textures, programs, pictures in passes, and what single rays find. */
"use strict";

const textureEdge = 2048; /* WebGL2 guarantees it, and 256 layers */
const rowsAtOnce = 256;

/* The texture of each array, in the order of texture units; parts: elements of the array in a texel. */
const layouts = {
  masks: {internal: "RGBA32UI", format: "RGBA_INTEGER", type: "UNSIGNED_INT", parts: 4},
  directory: {internal: "R32UI", format: "RED_INTEGER", type: "UNSIGNED_INT", parts: 1},
  colors: {internal: "RGBA8", format: "RGBA", type: "UNSIGNED_BYTE", parts: 4},
  normals: {internal: "RG8", format: "RG", type: "UNSIGNED_BYTE", parts: 2},
  light: {internal: "RGBA8", format: "RGBA", type: "UNSIGNED_BYTE", parts: 4}
};

const screenShader = `#version 300 es
void main() { /* one triangle over the screen */
  gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1);
}`;

function makeContext(canvas) {
  const gl = canvas.getContext("webgl2", {alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true});
  if (gl === null) {
    throw new Refusal("This browser has no WebGL2, with which the picture is drawn. Is hardware acceleration off?");
  }
  return gl;
}

/* ---- textures ---- */

/* Fills texels of the bound texture, from the texel first on: a part of a row, rows, a part of a row. */
function fillTexture(gl, layout, array, first) {
  const texels = array.length / layout.parts;
  for (let done = 0; done < texels;) {
    const x = (first + done) % textureEdge;
    const row = Math.floor((first + done) / textureEdge);
    const left = texels - done;
    const whole = x === 0 && left >= textureEdge;
    const rows = whole ? Math.min(Math.floor(left / textureEdge), rowsAtOnce, textureEdge - row % textureEdge) : 1;
    const columns = whole ? textureEdge : Math.min(left, textureEdge - x);
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, x, row % textureEdge, Math.floor(row / textureEdge), columns, rows, 1,
      gl[layout.format], gl[layout.type], array, done * layout.parts);
    done += rows * columns;
  }
}

function makeTexture(gl, unit, layout, texels) {
  const rows = Math.max(1, Math.ceil(texels / textureEdge));
  const layers = Math.ceil(rows / textureEdge);
  if (layers > gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS)) {
    throw new Refusal("The tree has more nodes than textures of this graphics device hold.");
  }
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, gl.createTexture());
  gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl[layout.internal], textureEdge, Math.min(rows, textureEdge), layers);
  if (gl.getError() !== gl.NO_ERROR) {
    throw new Refusal("The graphics device has no room for the nodes of the tree.");
  }
}

/* ---- programs ---- */

function compile(gl, type, source) {
  const shader = gl.createShader(type);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return shader;
}

/* parts: names of shader elements, whose texts follow each other. */
function makeProgram(gl, parts) {
  const texts = parts.map(name => document.getElementById(name).textContent);
  const program = gl.createProgram();
  const vertex = compile(gl, gl.VERTEX_SHADER, screenShader);
  const fragment = compile(gl, gl.FRAGMENT_SHADER, "#version 300 es\n" + texts.join("\n"));
  gl.attachShader(program, vertex);
  gl.attachShader(program, fragment);
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    const log = [gl.getShaderInfoLog(vertex), gl.getShaderInfoLog(fragment), gl.getProgramInfoLog(program)];
    throw new Refusal(`The graphics device does not compile the shaders: ${log.filter(Boolean).join(" ")}`);
  }
  gl.useProgram(program);
  const uniforms = new Map();
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
    const {name, type} = gl.getActiveUniform(program, i);
    uniforms.set(name.replace("[0]", ""), {type, location: gl.getUniformLocation(program, name)});
  }
  return {program, uniforms};
}

/* Sets those of the values that the program has. */
function setUniforms(gl, {program, uniforms}, values) {
  gl.useProgram(program);
  for (const [name, value] of Object.entries(values)) {
    const uniform = uniforms.get(name);
    switch (uniform?.type) {
      case undefined: break;
      case gl.FLOAT: gl.uniform1f(uniform.location, value); break;
      case gl.FLOAT_VEC2: gl.uniform2fv(uniform.location, value); break;
      case gl.FLOAT_VEC3: gl.uniform3fv(uniform.location, value); break;
      case gl.FLOAT_VEC4: gl.uniform4fv(uniform.location, value); break; /* an array of them */
      case gl.INT_VEC2: gl.uniform2iv(uniform.location, value); break;
      case gl.UNSIGNED_INT_VEC2: gl.uniform2uiv(uniform.location, value); break;
      default: gl.uniform1i(uniform.location, value); /* numbers, and units of textures */
    }
  }
}

/* The elements of a payload: those before the first have none. */
function rangeOf(payload) {
  return payload !== null ? [payload.first, payload.stride] : [0xffffffff, 0];
}

/* The sources of a lit page, for lengths in cells. */
function sourceUniforms(tree) {
  const cells = point => [0, 1, 2].map(axis => (point[axis] - tree.origin[axis]) / tree.edge);
  const isFar = ({kind}) => kind === 0;
  const pack = row => (tree.sources ?? []).flatMap(row);
  const unlimited = [-2, -1.5]; /* cosines, of points, which no angle ends */
  return tree.light === null ? {} : {
    lightLevel: tree.lightLevel,
    exposure: tree.exposure,
    sky: tree.sky,
    sourceCount: tree.sources.length,
    sourcePlace: pack(source => [...cells(source.position), source.kind]),
    sourceDirection: pack(source => [...(isFar(source) || source.kind >= 2 ? normalize(source.direction) : [0, 0, 0]),
      source.kind === 2 ? Math.cos(source.outer) : unlimited[0]]),
    sourceValue: pack(source => [...scale(source.value, isFar(source) ? 1 : 1 / tree.edge ** 2),
      source.kind === 2 ? Math.cos(source.inner) : unlimited[1]])
  };
}

/* ---- targets ---- */

function makeTarget(gl, internals, width, height) {
  const framebuffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  const buffers = internals.map((internal, i) => {
    const buffer = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl[internal], width, height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.RENDERBUFFER, buffer);
    return buffer;
  });
  gl.drawBuffers(internals.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
  return {framebuffer, buffers, width, height};
}

function deleteTarget(gl, target) {
  gl.deleteFramebuffer(target.framebuffer);
  target.buffers.forEach(buffer => gl.deleteRenderbuffer(buffer));
}

/* ---- drawing ---- */

const stripMilliseconds = 50; /* what is drawn at once should take no longer */
const stripRaysLeast = 1 << 13; /* below, it is waiting that takes the time */
const stripRaysMost = 1 << 24;
const blocks = [1, 2, 3, 4, 6, 8, 12, 16];

/*
 * Draws pictures in passes: first in blocks of pixels as large as the device needs to answer at once, then pixel by
 * pixel, then, if shaded, with four rays a pixel. A pass is drawn strip by strip. The next strip waits for the one
 * before it, so that a slow device still answers; its time says how large the next may be. A pass is shown when it is
 * complete.
 */
class Drawing {
  /* A tree of no levels yet. */
  constructor(canvas, tree) {
    const gl = makeContext(canvas);
    this.gl = gl;
    this.canvas = canvas;
    const names = Object.keys(layouts);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const texels = countTexels(tree, tree.level);
    names.forEach((name, unit) => makeTexture(gl, unit, layouts[name], texels[name]));
    const sky = tree.skyMap ?? {width: 0, height: 0, texels: ""};
    makeTexture(gl, names.length, layouts.light, sky.width * sky.height);
    fillTexture(gl, layouts.light, decodeLetters(sky.texels), 0);
    const common = {
      ...Object.fromEntries(names.map((name, unit) => [name, unit])),
      skyMap: names.length,
      skySize: [sky.width, sky.height],
      depth: tree.level,
      colorRange: rangeOf(tree.colors),
      normalRange: rangeOf(tree.normals),
      occlusionRange: 2 ** tree.level / 14 + 2,
      up: normalize(tree.camera.up),
      ...sourceUniforms(tree)
    };
    this.picture = makeProgram(gl, ["nodes", "walk", "light", "picture-shader"]);
    this.prober = makeProgram(gl, ["nodes", "walk", "probe"]);
    setUniforms(gl, this.picture, common);
    setUniforms(gl, this.prober, common);
    this.target = null; /* of the pass */
    this.shown = null; /* the last complete pass, with its target */
    this.look = null; /* what the picture is asked to show: values of uniforms */
    this.stale = false; /* whether that changed since the pass began */
    this.pass = null;
    this.fence = null;
    this.stripRays = stripRaysLeast;
  }

  /* Takes the arrays that a level adds to those of the levels above it; first: the texels that these have. */
  fill(arrays, first) {
    const {gl} = this;
    Object.entries(layouts).forEach(([name, layout], unit) => {
      if (arrays[name].length > 0 && !gl.isContextLost()) {
        gl.activeTexture(gl.TEXTURE0 + unit);
        fillTexture(gl, layout, arrays[name], first[name]);
      }
    });
    if (gl.getError() === gl.OUT_OF_MEMORY) {
      throw new Refusal("The graphics device has no room for the nodes of the tree.");
    }
  }

  /* Asks for a picture of the canvas's present size. */
  show(look) {
    this.look = look;
    this.stale = true;
  }

  /* Goes on drawing; to be called for each frame of the browser. Returns whether there is more to do. */
  step(now) {
    if (this.fence !== null && !this.collect(now)) {
      return true;
    }
    /* The first pass is completed before the next picture begins, so that something moves. */
    if (this.stale && (this.pass === null || !this.pass.first)) {
      this.begin();
    }
    if (this.pass !== null) {
      this.drawStrip(now);
    }
    return this.pass !== null;
  }

  /* How much of the present pass is done: 0 to 1. */
  progress() {
    return this.pass === null ? 1 : this.pass.row / this.pass.rows;
  }

  begin() {
    const {width, height} = this.canvas;
    const block = blocks.find(edge => width * height / (edge * edge) <= 2 * this.stripRays) ?? blocks.at(-1);
    this.target = this.fitTarget(this.target, width, height);
    this.stale = false;
    setUniforms(this.gl, this.picture, {...this.look, pictureHeight: height});
    this.pass = this.makePass(block, 1, true);
  }

  fitTarget(target, width, height) {
    if (target !== null && target.width === width && target.height === height) {
      return target;
    }
    if (target !== null) {
      deleteTarget(this.gl, target);
    }
    return makeTarget(this.gl, ["RGBA8"], width, height);
  }

  makePass(block, samples, first) {
    const {width, height} = this.target;
    return {block, samples, first, row: 0, columns: Math.ceil(width / block), rows: Math.ceil(height / block)};
  }

  drawStrip(now) {
    const {gl, pass} = this;
    const raysPerRow = pass.columns * pass.samples ** 2;
    const height = Math.min(pass.rows - pass.row, Math.max(1, Math.floor(this.stripRays / raysPerRow)));
    setUniforms(gl, this.picture, {block: pass.block, samples: pass.samples});
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target.framebuffer);
    gl.viewport(0, 0, pass.columns, pass.rows);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, pass.row, pass.columns, height);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
    pass.row += height;
    const sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.fence = {sync, begun: now, rays: height * raysPerRow, whole: pass.row < pass.rows};
    gl.flush();
  }

  /* Returns false while a strip is not done. */
  collect(now) {
    const {gl, fence, pass} = this;
    if (gl.getSyncParameter(fence.sync, gl.SYNC_STATUS) !== gl.SIGNALED) {
      return false;
    }
    gl.deleteSync(fence.sync);
    this.fence = null;
    const fitting = fence.rays * clamp(stripMilliseconds / Math.max(now - fence.begun, 1), 0.25, 2);
    /* The last strip of a pass is short: it tells whether there is room for more, but not for less. */
    this.stripRays = clamp(fence.whole ? fitting : Math.max(fitting, this.stripRays), stripRaysLeast, stripRaysMost);
    if (pass.row === pass.rows) {
      const free = this.shown?.target ?? null;
      this.shown = {...pass, target: this.target};
      this.present();
      this.target = this.fitTarget(free, this.target.width, this.target.height);
      this.pass = this.nextPass(pass);
    }
    return true;
  }

  /* Views of single rays keep the values of one: a mean of levels is none. */
  nextPass(pass) {
    const finer = pass.block === 1 && pass.samples === 1 && [0, 5, 6].includes(this.look.view);
    return pass.block > 1 ? this.makePass(1, 1, false) : finer ? this.makePass(1, 2, false) : null;
  }

  /* The last complete pass on the canvas, whose size may have changed since. */
  present() {
    const {gl, canvas, shown} = this;
    if (shown === null) {
      return;
    }
    const across = canvas.width / shown.target.width;
    const upwards = canvas.height / shown.target.height;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, shown.target.framebuffer);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, shown.columns, shown.rows, 0, 0, Math.round(shown.columns * shown.block * across),
      Math.round(shown.rows * shown.block * upwards), gl.COLOR_BUFFER_BIT, gl.NEAREST);
  }

  /* What the rays of columns x rows pixels find, from the pixel first on and stride pixels apart: 8 numbers each, as
     probe.glsl writes them. */
  probe(look, first, stride, columns, rows) {
    const {gl} = this;
    const target = makeTarget(gl, ["RGBA32UI", "RGBA32UI"], columns, rows);
    const read = [0, 1].map(() => new Uint32Array(4 * columns * rows));
    setUniforms(gl, this.prober, {...look, first, stride});
    gl.viewport(0, 0, columns, rows);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    read.forEach((numbers, i) => {
      gl.readBuffer(gl.COLOR_ATTACHMENT0 + i);
      gl.readPixels(0, 0, columns, rows, gl.RGBA_INTEGER, gl.UNSIGNED_INT, numbers);
    });
    deleteTarget(gl, target);
    const distances = new Float32Array(read[1].buffer);
    return [...Array(columns * rows).keys()].map(i => ({
      node: read[0][4 * i],
      level: read[0][4 * i + 1],
      steps: read[0][4 * i + 2],
      met: read[0][4 * i + 3] !== 0,
      direction: [...distances.subarray(4 * i, 4 * i + 3)],
      distance: distances[4 * i + 3]
    }));
  }
}
