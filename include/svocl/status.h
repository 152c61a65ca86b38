/* SPDX-License-Identifier: MIT */
/*
 * Status codes, messages and the log callback.
 *
 * Every function that can fail returns an svo_status and leaves its outputs untouched when it is not SVO_OK (reports of
 * times excepted). SVO_INVALID_ARGUMENT and SVO_OUT_OF_HOST_MEMORY may come from any of them. The words
 * that go with it ("svo_plan_create: depth 17 is not in 1 .. 16") are kept by the handle that was used, or written to
 * the svo_message of functions that have no handle yet. The library never prints, exits or aborts.
 */
#ifndef SVOCL_STATUS_H
#define SVOCL_STATUS_H

#include "svocl/export.h"

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Structs that may grow begin with size_t struct_size, which says how much of the struct the caller knows. Each has a
 * macro SVO_..._INIT, which sets it and makes everything else zero.
 */
#if defined(__cplusplus) && __cplusplus < 202002L
#define SVO_STRUCT_INIT(type) \
    {                         \
        sizeof(type)          \
    }
#else
#define SVO_STRUCT_INIT(type)       \
    {                               \
        .struct_size = sizeof(type) \
    }
#endif

/* X(enumerator, value, text): the one list of status codes. Values are stable. */
#define SVO_STATUS_LIST(X)                                                              \
    X(SVO_OK, 0, "ok")                                                                  \
    X(SVO_INVALID_ARGUMENT, 1, "an argument is outside its documented range")           \
    X(SVO_OUT_OF_HOST_MEMORY, 2, "the host is out of memory")                           \
    X(SVO_OUT_OF_DEVICE_MEMORY, 3, "a buffer does not fit the device")                  \
    X(SVO_NO_DEVICE, 4, "no OpenCL platform or device fits")                            \
    X(SVO_NO_GL, 5, "no OpenGL context of the asked kind can be made")                  \
    X(SVO_UNSUPPORTED, 6, "the device or the context cannot do what was asked")         \
    X(SVO_COMPILE_FAILED, 7, "a kernel or a shader does not compile")                   \
    X(SVO_CL_ERROR, 8, "an OpenCL call failed")                                         \
    X(SVO_GL_ERROR, 9, "an OpenGL call failed")                                         \
    X(SVO_CAPACITY_EXCEEDED, 10, "a capacity is too small; the exact need is reported") \
    X(SVO_FILE_ERROR, 11, "a file cannot be opened, read or written")                   \
    X(SVO_FILE_DAMAGED, 12, "a file is truncated, damaged or of another format")        \
    X(SVO_IMPORT_FAILED, 13, "a mesh file cannot be read")                              \
    X(SVO_INTERNAL, 14, "an invariant of the library does not hold")

typedef enum svo_status {
#define SVO_STATUS_ENUM(name, value, text) name = (value),
    SVO_STATUS_LIST(SVO_STATUS_ENUM)
#undef SVO_STATUS_ENUM
} svo_status;

/* "SVO_OK", ...; "unknown status" for other values. Static string. */
SVO_API const char *svo_status_name(svo_status status);
/* The text of the list above. Static string. */
SVO_API const char *svo_status_text(svo_status status);

/* One line of text without a newline, always terminated; longer messages are cut, build logs go to the log callback. */
#define SVO_MESSAGE_BYTES 1024
typedef struct svo_message {
    char text[SVO_MESSAGE_BYTES];
} svo_message;

typedef enum svo_log_level { SVO_LOG_ERROR = 0, SVO_LOG_WARNING = 1, SVO_LOG_INFO = 2 } svo_log_level;

/* Receives terminated text of any length, valid during the call. Called on the thread that called the library. */
typedef void (*svo_log_callback)(void *user, svo_log_level level, const char *text);

#ifdef __cplusplus
}
#endif

#endif
