/* SPDX-License-Identifier: MIT */
/* svocl hash: the hash of a tree, of a light or of probes in it, alone on the last line. */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "support/job.h"
#include "support/options_parse.h"
#include "support/parts_input.h"
#include "support/tree_form.h"
#include "svocl/commands.h"
#include "svocl/probes.h"

/* Fails where --expect asks for another hash. */
static int check_expected(program *state, const char *hash)
{
    const char *expected = state->options.expected_hash;
    return expected == NULL || strcasecmp(expected, hash) == 0
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED, "%s: the hash is %s, and --expect is %s", state->options.input,
                              hash, expected);
}

static int print_digits(program *state, const char *hash)
{
    const int exit_code = check_expected(state, hash);
    if (exit_code == PROGRAM_DONE) {
        progress_hide(state->progress);
        puts(hash);
    }
    return exit_code;
}

/* done: NULL for a hashed file, where nothing was built. */
static int print_hashes(program *state, const char *asked, const char *nodes, const job *done, uint32_t depth)
{
    if (!state->options.json) {
        return print_digits(state, asked);
    }
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "hash", asked);
    json_add_text(document, "scope", state->options.nodes ? "nodes" : "all");
    json_add_text(document, "nodes_hash", nodes);
    if (done != NULL) {
        job_add_what_ran(document, done);
    } else {
        json_add_count(document, "depth", depth);
    }
    const int exit_code = json_print(state, document);
    return exit_code == PROGRAM_DONE ? check_expected(state, asked) : exit_code;
}

static int print_hash(program *state, const svo_tree *tree, const job *done)
{
    char all[SVO_HASH_TEXT_BYTES];
    char nodes[SVO_HASH_TEXT_BYTES];
    svo_tree_info info = SVO_TREE_INFO_INIT;
    progress_step(state->progress, "hashing");
    if (svo_tree_hash(tree, SVO_HASH_ALL, all) != SVO_OK || svo_tree_hash(tree, SVO_HASH_NODES, nodes) != SVO_OK) {
        return program_fail(state, PROGRAM_FAILED, "%s: the tree has no host arrays to hash", state->options.input);
    }
    svo_tree_get_info(tree, &info);
    return print_hashes(state, state->options.nodes ? nodes : all, nodes, done, info.depth);
}

/* The hash of something in a tree, and with --json what is known of it. */
static int print_hash_of(program *state, const char *text, const char *name, const char *value)
{
    if (!state->options.json) {
        return print_digits(state, text);
    }
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "hash", text);
    json_add_text(document, name, value);
    cl_calls_add_kernels(document);
    const int exit_code = json_print(state, document);
    return exit_code == PROGRAM_DONE ? check_expected(state, text) : exit_code;
}

/* ---- light ---- */

/* A light with known sources: a sun, and a lamp in the middle of the grid. Few photons, so that interpreters of kernels
   take part. */
static svo_status make_light(const job *done, svo_light_form form, svo_light **light)
{
    svo_light_options asked = SVO_LIGHT_OPTIONS_INIT;
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    svo_tree_info info = SVO_TREE_INFO_INIT;
    svo_tree_get_info(done->result.tree, &info);
    const svo_light_source sources[2] = {
        {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {-0.3F, -1.0F, -0.2F}, .value = {3.0F, 2.5F, 2.0F}},
        {.kind = SVO_SOURCE_POINT,
         .position = {(float)(info.origin[0] + info.edge / 2), (float)(info.origin[1] + info.edge / 2),
                      (float)(info.origin[2] + info.edge / 2)},
         .value = {1.0F, 1.5F, 2.0F}},
    };
    asked.form = form;
    setup.sources = sources;
    setup.source_count = 2;
    setup.view_resolution = 40;
    svo_status status = svo_light_create(done->result.tree, &asked, done->opened.queue, light);
    if (status == SVO_OK) {
        status = svo_light_set_sources(*light, &setup, done->opened.queue);
    }
    return status;
}

static int print_light_hash(program *state, const job *done)
{
    const svo_light_form form = (svo_light_form)state->options.light_form;
    char text[SVO_HASH_TEXT_BYTES];
    svo_light *light = NULL;
    progress_step(state->progress, "hashing");
    svo_status status = make_light(done, form, &light);
    if (status == SVO_OK) {
        status = svo_light_hash(light, done->opened.queue, text);
    }
    svo_light_destroy(&light);
    if (status != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    return print_hash_of(state, text, "light", svo_name(SVO_NAME_LIGHT_FORM, form));
}

/* ---- probes ---- */

static bool has_probes(const program *state)
{
    return state->options.probe_counts[0] != 0;
}

static int print_probes_hash(program *state, const job *done)
{
    const options *given = &state->options;
    svo_probe_options asked = {.struct_size = sizeof asked,
                               .resolution = (uint32_t)given->probe_resolution,
                               .field_size = (uint32_t)given->probe_field,
                               .tree = done->result.tree};
    char text[SVO_HASH_TEXT_BYTES];
    char counts[64];
    svo_probes *probes = NULL;
    memcpy(asked.counts, given->probe_counts, sizeof asked.counts);
    progress_step(state->progress, "hashing");
    svo_status status = svo_probes_create(&asked, done->opened.queue, &probes);
    if (status == SVO_OK) {
        status = svo_probes_hash(probes, done->opened.queue, text);
    }
    svo_probes_destroy(&probes);
    if (status != SVO_OK) {
        return program_fail_library(state, svo_device_message(done->opened.device));
    }
    (void)snprintf(counts, sizeof counts, "%u,%u,%u", asked.counts[0], asked.counts[1], asked.counts[2]);
    return print_hash_of(state, text, "probes", counts);
}

/* ---- what is in a tree ---- */

static int hash_inside(program *state)
{
    job done;
    int exit_code = input_is_tree(state) ? job_load(state, 1, &done) : job_run(state, state->options.need, 1, &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = has_probes(state) ? print_probes_hash(state, &done) : print_light_hash(state, &done);
    job_release(&done);
    return exit_code;
}

/* ---- compact trees ---- */

static int print_form_hash(program *state, const svo_compact *compact)
{
    char text[SVO_HASH_TEXT_BYTES];
    progress_step(state->progress, "hashing");
    if (svo_compact_hash(compact, text) != SVO_OK) {
        return program_fail(state, PROGRAM_FAILED, "%s: the compact tree cannot be hashed", state->options.input);
    }
    if (!state->options.json) {
        return print_digits(state, text);
    }
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "hash", text);
    tree_form_add_json(document, compact);
    cl_calls_add_kernels(document);
    const int exit_code = json_print(state, document);
    return exit_code == PROGRAM_DONE ? check_expected(state, text) : exit_code;
}

static int hash_form(program *state)
{
    job done;
    svo_compact *compact = NULL;
    int exit_code = input_is_compact(state) ? tree_form_load(state, 2, &done, &compact)
                    : input_is_tree(state)  ? job_load(state, 2, &done)
                                            : job_run(state, state->options.need, 2, &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (compact == NULL) {
        exit_code = tree_form_take(state, &done, &compact);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = print_form_hash(state, compact);
    }
    svo_compact_destroy(&compact);
    job_release(&done);
    return exit_code;
}

/* ---- trees ---- */

/* A whole folder of parts, which may be larger than any tree in memory. */
static int hash_parts(program *state)
{
    char all[SVO_HASH_TEXT_BYTES];
    char nodes[SVO_HASH_TEXT_BYTES];
    const bool needs_nodes = state->options.nodes || state->options.json;
    const bool needs_all = !state->options.nodes;
    svo_parts_tree *tree = NULL;
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_message message = {""};
    progress_step(state->progress, "hashing");
    int exit_code = parts_input_open(state, &tree);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    svo_status status = svo_parts_tree_get_info(tree, &info, &message);
    if (status == SVO_OK && needs_all) {
        status = svo_parts_tree_hash(tree, SVO_HASH_ALL, all, &message);
    }
    if (status == SVO_OK && needs_nodes) {
        status = svo_parts_tree_hash(tree, SVO_HASH_NODES, nodes, &message);
    }
    svo_parts_tree_close(&tree);
    return status == SVO_OK ? print_hashes(state, needs_all ? all : nodes, nodes, NULL, info.tree.depth)
                            : parts_input_fail(state, status, &message);
}

static int hash_tree_file(program *state)
{
    int exit_code = input_refuse_device_options(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    svo_tree *tree = NULL;
    program_begin_progress(state, 2);
    if (input_is_parts(state) && state->options.region == NULL && state->options.last_level == 0) {
        return hash_parts(state);
    }
    exit_code = input_load_tree(state, &tree);
    if (exit_code == PROGRAM_DONE) {
        exit_code = print_hash(state, tree, NULL);
    }
    svo_tree_destroy(&tree);
    return exit_code;
}

int command_hash(program *state)
{
    if (state->options.has_light && state->options.nodes) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--light and --nodes exclude each other");
    }
    if (!has_probes(state) && (state->options.probe_resolution != 0 || state->options.probe_field != 0)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "options of probes require --probes");
    }
    if (has_probes(state) && (state->options.has_light || state->options.nodes)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--probes and --%s exclude each other",
                            state->options.nodes ? "nodes" : "light");
    }
    if (state->options.has_light || has_probes(state)) {
        const int exit_code = options_refuse_groups(state, OPTION_TREE_FORM, "with --light and --probes");
        return exit_code == PROGRAM_DONE ? hash_inside(state) : exit_code;
    }
    if (state->options.tree_form != 0) {
        static const char *const of_trees[] = {"nodes", NULL};
        const int exit_code = options_refuse(state, of_trees, "with --tree-form, whose arrays are hashed");
        return exit_code == PROGRAM_DONE ? hash_form(state) : exit_code;
    }
    if (input_is_tree(state)) {
        return hash_tree_file(state);
    }
    job done;
    int exit_code = job_run(state, state->options.need, 1, &done);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = print_hash(state, done.result.tree, &done);
    job_release(&done);
    return exit_code;
}
