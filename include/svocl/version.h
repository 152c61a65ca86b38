/* SPDX-License-Identifier: MIT */
/* Version numbers of svocl. Before 1.0 the API and the ABI may change with each minor version; the CHANGELOG says
   how. */
#ifndef SVOCL_VERSION_H
#define SVOCL_VERSION_H

#include "svocl/export.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_VERSION_MAJOR  0
#define SVO_VERSION_MINOR  1
#define SVO_VERSION_PATCH  0
#define SVO_VERSION_STRING "0.1.0"

/* The version the program runs with (a shared library may be newer than the headers): a static string. */
SVO_API const char *svo_version_string(void);

#ifdef __cplusplus
}
#endif

#endif
