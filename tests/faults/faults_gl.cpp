// SPDX-License-Identifier: MIT
// Wraps the functions of OpenGL and EGL. The library looks them up by name: EGL's by dlsym, OpenGL's by
// eglGetProcAddress. A wrapper per function is made from the function's type alone, which C cannot do.
#include "faults.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <cstring>
#include <tuple>

#include "context/functions.h"

namespace
{

enum gl_index {
#define GL_INDEX(member, type, core_version, extension) GL_##member,
    SVO_I_GL_FUNCTION_LIST(GL_INDEX)
#undef GL_INDEX
};

// X(name, type): EGL's functions that the library may look up, by dlsym or by eglGetProcAddress.
#define EGL_LIST(X)                                           \
    X(GetError, PFNEGLGETERRORPROC)                           \
    X(GetProcAddress, PFNEGLGETPROCADDRESSPROC)               \
    X(QueryString, PFNEGLQUERYSTRINGPROC)                     \
    X(Initialize, PFNEGLINITIALIZEPROC)                       \
    X(BindAPI, PFNEGLBINDAPIPROC)                             \
    X(QueryAPI, PFNEGLQUERYAPIPROC)                           \
    X(ChooseConfig, PFNEGLCHOOSECONFIGPROC)                   \
    X(CreateContext, PFNEGLCREATECONTEXTPROC)                 \
    X(DestroyContext, PFNEGLDESTROYCONTEXTPROC)               \
    X(MakeCurrent, PFNEGLMAKECURRENTPROC)                     \
    X(GetCurrentContext, PFNEGLGETCURRENTCONTEXTPROC)         \
    X(GetCurrentDisplay, PFNEGLGETCURRENTDISPLAYPROC)         \
    X(GetCurrentSurface, PFNEGLGETCURRENTSURFACEPROC)         \
    X(QueryDevicesEXT, PFNEGLQUERYDEVICESEXTPROC)             \
    X(GetPlatformDisplayEXT, PFNEGLGETPLATFORMDISPLAYEXTPROC) \
    X(QueryDeviceStringEXT, PFNEGLQUERYDEVICESTRINGEXTPROC)

enum egl_index {
#define EGL_INDEX(name, type) EGL_##name,
    EGL_LIST(EGL_INDEX)
#undef EGL_INDEX
};

const char *const gl_names[] = {
#define GL_NAME(member, type, core_version, extension) "gl" #member,
    SVO_I_GL_FUNCTION_LIST(GL_NAME)
#undef GL_NAME
};

const char *const egl_names[] = {
#define EGL_NAME(name, type) "egl" #name,
    EGL_LIST(EGL_NAME)
#undef EGL_NAME
};

GLenum gl_error; // of a call that was made to fail, until glGetError
EGLint egl_error;

// Objects deleted: names of 0 are ignored.
int64_t count_names(GLsizei count, const GLuint *names)
{
    int64_t sum = 0;
    for (GLsizei i = 0; i < count; ++i) {
        sum += names[i] != 0 ? 1 : 0;
    }
    return sum;
}

constexpr bool makes_names(int index)
{
    return index == GL_GenBuffers || index == GL_GenVertexArrays || index == GL_GenFramebuffers ||
           index == GL_GenQueries;
}

constexpr bool deletes_names(int index)
{
    return index == GL_DeleteBuffers || index == GL_DeleteVertexArrays || index == GL_DeleteFramebuffers ||
           index == GL_DeleteQueries;
}

constexpr bool makes_object(int index)
{
    return index == GL_CreateShader || index == GL_CreateProgram;
}

constexpr bool deletes_object(int index)
{
    return index == GL_DeleteShader || index == GL_DeleteProgram;
}

// Calls that have their effect even when they report an error.
constexpr bool releases(int index)
{
    return deletes_names(index) || deletes_object(index) || index == GL_UnmapBuffer;
}

template <int Index, class Function> struct gl_hook;

template <int Index, class Result, class... Arguments> struct gl_hook<Index, Result (*)(Arguments...)> {
    static inline Result (*real)(Arguments...) = nullptr;

    static Result call_real(Arguments... arguments)
    {
        if constexpr (deletes_names(Index)) {
            const auto all = std::make_tuple(arguments...);
            faults_live.gl_objects -= count_names(std::get<0>(all), std::get<1>(all));
        } else if constexpr (deletes_object(Index)) {
            faults_live.gl_objects -= std::get<0>(std::make_tuple(arguments...)) != 0 ? 1 : 0;
        }
        if constexpr (makes_object(Index)) {
            const Result made = real(arguments...);
            faults_live.gl_objects += made != 0 ? 1 : 0;
            return made;
        } else if constexpr (makes_names(Index)) {
            real(arguments...);
            faults_live.gl_objects += std::get<0>(std::make_tuple(arguments...));
        } else {
            return real(arguments...);
        }
    }

    static Result call(Arguments... arguments)
    {
        if constexpr (Index == GL_GetError) {
            const GLenum earlier = gl_error;
            gl_error = GL_NO_ERROR;
            if (faults_turn(FAULT_OPENGL, gl_names[Index])) {
                return FAULT_GL_ERROR;
            }
            return earlier != GL_NO_ERROR ? earlier : real();
        } else if (faults_turn(FAULT_OPENGL, gl_names[Index])) {
            gl_error = FAULT_GL_ERROR;
            if constexpr (releases(Index)) {
                (void)call_real(arguments...);
            }
            if constexpr (Index == GL_GetUniformLocation) {
                return -1;
            }
            return Result();
        }
        return call_real(arguments...);
    }
};

template <int Index, class Function> struct egl_hook;

using any_function = void (*)();

any_function hook_gl(const char *name, any_function real);

template <int Index, class Result, class... Arguments> struct egl_hook<Index, Result (*)(Arguments...)> {
    static inline Result (*real)(Arguments...) = nullptr;

    static Result call_real(Arguments... arguments)
    {
        if constexpr (Index == EGL_GetProcAddress) {
            return hook_gl(arguments..., real(arguments...));
        } else {
            const Result result = real(arguments...);
            if constexpr (Index == EGL_CreateContext) {
                faults_live.gl_contexts += result != EGL_NO_CONTEXT ? 1 : 0;
            } else if constexpr (Index == EGL_DestroyContext) {
                faults_live.gl_contexts -= result != EGL_FALSE ? 1 : 0;
            }
            return result;
        }
    }

    static Result call(Arguments... arguments)
    {
        if constexpr (Index == EGL_GetError) {
            const EGLint earlier = egl_error;
            egl_error = EGL_SUCCESS;
            return earlier != EGL_SUCCESS ? earlier : real();
        } else if (faults_turn(FAULT_EGL, egl_names[Index])) {
            egl_error = FAULT_EGL_ERROR;
            if constexpr (Index == EGL_DestroyContext) {
                (void)call_real(arguments...);
            }
            return Result();
        }
        return call_real(arguments...);
    }
};

// Keeps the function that was found, and returns its wrapper. Missing functions stay missing.
template <class Hook, class Function> any_function install(any_function found)
{
    if (found == nullptr) {
        return nullptr;
    }
    Hook::real = reinterpret_cast<Function>(found);
    return reinterpret_cast<any_function>(&Hook::call);
}

any_function hook_gl(const char *name, any_function real)
{
#define GL_INSTALL(member, type, core_version, extension)       \
    if (std::strcmp(name, "gl" #member) == 0) {                 \
        return install<gl_hook<GL_##member, type>, type>(real); \
    }
    SVO_I_GL_FUNCTION_LIST(GL_INSTALL)
#undef GL_INSTALL
#define EGL_INSTALL(member, type)                                 \
    if (std::strcmp(name, "egl" #member) == 0) {                  \
        return install<egl_hook<EGL_##member, type>, type>(real); \
    }
    EGL_LIST(EGL_INSTALL)
#undef EGL_INSTALL
    return real;
}

} // namespace

extern "C" void *faults_hook(const char *name, void *real)
{
    return reinterpret_cast<void *>(hook_gl(name, reinterpret_cast<any_function>(real)));
}
