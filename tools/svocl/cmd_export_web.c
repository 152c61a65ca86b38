/* SPDX-License-Identifier: MIT */
/* svocl export-web: a page of one file that shows a tree in a browser. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "support/job.h"
#include "support/output.h"
#include "support/table.h"
#include "svocl/commands.h"
#include "svocl/compact.h"
#include "web/page.h"

/* What is made on the way from INPUT to the page. */
typedef struct web_export {
    job done; /* empty for a compact tree that is taken as it is */
    svo_compact *compact;
    web_tree tree;
    web_page page;
    unsigned char *packed; /* by malloc */
    size_t page_bytes;
} web_export;

/* ---- the compact tree ---- */

static int make_compact(program *state, uint32_t minimize, web_export *made)
{
    const session *opened = &made->done.opened;
    const svo_compact_options wanted = {.struct_size = sizeof wanted,
                                        .form = SVO_FORM_IMPLIED,
                                        .leave_out = SVO_NEED_ALL & ~(SVO_NEED_COLOR | SVO_NEED_NORMAL),
                                        .directory_step_log2 = WEB_DIRECTORY_STEP_LOG2,
                                        .minimize = minimize};
    const svo_tree *tree = made->done.result.tree;
    progress_step(state->progress, "making the compact tree");
    if (svo_compact_create(opened->device, tree, &wanted, opened->queue, &made->compact) != SVO_OK ||
        svo_compact_download(made->compact, opened->queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    return PROGRAM_DONE;
}

/* A file of a compact tree in the form that pages have is taken as it is; others are expanded. */
static int load_compact(program *state, web_export *made)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    int exit_code = input_refuse_build_options(state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = input_load_compact(state, &made->compact);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    (void)svo_compact_get_info(made->compact, &info);
    if (info.form == SVO_FORM_IMPLIED && info.directory_step_log2 == WEB_DIRECTORY_STEP_LOG2) {
        program_begin_progress(state, 2);
        return PROGRAM_DONE;
    }
    svo_compact_destroy(&made->compact);
    exit_code = job_load(state, 3, &made->done);
    return exit_code == PROGRAM_DONE ? make_compact(state, info.minimized, made) : exit_code;
}

static int open_input(program *state, web_export *made)
{
    if (input_is_compact(state)) {
        return load_compact(state, made);
    }
    const int exit_code =
        input_is_tree(state) ? job_load(state, 3, &made->done) : job_run(state, state->options.need, 3, &made->done);
    return exit_code == PROGRAM_DONE ? make_compact(state, 0, made) : exit_code;
}

/* ---- the page ---- */

/* What the page calls the tree: a page that is handed around does not say where its file was. */
static const char *name_of_input(const options *given)
{
    const char *slash = strrchr(given->input, '/');
    return slash != NULL && slash[1] != '\0' ? slash + 1 : given->input;
}

/* Packs the tree down to a level; *fits tells whether the page is within --max-bytes then. */
static int pack_level(program *state, uint32_t level, web_export *made, bool *fits)
{
    web_page *page = &made->page;
    size_t shell_bytes = 0;
    page->cut = web_cut_at(&made->tree, level);
    const int exit_code = web_page_measure(state, page, &shell_bytes);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const size_t room = web_page_room(state->options.max_bytes, shell_bytes);
    const web_pack_status status = web_pack(&made->tree, &page->cut, room, &made->packed, &page->packed_count);
    if (status == WEB_PACK_NO_MEMORY) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the compressed nodes");
    }
    *fits = status == WEB_PACK_DONE;
    page->packed = made->packed;
    made->page_bytes = shell_bytes + (page->packed_count + 2) / 3 * 4; /* base64 */
    return PROGRAM_DONE;
}

/* The deepest level that fits. */
static int pack(program *state, web_export *made)
{
    bool fits = false;
    made->tree = web_tree_of(made->compact);
    made->page = (web_page){.name = name_of_input(&state->options), .tree = &made->tree};
    progress_step(state->progress, "compressing the nodes");
    for (uint32_t level = made->tree.info.depth; level > 0 && !fits; --level) {
        const int exit_code = pack_level(state, level, made, &fits);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    return fits ? PROGRAM_DONE
                : program_fail(state, PROGRAM_FAILED,
                               "--max-bytes %" PRIu64 " is too small for a page of the first level alone",
                               state->options.max_bytes);
}

static int write_page(program *state, web_export *made)
{
    output_file file;
    progress_step(state->progress, "writing the page");
    int exit_code = output_open(state, state->options.output_path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = web_page_write(state, &made->page, file.stream);
    if (exit_code != PROGRAM_DONE) {
        output_abandon(&file);
        return exit_code;
    }
    return output_commit(state, &file);
}

/* ---- the command ---- */

static int report_json(program *state, const web_export *made)
{
    const web_cut *cut = &made->page.cut;
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "file", state->options.output_path);
    json_add_count(document, "bytes", made->page_bytes);
    json_add_count(document, "max_bytes", state->options.max_bytes);
    json_add_count(document, "packed_bytes", made->page.packed_count);
    json_add_count(document, "unpacked_bytes", cut->byte_count);
    json_add_count(document, "depth", made->tree.info.depth);
    json_add_count(document, "level", cut->level);
    json_add_count(document, "nodes", cut->node_count);
    json_add_count(document, "leaves", cut->leaf_count);
    cJSON_AddBoolToObject(document, "colors", cut->colors.count > 0);
    cJSON_AddBoolToObject(document, "normals", cut->normals.count > 0);
    return json_print(state, document);
}

static int report(program *state, const web_export *made)
{
    const options *given = &state->options;
    const web_cut *cut = &made->page.cut;
    const uint32_t depth = made->tree.info.depth;
    if (given->json) {
        return report_json(state, made);
    }
    if (given->quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(state->progress);
    table_line("%s: %s, %s leaves at depth %u of %s%s%s", output_name(given->output_path),
               figure_bytes(made->page_bytes).text, figure_count(cut->leaf_count).text, cut->level, given->input,
               cut->colors.count > 0 ? ", colors" : "", cut->normals.count > 0 ? ", normals" : "");
    if (cut->level < depth) {
        table_line("Levels %u to %u are left out: with them the page would exceed %s (--max-bytes).", cut->level + 1,
                   depth, figure_bytes(given->max_bytes).text);
    }
    return PROGRAM_DONE;
}

int command_export_web(program *state)
{
    web_export made = {0};
    if (state->options.output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    int exit_code = output_check(state, state->options.output_path);
    if (exit_code == PROGRAM_DONE) {
        exit_code = open_input(state, &made);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = pack(state, &made);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_page(state, &made);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, &made);
    }
    free(made.packed);
    svo_compact_destroy(&made.compact);
    job_release(&made.done);
    return exit_code;
}
