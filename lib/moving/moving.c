/* SPDX-License-Identifier: MIT */
/*
 * Scenes that move. An update makes new pairs of what changed, a new list and a new tree beside the old ones, and takes
 * them only when all has succeeded.
 */
#include "moving/moving.h"

#include <math.h>
#include <string.h>

#include "core/struct_size.h"
#include "core/work.h"
#include "moving/bvh.h"
#include "moving/changes.h"
#include "moving/merge.h"
#include "moving/mesh.h"
#include "moving/objects.h"
#include "moving/pairs.h"
#include "moving/tree.h"
#include "plan/update.h"

/* ---- an update ---- */

static const char update_name[] = "svo_moving_update";

typedef svo_i_moving_update update;

/* The time since the last call goes to a stage. */
static void tell(update *u, double *stage_ms)
{
    const double now = svo_i_now_ms();
    *stage_ms += now - u->start_ms;
    u->start_ms = now;
}

bool svo_i_moving_is_new(const svo_i_moving_object *object)
{
    return svo_i_moving_shows(object) && !svo_i_moving_stays(object);
}

bool svo_i_moving_is_due(const svo_moving *moving)
{
    bool due = moving->tree == NULL;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        due = due || (object->listed && !svo_i_moving_stays(object)) || svo_i_moving_is_new(object);
    }
    return due;
}

/* Brings new vertices to the plans of the objects. */
static svo_status move_objects(update *u)
{
    svo_moving *moving = u->moving;
    double area = 0.0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        svo_i_moving_object *object = &moving->objects[i];
        if (!svo_i_moving_shows(object)) {
            continue;
        }
        if (object->moved) {
            SVO_I_TRY(svo_plan_update_enqueue(object->plan, &object->mesh, u->chain.queue, 0, NULL, NULL));
            SVO_I_TRY(svo_i_update_settle(object->plan, update_name, u->chain.queue));
            object->moved = false;
        }
        area += object->plan->info.area;
    }
    SVO_I_TRY(svo_i_update_check_area(&moving->whole, update_name, area));
    tell(u, &u->report.move_ms);
    return SVO_OK;
}

svo_status svo_i_moving_alloc_changed(update *u)
{
    const svo_i_memory *memory = &u->moving->device->memory;
    u->changed = svo_i_alloc_zeroed(memory, u->moving->object_count, sizeof *u->changed);
    u->members = svo_i_alloc_zeroed(memory, u->moving->object_count, sizeof *u->members);
    return u->changed != NULL && u->members != NULL
               ? SVO_OK
               : svo_i_device_fail(u->moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects",
                                   u->chain.function, u->moving->object_count);
}

/* Makes the pairs of the objects that changed. */
static svo_status make_pairs(update *u)
{
    svo_moving *moving = u->moving;
    SVO_I_TRY(svo_i_moving_alloc_changed(u));
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        if (svo_i_moving_is_new(&moving->objects[i])) {
            svo_i_kept_list *list = &u->changed[u->changed_count];
            u->members[u->changed_count++] = i;
            SVO_I_TRY(svo_i_moving_voxelize(moving, i, &u->chain, NULL, list));
            tell(u, &u->report.voxelize_ms);
            SVO_I_TRY(svo_i_moving_weigh(moving, i, &u->chain, list));
            tell(u, &u->report.weigh_ms);
        }
    }
    return SVO_OK;
}

/* Counts the pairs of the scene and those that changed. staying: receives those of the old list that stay. */
static svo_status count_pairs(update *u, uint64_t *staying)
{
    const svo_moving *moving = u->moving;
    *staying = 0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        const bool stays = svo_i_moving_stays(object);
        *staying += stays ? object->fragments : 0;
        u->report.changed_fragments += object->listed && !stays ? object->fragments : 0;
        u->report.changed_objects += !stays && (object->listed || svo_i_moving_shows(object)) ? 1 : 0;
    }
    u->report.fragments = *staying;
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        u->report.fragments += u->changed[i].count;
        u->report.changed_fragments += u->changed[i].count;
    }
    return u->report.fragments <= u->fragment_limit
               ? SVO_OK
               : svo_i_device_fail(moving->device, SVO_CAPACITY_EXCEEDED,
                                   "%s: the scene has %llu fragments, and room for %llu; see options.fragment_capacity",
                                   u->chain.function, (unsigned long long)u->report.fragments,
                                   (unsigned long long)u->fragment_limit);
}

svo_status svo_i_moving_merge_changed(update *u)
{
    svo_moving *moving = u->moving;
    uint64_t staying = 0;
    static const svo_i_kept_list none = {.count = 0};
    SVO_I_TRY(count_pairs(u, &staying));
    SVO_I_TRY(svo_i_moving_merge_all(moving, &u->chain, u->changed, u->changed_count));
    if (staying == 0 && u->changed_count > 0) { /* nothing to merge */
        u->list = u->changed[0];
        u->changed[0] = none;
    } else {
        u->list = moving->spare;
        moving->spare = none;
        SVO_I_TRY(svo_i_moving_merge(moving, &u->chain, u->changed_count > 0 ? &u->changed[0] : &none,
                                     u->report.fragments, &u->list));
    }
    tell(u, &u->report.merge_ms);
    return SVO_OK;
}

/* The old list's buffers serve the next update. */
void svo_i_moving_commit(update *u, const uint64_t *counts)
{
    svo_moving *moving = u->moving;
    svo_i_moving_note_changes(moving);
    moving->area = 0.0;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        svo_i_moving_object *object = &moving->objects[i];
        object->fragments = svo_i_moving_stays(object) ? object->fragments : 0;
        object->listed = svo_i_moving_shows(object);
        object->stale = object->listed ? false : object->stale;
        moving->area += object->listed ? object->plan->info.area : 0.0;
    }
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        moving->objects[u->members[i]].fragments = counts[i];
        moving->objects[u->members[i]].version = ++moving->serial;
    }
    svo_i_kept_list_free(&moving->spare);
    moving->spare = moving->list;
    moving->list = u->list;
    u->list = (svo_i_kept_list){.count = 0};
    svo_i_moving_note_parts(moving);
    svo_tree_destroy(&moving->tree);
    moving->tree = u->tree;
    u->tree = NULL;
}

static svo_status run_stages(update *u)
{
    svo_status status = SVO_OK;
    uint64_t *counts = NULL;
    SVO_I_TRY_CLEANUP(move_objects(u));
    SVO_I_TRY_CLEANUP(make_pairs(u));
    counts = svo_i_alloc_zeroed(&u->moving->device->memory, u->changed_count + 1u, sizeof *counts);
    if (counts == NULL) {
        status = svo_i_device_fail(u->moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u objects",
                                   update_name, u->changed_count);
        goto cleanup;
    }
    for (uint32_t i = 0; i < u->changed_count; ++i) {
        counts[i] = u->changed[i].count;
    }
    SVO_I_TRY_CLEANUP(svo_i_moving_merge_changed(u));
    SVO_I_TRY_CLEANUP(svo_i_moving_tree(u->moving, &u->chain, &u->list, u->timed ? &u->report : NULL, &u->tree));
    svo_i_moving_commit(u, counts);
cleanup:
    svo_i_free(counts);
    return status;
}

void svo_i_moving_release_update(update *u)
{
    for (uint32_t i = 0; u->changed != NULL && i < u->changed_count; ++i) {
        svo_i_kept_list_free(&u->changed[i]);
    }
    svo_i_kept_list_free(&u->list);
    svo_i_free(u->changed);
    svo_i_free(u->members);
}

#define SIZES_OF_REPORT SVO_I_STRUCT_SIZES(svo_moving_report, total_ms)

svo_status svo_moving_update(svo_moving *moving, cl_command_queue queue, svo_moving_report *report)
{
    if (moving == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    const double start_ms = svo_i_now_ms();
    update u = {.moving = moving,
                .chain = {.function = update_name, .waits = true},
                .fragment_limit = moving->fragment_limit,
                .timed = report != NULL,
                .start_ms = start_ms};
    SVO_I_TRY(svo_i_moving_check_still(moving, update_name));
    SVO_I_TRY(report != NULL
                  ? svo_i_struct_check(&moving->device->message, update_name, "report", report, SIZES_OF_REPORT)
                  : SVO_OK);
    SVO_I_TRY(svo_i_device_queue(moving->device, update_name, queue, &u.chain.queue));
    u.report.fragments = moving->list.count;
    const bool due = svo_i_moving_is_due(moving);
    const svo_status status = due ? run_stages(&u) : SVO_OK;
    if (!due) {
        svo_i_moving_forget_changes(moving);
    }
    svo_i_moving_release_update(&u);
    u.report.total_ms = svo_i_now_ms() - start_ms;
    if (report != NULL) {
        (void)svo_i_struct_write(NULL, update_name, "report", &u.report, report, SIZES_OF_REPORT);
    }
    return status;
}

/* ---- the scene ---- */

/* Reads what describes the scene, and makes the options of the plans. */
static svo_status read_options(svo_moving *moving, const svo_moving_options *given)
{
    svo_moving_options options;
    svo_device *device = moving->device;
    SVO_I_TRY(svo_i_struct_read(&device->message, "svo_moving_create", "options", given, &options,
                                SVO_I_STRUCT_SIZES(svo_moving_options, weight_log2)));
    if (!(options.edge > 0.0)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_moving_create: options.edge %g is not above 0, and the grid is fixed",
                                 options.edge);
    }
    moving->fragment_limit = options.fragment_capacity != 0 ? options.fragment_capacity : SVO_I_FRAGMENTS_MAX;
    moving->options = (svo_plan_options){.struct_size = sizeof moving->options,
                                         .need = options.need,
                                         .coverage = options.coverage,
                                         .weights = options.weights,
                                         .builder = SVO_BUILDER_SORTED,
                                         .payload_level = options.payload_level,
                                         .edge = options.edge,
                                         .max_area = options.max_area,
                                         .updatable = 1,
                                         .weight_log2 = options.weight_log2};
    memcpy(moving->options.origin, options.origin, sizeof options.origin);
    return SVO_OK;
}

/* Puts the materials and textures on the device. */
static svo_status upload_materials(svo_moving *moving, const svo_plan *plan)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    const uint64_t material_bytes = plan->material_count * sizeof(svo_material_record);
    SVO_I_TRY(svo_i_work_begin(moving->device, "svo_moving_create", NULL, &work));
    if (plan->materials != NULL) {
        SVO_I_TRY_CLEANUP(svo_i_work_result(&work, "material_records", material_bytes, &moving->materials));
        SVO_I_TRY_CLEANUP(svo_i_work_write(&work, moving->materials, plan->materials, material_bytes));
    }
    if (plan->texels != NULL) {
        SVO_I_TRY_CLEANUP(svo_i_work_result(&work, "texels", plan->texel_count * 4, &moving->texels));
        SVO_I_TRY_CLEANUP(svo_i_work_write(&work, moving->texels, plan->texels, plan->texel_count * 4));
    }
cleanup:
    svo_i_work_end(&work);
    return status;
}

/* Makes the plan of the whole scene from that of the static mesh. */
static svo_status describe_whole(svo_moving *moving)
{
    const svo_plan *plan = moving->objects[0].plan;
    moving->whole = *plan;
    moving->whole.triangle_count = UINT32_MAX; /* the lists number triangles in their objects */
    moving->whole.work.order = true; /* the filter reads the leaves' ranges */
    moving->options.need = plan->info.need != 0 ? plan->info.need : (uint32_t)SVO_NEED_NONE;
    moving->options.weight_log2 = plan->info.weight_log2;
    moving->options.max_area = 0.0;
    return upload_materials(moving, plan);
}

static svo_status create(svo_moving *moving, const svo_mesh *given, const svo_moving_options *options)
{
    static const char function[] = "svo_moving_create";
    svo_mesh mesh;
    if (given == NULL || options == NULL) {
        return svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 given == NULL ? "mesh" : "options");
    }
    SVO_I_TRY(svo_i_struct_read(&moving->device->message, function, "mesh", given, &mesh,
                                SVO_I_STRUCT_SIZES(svo_mesh, texture_count)));
    SVO_I_TRY(read_options(moving, options));
    moving->objects = svo_i_alloc_zeroed(&moving->device->memory, 4, sizeof *moving->objects);
    if (moving->objects == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for objects", function);
    }
    moving->object_count = 1;
    moving->object_capacity = 4;
    SVO_I_TRY(svo_frontend_create_cl(moving->device, &moving->frontend));
    SVO_I_TRY(svo_i_moving_make_object(moving, function, 0, &mesh, NULL));
    return describe_whole(moving);
}

svo_status svo_moving_create(svo_device *device, const svo_mesh *mesh, unsigned depth,
                             const svo_moving_options *options, cl_command_queue queue, svo_moving **out)
{
    if (device == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_moving_create: %s is NULL",
                                 device == NULL ? "device" : "out");
    }
    svo_status status = SVO_OK;
    svo_moving *moving = svo_i_alloc_zeroed(&device->memory, 1, sizeof *moving);
    if (moving == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_moving_create: no memory for the handle");
    }
    moving->device = device;
    moving->depth = depth;
    SVO_I_TRY_CLEANUP(create(moving, mesh, options));
    SVO_I_TRY_CLEANUP(svo_moving_update(moving, queue, NULL));
    *out = moving;
    return SVO_OK;
cleanup:
    svo_i_message_rename(&device->message, "svo_moving_create");
    svo_moving_destroy(&moving);
    return status;
}

void svo_moving_destroy(svo_moving **moving)
{
    if (moving == NULL || *moving == NULL) {
        return;
    }
    svo_moving *m = *moving;
    if (m->flight != NULL) {
        (void)svo_moving_finish(m, NULL); /* its commands write to the scene */
    }
    svo_tree_destroy(&m->tree);
    svo_i_moving_free_bvhs(m);
    svo_i_kept_list_free(&m->list);
    svo_i_kept_list_free(&m->spare);
    for (uint32_t i = 0; i < m->object_count; ++i) {
        svo_i_moving_release_object(&m->objects[i]);
    }
    svo_i_moving_forget_mesh(m);
    svo_i_buffer_release(&m->materials);
    svo_i_buffer_release(&m->texels);
    svo_frontend_destroy(&m->frontend);
    svo_i_free(m->objects);
    svo_i_free(m);
    *moving = NULL;
}

svo_tree *svo_moving_tree(const svo_moving *moving)
{
    return moving->tree;
}

static uint64_t bytes_of(cl_mem buffer)
{
    size_t bytes = 0;
    if (buffer != NULL) {
        clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    }
    return bytes;
}

static uint64_t list_bytes(const svo_i_kept_list *list)
{
    return bytes_of(list->fragments) + bytes_of(list->values) + bytes_of(list->materials) + bytes_of(list->areas) +
           bytes_of(list->marks);
}

svo_status svo_moving_get_info(const svo_moving *moving, svo_moving_info *info)
{
    svo_moving_info made = {.need = moving->whole.info.need,
                            .weight_log2 = moving->whole.info.weight_log2,
                            .fragments = moving->list.count,
                            .list_bytes = list_bytes(&moving->list) + list_bytes(&moving->spare),
                            .area = moving->area};
    for (uint32_t i = 1; i < moving->object_count; ++i) {
        made.object_count += moving->objects[i].plan != NULL ? 1 : 0;
    }
    return svo_i_struct_write(&moving->device->message, "svo_moving_get_info", "info", &made, info,
                              SVO_I_STRUCT_SIZES(svo_moving_info, area));
}
