/* SPDX-License-Identifier: MIT */
/* What test_faults.c plays, what its scenarios share, and their small steps. */
#ifndef SVOCL_TESTS_FAULTS_SCENARIO_H
#define SVOCL_TESTS_FAULTS_SCENARIO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/device.h"
#include "faults.h"
#include "support/attributed_mesh.h"
#include "support/nondefault_state.h"
#include "support/own_context.h"
#include "svocl/gl.h"
#include "svocl/io.h"
#include "svocl/svocl.h"

enum { TRIANGLES = 40, DEPTH = 4, RAYS = 64, PICTURE_SIDE = 32 };

/* What scenarios share. Opened once; no call fails meanwhile. */
typedef struct faults_world {
    svo_device *device, *saver; /* saver: with one compiled program */
    cl_command_queue queue;
    svo_frontend *cl;
    svo_gl_context *context; /* NULL: no OpenGL here */
    svo_gl *host, *copy;
    own_context own; /* the caller's */
    uint32_t gl_buffer;
    cl_kernel kernel; /* the caller's */
    attributed_mesh mesh;
    svo_mesh floats; /* the same, with float_positions */
    float float_positions[TRIANGLES * 9];
    svo_ray rays[RAYS];
    svo_query_point points[RAYS];
    char folder[64];
    char obj_path[128], ply_path[128], stl_path[128], off_path[128];
    char gltf_path[128], kernels_folder[128];
    char tree_path[128], packed_path[128], compact_path[128], vox_path[128], report_path[128];
    uint64_t stride;
    bool quick; /* every second place alone */
    uint64_t failed_calls[FAULT_KINDS], recovered;
    unsigned violations;
    faults_objects kept; /* what the process keeps to its end */
    char current[128]; /* for words after a crash or a hang */
} faults_world;
extern faults_world world;

/* What one run works on. */
typedef struct subject {
    svo_device *device;
    svo_plan *plan;
    svo_tree *tree;
    svo_workspace *workspace;
    svo_gl *gl;
    cl_mem positions, normals, indices;
    svo_compact *compact;
    svo_light *light;
    svo_probes *probes;
    cl_kernel kernels[3]; /* of the caller's, with the parameters of these */
    const char *mesh_path;
    nondefault_state *state; /* of the caller's context */
    char warning[256]; /* of an import that leaves something out */
    svo_message message;
    XXH64_hash_t digest; /* of the results */
} subject;

typedef struct scenario {
    const char *name;
    bool gl; /* needs OpenGL */
    bool in_child; /* calls of the import child fail */
    void (*prepare)(subject *of);
    svo_status (*run)(subject *of); /* what it makes it destroys; may run again after a failure */
    void (*look)(subject *of); /* adds to the digest what run leaves; NULL allowed */
    void (*cleanup)(subject *of);
} scenario;

typedef struct scenario_list {
    const scenario *rows;
    size_t count;
} scenario_list;

extern const scenario_list library_scenarios, form_scenarios, file_scenarios, opengl_scenarios;

/*
 * Small steps.
 */

/* Adds to the digest of the results. */
void digest(subject *of, const void *bytes, size_t byte_count);
/* Takes the message of the device's handle. */
svo_status told(subject *of, const svo_device *device, svo_status status);
#define TRY_TOLD(call) SVO_I_TRY(told(of, world.device, (call)))

/* A plan with all needs; the same with other options; its tree; that, downloaded. */
extern const svo_plan_options everything;
void prepare_nothing(subject *of);
void prepare_plan(subject *of);
void prepare_plan_by(subject *of, const svo_plan_options *options);
void prepare_tree(subject *of);
void prepare_host_tree(subject *of);
void destroy_all(subject *of);
/* An empty kernel of the caller's. text: "kernel void empty(...) {}". */
cl_kernel make_kernel(svo_target target, const char *text);
/* Releases the event of a call that has succeeded. */
void release_event(cl_event *event);

/* Downloads the tree and adds its hash to the digest. */
svo_status digest_tree(subject *of, svo_tree *tree);
/* Builds what of->plan plans. */
svo_status build_and_digest(subject *of, svo_frontend *frontend);
/* Traces of->tree in each way. */
svo_status run_rays(subject *of);
/* Writes both files of of->tree. */
svo_status run_save(subject *of);
/* Removes the files of world.kernels_folder. */
void remove_kernels(void);

#endif
