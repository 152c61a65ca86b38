/* SPDX-License-Identifier: MIT */
/* What all stages of a build by compute shaders use. */
#include "compute/stage.h"

#include "core/message.h"
#include "share/shared_buffer.h"

GLuint svo_i_gl_chunk(const svo_i_gl_build *gl_build, uint32_t chunk)
{
    const svo_i_share_buffer *buffer = gl_build->build->list.chunks[chunk].owner;
    return buffer->name;
}

svo_status svo_i_gl_check_loops(svo_i_gl_build *gl_build, const char *what)
{
    bool exhausted = false;
    SVO_I_TRY(svo_i_compute_exhausted(gl_build->compute, &exhausted));
    if (exhausted) {
        return svo_i_device_fail(gl_build->build->commands.device, SVO_UNSUPPORTED,
                                 SVO_I_GL_BUILD ": a voxel has too many triangles: %s takes more than the 65535 loop "
                                                "iterations that %s allows an invocation",
                                 what, gl_build->compute->gl->renderer);
    }
    return SVO_OK;
}
