/* SPDX-License-Identifier: MIT */
/* Builds of the parts in a folder. */
#ifndef SVO_LIB_PARTS_JOB_H
#define SVO_LIB_PARTS_JOB_H

#include "parts/folder.h"
#include "parts/triangles.h"

/* Plans a part from its triangles. *expected_bytes: of the buffers and the host's memory of its build. */
svo_status svo_i_part_plan(const svo_parts *parts, svo_device *device, uint32_t level, uint64_t code, svo_plan **plan,
                           uint64_t *expected_bytes, svo_message *message);
/* Host memory of a part's build while it is planned: its triangles and what the plan makes of them. */
uint64_t svo_i_part_host_bytes(const svo_parts *parts, uint64_t triangles);

#endif
