/* SPDX-License-Identifier: MIT */
/*
 * Makes an object's pairs by the stages of a build: the front end "cl" and the sort of the builder "sorted". Then
 * kernels/moving/weigh.cl evaluates each pair once, and kernels/moving/merge.cl merges lists of them. The newest event
 * is handed from one piece of an update to the next.
 */
#include "moving/pairs.h"

#include <stdio.h>

#include "commands/commands.h"
#include "moving/programs.h"
#include "pipeline/build.h"
#include "pipeline/run.h"
#include "plan/accounts.h"
#include "plan/chunking.h"
#include "plan/configuration.h"
#include "plan/estimate.h"
#include "stages/drop.h"
#include "stages/inputs.h"
#include "stages/programs.h"
#include "stages/sort.h"

/* A bit for each object whose pairs in the scene's list are left out. */
#define DROPPED_BYTES (SVO_I_MOVING_OBJECTS / 8)

/* ---- the chain of commands ---- */

svo_status svo_i_moving_program(const svo_moving *moving, const char *function, cl_program *out)
{
    char of_filter[SVO_I_DEFINES_BYTES] = "";
    char defines[SVO_I_DEFINES_BYTES + 16];
    svo_i_plan_defines(&moving->whole, &svo_i_program_filter, of_filter, sizeof of_filter);
    (void)snprintf(defines, sizeof defines, " -DSVO_SORT%s", of_filter);
    return svo_i_program_get(moving->device, function, &svo_i_program_moving, defines, out, NULL);
}

/* Begins a piece of work with the program of kernels/moving. */
static svo_status begin_work(svo_i_chain *chain, const svo_moving *moving, svo_i_device_work *work)
{
    SVO_I_TRY(svo_i_work_begin(moving->device, chain->function, chain->queue, work));
    SVO_I_TRY(svo_i_moving_program(moving, chain->function, &work->program));
    work->last = chain->last;
    chain->last = NULL;
    return SVO_OK;
}

/* Ends it: after a failure waits for its commands. Returns the first failure. */
static svo_status end_work(svo_i_chain *chain, svo_i_device_work *work, svo_status status)
{
    if (status == SVO_OK && chain->waits) {
        status = svo_i_work_wait(work);
    }
    if (status == SVO_OK && !chain->waits) {
        svo_i_work_leave(work, &chain->last);
    } else {
        svo_i_work_end(work);
    }
    return status;
}

svo_i_commands svo_i_chain_begin_commands(svo_i_chain *chain, svo_plan *plan, svo_build_report *report)
{
    svo_i_commands commands = svo_i_commands_begin(plan, chain->queue, report);
    commands.mode = chain->waits ? SVO_I_MODE_RUN : SVO_I_MODE_ENQUEUE;
    commands.untimed = true;
    commands.last = chain->last;
    chain->last = NULL;
    return commands;
}

void svo_i_chain_end_commands(svo_i_chain *chain, svo_i_commands *commands, svo_status status)
{
    if (status == SVO_OK && !chain->waits) {
        chain->last = commands->last;
        commands->last = NULL;
    }
    svo_i_commands_end(commands);
    svo_i_stage_collect(commands);
}

void svo_i_chain_settle(svo_i_chain *chain)
{
    if (chain->last != NULL) {
        (void)svo_i_event_settle(chain->last);
        clReleaseEvent(chain->last);
        chain->last = NULL;
    }
}

/* ---- lists ---- */

void svo_i_kept_list_free(svo_i_kept_list *list)
{
    svo_i_buffer_release(&list->fragments);
    svo_i_buffer_release(&list->values);
    svo_i_buffer_release(&list->materials);
    svo_i_buffer_release(&list->areas);
    svo_i_buffer_release(&list->marks);
    svo_i_buffer_release(&list->counted);
    *list = (svo_i_kept_list){.count = 0};
}

/* Marks of a list of so many pairs. */
static uint64_t count_marks(uint64_t pairs)
{
    return (pairs + SVO_MERGE_STRIP - 1) / SVO_MERGE_STRIP;
}

static bool needs_materials(const svo_moving *moving)
{
    return (moving->whole.work.made & SVO_NEED_MATERIAL) != 0;
}

/* Makes the buffers of the values. */
static svo_status alloc_values(const svo_moving *moving, const char *function, uint64_t capacity, svo_i_kept_list *list)
{
    SVO_I_TRY(svo_i_device_buffer(moving->device, function, "values", CL_MEM_READ_WRITE,
                                  (size_t)capacity * SVO_KEPT_WORDS * sizeof(cl_uint), &list->values));
    if (svo_i_moving_has_areas(moving)) {
        SVO_I_TRY(svo_i_device_buffer(moving->device, function, "pair_areas", CL_MEM_READ_WRITE,
                                      (size_t)capacity * SVO_KEPT_AREA_WORDS * sizeof(cl_uint), &list->areas));
    }
    return needs_materials(moving) ? svo_i_device_buffer(moving->device, function, "pair_materials", CL_MEM_READ_WRITE,
                                                         (size_t)capacity * sizeof(cl_uint), &list->materials)
                                   : SVO_OK;
}

/* Makes buffers of a list with room for so many pairs, at least one. */
static svo_status alloc_list(const svo_moving *moving, const char *function, uint64_t capacity, svo_i_kept_list *out)
{
    svo_status status = SVO_OK;
    svo_i_kept_list made = {.capacity = capacity};
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(moving->device, function, "fragments", CL_MEM_READ_WRITE,
                                          (size_t)capacity * svo_i_plan_fragment_bytes(&moving->whole),
                                          &made.fragments));
    SVO_I_TRY_CLEANUP(alloc_values(moving, function, capacity, &made));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(moving->device, function, "pair_marks", CL_MEM_READ_WRITE,
                                          (size_t)count_marks(capacity) * sizeof(cl_uint), &made.marks));
    *out = made;
    return SVO_OK;
cleanup:
    svo_i_kept_list_free(&made);
    return status;
}

/* ---- voxelization ---- */

/* Takes the sorted list out of a build, which would release it. */
static void take_list(svo_i_build *build, svo_i_kept_list *out)
{
    out->fragments = build->list.chunks[0].buffer;
    out->count = build->fragment_count;
    out->capacity = build->fragment_count;
    build->list.chunks[0].buffer = NULL;
}

void svo_i_moving_remember(svo_i_moving_object *object, uint64_t fragments)
{
    uint64_t *capacity = &object->plan->options.fragment_capacity;
    const uint64_t wanted = fragments + fragments / 8 + 1024;
    const uint64_t room = wanted < SVO_I_FRAGMENTS_MAX ? wanted : SVO_I_FRAGMENTS_MAX;
    *capacity = *capacity > room ? *capacity : room;
}

/* Drops pairs by their alpha, by the arrays that the object's plan and the scene have on the device. */
static svo_status drop_pairs(const svo_moving *moving, svo_i_build *build)
{
    const svo_plan *plan = build->commands.plan;
    const svo_i_plan_memory *memory = &plan->memory;
    if (!plan->work.drop) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_build_get_program(build, SVO_I_BUILD, &svo_i_program_drop, NULL));
    build->surface = (svo_i_surface){.vertices = memory->vertices,
                                     .indices = memory->indices,
                                     .remainders = memory->remainders,
                                     .records = memory->records,
                                     .colors = memory->colors,
                                     .uvs = memory->uvs,
                                     .materials = moving->materials,
                                     .texels = moving->texels};
    const svo_status status = svo_i_drop(build);
    build->surface = (svo_i_surface){0};
    return status;
}

/* The one chunk of a list whose count stays on the device. */
static svo_status make_chunk(const svo_moving *moving, svo_i_build *build, svo_i_chunking *chunking)
{
    svo_device *device = moving->device;
    const svo_plan *plan = build->commands.plan;
    SVO_I_TRY(svo_i_chunking_create(plan, svo_i_chunk_bytes_max(plan, build->frontend->chunk_bytes_max), chunking));
    if (chunking->chunk_count != 1) {
        return svo_i_device_fail(device, SVO_UNSUPPORTED,
                                 "svo_moving_update: the pairs of an object do not fit one buffer of the "
                                 "device");
    }
    build->list.chunks = svo_i_alloc_zeroed(&device->memory, 1, sizeof *build->list.chunks);
    if (build->list.chunks == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_moving_update: no memory for a list");
    }
    build->list.chunk_count = 1;
    build->fragment_count = chunking->chunks[0].capacity;
    return SVO_OK;
}

/* Draws the list with the room that there is. The device counts, and fills up the room. */
static svo_status draw_later(svo_moving *moving, svo_i_build *build, svo_i_pair_count *later, svo_i_kept_list *out)
{
    svo_status status = SVO_OK;
    svo_i_commands *commands = &build->commands;
    svo_i_chunking chunking = {0};
    cl_program program = NULL;
    SVO_I_TRY_CLEANUP(svo_i_moving_program(moving, "svo_moving_update", &program));
    SVO_I_TRY_CLEANUP(make_chunk(moving, build, &chunking));
    SVO_I_TRY_CLEANUP(svo_i_frontend_voxelize(build->frontend, commands, &chunking, &build->list));
    SVO_I_TRY_CLEANUP(drop_pairs(moving, build));
    SVO_I_TRY_CLEANUP(svo_i_device_buffer(moving->device, "svo_moving_update", "pair_count", CL_MEM_READ_WRITE,
                                          sizeof(cl_uint), &out->counted));
    const svo_moving_params params = {.count = (cl_uint)build->fragment_count};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(build->list.counters),
                                        SVO_I_ARGUMENT(build->list.chunks[0].buffer), SVO_I_ARGUMENT(out->counted),
                                        SVO_I_ARGUMENT(params)};
    later->capacity = build->fragment_count;
    SVO_I_TRY_CLEANUP(svo_i_commands_read(commands, build->list.counters, later->words, sizeof later->words));
    SVO_I_TRY_CLEANUP(
        svo_i_commands_run(commands, program, "svo_k_moving_take", SVO_I_ARGUMENTS(arguments), params.count));
cleanup:
    svo_i_chunking_destroy(&chunking);
    return status;
}

static svo_status draw(svo_moving *moving, uint32_t index, svo_i_build *build)
{
    SVO_I_TRY(svo_i_list_make(build));
    svo_i_moving_remember(&moving->objects[index], build->fragment_count);
    return drop_pairs(moving, build);
}

svo_status svo_i_moving_voxelize(svo_moving *moving, uint32_t index, svo_i_chain *chain, svo_i_pair_count *later,
                                 svo_i_kept_list *out)
{
    svo_plan *plan = moving->objects[index].plan;
    svo_status status = SVO_OK;
    svo_build_report report = {0};
    svo_i_build build = {.commands = svo_i_chain_begin_commands(chain, plan, &report), .frontend = moving->frontend};
    svo_i_plan_buffers_reset(plan);
    SVO_I_TRY_CLEANUP(svo_i_build_get_program(&build, SVO_I_BUILD, &svo_i_program_sort, NULL));
    SVO_I_TRY_CLEANUP(chain->waits ? draw(moving, index, &build) : draw_later(moving, &build, later, out));
    SVO_I_TRY_CLEANUP(svo_i_sort(&build));
    SVO_I_TRY_CLEANUP(svo_i_commands_wait(&build.commands));
    take_list(&build, out);
cleanup:
    svo_i_chain_end_commands(chain, &build.commands, status);
    svo_i_order_release_scratch(&build);
    return status;
}

/* ---- weights ---- */

static svo_status launch_weigh(const svo_moving *moving, uint32_t index, svo_i_device_work *work,
                               const svo_i_kept_list *list)
{
    const svo_plan *plan = moving->objects[index].plan;
    const svo_i_plan_memory *memory = &plan->memory;
    const svo_filter_params filter = {
        .depth = plan->info.depth, .voxel_log2 = plan->voxel_log2, .weight_log2 = plan->weight_log2};
    const svo_moving_params params = {.count = (cl_uint)list->count, .object = index};
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(list->fragments), SVO_I_ARGUMENT(memory->vertices), SVO_I_ARGUMENT(memory->remainders),
        SVO_I_ARGUMENT(memory->indices), SVO_I_ARGUMENT(memory->records),  SVO_I_ARGUMENT(memory->colors),
        SVO_I_ARGUMENT(memory->normals), SVO_I_ARGUMENT(memory->uvs),      SVO_I_ARGUMENT(moving->materials),
        SVO_I_ARGUMENT(moving->texels),  SVO_I_ARGUMENT(list->values),     SVO_I_ARGUMENT(list->materials),
        SVO_I_ARGUMENT(list->counted),   SVO_I_ARGUMENT(filter),           SVO_I_ARGUMENT(params),
        SVO_I_ARGUMENT(list->areas)};
    const cl_uint count = (cl_uint)(sizeof arguments / sizeof arguments[0]) - (list->areas != NULL ? 0 : 1);
    const uint64_t per_item = plan->work.pair_lanes ? SVO_GROUP_ITEMS : 1;
    return svo_i_work_launch(work, "svo_k_moving_weigh", arguments, count, (list->count + per_item - 1) / per_item);
}

svo_status svo_i_moving_weigh(svo_moving *moving, uint32_t index, svo_i_chain *chain, svo_i_kept_list *list)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    SVO_I_TRY(begin_work(chain, moving, &work));
    SVO_I_TRY_CLEANUP(alloc_values(moving, chain->function, list->count, list));
    SVO_I_TRY_CLEANUP(launch_weigh(moving, index, &work, list));
cleanup:
    return end_work(chain, &work, status);
}

/* ---- merging ---- */

/* What is left out of the first of two lists. */
typedef struct dropped_objects {
    cl_mem bits; /* one for each object */
    cl_uint marks; /* a bit for each object, modulo 32, that may have pairs in the list */
} dropped_objects;

/* Writes the pairs of both lists to one that has room for them, and its marks. */
static svo_status launch_merge(svo_i_device_work *work, const svo_i_kept_list *a, const svo_i_kept_list *b,
                               const dropped_objects *dropped, const svo_i_kept_list *to)
{
    const uint64_t strips = (a->count + b->count + SVO_MERGE_STRIP - 1) / SVO_MERGE_STRIP;
    const svo_moving_params params = {
        .count = (cl_uint)a->count, .other_count = (cl_uint)b->count, .object = dropped->marks};
    cl_mem counts = NULL;
    cl_mem before = NULL;
    SVO_I_TRY(svo_i_work_alloc(work, "strip_counts", strips * sizeof(cl_uint), &counts));
    SVO_I_TRY(svo_i_work_alloc(work, "strip_begins", (strips + 1) * sizeof(cl_uint), &before));
    const svo_i_argument count[] = {SVO_I_ARGUMENT(a->fragments), SVO_I_ARGUMENT(a->values),
                                    SVO_I_ARGUMENT(a->marks),     SVO_I_ARGUMENT(b->fragments),
                                    SVO_I_ARGUMENT(b->values),    SVO_I_ARGUMENT(a->counted),
                                    SVO_I_ARGUMENT(b->counted),   SVO_I_ARGUMENT(dropped->bits),
                                    SVO_I_ARGUMENT(counts),       SVO_I_ARGUMENT(params)};
    const svo_i_argument write[] = {
        SVO_I_ARGUMENT(a->fragments),  SVO_I_ARGUMENT(a->values),     SVO_I_ARGUMENT(a->materials),
        SVO_I_ARGUMENT(b->fragments),  SVO_I_ARGUMENT(b->values),     SVO_I_ARGUMENT(b->materials),
        SVO_I_ARGUMENT(a->counted),    SVO_I_ARGUMENT(b->counted),    SVO_I_ARGUMENT(dropped->bits),
        SVO_I_ARGUMENT(before),        SVO_I_ARGUMENT(to->fragments), SVO_I_ARGUMENT(to->values),
        SVO_I_ARGUMENT(to->materials), SVO_I_ARGUMENT(to->marks),     SVO_I_ARGUMENT(params),
        SVO_I_ARGUMENT(a->areas),      SVO_I_ARGUMENT(b->areas),      SVO_I_ARGUMENT(to->areas)};
    const cl_uint write_count = (cl_uint)(sizeof write / sizeof write[0]) - (to->areas != NULL ? 0 : 3);
    SVO_I_TRY(svo_i_work_fill_zero(work, to->marks, count_marks(to->count) * sizeof(cl_uint)));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_merge_count", SVO_I_ARGUMENTS(count), strips));
    SVO_I_TRY(svo_i_work_scan(work, counts, before, strips));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_merge_write", write, write_count, strips));
    return to->counted != NULL
               ? svo_i_work_copy(work, before, strips * sizeof(cl_uint), to->counted, 0, sizeof(cl_uint))
               : SVO_OK;
}

/* The number of pairs that a merge is about to write: the device counts it where it counts those of a list. */
static svo_status set_count(svo_i_device_work *work, const svo_i_kept_list *from, uint64_t count, svo_i_kept_list *to)
{
    to->count = count;
    return from->counted != NULL ? svo_i_work_result(work, "pair_count", sizeof(cl_uint), &to->counted) : SVO_OK;
}

/* drops: the objects whose pairs in the scene's list do not stay; else none. */
static svo_status find_dropped(const svo_moving *moving, const svo_i_chain *chain, bool drops, dropped_objects *out)
{
    uint32_t *bits = svo_i_alloc_zeroed(&moving->device->memory, DROPPED_BYTES / sizeof *bits, sizeof *bits);
    if (bits == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the objects",
                                 chain->function);
    }
    for (uint32_t i = 0; drops && i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        const uint32_t bit = object->listed && !svo_i_moving_stays(object) ? 1u << (i % 32) : 0u;
        bits[i / 32] |= bit;
        out->marks |= bit;
    }
    const svo_status status =
        svo_i_device_constants(moving->device, chain->function, "dropped", bits, DROPPED_BYTES, &out->bits);
    svo_i_free(bits);
    return status;
}

/* Merges b into a. */
static svo_status merge_two(svo_moving *moving, svo_i_chain *chain, const dropped_objects *dropped, svo_i_kept_list *a,
                            svo_i_kept_list *b)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    svo_i_kept_list both = {.count = 0};
    SVO_I_TRY(begin_work(chain, moving, &work));
    SVO_I_TRY_CLEANUP(alloc_list(moving, chain->function, a->count + b->count, &both));
    SVO_I_TRY_CLEANUP(set_count(&work, a, a->count + b->count, &both));
    SVO_I_TRY_CLEANUP(launch_merge(&work, a, b, dropped, &both));
cleanup:
    status = end_work(chain, &work, status);
    if (status == SVO_OK) {
        svo_i_kept_list_free(b);
        svo_i_kept_list_free(a);
        *a = both;
    } else {
        svo_i_kept_list_free(&both);
    }
    return status;
}

/* Merges lists of different objects into the first; the others are released. */
static svo_status merge_all(svo_moving *moving, svo_i_chain *chain, svo_i_kept_list *lists, uint32_t count)
{
    svo_status status = SVO_OK;
    dropped_objects none = {.bits = NULL};
    if (count < 2) {
        return SVO_OK;
    }
    SVO_I_TRY_CLEANUP(find_dropped(moving, chain, false, &none));
    for (uint32_t reach = 1; reach < count; reach *= 2) {
        for (uint32_t i = 0; i + reach < count; i += 2 * reach) {
            SVO_I_TRY_CLEANUP(merge_two(moving, chain, &none, &lists[i], &lists[i + reach]));
        }
    }
cleanup:
    svo_i_buffer_release(&none.bits);
    return status;
}

/* Makes room in a list for so many pairs, and for an eighth more where it has to grow. A list that was not merged has
   no marks. */
static svo_status make_room(const svo_moving *moving, const char *function, uint64_t fragments, svo_i_kept_list *list)
{
    if (list->capacity >= fragments && list->marks != NULL) {
        return SVO_OK;
    }
    svo_i_kept_list_free(list);
    return alloc_list(moving, function, fragments + fragments / 8 + 1, list);
}

/* Copies the pairs that stay, which are few, so that merging does not pass over all that go. */
static svo_status keep_staying(svo_moving *moving, svo_i_device_work *work, const dropped_objects *dropped,
                               uint64_t staying, svo_i_kept_list *out)
{
    static const svo_i_kept_list none = {.count = 0};
    SVO_I_TRY(alloc_list(moving, work->function, staying > 0 ? staying : 1, out));
    out->count = staying;
    return launch_merge(work, &moving->list, &none, dropped, out);
}

/* Merges the scene's list, without what does not stay, with that of the objects that changed, into to, whose buffers
   are used where they are large enough. */
static svo_status merge_with_scene(svo_moving *moving, svo_i_chain *chain, const svo_i_kept_list *changed,
                                   uint64_t fragments, svo_i_kept_list *to)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    svo_i_kept_list kept = {.count = 0};
    const uint64_t staying = fragments - changed->count;
    dropped_objects dropped = {.bits = NULL};
    SVO_I_TRY(make_room(moving, chain->function, fragments, to));
    SVO_I_TRY(begin_work(chain, moving, &work));
    SVO_I_TRY_CLEANUP(set_count(&work, changed, fragments, to));
    SVO_I_TRY_CLEANUP(find_dropped(moving, chain, true, &dropped));
    if (staying < moving->list.count / 4) {
        SVO_I_TRY_CLEANUP(keep_staying(moving, &work, &dropped, staying, &kept));
        SVO_I_TRY_CLEANUP(launch_merge(&work, &kept, changed, &dropped, to));
    } else {
        SVO_I_TRY_CLEANUP(launch_merge(&work, &moving->list, changed, &dropped, to));
    }
cleanup:
    status = end_work(chain, &work, status);
    svo_i_buffer_release(&dropped.bits);
    svo_i_kept_list_free(&kept);
    return status;
}

svo_status svo_i_moving_merge(svo_moving *moving, svo_i_chain *chain, svo_i_kept_list *changed, uint32_t changed_count,
                              uint64_t fragments, svo_i_kept_list *out)
{
    static const svo_i_kept_list none = {.count = 0};
    SVO_I_TRY(merge_all(moving, chain, changed, changed_count));
    if (changed_count > 0 && changed[0].count == fragments) { /* nothing else stays */
        *out = changed[0];
        changed[0] = none;
        return SVO_OK;
    }
    *out = moving->spare;
    moving->spare = none;
    return merge_with_scene(moving, chain, changed_count > 0 ? &changed[0] : &none, fragments, out);
}
