/* SPDX-License-Identifier: MIT */
/* Launches compute shaders and times the stages. */
#include "compute/launch.h"

#include "commands/commands.h"
#include "compute/buffer.h"
#include "core/message.h"

/* Groups in a row of a launch. Every context allows 65535. */
#define ROW_GROUPS 16384u

static void dispatch(const svo_i_gl_functions *gl, const svo_i_launch *launch)
{
    if (launch->indirect != 0) {
        gl->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, launch->indirect);
        gl->DispatchComputeIndirect((GLintptr)launch->indirect_word * 4);
        return;
    }
    const uint64_t groups = (launch->items + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
    const uint64_t columns = groups < ROW_GROUPS ? groups : ROW_GROUPS;
    gl->DispatchCompute((GLuint)columns, (GLuint)((groups + columns - 1) / columns), 1);
}

svo_status svo_i_compute_launch(svo_i_compute *compute, const svo_i_launch *launch)
{
    const svo_i_gl_functions *gl = compute->gl;
    svo_i_compute_program *program = NULL;
    if (launch->indirect == 0 && launch->items == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_compute_program_get(compute, launch->entry, &program));
    for (GLuint binding = 0; binding < SVO_I_COMPUTE_BLOCKS; ++binding) {
        if (launch->buffers[binding] != 0) {
            gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, launch->buffers[binding]);
        }
    }
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, SVO_I_COMPUTE_EXHAUSTED, compute->exhausted);
    gl->UseProgram(program->name);
    svo_i_compute_program_set(compute, program, launch->params);
    gl->Uniform1ui(program->vertex_count, launch->vertex_count);
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                      (launch->indirect != 0 ? GL_COMMAND_BARRIER_BIT : 0u));
    dispatch(gl, launch);
    return svo_i_compute_check(compute, "launching a compute shader");
}

svo_status svo_i_compute_exhausted(svo_i_compute *compute, bool *exhausted)
{
    uint32_t word = 0;
    *exhausted = false;
    SVO_I_TRY(svo_i_compute_read(compute, compute->exhausted, &word, sizeof word));
    *exhausted = word != 0;
    if (*exhausted) {
        svo_i_compute_fill_zero(compute, compute->exhausted);
    }
    return SVO_OK;
}

void svo_i_compute_stage_begin(svo_i_compute *compute)
{
    if (compute->has_timer) {
        compute->gl->QueryCounter(compute->queries[0], GL_TIMESTAMP);
    } else {
        compute->gl->Finish();
    }
    compute->stage_start_ms = svo_i_now_ms();
}

svo_status svo_i_compute_stage_end(svo_i_compute *compute, svo_i_build *build, svo_stage stage)
{
    const svo_i_gl_functions *gl = compute->gl;
    if (!compute->has_timer) {
        gl->Finish();
        svo_i_report_add(build->commands.report, stage, svo_i_now_ms() - compute->stage_start_ms, "wall");
        return svo_i_compute_check(compute, svo_stage_name(stage));
    }
    GLuint64 begin_ns = 0;
    GLuint64 end_ns = 0;
    gl->QueryCounter(compute->queries[1], GL_TIMESTAMP);
    gl->GetQueryObjectui64v(compute->queries[0], GL_QUERY_RESULT, &begin_ns);
    gl->GetQueryObjectui64v(compute->queries[1], GL_QUERY_RESULT, &end_ns);
    svo_i_report_add(build->commands.report, stage, (double)(end_ns - begin_ns) * 1e-6, "gl-timer");
    return svo_i_compute_check(compute, svo_stage_name(stage));
}
