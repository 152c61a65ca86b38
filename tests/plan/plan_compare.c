/* SPDX-License-Identifier: MIT */
/* See plan_compare.h. */
#include "plan_compare.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "plan/arrays.h"

static void same_bytes(const char *name, const void *host, const void *device, size_t bytes)
{
    if ((host == NULL) != (device == NULL) || (host != NULL && memcmp(host, device, bytes) != 0)) {
        print_error("%s differ, or one plan has none\n", name);
        fail();
    }
}

#define SAME(field)              same_bytes(#field, &host->field, &device->field, sizeof host->field)
#define SAME_ARRAY(field, count) same_bytes(#field, host->field, device->field, (size_t)(count) * sizeof *host->field)

static void compare_geometry(const svo_plan *host, const svo_plan *device)
{
    SAME(vertex_count);
    SAME(triangle_count);
    SAME(class_begin);
    SAME(sums);
    SAME(estimate);
    SAME(large_count);
    SAME_ARRAY(vertices, host->vertex_count * 3);
    SAME_ARRAY(remainders, host->vertex_count);
    SAME_ARRAY(indices, host->triangle_count * 3);
    SAME_ARRAY(triangle_ids, host->triangle_count);
    SAME_ARRAY(items, host->triangle_count);
    SAME_ARRAY(item_fragments, host->triangle_count);
    SAME_ARRAY(large, host->large_count);
    SAME_ARRAY(positions, host->vertex_count * 3);
    SAME_ARRAY(positions_double, host->vertex_count * 3);
}

static void compare_payload(const svo_plan *host, const svo_plan *device)
{
    SAME(material_count);
    SAME(materials_vary);
    SAME(one_normal);
    SAME(texel_count);
    SAME(textures_given);
    SAME(textures_used);
    SAME(weight_log2);
    SAME_ARRAY(records, host->triangle_count);
    SAME_ARRAY(colors, host->vertex_count);
    SAME_ARRAY(normals, host->vertex_count * 4);
    SAME_ARRAY(uvs, host->vertex_count * 2);
    SAME_ARRAY(materials, host->material_count);
    SAME_ARRAY(texels, host->texel_count);
}

static bool is_input(const char *name)
{
    static const char *const names[] = {
        "mesh_vertices", "mesh_indices",      "mesh_positions", "mesh_items",     "vertices", "indices",
        "records",       "vertex_remainders", "vertex_colors",  "vertex_normals", "uvs"};
    size_t i = 0;
    while (i < sizeof names / sizeof names[0] && strcmp(names[i], name) != 0) {
        ++i;
    }
    return i < sizeof names / sizeof names[0];
}

/* Builds read the mesh where the plan has it: what a plan on the device lists is what one on the host does, but for
   arrays of the mesh. */
static void compare_buffers(const svo_plan *host, const svo_plan *device)
{
    size_t found = 0;
    for (size_t i = 0; i < host->buffer_count; ++i) {
        const svo_buffer_info *expected = &host->buffers[i];
        if (found < device->buffer_count && strcmp(device->buffers[found].name, expected->name) == 0) {
            same_bytes(expected->name, expected, &device->buffers[found++], sizeof *expected);
        } else {
            assert_true(is_input(expected->name));
        }
    }
    assert_int_equal(found, device->buffer_count);
    assert_in_range(device->predicted_bytes, 1, host->predicted_bytes);
}

void plan_compare(const svo_plan *host, svo_plan *device)
{
    svo_plan_info host_info = host->info;
    svo_plan_info device_info = device->info;
    host_info.grid_ms = device_info.grid_ms = 0.0;
    host_info.place = device_info.place = 0;
    assert_int_equal(svo_i_plan_copy_to_host(device), SVO_OK);
    same_bytes("info", &host_info, &device_info, sizeof host_info);
    compare_geometry(host, device);
    compare_payload(host, device);
    SAME(work);
    compare_buffers(host, device);
    SAME(predicted_tree_bytes);
}
