/* SPDX-License-Identifier: MIT */
/*
 * SVO_FORM_SHARED: the nodes go to the host, become records there (dag_encode.c), and go back; the payload is put in
 * the records' order on the device.
 */
#include "compact/shared.h"
#include "compact/dag.h"
#include "compact/payload.h"
#include "compact/programs.h"
#include "core/device.h"
#include "shared/dag.clh"

/* Everything on the host. */
typedef struct sharing {
    svo_i_device_work *work;
    const svo_i_compact_source *source;
    svo_compact *compact;
    void *arrays[4]; /* of nodes, by svo_i_alloc */
    svo_i_dag_nodes nodes;
    svo_i_dag dag;
    uint32_t *place_of; /* the place of each payload of the source; NULL: none is held */
    uint32_t *origins; /* the other way round */
} sharing;

/* Reads an array into new memory. */
static svo_status read_array(sharing *s, cl_mem from, uint64_t bytes, int index)
{
    s->arrays[index] = svo_i_alloc(&s->work->device->memory, (size_t)bytes);
    if (s->arrays[index] == NULL) {
        return svo_i_device_fail(s->work->device, SVO_OUT_OF_HOST_MEMORY, "%s: nodes on the host need %llu bytes",
                                 s->work->function, (unsigned long long)bytes);
    }
    return svo_i_work_read(s->work, from, 0, s->arrays[index], (size_t)bytes);
}

static svo_status read_nodes(sharing *s)
{
    const svo_i_compact_source *source = s->source;
    const uint64_t inner_count = svo_i_source_level_begin(&source->info, source->info.depth);
    SVO_I_TRY(read_array(s, source->valid, inner_count, 0));
    SVO_I_TRY(read_array(s, source->leaf, inner_count, 1));
    SVO_I_TRY(read_array(s, source->first_inner, inner_count * 4, 2));
    if (svo_i_compact_has_places(&source->info)) {
        SVO_I_TRY(read_array(s, source->first_payload, inner_count * 4, 3));
    }
    s->nodes = (svo_i_dag_nodes){.depth = source->info.depth,
                                 .payload_level = source->info.payload_level,
                                 .valid = s->arrays[0],
                                 .leaf = s->arrays[1],
                                 .first_inner = s->arrays[2],
                                 .first_payload = s->arrays[3],
                                 .payload_begin = source->payload_begin};
    for (uint32_t level = 0; level <= source->info.depth; ++level) {
        s->nodes.level_begin[level] = svo_i_source_level_begin(&source->info, level);
    }
    return SVO_OK;
}

/* Makes the records, and room for the places of payload if some is held. */
static svo_status encode(sharing *s)
{
    const bool places = svo_i_compact_has_places(&s->source->info);
    const size_t payload_count = (size_t)s->compact->info.payload_count;
    if (places) {
        s->place_of = svo_i_alloc(&s->work->device->memory, (payload_count + 1) * sizeof *s->place_of);
        s->origins = svo_i_alloc(&s->work->device->memory, (payload_count + 1) * sizeof *s->origins);
        if (s->place_of == NULL || s->origins == NULL) {
            return svo_i_device_fail(s->work->device, SVO_OUT_OF_HOST_MEMORY,
                                     "%s: places of %zu elements need %zu bytes", s->work->function, payload_count,
                                     2 * payload_count * sizeof *s->place_of);
        }
    }
    SVO_I_TRY(svo_i_dag_encode(s->work->function, &s->nodes, &s->work->device->memory, places, &s->dag, s->place_of,
                               svo_i_device_message(s->work->device)));
    for (size_t i = 0; places && i < payload_count; ++i) {
        s->origins[s->place_of[i]] = (uint32_t)i;
    }
    return SVO_OK;
}

static svo_status put_records(const sharing *s)
{
    svo_compact *compact = s->compact;
    const cl_uint links[2] = {s->dag.depth, s->dag.depth - s->dag.payload_level};
    compact->info.stored_count = s->dag.word_count;
    compact->info.shared_count = s->dag.record_count;
    svo_i_compact_count(&compact->info);
    SVO_I_TRY(svo_i_work_result(s->work, "nodes", compact->info.bytes[SVO_COMPACT_NODES],
                                &compact->buffers[SVO_COMPACT_NODES]));
    SVO_I_TRY(svo_i_work_result(s->work, "links", sizeof links, &compact->buffers[SVO_COMPACT_LINKS]));
    SVO_I_TRY(svo_i_work_write(s->work, compact->buffers[SVO_COMPACT_LINKS], links, sizeof links));
    return svo_i_work_write(s->work, compact->buffers[SVO_COMPACT_NODES], s->dag.words,
                            compact->info.bytes[SVO_COMPACT_NODES]);
}

static svo_status put_payload(const sharing *s)
{
    const uint64_t bytes = s->compact->info.payload_count * sizeof *s->origins;
    cl_mem origins = NULL;
    if (s->origins != NULL) {
        SVO_I_TRY(svo_i_work_alloc(s->work, "payload_origins", bytes, &origins));
        SVO_I_TRY(svo_i_work_write(s->work, origins, s->origins, bytes));
    }
    return svo_i_payload_gather(s->work, s->source, origins, s->compact);
}

static svo_status share(sharing *s)
{
    svo_i_compact_count(&s->compact->info);
    SVO_I_TRY(svo_i_work_use(s->work, &svo_i_program_compact, " -DSVO_SORT"));
    SVO_I_TRY(read_nodes(s));
    SVO_I_TRY(encode(s));
    SVO_I_TRY(put_records(s));
    return put_payload(s);
}

svo_status svo_i_shared_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact)
{
    sharing s = {.work = work, .source = source, .compact = compact};
    const svo_status status = share(&s);
    for (int i = 0; i < 4; ++i) {
        svo_i_free(s.arrays[i]);
    }
    svo_i_free(s.place_of);
    svo_i_free(s.origins);
    svo_i_dag_free(&s.dag);
    return status;
}

void svo_i_shared_count(svo_compact_info *info)
{
    /* A record names each inner child and has a number for each, besides its masks. Above voxels it has a byte for each
       of the two masks and each child, rounded up to words. */
    info->stored_count = 0;
    info->shared_count = 0;
    for (uint32_t level = 0; level + 1 < info->depth; ++level) {
        const uint64_t inner = info->level_inner[level];
        const uint64_t below = info->level_inner[level + 1];
        info->shared_count += inner;
        info->stored_count += level + 2 < info->depth ? inner + 2 * below : (5 * inner + below) / 4;
    }
    if (info->depth == 1) {
        info->stored_count = 1;
        info->shared_count = 1;
    }
}
