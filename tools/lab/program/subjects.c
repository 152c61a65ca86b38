/* SPDX-License-Identifier: MIT */
/* The list of all measurements. A new subject is added here. */
#include "program/subjects.h"

#include "bench/rays.h"
#include "bench/sizes.h"
#include "bench/subjects.h"
#include "errors/subjects.h"

const suite_subject *const subjects[] = {
    [SUBJECT_VOXELIZE] = &bench_voxelize,
    [SUBJECT_BUILD] = &bench_builders,
    [SUBJECT_FILTER] = &bench_filter,
    [SUBJECT_STARTUP] = &bench_startup,
    [SUBJECT_IMPORT] = &bench_import,
    [SUBJECT_CONVERT] = &bench_convert,
    [SUBJECT_RAYS] = &bench_rays,
    [SUBJECT_VOXEL_RAYS] = &bench_voxel_rays,
    [SUBJECT_COMPACT] = &bench_compact,
    [SUBJECT_SOLID] = &bench_solid,
    [SUBJECT_SCENE] = &bench_scene,
    [SUBJECT_LIGHT] = &bench_light,
    [SUBJECT_LEAVING_OUT] = &bench_leaving_out,
    [SUBJECT_SIZES] = &bench_scene_sizes,
    [SUBJECT_MEMORY] = &bench_memory,
    [SUBJECT_PARTS] = &bench_parts,
    [SUBJECT_PARTS_LARGE] = &bench_parts_large,
    [SUBJECT_PAGED] = &bench_paged,
    [SUBJECT_MOVING] = &bench_moving,
    [SUBJECT_MOVING_LIGHT] = &bench_moving_light,
    [SUBJECT_THESIS_2020] = &bench_thesis_2020,
    [SUBJECT_THESIS_2016] = &bench_thesis_2016,
    [SUBJECT_PEER_EMBREE] = &bench_peer_embree,
    [SUBJECT_PEER_OPENVDB] = &bench_peer_openvdb,
    [SUBJECT_E1] = &errors_voxelization,
    [SUBJECT_E2] = &errors_rays,
    [SUBJECT_E3] = &errors_attributes,
    [SUBJECT_E4] = &errors_detail,
    [SUBJECT_E5] = &errors_conditioning,
    [SUBJECT_E7] = &errors_cones,
    [SUBJECT_E8] = &errors_probes,
    [SUBJECT_COUNT] = NULL,
};

bool subjects_know(const char *wanted)
{
    for (size_t i = 0; subjects[i] != NULL; ++i) {
        if (suite_is_wanted(subjects[i], wanted)) {
            return true;
        }
    }
    return false;
}
