/* SPDX-License-Identifier: MIT */
/*
 * Steps: a step reads the current version's root and writes another. One that fails gives back what it wrote, so the
 * versions are as before. Memory is collected between steps alone, when all roots are known.
 */
#include "edit/steps.h"

#include <inttypes.h>
#include <string.h>

#include "core/limits.h"
#include "core/struct_size.h"
#include "edit/combine.h"

#define MATERIAL_MAX   65534u
#define SPARE_SEGMENTS 8u /* that are written before a collection is worth it */

static const char apply_name[] = "svo_edit_apply";
static const char copy_name[] = "svo_edit_copy";

/* ---- collection ---- */

uint64_t svo_i_edit_collect_bytes(const svo_edit *edit)
{
    return 2 * edit->info.kept_bytes + SPARE_SEGMENTS * (uint64_t)svo_i_edit_segment_bytes;
}

void svo_edit_collect(svo_edit *edit)
{
    svo_i_edit_store_collect(&edit->store, edit->versions, edit->version_count);
    edit->info.kept_bytes = svo_i_edit_store_used(&edit->store);
    ++edit->info.collections;
}

/* ---- versions ---- */

/* Makes root the version after the current one. */
static void push(svo_edit *edit, svo_i_edit_ref root)
{
    if (edit->current + 1 == edit->version_room) {
        memmove(edit->versions, edit->versions + 1, edit->current * sizeof *edit->versions);
        --edit->current;
    }
    edit->versions[++edit->current] = root;
    edit->version_count = edit->current + 1;
}

svo_status svo_edit_undo(svo_edit *edit)
{
    if (edit == NULL || edit->current == 0) {
        return SVO_INVALID_ARGUMENT;
    }
    --edit->current;
    return SVO_OK;
}

svo_status svo_edit_redo(svo_edit *edit)
{
    if (edit == NULL || edit->current + 1 == edit->version_count) {
        return SVO_INVALID_ARGUMENT;
    }
    ++edit->current;
    return SVO_OK;
}

void svo_edit_forget(svo_edit *edit)
{
    edit->versions[0] = edit->versions[edit->current];
    edit->current = 0;
    edit->version_count = 1;
}

/* ---- checks ---- */

static svo_status check_step(const char *function, const svo_edit_step *step, svo_message *message)
{
    if (step->verb > SVO_EDIT_PAINT || step->shape > SVO_EDIT_VOXELS) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: step.%s %u is not in 0 .. %d", function,
                          step->verb > SVO_EDIT_PAINT ? "verb" : "shape",
                          step->verb > SVO_EDIT_PAINT ? step->verb : step->shape,
                          step->verb > SVO_EDIT_PAINT ? SVO_EDIT_PAINT : SVO_EDIT_VOXELS);
    }
    if (step->reserved != 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: step.reserved %u is not 0", function, step->reserved);
    }
    if (step->material > MATERIAL_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: step.material %u is above %u", function, step->material,
                          MATERIAL_MAX);
    }
    return SVO_OK;
}

/* ---- steps ---- */

/* What a step combines the current version with. */
typedef struct operand {
    const char *function; /* for messages */
    svo_edit_verb verb;
    bool has_solid; /* a shape; else the voxels of other */
    svo_i_edit_solid solid;
    svo_i_edit_payload payload; /* of the shape */
    const svo_edit *other; /* whose voxels are moved; of the shape alone where there is one */
    int64_t offset[3]; /* between the coordinates of both */
} operand;

static uint64_t voxels_of(const svo_i_edit_run *run, svo_i_edit_ref root)
{
    return svo_i_edit_voxels_of(run->store, root, SVO_I_EDIT_ROOT_LEVEL);
}

/* Writes the voxels of an operand that are moved. moved_all: whether none was cut off. */
static bool move_voxels(svo_i_edit_run *run, const operand *o, svo_i_edit_ref *out, bool *moved_all)
{
    const svo_edit *other = o->other;
    svo_i_edit_ref source = other->versions[other->current];
    int64_t offset[3];
    if (o->has_solid) {
        run->verb = SVO_EDIT_KEEP;
        if (!svo_i_edit_combine(run, source, SVO_I_EDIT_SHAPE, &source)) {
            return false;
        }
    }
    for (int axis = 0; axis < 3; ++axis) { /* from cube to cube */
        offset[axis] = o->offset[axis];
    }
    if (!svo_i_edit_move(run, &other->store, source, offset, out)) {
        return false;
    }
    *moved_all = voxels_of(run, *out) == svo_i_edit_voxels_of(&other->store, source, SVO_I_EDIT_ROOT_LEVEL);
    return true;
}

/* Runs a step once. moved_all: as for move_voxels. */
static bool run_step(const svo_edit *edit, svo_i_edit_run *run, const operand *o, svo_i_edit_ref *out, bool *moved_all)
{
    svo_i_edit_ref b = SVO_I_EDIT_SHAPE;
    *moved_all = true;
    run->solid = o->solid;
    run->begin = 0.0;
    run->share = o->other != NULL ? 0.5 : 1.0;
    if (o->has_solid && !svo_i_edit_fill(run->store, o->payload, &run->fill)) {
        return false;
    }
    if (o->other != NULL) {
        if (!move_voxels(run, o, &b, moved_all)) {
            return false;
        }
        run->begin = 0.5;
        run->share = 0.5;
    }
    run->verb = o->verb;
    return svo_i_edit_combine(run, edit->versions[edit->current], b, out);
}

static svo_status fail_run(const svo_edit *edit, const svo_i_edit_run *run, const operand *o, svo_message *message)
{
    if (run->canceled) {
        return svo_i_fail(message, SVO_CANCELED, "%s: the progress callback stopped the call at %.0f %%", o->function,
                          run->fraction * 100.0);
    }
    return edit->store.failure == SVO_CAPACITY_EXCEEDED
               ? svo_i_fail(message, SVO_CAPACITY_EXCEEDED, "%s: the nodes need more than max_bytes, %s", o->function,
                            svo_i_bytes(edit->store.max_bytes).text)
               : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the nodes", o->function);
}

static svo_status fail_room(const svo_edit *edit, const operand *o, svo_message *message)
{
    const int64_t *offset = o->offset;
    const svo_edit_info *info = &edit->info;
    return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                      "%s: voxels moved by %" PRId64 ", %" PRId64 ", %" PRId64
                      " are not within %d, %d, %d .. %d, %d, %d",
                      o->function, offset[0], offset[1], offset[2], info->low[0], info->low[1], info->low[2],
                      info->high[0], info->high[1], info->high[2]);
}

static void note_peak(svo_edit *edit)
{
    const uint64_t held_bytes = svo_i_edit_store_held(&edit->store);
    edit->info.peak_bytes = held_bytes > edit->info.peak_bytes ? held_bytes : edit->info.peak_bytes;
}

/* Runs a step; a second time after a collection where memory is lacking. top: receives where its nodes begin. */
static svo_status run_in_memory(svo_edit *edit, svo_i_edit_run *run, const operand *o, svo_i_edit_ref *root,
                                uint32_t *top, svo_message *message)
{
    bool moved_all = true;
    bool is_collected = svo_i_edit_store_used(&edit->store) > svo_i_edit_collect_bytes(edit);
    if (is_collected) {
        svo_edit_collect(edit);
    }
    *top = edit->store.top;
    bool done = run_step(edit, run, o, root, &moved_all);
    note_peak(edit);
    if (!done && !run->canceled && !is_collected) {
        svo_i_edit_store_rewind(&edit->store, *top);
        svo_edit_collect(edit);
        *top = edit->store.top;
        done = run_step(edit, run, o, root, &moved_all);
        note_peak(edit);
    }
    if (!done) {
        return fail_run(edit, run, o, message);
    }
    const bool fills = o->verb == SVO_EDIT_SET || o->verb == SVO_EDIT_ADD;
    return moved_all || !fills ? SVO_OK : fail_room(edit, o, message);
}

static svo_status do_step(svo_edit *edit, const operand *o, svo_message *message)
{
    svo_i_edit_run run = {
        .store = &edit->store, .progress = edit->progress, .progress_user = edit->progress_user, .fraction = -1.0};
    svo_i_edit_ref root = SVO_I_EDIT_EMPTY;
    uint32_t top = edit->store.top;
    svo_status status = svo_i_edit_tell(&run, 0.0) ? run_in_memory(edit, &run, o, &root, &top, message)
                                                   : fail_run(edit, &run, o, message);
    if (status == SVO_OK && !svo_i_edit_tell(&run, 1.0)) {
        status = fail_run(edit, &run, o, message);
    }
    if (status != SVO_OK) {
        svo_i_edit_store_rewind(&edit->store, top);
        return status;
    }
    edit->info.step_nodes = run.node_count;
    edit->info.step_bytes = svo_i_edit_bytes_between(top, edit->store.top);
    push(edit, root);
    return SVO_OK;
}

static svo_i_edit_payload payload_of(const svo_edit_step *step)
{
    svo_i_edit_payload payload = {.material = (uint16_t)step->material};
    memcpy(&payload.color, step->rgba, sizeof payload.color);
    return payload;
}

svo_status svo_edit_apply(svo_edit *edit, const svo_edit_step *step, svo_message *message)
{
    svo_edit_step given;
    if (edit == NULL || step == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", apply_name, edit == NULL ? "edit" : "step");
    }
    SVO_I_TRY(
        svo_i_struct_read(message, apply_name, "step", step, &given, SVO_I_STRUCT_SIZES(svo_edit_step, reserved)));
    SVO_I_TRY(check_step(apply_name, &given, message));
    operand o = {.function = apply_name,
                 .verb = (svo_edit_verb)given.verb,
                 .has_solid = given.shape != SVO_EDIT_VOXELS,
                 .payload = payload_of(&given)};
    if (o.has_solid) {
        SVO_I_TRY(svo_i_edit_solid_read(apply_name, &given, &edit->info, edit->corner, &o.solid, message));
        return do_step(edit, &o, message);
    }
    if (given.other == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: step.other is NULL", apply_name);
    }
    o.other = given.other;
    for (int axis = 0; axis < 3; ++axis) {
        o.offset[axis] = given.offset[axis] + o.other->corner[axis] - edit->corner[axis];
    }
    return do_step(edit, &o, message);
}

svo_status svo_edit_copy(svo_edit *edit, const svo_edit_step *region, const int32_t offset[3], svo_message *message)
{
    svo_edit_step given;
    if (edit == NULL || region == NULL || offset == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", copy_name,
                          edit == NULL     ? "edit"
                          : region == NULL ? "region"
                                           : "offset");
    }
    SVO_I_TRY(
        svo_i_struct_read(message, copy_name, "region", region, &given, SVO_I_STRUCT_SIZES(svo_edit_step, reserved)));
    SVO_I_TRY(check_step(copy_name, &given, message));
    if (given.shape == SVO_EDIT_VOXELS) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: region.shape is not a box, sphere or capsule", copy_name);
    }
    operand o = {.function = copy_name, .verb = (svo_edit_verb)given.verb, .has_solid = true, .other = edit};
    for (int axis = 0; axis < 3; ++axis) {
        if (offset[axis] < -SVO_EDIT_EXTENT || offset[axis] > SVO_EDIT_EXTENT) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: offset[%d] %d is not in -2^21 .. 2^21", copy_name,
                              axis, offset[axis]);
        }
        o.offset[axis] = offset[axis];
    }
    SVO_I_TRY(svo_i_edit_solid_read(copy_name, &given, &edit->info, edit->corner, &o.solid, message));
    return do_step(edit, &o, message);
}
