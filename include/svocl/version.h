/* SPDX-License-Identifier: MIT */
/** \file
 * Version numbers. Before 1.0 a minor version may change the API and the ABI; the CHANGELOG says how.
 */
#ifndef SVOCL_VERSION_H
#define SVOCL_VERSION_H

#include "svocl/export.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_VERSION_MAJOR  0 /**< of the headers */
#define SVO_VERSION_MINOR  2 /**< of the headers */
#define SVO_VERSION_PATCH  0 /**< of the headers */
#define SVO_VERSION_STRING "0.2.0" /**< of the headers */

/** The version of the library at run time; a shared library may be newer than the headers.
 *
 * \returns a static string. */
SVO_API const char *svo_version_string(void);

#ifdef __cplusplus
}
#endif

#endif
