/* SPDX-License-Identifier: MIT */
/*
 * The fields of a signed distance field. Files of the room, each after those that it uses: programs, distances, sdf.
 */
#ifndef SVO_LIB_SDF_HANDLE_H
#define SVO_LIB_SDF_HANDLE_H

#include <stdbool.h>

#include "core/memory.h"
#include "core/tree.h"
#include "core/work.h"
#include "svocl/sdf.h"

struct svo_sdf {
    svo_sdf_info info;
    svo_device *device;
    svo_i_memory memory; /* of the field and its host arrays */
    cl_mem buffers[SVO_SDF_BUFFER_COUNT]; /* owned; NULL where absent */
    void *host[SVO_SDF_BUFFER_COUNT]; /* owned; NULL where absent or not downloaded */
    bool downloaded; /* host[] has all arrays */
};

/* Bytes of an element of an array. */
#define SVO_I_SDF_DISTANCE_BYTES sizeof(cl_float)
#define SVO_I_SDF_CODE_BYTES     sizeof(cl_ulong)

#endif
