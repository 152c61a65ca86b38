/* SPDX-License-Identifier: MIT */
/* Updates a scene that moves. */
#include "moving.h"

#include <inttypes.h>
#include <string.h>

#include "digest.h"
#include "svocl/moving.h"

#define AREA_MAX 20.0 /* of faces of the grid: more than any of the scenes has */

typedef enum step_kind { ADD, MOVE, HIDE, SHOW, REMOVE } step_kind;

/* Of an object, and how far it is shifted. */
static const struct {
    const char *name;
    step_kind kind;
    uint32_t object;
    double shift; /* as a share of the grid */
} steps[] = {
    {"moving, one object", ADD, 0, 0.1},          {"moving, two objects", ADD, 1, -0.2},
    {"moving, the first moved", MOVE, 0, 0.12},   {"moving, the second partly outside", MOVE, 1, 0.5},
    {"moving, the first hidden", HIDE, 0, 0.0},   {"moving, the first shown", SHOW, 0, 0.0},
    {"moving, the second removed", REMOVE, 1, 0},
};

/* Half as large, turned a little. */
static void place(double shift, double transform[12])
{
    const double rows[12] = {0.5, -0.1, 0, shift, 0.1, 0.5, 0, shift, 0, 0.05, 0.5, 0.5 * shift};
    memcpy(transform, rows, sizeof rows);
}

static svo_status take_step(svo_moving *moving, size_t step, const svo_mesh *mesh, double edge)
{
    const uint32_t object = steps[step].object;
    uint32_t added = 0;
    double transform[12];
    place(steps[step].shift * edge, transform);
    switch (steps[step].kind) {
    case ADD:
        return svo_moving_add(moving, mesh, transform, &added);
    case MOVE:
        return svo_moving_set_transform(moving, object, transform);
    case HIDE:
        return svo_moving_show(moving, object, 0);
    case SHOW:
        return svo_moving_show(moving, object, 1);
    default:
        return svo_moving_remove(moving, object);
    }
}

static void print_tree(const char *name, const char *part, const opened *session, svo_moving *moving)
{
    char hash[SVO_HASH_TEXT_BYTES];
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    line_text line = {.used = 0};
    svo_status status = svo_moving_update(moving, &(svo_submit){.queue = session->queue}, &report);
    if (status == SVO_OK) {
        status = svo_tree_download(svo_moving_tree(moving), session->queue);
    }
    if (status == SVO_OK) {
        status = svo_tree_hash(svo_moving_tree(moving), SVO_HASH_ALL, hash);
    }
    if (status != SVO_OK) {
        line_print_status(name, part, status);
        return;
    }
    line_text_add(&line, "%s changed %" PRIu64 " of %" PRIu64, hash, report.changed_fragments, report.fragments);
    line_print(name, part, line.text);
}

void describe_moving(const char *name, const opened *session, const svo_mesh *mesh, const request *wanted)
{
    svo_moving_options options = SVO_MOVING_OPTIONS_INIT;
    svo_moving *moving = NULL;
    options.need = wanted->need;
    options.coverage = wanted->coverage;
    options.weights = wanted->weights;
    options.payload_level = wanted->payload_level;
    memcpy(options.origin, wanted->origin, sizeof options.origin);
    options.edge = wanted->edge;
    options.max_area = AREA_MAX * wanted->edge * wanted->edge;
    svo_status status = svo_moving_create(session->device, mesh, wanted->depth, &options, session->queue, &moving);
    if (status != SVO_OK) {
        line_print_status(name, "moving", status);
        return;
    }
    print_tree(name, "moving, the static mesh alone", session, moving);
    for (size_t step = 0; step < sizeof steps / sizeof steps[0]; ++step) {
        status = take_step(moving, step, mesh, wanted->edge);
        if (status == SVO_OK) {
            print_tree(name, steps[step].name, session, moving);
        } else {
            line_print_status(name, steps[step].name, status);
        }
    }
    svo_moving_destroy(&moving);
}
