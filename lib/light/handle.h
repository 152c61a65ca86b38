/* SPDX-License-Identifier: MIT */
/*
 * The light's fields, and what the files of this room share: buffers and levels.
 *
 * The room, each file after those that it uses:
 *   source_views      what a light source sees, as pixels
 *   kept_photons      what is kept of photons for a changed tree
 *   photons           photons of a view into the sums of leaves
 *   handle            this: fields, names, description, hash
 *   opacity           the opacity of all nodes, in three forms; what a changed tree keeps of it
 *   radiance_filter   from the radiance of lit leaves to that of all nodes that see them
 *   exchange          from the sums of photons to the radiance of lit leaves
 *   shoot             all photons of a setup, or those that a change concerns
 *   emitters          triangles that emit, for rays that aim at them
 *   sky               the map of the sky
 *   mesh              the mesh of the tree, for what cameras see
 *   light             plan, create, set sources, update, destroy
 *   shader            options of gathering; kernels that shade surfaces
 *   gather            light at batches of points, radiance along rays
 *   screen            light of pictures by few rays, smoothed over surfaces
 *   picture           pictures
 */
#ifndef SVO_LIB_LIGHT_HANDLE_H
#define SVO_LIB_LIGHT_HANDLE_H

#include "light/photons.h"

/* What lights the tree: copies of what svo_light_set_sources got. */
typedef struct svo_i_light_setup {
    svo_light_setup asked; /* its arrays are given and finishes below, without a map; struct_size 0: there is none */
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

/* What is kept of the nodes of a tree, so that the light of a changed one copies what stays: kernels/light/origins.cl.
   The light before has the rest. */
typedef struct svo_i_kept_nodes {
    svo_i_kept_tree tree;
    cl_mem masks, children; /* of inner nodes: the tree's */
    cl_mem opacities; /* of inner nodes of SVO_LIGHT_FACES, whose extinctions say too little: six u16 each; else NULL */
} svo_i_kept_nodes;

/* What svo_light_update begins with. */
typedef struct svo_i_light_before {
    const struct svo_light *light; /* of the tree before, which may be gone */
    svo_i_light_changes changes;
    cl_mem origins; /* u32 an inner node: what it was in the tree before, or SVO_NO_NODE. Owned; NULL: not known */
    cl_mem renewed; /* u32 an inner node: octants of its children whose leaves have new radiance. Owned; NULL: all do */
} svo_i_light_before;

/* What svo_light_set_mesh got: kernels/light/mesh.clh. */
typedef struct svo_i_light_mesh {
    cl_mem triangles, materials, texels; /* owned; NULL: there is no mesh */
    cl_mem bends; /* owned; NULL: there are no normal maps */
    uint32_t flags; /* SVO_MESH_* */
} svo_i_light_mesh;

/* The most of a setup. */
#define SVO_I_LIGHT_SOURCES_MAX  1024u
#define SVO_I_LIGHT_FINISHES_MAX 65535u

struct svo_light {
    svo_tree *tree; /* the caller's */
    svo_device *device; /* the tree's */
    svo_light_info info;
    svo_light_params params; /* of its kernels */
    svo_light_options options; /* as asked */
    cl_mem buffers[SVO_LIGHT_BUFFER_COUNT]; /* owned; NULL where not held */
    svo_i_light_setup setup; /* owned */
    cl_mem sky_map; /* and its means, as params.sky_size says; owned; NULL: none (sky.c) */
    bool aims_at_sky; /* behind them are shares, by which paths aim at it */
    svo_i_light_mesh mesh;
    cl_mem emitters; /* svo_emitter_record, by ascending triangle; owned; NULL: none */
    uint32_t emitter_count;
    bool knows_emitters; /* they were listed */
    svo_i_kept_photons *kept; /* owned; NULL: no photons are kept */
    svo_i_kept_nodes *nodes; /* owned; NULL: no nodes are kept */
    svo_i_light_before *before; /* during svo_light_update, which then has given it kept; else NULL */
};

/* The defines of the kernels that make and filter a light: its form, and whether they read areas. Static string. */
const char *svo_i_light_defines(const svo_light *light);
/* Launches a kernel that makes so many bricks. arguments: the last is SVO_I_BRICK_ROOM, which CPUs do without. */
svo_status svo_i_light_launch_bricks(svo_i_device_work *work, const char *name, const svo_i_argument *arguments,
                                     cl_uint argument_count, uint32_t bricks);
#define SVO_I_BRICK_ROOM SVO_I_LOCAL(SVO_BRICK_ROOM_WORDS * sizeof(cl_uint))

/* The projected areas of the leaves, where opacity is by area; else NULL. */
cl_mem svo_i_light_areas(const svo_light *light);

/* Makes one of the light's buffers, of info.bytes[buffer], which the plan or the caller has set. */
svo_status svo_i_light_buffer(svo_i_device_work *work, svo_light *light, svo_light_buffer buffer);
/* Releases one, and says in info that it is not held. */
void svo_i_light_release(svo_light *light, svo_light_buffer buffer);

/* Releases the radiance. */
void svo_i_light_darken(svo_light *light);

/* Arguments for kernels of one level; those of the leaves for level depth. */
svo_light_step svo_i_light_step(const svo_light *light, uint32_t level);

/* Waits, and takes the time since start_ms (svo_i_now_ms) as the stage's. */
svo_status svo_i_light_took(svo_i_device_work *work, svo_light *light, svo_light_stage stage, double start_ms);

#endif
