/* SPDX-License-Identifier: MIT */
/* The forms of compact trees: how each makes nodes and puts payload in its order. Kernels: kernels/compact. */
#include "compact/form.h"

#include <string.h>

#include "compact/dag.h"
#include "compact/programs.h"
#include "core/device.h"
#include "core/tree.h"
#include "shared/dag.clh"
#include "shared/descriptor.h"
#include "shared/layout.h"

#define CL12    "-cl-std=CL1.2"
#define IMPLIED " -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2="
#define PLACES  " -DSVO_HAS_BASES"
#define WORDS   " -DSVO_READ_DESCRIPTOR"
#define SHARED  " -DSVO_READ_SHARED"
#define MIRROR  " -DSVO_READ_MIRRORED"

/* ---- payload: kernels/compact/payload.cl ---- */

/* The first inner node whose children have payload. */
static uint32_t payload_parents(const svo_compact_info *info)
{
    return info->payload_level > 0 ? svo_i_source_level_begin(info, info->payload_level - 1) : 0;
}

static svo_compact_params payload_params(const svo_i_compact_source *source)
{
    const svo_compact_info *info = &source->info;
    return (svo_compact_params){.node_count = svo_i_source_level_begin(info, info->depth),
                                .payload_parents = payload_parents(info),
                                .payload_begin = source->payload_begin,
                                .root_payload = info->payload_level == 0};
}

/* Makes bases beside the words of the nodes buffer. places: u32 per inner node of the source, the index of its word.
   *targets: u32 per inner node, where its children's payload goes; scratch. Does nothing where there are no places.
   compact->info: complete. */
static svo_status make_word_bases(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem places,
                                  svo_compact *compact, cl_mem *targets)
{
    const svo_compact_params params = payload_params(source);
    const uint64_t word_count = compact->info.stored_count;
    cl_mem *bases = &compact->buffers[SVO_COMPACT_BASES];
    cl_mem counts = NULL;
    cl_mem sums = NULL;
    if (!svo_i_compact_has_places(&compact->info)) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_alloc(work, "payload_counts", word_count * 4, &counts));
    SVO_I_TRY(svo_i_work_alloc(work, "payload_sums", (word_count + 1) * 4, &sums));
    SVO_I_TRY(svo_i_work_alloc(work, "payload_targets", params.node_count * UINT64_C(4), targets));
    SVO_I_TRY(svo_i_work_result(work, "bases", word_count * 4, bases));
    SVO_I_TRY(svo_i_work_fill_zero(work, counts, word_count * 4));
    SVO_I_TRY(svo_i_work_fill_zero(work, *bases, word_count * 4));
    const svo_i_argument count[] = {SVO_I_ARGUMENT(source->valid), SVO_I_ARGUMENT(places), SVO_I_ARGUMENT(counts),
                                    SVO_I_ARGUMENT(params)};
    const svo_i_argument base[] = {SVO_I_ARGUMENT(places), SVO_I_ARGUMENT(sums), SVO_I_ARGUMENT(*bases),
                                   SVO_I_ARGUMENT(*targets), SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_compact_counts", SVO_I_ARGUMENTS(count), params.node_count));
    SVO_I_TRY(svo_i_work_scan(work, counts, sums, word_count));
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_compact_bases", SVO_I_ARGUMENTS(base), params.node_count));
    svo_i_work_free(work, &counts);
    svo_i_work_free(work, &sums);
    return SVO_OK;
}

/* Makes the buffer of a payload array; one that is constant gets its element. Other arrays are filled by the caller. */
static svo_status make_payload_array(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact,
                                     svo_compact_buffer buffer, bool *fill)
{
    cl_mem *to = &compact->buffers[buffer];
    const cl_mem from = source->payload[buffer - SVO_I_PAYLOAD_FIRST];
    const uint64_t bytes = compact->info.bytes[buffer];
    *fill = false;
    if (bytes == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(work, svo_name(SVO_NAME_COMPACT_BUFFER, buffer), bytes, to));
    if (svo_i_compact_is_constant(&compact->info, buffer)) {
        return svo_i_work_copy(work, from, 0, *to, 0, bytes);
    }
    *fill = true;
    return SVO_OK;
}

static svo_status reorder(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem targets,
                          const svo_compact *compact, svo_compact_buffer buffer)
{
    svo_compact_params params = payload_params(source);
    params.element_halves = (cl_uint)(svo_i_compact_element_bytes(&compact->info, buffer) / 2);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(source->valid),
                                        SVO_I_ARGUMENT(source->first_payload),
                                        SVO_I_ARGUMENT(targets),
                                        SVO_I_ARGUMENT(source->payload[buffer - SVO_I_PAYLOAD_FIRST]),
                                        SVO_I_ARGUMENT(compact->buffers[buffer]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_compact_payload", SVO_I_ARGUMENTS(arguments), params.node_count);
}

/* Makes all payload arrays. targets: NULL where there are no places. */
static svo_status make_payload(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem targets,
                               svo_compact *compact)
{
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        bool fill = false;
        SVO_I_TRY(make_payload_array(work, source, compact, (svo_compact_buffer)i, &fill));
        if (fill) {
            SVO_I_TRY(reorder(work, source, targets, compact, (svo_compact_buffer)i));
        }
    }
    return SVO_OK;
}

/* The same for any order. origins: u32 per payload of the compact tree, its index among those of the source; NULL where
   there are no places. */
static svo_status gather_payload(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem origins,
                                 svo_compact *compact)
{
    svo_compact_params params = {.node_count = (cl_uint)compact->info.payload_count};
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const svo_compact_buffer buffer = (svo_compact_buffer)i;
        bool fill = false;
        SVO_I_TRY(make_payload_array(work, source, compact, buffer, &fill));
        if (!fill) {
            continue;
        }
        params.element_halves = (cl_uint)(svo_i_compact_element_bytes(&compact->info, buffer) / 2);
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(origins),
                                            SVO_I_ARGUMENT(source->payload[i - SVO_I_PAYLOAD_FIRST]),
                                            SVO_I_ARGUMENT(compact->buffers[i]), SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(work, "svo_k_compact_gather", SVO_I_ARGUMENTS(arguments), params.node_count));
    }
    return SVO_OK;
}

/* ---- SVO_FORM_DESCRIPTOR: words in an order of short distances ---- */

/* Sizes of subtrees bottom-up, places top-down, words. */

/* What the stages hand on: an element per inner node. */
typedef struct words {
    svo_i_device_work *work;
    const svo_i_compact_source *source;
    cl_mem sizes; /* u32: words of its descendants */
    cl_mem far; /* u8: those of its inner children that have far words */
    cl_mem places; /* u32: of its word */
    cl_mem groups; /* u32: the first word of its inner children */
} words;

static svo_compact_params level_params(const svo_i_compact_source *source, uint32_t level)
{
    return (svo_compact_params){.first_node = svo_i_source_level_begin(&source->info, level),
                                .node_count = source->info.level_inner[level]};
}

static svo_status find_sizes(const words *w)
{
    for (uint32_t level = w->source->info.depth; level-- > 0;) {
        const svo_compact_params params = level_params(w->source, level);
        const svo_i_argument arguments[] = {
            SVO_I_ARGUMENT(w->source->valid), SVO_I_ARGUMENT(w->source->leaf), SVO_I_ARGUMENT(w->source->first_inner),
            SVO_I_ARGUMENT(w->sizes),         SVO_I_ARGUMENT(w->far),          SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(w->work, "svo_k_compact_sizes", SVO_I_ARGUMENTS(arguments), params.node_count));
    }
    return SVO_OK;
}

static svo_status find_places(const words *w)
{
    const cl_uint root_word = 0;
    const cl_uint root_group = 1;
    SVO_I_TRY(svo_i_work_write(w->work, w->places, &root_word, sizeof root_word));
    SVO_I_TRY(svo_i_work_write(w->work, w->groups, &root_group, sizeof root_group));
    for (uint32_t level = 0; level + 1 < w->source->info.depth; ++level) {
        const svo_compact_params params = level_params(w->source, level);
        const svo_i_argument arguments[] = {
            SVO_I_ARGUMENT(w->source->valid), SVO_I_ARGUMENT(w->source->leaf), SVO_I_ARGUMENT(w->source->first_inner),
            SVO_I_ARGUMENT(w->sizes),         SVO_I_ARGUMENT(w->far),          SVO_I_ARGUMENT(w->places),
            SVO_I_ARGUMENT(w->groups),        SVO_I_ARGUMENT(params)};
        SVO_I_TRY(svo_i_work_launch(w->work, "svo_k_compact_places", SVO_I_ARGUMENTS(arguments), params.node_count));
    }
    return SVO_OK;
}

static svo_status write_words(const words *w, cl_mem nodes)
{
    const svo_compact_params params = {.node_count = svo_i_source_level_begin(&w->source->info, w->source->info.depth)};
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(w->source->valid),
                                        SVO_I_ARGUMENT(w->source->leaf),
                                        SVO_I_ARGUMENT(w->source->first_inner),
                                        SVO_I_ARGUMENT(w->sizes),
                                        SVO_I_ARGUMENT(w->far),
                                        SVO_I_ARGUMENT(w->groups),
                                        SVO_I_ARGUMENT(nodes),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(w->work, "svo_k_compact_words", SVO_I_ARGUMENTS(arguments), params.node_count);
}

/* A member of a group is far from its children if its elder siblings' descendants take that many words: the group
   itself and its far words are 16 at most. */
#define FAR_WORDS_MIN (SVO_WORD_DISTANCE_MAX - 15u)

/* As exactly as the levels' counts tell. */
static void count_descriptor(svo_compact_info *info)
{
    const uint64_t inner_count = svo_i_source_level_begin(info, info->depth);
    /* Seven members of a group at most are far, and only if its descendants are FAR_WORDS_MIN words. Those of a level's
       groups are disjoint, so there are at most 7 (depth - 1) words / FAR_WORDS_MIN, far ones included. */
    const uint64_t far_per_words = 7 * (uint64_t)(info->depth - 1);
    info->far_count =
        inner_count > SVO_WORD_DISTANCE_MAX ? far_per_words * inner_count / (FAR_WORDS_MIN - far_per_words) : 0;
    info->stored_count = inner_count + info->far_count;
}

static svo_status make_descriptor(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact)
{
    const uint64_t inner_count = svo_i_source_level_begin(&source->info, source->info.depth);
    words w = {.work = work, .source = source};
    cl_mem targets = NULL;
    cl_uint below_root = 0;
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_compact, " -DSVO_SORT"));
    SVO_I_TRY(svo_i_work_alloc(work, "word_sizes", inner_count * 4, &w.sizes));
    SVO_I_TRY(svo_i_work_alloc(work, "word_far", inner_count, &w.far));
    SVO_I_TRY(svo_i_work_alloc(work, "word_places", inner_count * 4, &w.places));
    SVO_I_TRY(svo_i_work_alloc(work, "word_groups", inner_count * 4, &w.groups));
    SVO_I_TRY(find_sizes(&w));
    SVO_I_TRY(svo_i_work_read(work, w.sizes, 0, &below_root, sizeof below_root));
    compact->info.stored_count = 1 + (uint64_t)below_root;
    compact->info.far_count = compact->info.stored_count - inner_count;
    svo_i_compact_count(&compact->info);
    SVO_I_TRY(find_places(&w));
    SVO_I_TRY(
        svo_i_work_result(work, "nodes", compact->info.bytes[SVO_COMPACT_NODES], &compact->buffers[SVO_COMPACT_NODES]));
    SVO_I_TRY(write_words(&w, compact->buffers[SVO_COMPACT_NODES]));
    svo_i_work_free(work, &w.sizes);
    svo_i_work_free(work, &w.far);
    svo_i_work_free(work, &w.groups);
    SVO_I_TRY(make_word_bases(work, source, w.places, compact, &targets));
    svo_i_work_free(work, &w.places);
    return make_payload(work, source, targets, compact);
}

/* ---- SVO_FORM_IMPLIED: child masks breadth-first, and a directory ---- */

/* The masks' bits and their exclusive sums, in scratch buffers. */
static svo_status count_children(svo_i_device_work *work, cl_mem masks, uint64_t mask_count, cl_mem *sums)
{
    const svo_compact_params params = {.node_count = (cl_uint)mask_count};
    cl_mem counts = NULL;
    SVO_I_TRY(svo_i_work_alloc(work, "child_counts", mask_count * 4, &counts));
    SVO_I_TRY(svo_i_work_alloc(work, "child_sums", (mask_count + 1) * 4, sums));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(masks), SVO_I_ARGUMENT(counts), SVO_I_ARGUMENT(params)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_implied_counts", SVO_I_ARGUMENTS(arguments), mask_count));
    SVO_I_TRY(svo_i_work_scan(work, counts, *sums, mask_count));
    svo_i_work_free(work, &counts);
    return SVO_OK;
}

static svo_status make_masks(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem sums,
                             svo_compact *compact)
{
    const svo_compact_params params = {.node_count = svo_i_source_level_begin(&source->info, source->info.depth)};
    const uint64_t bytes = compact->info.bytes[SVO_COMPACT_NODES];
    cl_mem *masks = &compact->buffers[SVO_COMPACT_NODES];
    SVO_I_TRY(svo_i_work_result(work, "nodes", bytes, masks));
    SVO_I_TRY(svo_i_work_fill_zero(work, *masks, bytes));
    const svo_i_argument arguments[] = {
        SVO_I_ARGUMENT(source->valid), SVO_I_ARGUMENT(source->leaf), SVO_I_ARGUMENT(source->first_inner),
        SVO_I_ARGUMENT(sums),          SVO_I_ARGUMENT(*masks),       SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_implied_masks", SVO_I_ARGUMENTS(arguments), params.node_count);
}

static svo_status make_directory(svo_i_device_work *work, svo_compact *compact)
{
    const cl_uint step_log2 = compact->info.directory_step_log2;
    const cl_uint entry_count = (cl_uint)(compact->info.bytes[SVO_COMPACT_LINKS] / 4);
    cl_mem *links = &compact->buffers[SVO_COMPACT_LINKS];
    cl_mem sums = NULL;
    SVO_I_TRY(count_children(work, compact->buffers[SVO_COMPACT_NODES], compact->info.stored_count, &sums));
    SVO_I_TRY(svo_i_work_result(work, "links", entry_count * UINT64_C(4), links));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(sums), SVO_I_ARGUMENT(*links), SVO_I_ARGUMENT(step_log2),
                                        SVO_I_ARGUMENT(entry_count)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_implied_directory", SVO_I_ARGUMENTS(arguments), entry_count));
    svo_i_work_free(work, &sums);
    return SVO_OK;
}

/* bases: the first node that has payload. *targets as make_payload takes it; scratch. */
static svo_status make_first_base(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem sums,
                                  svo_compact *compact, cl_mem *targets)
{
    svo_compact_params params = {.node_count = svo_i_source_level_begin(&source->info, source->info.depth)};
    if (!svo_i_compact_has_places(&compact->info)) {
        return SVO_OK;
    }
    for (uint32_t level = 0; level < compact->info.payload_level; ++level) {
        params.child_begin += compact->info.level_inner[level] + compact->info.level_leaf[level];
    }
    cl_mem *bases = &compact->buffers[SVO_COMPACT_BASES];
    SVO_I_TRY(svo_i_work_result(work, "bases", sizeof params.child_begin, bases));
    SVO_I_TRY(svo_i_work_write(work, *bases, &params.child_begin, sizeof params.child_begin));
    SVO_I_TRY(svo_i_work_alloc(work, "payload_targets", params.node_count * UINT64_C(4), targets));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(sums), SVO_I_ARGUMENT(*targets), SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_implied_targets", SVO_I_ARGUMENTS(arguments), params.node_count);
}

static void count_implied(svo_compact_info *info)
{
    info->stored_count = 0;
    for (uint32_t level = 0; level < info->depth; ++level) {
        info->stored_count += (uint64_t)info->level_inner[level] + info->level_leaf[level];
    }
}

static svo_status make_implied(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact)
{
    cl_mem sums = NULL;
    cl_mem targets = NULL;
    SVO_I_TRY(svo_i_work_use(work, &svo_i_program_compact, " -DSVO_SORT"));
    count_implied(&compact->info);
    svo_i_compact_count(&compact->info);
    SVO_I_TRY(count_children(work, source->valid, svo_i_source_level_begin(&source->info, source->info.depth), &sums));
    SVO_I_TRY(make_masks(work, source, sums, compact));
    SVO_I_TRY(make_first_base(work, source, sums, compact, &targets));
    svo_i_work_free(work, &sums);
    SVO_I_TRY(make_directory(work, compact));
    return make_payload(work, source, targets, compact);
}

/* ---- SVO_FORM_SHARED, SVO_FORM_MIRRORED: nodes with equal subtrees have one record ---- */

/* The nodes go to the host, become records there (dag.c), and go back; the payload is put in the records' order on the
   device. */

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
    SVO_I_TRY(svo_i_dag_encode(s->work->function, &s->nodes, &s->work->device->memory,
                               s->source->info.form == SVO_FORM_MIRRORED, &s->dag, s->place_of,
                               svo_i_device_message(s->work->device)));
    for (size_t i = 0; places && i < payload_count; ++i) {
        s->origins[s->place_of[i]] = (uint32_t)i;
    }
    return SVO_OK;
}

static svo_status put_records(const sharing *s)
{
    svo_compact *compact = s->compact;
    const uint64_t links_bytes = s->dag.link_count * sizeof s->dag.links[0];
    compact->info.stored_count = s->dag.word_count;
    compact->info.shared_count = s->dag.record_count;
    svo_i_compact_count(&compact->info);
    SVO_I_TRY(svo_i_work_result(s->work, "nodes", compact->info.bytes[SVO_COMPACT_NODES],
                                &compact->buffers[SVO_COMPACT_NODES]));
    SVO_I_TRY(svo_i_work_result(s->work, "links", links_bytes, &compact->buffers[SVO_COMPACT_LINKS]));
    SVO_I_TRY(svo_i_work_write(s->work, compact->buffers[SVO_COMPACT_LINKS], s->dag.links, links_bytes));
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
    return gather_payload(s->work, s->source, origins, s->compact);
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

static void free_sharing(sharing *s)
{
    for (int i = 0; i < 4; ++i) {
        svo_i_free(s->arrays[i]);
    }
    svo_i_free(s->place_of);
    svo_i_free(s->origins);
    svo_i_dag_free(&s->dag);
}

static svo_status make_shared(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact)
{
    sharing s = {.work = work, .source = source, .compact = compact};
    const svo_status status = share(&s);
    free_sharing(&s);
    return status;
}

/* Describes nodes that are on the host. */
static svo_status take_nodes(sharing *s, const svo_tree *tree)
{
    const svo_tree_info *info = &tree->info;
    const uint8_t *valid = tree->host[SVO_TREE_CHILD_MASK];
    const uint32_t last = info->level_begin[info->depth - 1];
    uint8_t *leaf = svo_i_alloc_zeroed(&s->work->device->memory, (size_t)info->inner_count, sizeof *leaf);
    s->arrays[0] = leaf;
    if (leaf == NULL) {
        return svo_i_device_fail(s->work->device, SVO_OUT_OF_HOST_MEMORY, "%s: leaf masks need %llu bytes",
                                 s->work->function, (unsigned long long)info->inner_count);
    }
    memcpy(leaf + last, valid + last, (size_t)info->inner_count - last);
    s->nodes = (svo_i_dag_nodes){.depth = info->depth,
                                 .payload_level = info->payload_level,
                                 .valid = valid,
                                 .leaf = leaf,
                                 .first_inner = tree->host[SVO_TREE_FIRST_CHILD],
                                 .payload_begin = info->level_begin[info->payload_level]};
    s->nodes.first_payload = svo_i_compact_has_places(&s->compact->info) ? s->nodes.first_inner : NULL;
    memcpy(s->nodes.level_begin, info->level_begin, sizeof s->nodes.level_begin);
    return SVO_OK;
}

static svo_status share_host(sharing *s, const svo_tree *tree)
{
    svo_compact *compact = s->compact;
    svo_i_compact_count(&compact->info);
    SVO_I_TRY(take_nodes(s, tree));
    SVO_I_TRY(svo_i_dag_encode(s->work->function, &s->nodes, &s->work->device->memory, false, &s->dag, NULL,
                               svo_i_device_message(s->work->device)));
    SVO_I_TRY(put_records(s));
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const svo_compact_buffer buffer = (svo_compact_buffer)i;
        const uint64_t bytes = compact->info.bytes[buffer];
        if (bytes > 0) {
            SVO_I_TRY(svo_i_work_result(s->work, svo_name(SVO_NAME_COMPACT_BUFFER, buffer), bytes,
                                        &compact->buffers[buffer]));
            SVO_I_TRY(svo_i_work_write(s->work, compact->buffers[buffer], tree->host[svo_i_compact_tree_buffer(buffer)],
                                       bytes));
        }
    }
    return SVO_OK;
}

svo_status svo_i_form_share(svo_i_device_work *work, const svo_tree *tree, svo_compact *compact)
{
    sharing s = {.work = work, .compact = compact};
    const svo_status status = share_host(&s, tree);
    free_sharing(&s);
    return status;
}

/* Bounds by the levels' counts, as if no two subtrees were equal. */
static void count_shared(svo_compact_info *info)
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

/* The same in half words, all of whose references are long. */
static void count_mirrored(svo_compact_info *info)
{
    uint64_t halves = 0;
    const uint32_t per_child = svo_i_compact_has_places(info) ? 4 : 2;
    count_shared(info);
    for (uint32_t level = 0; level + 1 < info->depth; ++level) {
        const uint64_t inner = info->level_inner[level];
        const uint64_t below = info->level_inner[level + 1];
        halves +=
            level + 2 < info->depth ? inner + per_child * below : (2 * inner + below + info->level_leaf[level + 1]) / 2;
    }
    info->stored_count = info->depth == 1 ? 1 : (halves + 1) / 2;
}

/* ---- the table of forms ---- */

const char *svo_i_form_options(const svo_compact_info *info)
{
    static const char *const implied[3][2] = {{CL12 IMPLIED "4", CL12 IMPLIED "4" PLACES},
                                              {CL12 IMPLIED "5", CL12 IMPLIED "5" PLACES},
                                              {CL12 IMPLIED "6", CL12 IMPLIED "6" PLACES}};
    const bool places = svo_i_compact_has_places(info);
    if (info->form == SVO_FORM_SHARED) {
        return places ? CL12 SHARED PLACES : CL12 SHARED;
    }
    if (info->form == SVO_FORM_MIRRORED) {
        return places ? CL12 MIRROR PLACES : CL12 MIRROR;
    }
    if (info->form == SVO_FORM_IMPLIED) {
        return implied[info->directory_step_log2 - SVO_I_DIRECTORY_LOG2_MIN][places ? 1 : 0];
    }
    return places ? CL12 WORDS PLACES : CL12 WORDS;
}

const char *svo_i_form_defines(const svo_compact_info *info)
{
    return svo_i_form_options(info) + sizeof CL12 - 1;
}

void svo_i_form_count(svo_compact_info *info)
{
    switch (info->form) {
    case SVO_FORM_DESCRIPTOR:
        count_descriptor(info);
        break;
    case SVO_FORM_IMPLIED:
        count_implied(info);
        break;
    case SVO_FORM_MIRRORED:
        count_mirrored(info);
        break;
    default:
        count_shared(info);
        break;
    }
    svo_i_compact_count(info);
}

svo_status svo_i_form_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact)
{
    switch (source->info.form) {
    case SVO_FORM_IMPLIED:
        return make_implied(work, source, compact);
    case SVO_FORM_SHARED:
    case SVO_FORM_MIRRORED:
        return make_shared(work, source, compact);
    default:
        return make_descriptor(work, source, compact);
    }
}
