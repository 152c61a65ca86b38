/* SPDX-License-Identifier: MIT */
/*
 * Makes one call of the library fail: an allocation, or a call of OpenCL, OpenGL, EGL, the file system, a child process
 * or the dynamic loader. It also counts the objects that the library holds. The linker puts it between a test with its
 * static libraries and what they call: in CMake, svocl_inject_faults(test_name) (ld --wrap; faults.cmake lists the
 * calls). OpenGL and EGL functions are replaced where the library looks them up (faults_gl.cpp). Calls inside drivers
 * and shared libraries never fail.
 *
 *     faults_arm(7);                     // the eighth call from now on fails
 *     status = svo_build(...);
 *     faults_call failed = faults_disarm();   // failed.name is NULL where there were fewer calls
 *
 * A failed call has no effect and leaves its outputs as they are. A call that releases something, such as free's
 * relatives clReleaseEvent or close, releases it and reports an error. All of this is for one thread.
 */
#ifndef SVOCL_TESTS_FAULTS_H
#define SVOCL_TESTS_FAULTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fault_kind {
    FAULT_ALLOCATION, /* malloc and its relatives */
    FAULT_OPENCL,
    FAULT_OPENGL,
    FAULT_EGL,
    FAULT_FILE, /* files and pipes */
    FAULT_PROCESS, /* the import child */
    FAULT_LOADER, /* dlopen, dlsym, dlclose */
    FAULT_KINDS
} fault_kind;

const char *fault_kind_name(fault_kind kind);

/* What the failed calls report. The library must not mistake them for a limit that it can avoid. */
#define FAULT_CL_ERROR  CL_OUT_OF_RESOURCES
#define FAULT_GL_ERROR  0x0505 /* GL_OUT_OF_MEMORY */
#define FAULT_EGL_ERROR 0x3003 /* EGL_BAD_ALLOC */

typedef struct faults_call {
    const char *name; /* static; NULL: no call failed */
    fault_kind kind;
} faults_call;

/* Counts calls from now on, and makes the index-th (from 0) fail. */
void faults_arm(uint64_t index);
/* Ends that, or what faults_note began. */
faults_call faults_disarm(void);
/* Writes down where each call from now on comes from; none fails. places: room for place_count of them. A place is the
 * function that calls and the one above it, as a hash that another process of the program finds too. */
void faults_note(uint64_t *places, size_t place_count);
/* How many calls there were since. */
size_t faults_noted(void);
/* While on, calls are neither counted nor made to fail: the test's own between those of the library. */
void faults_spare(bool on);
/* The call that failed since faults_arm, while it is still armed. */
faults_call faults_failed(void);

/* X(member, text): objects that the library made or retained and has not released. */
#define FAULTS_OBJECT_LIST(X)              \
    X(blocks, "blocks of memory")          \
    X(contexts, "cl_context")              \
    X(queues, "cl_command_queue")          \
    X(buffers, "cl_mem")                   \
    X(programs, "cl_program")              \
    X(kernels, "cl_kernel")                \
    X(events, "cl_event")                  \
    X(mappings, "mapped buffers or files") \
    X(files, "open files")                 \
    X(processes, "child processes")        \
    X(libraries, "opened libraries")       \
    X(gl_contexts, "OpenGL contexts")      \
    X(gl_objects, "OpenGL objects")

typedef struct faults_objects {
#define FAULTS_MEMBER(member, text) int64_t member;
    FAULTS_OBJECT_LIST(FAULTS_MEMBER)
#undef FAULTS_MEMBER
} faults_objects;

/* Counts since the program began; never reset. */
extern faults_objects faults_live;

/*
 * For the wrappers.
 */

/* Counts a call; true when it is its turn to fail. */
bool faults_turn(fault_kind kind, const char *name);
/* The wrapper for a function of OpenGL or EGL that was looked up: real itself where there is none. */
void *faults_hook(const char *name, void *real);

#ifdef __cplusplus
}
#endif

#endif
