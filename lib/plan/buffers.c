/* SPDX-License-Identifier: MIT */
/* The list of buffers. Builds and measuring builds add to it as they allocate. */
#include <string.h>

#include "plan/buffers.h"

#include "core/memory.h"

void svo_i_plan_buffers_reset(svo_plan *plan)
{
    plan->buffer_count = 0;
    plan->live_bytes = 0;
    plan->peak_bytes = 0;
}

/* The table's entry for a buffer, preferably of a stage that runs; NULL if the table has none. */
static const svo_i_buffer_kind *kind_of(const svo_plan *plan, const char *name)
{
    const svo_i_buffer_kind *found = NULL;
    for (size_t i = 0; i < plan->stage_count; ++i) {
        const svo_i_buffer_kind *kinds = plan->stages[i].buffers;
        for (size_t k = 0; k < SVO_I_STAGE_BUFFERS_MAX && kinds[k].name != NULL; ++k) {
            if (strcmp(kinds[k].name, name) == 0) {
                found = &kinds[k];
                if (plan->stages[i].runs(plan)) {
                    return found;
                }
            }
        }
    }
    return found;
}

static svo_certainty certainty_of(const svo_plan *plan, const svo_i_buffer_kind *kind, uint64_t bytes)
{
    const bool one_value = kind->persistent && kind->basis == SVO_I_OF_NODES && bytes <= 6;
    if (kind->basis == SVO_I_OF_MESH || one_value || plan->built) {
        return SVO_BYTES_EXACT;
    }
    if (!plan->counted || kind->basis == SVO_I_OF_NODES) {
        return SVO_BYTES_ESTIMATE;
    }
    return kind->basis == SVO_I_OF_FRAGMENTS ? SVO_BYTES_EXACT : SVO_BYTES_BOUND;
}

svo_status svo_i_plan_buffer_add(svo_plan *plan, const char *name, uint64_t bytes)
{
    size_t index = 0;
    while (index < plan->buffer_count && strcmp(plan->buffers[index].name, name) != 0) {
        ++index;
    }
    if (index == SVO_I_BUFFERS_MAX) {
        return svo_i_device_fail(plan->device, SVO_INTERNAL, "svo_build: buffer %s is one more than the %d of a plan",
                                 name, SVO_I_BUFFERS_MAX);
    }
    svo_buffer_info *buffer = &plan->buffers[index];
    if (index == plan->buffer_count) {
        const svo_i_buffer_kind *kind = kind_of(plan, name);
        *buffer = (svo_buffer_info){.name = name, .persistent = kind != NULL && kind->persistent};
        buffer->certainty = kind != NULL ? certainty_of(plan, kind, bytes) : SVO_BYTES_ESTIMATE;
        ++plan->buffer_count;
    }
    buffer->bytes += bytes;
    ++buffer->count;
    plan->live_bytes += bytes;
    plan->peak_bytes = plan->live_bytes > plan->peak_bytes ? plan->live_bytes : plan->peak_bytes;
    return SVO_OK;
}

void svo_i_plan_buffer_remove(svo_plan *plan, uint64_t bytes)
{
    plan->live_bytes -= bytes;
}

svo_status svo_i_plan_check_budget(const svo_plan *plan, const char *function, uint64_t bytes)
{
    const svo_i_budget *budget = plan->device->budget;
    return svo_i_budget_fits(budget, bytes)
               ? SVO_OK
               : svo_i_device_fail(plan->device, SVO_OUT_OF_DEVICE_MEMORY,
                                   "%s: the scene needs about %s at depth %u beside the %s in use, above "
                                   "max_device_bytes, %s",
                                   function, svo_i_bytes(bytes).text, plan->info.depth,
                                   svo_i_bytes(svo_i_budget_held(budget)).text,
                                   svo_i_bytes(svo_i_budget_max(budget)).text);
}
