/* SPDX-License-Identifier: MIT */
/** \file
 * Symbol visibility. The library is built with hidden visibility; only what carries SVO_API is exported, and only from
 * a shared library. Programs that link a static one define SVO_STATIC, as svocl::svocl and svocl.pc do for them. Then a
 * plugin that contains svocl exports no symbol of it.
 */
#ifndef SVOCL_EXPORT_H
#define SVOCL_EXPORT_H

/** Marks an exported function. */
#if defined(SVO_STATIC) || defined(_WIN32)
#define SVO_API
#else
#define SVO_API __attribute__((visibility("default")))
#endif

#endif
