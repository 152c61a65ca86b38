/* SPDX-License-Identifier: MIT */
/*
 * Shared by the cases of svocl stress: the open session, one build with its comparison, and the list of results. Each
 * case runs the whole pipeline on the user's device and driver and is compared with the exact reference.
 */
#ifndef SVOCL_TOOLS_STRESS_STRESS_H
#define SVOCL_TOOLS_STRESS_STRESS_H

#include "measure/triangle_sets.h"
#include "support/program.h"
#include "support/session.h"

#define STRESS_NAME_BYTES 64

typedef struct stress_case {
    char name[STRESS_NAME_BYTES]; /* row of the catalog, then what is special */
    const char *method; /* "svocl" or a float32 method: static */
    uint64_t false_negatives, false_positives; /* missed pairs and surplus pairs */
    double figure; /* the amount compared, or the value measured */
    const char *unit; /* of figure: static */
    double ms; /* wall-clock time of the builds, or of the float32 method on the host */
    bool judged; /* float32 methods are listed, but never fail */
    bool passed;
    char reason[SVO_MESSAGE_BYTES]; /* why it failed; "" otherwise */
} stress_case;

typedef struct stress {
    program *state;
    session opened;
    uint64_t seed;
    size_t count; /* amount of work; 0: the minimum */
    stress_case *cases;
    size_t case_count, case_capacity;
    bool failed; /* out of memory */
} stress;

/* A finished tree, downloaded. */
typedef struct stress_tree {
    svo_tree *tree;
    svo_tree_info info;
    svo_tree_arrays arrays;
    svo_build_report report;
    char hash[SVO_HASH_TEXT_BYTES], nodes_hash[SVO_HASH_TEXT_BYTES];
    double ms;
} stress_tree;

/* Number of triangles in a case: per_count for each --count, or least if that is 0. */
size_t stress_amount(const stress *run, size_t per_count, size_t least);
/* The depth, or the least one if --count is 0. */
unsigned stress_depth(const stress *run, unsigned depth, unsigned least);

/* Begins a case, which has passed so far. */
stress_case stress_begin(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* Marks the case as failed. The first reason is kept. */
void stress_fail(stress_case *one, const char *format, ...) __attribute__((format(printf, 2, 3)));
void stress_end(stress *run, const stress_case *one);

/* Builds by frontend (NULL: that of the session) and adds the time to the case. If the build fails, the case fails
   and false is returned. plan_options: struct_size need not be set. */
bool stress_build(stress *run, svo_frontend *frontend, const svo_mesh *mesh, unsigned depth,
                  const svo_plan_options *plan_options, stress_case *one, stress_tree *out);
void stress_tree_free(stress_tree *built);

/* Compares a tree built with SVO_NEED_RAYS with the reference: snap, pairs, nodes. */
void stress_compare(const svo_mesh *mesh, const svo_plan_options *given, const stress_tree *built, stress_case *one);
/* Builds, compares and releases. */
void stress_check(stress *run, const svo_mesh *mesh, unsigned depth, const svo_plan_options *given, stress_case *one);

/* Runs the float32 methods on the triangles of a tree, one case each, and compares them with the exact voxels of its
   mesh. what: the name of the case. */
void stress_float_methods(stress *run, const char *what, const svo_mesh *mesh, const stress_tree *built);

#endif
