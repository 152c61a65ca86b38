/* SPDX-License-Identifier: MIT */
/*
 * Prints digests of everything that svocl produces for a table of cases, one NAME<TAB>VALUE per line: trees, files,
 * reports, plans, pictures, hits, compact trees, scenes, paged trees, scenes that move, lists of voxels, OpenCL calls.
 * `tools/dev snapshot` sorts and compares them: a refactoring changes none.
 *
 * Times and device names are left out, so that the lines are equal in every run on one machine.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "builds.h"
#include "cases.h"
#include "describe.h"
#include "digest.h"
#include "instances.h"
#include "lists.h"
#include "meshes.h"
#include "moving.h"
#include "paged.h"
#include "queries.h"

typedef struct run {
    opened session;
    case_mesh mesh;
    const char *folder; /* for .svo files */
} run;

static int fail(const char *what, const char *why)
{
    (void)fprintf(stderr, "svocl_snapshot: %s: %s\n", what, why);
    return EXIT_FAILURE;
}

static void build_case(run *state, const svo_mesh *mesh, const request *wanted, const method *by)
{
    char title[LINE_NAME_BYTES], name[LINE_NAME_BYTES];
    build made;
    request_name(wanted, title, sizeof title);
    (void)snprintf(name, sizeof name, "%.180s %s", title, by->name);
    const svo_status status = build_run(&state->session, mesh, wanted, by, &made);
    if (status == SVO_OK) {
        describe_build(name, &state->session, &made, state->folder);
        if (by == &methods[0]) {
            describe_files(name, made.tree, state->folder);
        }
    } else {
        line_text line = {.used = 0};
        line_text_add(&line, "status %d fragments %llu inner %llu", (int)status,
                      (unsigned long long)made.report.fragments, (unsigned long long)made.report.inner_nodes);
        line_print(name, "tree", line.text);
    }
    build_release(&made);
}

/* A plan for each builder, before any build. */
static void plan_case(run *state, const svo_mesh *mesh, const request *wanted, svo_builder builder)
{
    char title[LINE_NAME_BYTES], name[LINE_NAME_BYTES];
    svo_plan *plan = NULL;
    request_name(wanted, title, sizeof title);
    (void)snprintf(name, sizeof name, "%.180s %s", title, builder == SVO_BUILDER_SORTED ? "sorted" : "cl");
    const svo_plan_options options = request_options(wanted, builder);
    const svo_status status = svo_plan_create(state->session.device, mesh, wanted->depth, &options, &plan);
    if (status == SVO_OK) {
        describe_plan(name, plan);
        if (builder == SVO_BUILDER_CL) { /* the one that workspaces are made for */
            describe_room(name, plan, state->session.cl);
        }
    } else {
        line_print_status(name, "plan", status);
    }
    svo_plan_destroy(&plan);
}

static int run_requests(run *state)
{
    for (size_t i = 0; i < request_count; ++i) {
        svo_message message = {""};
        const svo_mesh *mesh = case_mesh_get(&state->mesh, &requests[i], &message);
        if (mesh == NULL) {
            return fail(requests[i].scene, message.text);
        }
        plan_case(state, mesh, &requests[i], SVO_BUILDER_CL);
        plan_case(state, mesh, &requests[i], SVO_BUILDER_SORTED);
        for (size_t m = 0; m < METHOD_COUNT; ++m) {
            if ((requests[i].methods >> m & 1u) != 0) {
                build_case(state, mesh, &requests[i], &methods[m]);
            }
        }
    }
    return EXIT_SUCCESS;
}

static svo_status build_downloaded(const opened *session, const svo_mesh *mesh, const request *wanted, build *made)
{
    const svo_status status = build_run(session, mesh, wanted, &methods[0], made);
    return status != SVO_OK ? status : svo_tree_download(made->tree, session->queue);
}

/* Prints the lines of a built tree, which is on the device and on the host. */
typedef void print_tree(const char *name, const run *state, svo_tree *tree);

static int run_trees(run *state, const request *wanted, size_t count, print_tree *print)
{
    for (size_t i = 0; i < count; ++i) {
        char name[LINE_NAME_BYTES];
        svo_message message = {""};
        build made;
        const svo_mesh *mesh = case_mesh_get(&state->mesh, &wanted[i], &message);
        if (mesh == NULL) {
            return fail(wanted[i].scene, message.text);
        }
        request_name(&wanted[i], name, sizeof name);
        const svo_status status = build_downloaded(&state->session, mesh, &wanted[i], &made);
        if (status == SVO_OK) {
            print(name, state, made.tree);
        } else {
            line_print_status(name, "queries", status);
        }
        build_release(&made);
    }
    return EXIT_SUCCESS;
}

static void print_queries(const char *name, const run *state, svo_tree *tree)
{
    describe_queries(name, &state->session, tree);
}

static int run_queries(run *state)
{
    return run_trees(state, query_requests, query_request_count, print_queries);
}

static void print_pages(const char *name, const run *state, svo_tree *tree)
{
    describe_paged(name, &state->session, tree, state->folder);
}

static int run_paged(run *state)
{
    return run_trees(state, paged_requests, paged_request_count, print_pages);
}

static int run_moving(run *state)
{
    for (size_t i = 0; i < moving_request_count; ++i) {
        char name[LINE_NAME_BYTES];
        svo_message message = {""};
        const svo_mesh *mesh = case_mesh_get(&state->mesh, &moving_requests[i], &message);
        if (mesh == NULL) {
            return fail(moving_requests[i].scene, message.text);
        }
        request_name(&moving_requests[i], name, sizeof name);
        describe_moving(name, &state->session, mesh, &moving_requests[i]);
    }
    return EXIT_SUCCESS;
}

static int run_instances(run *state)
{
    build made[INSTANCED_COUNT] = {{0}};
    svo_tree *trees[INSTANCED_COUNT] = {NULL};
    int result = EXIT_SUCCESS;
    for (int i = 0; i < INSTANCED_COUNT && result == EXIT_SUCCESS; ++i) {
        const request *wanted = &instanced_requests[i];
        svo_message message = {""};
        const svo_mesh *mesh = case_mesh_get(&state->mesh, wanted, &message);
        if (mesh == NULL) {
            result = fail(wanted->scene, message.text);
        } else if (build_run(&state->session, mesh, wanted, &methods[0], &made[i]) != SVO_OK) {
            result = fail(wanted->scene, svo_device_message(state->session.device));
        }
        trees[i] = made[i].tree;
    }
    if (result == EXIT_SUCCESS) {
        describe_instances("instances of knot, cornell, cube", &state->session, trees, INSTANCED_COUNT);
    }
    for (int i = 0; i < INSTANCED_COUNT; ++i) {
        build_release(&made[i]);
    }
    return result;
}

static int run_lists(run *state)
{
    svo_message message = {"no memory"};
    return describe_lists(&state->session, state->folder, &message) == SVO_OK ? EXIT_SUCCESS
                                                                              : fail("lists", message.text);
}

/* On a fresh device handle, which has compiled nothing yet: the first build compiles, the second does not. */
static int count_case(const svo_mesh *mesh, const request *wanted, const method *by)
{
    char title[LINE_NAME_BYTES], name[LINE_NAME_BYTES];
    svo_message message = {""};
    opened session;
    request_name(wanted, title, sizeof title);
    if (opened_create(&session, &message) != SVO_OK) {
        return fail(title, message.text);
    }
    for (int i = 0; i < 2; ++i) {
        build made;
        (void)snprintf(name, sizeof name, "%.170s %s %s", title, by->name, i == 0 ? "first" : "second");
        const svo_status status = build_run(&session, mesh, wanted, by, &made);
        line_print_status(name, "build", status);
        describe_calls(name, &made);
        build_release(&made);
    }
    opened_release(&session);
    return EXIT_SUCCESS;
}

static int run_counts(run *state)
{
    for (size_t i = 0; i < counted_request_count; ++i) {
        svo_message message = {""};
        const svo_mesh *mesh = case_mesh_get(&state->mesh, &counted_requests[i], &message);
        if (mesh == NULL) {
            return fail(counted_requests[i].scene, message.text);
        }
        for (size_t m = 0; m < METHOD_COUNT; ++m) {
            const unsigned chosen = counted_requests[i].methods >> m & 1u;
            if (chosen != 0 && count_case(mesh, &counted_requests[i], &methods[m]) != EXIT_SUCCESS) {
                return EXIT_FAILURE;
            }
        }
    }
    return EXIT_SUCCESS;
}

static int run_all(run *state)
{
    int (*const parts[])(run *) = {run_requests,  run_queries, run_paged, run_moving,
                                   run_instances, run_lists,   run_counts};
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
        const int result = parts[i](state);
        if (result != EXIT_SUCCESS) {
            return result;
        }
    }
    return fflush(stdout) == 0 && !ferror(stdout) ? EXIT_SUCCESS : fail("standard output", "cannot be written");
}

int main(int argc, char **argv)
{
    svo_message message = {""};
    if (argc != 2) {
        return fail("usage", "svocl_snapshot FOLDER, which is for files that it makes and removes");
    }
    run state = {.folder = argv[1]};
    if (opened_create(&state.session, &message) != SVO_OK) {
        return fail("no device", message.text);
    }
    const int result = run_all(&state);
    case_mesh_release(&state.mesh);
    opened_release(&state.session);
    return result;
}
