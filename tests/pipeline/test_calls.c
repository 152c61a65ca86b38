/* SPDX-License-Identifier: MIT */
/*
 * How many calls of OpenCL everything takes, after a first time that compiles: what a GPU waits for are calls that
 * allocate, fill and block. Each kind of work, by the kernels of CPUs and by those of GPUs, makes at most so many.
 *
 * The counts are those of one scene, but for a level of the tree they do not depend on it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scenes.h"
#include "support/counting.h"
#include "support/enqueued.h"
#include "support/fixture.h"
#include "support/suite.h"

#define DEPTH          8
#define POINTS         4096
#define PIXELS         256
#define DOCUMENT_BYTES (1u << 20)

/* What the steps work on. */
typedef struct subject {
    fixture opened;
    scene *room, *knot;
    svo_plan *plan, *updatable;
    svo_workspace *workspace;
    svo_tree *tree, *reused;
    svo_tree *result; /* of a build */
    svo_compact *compact;
    svo_light *light;
    svo_probes *probes;
    svo_moving *moving;
    svo_scene *scene;
    cl_mem rays, hits;
    uint32_t object;
    double shift; /* of the object */
} subject;

typedef void step_function(subject *s);

/* The most calls of a step, and the most bytes that it fills. */
typedef struct limits {
    unsigned buffers, fills, fill_kilobytes, reads, waits, launches;
} limits;

/* A step, which may use what those before it have left. */
typedef struct step {
    const char *name; /* NULL: a preparation, which is not counted */
    step_function *work;
    step_function *undo; /* so that it can be done again; NULL: nothing */
    limits cpu, gpu;
} step;

/* ---- plans and builds ---- */

static void make(subject *s, uint32_t need, svo_builder builder)
{
    s->plan = make_plan(&s->opened, scene_mesh(s->room), DEPTH,
                        (svo_plan_options){.need = need, .builder = builder, .place = SVO_PLACE_DEVICE});
}

static void plan_occupancy(subject *s)
{
    make(s, SVO_NEED_NONE, SVO_BUILDER_CL);
}

static void plan_payload(subject *s)
{
    make(s, SVO_NEED_DEFAULT, SVO_BUILDER_CL);
}

static void plan_all(subject *s)
{
    make(s, SVO_NEED_ALL, SVO_BUILDER_CL);
}

static void plan_sorted(subject *s)
{
    make(s, SVO_NEED_ALL, SVO_BUILDER_SORTED);
}

static void drop_plan(subject *s)
{
    svo_plan_destroy(&s->plan);
}

static void build(subject *s)
{
    succeed(&s->opened, svo_build(s->plan, s->opened.frontend, s->opened.queue, &s->result, NULL));
}

static void drop_result(subject *s)
{
    svo_tree_destroy(&s->result);
}

static void drop_build(subject *s)
{
    drop_result(s);
    drop_plan(s);
}

static void prepare_workspace(subject *s)
{
    s->updatable = make_plan(
        &s->opened, scene_mesh(s->room), DEPTH,
        (svo_plan_options){.need = SVO_NEED_ALL, .updatable = 1, .edge = 100.0, .origin = {-50.0, -50.0, -50.0}});
    s->workspace = make_workspace(&s->opened, s->updatable);
    s->reused = make_tree(&s->opened, s->workspace);
}

static void enqueue(subject *s)
{
    const svo_submit submit = {.queue = s->opened.queue};
    succeed(&s->opened, svo_plan_update(s->updatable, scene_mesh(s->room), &submit));
    succeed(&s->opened, svo_build_enqueue(s->workspace, s->reused, &submit));
    succeed(&s->opened, svo_tree_finish(s->reused, s->opened.queue, 0, NULL));
}

/* ---- rays ---- */

static void take_tree(subject *s)
{
    s->tree = s->result;
    s->result = NULL;
    drop_plan(s);
}

static void make_bvh(subject *s, svo_bvh_quality quality)
{
    succeed(&s->opened, svo_tree_make_bvh(s->tree, quality, s->opened.queue));
}

static void make_best_bvh(subject *s)
{
    make_bvh(s, SVO_BVH_BEST);
}

static void make_fast_bvh(subject *s)
{
    make_bvh(s, SVO_BVH_FAST);
}

static void prepare_rays(subject *s)
{
    static svo_ray rays[POINTS];
    svo_device_info on = SVO_DEVICE_INFO_INIT;
    for (size_t i = 0; i < POINTS; ++i) {
        const size_t row = i / 64;
        rays[i] = (svo_ray){.origin = {(float)(i % 64) * 0.1F, (float)row * 0.1F, -50.0F},
                            .direction = {0.0F, 0.0F, 1.0F},
                            .t_max = 1000.0F};
    }
    succeed(&s->opened, svo_device_get_info(s->opened.device, &on));
    s->rays = clCreateBuffer(on.context, CL_MEM_COPY_HOST_PTR, sizeof rays, rays, NULL);
    s->hits = clCreateBuffer(on.context, CL_MEM_READ_WRITE, POINTS * sizeof(svo_hit), NULL, NULL);
    assert_non_null(s->rays);
    assert_non_null(s->hits);
}

static void trace_buffers(subject *s)
{
    const svo_submit submit = {.queue = s->opened.queue};
    succeed(&s->opened, svo_trace_triangles(svo_tree_target(s->tree), svo_in_buffer(s->rays), svo_in_buffer(s->hits),
                                            POINTS, SVO_TRACE_CLOSEST, &submit));
}

static void trace_host(subject *s)
{
    static const svo_ray rays[POINTS];
    static svo_hit hits[POINTS];
    succeed(&s->opened, svo_trace_triangles(svo_tree_target(s->tree), svo_in_host(rays), svo_in_host(hits), POINTS,
                                            SVO_TRACE_CLOSEST, NULL));
}

static void draw(subject *s)
{
    static unsigned char pixels[PIXELS * PIXELS * 4];
    svo_render_options options = SVO_RENDER_OPTIONS_INIT;
    options.width = PIXELS;
    options.height = PIXELS;
    succeed(&s->opened, svo_camera_fit(svo_tree_target(s->tree), 1.0F, &options.camera));
    succeed(&s->opened, svo_render(svo_tree_target(s->tree), &options, svo_in_host(pixels), NULL));
}

/* ---- compact trees ---- */

static void compact(subject *s, svo_form form)
{
    const svo_compact_options options = {.struct_size = sizeof options, .form = form};
    succeed(&s->opened, svo_compact_create(s->opened.device, s->tree, &options, s->opened.queue, &s->compact));
}

static void make_descriptors(subject *s)
{
    compact(s, SVO_FORM_DESCRIPTOR);
}

static void make_implied(subject *s)
{
    compact(s, SVO_FORM_IMPLIED);
}

static void make_shared(subject *s)
{
    compact(s, SVO_FORM_SHARED);
}

static void drop_compact(subject *s)
{
    svo_compact_destroy(&s->compact);
}

static void expand(subject *s)
{
    succeed(&s->opened, svo_compact_expand(s->compact, s->opened.queue, &s->result));
}

/* ---- light ---- */

static void make_light(subject *s)
{
    succeed(&s->opened, svo_light_create(s->tree, NULL, s->opened.queue, &s->light));
}

static void drop_light(subject *s)
{
    svo_light_destroy(&s->light);
}

static void set_sources(subject *s)
{
    const svo_light_source sun = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.3F, -1.0F, 0.2F}, .value = {1.0F, 1.0F, 1.0F}};
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .sources = &sun, .source_count = 1, .view_resolution = 128};
    succeed(&s->opened, svo_light_set_sources(s->light, &setup, s->opened.queue));
}

static void gather(subject *s)
{
    static const svo_gather_point points[POINTS];
    static svo_gather_result results[POINTS];
    succeed(&s->opened, svo_gather(s->light, svo_in_host(points), svo_in_host(results), POINTS, NULL, NULL));
}

static void make_probes(subject *s)
{
    const svo_probe_options options = {.struct_size = sizeof options,
                                       .counts = {2, 2, 2},
                                       .resolution = 64,
                                       .field_size = 16,
                                       .light = s->light,
                                       .tree = s->tree,
                                       .diffuse = 1,
                                       .cones = 5};
    succeed(&s->opened, svo_probes_create(&options, s->opened.queue, &s->probes));
}

static void drop_probes(subject *s)
{
    svo_probes_destroy(&s->probes);
}

/* ---- scenes ---- */

static void prepare_scene(subject *s)
{
    svo_instance placed[2] = {{.tree = 0, .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
                              {.tree = 0, .transform = {1, 0, 0, 20, 0, 1, 0, 0, 0, 0, 1, 0}}};
    const svo_scene_options options = {
        .struct_size = sizeof options, .trees = &s->tree, .tree_count = 1, .instances = placed, .instance_count = 2};
    succeed(&s->opened, svo_scene_create(s->opened.device, &options, s->opened.queue, &s->scene));
}

static void place_instances(subject *s)
{
    const float transforms[24] = {1, 0, 0, 3, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 20, 0, 1, 0, 0, 0, 0, 1, 0};
    succeed(&s->opened, svo_scene_set_transforms(s->scene, 0, 2, transforms, s->opened.queue));
}

static void rebuild_scene(subject *s)
{
    succeed(&s->opened, svo_scene_rebuild(s->scene, s->opened.queue));
}

static void prepare_moving(subject *s)
{
    const svo_moving_options options = {
        .struct_size = sizeof options, .need = SVO_NEED_ALL, .origin = {-50.0, -50.0, -50.0}, .edge = 100.0};
    const svo_mesh *mesh = scene_mesh(s->knot);
    succeed(&s->opened, svo_moving_create(s->opened.device, mesh, DEPTH, &options, s->opened.queue, &s->moving));
    succeed(&s->opened, svo_moving_add(s->moving, mesh, NULL, &s->object));
    succeed(&s->opened, svo_moving_update(s->moving, NULL, NULL));
}

static void move(subject *s)
{
    s->shift += 0.5;
    const double transform[12] = {1, 0, 0, s->shift, 0, 1, 0, 0, 0, 0, 1, 0};
    succeed(&s->opened, svo_moving_set_transform(s->moving, s->object, transform));
    succeed(&s->opened, svo_moving_update(s->moving, NULL, NULL));
}

/* ---- the table ---- */

/* Of buffers, fills, kilobytes that they fill, blocking reads, all waits, and launches: on CPUs, and on GPUs. */

static const step steps[] = {
    {"plan, occupancy", plan_occupancy, drop_plan, {7, 2, 25, 2, 4, 8}, {7, 2, 25, 2, 4, 8}},
    {"build, occupancy", build, drop_result, {9, 2, 4, 2, 5, 13}, {9, 2, 4, 2, 5, 13}},
    {NULL, drop_build, NULL, {0}, {0}},
    {"plan, payload", plan_payload, drop_plan, {14, 3, 25, 3, 5, 11}, {14, 3, 25, 3, 5, 11}},
    {"build, payload", build, drop_result, {14, 3, 1936, 2, 5, 20}, {16, 3, 1936, 2, 5, 25}},
    {NULL, drop_build, NULL, {0}, {0}},
    {"plan, everything, sorted", plan_sorted, drop_plan, {14, 3, 25, 3, 5, 13}, {14, 3, 25, 3, 5, 13}},
    {"build, everything, sorted", build, drop_result, {26, 4, 3863, 2, 7, 75}, {26, 4, 1931, 2, 7, 86}},
    {NULL, drop_build, NULL, {0}, {0}},
    {"plan, everything", plan_all, drop_plan, {14, 3, 25, 3, 5, 13}, {14, 3, 25, 3, 5, 13}},
    {"build, everything", build, drop_result, {25, 5, 5799, 2, 6, 33}, {26, 5, 3867, 2, 6, 36}},
    {NULL, take_tree, NULL, {0}, {0}},
    {NULL, prepare_workspace, NULL, {0}, {0}},
    {"update and enqueued build", enqueue, NULL, {0, 19, 2907, 0, 1, 48}, {0, 19, 2488, 0, 1, 51}},
    {"BVH, fast", make_fast_bvh, make_best_bvh, {21, 3, 80, 3, 5, 53}, {21, 3, 80, 3, 5, 53}},
    {"BVH, best", make_best_bvh, make_fast_bvh, {24, 7, 82, 3, 5, 56}, {24, 7, 92, 3, 5, 65}},
    {NULL, prepare_rays, NULL, {0}, {0}},
    {"rays in buffers", trace_buffers, NULL, {0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 1}},
    {"rays in host memory", trace_host, NULL, {2, 0, 0, 1, 4, 1}, {2, 0, 0, 1, 4, 1}},
    {"picture", draw, NULL, {2, 0, 0, 1, 2, 1}, {2, 0, 0, 1, 2, 1}},
    {"compact, descriptor", make_descriptors, drop_compact, {15, 3, 1306, 1, 5, 24}, {15, 3, 1306, 1, 5, 24}},
    {NULL, drop_compact, NULL, {0}, {0}},
    {"compact, shared", make_shared, drop_compact, {8, 1, 145, 4, 9, 4}, {8, 1, 145, 4, 9, 4}},
    {NULL, drop_compact, NULL, {0}, {0}},
    {"compact, implied", make_implied, drop_compact, {14, 2, 290, 0, 3, 13}, {14, 2, 290, 0, 3, 13}},
    {"expand", expand, drop_result, {32, 1, 0, 0, 2, 68}, {32, 1, 0, 0, 2, 68}},
    {"light", make_light, drop_light, {2, 0, 0, 0, 3, 10}, {2, 0, 0, 0, 3, 10}},
    {"photons", set_sources, NULL, {18, 4, 17027, 5, 11, 32}, {18, 4, 17027, 5, 11, 32}},
    {"light at points", gather, NULL, {3, 0, 0, 1, 4, 1}, {3, 0, 0, 1, 4, 1}},
    {"probes", make_probes, drop_probes, {12, 0, 0, 2, 14, 12}, {12, 0, 0, 2, 14, 12}},
    {NULL, prepare_scene, NULL, {0}, {0}},
    {"scene, transforms", place_instances, NULL, {0, 0, 0, 0, 3, 2}, {0, 0, 0, 0, 3, 1}},
    {"scene, hierarchy", rebuild_scene, NULL, {0, 0, 0, 0, 1, 36}, {0, 0, 0, 0, 1, 35}},
    {NULL, prepare_moving, NULL, {0}, {0}},
    {"step of a moving scene", move, NULL, {40, 13, 137, 4, 14, 77}, {41, 14, 137, 4, 14, 79}},
};

static const step steps_in_gl[] = {
    {NULL, plan_payload, NULL, {0}, {0}},
    {"build, payload, OpenGL", build, drop_result, {12, 2, 1936, 2, 5, 16}, {12, 2, 1936, 2, 5, 16}},
};

static void assert_at_most(const step *of, const char *what, uint64_t count, unsigned most)
{
    if (count > most) {
        fail_msg("%s: %llu %s, above %u", of->name, (unsigned long long)count, what, most);
    }
}

static void run(subject *s, const step *of, bool cpu)
{
    const limits *most = cpu ? &of->cpu : &of->gpu;
    of->work(s);
    if (of->name == NULL) {
        return;
    }
    if (of->undo != NULL) {
        of->undo(s);
    }
    counting_begin();
    of->work(s);
    const counted did = counting_read();
    print_message(
        "%-26s %3u buffers, %2u fills of %6u KB, %2u reads, %2u waits, %3u launches, %2u writes, %2u copies\n",
        of->name, (unsigned)did.buffers, (unsigned)did.fills, (unsigned)(did.filled_bytes / 1000), (unsigned)did.reads,
        (unsigned)did.waits, (unsigned)did.launches, (unsigned)did.writes, (unsigned)did.copies);
    assert_int_equal(did.builds, 0);
    assert_at_most(of, "buffers", did.buffers, most->buffers);
    assert_at_most(of, "fills", did.fills, most->fills);
    assert_at_most(of, "kilobytes of fills", did.filled_bytes / 1000, most->fill_kilobytes);
    assert_at_most(of, "blocking reads", did.reads, most->reads);
    assert_at_most(of, "waits", did.waits, most->waits);
    assert_at_most(of, "launches", did.launches, most->launches);
}

static void drop(subject *s)
{
    svo_moving_destroy(&s->moving);
    svo_scene_destroy(&s->scene);
    svo_probes_destroy(&s->probes);
    svo_light_destroy(&s->light);
    svo_compact_destroy(&s->compact);
    svo_tree_destroy(&s->result);
    svo_tree_destroy(&s->tree);
    svo_tree_destroy(&s->reused);
    svo_workspace_destroy(&s->workspace);
    svo_plan_destroy(&s->updatable);
    svo_plan_destroy(&s->plan);
    if (s->rays != NULL) {
        clReleaseMemObject(s->rays);
        clReleaseMemObject(s->hits);
    }
    scene_destroy(&s->room);
    scene_destroy(&s->knot);
    fixture_close(&s->opened);
}

static void run_all(subject *s, const step *all, size_t count)
{
    svo_device_info on = SVO_DEVICE_INFO_INIT;
    succeed(&s->opened, svo_device_get_info(s->opened.device, &on));
    s->room = fixture_scene("atrium:20000");
    s->knot = fixture_scene("knot:2000");
    for (size_t i = 0; i < count; ++i) {
        run(s, &all[i], on.path == SVO_PATH_CPU);
    }
    drop(s);
}

static void work_makes_few_calls(void **state)
{
    static const svo_path paths[] = {SVO_PATH_CPU, SVO_PATH_GPU};
    (void)state;
    for (size_t i = 0; i < 2; ++i) {
        subject s = {.shift = 0.0};
        fixture_open_cl(&(fixture_options){.path = paths[i]}, &s.opened);
        print_message("path %s\n", svo_name(SVO_NAME_PATH, paths[i]));
        run_all(&s, steps, sizeof steps / sizeof steps[0]);
    }
}

static void builds_by_opengl_make_few_calls(void **state)
{
    subject s = {.shift = 0.0};
    (void)state;
    fixture_open(&(fixture_options){.context = 0}, &s.opened);
    run_all(&s, steps_in_gl, sizeof steps_in_gl / sizeof steps_in_gl[0]);
}

/* The text of docs/performance.md, released by free. */
static char *read_document(void)
{
    FILE *file = fopen(PERFORMANCE_DOCUMENT, "rb");
    char *text = calloc(1, DOCUMENT_BYTES);
    assert_non_null(file);
    assert_non_null(text);
    assert_in_range(fread(text, 1, DOCUMENT_BYTES, file), 1, DOCUMENT_BYTES - 1);
    (void)fclose(file);
    return text;
}

static bool document_has(const char *text, const step *of)
{
    char row[256];
    const limits *c = &of->cpu;
    const limits *g = &of->gpu;
    (void)snprintf(row, sizeof row, "\n| %s | %u | %u | %u | %u | %u | %u | %u | %u |\n", of->name, c->buffers,
                   c->fills, c->reads, c->launches, g->buffers, g->fills, g->reads, g->launches);
    if (strstr(text, row) == NULL) {
        print_message("missing in docs/performance.md:%s", row);
        return false;
    }
    return true;
}

static void the_document_has_the_counts(void **state)
{
    (void)state;
    char *text = read_document();
    size_t missing = 0;
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; ++i) {
        missing += steps[i].name != NULL && !document_has(text, &steps[i]) ? 1 : 0;
    }
    free(text);
    assert_int_equal(missing, 0);
}

TEST_GROUP(calls)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_document_has_the_counts),
                                       cmocka_unit_test(work_makes_few_calls),
                                       cmocka_unit_test(builds_by_opengl_make_few_calls)};
    return cmocka_run_group_tests_name("calls", tests, NULL, NULL);
}
