/* SPDX-License-Identifier: MIT */
/* Merges lists of kept pairs by kernels/moving/merge.cl. */
#include "moving/merge.h"

#include "moving/pairs.h"

/* A bit for each object whose pairs in the scene's list are left out. */
#define DROPPED_BYTES (SVO_I_MOVING_OBJECTS / 8)

/* What is left out of the first of two lists. */
typedef struct dropped_objects {
    cl_mem bits; /* one for each object */
    cl_uint marks; /* a bit for each object, modulo 32, that may have pairs in the list */
} dropped_objects;

/* Writes the pairs of both lists to one that has room for them, and its marks. */
static svo_status launch(svo_i_device_work *work, const svo_i_kept_list *a, const svo_i_kept_list *b,
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
    SVO_I_TRY(svo_i_work_fill_zero(work, to->marks, svo_i_kept_list_marks(to->count) * sizeof(cl_uint)));
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

/* ---- several objects ---- */

/* Merges b into a. */
static svo_status merge_two(svo_moving *moving, svo_i_chain *chain, const dropped_objects *dropped, svo_i_kept_list *a,
                            svo_i_kept_list *b)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    svo_i_kept_list both = {.count = 0};
    SVO_I_TRY(svo_i_chain_begin(chain, moving, &work));
    SVO_I_TRY_CLEANUP(svo_i_kept_list_alloc(moving, chain->function, a->count + b->count, &both));
    SVO_I_TRY_CLEANUP(set_count(&work, a, a->count + b->count, &both));
    SVO_I_TRY_CLEANUP(launch(&work, a, b, dropped, &both));
cleanup:
    status = svo_i_chain_end(chain, &work, status);
    if (status == SVO_OK) {
        svo_i_kept_list_free(b);
        svo_i_kept_list_free(a);
        *a = both;
    } else {
        svo_i_kept_list_free(&both);
    }
    return status;
}

svo_status svo_i_moving_merge_all(svo_moving *moving, svo_i_chain *chain, svo_i_kept_list *lists, uint32_t count)
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

/* ---- the scene ---- */

/* Makes room in a list for so many pairs, and for an eighth more where it has to grow. A list that was not merged has
   no marks. */
static svo_status make_room(const svo_moving *moving, const char *function, uint64_t fragments, svo_i_kept_list *list)
{
    if (list->capacity >= fragments && list->marks != NULL) {
        return SVO_OK;
    }
    svo_i_kept_list_free(list);
    return svo_i_kept_list_alloc(moving, function, fragments + fragments / 8 + 1, list);
}

/* Copies the pairs that stay, which are few, so that merging does not pass over all that go. */
static svo_status keep_staying(svo_moving *moving, svo_i_device_work *work, const dropped_objects *dropped,
                               uint64_t staying, svo_i_kept_list *out)
{
    static const svo_i_kept_list none = {.count = 0};
    SVO_I_TRY(svo_i_kept_list_alloc(moving, work->function, staying > 0 ? staying : 1, out));
    out->count = staying;
    return launch(work, &moving->list, &none, dropped, out);
}

svo_status svo_i_moving_merge(svo_moving *moving, svo_i_chain *chain, const svo_i_kept_list *changed,
                              uint64_t fragments, svo_i_kept_list *to)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    svo_i_kept_list kept = {.count = 0};
    const uint64_t staying = fragments - changed->count;
    dropped_objects dropped = {.bits = NULL};
    SVO_I_TRY(make_room(moving, chain->function, fragments, to));
    SVO_I_TRY(svo_i_chain_begin(chain, moving, &work));
    SVO_I_TRY_CLEANUP(set_count(&work, changed, fragments, to));
    SVO_I_TRY_CLEANUP(find_dropped(moving, chain, true, &dropped));
    if (staying < moving->list.count / 4) {
        SVO_I_TRY_CLEANUP(keep_staying(moving, &work, &dropped, staying, &kept));
        SVO_I_TRY_CLEANUP(launch(&work, &kept, changed, &dropped, to));
    } else {
        SVO_I_TRY_CLEANUP(launch(&work, &moving->list, changed, &dropped, to));
    }
cleanup:
    status = svo_i_chain_end(chain, &work, status);
    svo_i_buffer_release(&dropped.bits);
    svo_i_kept_list_free(&kept);
    return status;
}
