/* SPDX-License-Identifier: MIT */
/** \file
 * Status codes, messages, the log callback, and the rule for structs that may grow.
 *
 * Every function that can fail returns an svo_status. Unless it is SVO_OK, outputs are left untouched (a build's report
 * excepted), and one line says what was wrong: function, argument, value and limit, as in "svo_plan_create: depth 17 is
 * not in 1 .. 16". The handle that was used keeps the line (svo_device_message); functions without a handle write it to
 * an svo_message. A tree from a file, or a compact one, belongs to no device handle before it is uploaded; what needs
 * it on a device returns SVO_NOT_ON_DEVICE, whose text (SVO_NAME_STATUS_TEXT) is the message. Any function may return
 * SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY, one that can return SVO_CL_ERROR or SVO_GL_ERROR also
 * SVO_OUT_OF_DEVICE_MEMORY, and one that can return SVO_COMPILE_FAILED also SVO_DEVICE_UNRELIABLE
 * (svo_device_options.trust_driver). The library never prints, exits or aborts.
 *
 * Structs that may grow begin with "size_t struct_size", which the caller sets to sizeof. Each has a macro SVO_..._INIT
 * that does so and makes everything else zero, which is the default. Sizes below that of the first release are refused
 * with SVO_INVALID_ARGUMENT. An input may be smaller than today's struct: the fields that it lacks are zero. A larger
 * one is refused too. An output may be smaller or larger: it is filled as far as it reaches, and the rest of a larger
 * one becomes zero.
 */
#ifndef SVOCL_STATUS_H
#define SVOCL_STATUS_H

#include <stddef.h>

#include "svocl/export.h"
#include "svocl/names.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Initializer of a struct with struct_size. In C++ it is a call, since compilers warn about lists that leave members
 *  out. */
#if defined(__cplusplus)
#define SVO_STRUCT_INIT(type)                       \
    []() {                                          \
        type svo_struct = type();                   \
        svo_struct.struct_size = sizeof svo_struct; \
        return svo_struct;                          \
    }()
#else
#define SVO_STRUCT_INIT(type)       \
    {                               \
        .struct_size = sizeof(type) \
    }
#endif

/** X(enumerator, value, text): the one list of status codes. Values are stable. */
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
    X(SVO_INTERNAL, 14, "an invariant of the library does not hold")                    \
    X(SVO_CANCELED, 15, "the progress callback stopped the call")                       \
    X(SVO_NOT_ON_DEVICE, 16, "the tree is not on a device; upload it first")            \
    X(SVO_DEVICE_UNRELIABLE, 17, "a kernel gives wrong results on the device")          \
    X(SVO_UNAVAILABLE, 18, "a file or a folder cannot be had now; later it may")

/** \cond the enumerators are those of SVO_STATUS_LIST */
typedef enum svo_status {
#define SVO_STATUS_ENUM(name, value, text) name = (value),
    SVO_STATUS_LIST(SVO_STATUS_ENUM)
#undef SVO_STATUS_ENUM
} svo_status;
/** \endcond */

#define SVO_MESSAGE_BYTES 1024 /**< longest message, its terminator included */

/** One line of text without a newline, always terminated. Longer lines are cut; build logs go to the log callback. */
typedef struct svo_message {
    char text[SVO_MESSAGE_BYTES]; /**< the line */
} svo_message;

/** Severity of a logged text. */
typedef enum svo_log_level {
    SVO_LOG_ERROR = 0, /**< a call fails */
    SVO_LOG_WARNING = 1, /**< something is replaced or left out */
    SVO_LOG_INFO = 2 /**< worth knowing */
} svo_log_level;

/** Receives terminated text of any length, valid during the call, on the thread that called the library. */
typedef void (*svo_log_callback)(void *user, svo_log_level level, const char *text);

#ifdef __cplusplus
}
#endif

#endif
