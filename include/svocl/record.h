/* SPDX-License-Identifier: MIT */
/** \file
 * How records are declared that host and device share: one text for C, C++, OpenCL C and GLSL. Records hold 32-bit
 * integers and floats only, without padding.
 */
#ifndef SVOCL_RECORD_H
#define SVOCL_RECORD_H

/** \cond the same types and structs in four languages */
#if defined(__OPENCL_C_VERSION__)
#define SVO_U32 uint
#define SVO_I32 int
#define SVO_F32 float
#define SVO_RECORD(name)      \
    typedef struct name name; \
    struct name
#elif defined(GL_core_profile)
#define SVO_U32          uint
#define SVO_I32          int
#define SVO_F32          float
#define SVO_RECORD(name) struct name
#else
#include <stdint.h>
#define SVO_U32 uint32_t
#define SVO_I32 int32_t
#define SVO_F32 float
#define SVO_RECORD(name)      \
    typedef struct name name; \
    struct name
#endif

/* Sizes are checked wherever the text is compiled, except in GLSL, which cannot. */
#if defined(__OPENCL_C_VERSION__)
#define SVO_ASSERT_BYTES(name, bytes) typedef char name##_bytes[sizeof(name) == (bytes) ? 1 : -1]
#elif defined(__cplusplus)
#define SVO_ASSERT_BYTES(name, bytes) static_assert(sizeof(name) == (bytes), #name)
#elif !defined(GL_core_profile)
#define SVO_ASSERT_BYTES(name, bytes) _Static_assert(sizeof(name) == (bytes), #name)
#endif
/** \endcond */

#endif
