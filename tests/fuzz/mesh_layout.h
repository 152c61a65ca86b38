/* SPDX-License-Identifier: MIT */
/* The part of fuzz_mesh that splits a plan's fragment list into chunks, grows it, and checks every chunking. */
#ifndef SVOCL_TESTS_FUZZ_MESH_LAYOUT_H
#define SVOCL_TESTS_FUZZ_MESH_LAYOUT_H

#include "plan/plan_data.h"

/* chunk_bytes: at least 16384. seed: for the random fragment counts that make chunks grow. */
void check_layouts(const svo_plan *plan, uint64_t chunk_bytes, uint64_t seed);

#endif
