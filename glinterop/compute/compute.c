/* SPDX-License-Identifier: MIT */
/*
 * The builder's compute shaders in one context: storage blocks for the stages; the programs, one per entry point and
 * set of defines, compiled on first use; launches, and the times of stages. The programs share
 * kernels/shared/integer.clh and clip.clh with the OpenCL kernels, as the same text. The first svo_gl_build creates the
 * builder, and svo_gl_destroy destroys it.
 */
#include "compute/compute.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "commands/commands.h"
#include "context/functions.h"
#include "core/message.h"
#include "plan/configuration.h"
#include "share/share.h"
#include "stages/programs.h"

/* ---- storage blocks ---- */

/* svocl draws nothing from this binding point. */
#define WORK_TARGET GL_COPY_READ_BUFFER

/* SVO_OK, or the first OpenGL error since the last check, with the step in the message. */
static svo_status check(svo_i_compute *compute, const char *step)
{
    return svo_i_gl_check(compute->gl, SVO_I_GL_BUILD, step, &compute->device->message);
}

/* Whole words plus one: shaders read one word past the last. */
static uint64_t padded(uint64_t bytes)
{
    return (bytes + 3) / 4 * 4 + 4;
}

uint64_t svo_i_compute_range_max(const svo_i_compute *compute)
{
    return (uint64_t)compute->gl->limits.storage_block_bytes - UINT64_C(2) * SVO_I_RANGE_SLACK;
}

static svo_status alloc_any(svo_i_compute *compute, const char *name, uint64_t bytes, const void *data, GLuint *out)
{
    const svo_i_gl_functions *gl = compute->gl;
    gl->GenBuffers(1, out);
    gl->BindBuffer(WORK_TARGET, *out);
    gl->BufferData(WORK_TARGET, (GLsizeiptr)padded(bytes), NULL, GL_STATIC_COPY); /* in the GPU's memory */
    if (data != NULL && bytes > 0) {
        gl->BufferSubData(WORK_TARGET, 0, (GLsizeiptr)bytes, data);
    }
    gl->BindBuffer(WORK_TARGET, 0);
    return check(compute, name);
}

static svo_status alloc(svo_i_compute *compute, const char *name, uint64_t bytes, const void *data, GLuint *out)
{
    const svo_i_gl_functions *gl = compute->gl;
    if (padded(bytes) > (uint64_t)gl->limits.storage_block_bytes) {
        return svo_i_device_fail(compute->device, SVO_UNSUPPORTED,
                                 SVO_I_GL_BUILD ": %s needs %llu bytes, above the storage block limit of %lld of %s",
                                 name, (unsigned long long)padded(bytes), (long long)gl->limits.storage_block_bytes,
                                 gl->renderer);
    }
    return alloc_any(compute, name, bytes, data, out);
}

svo_status svo_i_compute_alloc(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out)
{
    return alloc(compute, name, bytes, NULL, out);
}

svo_status svo_i_compute_alloc_zero(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out)
{
    SVO_I_TRY(alloc(compute, name, bytes, NULL, out));
    svo_i_compute_fill_zero(compute, *out);
    return SVO_OK;
}

svo_status svo_i_compute_upload(svo_i_compute *compute, const char *name, const void *data, uint64_t bytes, GLuint *out)
{
    return alloc(compute, name, bytes, data, out);
}

svo_status svo_i_compute_alloc_array(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out)
{
    return alloc_any(compute, name, bytes, NULL, out);
}

svo_status svo_i_compute_alloc_array_zero(svo_i_compute *compute, const char *name, uint64_t bytes, GLuint *out)
{
    SVO_I_TRY(alloc_any(compute, name, bytes, NULL, out));
    svo_i_compute_fill_zero(compute, *out);
    return SVO_OK;
}

void svo_i_compute_fill_zero(const svo_i_compute *compute, GLuint buffer)
{
    const svo_i_gl_functions *gl = compute->gl;
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(WORK_TARGET, buffer);
    gl->ClearBufferData(WORK_TARGET, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, NULL);
    gl->BindBuffer(WORK_TARGET, 0);
}

void svo_i_compute_free(const svo_i_compute *compute, GLuint *buffer)
{
    if (*buffer != 0) {
        compute->gl->DeleteBuffers(1, buffer);
        *buffer = 0;
    }
}

svo_status svo_i_compute_read_at(svo_i_compute *compute, GLuint buffer, uint64_t offset, void *to, size_t bytes)
{
    const svo_i_gl_functions *gl = compute->gl;
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(WORK_TARGET, buffer);
    gl->GetBufferSubData(WORK_TARGET, (GLintptr)offset, (GLsizeiptr)bytes, to);
    gl->BindBuffer(WORK_TARGET, 0);
    return check(compute, "reading a buffer");
}

svo_status svo_i_compute_read(svo_i_compute *compute, GLuint buffer, void *to, size_t bytes)
{
    return svo_i_compute_read_at(compute, buffer, 0, to, bytes);
}

void svo_i_compute_write_at(svo_i_compute *compute, GLuint buffer, uint64_t offset, const void *from, size_t bytes)
{
    const svo_i_gl_functions *gl = compute->gl;
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(WORK_TARGET, buffer);
    gl->BufferSubData(WORK_TARGET, (GLintptr)offset, (GLsizeiptr)bytes, from);
    gl->BindBuffer(WORK_TARGET, 0);
}

svo_status svo_i_compute_copy(svo_i_compute *compute, GLuint from, GLuint to, uint64_t offset, uint64_t bytes)
{
    const svo_i_gl_functions *gl = compute->gl;
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(WORK_TARGET, from);
    gl->BindBuffer(GL_COPY_WRITE_BUFFER, to);
    gl->CopyBufferSubData(WORK_TARGET, GL_COPY_WRITE_BUFFER, 0, (GLintptr)offset, (GLsizeiptr)bytes);
    gl->BindBuffer(GL_COPY_WRITE_BUFFER, 0);
    gl->BindBuffer(WORK_TARGET, 0);
    return check(compute, "copying a buffer");
}

/* Expects the buffer bound to WORK_TARGET. */
static svo_status copy_bound_to_cl(svo_i_compute *compute, svo_i_build *build, const char *name, uint64_t offset,
                                   uint64_t bytes, cl_mem *out)
{
    const svo_i_gl_functions *gl = compute->gl;
    const void *mapped = gl->MapBufferRange(WORK_TARGET, (GLintptr)offset, (GLsizeiptr)bytes, GL_MAP_READ_BIT);
    SVO_I_TRY(check(compute, "glMapBufferRange"));
    if (mapped == NULL) {
        return svo_i_device_fail(compute->device, SVO_GL_ERROR, SVO_I_GL_BUILD ": glMapBufferRange returned NULL");
    }
    const svo_status status = svo_i_commands_upload(&build->commands, name, mapped, bytes, out);
    const bool intact = gl->UnmapBuffer(WORK_TARGET) == GL_TRUE;
    SVO_I_TRY(status);
    if (!intact) {
        return svo_i_device_fail(compute->device, SVO_GL_ERROR,
                                 SVO_I_GL_BUILD ": glUnmapBuffer reports that the content of %s was lost", name);
    }
    return SVO_OK;
}

svo_status svo_i_compute_to_cl(svo_i_compute *compute, svo_i_build *build, GLuint buffer, const char *name,
                               uint64_t offset, uint64_t bytes, cl_mem *out)
{
    const svo_i_gl_functions *gl = compute->gl;
    if (bytes == 0) {
        return svo_i_commands_alloc(&build->commands, name, bytes, out);
    }
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(WORK_TARGET, buffer);
    const svo_status status = copy_bound_to_cl(compute, build, name, offset, bytes, out);
    gl->BindBuffer(WORK_TARGET, 0);
    return status;
}

/* ---- programs ---- */

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_compute_common[];
extern const char svo_i_source_compute_fragment[];
extern const char svo_i_source_compute_attribute[];
extern const char svo_i_source_compute_decide[];
extern const char svo_i_source_compute_subdivide[];
extern const char svo_i_source_compute_scan[];
extern const char svo_i_source_compute_pack[];
extern const char svo_i_source_compute_filter[];
extern const char svo_i_source_compute_area[];
extern const char svo_i_source_compute_material[];

/* The shared texts before an entry point. Each base includes those above it. */
typedef enum base {
    BASE_COMMON, /* records and group size */
    BASE_FRAGMENT, /* the fragment list */
    BASE_ATTRIBUTE /* the mesh's attributes */
} base;

typedef struct entry_shape {
    const char *define; /* selects the entry point in its text */
    const char *source;
    base base;
    bool has_64_bits; /* also takes all of the plan's defines; otherwise only the one for the length of codes */
    bool subdivides; /* takes svo_subdivide_params, else svo_filter_params */
    uint32_t need; /* svo_need bits; a build with one of them launches it. 0: always. */
    bool is_rare; /* compiled at its first launch, not by svo_i_compute_prepare */
} entry_shape;

/* The needs that require each leaf's range of entries. */
#define RANGES ((uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_MATERIAL)

#define DECIDE    svo_i_source_compute_decide
#define SUBDIVIDE svo_i_source_compute_subdivide
#define SCAN      svo_i_source_compute_scan
#define PACK      svo_i_source_compute_pack
#define FILTER    svo_i_source_compute_filter
#define AREA      svo_i_source_compute_area
#define MATERIAL  svo_i_source_compute_material

static const entry_shape shapes[SVO_I_ENTRIES] = {
    {"SVO_K_DECIDE", DECIDE, BASE_FRAGMENT, false, false, 0, false},
    {"SVO_K_MARK", SUBDIVIDE, BASE_FRAGMENT, false, true, 0, false},
    {"SVO_K_DESCEND", SUBDIVIDE, BASE_FRAGMENT, false, true, 0, false},
    {"SVO_K_SCAN_MASKS_REDUCE", SCAN, BASE_COMMON, false, true, 0, false},
    {"SVO_K_SCAN_MASKS_PARTIALS", SCAN, BASE_COMMON, false, true, 0, false},
    {"SVO_K_SCAN_MASKS_ADD", SCAN, BASE_COMMON, false, true, 0, false},
    {"SVO_K_COUNT", PACK, BASE_COMMON, false, false, RANGES, false},
    {"SVO_K_SCAN_LISTS_REDUCE", SCAN, BASE_COMMON, false, false, RANGES, false},
    {"SVO_K_SCAN_LISTS_PARTIALS", SCAN, BASE_COMMON, false, false, RANGES, false},
    {"SVO_K_SCAN_LISTS_ADD", SCAN, BASE_COMMON, false, false, RANGES, false},
    {"SVO_K_SCATTER", PACK, BASE_FRAGMENT, false, false, SVO_NEED_RAYS, false},
    {"SVO_K_SORT_SHORT", PACK, BASE_COMMON, false, false, SVO_NEED_RAYS, false},
    {"SVO_K_SORT_LONG", PACK, BASE_COMMON, false, false, SVO_NEED_RAYS, false},
    {"SVO_K_MATERIAL_SCATTER", MATERIAL, BASE_ATTRIBUTE, true, false, SVO_NEED_MATERIAL, false},
    {"SVO_K_MATERIAL_LEAVES", MATERIAL, BASE_COMMON, true, false, SVO_NEED_MATERIAL, false},
    {"SVO_K_MATERIAL_PASS", MATERIAL, BASE_COMMON, true, false, SVO_NEED_MATERIAL, true},
    {"SVO_K_MATERIAL_ROOM", MATERIAL, BASE_COMMON, true, false, SVO_NEED_MATERIAL, false},
    {"SVO_K_MATERIAL_MERGE", MATERIAL, BASE_COMMON, true, false, SVO_NEED_MATERIAL, false},
    {"SVO_K_GATHER", FILTER, BASE_ATTRIBUTE, true, false, SVO_I_NEED_FILTER, false},
    {"SVO_K_FILTER", FILTER, BASE_COMMON, true, false, SVO_I_NEED_FILTER, false},
    {"SVO_K_AREA", AREA, BASE_ATTRIBUTE, true, false, SVO_NEED_PROJECTED_AREA, false},
    {"SVO_K_ROUND_AREAS", AREA, BASE_ATTRIBUTE, true, false, SVO_NEED_PROJECTED_AREA, false},
};

/* A field of the parameters and the name of its uniform. */
typedef struct field {
    const char *name;
    size_t offset;
} field;

#define SUBDIVIDE_FIELD(name)                                 \
    {                                                         \
        "params." #name, offsetof(svo_subdivide_params, name) \
    }
static const field subdivide_fields[] = {SUBDIVIDE_FIELD(depth), SUBDIVIDE_FIELD(level),
                                         SUBDIVIDE_FIELD(inner_capacity), SUBDIVIDE_FIELD(fragment_count)};

#define FILTER_FIELD(name)                                 \
    {                                                      \
        "params." #name, offsetof(svo_filter_params, name) \
    }
static const field filter_fields[] = {
    FILTER_FIELD(depth),       FILTER_FIELD(level),          FILTER_FIELD(level_begin),  FILTER_FIELD(level_count),
    FILTER_FIELD(child_begin), FILTER_FIELD(fragment_count), FILTER_FIELD(leaf_begin),   FILTER_FIELD(leaf_count),
    FILTER_FIELD(voxel_log2),  FILTER_FIELD(first_chunk),    FILTER_FIELD(digit_passes), FILTER_FIELD(weight_log2),
    FILTER_FIELD(fill_shift),  FILTER_FIELD(both_sides)};

static size_t fields_of(svo_i_entry entry, const field **out)
{
    *out = shapes[entry].subdivides ? subdivide_fields : filter_fields;
    return shapes[entry].subdivides ? sizeof subdivide_fields / sizeof subdivide_fields[0]
                                    : sizeof filter_fields / sizeof filter_fields[0];
}

/* " -DSVO_A -DSVO_B" as lines of "#define SVO_A". */
static void defines_to_lines(const char *defines, char *lines, size_t lines_bytes)
{
    size_t used = 0;
    lines[0] = '\0';
    for (const char *at = strstr(defines, " -D"); at != NULL && used < lines_bytes; at = strstr(at + 3, " -D")) {
        used += (size_t)snprintf(lines + used, lines_bytes - used, "#define %.*s\n", (int)strcspn(at + 3, " "), at + 3);
    }
}

/* The plan's defines that the entry point takes. */
static const char *defines_of(const svo_i_compute *compute, svo_i_entry entry)
{
    static const char code48[] = " -DSVO_CODE48";
    if (shapes[entry].has_64_bits) {
        return compute->defines;
    }
    return shapes[entry].base != BASE_COMMON && strstr(compute->defines, code48) != NULL ? code48 : "";
}

static svo_status compile_shader(const svo_i_shader_maker *maker, const entry_shape *shape, const char *defines,
                                 GLuint *out)
{
    char lines[2 * SVO_I_DEFINES_BYTES];
    defines_to_lines(defines, lines, sizeof lines);
    const char *sources[] = {
        "#version 430 core\n",
        shape->has_64_bits ? "#extension GL_ARB_gpu_shader_int64 : require\n#define SVO_INT64\n" : "",
        lines,
        "#define ",
        shape->define,
        "\n",
        svo_i_source_compute_common,
        shape->base >= BASE_FRAGMENT ? svo_i_source_compute_fragment : "",
        shape->base >= BASE_ATTRIBUTE ? svo_i_source_compute_attribute : "",
        shape->source,
    };
    return svo_i_shader_compile(maker, GL_COMPUTE_SHADER, sources, sizeof sources / sizeof sources[0], out);
}

static void find_uniforms(const svo_i_gl_functions *gl, svo_i_compute_program *program)
{
    const field *fields = NULL;
    const size_t count = fields_of(program->entry, &fields);
    for (size_t i = 0; i < count; ++i) {
        program->fields[i] = gl->GetUniformLocation(program->name, fields[i].name);
    }
    for (unsigned binding = 0; binding < SVO_I_COMPUTE_BLOCKS; ++binding) {
        char name[24];
        (void)snprintf(name, sizeof name, "svo_first[%u]", binding);
        program->first[binding] = gl->GetUniformLocation(program->name, name);
    }
    program->window_begin = gl->GetUniformLocation(program->name, "window_begin");
    program->window_count = gl->GetUniformLocation(program->name, "window_count");
    program->vertex_count = gl->GetUniformLocation(program->name, "vertex_count");
    program->first_triangle = gl->GetUniformLocation(program->name, "first_triangle");
    program->triangle_count = gl->GetUniformLocation(program->name, "triangle_count");
    program->texel_block_log2 = gl->GetUniformLocation(program->name, "texel_block_log2");
}

/* Sets the parameters' uniforms of the program in use. params: NULL means zeros. */
static void set_params(const svo_i_compute *compute, const svo_i_compute_program *program, const void *params)
{
    const field *fields = NULL;
    const size_t count = fields_of(program->entry, &fields);
    for (size_t i = 0; i < count; ++i) {
        uint32_t value = 0;
        if (params != NULL) {
            memcpy(&value, (const char *)params + fields[i].offset, sizeof value);
        }
        compute->gl->Uniform1ui(program->fields[i], value);
    }
}

static void set_mesh(const svo_i_compute *compute, const svo_i_compute_program *program, const svo_i_launch_mesh *mesh)
{
    compute->gl->Uniform1ui(program->vertex_count, mesh->vertex_count);
    compute->gl->Uniform1ui(program->first_triangle, mesh->first_triangle);
    compute->gl->Uniform1ui(program->triangle_count, mesh->triangle_count);
    compute->gl->Uniform1ui(program->texel_block_log2, mesh->texel_block_log2);
}

/* Drivers compile a shader at its first launch: launches one group on a buffer of zeros. */
static svo_status warm_up(svo_i_compute *compute, const svo_i_compute_program *program)
{
    const svo_i_gl_functions *gl = compute->gl;
    svo_status status = SVO_OK;
    GLuint zeros = 0;
    SVO_I_TRY_CLEANUP(svo_i_compute_alloc_zero(compute, "zeros", 4096, &zeros));
    for (GLuint i = 0; i < SVO_I_COMPUTE_BINDINGS; ++i) {
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, zeros);
    }
    gl->UseProgram(program->name);
    set_params(compute, program, NULL);
    gl->DispatchCompute(1, 1, 1);
    gl->Finish();
    SVO_I_TRY_CLEANUP(check(compute, "launching a shader on nothing"));
cleanup:
    svo_i_compute_free(compute, &zeros);
    return status;
}

static svo_status make_program(svo_i_compute *compute, svo_i_compute_program *program)
{
    const entry_shape *shape = &shapes[program->entry];
    const svo_i_shader_maker maker = {compute->device, compute->gl, SVO_I_GL_BUILD, shape->define};
    GLuint shader = 0;
    SVO_I_TRY(compile_shader(&maker, shape, program->defines, &shader));
    const svo_status linked = svo_i_shader_link(&maker, &shader, 1, &program->name);
    compute->gl->DeleteShader(shader);
    SVO_I_TRY(linked);
    find_uniforms(compute->gl, program);
    return warm_up(compute, program);
}

svo_status svo_i_compute_program_get(svo_i_compute *compute, svo_i_entry entry, svo_i_compute_program **out)
{
    const char *defines = defines_of(compute, entry);
    for (svo_i_compute_program *known = compute->programs; known != NULL; known = known->next) {
        if (known->entry == entry && strcmp(known->defines, defines) == 0) {
            *out = known;
            return SVO_OK;
        }
    }
    svo_i_compute_program *program = svo_i_alloc_zeroed(&compute->device->memory, 1, sizeof *program);
    if (program == NULL) {
        return svo_i_device_fail(compute->device, SVO_OUT_OF_HOST_MEMORY, SVO_I_GL_BUILD ": no memory for a program");
    }
    const double start_ms = svo_i_now_ms();
    program->entry = entry;
    memcpy(program->defines, defines, strlen(defines) + 1);
    const svo_status status = make_program(compute, program);
    compute->device->compile_ms += svo_i_now_ms() - start_ms;
    if (status != SVO_OK) {
        compute->gl->DeleteProgram(program->name);
        svo_i_free(program);
        return status;
    }
    program->next = compute->programs;
    compute->programs = program;
    *out = program;
    return SVO_OK;
}

static void destroy_programs(svo_i_compute *compute)
{
    while (compute->programs != NULL) {
        svo_i_compute_program *dying = compute->programs;
        compute->programs = dying->next;
        compute->gl->DeleteProgram(dying->name);
        svo_i_free(dying);
    }
}

svo_status svo_i_compute_prepare(svo_i_compute *compute, const svo_plan *plan)
{
    const uint32_t need = plan->work.made | (plan->work.lists ? (uint32_t)SVO_NEED_RAYS : 0u);
    svo_i_gl_clear_errors(compute->gl);
    svo_i_plan_defines(plan, &svo_i_program_filter, compute->defines, sizeof compute->defines);
    for (svo_i_entry entry = 0; entry < SVO_I_ENTRIES; ++entry) {
        svo_i_compute_program *program = NULL;
        if (!shapes[entry].is_rare && (shapes[entry].need == 0 || (shapes[entry].need & need) != 0)) {
            SVO_I_TRY(svo_i_compute_program_get(compute, entry, &program));
        }
    }
    return SVO_OK;
}

/* ---- launches ---- */

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

svo_i_range svo_i_range_of(uint64_t begin, uint64_t end, unsigned element_bytes)
{
    return (svo_i_range){.begin_bytes = begin * element_bytes, .bytes = (end - begin) * element_bytes};
}

/* Offsets of ranges are multiples of this many bytes, which OpenGL's own alignment divides. */
#define RANGE_ALIGNMENT SVO_I_RANGE_SLACK

/* Binds what the launch reads and writes, and tells the program in use where ranges begin. */
static void bind_buffers(const svo_i_compute *compute, const svo_i_compute_program *program, const svo_i_launch *launch)
{
    const svo_i_gl_functions *gl = compute->gl;
    for (GLuint binding = 0; binding < SVO_I_COMPUTE_BLOCKS; ++binding) {
        const GLuint buffer = launch->buffers[binding];
        const svo_i_range *range = &launch->ranges[binding];
        const uint64_t begin = range->begin_bytes / RANGE_ALIGNMENT * RANGE_ALIGNMENT;
        if (buffer != 0 && (range->bytes == 0 || range->local)) {
            gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer);
        } else if (buffer != 0) {
            gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, buffer, (GLintptr)begin,
                                (GLsizeiptr)padded(range->begin_bytes - begin + range->bytes));
        }
        gl->Uniform1ui(program->first[binding], (GLuint)(begin / 4));
    }
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, SVO_I_COMPUTE_EXHAUSTED, compute->exhausted);
}

svo_status svo_i_compute_launch(svo_i_compute *compute, const svo_i_launch *launch)
{
    const svo_i_gl_functions *gl = compute->gl;
    svo_i_compute_program *program = NULL;
    if (launch->indirect == 0 && launch->items == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_compute_program_get(compute, launch->entry, &program));
    gl->UseProgram(program->name);
    bind_buffers(compute, program, launch);
    set_params(compute, program, launch->params);
    set_mesh(compute, program, &launch->mesh);
    gl->Uniform1ui(program->window_begin, launch->window_begin);
    gl->Uniform1ui(program->window_count, launch->window_count);
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                      (launch->indirect != 0 ? GL_COMMAND_BARRIER_BIT : 0u));
    dispatch(gl, launch);
    return check(compute, "launching a compute shader");
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
        return check(compute, svo_name(SVO_NAME_STAGE, stage));
    }
    GLuint64 begin_ns = 0;
    GLuint64 end_ns = 0;
    gl->QueryCounter(compute->queries[1], GL_TIMESTAMP);
    gl->GetQueryObjectui64v(compute->queries[0], GL_QUERY_RESULT, &begin_ns);
    gl->GetQueryObjectui64v(compute->queries[1], GL_QUERY_RESULT, &end_ns);
    svo_i_report_add(build->commands.report, stage, (double)(end_ns - begin_ns) * 1e-6, "gl-timer");
    return check(compute, svo_name(SVO_NAME_STAGE, stage));
}

/* ---- stages ---- */

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

/* ---- the builder ---- */

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
        destroy_programs(dying);
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
    /* Among the entry points without payload, two have the most blocks: SVO_I_ENTRY_DECIDE six, and
       SVO_I_ENTRY_SORT_LONG five and exhausted. */
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
