/* SPDX-License-Identifier: MIT */
/*
 * The target of the scenes: a growing mesh that remembers the first allocation failure, or a mere counter.
 *
 * In counting mode nothing is stored and surface functions are not called. A scene is generated in this mode until its
 * detail gives the requested count, and then once with storage.
 */
#ifndef SVOCL_TOOLS_SCENES_BUILDER_H
#define SVOCL_TOOLS_SCENES_BUILDER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "maths.h"
#include "svocl/mesh.h"

#define SCENE_MATERIALS_MAX 8

typedef struct scene_builder {
    float *positions;
    float *normals;
    uint8_t *colors;
    size_t vertex_count, vertex_capacity;
    uint32_t *indices;
    uint16_t *triangle_materials;
    size_t triangle_count, triangle_capacity;
    svo_material materials[SCENE_MATERIALS_MAX];
    size_t material_count;
    uint16_t material; /* material of the triangles that follow */
    bool counting;
    bool out_of_memory; /* sticky: later calls do nothing */
} scene_builder;

/* One point of a surface: color components are in [0, 1] and stored unchanged (sRGB). */
typedef struct surface_point {
    vector3 position;
    vector3 normal; /* unit length */
    vector3 color;
} surface_point;

/* Parameters of a scene. */
typedef struct scene_request {
    uint32_t triangles;
    uint32_t seed;
} scene_request;

/* Appends a vertex and returns its index; 0 in counting mode or without memory. */
uint32_t builder_vertex(scene_builder *builder, const surface_point *point);
/* Appends a triangle of the current material, counter-clockwise seen from outside. */
void builder_triangle(scene_builder *builder, uint32_t a, uint32_t b, uint32_t c);
/* Two triangles. */
void builder_quad(scene_builder *builder, uint32_t a, uint32_t b, uint32_t c, uint32_t d);
/* Adds a material of a base color, makes it current and returns its number. */
uint16_t builder_add_material(scene_builder *builder, vector3 base_color);
/* Whether vertices need not be computed: counting, or out of memory. */
bool builder_is_idle(const scene_builder *builder);
void builder_release(scene_builder *builder);

/* A scene whose parts are all refined by one number; 1 is the default. More detail never gives fewer triangles. */
typedef void (*detailed_scene)(scene_builder *builder, uint32_t seed, double detail);

/* Builds a scene with the detail whose triangle count is nearest to the requested one. */
void builder_fit(scene_builder *builder, const scene_request *request, detailed_scene generate);

/* A number of segments: base at detail 1, never below least. */
uint32_t detail_segments(double base, double detail, uint32_t least);

#endif
