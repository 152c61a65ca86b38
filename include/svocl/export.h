/* SPDX-License-Identifier: MIT */
/** \file
 * Symbol visibility. The library is built with hidden visibility; only what carries SVO_API is exported.
 */
#ifndef SVOCL_EXPORT_H
#define SVOCL_EXPORT_H

/** Marks an exported function. */
#if defined(_WIN32)
#define SVO_API
#else
#define SVO_API __attribute__((visibility("default")))
#endif

#endif
