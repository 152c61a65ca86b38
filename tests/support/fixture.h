/* SPDX-License-Identifier: MIT */
/*
 * The environment of tests of whole builds: a device with a queue, the OpenCL front end and, on request, an OpenGL
 * context with its front end; scenes; and the results of a build. Call the functions inside a running cmocka test. What
 * this machine lacks skips the test and prints the reason. What exists but does not work fails the test with the
 * library's message.
 */
#ifndef SVOCL_TESTS_FIXTURE_H
#define SVOCL_TESTS_FIXTURE_H

#include <stdbool.h>

#include "svocl/gl.h"
#include "svocl/svocl.h"

typedef struct fixture_options {
    unsigned context; /* 1 + svo_gl_context_kind; 0: the first available kind */
    svo_gl_share share;
    uint32_t no_int64; /* as in svo_gl_options */
    cl_command_queue_properties queue_properties;
    svo_path path; /* SVO_PATH_AUTO: by the environment variable SVOCL_TEST_PATH, "cpu" or "gpu", else by the device */
} fixture_options;

typedef struct fixture {
    svo_device *device;
    cl_command_queue queue;
    svo_gl_context *context;
    svo_gl *gl;
    svo_frontend *cl; /* owned */
    svo_frontend *frontend; /* used by fixture_build */
} fixture;

/* SVO_PATH_AUTO, or the path that SVOCL_TEST_PATH names. */
svo_path fixture_path(void);

/* With OpenGL; builds use its front end. */
void fixture_open(const fixture_options *options, fixture *out);
/* Without OpenGL; builds use the OpenCL front end. */
void fixture_open_cl(const fixture_options *options, fixture *out);
void fixture_close(fixture *opened); /* all zero is allowed */

/* One fixture for all tests of a program: group setup and teardown, and the fixture itself, opened on first use. */
int fixture_group_setup(void **state);
int fixture_group_teardown(void **state);
fixture *fixture_of_group(void **state);
/* The same for builds with OpenCL alone; opens no OpenGL. A view that must not be closed. */
fixture fixture_cl_of_group(void **state);

/* For groups that use the kernels of GPUs: PoCL compiles without its optimizer, for no GPU runs what that makes. */
int fixture_group_setup_unoptimized(void **state);
int fixture_group_teardown_unoptimized(void **state);

/* Closes the fixture and ends the running test as skipped. */
void fixture_skip(fixture *opened, const char *reason);
void fixture_close_gl(fixture *opened); /* for fixture_close */

/* Whether builds by the kernels for CPUs evaluate pairs eight at a time: only on CPUs whose doubles are known to be
   exact (lib/plan/configuration.c). Others have other buffers and kernels, and the same results. */
bool fixture_has_pair_lanes(const fixture *opened);

/* A procedural scene by its specification, in the program's syntax. Released by scene_destroy. */
struct scene *fixture_scene(const char *spec);

#define FIXTURE_BUFFERS_MAX 48

/* A finished tree, downloaded, with its build's figures. */
typedef struct built {
    svo_tree *tree;
    svo_tree_info info;
    svo_tree_arrays arrays;
    char hash[SVO_HASH_TEXT_BYTES], nodes_hash[SVO_HASH_TEXT_BYTES];
    svo_build_report report;
    svo_plan_info plan;
    uint32_t weight_log2; /* log2 of a voxel face's area, in the plan's units of weight */
    svo_buffer_info buffers[FIXTURE_BUFFERS_MAX]; /* the plan's list after the build */
    size_t buffer_count;
} built;

/* options: NULL means all defaults; struct_size need not be set. */
void fixture_build(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                   built *out);
/* The same with another function than svo_build. */
typedef svo_status fixture_builder(const fixture *opened, svo_plan *plan, svo_tree **out, svo_build_report *report);
void fixture_build_by(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                      fixture_builder *by, built *out);
/* The same with svo_gl_build. */
void fixture_build_in_gl(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                         built *out);
void built_destroy(built *finished);

/* A caller's kernel whose parameters have the sizes of SVO_TREE_PARAMETERS, without the time to compile these. */
cl_kernel fixture_tree_kernel(cl_context context, cl_device_id device);

#endif
