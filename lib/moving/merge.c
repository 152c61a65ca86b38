/* SPDX-License-Identifier: MIT */
/* Merges lists of kept pairs by kernels/moving/merge.cl. */
#include "moving/merge.h"

#include "core/work.h"
#include "moving/pairs.h"

/* A bit for each object whose pairs in the scene's list are left out. */
#define DROPPED_BYTES (SVO_I_MOVING_OBJECTS / 8)

static svo_status begin(svo_moving *moving, const char *function, cl_command_queue queue, svo_i_device_work *work)
{
    SVO_I_TRY(svo_i_work_begin(moving->device, function, queue, work));
    return svo_i_moving_program(moving, function, &work->program);
}

/* Writes the pairs of both lists to one that has room for them. dropped: bits of objects that are left out of a. */
static svo_status launch(svo_i_device_work *work, const svo_i_kept_list *a, const svo_i_kept_list *b, cl_mem dropped,
                         const svo_i_kept_list *to)
{
    const uint64_t strips = (a->count + b->count + SVO_MERGE_STRIP - 1) / SVO_MERGE_STRIP;
    const svo_moving_params params = {.count = (cl_uint)a->count, .other_count = (cl_uint)b->count};
    cl_mem counts = NULL;
    cl_mem before = NULL;
    SVO_I_TRY(svo_i_work_alloc(work, "strip_counts", strips * sizeof(cl_uint), &counts));
    SVO_I_TRY(svo_i_work_alloc(work, "strip_begins", (strips + 1) * sizeof(cl_uint), &before));
    const svo_i_argument count[] = {SVO_I_ARGUMENT(a->fragments), SVO_I_ARGUMENT(a->values),
                                    SVO_I_ARGUMENT(b->fragments), SVO_I_ARGUMENT(b->values),
                                    SVO_I_ARGUMENT(dropped),      SVO_I_ARGUMENT(counts),
                                    SVO_I_ARGUMENT(params)};
    const svo_i_argument write[] = {
        SVO_I_ARGUMENT(a->fragments), SVO_I_ARGUMENT(a->values),     SVO_I_ARGUMENT(a->materials),
        SVO_I_ARGUMENT(b->fragments), SVO_I_ARGUMENT(b->values),     SVO_I_ARGUMENT(b->materials),
        SVO_I_ARGUMENT(dropped),      SVO_I_ARGUMENT(before),        SVO_I_ARGUMENT(to->fragments),
        SVO_I_ARGUMENT(to->values),   SVO_I_ARGUMENT(to->materials), SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_merge_count", SVO_I_ARGUMENTS(count), strips));
    SVO_I_TRY(svo_i_work_scan(work, counts, before, strips));
    return svo_i_work_launch(work, "svo_k_merge_write", SVO_I_ARGUMENTS(write), strips);
}

/* ---- several objects ---- */

/* Merges b into a. */
static svo_status merge_two(svo_moving *moving, const char *function, cl_command_queue queue, cl_mem dropped,
                            svo_i_kept_list *a, svo_i_kept_list *b)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    svo_i_kept_list both = {.count = 0};
    SVO_I_TRY(begin(moving, function, queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_kept_list_alloc(moving, function, a->count + b->count, &both));
    both.count = a->count + b->count;
    SVO_I_TRY_CLEANUP(launch(&work, a, b, dropped, &both));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));
    svo_i_kept_list_free(b);
    svo_i_kept_list_free(a);
    *a = both;
    both = (svo_i_kept_list){.count = 0};
cleanup:
    svo_i_work_end(&work);
    svo_i_kept_list_free(&both);
    return status;
}

/* Rounds of merging neighbors: each halves the number of lists. */
static svo_status merge_rounds(svo_moving *moving, const char *function, cl_command_queue queue, cl_mem dropped,
                               svo_i_kept_list *lists, uint32_t count)
{
    for (uint32_t reach = 1; reach < count; reach *= 2) {
        for (uint32_t i = 0; i + reach < count; i += 2 * reach) {
            SVO_I_TRY(merge_two(moving, function, queue, dropped, &lists[i], &lists[i + reach]));
        }
    }
    return SVO_OK;
}

svo_status svo_i_moving_merge_all(svo_moving *moving, const char *function, cl_command_queue queue,
                                  svo_i_kept_list *lists, uint32_t count)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    cl_mem none = NULL;
    if (count < 2) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_begin(moving->device, function, queue, &work));
    SVO_I_TRY_CLEANUP(svo_i_work_alloc(&work, "dropped", DROPPED_BYTES, &none));
    SVO_I_TRY_CLEANUP(svo_i_work_fill_zero(&work, none, DROPPED_BYTES));
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));
    SVO_I_TRY_CLEANUP(merge_rounds(moving, function, queue, none, lists, count));
cleanup:
    svo_i_work_end(&work);
    return status;
}

/* ---- the scene ---- */

static svo_status mark_dropped(const svo_moving *moving, svo_i_device_work *work, cl_mem *out)
{
    svo_status status = SVO_OK;
    uint32_t *bits = svo_i_alloc_zeroed(&moving->device->memory, DROPPED_BYTES / sizeof *bits, sizeof *bits);
    if (bits == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the objects",
                                 work->function);
    }
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        bits[i / 32] |= svo_i_moving_stays(&moving->objects[i]) ? 0u : 1u << (i % 32);
    }
    SVO_I_TRY_CLEANUP(svo_i_work_alloc(work, "dropped", DROPPED_BYTES, out));
    SVO_I_TRY_CLEANUP(svo_i_work_write(work, *out, bits, DROPPED_BYTES));
cleanup:
    svo_i_free(bits);
    return status;
}

/* Makes room in a list for so many pairs, and for an eighth more where it has to grow. */
static svo_status make_room(const svo_moving *moving, const char *function, uint64_t fragments, svo_i_kept_list *list)
{
    if (list->capacity >= fragments && list->capacity > 0) {
        return SVO_OK;
    }
    svo_i_kept_list_free(list);
    return svo_i_kept_list_alloc(moving, function, fragments + fragments / 8 + 1, list);
}

/* Copies the pairs that stay, which are few, so that merging does not pass over all that go. */
static svo_status keep_staying(svo_moving *moving, svo_i_device_work *work, cl_mem dropped, uint64_t staying,
                               svo_i_kept_list *out)
{
    static const svo_i_kept_list none = {.count = 0};
    SVO_I_TRY(svo_i_kept_list_alloc(moving, work->function, staying > 0 ? staying : 1, out));
    out->count = staying;
    return launch(work, &moving->list, &none, dropped, out);
}

svo_status svo_i_moving_merge(svo_moving *moving, const char *function, cl_command_queue queue,
                              const svo_i_kept_list *changed, uint64_t fragments, svo_i_kept_list *to)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    svo_i_kept_list kept = {.count = 0};
    const uint64_t staying = fragments - changed->count;
    cl_mem dropped = NULL;
    SVO_I_TRY(make_room(moving, function, fragments, to));
    to->count = fragments;
    SVO_I_TRY(begin(moving, function, queue, &work));
    SVO_I_TRY_CLEANUP(mark_dropped(moving, &work, &dropped));
    if (staying < moving->list.count / 4) {
        SVO_I_TRY_CLEANUP(keep_staying(moving, &work, dropped, staying, &kept));
        SVO_I_TRY_CLEANUP(launch(&work, &kept, changed, dropped, to));
    } else {
        SVO_I_TRY_CLEANUP(launch(&work, &moving->list, changed, dropped, to));
    }
    SVO_I_TRY_CLEANUP(svo_i_work_wait(&work));
cleanup:
    svo_i_work_end(&work);
    svo_i_kept_list_free(&kept);
    return status;
}
