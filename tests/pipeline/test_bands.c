/* SPDX-License-Identifier: MIT */
/*
 * Calls that wait launch their work in bands on GPUs, whose drivers end a launch of seconds: many of them, if they are
 * made small, the more the longer they take, and the same bytes. Enqueued calls, and CPUs, launch a batch once.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/device.h"
#include "scenes.h"
#include "support/counting.h"
#include "support/enqueued.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

#define DEPTH        6
#define GROUPS       157u
#define RECORDS      (GROUPS * 64u - 37u)
#define RECORD_BYTES 64u /* the most of a record */
#define EDGE         208u /* pixels */

typedef struct subject {
    fixture opened;
    scene *room;
    svo_tree *tree;
    svo_compact *compact;
    svo_light *light;
    svo_probes *probes;
    svo_scene *scene;
} subject;

/* ---- what goes in bands ---- */

typedef svo_status batch_function(subject *s, svo_array from, svo_array to, const svo_submit *submit);

static svo_status closest(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_trace_triangles(svo_tree_target(s->tree), from, to, RECORDS, SVO_TRACE_CLOSEST, submit);
}

static svo_status counts(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_trace_triangles(svo_tree_target(s->tree), from, to, RECORDS, SVO_TRACE_COUNT, submit);
}

static svo_status nearest(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_tree_nearest(s->tree, from, to, RECORDS, submit);
}

static svo_status voxels(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_trace_voxels(svo_tree_target(s->tree), from, to, RECORDS, 0.0F, 0, submit);
}

static svo_status compact_voxels(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_trace_voxels(svo_compact_target(s->compact), from, to, RECORDS, 0.0F, 0, submit);
}

static svo_status scene_voxels(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_trace_voxels(svo_scene_target(s->scene), from, to, RECORDS, 0.0F, SVO_SCENE_CLOSEST, submit);
}

static svo_status scene_triangles(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_trace_triangles(svo_scene_target(s->scene), from, to, RECORDS, SVO_SCENE_CLOSEST, submit);
}

static svo_status gather(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_gather(s->light, from, to, RECORDS, NULL, submit);
}

static svo_status probe_hits(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_probes_trace(s->probes, from, to, RECORDS, NULL, submit);
}

static svo_status irradiance(subject *s, svo_array from, svo_array to, const svo_submit *submit)
{
    return svo_probes_irradiance(s->probes, from, to, RECORDS, submit);
}

typedef struct batch {
    const char *name;
    batch_function *run;
    size_t input_bytes, output_bytes; /* of a record */
} batch;

static const batch batches[] = {
    {"triangles", closest, sizeof(svo_ray), sizeof(svo_hit)},
    {"triangles, counted", counts, sizeof(svo_ray), sizeof(svo_hit)},
    {"nearest triangles", nearest, sizeof(svo_query_point), sizeof(svo_nearest)},
    {"voxels", voxels, sizeof(svo_ray), sizeof(svo_voxel_hit)},
    {"voxels of a compact tree", compact_voxels, sizeof(svo_ray), sizeof(svo_voxel_hit)},
    {"voxels of a scene", scene_voxels, sizeof(svo_ray), sizeof(svo_scene_hit)},
    {"triangles of a scene", scene_triangles, sizeof(svo_ray), sizeof(svo_scene_triangle_hit)},
    {"cones", gather, sizeof(svo_gather_point), sizeof(svo_gather_result)},
    {"probes", probe_hits, sizeof(svo_ray), sizeof(svo_probe_hit)},
    {"light of probes", irradiance, sizeof(svo_gather_point), sizeof(svo_probe_irradiance)},
};

/* ---- the subject ---- */

static void make_light(subject *s)
{
    const svo_light_source sun = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.3F, -1.0F, 0.2F}, .value = {1.0F, 1.0F, 1.0F}};
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .sources = &sun, .source_count = 1, .view_resolution = 64};
    const svo_probe_options probes = {.struct_size = sizeof probes,
                                      .counts = {2, 1, 1},
                                      .resolution = 64,
                                      .field_size = 8,
                                      .tree = s->tree,
                                      .diffuse = 1,
                                      .cones = 5};
    svo_probe_options options = probes;
    succeed(&s->opened, svo_light_create(s->tree, NULL, s->opened.queue, &s->light));
    succeed(&s->opened, svo_light_set_sources(s->light, &setup, s->opened.queue));
    options.light = s->light;
    succeed(&s->opened, svo_probes_create(&options, s->opened.queue, &s->probes));
}

static void make_subject(svo_path path, subject *s)
{
    const svo_instance placed = {.tree = 0, .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    *s = (subject){.scene = NULL};
    fixture_open_cl(&(fixture_options){.path = path}, &s->opened);
    s->room = fixture_scene("atrium:5000");
    svo_plan *plan = make_plan(&s->opened, scene_mesh(s->room), DEPTH, (svo_plan_options){.need = SVO_NEED_ALL});
    succeed(&s->opened, svo_build(plan, s->opened.frontend, s->opened.queue, &s->tree, NULL));
    svo_plan_destroy(&plan);
    const svo_compact_options compact = {.struct_size = sizeof compact, .form = SVO_FORM_DESCRIPTOR};
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = &s->tree,
                                       .tree_count = 1,
                                       .instances = &placed,
                                       .instance_count = 1,
                                       .need = SVO_NEED_RAYS};
    succeed(&s->opened, svo_compact_create(s->opened.device, s->tree, &compact, s->opened.queue, &s->compact));
    succeed(&s->opened, svo_scene_create(s->opened.device, &options, s->opened.queue, &s->scene));
    make_light(s);
}

static void drop_subject(subject *s)
{
    svo_scene_destroy(&s->scene);
    svo_probes_destroy(&s->probes);
    svo_light_destroy(&s->light);
    svo_compact_destroy(&s->compact);
    svo_tree_destroy(&s->tree);
    scene_destroy(&s->room);
    fixture_close(&s->opened);
}

/* A place in the room's box, by a number. */
static void place(const svo_tree_info *info, size_t i, float out[3])
{
    const size_t cells[3] = {i % 23, i / 23 % 19, i / 437};
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = (float)(info->origin[axis] + info->edge * ((double)cells[axis] + 0.5) / 24.0);
    }
}

/* Records of a batch. */
static void fill(const subject *s, const batch *of, void *records)
{
    const svo_tree_info info = info_of_tree(s->tree);
    for (size_t i = 0; i < RECORDS; ++i) {
        float at[3];
        place(&info, i, at);
        const float direction[3] = {(float)(i % 7) - 3.0F, (float)(i % 5) - 2.0F, (float)(i % 3) + 0.25F};
        if (of->input_bytes == sizeof(svo_ray)) {
            ((svo_ray *)records)[i] = (svo_ray){.origin = {at[0], at[1], at[2]},
                                                .direction = {direction[0], direction[1], direction[2]},
                                                .t_max = 1000.0F};
        } else if (of->input_bytes == sizeof(svo_query_point)) {
            ((svo_query_point *)records)[i] =
                (svo_query_point){.position = {at[0], at[1], at[2]}, .max_distance = 1000.0F};
        } else {
            ((svo_gather_point *)records)[i] = (svo_gather_point){.position = {at[0], at[1], at[2]},
                                                                  .normal = {direction[0], direction[1], direction[2]}};
        }
    }
}

_Static_assert(sizeof(svo_ray) != sizeof(svo_gather_point) && sizeof(svo_ray) != sizeof(svo_query_point),
               "records are told by their sizes");

/* ---- batches ---- */

/* Runs a batch with bands in host memory. Returns its launches. */
static uint64_t run(subject *s, const batch *of, svo_i_bands bands, const void *from, void *to)
{
    s->opened.device->bands = bands;
    memset(to, 0xa5, (size_t)RECORDS * RECORD_BYTES);
    counting_begin();
    succeed(&s->opened, of->run(s, svo_in_host(from), svo_in_host(to), NULL));
    return counting_read().launches;
}

/* The same batch in buffers, enqueued. */
static uint64_t enqueue(subject *s, const batch *of, const void *from, void *to)
{
    const cl_context context = info_of_device(s->opened.device).context;
    const size_t bytes = RECORDS * of->output_bytes;
    cl_mem input = clCreateBuffer(context, CL_MEM_READ_ONLY, RECORDS * of->input_bytes, NULL, NULL);
    cl_mem output = clCreateBuffer(context, CL_MEM_READ_WRITE, bytes, NULL, NULL);
    assert_int_equal(
        clEnqueueWriteBuffer(s->opened.queue, input, CL_TRUE, 0, RECORDS * of->input_bytes, from, 0, NULL, NULL),
        CL_SUCCESS);
    counting_begin();
    succeed(&s->opened,
            of->run(s, svo_in_buffer(input), svo_in_buffer(output), &(svo_submit){.queue = s->opened.queue}));
    const uint64_t launches = counting_read().launches;
    assert_int_equal(clEnqueueReadBuffer(s->opened.queue, output, CL_TRUE, 0, bytes, to, 0, NULL, NULL), CL_SUCCESS);
    clReleaseMemObject(input);
    clReleaseMemObject(output);
    return launches;
}

static void expect(const batch *of, const char *how, uint64_t launches, uint64_t expected, bool same)
{
    if (launches != expected || !same) {
        fail_msg("%s, %s: %llu launches, and %llu were expected; the results %s", of->name, how,
                 (unsigned long long)launches, (unsigned long long)expected, same ? "are the same" : "differ");
    }
}

static void compare_bands(subject *s, const batch *of, bool cpu, void *memory[3])
{
    const svo_i_bands usual = s->opened.device->bands;
    const svo_i_bands slow = {0.0, 3, 5}; /* 3 groups, then always the least */
    const svo_i_bands fast = {1e12, 1, 1}; /* 1, 8, 64 groups, and the other 84 */
    const size_t bytes = RECORDS * of->output_bytes;
    fill(s, of, memory[0]);
    (void)run(s, of, usual, memory[0], memory[1]); /* makes what it needs */
    expect(of, "whole", run(s, of, usual, memory[0], memory[1]), 1, true);
    uint64_t launches = run(s, of, slow, memory[0], memory[2]);
    expect(of, "slow", launches, cpu ? 1 : 1 + (GROUPS - 3 + 4) / 5, memcmp(memory[1], memory[2], bytes) == 0);
    launches = run(s, of, fast, memory[0], memory[2]);
    expect(of, "fast", launches, cpu ? 1 : 4, memcmp(memory[1], memory[2], bytes) == 0);
    s->opened.device->bands = slow;
    launches = enqueue(s, of, memory[0], memory[2]);
    expect(of, "enqueued", launches, 1, memcmp(memory[1], memory[2], bytes) == 0);
    s->opened.device->bands = usual;
}

static void batches_are_the_same_in_bands(svo_path path)
{
    subject s;
    void *memory[3];
    make_subject(path, &s);
    for (unsigned i = 0; i < 3; ++i) {
        memory[i] = malloc((size_t)RECORDS * RECORD_BYTES);
        assert_non_null(memory[i]);
    }
    for (size_t i = 0; i < sizeof batches / sizeof batches[0]; ++i) {
        assert_in_range(batches[i].output_bytes, 1, RECORD_BYTES);
        compare_bands(&s, &batches[i], path == SVO_PATH_CPU, memory);
    }
    for (unsigned i = 0; i < 3; ++i) {
        free(memory[i]);
    }
    drop_subject(&s);
}

static void gpus_take_many_launches(void **state)
{
    (void)state;
    batches_are_the_same_in_bands(SVO_PATH_GPU);
}

static void cpus_take_one_launch(void **state)
{
    (void)state;
    batches_are_the_same_in_bands(SVO_PATH_CPU);
}

/* ---- pictures ---- */

static uint64_t draw(subject *s, svo_target target, svo_render_view view, double target_ms, unsigned char *pixels)
{
    svo_render_options options = SVO_RENDER_OPTIONS_INIT;
    options.width = EDGE;
    options.height = EDGE;
    options.view = view;
    s->opened.device->bands = (svo_i_bands){target_ms, 1, 1};
    succeed(&s->opened, svo_camera_fit(svo_tree_target(s->tree), 1.0F, &options.camera));
    memset(pixels, 0xa5, (size_t)EDGE * EDGE * 4);
    counting_begin();
    succeed(&s->opened, svo_render(target, &options, svo_in_host(pixels), NULL));
    return counting_read().launches;
}

/* The first band of a picture is as large as all of those that are not measured, here of 32 tiles of 8 x 8 pixels, or
   2 of the 16 x 16 of a light without rays; the others are of one. */
static void pictures_are_the_same_in_bands(void **state)
{
    static unsigned char pixels[2][EDGE * EDGE * 4];
    (void)state;
    subject s;
    make_subject(SVO_PATH_GPU, &s);
    const struct {
        svo_target of;
        svo_render_view view;
        cl_uint tile_edge, first;
    } targets[] = {{svo_tree_target(s.tree), SVO_VIEW_SHADED, 8, 32},
                   {svo_compact_target(s.compact), SVO_VIEW_SHADED, 8, 32},
                   {svo_scene_target(s.scene), SVO_VIEW_SHADED, 8, 32},
                   {svo_light_target(s.light), SVO_VIEW_DIRECT, 16, 2}};
    const cl_uint all = s.opened.device->band_tiles;
    for (size_t i = 0; i < sizeof targets / sizeof targets[0]; ++i) {
        const cl_uint across = EDGE / targets[i].tile_edge;
        assert_int_equal(draw(&s, targets[i].of, targets[i].view, 1e12, pixels[0]), 1);
        s.opened.device->band_tiles = 32;
        assert_int_equal(draw(&s, targets[i].of, targets[i].view, 0.0, pixels[1]),
                         1 + across * across - targets[i].first);
        assert_memory_equal(pixels[0], pixels[1], sizeof pixels[0]);
        s.opened.device->band_tiles = all;
    }
    drop_subject(&s);
}

TEST_GROUP(bands)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(gpus_take_many_launches),
                                       cmocka_unit_test(cpus_take_one_launch),
                                       cmocka_unit_test(pictures_are_the_same_in_bands)};
    return cmocka_run_group_tests_name("bands", tests, NULL, NULL);
}
