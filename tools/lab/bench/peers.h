/* SPDX-License-Identifier: MIT */
/* Subjects "peer-embree" and "peer-openvdb": other libraries on the same triangles. */
#ifndef SVOCL_TOOLS_BENCH_PEERS_H
#define SVOCL_TOOLS_BENCH_PEERS_H

#include "measure/suite.h"

extern const suite_subject bench_peer_embree, bench_peer_openvdb;

#endif
