/* SPDX-License-Identifier: MIT */
/*
 * The programs of the compute shaders: one per entry point and set of defines, compiled on first use. They share
 * kernels/shared/integer.clh and clip.clh with the OpenCL kernels, as the same text.
 */
#include "compute/program.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "compute/buffer.h"
#include "context/shader.h"
#include "core/message.h"
#include "plan/configuration.h"
#include "stages/programs.h"

/* Made by cmake/embed.cmake. */
extern const char svo_i_source_compute_common[];
extern const char svo_i_source_compute_fragment[];
extern const char svo_i_source_compute_attribute[];
extern const char svo_i_source_compute_subdivide[];
extern const char svo_i_source_compute_scan[];
extern const char svo_i_source_compute_link[];
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

#define SUBDIVIDE svo_i_source_compute_subdivide
#define SCAN      svo_i_source_compute_scan
#define LINK      svo_i_source_compute_link
#define PACK      svo_i_source_compute_pack
#define FILTER    svo_i_source_compute_filter
#define AREA      svo_i_source_compute_area
#define MATERIAL  svo_i_source_compute_material

static const entry_shape shapes[SVO_I_ENTRIES] = {
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
    {"SVO_K_MATERIAL_MERGE", MATERIAL, BASE_COMMON, true, false, SVO_NEED_MATERIAL, false},
    {"SVO_K_LINK", LINK, BASE_COMMON, false, false, SVO_I_NEED_FILTER, false},
    {"SVO_K_GATHER_LEVEL", FILTER, BASE_ATTRIBUTE, true, false, SVO_I_NEED_FILTER, false},
    {"SVO_K_GATHER", FILTER, BASE_ATTRIBUTE, true, false, SVO_I_NEED_FILTER, true},
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
    program->vertex_count = gl->GetUniformLocation(program->name, "vertex_count");
}

void svo_i_compute_program_set(const svo_i_compute *compute, const svo_i_compute_program *program, const void *params)
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
    svo_i_compute_program_set(compute, program, NULL);
    gl->DispatchCompute(1, 1, 1);
    gl->Finish();
    SVO_I_TRY_CLEANUP(svo_i_compute_check(compute, "launching a shader on nothing"));
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

void svo_i_compute_programs_destroy(svo_i_compute *compute)
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
