/* SPDX-License-Identifier: MIT */
/*
 * Procedural scenes: meshes for demonstrations, tests and benchmarks that need no download.
 *
 * A scene is a pure function of its name, the requested triangle count and the seed. It uses only integer arithmetic
 * and correctly rounded double operations, so the same request gives the same bytes on every machine and compiler.
 * Scenes have float positions, unit normals and RGBA8 colors per vertex and are indexed; y points up, +z to the viewer.
 *
 * Thread-safety: no state outside handles; any thread may use any function on handles of its own.
 */
#ifndef SVOCL_TOOLS_SCENES_SCENES_H
#define SVOCL_TOOLS_SCENES_SCENES_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "svocl/mesh.h"
#include "svocl/status.h"

#define SCENE_TRIANGLES_MAX 50000000u
#define SCENE_DEFAULT_SEED  1u

typedef struct scene scene;

typedef struct scene_description {
    const char *name;
    const char *summary; /* one line, without a full stop */
    uint32_t default_triangles;
} scene_description;

/* The scenes in display order; NULL for an index past the last. Static data. */
const scene_description *scene_describe(size_t index);

/*
 * Makes a scene.
 *
 * spec: NAME[:triangles[:seed]] with triangles 1 .. SCENE_TRIANGLES_MAX and seed 0 .. 2^32 - 1, both decimal.
 *       terrain, needles and dust have exactly the requested count; statue comes within two percent from 10,000 on and
 *       has at least some 600; knot is the nearest even product of sides and segments; atrium and cornell refine all
 *       their parts together and come close from their least detail on (17,000 and 94); cube is the nearest
 *       12 * n * n. mesh->triangle_count has the actual count.
 * message: receives one line on failure; NULL allowed.
 * Returns SVO_INVALID_ARGUMENT (the message lists the valid names or the range), SVO_OUT_OF_HOST_MEMORY.
 */
svo_status scene_create(const char *spec, scene **out, svo_message *message);
void scene_destroy(scene **scene_handle); /* NULL and a pointer to NULL are allowed */
const svo_mesh *scene_mesh(const scene *scene_handle); /* lives as long as the scene */
uint32_t scene_seed(const scene *scene_handle); /* it was made with */

/*
 * The three write a mesh to a stream, whose errors the caller looks for. A mesh needs float positions, normals and
 * colors, and no textures. message: receives one line on failure; NULL allowed.
 *
 * OBJ has vertex colors and normals and, where the mesh has materials, names the file of the library, which is what
 * scene_write_mtl writes. PLY is binary little-endian with normals and colors, base colors multiplied in.
 *
 * Returns SVO_UNSUPPORTED (another mesh, or a PLY of one in which triangles of different base colors share a vertex),
 * SVO_OUT_OF_HOST_MEMORY; nothing was written then.
 */
svo_status scene_write_obj(const svo_mesh *mesh, const char *library_name, FILE *stream, svo_message *message);
svo_status scene_write_ply(const svo_mesh *mesh, FILE *stream, svo_message *message);
void scene_write_mtl(const svo_mesh *mesh, FILE *stream);

#endif
