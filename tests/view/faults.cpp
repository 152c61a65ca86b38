// SPDX-License-Identifier: MIT
//
// For LD_PRELOAD: makes one call of `svocl view` fail: an allocation of the program itself, a call of OpenGL or SDL, or
// a command of OpenCL, whose device is then lost. What runs until the tree is there, with the library, is left alone:
// test_faults is for that.
//
//   VIEW_FAULT_AT=N        the call that fails, counted from 0
//   VIEW_FAULT_LIST=FILE   no call fails; lists them, "N KIND PLACE" a line, where PLACE is the same for calls from one
//                          place of the program
//
// A call of OpenGL that fails does nothing, and glGetError reports it. A wrapper per function is made from the
// function's type alone.
#include <SDL.h>
#include <dlfcn.h>
#include <elf.h>
#include <link.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "view/gl.h"

extern "C" {
void *__libc_malloc(std::size_t bytes);
void *__libc_calloc(std::size_t count, std::size_t bytes);
void *__libc_realloc(void *block, std::size_t bytes);
}

namespace
{

std::uintptr_t program_begin, program_end; // of the program's code
bool resting; // while the tree is made
long number; // of calls so far
long failing = -1;
int list = -1; // a descriptor
GLenum gl_error; // of a call that was made to fail, until glGetError

// The first object of the process is the program.
int find_program(dl_phdr_info *info, std::size_t, void *)
{
    for (int i = 0; i < info->dlpi_phnum; ++i) {
        const ElfW(Phdr) &part = info->dlpi_phdr[i];
        if (part.p_type == PT_LOAD && (part.p_flags & PF_X) != 0) {
            program_begin = info->dlpi_addr + part.p_vaddr;
            program_end = program_begin + part.p_memsz;
        }
    }
    return 1;
}

// Programs that this one starts (OpenCL's compiler starts a linker) have calls of their own, which do not count.
__attribute__((constructor)) void begin()
{
    dl_iterate_phdr(find_program, nullptr);
    if (const char *at = std::getenv("VIEW_FAULT_AT")) {
        failing = std::atol(at);
    }
    if (const char *path = std::getenv("VIEW_FAULT_LIST")) {
        if (std::FILE *file = std::fopen(path, "w")) {
            list = dup(fileno(file));
            std::fclose(file);
        }
    }
    unsetenv("VIEW_FAULT_AT");
    unsetenv("VIEW_FAULT_LIST");
}

bool is_of_program(const void *caller)
{
    const auto address = reinterpret_cast<std::uintptr_t>(caller);
    return address >= program_begin && address < program_end;
}

// Whether this call is the one that fails.
bool fails(const char *kind, const void *caller)
{
    if (resting || !is_of_program(caller)) {
        return false;
    }
    if (list >= 0) {
        char line[96];
        const auto place = static_cast<unsigned long>(reinterpret_cast<std::uintptr_t>(caller) - program_begin);
        const int length = std::snprintf(line, sizeof line, "%ld %s %lx\n", number, kind, place);
        (void)!write(list, line, static_cast<std::size_t>(length));
    }
    return number++ == failing;
}

// The system's function of a name.
template <typename F> F next(const char *name)
{
    F found;
    void *const address = dlsym(RTLD_NEXT, name);
    std::memcpy(&found, &address, sizeof found);
    return found;
}

// ---- OpenGL ----

enum gl_index {
#define GL_INDEX(name, type) GL_##name,
    VIEW_GL_FUNCTIONS(GL_INDEX)
#undef GL_INDEX
};

template <int index, typename F> struct wrapper;

template <int index, typename R, typename... A> struct wrapper<index, R (*)(A...)> {
    static R (*real)(A...);
    static const char *name;
    static R call(A... arguments)
    {
        if (fails(name, __builtin_return_address(0))) {
            gl_error = GL_OUT_OF_MEMORY;
            return R();
        }
        return real(arguments...);
    }
};

template <int index, typename R, typename... A> R (*wrapper<index, R (*)(A...)>::real)(A...);
template <int index, typename R, typename... A> const char *wrapper<index, R (*)(A...)>::name;

GLenum (*real_get_error)();

GLenum get_error()
{
    const GLenum error = gl_error;
    gl_error = GL_NO_ERROR;
    return error != GL_NO_ERROR ? error : real_get_error();
}

// The wrapper of a function; the function itself where there is none.
void *wrap(const char *name, void *real)
{
    if (std::strcmp(name, "glGetError") == 0) {
        std::memcpy(&real_get_error, &real, sizeof real_get_error);
        return reinterpret_cast<void *>(get_error);
    }
#define WRAP(member, type)                                                  \
    if (std::strcmp(name, "gl" #member) == 0) {                             \
        std::memcpy(&wrapper<GL_##member, type>::real, &real, sizeof real); \
        wrapper<GL_##member, type>::name = "gl" #member;                    \
        return reinterpret_cast<void *>(wrapper<GL_##member, type>::call);  \
    }
    VIEW_GL_FUNCTIONS(WRAP)
#undef WRAP
    return real;
}

} // namespace

// ---- memory ----

extern "C" {

void *malloc(std::size_t bytes)
{
    return fails("malloc", __builtin_return_address(0)) ? nullptr : __libc_malloc(bytes);
}

void *calloc(std::size_t count, std::size_t bytes)
{
    return fails("calloc", __builtin_return_address(0)) ? nullptr : __libc_calloc(count, bytes);
}

void *realloc(void *block, std::size_t bytes)
{
    return fails("realloc", __builtin_return_address(0)) ? nullptr : __libc_realloc(block, bytes);
}

// ---- SDL ----

void *SDL_GL_GetProcAddress(const char *name)
{
    if (fails("SDL_GL_GetProcAddress", __builtin_return_address(0))) {
        return nullptr;
    }
    void *const found = next<void *(*)(const char *)>("SDL_GL_GetProcAddress")(name);
    return found == nullptr ? nullptr : wrap(name, found);
}

int SDL_InitSubSystem(Uint32 flags)
{
    return fails("SDL_InitSubSystem", __builtin_return_address(0)) ? SDL_SetError("made to fail")
                                                                   : next<int (*)(Uint32)>("SDL_InitSubSystem")(flags);
}

SDL_Window *SDL_CreateWindow(const char *title, int x, int y, int w, int h, Uint32 flags)
{
    if (fails("SDL_CreateWindow", __builtin_return_address(0))) {
        SDL_SetError("made to fail");
        return nullptr;
    }
    return next<decltype(&SDL_CreateWindow)>("SDL_CreateWindow")(title, x, y, w, h, flags);
}

SDL_GLContext SDL_GL_CreateContext(SDL_Window *window)
{
    if (fails("SDL_GL_CreateContext", __builtin_return_address(0))) {
        SDL_SetError("made to fail");
        return nullptr;
    }
    return next<decltype(&SDL_GL_CreateContext)>("SDL_GL_CreateContext")(window);
}

// The window is used again once the tree is there.
int SDL_GL_MakeCurrent(SDL_Window *window, SDL_GLContext context)
{
    resting = false;
    return fails("SDL_GL_MakeCurrent", __builtin_return_address(0))
               ? SDL_SetError("made to fail")
               : next<decltype(&SDL_GL_MakeCurrent)>("SDL_GL_MakeCurrent")(window, context);
}

int SDL_PushEvent(SDL_Event *event)
{
    return fails("SDL_PushEvent", __builtin_return_address(0)) ? SDL_SetError("made to fail")
                                                               : next<decltype(&SDL_PushEvent)>("SDL_PushEvent")(event);
}

// ---- OpenCL ----

cl_int clGetPlatformIDs(cl_uint room, cl_platform_id *platforms, cl_uint *count)
{
    resting = true;
    return next<decltype(&clGetPlatformIDs)>("clGetPlatformIDs")(room, platforms, count);
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const std::size_t *offset,
                              const std::size_t *global, const std::size_t *local, cl_uint wait_count,
                              const cl_event *wait, cl_event *event)
{
    return fails("clEnqueueNDRangeKernel", __builtin_return_address(0))
               ? CL_DEVICE_NOT_AVAILABLE
               : next<decltype(&clEnqueueNDRangeKernel)>("clEnqueueNDRangeKernel")(
                     queue, kernel, dimensions, offset, global, local, wait_count, wait, event);
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, std::size_t offset,
                           std::size_t bytes, void *out, cl_uint wait_count, const cl_event *wait, cl_event *event)
{
    return fails("clEnqueueReadBuffer", __builtin_return_address(0))
               ? CL_OUT_OF_RESOURCES
               : next<decltype(&clEnqueueReadBuffer)>("clEnqueueReadBuffer")(queue, buffer, blocking, offset, bytes,
                                                                             out, wait_count, wait, event);
}

} // extern "C"
