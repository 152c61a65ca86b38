/* SPDX-License-Identifier: MIT */
/*
 * A build allocates exactly what its plan lists, for every request, with both builders, for every chunking and however
 * often the list grows. Empty scenes, a point or a triangle need little memory.
 *
 * measured_build compares every figure; the tests here provide the cases.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support/attributed_mesh.h"
#include "support/measured.h"
#include "support/suite.h"

static const svo_builder builders[] = {SVO_BUILDER_CL, SVO_BUILDER_SORTED};
enum { BUILDERS = sizeof builders / sizeof builders[0] };

static void every_request_allocates_the_planned_buffers(void **state)
{
    (void)state;
    static const uint32_t needs[] = {SVO_NEED_NONE,     SVO_NEED_DEFAULT,
                                     SVO_NEED_RAYS,     SVO_NEED_RAYS | (uint32_t)SVO_NEED_COLOR,
                                     SVO_NEED_MATERIAL, SVO_NEED_ALL};
    attributed_mesh made;
    attributed_mesh_create(5, 300, 0.1, &made);
    for (size_t b = 0; b < BUILDERS; ++b) {
        for (size_t i = 0; i < sizeof needs / sizeof needs[0]; ++i) {
            const svo_plan_options options = {.need = needs[i],
                                              .weights =
                                                  needs[i] != SVO_NEED_ALL ? SVO_WEIGHTS_UNIFORM : SVO_WEIGHTS_AREA,
                                              .builder = builders[b],
                                              .edge = 1.0};
            measured taken;
            measured_build(&made.mesh, 6, &options, &taken);
            assert_int_equal(taken.result.report.reruns, 0);
            measured_destroy(&taken);
        }
    }
    attributed_mesh_destroy(&made);
}

/* The list in many chunks, and a list that has to grow: attempts that were too small are listed too. */
static void chunked_and_grown_lists_allocate_the_planned_buffers(void **state)
{
    (void)state;
    static const struct {
        uint64_t chunk_bytes, fragment_capacity;
    } lists[] = {{65536, 0}, {0, 100}};
    attributed_mesh made;
    attributed_mesh_create(6, 100, 0.1, &made);
    for (size_t b = 0; b < BUILDERS; ++b) {
        for (size_t i = 0; i < 2; ++i) {
            const svo_plan_options options = {.need = SVO_NEED_ALL,
                                              .builder = builders[b],
                                              .edge = 1.0,
                                              .chunk_bytes = lists[i].chunk_bytes,
                                              .fragment_capacity = lists[i].fragment_capacity};
            measured taken;
            measured_build(&made.mesh, 7, &options, &taken);
            assert_true(lists[i].chunk_bytes == 0 || builders[b] == SVO_BUILDER_SORTED ||
                        taken.result.report.list_chunks > 1);
            assert_true(lists[i].fragment_capacity == 0 || taken.result.report.reruns > 0);
            measured_destroy(&taken);
        }
    }
    attributed_mesh_destroy(&made);
}

static uint64_t bytes_of(const measured *taken, const char *name)
{
    const svo_buffer_info *found = measured_buffer(taken, name);
    return found != NULL ? found->bytes : 0;
}

/* The bytes of all arrays that the host fills. */
static uint64_t uploaded_bytes(const measured *taken)
{
    static const char *const names[] = {
        "mesh_vertices", "mesh_positions", "mesh_indices",   "mesh_items",       "mesh_tiles",       "vertices",
        "indices",       "triangle_ids",   "positions",      "positions_double", "records",          "uvs",
        "texels",        "vertex_colors",  "vertex_normals", "material_records", "vertex_remainders"};
    uint64_t bytes = 0;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        bytes += bytes_of(taken, names[i]);
    }
    return bytes;
}

/* The voxelizer, the payload and the tree share the mesh: no byte of it crosses to the device twice, also where
   the list is made again. */
static void the_mesh_is_uploaded_once(void **state)
{
    (void)state;
    static const struct {
        uint32_t need;
        svo_weights weights;
        uint64_t fragment_capacity;
    } requests[] = {
        {SVO_NEED_NONE, SVO_WEIGHTS_AREA, 0},  {SVO_NEED_RAYS, SVO_WEIGHTS_AREA, 0},
        {SVO_NEED_COLOR, SVO_WEIGHTS_AREA, 0}, {SVO_NEED_COLOR, SVO_WEIGHTS_UNIFORM, 0},
        {SVO_NEED_ALL, SVO_WEIGHTS_AREA, 0},   {SVO_NEED_ALL, SVO_WEIGHTS_AREA, 100},
    };
    static const uint64_t counts_bytes = 4096; /* what a build writes besides arrays */
    attributed_mesh made;
    attributed_mesh_create(7, 2000, 0.02, &made);
    for (size_t i = 0; i < sizeof requests / sizeof requests[0] * BUILDERS; ++i) {
        const size_t r = i / BUILDERS;
        const svo_plan_options options = {.need = requests[r].need,
                                          .weights = requests[r].weights,
                                          .builder = builders[i % BUILDERS],
                                          .fragment_capacity = requests[r].fragment_capacity,
                                          .edge = 1.0,
                                          .place = SVO_PLACE_HOST};
        measured taken;
        measured_build(&made.mesh, 5, &options, &taken);
        const uint64_t written = counting_read().written_bytes;
        assert_int_equal(taken.result.report.reruns > 0, requests[r].fragment_capacity > 0);
        assert_int_equal(bytes_of(&taken, "vertices") + bytes_of(&taken, "mesh_vertices"), made.mesh.vertex_count * 12);
        assert_in_range(bytes_of(&taken, "indices") + bytes_of(&taken, "mesh_indices"), 1,
                        made.mesh.triangle_count * 12); /* of kept triangles */
        assert_in_range(written, uploaded_bytes(&taken), uploaded_bytes(&taken) + counts_bytes);
        measured_destroy(&taken);
    }
    attributed_mesh_destroy(&made);
}

/* Upper limits, at depth 9, with everything requested. */
static void tiny_scenes_need_little_memory(void **state)
{
    (void)state;
    static const float positions[] = {0.5F, 0.5F, 0.5F, 0.502F, 0.5F, 0.5F, 0.5F, 0.502F, 0.5F};
    static const uint32_t point[3] = {0, 0, 0};
    static const struct {
        const char *name;
        const uint32_t *indices;
        size_t triangles;
        uint64_t planned_bytes, peak_bytes, tree_bytes;
    } scenes[] = {{"nothing", NULL, 0, 6144, 6144, 512},
                  {"a point", point, 1, 24576, 6144, 512},
                  {"a triangle", NULL, 1, 24576, 8192, 1024}};
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i) {
        const svo_mesh mesh = {.struct_size = sizeof mesh,
                               .positions = positions,
                               .vertex_count = 3,
                               .indices = scenes[i].indices,
                               .triangle_count = scenes[i].triangles};
        const svo_plan_options options = {.need = SVO_NEED_ALL, .edge = 1.0};
        measured taken;
        measured_build(&mesh, 9, &options, &taken);
        print_message("%s: %llu nodes, peak %llu bytes (planned %llu), tree %llu bytes (planned %llu)\n",
                      scenes[i].name, (unsigned long long)taken.result.info.node_count,
                      (unsigned long long)taken.peak_bytes, (unsigned long long)taken.planned_peak_bytes,
                      (unsigned long long)taken.tree_bytes, (unsigned long long)taken.planned_tree_bytes);
        assert_in_range(taken.planned_peak_bytes, 1, scenes[i].planned_bytes);
        assert_in_range(taken.peak_bytes, 1, scenes[i].peak_bytes);
        assert_in_range(taken.tree_bytes, 1, scenes[i].tree_bytes);
        assert_int_equal(measured_left_out(&taken, "voxelization") != NULL, scenes[i].triangles == 0);
        measured_destroy(&taken);
    }
}

TEST_GROUP(planned_memory)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_request_allocates_the_planned_buffers),
        cmocka_unit_test(chunked_and_grown_lists_allocate_the_planned_buffers),
        cmocka_unit_test(the_mesh_is_uploaded_once),
        cmocka_unit_test(tiny_scenes_need_little_memory),
    };
    return cmocka_run_group_tests_name("planned_memory", tests, NULL, NULL);
}
