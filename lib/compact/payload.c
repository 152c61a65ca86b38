/* SPDX-License-Identifier: MIT */
/* Places of payload and its arrays. */
#include "compact/payload.h"

#include "shared/layout.h"

static svo_compact_params make_params(const svo_i_compact_source *source)
{
    const svo_compact_info *info = &source->info;
    return (svo_compact_params){.node_count = svo_i_source_level_begin(info, info->depth),
                                .payload_parents = svo_i_source_payload_parents(info),
                                .payload_begin = source->payload_begin,
                                .root_payload = info->payload_level == 0};
}

svo_status svo_i_payload_bases(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem places,
                               svo_compact *compact, cl_mem *targets)
{
    const svo_compact_params params = make_params(source);
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
static svo_status make_array(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact,
                             svo_compact_buffer buffer, bool *fill)
{
    cl_mem *to = &compact->buffers[buffer];
    const cl_mem from = source->payload[buffer - SVO_I_PAYLOAD_FIRST];
    const uint64_t bytes = compact->info.bytes[buffer];
    *fill = false;
    if (bytes == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_result(work, svo_compact_buffer_name(buffer), bytes, to));
    if (svo_i_compact_is_constant(&compact->info, buffer)) {
        return svo_i_work_copy(work, from, 0, *to, 0, bytes);
    }
    *fill = true;
    return SVO_OK;
}

static svo_status gather(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem targets,
                         const svo_compact *compact, svo_compact_buffer buffer)
{
    svo_compact_params params = make_params(source);
    params.element_halves = (cl_uint)(svo_i_compact_element_bytes(&compact->info, buffer) / 2);
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(source->valid),
                                        SVO_I_ARGUMENT(source->first_payload),
                                        SVO_I_ARGUMENT(targets),
                                        SVO_I_ARGUMENT(source->payload[buffer - SVO_I_PAYLOAD_FIRST]),
                                        SVO_I_ARGUMENT(compact->buffers[buffer]),
                                        SVO_I_ARGUMENT(params)};
    return svo_i_work_launch(work, "svo_k_compact_payload", SVO_I_ARGUMENTS(arguments), params.node_count);
}

svo_status svo_i_payload_make(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem targets,
                              svo_compact *compact)
{
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        bool fill = false;
        SVO_I_TRY(make_array(work, source, compact, (svo_compact_buffer)i, &fill));
        if (fill) {
            SVO_I_TRY(gather(work, source, targets, compact, (svo_compact_buffer)i));
        }
    }
    return SVO_OK;
}

svo_status svo_i_payload_gather(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem origins,
                                svo_compact *compact)
{
    svo_compact_params params = {.node_count = (cl_uint)compact->info.payload_count};
    for (int i = SVO_I_PAYLOAD_FIRST; i < SVO_COMPACT_BUFFER_COUNT; ++i) {
        const svo_compact_buffer buffer = (svo_compact_buffer)i;
        bool fill = false;
        SVO_I_TRY(make_array(work, source, compact, buffer, &fill));
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
