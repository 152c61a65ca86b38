/* SPDX-License-Identifier: MIT */
/* build --max-memory: plans parts, builds one after the other, stitches them. What is done stays for --resume. */
#include "svocl/build_parts.h"

#include <stdlib.h>

#include "support/build_report.h"
#include "support/json.h"
#include "support/output.h"
#include "support/parts_hold.h"
#include "support/parts_job.h"
#include "support/table.h"

/* A build in parts and what it took. */
typedef struct parts_run {
    char *folder;
    session opened;
    parts_holder *holder; /* from before the plan on, so that nobody else plans in between */
    svo_parts *parts;
    parts_mesh mesh;
    double plan_ms, build_ms, stitch_ms;
    bool is_too_large; /* for a file */
} parts_run;

static int check_options(program *state)
{
    const options *given = &state->options;
    const char *other = given->plan_only || given->plan ? "plan"
                        : given->repeat > 1             ? "repeat"
                        : given->compress               ? "compress"
                        : given->solid != 0             ? "solid"
                        : given->count_first            ? "count-first"
                                                        : NULL;
    if (other != NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s does not apply with --max-memory", other);
    }
    if (parts_check_builder(state) != PROGRAM_DONE) {
        return PROGRAM_WRONG_USAGE;
    }
    if ((given->given_groups & (unsigned)OPTION_VOXELS) != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--hidden and --frame do not apply with --max-memory");
    }
    if (given->max_memory == 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--resume requires --max-memory");
    }
    if (given->output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--max-memory needs -o FILE");
    }
    return output_check(state, given->output_path);
}

static int check_folder(program *state, const parts_run *run)
{
    return !parts_folder_has_plan(run->folder) || state->options.resume
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED,
                              "%s exists: --resume goes on from there, svocl parts remove "
                              "removes it",
                              run->folder);
}

static int build_all(program *state, parts_run *run)
{
    const size_t count = svo_parts_count(run->parts);
    const double start_ms = input_now_ms();
    int exit_code = PROGRAM_DONE;
    progress_step(state->progress, "building parts");
    for (size_t i = 0; i < count && exit_code == PROGRAM_DONE; ++i) {
        progress_part(state->progress, "parts", (double)i / (double)count);
        exit_code = parts_build(state, &run->opened, run->parts, i);
    }
    run->build_ms = input_now_ms() - start_ms;
    return exit_code;
}

/* A file has at most so many nodes. */
#define FILE_NODES_MAX 4294967294.0

/* A tree that cannot be stitched is refused before its parts are built. */
static int check_nodes(program *state, const parts_run *run)
{
    svo_part_header header = SVO_PART_HEADER_INIT;
    svo_message message;
    if (svo_parts_get_header(run->parts, &header, &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    return header.expected_nodes <= FILE_NODES_MAX
               ? PROGRAM_DONE
               : program_fail(
                     state, PROGRAM_FAILED,
                     "%s: about %.0f nodes are expected at depth %u, above 2^32 - 2 of a .svo file; svocl parts "
                     "plan and parts build make a folder, which is a tree in itself",
                     state->options.input, header.expected_nodes, header.depth);
}

/* Plans the parts and opens their folder. */
static int plan_all(program *state, parts_run *run)
{
    const double start_ms = input_now_ms();
    int exit_code = parts_plan(state, &run->opened, run->folder, &run->mesh);
    run->plan_ms = input_now_ms() - start_ms;
    if (exit_code == PROGRAM_DONE) {
        exit_code = parts_open(state, run->folder, &run->parts);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = check_nodes(state, run);
        run->is_too_large = exit_code != PROGRAM_DONE;
    }
    return exit_code;
}

static int stitch_all(program *state, parts_run *run)
{
    const double start_ms = input_now_ms();
    svo_message message;
    progress_step(state->progress, "stitching");
    const int exit_code = parts_finish(state, &run->opened, run->parts, state->options.output_path);
    run->stitch_ms = input_now_ms() - start_ms;
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_status status = svo_parts_remove(run->folder, &message);
    return status == SVO_OK ? PROGRAM_DONE : parts_fail(state, status, message.text);
}

static int report_json(program *state, const parts_run *run)
{
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "output", state->options.output_path);
    json_add_count(document, "depth", state->options.depth);
    json_add_count(document, "parts", svo_parts_count(run->parts));
    json_add_count(document, "max_memory_bytes", state->options.max_memory);
    cJSON_AddBoolToObject(document, "mesh_in_blocks", run->mesh.in_blocks);
    json_add_count(document, "mesh_bytes", run->mesh.bytes);
    json_add_count(document, "peak_resident_bytes", peak_memory_bytes());
    cJSON_AddNumberToObject(document, "plan_ms", run->plan_ms);
    cJSON_AddNumberToObject(document, "build_ms", run->build_ms);
    cJSON_AddNumberToObject(document, "stitch_ms", run->stitch_ms);
    return json_print(state, document);
}

static void report_table(const program *state, const parts_run *run)
{
    table *rows = table_create("lr");
    table_heading("%s", state->options.input);
    table_cell(rows, "parts");
    table_cell(rows, "%s", figure_count(svo_parts_count(run->parts)).text);
    table_cell(rows, "import and plan");
    table_cell(rows, "%s", figure_ms(run->plan_ms).text);
    table_cell(rows, "build");
    table_cell(rows, "%s", figure_ms(run->build_ms).text);
    table_cell(rows, "stitch");
    table_cell(rows, "%s", figure_ms(run->stitch_ms).text);
    table_cell(rows, "limit of a part");
    table_cell(rows, "%s", figure_bytes(state->options.max_memory).text);
    if (!run->mesh.in_blocks) {
        table_cell(rows, "mesh");
        table_cell(rows, "%s", figure_bytes(run->mesh.bytes).text);
    }
    table_cell(rows, "peak resident");
    table_cell(rows, "%s", figure_bytes(peak_memory_bytes()).text);
    table_print(rows);
    if (run->mesh.in_blocks) {
        table_line("The mesh was read from its file in blocks.");
    } else {
        table_line("The mesh was in memory as a whole; the limit counts what parts take beside it.");
    }
    if (run->mesh.why_whole.text[0] != '\0') {
        table_line("%s", run->mesh.why_whole.text);
    }
}

static int run_all(program *state, parts_run *run)
{
    int exit_code = check_folder(state, run);
    if (exit_code == PROGRAM_DONE) {
        exit_code = session_open(state, &run->opened);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = parts_hold(state, run->folder, &run->holder);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = plan_all(state, run);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = build_all(state, run);
    }
    return exit_code == PROGRAM_DONE ? stitch_all(state, run) : exit_code;
}

int build_parts(program *state)
{
    parts_run run = {0};
    int exit_code = check_options(state);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    run.folder = parts_folder_of(state->options.output_path);
    if (run.folder == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    program_begin_progress(state, state->options.tree_form != 0 ? 6 : 4);
    const bool is_new = !parts_folder_exists(run.folder);
    exit_code = run_all(state, &run);
    if ((exit_code == PROGRAM_WRONG_USAGE || run.is_too_large) && is_new && parts_folder_exists(run.folder)) {
        (void)svo_parts_remove(run.folder, NULL); /* parts of a limit that is too small serve no other run */
    }
    progress_destroy(&state->progress);
    if (exit_code == PROGRAM_DONE && state->options.json) {
        exit_code = report_json(state, &run);
    } else if (exit_code == PROGRAM_DONE && !state->options.quiet) {
        report_table(state, &run);
    }
    svo_parts_close(&run.parts);
    parts_release(&run.holder);
    session_close(&run.opened);
    free(run.folder);
    return exit_code;
}
