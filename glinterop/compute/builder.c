/* SPDX-License-Identifier: MIT */
/* The builder by compute shaders: created by the first svo_gl_build, destroyed with svo_gl. */
#include "compute/builder.h"

#include <stdio.h>
#include <string.h>

#include "compute/buffer.h"
#include "compute/program.h"
#include "core/message.h"

/* llvmpipe's timer queries omit work, and the first ones return nonsense. */
static bool has_reliable_timer(const svo_i_gl_functions *gl)
{
    return strstr(gl->renderer, "llvmpipe") == NULL;
}

static svo_status create_objects(svo_i_compute *compute)
{
    SVO_I_TRY(svo_i_gl_context_make_current(compute->context, &compute->device->message));
    svo_i_gl_clear_errors(compute->gl);
    compute->gl->GenQueries(2, compute->queries);
    const svo_status status = svo_i_compute_alloc_zero(compute, "exhausted", 4, &compute->exhausted);
    svo_i_gl_context_release_current(compute->context);
    return status;
}

svo_status svo_i_compute_create(svo_device *device, svo_gl_context *context, svo_i_compute **out)
{
    svo_i_compute *compute = svo_i_alloc_zeroed(&device->memory, 1, sizeof *compute);
    if (compute == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, SVO_I_GL_BUILD ": no memory for the builder");
    }
    svo_status status = SVO_OK;
    compute->device = device;
    compute->context = context;
    compute->gl = svo_i_gl_context_functions(context);
    compute->has_timer = has_reliable_timer(compute->gl);
    SVO_I_TRY_CLEANUP(create_objects(compute));
    *out = compute;
    return SVO_OK;
cleanup:
    svo_i_compute_destroy(&compute);
    return status;
}

void svo_i_compute_destroy(svo_i_compute **compute)
{
    svo_i_compute *dying = *compute;
    if (dying == NULL) {
        return;
    }
    if (svo_i_gl_context_make_current_to_delete(dying->context)) {
        svo_i_compute_programs_destroy(dying);
        dying->gl->DeleteQueries(2, dying->queries);
        svo_i_compute_free(dying, &dying->exhausted);
        svo_i_gl_context_release_current(dying->context);
    }
    svo_i_free(dying);
    *compute = NULL;
}

void svo_i_compute_reason(const svo_gl_context *context, bool no_int64, uint32_t need, char *reason,
                          size_t reason_bytes)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    const bool payload = (need & SVO_I_NEED_PAYLOAD) != 0;
    /* Among the entry points without payload, SVO_I_ENTRY_SORT_LONG has the most blocks: its five and exhausted. */
    const int blocks = payload ? SVO_I_COMPUTE_BINDINGS : 6;
    reason[0] = '\0';
    if (gl->limits.compute_group_invocations < SVO_GROUP_ITEMS) {
        (void)snprintf(reason, reason_bytes, "%s has groups of %d invocations, below %d", gl->renderer,
                       gl->limits.compute_group_invocations, SVO_GROUP_ITEMS);
    } else if (gl->limits.storage_bindings < SVO_I_COMPUTE_BINDINGS) {
        (void)snprintf(reason, reason_bytes, "%s has %d bindings of storage blocks, below %d", gl->renderer,
                       gl->limits.storage_bindings, SVO_I_COMPUTE_BINDINGS);
    } else if (gl->limits.compute_storage_blocks < blocks) {
        (void)snprintf(reason, reason_bytes, "%s has %d storage blocks for compute shaders, below the %d of %s",
                       gl->renderer, gl->limits.compute_storage_blocks, blocks,
                       payload ? "payload" : "nodes and lists");
    } else if (payload && (no_int64 || !svo_i_gl_has_extension(gl, "GL_ARB_gpu_shader_int64"))) {
        (void)snprintf(reason, reason_bytes, "payload needs GL_ARB_gpu_shader_int64, which %s does not have%s",
                       gl->renderer, no_int64 ? " by svo_gl_options.no_int64" : "");
    }
}
