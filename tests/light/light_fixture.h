/* SPDX-License-Identifier: MIT */
/* Trees of given opacity, their lights, and samples of their fields. Call inside a running cmocka test. */
#ifndef SVOCL_TESTS_LIGHT_FIXTURE_H
#define SVOCL_TESTS_LIGHT_FIXTURE_H

#include "support/fixture.h"
#include "svocl/light.h"

/* Fails with the device's message. */
void light_succeed(const fixture *opened, svo_status status);

/* The tree of a grid of alphas, 0 .. 255, 8^depth, x + y * 2^depth + z * 4^depth. A voxel of alpha 0 is absent; the
   first one is always there, so that the grid begins with it. Downloaded. */
svo_tree *light_tree_of(const fixture *opened, uint32_t depth, const uint8_t *alphas);

svo_light *light_of(const fixture *opened, svo_tree *tree, svo_light_form form);
svo_light_info light_info_of(const svo_light *light);
/* One of its buffers; released by free. */
void *light_read(const fixture *opened, const svo_light *light, svo_light_buffer buffer);

/* A place in a field: position in voxels, unit direction. 36 bytes. */
typedef struct light_probe {
    float position[3];
    uint32_t level;
    float direction[3];
    uint32_t with_light;
    uint32_t in_pair; /* 0: alone; 1: as the finer of two levels; 2: as the coarser, not of the deepest level */
} light_probe;

/* What is there, as kernels/light/field.clh has it. 32 bytes. */
typedef struct light_sample {
    float extinction, cover, facing, opacity;
    float radiance[3];
    float empty;
} light_sample;

void light_probe_field(const fixture *opened, svo_light *light, const light_probe *probes, light_sample *samples,
                       size_t count);

#endif
