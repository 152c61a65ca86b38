/* SPDX-License-Identifier: MIT */
/* The light's fields, and what the files of this room share. */
#ifndef SVO_LIB_LIGHT_STATE_H
#define SVO_LIB_LIGHT_STATE_H

#include "core/tree.h"
#include "core/work.h"
#include "shared/light_layout.h"
#include "svocl/light.h"

struct svo_i_light_viewer;
struct svo_i_kept_photons;
struct svo_i_kept_nodes;

/* What lights the tree: copies of what svo_light_set_sources got. */
typedef struct svo_i_light_setup {
    svo_light_setup asked; /* its arrays are given and finishes below; struct_size 0: there is none */
    svo_light_source *given; /* NULL: none */
    svo_light_source *sources; /* with unit directions, for pictures; NULL: none */
    size_t source_count;
    svo_finish *finishes; /* NULL: none */
    size_t finish_count;
} svo_i_light_setup;

/* Bounds of what has changed in a tree. */
typedef struct svo_i_light_changes {
    const svo_box *boxes;
    size_t count;
} svo_i_light_changes;

/* What svo_light_update begins with. */
typedef struct svo_i_light_before {
    const struct svo_light *light; /* of the tree before, which may be gone */
    svo_i_light_changes changes;
    cl_mem origins; /* u32 an inner node: what it was in the tree before, or SVO_NO_NODE. Owned; NULL: not known */
    cl_mem renewed; /* u32 an inner node: octants of its children whose leaves have new radiance. Owned; NULL: all do */
} svo_i_light_before;

struct svo_light {
    svo_tree *tree; /* the caller's */
    svo_device *device; /* the tree's */
    svo_light_info info;
    svo_light_params params; /* of its kernels */
    svo_light_options options; /* as asked */
    cl_mem buffers[SVO_LIGHT_BUFFER_COUNT]; /* owned; NULL where not held */
    svo_i_light_setup setup; /* owned */
    struct svo_i_kept_photons *kept; /* owned; NULL: no photons are kept */
    struct svo_i_kept_nodes *nodes; /* owned; NULL: no nodes are kept */
    svo_i_light_before *before; /* during svo_light_update, which then has given it kept; else NULL */
    const struct svo_i_light_viewer *viewer; /* during svo_i_light_set_sources_by; else NULL: rays */
};

/* The defines of the kernels that make and filter a light: its form, and whether they read areas. Static string. */
const char *svo_i_light_defines(const svo_light *light);

/* The projected areas of the leaves, where opacity is by area; else NULL. */
cl_mem svo_i_light_areas(const svo_light *light);

/* Makes one of the light's buffers, of info.bytes[buffer], which the plan or the caller has set. */
svo_status svo_i_light_buffer(svo_i_device_work *work, svo_light *light, svo_light_buffer buffer);
/* Releases one, and says in info that it is not held. */
void svo_i_light_release(svo_light *light, svo_light_buffer buffer);

/* Arguments for kernels of one level; those of the leaves for level depth. */
svo_light_step svo_i_light_step(const svo_light *light, uint32_t level);

/* Sets the arguments that SVO_LIGHT_PARAMETERS of kernels/light/field.clh declares, from first_index on. */
svo_status svo_i_light_set_args(const svo_light *light, const char *function, cl_kernel kernel, cl_uint first_index);

/* Waits, and takes the time since start_ms (svo_i_now_ms) as the stage's. */
svo_status svo_i_light_took(svo_i_device_work *work, svo_light *light, svo_light_stage stage, double start_ms);

#endif
