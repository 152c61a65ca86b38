/* SPDX-License-Identifier: MIT */
/*
 * Around internal functions that svocl::gl and svocl::io may call; lib/exports.txt names those that are exported. As
 * with SVO_API, a static library exports none; on Windows the list alone decides.
 */
#ifndef SVO_LIB_CORE_VISIBILITY_H
#define SVO_LIB_CORE_VISIBILITY_H

#if defined(SVO_STATIC) || defined(_WIN32)
#define SVO_I_SHARED_BEGIN
#define SVO_I_SHARED_END
#else
#define SVO_I_SHARED_BEGIN _Pragma("GCC visibility push(default)")
#define SVO_I_SHARED_END   _Pragma("GCC visibility pop")
#endif

#endif
