/* SPDX-License-Identifier: MIT */
/* The list of all measurements. A new subject is added here. */
#include "svocl/subjects.h"

#include "bench/builders.h"
#include "bench/compact.h"
#include "bench/convert.h"
#include "bench/filter.h"
#include "bench/import.h"
#include "bench/leaving_out.h"
#include "bench/light.h"
#include "bench/moving.h"
#include "bench/moving_light.h"
#include "bench/paged.h"
#include "bench/parts.h"
#include "bench/parts_large.h"
#include "bench/peers.h"
#include "bench/rays.h"
#include "bench/scene.h"
#include "bench/sizes.h"
#include "bench/solid.h"
#include "bench/startup.h"
#include "bench/thesis_tables.h"
#include "bench/voxelize.h"
#include "errors/e1_voxelization.h"
#include "errors/e2_rays.h"
#include "errors/e3_attributes.h"
#include "errors/e4_detail.h"
#include "errors/e5_conditioning.h"
#include "errors/e7_cones.h"
#include "errors/e8_probes.h"

const suite_subject *const subjects[] = {
    &bench_voxelize,
    &bench_builders,
    &bench_filter,
    &bench_startup,
    &bench_import,
    &bench_convert,
    &bench_rays,
    &bench_compact,
    &bench_solid,
    &bench_scene,
    &bench_light,
    &bench_leaving_out,
    &bench_scene_sizes,
    &bench_memory,
    &bench_parts,
    &bench_parts_large,
    &bench_paged,
    &bench_moving,
    &bench_moving_light,
    &bench_thesis_2020,
    &bench_thesis_2016,
    &bench_peer_embree,
    &bench_peer_openvdb,
    &errors_voxelization,
    &errors_rays,
    &errors_attributes,
    &errors_detail,
    &errors_conditioning,
    &errors_cones,
    &errors_probes,
    NULL,
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
