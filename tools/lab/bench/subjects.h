/* SPDX-License-Identifier: MIT */
/* The subjects of this room, for the list in program/subjects.c. */
#ifndef SVOCL_TOOLS_BENCH_SUBJECTS_H
#define SVOCL_TOOLS_BENCH_SUBJECTS_H

#include "measure/suite.h"

/* Subject "voxelize": the front ends. */
extern const suite_subject bench_voxelize;
/* Subject "build": builders and interop paths, stage by stage. */
extern const suite_subject bench_builders;
/* Subject "filter": attributes under each weighting. */
extern const suite_subject bench_filter;
/* Subject "startup": from the start of a process to its first tree. */
extern const suite_subject bench_startup;
/* Subject "import": mesh files, compared with assimp alone. */
extern const suite_subject bench_import;
/* Voxels to trees and files. */
extern const suite_subject bench_convert;
/* Subject "voxel-rays": rays through the voxels of a tree beside NanoVDB and a brickmap. */
extern const suite_subject bench_voxel_rays;
/* Subject "compact": bytes and rays of compact trees beside the built tree. */
extern const suite_subject bench_compact;
/* svocl bench solid: the inside of closed meshes. */
extern const suite_subject bench_solid;
/* svocl bench scene: instances of one tree in a lattice, beside one tree of all their voxels and beside Embree. */
extern const suite_subject bench_scene;
/* Light: its stages, bytes, views and frames. Tables "light-stages", "light-bytes", "light-frames". */
extern const suite_subject bench_light;
/* Subject "leaving-out": time and bytes of each need. */
extern const suite_subject bench_leaving_out;
/* Subject "parts": time and memory against the number of parts. */
extern const suite_subject bench_parts;
/* Subject "parts-large": trees of a hundred million leaves in little memory. */
extern const suite_subject bench_parts_large;
/* Subject "paged": misses and reads along a camera path, by the share of the file that has room. */
extern const suite_subject bench_paged;
/* Subject "moving": updates of scenes that move beside full builds. */
extern const suite_subject bench_moving;
/* Subject "moving-light": light that follows an object, beside light from nothing. */
extern const suite_subject bench_moving_light;
/* Subjects "thesis-2020" and "thesis-2016": the published tables of two older systems, measured again. */
extern const suite_subject bench_thesis_2020, bench_thesis_2016;
/* Subjects "peer-embree" and "peer-openvdb": other libraries on the same triangles. */
extern const suite_subject bench_peer_embree, bench_peer_openvdb;

#endif
