/* SPDX-License-Identifier: MIT */
/* Fills the table of a context's OpenGL entry points when the context is created. */
#include "context/functions.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "core/message.h"

/* ---- the table ---- */

typedef struct entry_point {
    const char *name;
    size_t offset_bytes; /* into svo_i_gl_functions */
    int core_version;
    const char *extension;
} entry_point;

static const entry_point entry_points[] = {
#define ENTRY_POINT(member, type, core_version, extension) \
    {"gl" #member, offsetof(svo_i_gl_functions, member), core_version, extension},
    SVO_I_GL_FUNCTION_LIST(ENTRY_POINT)
#undef ENTRY_POINT
};
enum { ENTRY_POINT_COUNT = sizeof entry_points / sizeof entry_points[0], EXTENSIONS_MAX = 4096 };

/* The function that messages name. */
#define FUNCTION "svo_gl_context_create"

static const char *gl_error_name(GLenum error)
{
    static const struct {
        GLenum error;
        const char *name;
    } names[] = {
#define GL_ERROR(name) {name, #name}
        GL_ERROR(GL_INVALID_ENUM),      GL_ERROR(GL_INVALID_VALUE),
        GL_ERROR(GL_INVALID_OPERATION), GL_ERROR(GL_INVALID_FRAMEBUFFER_OPERATION),
        GL_ERROR(GL_OUT_OF_MEMORY),     GL_ERROR(GL_CONTEXT_LOST),
#undef GL_ERROR
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (names[i].error == error) {
            return names[i].name;
        }
    }
    return "unknown error";
}

static svo_status fail_error(const char *function, const char *step, GLenum error, svo_message *message)
{
    const svo_status status = error == GL_OUT_OF_MEMORY ? SVO_OUT_OF_DEVICE_MEMORY : SVO_GL_ERROR;
    return svo_i_fail(message, status, "%s: %s: %s (0x%04x)", function, step, gl_error_name(error), error);
}

/* Stores the pointer in the table, whatever its type: all function pointers have one representation. */
static void store_function(svo_i_gl_functions *gl, const entry_point *entry, svo_i_function function)
{
    memcpy((char *)gl + entry->offset_bytes, &function, sizeof function);
}

/* Looks up all required functions. Returns the name of the first missing one, or NULL. */
static const char *load_required(svo_i_gl_functions *gl, svo_i_get_proc_address get_proc_address, void *user)
{
    const char *missing = NULL;
    for (size_t i = 0; i < ENTRY_POINT_COUNT; ++i) {
        if (entry_points[i].core_version > SVO_I_GL_MINIMUM_VERSION) {
            continue;
        }
        svo_i_function function = get_proc_address(user, entry_points[i].name);
        store_function(gl, &entry_points[i], function);
        if (function == NULL && missing == NULL) {
            missing = entry_points[i].name;
        }
    }
    return missing;
}

static svo_status fail_missing(const char *missing, svo_message *message)
{
    return svo_i_fail(message, SVO_NO_GL, FUNCTION ": the context has no function %s", missing);
}

static void load_optional(svo_i_gl_functions *gl, svo_i_get_proc_address get_proc_address, void *user)
{
    for (size_t i = 0; i < ENTRY_POINT_COUNT; ++i) {
        const entry_point *entry = &entry_points[i];
        if (entry->core_version <= SVO_I_GL_MINIMUM_VERSION) {
            continue;
        }
        if (gl->version >= entry->core_version || svo_i_gl_has_extension(gl, entry->extension)) {
            store_function(gl, entry, get_proc_address(user, entry->name));
        }
    }
}

static const char *driver_string(const svo_i_gl_functions *gl, GLenum name)
{
    const char *text = (const char *)gl->GetString(name);
    return text != NULL ? text : "";
}

static svo_status load_version(svo_i_gl_functions *gl, svo_message *message)
{
    GLint major = 0, minor = 0; /* stay 0 below OpenGL 3.0, which has no such query */
    gl->GetIntegerv(GL_MAJOR_VERSION, &major);
    gl->GetIntegerv(GL_MINOR_VERSION, &minor);
    gl->version = major * 10 + minor;
    gl->vendor = driver_string(gl, GL_VENDOR);
    gl->renderer = driver_string(gl, GL_RENDERER);
    gl->version_text = driver_string(gl, GL_VERSION);
    SVO_I_TRY(svo_i_gl_check_query(gl, FUNCTION, "reading the version", message));
    if (gl->version_text[0] == '\0') {
        return svo_i_fail(message, SVO_NO_GL,
                          FUNCTION ": the context does not report its version; is it current on this thread?");
    }
    if (gl->version < SVO_I_GL_MINIMUM_VERSION) {
        return svo_i_fail(message, SVO_NO_GL, FUNCTION ": OpenGL \"%s\" of \"%s\" is below %d.%d", gl->version_text,
                          gl->renderer, SVO_I_GL_MINIMUM_VERSION / 10, SVO_I_GL_MINIMUM_VERSION % 10);
    }
    return SVO_OK;
}

/* Appends an extension name and a space to gl->extensions, of which bytes are used. */
static svo_status add_extension(svo_i_gl_functions *gl, const svo_i_memory *memory, const char *name, size_t *bytes,
                                svo_message *message)
{
    const size_t length = strlen(name);
    const size_t needed = *bytes + length + 2;
    char *longer = svo_i_grow(memory, gl->extensions, needed);
    if (longer == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, FUNCTION ": no %zu bytes for the extension names", needed);
    }
    (void)snprintf(longer + *bytes, length + 2, "%s ", name);
    gl->extensions = longer;
    *bytes = needed - 1;
    return SVO_OK;
}

/* Joins the extension names into one string, to be searched without the context being current. Each name is asked for
   once: a driver that fails may give another answer the second time. */
static svo_status load_extensions(svo_i_gl_functions *gl, const svo_i_memory *memory, svo_message *message)
{
    GLint count = 0;
    gl->GetIntegerv(GL_NUM_EXTENSIONS, &count);
    count = count < EXTENSIONS_MAX ? count : EXTENSIONS_MAX; /* in case the driver returns nonsense */
    size_t bytes = 0;
    for (GLint i = 0; i < count; ++i) {
        const char *name = (const char *)gl->GetStringi(GL_EXTENSIONS, (GLuint)i);
        SVO_I_TRY(name != NULL ? add_extension(gl, memory, name, &bytes, message) : SVO_OK);
    }
    return svo_i_gl_check(gl, FUNCTION, "reading the extensions", message);
}

static GLint integer_limit(const svo_i_gl_functions *gl, GLenum name)
{
    GLint value = 0;
    gl->GetIntegerv(name, &value);
    return value;
}

static void load_limits(svo_i_gl_functions *gl)
{
    svo_i_gl_limits *limits = &gl->limits;
    gl->GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limits->storage_block_bytes);
    limits->storage_offset_alignment_bytes = integer_limit(gl, GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT);
    limits->storage_bindings = integer_limit(gl, GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS);
    limits->vertex_storage_blocks = integer_limit(gl, GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS);
    limits->fragment_storage_blocks = integer_limit(gl, GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS);
    limits->compute_storage_blocks = integer_limit(gl, GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS);
    limits->framebuffer_width = integer_limit(gl, GL_MAX_FRAMEBUFFER_WIDTH);
    limits->framebuffer_height = integer_limit(gl, GL_MAX_FRAMEBUFFER_HEIGHT);
    limits->compute_group_invocations = integer_limit(gl, GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS);

    GLint viewport[2] = {0, 0};
    gl->GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    limits->viewport_width = viewport[0];
    limits->viewport_height = viewport[1];
}

/* Everything up to the extension names. A failure leaves the table partly filled. */
static svo_status load_core(svo_i_gl_functions *gl, svo_i_get_proc_address get_proc_address, void *user,
                            const svo_i_memory *memory, svo_message *message)
{
    const char *missing = load_required(gl, get_proc_address, user);
    if (gl->GetIntegerv == NULL || gl->GetString == NULL || gl->GetStringi == NULL || gl->GetError == NULL) {
        return fail_missing(missing, message);
    }
    svo_i_gl_clear_errors(gl);
    /* An old context lacks functions too, but its version explains the failure better. */
    SVO_I_TRY(load_version(gl, message));
    if (missing != NULL) {
        return fail_missing(missing, message);
    }
    return load_extensions(gl, memory, message);
}

svo_status svo_i_gl_load(svo_i_gl_functions *gl, svo_i_get_proc_address get_proc_address, void *user,
                         const svo_i_memory *memory, svo_message *message)
{
    *gl = (svo_i_gl_functions){0};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(load_core(gl, get_proc_address, user, memory, message));
    load_optional(gl, get_proc_address, user);
    load_limits(gl);
    SVO_I_TRY_CLEANUP(svo_i_gl_check_query(gl, FUNCTION, "reading the limits", message));
    return SVO_OK;
cleanup:
    svo_i_gl_unload(gl);
    return status;
}

void svo_i_gl_unload(svo_i_gl_functions *gl)
{
    svo_i_free(gl->extensions);
    *gl = (svo_i_gl_functions){0};
}

bool svo_i_gl_has_extension(const svo_i_gl_functions *gl, const char *extension)
{
    return svo_i_list_has_token(gl->extensions, extension);
}

bool svo_i_gl_is_software(const svo_i_gl_functions *gl)
{
    /* A layered driver names the one below in brackets: "zink (llvmpipe ...)". */
    static const char *const names[] = {"llvmpipe", "softpipe", "swrast", "SWR", "lavapipe", "SwiftShader", "Software"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strstr(gl->renderer, names[i]) != NULL) {
            return true;
        }
    }
    return false;
}

void svo_i_gl_clear_errors(const svo_i_gl_functions *gl)
{
    /* Bounded: a lost context may report errors forever. */
    for (int i = 0; i < 64 && gl->GetError() != GL_NO_ERROR; ++i) {
    }
}

svo_status svo_i_gl_check_query(const svo_i_gl_functions *gl, const char *function, const char *step,
                                svo_message *message)
{
    const GLenum error = gl->GetError();
    svo_i_gl_clear_errors(gl);
    return error == GL_NO_ERROR || error == GL_INVALID_ENUM ? SVO_OK : fail_error(function, step, error, message);
}

svo_status svo_i_gl_check(const svo_i_gl_functions *gl, const char *function, const char *step, svo_message *message)
{
    if (gl->GetGraphicsResetStatus != NULL && gl->GetGraphicsResetStatus() != GL_NO_ERROR) {
        svo_i_gl_clear_errors(gl);
        return svo_i_fail(message, SVO_GL_ERROR, "%s: %s: the context was lost", function, step);
    }
    GLenum error = gl->GetError();
    if (error == GL_NO_ERROR) {
        return SVO_OK;
    }
    svo_i_gl_clear_errors(gl);
    return fail_error(function, step, error, message);
}

/* ---- shaders ---- */

/* SVO_OK, or the first OpenGL error with what was being made. */
static svo_status check(const svo_i_shader_maker *maker, const char *step, svo_message *message)
{
    char text[128];
    (void)snprintf(text, sizeof text, "%s %s", step, maker->name);
    return svo_i_gl_check(maker->gl, maker->function, text, message);
}

/* What has a log: a shader or a program, with the two functions that read it. 0: it could not be created. */
typedef struct logged {
    GLuint name;
    PFNGLGETSHADERIVPROC get;
    PFNGLGETSHADERINFOLOGPROC get_log;
} logged;

static logged of_shader(const svo_i_gl_functions *gl, GLuint shader)
{
    return (logged){shader, gl->GetShaderiv, gl->GetShaderInfoLog};
}

static logged of_program(const svo_i_gl_functions *gl, GLuint program)
{
    return (logged){program, gl->GetProgramiv, gl->GetProgramInfoLog};
}

/* The whole log; NULL where there is none, or no memory for it. */
static char *read_log(const svo_i_shader_maker *maker, logged made)
{
    GLint bytes = 0;
    if (made.name != 0) {
        made.get(made.name, GL_INFO_LOG_LENGTH, &bytes);
    }
    char *log = bytes > 0 ? svo_i_alloc_zeroed(&maker->device->memory, (size_t)bytes + 1, 1) : NULL;
    if (log != NULL) {
        made.get_log(made.name, bytes, NULL, log);
    }
    return log;
}

/* Puts the first line of a shader's or a program's log into the message and passes all of it to the log callback. */
static svo_status fail_log(const svo_i_shader_maker *maker, const char *step, logged made)
{
    char *text = read_log(maker, made);
    const char *log = text != NULL ? text : "";
    svo_i_device_log(maker->device, SVO_LOG_ERROR, log);
    /* Out of memory is no mistake in the text, and without a log OpenGL's error says the most. */
    svo_message error = {""};
    const svo_status status = check(maker, step, &error);
    if (status == SVO_OUT_OF_DEVICE_MEMORY || (status != SVO_OK && log[0] == '\0')) {
        svo_i_free(text);
        return svo_i_device_fail(maker->device,
                                 status == SVO_OUT_OF_DEVICE_MEMORY ? SVO_OUT_OF_DEVICE_MEMORY : SVO_COMPILE_FAILED,
                                 "%s", error.text);
    }
    (void)svo_i_device_fail(maker->device, SVO_COMPILE_FAILED, "%s: %s %s on %s: %.*s", maker->function, step,
                            maker->name, maker->gl->renderer, (int)strcspn(log, "\n"), log);
    svo_i_free(text);
    return SVO_COMPILE_FAILED;
}

svo_status svo_i_shader_compile(const svo_i_shader_maker *maker, GLenum stage, const char *const *texts,
                                GLsizei text_count, GLuint *out)
{
    const svo_i_gl_functions *gl = maker->gl;
    const GLuint shader = gl->CreateShader(stage);
    if (shader == 0) {
        return fail_log(maker, "creating a shader for", of_shader(gl, 0));
    }
    gl->ShaderSource(shader, text_count, texts, NULL);
    gl->CompileShader(shader);
    GLint compiled = GL_FALSE;
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled != GL_TRUE) {
        const svo_status status = fail_log(maker, "compiling", of_shader(gl, shader));
        gl->DeleteShader(shader);
        return status;
    }
    const svo_status status = check(maker, "compiling", &maker->device->message);
    if (status != SVO_OK) {
        gl->DeleteShader(shader);
        return status;
    }
    *out = shader;
    return SVO_OK;
}

svo_status svo_i_shader_link(const svo_i_shader_maker *maker, const GLuint *shaders, unsigned shader_count, GLuint *out)
{
    const svo_i_gl_functions *gl = maker->gl;
    const GLuint program = gl->CreateProgram();
    if (program == 0) {
        return fail_log(maker, "creating a program for", of_program(gl, 0));
    }
    for (unsigned i = 0; i < shader_count; ++i) {
        gl->AttachShader(program, shaders[i]);
    }
    gl->LinkProgram(program);
    GLint linked = GL_FALSE;
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked != GL_TRUE) {
        const svo_status status = fail_log(maker, "linking", of_program(gl, program));
        gl->DeleteProgram(program);
        return status;
    }
    const svo_status status = check(maker, "linking", &maker->device->message);
    if (status != SVO_OK) {
        gl->DeleteProgram(program);
        return status;
    }
    *out = program;
    return SVO_OK;
}
