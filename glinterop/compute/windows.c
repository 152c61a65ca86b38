/* SPDX-License-Identifier: MIT */
/*
 * Windows for launches whose arrays exceed a storage block: consecutive nodes or leaves, found by reading the offsets
 * of their elements where the window may end; and exclusive sums, window by window.
 */
#include "compute/windows.h"

#include "core/message.h"

svo_i_offsets svo_i_gl_list_offsets(const svo_i_gl_build *gl_build)
{
    const svo_i_build *build = gl_build->build;
    return (svo_i_offsets){.buffer = gl_build->arrays[SVO_TREE_LIST_BEGIN],
                           .count = (uint32_t)build->tree->info.leaf_count,
                           .end = (uint32_t)build->fragment_count};
}

svo_i_offsets svo_i_gl_child_offsets(const svo_i_gl_build *gl_build, uint32_t level)
{
    const svo_tree_info *info = &gl_build->build->tree->info;
    const uint32_t begin = info->level_begin[level];
    const uint32_t child_begin = info->level_begin[level + 1];
    const uint64_t child_end = level + 2 <= info->depth ? info->level_begin[level + 2] : info->node_count;
    return (svo_i_offsets){.buffer = gl_build->arrays[SVO_TREE_FIRST_CHILD],
                           .first = begin,
                           .subtracted = child_begin,
                           .count = child_begin - begin,
                           .end = (uint32_t)(child_end - child_begin)};
}

svo_status svo_i_gl_offset(svo_i_gl_build *gl_build, const svo_i_offsets *offsets, uint32_t item, uint32_t *out)
{
    svo_i_compute *compute = gl_build->compute;
    *out = offsets->end;
    if (item < offsets->count) {
        SVO_I_TRY(svo_i_compute_read_at(compute, offsets->buffer, (offsets->first + item) * 4, out, 4));
        *out -= offsets->subtracted;
        if (offsets->through != 0) {
            SVO_I_TRY(svo_i_compute_read_at(compute, offsets->through, *out * UINT64_C(4), out, 4));
        }
    }
    return SVO_OK;
}

/* Grows the window, which is empty, by powers of two items from large to small. */
static svo_status grow_window(svo_i_gl_build *gl_build, const svo_i_offsets *offsets, uint64_t most_items,
                              uint64_t most_elements, svo_i_window *window)
{
    for (uint32_t reach = 0x80000000u; reach != 0; reach >>= 1) {
        const uint64_t end = (uint64_t)window->end + reach;
        uint32_t last = 0;
        if (end > offsets->count || end - window->begin > most_items) {
            continue;
        }
        SVO_I_TRY(svo_i_gl_offset(gl_build, offsets, (uint32_t)end, &last));
        if (last - window->first <= most_elements) {
            window->end = (uint32_t)end;
            window->last = last;
        }
    }
    return SVO_OK;
}

svo_status svo_i_gl_window(svo_i_gl_build *gl_build, const svo_i_offsets *offsets, uint32_t begin, uint64_t most_items,
                           uint64_t most_elements, const char *what, svo_i_window *out)
{
    const svo_i_gl_functions *gl = gl_build->compute->gl;
    *out = (svo_i_window){.begin = begin, .end = begin};
    if (begin == 0 && offsets->count <= most_items && offsets->end <= most_elements) {
        *out = (svo_i_window){.end = offsets->count, .last = offsets->end};
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_gl_offset(gl_build, offsets, begin, &out->first));
    SVO_I_TRY(grow_window(gl_build, offsets, most_items, most_elements, out));
    if (out->end == begin) {
        return svo_i_device_fail(gl_build->compute->device, SVO_UNSUPPORTED,
                                 SVO_I_GL_BUILD ": a node has more than %llu %s, above the storage block limit of %lld "
                                                "bytes of %s",
                                 (unsigned long long)most_elements, what, (long long)gl->limits.storage_block_bytes,
                                 gl->renderer);
    }
    return SVO_OK;
}

/* ---- exclusive sums ---- */

/* Items of a window with a word each, and one more. */
static uint32_t scan_window(const svo_i_compute *compute, uint32_t left)
{
    const uint64_t most = svo_i_compute_range_max(compute) / 4 - 1;
    return left < most ? left : (uint32_t)most;
}

static svo_status scan_one(svo_i_gl_build *gl_build, GLuint counts, GLuint begins, uint32_t begin, uint32_t count)
{
    const uint64_t items = (uint64_t)SVO_SCAN_GROUPS * SVO_GROUP_ITEMS;
    const svo_i_range read = svo_i_range_of(begin, (uint64_t)begin + count, 4);
    const svo_i_range written = svo_i_range_of(begin, (uint64_t)begin + count + 1, 4);
    svo_i_launch launches[] = {{.entry = SVO_I_ENTRY_SCAN_LISTS_REDUCE,
                                .buffers = {counts, gl_build->partials},
                                .ranges = {read},
                                .items = items},
                               {.entry = SVO_I_ENTRY_SCAN_LISTS_PARTIALS,
                                .buffers = {gl_build->partials, begins},
                                .ranges = {[1] = written},
                                .items = SVO_GROUP_ITEMS},
                               {.entry = SVO_I_ENTRY_SCAN_LISTS_ADD,
                                .buffers = {counts, gl_build->partials, begins},
                                .ranges = {read, [2] = written},
                                .items = items}};
    for (unsigned i = 0; i < 3; ++i) {
        launches[i].window_begin = begin;
        launches[i].window_count = count;
        SVO_I_TRY(svo_i_compute_launch(gl_build->compute, &launches[i]));
    }
    return SVO_OK;
}

svo_status svo_i_gl_scan(svo_i_gl_build *gl_build, GLuint counts, GLuint begins, uint32_t count)
{
    uint32_t begin = 0;
    do {
        const uint32_t size = scan_window(gl_build->compute, count - begin);
        SVO_I_TRY(scan_one(gl_build, counts, begins, begin, size));
        begin += size;
    } while (begin < count);
    return SVO_OK;
}
