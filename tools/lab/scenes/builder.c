/* SPDX-License-Identifier: MIT */
/* The growing mesh of a scene, and the search for the detail that gives the requested triangle count. */
#include "builder.h"

#include <stdlib.h>
#include <string.h>

bool builder_is_idle(const scene_builder *builder)
{
    return builder->counting || builder->out_of_memory;
}

/* Grows one array to capacity elements; on failure the array stays as it was. */
static bool grow(void **array, size_t capacity, size_t element_bytes)
{
    if (capacity > SIZE_MAX / element_bytes) {
        return false;
    }
    void *grown = realloc(*array, capacity * element_bytes);
    if (grown == NULL) {
        return false;
    }
    *array = grown;
    return true;
}

static bool grow_vertices(scene_builder *builder)
{
    const size_t capacity =
        builder->vertex_capacity == 0 ? 4096 : builder->vertex_capacity + builder->vertex_capacity / 2;
    void *positions = builder->positions;
    void *normals = builder->normals;
    void *colors = builder->colors;
    const bool grown = grow(&positions, capacity, 3 * sizeof(float)) && grow(&normals, capacity, 3 * sizeof(float)) &&
                       grow(&colors, capacity, 4);
    builder->positions = positions;
    builder->normals = normals;
    builder->colors = colors;
    if (grown) {
        builder->vertex_capacity = capacity;
    }
    return grown;
}

static bool grow_triangles(scene_builder *builder)
{
    const size_t capacity =
        builder->triangle_capacity == 0 ? 8192 : builder->triangle_capacity + builder->triangle_capacity / 2;
    void *indices = builder->indices;
    void *materials = builder->triangle_materials;
    const bool grown = grow(&indices, capacity, 3 * sizeof(uint32_t)) && grow(&materials, capacity, sizeof(uint16_t));
    builder->indices = indices;
    builder->triangle_materials = materials;
    if (grown) {
        builder->triangle_capacity = capacity;
    }
    return grown;
}

static uint8_t color_byte(double component)
{
    return (uint8_t)floor(clamp_to(component, 0, 1) * 255 + 0.5);
}

uint32_t builder_vertex(scene_builder *builder, const surface_point *point)
{
    if (builder_is_idle(builder)) {
        return 0;
    }
    if (builder->vertex_count == builder->vertex_capacity && !grow_vertices(builder)) {
        builder->out_of_memory = true;
        return 0;
    }
    const size_t vertex = builder->vertex_count++;
    float *position = builder->positions + 3 * vertex;
    position[0] = (float)point->position.x;
    position[1] = (float)point->position.y;
    position[2] = (float)point->position.z;
    float *normal = builder->normals + 3 * vertex;
    normal[0] = (float)point->normal.x;
    normal[1] = (float)point->normal.y;
    normal[2] = (float)point->normal.z;
    uint8_t *color = builder->colors + 4 * vertex;
    color[0] = color_byte(point->color.x);
    color[1] = color_byte(point->color.y);
    color[2] = color_byte(point->color.z);
    color[3] = 255;
    return (uint32_t)vertex;
}

void builder_triangle(scene_builder *builder, uint32_t a, uint32_t b, uint32_t c)
{
    if (builder->out_of_memory) {
        return;
    }
    if (!builder->counting) {
        if (builder->triangle_count == builder->triangle_capacity && !grow_triangles(builder)) {
            builder->out_of_memory = true;
            return;
        }
        uint32_t *corners = builder->indices + 3 * builder->triangle_count;
        corners[0] = a;
        corners[1] = b;
        corners[2] = c;
        builder->triangle_materials[builder->triangle_count] = builder->material;
    }
    builder->triangle_count += 1;
}

void builder_quad(scene_builder *builder, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    builder_triangle(builder, a, b, c);
    builder_triangle(builder, a, c, d);
}

uint16_t builder_add_material(scene_builder *builder, vector3 base_color)
{
    if (builder->material_count < SCENE_MATERIALS_MAX) {
        svo_material *material = &builder->materials[builder->material_count++];
        material->rgba[0] = color_byte(base_color.x);
        material->rgba[1] = color_byte(base_color.y);
        material->rgba[2] = color_byte(base_color.z);
        material->rgba[3] = 255;
        material->texture_index = SVO_NO_TEXTURE;
    }
    builder->material = (uint16_t)(builder->material_count - 1);
    return builder->material;
}

void builder_release(scene_builder *builder)
{
    free(builder->positions);
    free(builder->normals);
    free(builder->colors);
    free(builder->indices);
    free(builder->triangle_materials);
    memset(builder, 0, sizeof *builder);
}

static size_t count_triangles(detailed_scene generate, uint32_t seed, double detail)
{
    scene_builder counter = {.counting = true};
    generate(&counter, seed, detail);
    return counter.triangle_count;
}

void builder_fit(scene_builder *builder, const scene_request *request, detailed_scene generate)
{
    /* Counts grow with the square of the detail, in steps: bisect to where they pass the requested one. */
    double low = 0x1p-8;
    double high = 0x1p8;
    for (int step = 0; step < 40; ++step) {
        const double middle = sqrt(low * high);
        if (count_triangles(generate, request->seed, middle) < request->triangles) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const size_t below = count_triangles(generate, request->seed, low);
    const size_t above = count_triangles(generate, request->seed, high);
    const bool below_is_nearer = below <= request->triangles && request->triangles - below < above - request->triangles;
    generate(builder, request->seed, below_is_nearer ? low : high);
}

uint32_t detail_segments(double base, double detail, uint32_t least)
{
    const double segments = floor(base * detail + 0.5);
    return segments < (double)least ? least : (uint32_t)segments;
}
