/* SPDX-License-Identifier: MIT */
/*
 * The rules that predict which front end is faster. None of them runs anything.
 *
 * On two cores with PoCL 3.1 and llvmpipe, OpenCL alone makes six times as many fragments per second as the software
 * rasterizer. It makes a million of them in 15 ms; OpenGL takes 30 ms to start. Two rules are assumptions, not
 * measurements: a GPU rasterizes faster than a CPU computes, and copying a GPU's list through the host costs more than
 * rasterization saves.
 */
#include "plan/frontend_choice.h"

/* OpenCL makes fewer fragments than this before OpenGL has started. */
#define FEW_FRAGMENTS 1048576.0

int svo_frontend_cl_suffices(const svo_plan *plan, svo_message *reason)
{
    const bool few = plan->info.expected_fragments < FEW_FRAGMENTS;
    svo_i_message_set(reason, "about %.0f fragments are %s to start OpenGL for", plan->info.expected_fragments,
                      few ? "too few" : "enough");
    return few;
}

bool svo_i_frontend_prefers_cl(const svo_device *device, const svo_i_renderer *renderer, svo_message *reason)
{
    if (renderer->is_software) {
        svo_i_message_set(reason, "%s draws in software, OpenCL on %s is faster", renderer->name, device->name);
        return true;
    }
    if (!renderer->in_place && !device->cpu_path) {
        svo_i_message_set(reason, "%s and %s share no memory, and the list would go through the host", renderer->name,
                          device->name);
        return true;
    }
    if (renderer->in_place) {
        svo_i_message_set(reason, "%s draws in hardware, and %s has the list in place", renderer->name, device->name);
    } else {
        svo_i_message_set(reason, "%s draws in hardware, faster than %s computes", renderer->name, device->name);
    }
    return false;
}
