/* SPDX-License-Identifier: MIT */
/* The part of fuzz_mesh that chunks the fragment list of a plan, grows it, and checks every chunking. */
#ifndef SVOCL_TESTS_FUZZ_MESH_LAYOUT_H
#define SVOCL_TESTS_FUZZ_MESH_LAYOUT_H

#include "plan/plan_data.h"

/* chunk_bytes: at least 16384. seed: of the fragments that chunks need when they are grown. */
void check_layouts(const svo_plan *plan, uint64_t chunk_bytes, uint64_t seed);

#endif
