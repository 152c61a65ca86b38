/* SPDX-License-Identifier: MIT */
/*
 * The plan's list of buffers: kept while a build allocates, and predicted before it by a build that only measures, with
 * the plan's capacities in place of counts.
 */
#include <stdlib.h>
#include <string.h>

#include "build/build.h"

void svo_i_plan_buffers_reset(svo_plan *plan)
{
    plan->buffer_count = 0;
    plan->live_bytes = 0;
    plan->peak_bytes = 0;
}

/* Lists of more chunks are predicted as if they had so many. */
#define CHUNKS_MAX 32

/* What the bytes of a buffer follow from, and whether it stays. */
typedef enum basis { OF_MESH, OF_FRAGMENTS, OF_LEAVES, OF_NODES } basis;

static const struct buffer_kind {
    const char *name;
    basis follows;
    bool persistent; /* in the tree */
} kinds[] = {
    {"mesh_vertices", OF_MESH, false},
    {"mesh_indices", OF_MESH, false},
    {"mesh_items", OF_MESH, false},
    {"mesh_tiles", OF_NODES, false}, /* about as many as the large triangles have columns */
    {"counters", OF_MESH, false},
    {"fragments", OF_FRAGMENTS, false},
    {"cursors", OF_FRAGMENTS, false},
    {"state", OF_MESH, false},
    {"partials", OF_MESH, false},
    {"child_mask_pool", OF_NODES, false},
    {"first_child_pool", OF_NODES, false},
    {"child_mask", OF_NODES, true},
    {"first_child", OF_NODES, true},
    {"sorted", OF_FRAGMENTS, false},
    {"sort_counts", OF_MESH, false},
    {"level_counts", OF_MESH, false},
    {"begin_flags", OF_FRAGMENTS, false},
    {"level_codes", OF_NODES, false},
    {"vertices", OF_MESH, true},
    {"indices", OF_MESH, true},
    {"triangle_ids", OF_MESH, true},
    {"list_begin", OF_LEAVES, true},
    {"list_counts", OF_LEAVES, false},
    {"list", OF_FRAGMENTS, true},
    {"list_spare", OF_FRAGMENTS, false},
    {"long_leaves", OF_FRAGMENTS, false},
    {"records", OF_MESH, false},
    {"vertex_colors", OF_MESH, false},
    {"vertex_normals", OF_MESH, false},
    {"uvs", OF_MESH, false},
    {"material_records", OF_MESH, false},
    {"texels", OF_MESH, false},
    {"entry_counts", OF_NODES, false},
    {"entry_begins", OF_NODES, false},
    {"entries", OF_FRAGMENTS, false},
    {"heads", OF_LEAVES, false},
    {"weights", OF_NODES, false},
    {"color_sums", OF_NODES, false},
    {"normal_sums", OF_NODES, false},
    {"colors", OF_NODES, true},
    {"normals", OF_NODES, true},
    {"materials", OF_NODES, true},
    {"fills", OF_NODES, true},
};

static const struct buffer_kind *kind_of(const char *name)
{
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        if (strcmp(kinds[i].name, name) == 0) {
            return &kinds[i];
        }
    }
    return NULL;
}

/* Geometry, and where lists begin, stay where the lists do. */
static bool persistent(const svo_plan *plan, const struct buffer_kind *kind)
{
    return kind->persistent && (kind->follows == OF_NODES || plan->work.lists);
}

static svo_certainty certainty_of(const svo_plan *plan, const struct buffer_kind *kind, uint64_t bytes)
{
    const bool one_value = kind->persistent && kind->follows == OF_NODES && bytes <= 6;
    if (kind->follows == OF_MESH || one_value || plan->built) {
        return SVO_BYTES_EXACT;
    }
    if (!plan->counted || kind->follows == OF_NODES) {
        return SVO_BYTES_ESTIMATE;
    }
    return kind->follows == OF_FRAGMENTS ? SVO_BYTES_EXACT : SVO_BYTES_BOUND;
}

void svo_i_plan_buffer_add(svo_plan *plan, const char *name, uint64_t bytes)
{
    plan->live_bytes += bytes;
    plan->peak_bytes = plan->live_bytes > plan->peak_bytes ? plan->live_bytes : plan->peak_bytes;
    for (size_t i = 0; i < plan->buffer_count; ++i) {
        if (strcmp(plan->buffers[i].name, name) == 0) {
            plan->buffers[i].bytes += bytes;
            ++plan->buffers[i].count;
            return;
        }
    }
    const struct buffer_kind *kind = kind_of(name);
    if (plan->buffer_count < SVO_I_BUFFERS_MAX) {
        svo_buffer_info *buffer = &plan->buffers[plan->buffer_count++];
        *buffer = (svo_buffer_info){.name = name, .bytes = bytes, .count = 1};
        buffer->certainty = kind != NULL ? certainty_of(plan, kind, bytes) : SVO_BYTES_ESTIMATE;
        buffer->persistent = kind != NULL && persistent(plan, kind);
    }
}

void svo_i_plan_buffer_remove(svo_plan *plan, uint64_t bytes)
{
    plan->live_bytes -= bytes;
}

/* So many chunks of the same size, for a list that would be cut into many more: cutting it in earnest takes time and
   memory that a plan should not. */
static svo_status lay_out_roughly(const svo_plan *plan, svo_i_layout *layout)
{
    const uint64_t fragments = svo_i_with_slack(svo_i_plan_expected(plan, plan->info.depth));
    *layout = (svo_i_layout){.chunks = calloc(CHUNKS_MAX, sizeof *layout->chunks), .chunk_count = CHUNKS_MAX};
    for (uint32_t i = 0; layout->chunks != NULL && i < CHUNKS_MAX; ++i) {
        layout->chunks[i].capacity = fragments / CHUNKS_MAX + 1;
    }
    return layout->chunks != NULL
               ? SVO_OK
               : svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "svo_plan_create: no memory to predict sizes");
}

static svo_status lay_out(const svo_plan *plan, svo_i_layout *layout)
{
    const uint64_t asked = plan->options.chunk_bytes;
    const uint64_t most = plan->device->max_allocation_bytes;
    const uint64_t chunk_bytes = asked != 0 && asked < most ? asked : most;
    const double chunks =
        svo_i_plan_expected(plan, plan->info.depth) * svo_i_plan_fragment_bytes(plan) / (double)chunk_bytes;
    return chunks < CHUNKS_MAX ? svo_i_layout_create(plan, chunk_bytes, layout) : lay_out_roughly(plan, layout);
}

svo_status svo_i_plan_predict(svo_plan *plan)
{
    svo_i_layout layout = {0};
    svo_status status = lay_out(plan, &layout);
    if (status != SVO_OK) {
        return status;
    }
    status = svo_i_build_measure(plan, NULL, &layout, NULL, NULL);
    svo_i_layout_destroy(&layout);
    plan->predicted_bytes = plan->peak_bytes;
    return status;
}
