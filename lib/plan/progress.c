/* SPDX-License-Identifier: MIT */
/* The progress of calls on a plan: see progress.h. */
#include "plan/progress.h"

#include <string.h>

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
                             svo_stage_name(stage), progress->fraction * 100.0);
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
