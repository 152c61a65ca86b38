/* SPDX-License-Identifier: MIT */
/*
 * Off-screen contexts by EGL: on Mesa's surfaceless platform, or on a device of EGL_EXT_platform_device.
 *
 * All users of a platform in one process share its display, and eglTerminate ends it for all of them: for svocl's other
 * contexts and for the application. The library keeps no global count of displays, so it never calls eglTerminate. At
 * most one initialized display per platform or device remains, regardless of the number of contexts.
 */
#include "context/egl.h"

#include <stdio.h>

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "core/message.h"

/* X(member, type): the functions of libEGL that svocl uses, looked up as "egl" + member. */
#define EGL_FUNCTION_LIST(X)                          \
    X(GetError, PFNEGLGETERRORPROC)                   \
    X(GetProcAddress, PFNEGLGETPROCADDRESSPROC)       \
    X(QueryString, PFNEGLQUERYSTRINGPROC)             \
    X(Initialize, PFNEGLINITIALIZEPROC)               \
    X(BindAPI, PFNEGLBINDAPIPROC)                     \
    X(QueryAPI, PFNEGLQUERYAPIPROC)                   \
    X(ChooseConfig, PFNEGLCHOOSECONFIGPROC)           \
    X(CreateContext, PFNEGLCREATECONTEXTPROC)         \
    X(DestroyContext, PFNEGLDESTROYCONTEXTPROC)       \
    X(MakeCurrent, PFNEGLMAKECURRENTPROC)             \
    X(GetCurrentContext, PFNEGLGETCURRENTCONTEXTPROC) \
    X(GetCurrentDisplay, PFNEGLGETCURRENTDISPLAYPROC) \
    X(GetCurrentSurface, PFNEGLGETCURRENTSURFACEPROC)

typedef struct egl_library {
    void *library;
#define EGL_MEMBER(member, type) type member;
    EGL_FUNCTION_LIST(EGL_MEMBER)
#undef EGL_MEMBER
} egl_library;

typedef struct egl_context {
    svo_i_memory memory;
    egl_library egl;
    EGLDisplay display;
    EGLContext context;
    EGLDeviceEXT device; /* EGL_NO_DEVICE_EXT on the surfaceless platform */
} egl_context;

static const char *egl_error_name(EGLint error)
{
    static const struct {
        EGLint error;
        const char *name;
    } names[] = {
#define EGL_ERROR(name) {name, #name}
        EGL_ERROR(EGL_SUCCESS),       EGL_ERROR(EGL_NOT_INITIALIZED), EGL_ERROR(EGL_BAD_ACCESS),
        EGL_ERROR(EGL_BAD_ALLOC),     EGL_ERROR(EGL_BAD_ATTRIBUTE),   EGL_ERROR(EGL_BAD_CONFIG),
        EGL_ERROR(EGL_BAD_CONTEXT),   EGL_ERROR(EGL_BAD_DISPLAY),     EGL_ERROR(EGL_BAD_MATCH),
        EGL_ERROR(EGL_BAD_PARAMETER), EGL_ERROR(EGL_BAD_DEVICE_EXT),  EGL_ERROR(EGL_CONTEXT_LOST),
#undef EGL_ERROR
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (names[i].error == error) {
            return names[i].name;
        }
    }
    return "unknown error";
}

static svo_status fail_step(const egl_library *egl, const char *step, svo_message *message)
{
    EGLint error = egl->GetError();
    return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: %s failed: %s (0x%04x)", step, egl_error_name(error),
                      (unsigned)error);
}

/* Fills the table from an open library. The message names the first missing function. */
static svo_status egl_library_fill(egl_library *egl, svo_message *message)
{
    const char *missing = NULL;
#define EGL_FILL(member, type)                                               \
    egl->member = (type)svo_i_library_function(egl->library, "egl" #member); \
    if (egl->member == NULL && missing == NULL) {                            \
        missing = "egl" #member;                                             \
    }
    EGL_FUNCTION_LIST(EGL_FILL)
#undef EGL_FILL
    if (missing != NULL) {
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: " SVO_I_EGL_LIBRARY " has no function %s",
                          missing);
    }
    return SVO_OK;
}

static svo_status egl_library_open(egl_library *egl, svo_message *message)
{
    SVO_I_TRY(svo_i_library_open(SVO_I_EGL_LIBRARY, &egl->library, message));
    return egl_library_fill(egl, message);
}

static bool has_client_extension(const egl_library *egl, const char *extension)
{
    return svo_i_list_has_token(egl->QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), extension);
}

static svo_status require_client_extension(const egl_library *egl, const char *extension, svo_message *message)
{
    if (!has_client_extension(egl, extension)) {
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: EGL does not list %s", extension);
    }
    return SVO_OK;
}

/* How many devices EGL has; 0, and no function, where it cannot list them. */
static svo_status count_devices(const egl_library *egl, PFNEGLQUERYDEVICESEXTPROC *query_devices, uint32_t *count,
                                svo_message *message)
{
    EGLint all = 0;
    *query_devices = NULL;
    *count = 0;
    if (!has_client_extension(egl, "EGL_EXT_device_enumeration") && !has_client_extension(egl, "EGL_EXT_device_base")) {
        return SVO_OK;
    }
    *query_devices = (PFNEGLQUERYDEVICESEXTPROC)egl->GetProcAddress("eglQueryDevicesEXT");
    if (*query_devices == NULL) {
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: EGL has no function eglQueryDevicesEXT");
    }
    if (!(*query_devices)(0, NULL, &all)) {
        return fail_step(egl, "eglQueryDevicesEXT", message);
    }
    *count = (uint32_t)all;
    return SVO_OK;
}

/* The devices of EGL; none where it cannot list them. */
static svo_status list_devices(const egl_library *egl, const svo_i_memory *memory, EGLDeviceEXT **devices,
                               uint32_t *count, svo_message *message)
{
    PFNEGLQUERYDEVICESEXTPROC query_devices = NULL;
    EGLint listed = 0;
    *devices = NULL;
    SVO_I_TRY(count_devices(egl, &query_devices, count, message));
    if (query_devices == NULL) {
        return SVO_OK;
    }
    *devices = svo_i_alloc_zeroed(memory, (size_t)*count + 1, sizeof(EGLDeviceEXT));
    if (*devices == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_gl_context_create: no memory for %u devices", *count);
    }
    if (!query_devices((EGLint)*count, *devices, &listed)) {
        svo_i_free(*devices);
        *devices = NULL;
        return fail_step(egl, "eglQueryDevicesEXT", message);
    }
    *count = (uint32_t)listed;
    return SVO_OK;
}

svo_status svo_i_egl_count_devices(uint32_t *count, svo_message *message)
{
    svo_status status = SVO_OK;
    egl_library egl = {0};
    PFNEGLQUERYDEVICESEXTPROC query_devices = NULL;
    *count = 0;
    SVO_I_TRY_CLEANUP(egl_library_open(&egl, message));
    SVO_I_TRY_CLEANUP(count_devices(&egl, &query_devices, count, message));
cleanup:
    svo_i_library_close(egl.library);
    return status;
}

uint32_t svo_gl_egl_device_count(void)
{
    uint32_t count = 0;
    (void)svo_i_egl_count_devices(&count, NULL);
    return count;
}

/* What a device lists, without a display of it; NULL where EGL cannot say. */
static const char *device_extensions(const egl_library *egl, EGLDeviceEXT device)
{
    if (!has_client_extension(egl, "EGL_EXT_device_query") && !has_client_extension(egl, "EGL_EXT_device_base")) {
        return NULL;
    }
    PFNEGLQUERYDEVICESTRINGEXTPROC query_string =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)egl->GetProcAddress("eglQueryDeviceStringEXT");
    return query_string != NULL ? query_string(device, EGL_EXTENSIONS) : NULL;
}

bool svo_i_egl_device_is_software(const char *extensions)
{
    return svo_i_list_has_token(extensions, "EGL_MESA_device_software");
}

/* A device with a kernel driver is a GPU. Mesa's software device has none and lists an extension that says so. */
bool svo_i_egl_device_is_gpu(const char *extensions)
{
    return !svo_i_egl_device_is_software(extensions) && (svo_i_list_has_token(extensions, "EGL_EXT_device_drm") ||
                                                         svo_i_list_has_token(extensions, "EGL_NV_device_cuda"));
}

svo_status svo_i_egl_find_software(bool *software, uint32_t room, uint32_t *count, svo_message *message)
{
    svo_status status = SVO_OK;
    egl_library egl = {0};
    EGLDeviceEXT *devices = NULL;
    *count = 0;
    SVO_I_TRY_CLEANUP(egl_library_open(&egl, message));
    SVO_I_TRY_CLEANUP(list_devices(&egl, NULL, &devices, count, message));
    for (uint32_t i = 0; devices != NULL && i < *count && i < room; ++i) {
        software[i] = svo_i_egl_device_is_software(device_extensions(&egl, devices[i]));
    }
cleanup:
    *count = status == SVO_OK ? *count : 0;
    svo_i_free(devices);
    svo_i_library_close(egl.library);
    return status;
}

int svo_gl_egl_is_software(void)
{
    bool software[SVO_I_EGL_DEVICES_MAX] = {false};
    uint32_t count = 0;
    uint32_t in_software = 0;
    (void)svo_i_egl_find_software(software, SVO_I_EGL_DEVICES_MAX, &count, NULL);
    for (uint32_t i = 0; i < count && i < SVO_I_EGL_DEVICES_MAX; ++i) {
        in_software += software[i];
    }
    return in_software > 0 && in_software == count;
}

static svo_status find_device(const egl_library *egl, uint32_t device_index, const svo_i_memory *memory,
                              EGLDeviceEXT *device, svo_message *message)
{
    EGLDeviceEXT *devices = NULL;
    uint32_t count = 0;
    SVO_I_TRY(list_devices(egl, memory, &devices, &count, message));
    if (devices == NULL || device_index >= count) {
        svo_i_free(devices);
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: device_index %u is not below the %u EGL devices",
                          device_index, count);
    }
    *device = devices[device_index];
    svo_i_free(devices);
    return SVO_OK;
}

/* Finds the platform and the native display that eglGetPlatformDisplayEXT needs for the kind. */
static svo_status choose_platform(const egl_context *native, svo_gl_context_kind kind, uint32_t device_index,
                                  EGLenum *platform, void **native_display, svo_message *message)
{
    const egl_library *egl = &native->egl;
    if (kind == SVO_GL_SURFACELESS) {
        *platform = EGL_PLATFORM_SURFACELESS_MESA;
        *native_display = EGL_DEFAULT_DISPLAY;
        return require_client_extension(egl, "EGL_MESA_platform_surfaceless", message);
    }
    *platform = EGL_PLATFORM_DEVICE_EXT;
    SVO_I_TRY(require_client_extension(egl, "EGL_EXT_platform_device", message));
    return find_device(egl, device_index, &native->memory, native_display, message);
}

static svo_status open_display(egl_context *native, svo_gl_context_kind kind, uint32_t device_index,
                               svo_message *message)
{
    const egl_library *egl = &native->egl;
    EGLenum platform = 0;
    void *native_display = NULL;
    SVO_I_TRY(require_client_extension(egl, "EGL_EXT_platform_base", message));
    SVO_I_TRY(choose_platform(native, kind, device_index, &platform, &native_display, message));
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)egl->GetProcAddress("eglGetPlatformDisplayEXT");
    if (get_platform_display == NULL) {
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: EGL has no function eglGetPlatformDisplayEXT");
    }
    native->device = kind == SVO_GL_EGL_DEVICE ? native_display : EGL_NO_DEVICE_EXT;
    native->display = get_platform_display(platform, native_display, NULL);
    if (native->display == EGL_NO_DISPLAY) {
        return fail_step(egl, "eglGetPlatformDisplayEXT", message);
    }
    return SVO_OK;
}

static svo_status initialize_display(const egl_context *native, svo_message *message)
{
    /* Required by the calls below. EGL 1.5 has context versions and profiles in its core. */
    static const char *const needed[] = {"EGL_KHR_surfaceless_context", "EGL_KHR_create_context"};
    EGLint major = 0, minor = 0;
    if (!native->egl.Initialize(native->display, &major, &minor)) {
        return fail_step(&native->egl, "eglInitialize", message);
    }
    const char *extensions = native->egl.QueryString(native->display, EGL_EXTENSIONS);
    bool has_versions = major > 1 || (major == 1 && minor >= 5);
    for (size_t i = 0; i < sizeof needed / sizeof needed[0]; ++i) {
        bool is_core = i == 1 && has_versions;
        if (!is_core && !svo_i_list_has_token(extensions, needed[i])) {
            return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: the EGL display does not list %s", needed[i]);
        }
    }
    return SVO_OK;
}

/* svocl draws to no surface, so the context needs no configuration where the display allows that. */
static svo_status choose_config(const egl_context *native, EGLConfig *config, svo_message *message)
{
    const char *extensions = native->egl.QueryString(native->display, EGL_EXTENSIONS);
    if (svo_i_list_has_token(extensions, "EGL_KHR_no_config_context")) {
        *config = EGL_NO_CONFIG_KHR;
        return SVO_OK;
    }
    const EGLint attributes[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLint count = 0;
    if (!native->egl.ChooseConfig(native->display, attributes, config, 1, &count)) {
        return fail_step(&native->egl, "eglChooseConfig", message);
    }
    if (count < 1) {
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: the EGL display has no OpenGL configuration");
    }
    return SVO_OK;
}

/* A core profile. notified: the context reports its loss; otherwise the process may end or go on with garbage. */
static EGLContext try_core_context(const egl_context *native, EGLConfig config, EGLint minor, bool notified)
{
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 minor,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 notified ? EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY : EGL_NONE,
                                 EGL_LOSE_CONTEXT_ON_RESET,
                                 EGL_NONE};
    return native->egl.CreateContext(native->display, config, EGL_NO_CONTEXT, attributes);
}

/* The newest version available, at least 4.3. Expects EGL_OPENGL_API bound. */
static svo_status create_core_context(egl_context *native, EGLConfig config, svo_message *message)
{
    for (EGLint minor = 6; minor >= 3; --minor) {
        native->context = try_core_context(native, config, minor, true);
        if (native->context == EGL_NO_CONTEXT) {
            native->context = try_core_context(native, config, minor, false);
        }
        if (native->context != EGL_NO_CONTEXT) {
            return SVO_OK;
        }
    }
    return fail_step(&native->egl, "eglCreateContext (OpenGL 4.3 core)", message);
}

static svo_status create_context(egl_context *native, svo_message *message)
{
    EGLConfig config = NULL;
    SVO_I_TRY(choose_config(native, &config, message));
    EGLenum previous_api = native->egl.QueryAPI();
    if (!native->egl.BindAPI(EGL_OPENGL_API)) {
        return fail_step(&native->egl, "eglBindAPI(EGL_OPENGL_API)", message);
    }
    const svo_status status = create_core_context(native, config, message);
    (void)native->egl.BindAPI(previous_api);
    return status;
}

static void egl_destroy(void *pointer)
{
    egl_context *native = pointer;
    if (native->context != EGL_NO_CONTEXT) {
        (void)native->egl.DestroyContext(native->display, native->context);
    }
    svo_i_library_close(native->egl.library);
    svo_i_free(native);
}

static svo_status egl_create(svo_gl_context_kind kind, uint32_t device_index, const svo_i_memory *memory, void **out,
                             svo_message *message)
{
    egl_context *native = svo_i_alloc_zeroed(memory, 1, sizeof *native);
    if (native == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "svo_gl_context_create: no %zu bytes", sizeof *native);
    }
    svo_status status = SVO_OK;
    native->memory = *memory;
    native->context = EGL_NO_CONTEXT;
    SVO_I_TRY_CLEANUP(egl_library_open(&native->egl, message));
    SVO_I_TRY_CLEANUP(open_display(native, kind, device_index, message));
    SVO_I_TRY_CLEANUP(initialize_display(native, message));
    SVO_I_TRY_CLEANUP(create_context(native, message));
    *out = native;
    return SVO_OK;
cleanup:
    egl_destroy(native);
    return status;
}

static bool egl_is_current(void *pointer)
{
    const egl_context *native = pointer;
    return native->egl.QueryAPI() == EGL_OPENGL_API && native->egl.GetCurrentContext() == native->context;
}

static svo_status egl_make_current(void *pointer, svo_message *message)
{
    const egl_context *native = pointer;
    if (!native->egl.BindAPI(EGL_OPENGL_API)) {
        return fail_step(&native->egl, "eglBindAPI(EGL_OPENGL_API)", message);
    }
    if (!native->egl.MakeCurrent(native->display, EGL_NO_SURFACE, EGL_NO_SURFACE, native->context)) {
        return fail_step(&native->egl, "eglMakeCurrent", message);
    }
    return SVO_OK;
}

static svo_i_function egl_get_proc_address(void *pointer, const char *name)
{
    const egl_context *native = pointer;
    return (svo_i_function)native->egl.GetProcAddress(name);
}

static bool egl_promises_gpu(void *pointer)
{
    const egl_context *native = pointer;
    return native->device != EGL_NO_DEVICE_EXT &&
           svo_i_egl_device_is_gpu(device_extensions(&native->egl, native->device));
}

static svo_i_gl_handles egl_handles(void *pointer)
{
    const egl_context *native = pointer;
    return (svo_i_gl_handles){.system = SVO_I_GL_SYSTEM_EGL, .context = native->context, .display = native->display};
}

const svo_i_gl_platform svo_i_egl_platform = {
    .create = egl_create,
    .destroy = egl_destroy,
    .is_current = egl_is_current,
    .make_current = egl_make_current,
    .get_proc_address = egl_get_proc_address,
    .handles = egl_handles,
    .promises_gpu = egl_promises_gpu,
};

void svo_i_egl_binding_take(svo_i_egl_binding *binding)
{
    *binding = (svo_i_egl_binding){0};
    egl_library egl = {.library = svo_i_library_if_loaded(SVO_I_EGL_LIBRARY)};
    if (egl.library != NULL && egl_library_fill(&egl, NULL) == SVO_OK) {
        binding->loaded = true;
        binding->api = egl.QueryAPI();
        binding->context = egl.GetCurrentContext();
        if (binding->context != EGL_NO_CONTEXT) {
            binding->display = egl.GetCurrentDisplay();
            binding->draw_surface = egl.GetCurrentSurface(EGL_DRAW);
            binding->read_surface = egl.GetCurrentSurface(EGL_READ);
            (void)egl.MakeCurrent(binding->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        }
    }
    svo_i_library_close(egl.library);
}

void svo_i_egl_binding_restore(const svo_i_egl_binding *binding)
{
    if (!binding->loaded) {
        return;
    }
    egl_library egl = {.library = svo_i_library_if_loaded(SVO_I_EGL_LIBRARY)};
    if (egl.library != NULL && egl_library_fill(&egl, NULL) == SVO_OK) {
        (void)egl.BindAPI(binding->api);
        if (binding->context != EGL_NO_CONTEXT) {
            (void)egl.MakeCurrent(binding->display, binding->draw_surface, binding->read_surface, binding->context);
        }
    }
    svo_i_library_close(egl.library);
}
