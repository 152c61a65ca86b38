/* SPDX-License-Identifier: MIT */
/* Pins of scenes that move. */
#include "pins.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/moving.h"

#define RAYS 1000
#define EDGE 4.0
#define NEEDS                                                                                                       \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_MATERIAL | \
     (uint32_t)SVO_NEED_FILL | (uint32_t)SVO_NEED_PROJECTED_AREA)

typedef enum step_kind { ADD, MOVE, DEFORM, HIDE, SHOW, REMOVE } step_kind;

static const struct {
    const char *name;
    step_kind kind;
    uint32_t object;
    double shift; /* as a share of the grid */
} steps[] = {
    {"one object", ADD, 0, 0.1},         {"two objects", ADD, 1, -0.2},      {"first moved", MOVE, 0, 0.12},
    {"second across", MOVE, 1, 0.5},     {"first deformed", DEFORM, 0, 0.0}, {"first hidden", HIDE, 0, 0.0},
    {"first shown again", SHOW, 0, 0.0}, {"second removed", REMOVE, 1, 0.0},
};
#define STEP_COUNT (sizeof steps / sizeof steps[0])

/* Half as large, turned a little. */
static void place(double shift, double transform[12])
{
    const double rows[12] = {0.5, -0.1, 0, shift, 0.1, 0.5, 0, shift, 0, 0.05, 0.5, 0.5 * shift};
    memcpy(transform, rows, sizeof rows);
}

/* The object's vertices, each moved a little along x by its y. */
static void deform(const pins *all, svo_moving *moving, uint32_t object, const svo_mesh *mesh)
{
    svo_mesh bent = *mesh;
    const size_t count = mesh->vertex_count * 3;
    float *floats = malloc(count * sizeof *floats);
    double *doubles = malloc(count * sizeof *doubles);
    assert_true(floats != NULL && doubles != NULL);
    for (size_t i = 0; i < count; ++i) {
        if (mesh->positions != NULL) {
            floats[i] = mesh->positions[i] + (i % 3 == 0 ? 0.25F * mesh->positions[i + 1] : 0);
        } else {
            doubles[i] = mesh->positions_double[i] + (i % 3 == 0 ? 0.25 * mesh->positions_double[i + 1] : 0);
        }
    }
    bent.positions = mesh->positions != NULL ? floats : NULL;
    bent.positions_double = mesh->positions != NULL ? NULL : doubles;
    pin_succeed(all, svo_moving_set_vertices(moving, object, &bent));
    free(doubles);
    free(floats);
}

static void take_step(const pins *all, svo_moving *moving, size_t step, const svo_mesh *mesh)
{
    const uint32_t object = steps[step].object;
    uint32_t added = 0;
    double transform[12];
    place(steps[step].shift * EDGE, transform);
    switch (steps[step].kind) {
    case ADD:
        pin_succeed(all, svo_moving_add(moving, mesh, transform, &added));
        assert_int_equal(added, object);
        break;
    case MOVE:
        pin_succeed(all, svo_moving_set_transform(moving, object, transform));
        break;
    case DEFORM:
        deform(all, moving, object, mesh);
        break;
    case HIDE:
    case SHOW:
        pin_succeed(all, svo_moving_show(moving, object, steps[step].kind == SHOW));
        break;
    default:
        pin_succeed(all, svo_moving_remove(moving, object));
        break;
    }
}

static void pin_changes(pins *all, const char *name, const svo_moving *moving)
{
    enum { BOXES_MAX = 8 };
    svo_box boxes[BOXES_MAX];
    size_t count = 0;
    pin_succeed(all, svo_moving_get_changes(moving, boxes, BOXES_MAX, &count));
    assert_true(count <= BOXES_MAX);
    pin_digest(all, name, boxes, count * sizeof boxes[0]);
}

/* The BVH of the objects, which is refit where they only moved, and hits by it. */
static void pin_traced(pins *all, const char *name, svo_moving *moving)
{
    static svo_ray rays[RAYS];
    static svo_hit hits[RAYS];
    svo_moving_bvh_report report = SVO_MOVING_BVH_REPORT_INIT;
    char made[PIN_NAME_BYTES];
    svo_tree *tree = svo_moving_tree(moving);
    pin_succeed(all, svo_moving_make_bvh(moving, SVO_BVH_BEST, 4.0F, all->opened.queue, &report));
    pin_make_rays(tree, 55, rays, RAYS);
    pin_succeed(all, svo_trace_triangles(svo_tree_target(tree), svo_in_host(rays), svo_in_host(hits), RAYS,
                                         SVO_TRACE_CLOSEST, &(svo_submit){.queue = all->opened.queue}));
    for (size_t i = 0; i < RAYS; ++i) {
        hits[i].count = 0;
    }
    (void)snprintf(made, sizeof made, "%s, BVHs", name);
    pin_text(all, made, "kept %u refit %u made %u", (unsigned)report.kept, (unsigned)report.refit,
             (unsigned)report.made);
    (void)snprintf(made, sizeof made, "%s, hits", name);
    pin_digest(all, made, hits, sizeof hits);
}

/* step: even ones wait, odd ones are enqueued. */
static void update(pins *all, const char *name, svo_moving *moving, size_t step)
{
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    char counts[PIN_NAME_BYTES];
    const svo_submit submit = {.queue = all->opened.queue};
    if (step % 2 == 0) {
        pin_succeed(all, svo_moving_update(moving, &submit, &report));
    } else {
        pin_succeed(all, svo_moving_update(moving, &submit, NULL));
        pin_succeed(all, svo_moving_finish(moving, &report));
    }
    pin_tree(all, name, svo_moving_tree(moving));
    (void)snprintf(counts, sizeof counts, "%s, counts", name);
    pin_text(all, counts, "objects %" PRIu64 " changed %" PRIu64 " of %" PRIu64, report.changed_objects,
             report.changed_fragments, report.fragments);
    (void)snprintf(counts, sizeof counts, "%s, changes", name);
    pin_changes(all, counts, moving);
    pin_traced(all, name, moving);
}

void pin_moving(pins *all)
{
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        const svo_mesh *mesh = all->scenes[s].mesh;
        const svo_moving_options options = {.struct_size = sizeof options,
                                            .need = NEEDS,
                                            .coverage = s == 1 ? SVO_COVERAGE_CLOSED : SVO_COVERAGE_HALF_OPEN,
                                            .origin = {-2, -2, -2},
                                            .edge = EDGE,
                                            .max_area = 20 * EDGE * EDGE};
        svo_moving *moving = NULL;
        pin_begin(all, "%s", all->scenes[s].name);
        pin_succeed(all, svo_moving_create(all->opened.device, mesh, 5, &options, all->opened.queue, &moving));
        update(all, "the static mesh alone", moving, 0);
        for (size_t step = 0; step < STEP_COUNT; ++step) {
            take_step(all, moving, step, mesh);
            update(all, steps[step].name, moving, step);
        }
        svo_moving_destroy(&moving);
    }
}
