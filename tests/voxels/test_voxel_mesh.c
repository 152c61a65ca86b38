/* SPDX-License-Identifier: MIT */
/* The merged faces of a list, built as a mesh on the list's grid: the same voxels, and those with outer faces have
   their colors. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenes.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/suite.h"
#include "svocl/solid.h"
#include "svocl/voxel_files.h"

enum { SIDE = 12, CELLS = SIDE * SIDE * SIDE, VERTEX_BYTES = 16, FACE_BYTES = 17 };

typedef struct byte_list {
    uint8_t *bytes;
    size_t count;
} byte_list;

static int append(void *user, const void *bytes, size_t byte_count)
{
    byte_list *list = user;
    uint8_t *larger = realloc(list->bytes, list->count + byte_count + 1);
    assert_non_null(larger);
    memcpy(larger + list->count, bytes, byte_count);
    *list = (byte_list){larger, list->count + byte_count};
    larger[list->count] = 0;
    return 0;
}

/* A box of voxels, by the share of ten that are there, in three colors. */
static size_t fill(uint64_t *seed, uint32_t share, svo_voxel voxels[CELLS])
{
    size_t count = 0;
    for (int i = 0; i < CELLS; ++i) {
        const uint8_t color = (uint8_t)(1 + random_below(seed, 3));
        if ((uint32_t)random_below(seed, 10) < share) {
            voxels[count++] = (svo_voxel){.x = i % SIDE - 5,
                                          .y = i / SIDE % SIDE + 100,
                                          .z = i / SIDE / SIDE,
                                          .rgba = {(uint8_t)(80 * color), color, (uint8_t)(255 - color), 255}};
        }
    }
    return count;
}

/* The rectangles of the list's .ply file as triangles, whose arrays the caller frees. */
static svo_mesh mesh_of(const svo_voxels *voxels, float **positions, uint8_t **colors)
{
    byte_list file = {0};
    size_t vertices = 0;
    assert_int_equal(
        svo_voxels_save_faces(voxels, (svo_sink){.write = append, .user = &file}, SVO_VOXEL_FORMAT_PLY, NULL, NULL),
        SVO_OK);
    const char *text = (const char *)file.bytes;
    assert_int_equal(sscanf(strstr(text, "element vertex"), "element vertex %zu", &vertices), 1);
    const uint8_t *at = (const uint8_t *)strstr(text, "end_header\n") + strlen("end_header\n");
    const size_t corners = vertices / 4 * 6;
    *positions = calloc(corners, 3 * sizeof **positions);
    *colors = calloc(corners, 4);
    assert_true(*positions != NULL && *colors != NULL);
    for (size_t i = 0; i < corners; ++i) {
        static const size_t of_rectangle[6] = {0, 1, 2, 0, 2, 3};
        const uint8_t *from = at + VERTEX_BYTES * (i / 6 * 4 + of_rectangle[i % 6]);
        memcpy(*positions + 3 * i, from, 12);
        memcpy(*colors + 4 * i, from + 12, 4);
    }
    free(file.bytes);
    return (svo_mesh){.struct_size = sizeof(svo_mesh),
                      .positions = *positions,
                      .colors = *colors,
                      .vertex_count = corners,
                      .triangle_count = corners / 3};
}

static const svo_voxel *find(const svo_voxels *voxels, uint64_t count, const int32_t place[3])
{
    const svo_voxel *all = svo_voxels_get(voxels);
    for (uint64_t i = 0; i < count; ++i) {
        if (all[i].x == place[0] && all[i].y == place[1] && all[i].z == place[2]) {
            return &all[i];
        }
    }
    return NULL;
}

static bool has_outer_face(const svo_voxels *voxels, uint64_t count, const svo_voxel *voxel)
{
    for (int face = 0; face < 6; ++face) {
        int32_t place[3] = {voxel->x, voxel->y, voxel->z};
        place[face / 2] += face % 2 != 0 ? 1 : -1;
        if (find(voxels, count, place) == NULL) {
            return true;
        }
    }
    return false;
}

static uint64_t count_of(const svo_voxels *voxels)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(voxels, &info), SVO_OK);
    return info.voxel_count;
}

/* Each leaf is a voxel of the list; each voxel with an outer face is a leaf with its color. */
static void check_leaves(const svo_voxels *voxels, const svo_tree *tree)
{
    svo_voxels *leaves = NULL;
    assert_int_equal(svo_tree_get_voxels(tree, &leaves, NULL), SVO_OK);
    const uint64_t given = count_of(voxels);
    const uint64_t made = count_of(leaves);
    uint64_t seen = 0;
    for (uint64_t i = 0; i < given; ++i) {
        const svo_voxel *voxel = &svo_voxels_get(voxels)[i];
        const svo_voxel *leaf = find(leaves, made, (const int32_t[3]){voxel->x, voxel->y, voxel->z});
        seen += leaf != NULL ? 1 : 0;
        if (has_outer_face(voxels, given, voxel)) {
            assert_non_null(leaf);
            assert_memory_equal(leaf->rgba, voxel->rgba, 4);
        }
    }
    assert_int_equal(seen, made);
    svo_voxels_destroy(&leaves);
}

static void faces_are_built_as_their_voxels(void **state)
{
    const fixture *opened = fixture_of_group(state);
    static svo_voxel voxels[CELLS];
    uint64_t seed = 8;
    for (uint32_t share = 1; share <= 10; share += 3) {
        float *positions = NULL;
        uint8_t *colors = NULL;
        svo_voxels *list = NULL;
        svo_compact *solid = NULL;
        svo_solid_info filled = {.struct_size = sizeof filled};
        built made;
        double origin[3], edge = 0.0;
        unsigned depth = 0;
        const svo_voxels_source source = {
            .struct_size = sizeof source, .voxels = voxels, .voxel_count = fill(&seed, share, voxels)};
        assert_int_equal(svo_voxels_create(&source, &list, NULL), SVO_OK);
        const svo_mesh mesh = mesh_of(list, &positions, &colors);
        assert_int_equal(svo_mesh_voxel_grid(&mesh, 1.0, origin, &edge, &depth, NULL), SVO_OK);
        assert_int_equal(depth, 4);
        fixture_build(opened, &mesh, depth,
                      &(svo_plan_options){.need = SVO_NEED_COLOR | SVO_NEED_RAYS,
                                          .origin = {origin[0], origin[1], origin[2]},
                                          .edge = edge},
                      &made);
        check_leaves(list, made.tree);
        assert_int_equal(svo_solid_create(made.tree, NULL, opened->queue, &solid, &filled), SVO_OK);
        assert_int_equal(filled.surface_voxels + filled.inside_voxels, source.voxel_count);
        assert_true(filled.open_columns[0] + filled.open_columns[1] + filled.open_columns[2] == 0);
        svo_compact_destroy(&solid);
        built_destroy(&made);
        svo_voxels_destroy(&list);
        free(positions);
        free(colors);
    }
}

TEST_GROUP(voxel_mesh)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(faces_are_built_as_their_voxels)};
    return cmocka_run_group_tests_name("voxel_mesh", tests, fixture_group_setup, fixture_group_teardown);
}
