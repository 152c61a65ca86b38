/* SPDX-License-Identifier: MIT */
/*
 * What a running call accounts for: the progress, which its callback is told, and the list of buffers, to which builds
 * and measuring builds add as they allocate.
 */
#include "plan/accounts.h"

#include <string.h>

#include "core/memory.h"

/* ---- progress ---- */

/* The callback is told after this much predicted time. */
#define TOLD_EVERY_NS 5e6

void svo_plan_set_progress(svo_plan *plan, svo_progress_callback progress, void *user)
{
    plan->progress.callback = progress;
    plan->progress.user = user;
}

/* The predicted times of the call's stages, and what is done of them: at most all, since predictions may be low. */
static void sum_up(const svo_i_progress *progress, double *done, double *expected)
{
    for (unsigned stage = 0; stage < SVO_STAGE_COUNT; ++stage) {
        if ((progress->stages & SVO_I_STAGE_BIT(stage)) != 0) {
            const double all = progress->expected_ns[stage];
            *expected += all;
            *done += progress->done_ns[stage] < all ? progress->done_ns[stage] : all;
        }
    }
}

static svo_status tell(svo_plan *plan, svo_stage stage, double fraction)
{
    svo_i_progress *progress = &plan->progress;
    progress->untold_ns = 0.0;
    if (progress->callback == NULL) {
        return SVO_OK;
    }
    if (fraction > progress->fraction) {
        progress->fraction = fraction;
    }
    if (progress->callback(progress->user, stage, progress->fraction) == 0) {
        return SVO_OK;
    }
    return svo_i_device_fail(plan->device, SVO_CANCELED,
                             "%s: the progress callback stopped the call in stage %s at %.0f %%", progress->function,
                             svo_name(SVO_NAME_STAGE, stage), progress->fraction * 100.0);
}

svo_status svo_i_progress_begin(svo_plan *plan, const char *function, uint32_t stages)
{
    svo_i_progress *progress = &plan->progress;
    progress->function = function;
    progress->stages = stages;
    progress->fraction = 0.0;
    memset(progress->done_ns, 0, sizeof progress->done_ns);
    svo_stage first = SVO_STAGE_GRID;
    while (first + 1 < SVO_STAGE_COUNT && (stages & SVO_I_STAGE_BIT(first)) == 0) {
        ++first;
    }
    return tell(plan, first, 0.0);
}

bool svo_i_progress_add(svo_plan *plan, svo_stage stage, double ns)
{
    plan->progress.done_ns[stage] += ns;
    plan->progress.untold_ns += ns;
    return plan->progress.callback != NULL && plan->progress.untold_ns >= TOLD_EVERY_NS;
}

svo_status svo_i_progress_tell(svo_plan *plan, svo_stage stage)
{
    double done = 0.0;
    double expected = 0.0;
    sum_up(&plan->progress, &done, &expected);
    return tell(plan, stage, expected > 0.0 ? done / expected : 0.0);
}

svo_status svo_i_progress_reach(svo_plan *plan, svo_stage stage, double part)
{
    const double ns = part * plan->progress.expected_ns[stage];
    double *done_ns = &plan->progress.done_ns[stage];
    *done_ns = ns > *done_ns ? ns : *done_ns;
    return svo_i_progress_tell(plan, stage);
}

svo_status svo_i_progress_end(svo_plan *plan, svo_stage last_stage)
{
    return tell(plan, last_stage, 1.0);
}

/* ---- buffers ---- */

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
        for (size_t k = 0; kinds[k].name != NULL; ++k) {
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

uint64_t svo_i_plan_tree_bytes(const svo_plan *plan)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < plan->buffer_count; ++i) {
        bytes += plan->buffers[i].persistent != 0 ? plan->buffers[i].bytes : 0;
    }
    return bytes;
}

svo_status svo_i_plan_check_budget(const svo_plan *plan, const char *function, uint64_t bytes)
{
    const svo_i_budget_answer room = svo_i_device_budget(plan->device, bytes);
    return room.fits
               ? SVO_OK
               : svo_i_device_fail(plan->device, room.status, "%s: the scene needs about %s at depth %u %s%s", function,
                                   svo_i_bytes(bytes).text, plan->info.depth, svo_i_budget_words(&room).text,
                                   svo_i_limit_left(&room.limit) > 0 ? "; svo_parts_create builds it in parts" : "");
}
