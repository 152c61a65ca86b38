/* SPDX-License-Identifier: MIT */
/* Reads voxel files and point clouds, and says what they hold. */
#include "support/voxel_input.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "support/options_parse.h"
#include "support/table.h"

bool voxel_input_is_given(const program *state)
{
    const svo_voxel_format format = svo_voxel_format_of_path(
        piped_is(&state->piped, state->options.input) ? state->piped.suffix : state->options.input);
    return format == SVO_VOXEL_FORMAT_VOX || format == SVO_VOXEL_FORMAT_SVX || format == SVO_VOXEL_FORMAT_BINVOX ||
           format == SVO_VOXEL_FORMAT_NVDB || format == SVO_VOXEL_FORMAT_VDB || format == SVO_VOXEL_FORMAT_BT ||
           points_input_is_given(state);
}

static svo_voxels_load_options load_options_of(program *state)
{
    const options *given = &state->options;
    return (svo_voxels_load_options){.struct_size = sizeof(svo_voxels_load_options),
                                     .hidden = (uint32_t)given->hidden,
                                     .frame = (uint32_t)given->frame,
                                     .voxels_max = given->max_voxels,
                                     .axes = (uint32_t)given->axes,
                                     .log = program_log,
                                     .log_user = state};
}

static int open_points(program *state, voxel_input *opened)
{
    *opened = (voxel_input){.list = SVO_VOXELS_INFO_INIT};
    const int exit_code = points_input_read(state, &opened->voxels, &opened->points);
    if (exit_code == PROGRAM_DONE) {
        (void)svo_voxels_get_info(opened->voxels, &opened->list);
    }
    return exit_code;
}

int voxel_input_open(program *state, voxel_input *opened)
{
    svo_message message = {""};
    const options *given = &state->options;
    const svo_voxels_load_options load_options = load_options_of(state);
    if (points_input_is_given(state)) {
        return open_points(state, opened);
    }
    if (given->counts) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--counts applies to point clouds, not to %s", given->input);
    }
    *opened = (voxel_input){.file = SVO_VOXEL_FILE_INFO_INIT, .list = SVO_VOXELS_INFO_INIT};
    if (svo_voxels_load(piped_source(&state->piped, given->input), &load_options, &opened->voxels, &opened->file,
                        &message) != SVO_OK) {
        return program_fail_library(state, message.text);
    }
    (void)svo_voxels_get_info(opened->voxels, &opened->list);
    return PROGRAM_DONE;
}

svo_status voxel_input_copy(program *state, svo_sink sink, voxel_input *opened, svo_message *message)
{
    const svo_voxels_load_options load_options = load_options_of(state);
    *opened = (voxel_input){.file = SVO_VOXEL_FILE_INFO_INIT, .list = SVO_VOXELS_INFO_INIT};
    return svo_voxels_copy_vox(piped_source(&state->piped, state->options.input), sink, &load_options, &opened->file,
                               message);
}

svo_status voxel_input_read_parts(program *state, svo_voxel_part_callback callback, void *user, voxel_input *opened,
                                  svo_message *message)
{
    const svo_voxels_load_options load_options = load_options_of(state);
    *opened = (voxel_input){.file = SVO_VOXEL_FILE_INFO_INIT, .list = SVO_VOXELS_INFO_INIT};
    return svo_voxels_load_parts(piped_source(&state->piped, state->options.input), &load_options, callback, user,
                                 &opened->file, message);
}

void voxel_input_warn(program *state, const voxel_input *opened, const char *others)
{
    svo_message file = {""};
    svo_message line;
    if (opened->file.struct_size > 0) { /* of a file, not of a tree */
        (void)svo_voxels_left_out(&opened->file, &file);
    }
    const bool has_others = others != NULL && others[0] != '\0';
    if (file.text[0] == '\0' && !has_others) {
        return;
    }
    (void)snprintf(line.text, sizeof line.text, "%s: left out: %s%s%s", state->options.input, file.text,
                   file.text[0] != '\0' && has_others ? ", " : "", has_others ? others : "");
    program_log(state, SVO_LOG_WARNING, line.text);
}

void voxel_input_close(voxel_input *opened)
{
    svo_voxels_destroy(&opened->voxels);
}

int voxel_input_check_options(program *state, uint32_t need)
{
    const options *given = &state->options;
    static const char *const of_meshes[] = {"origin",        "edge",       "voxel-size", "coverage",
                                            "weights",       "drop-alpha", "strict",     "import-seconds",
                                            "import-memory", "weld",       NULL};
    /* Points have a grid of the caller's, as meshes have; the first three make it. */
    const char *const *names = of_meshes + (points_input_is_given(state) ? 3 : 0);
    if (options_refuse(state, names, "to voxels") != PROGRAM_DONE ||
        (options_ask_for_gl(given) && options_refuse_groups(state, OPTION_METHODS, "to voxels") != PROGRAM_DONE)) {
        return PROGRAM_WRONG_USAGE;
    }
    const uint32_t known = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_MATERIAL | (uint32_t)SVO_NEED_NONE;
    if ((need & ~known) != 0 && points_input_is_given(state)) { /* whose suffix may be that of a mesh */
        return program_fail(state, PROGRAM_FAILED, "%s: no triangles: points have colors and counts, but no %s",
                            given->input, figure_needs(need & ~known).text);
    }
    if ((need & ~known) != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s holds voxels, which have colors and materials, but no %s",
                            given->input, figure_needs(need & ~known).text);
    }
    return PROGRAM_DONE;
}

svo_status voxel_input_plan(const program *state, svo_device *device, const voxel_input *opened,
                            const svo_plan_options *plan_options, svo_plan **out)
{
    svo_plan_options by_voxels = *plan_options;
    if (!state->options.has_builder) {
        by_voxels.builder = SVO_BUILDER_SORTED;
    }
    if (opened->points.struct_size > 0) { /* the options made the grid of the points, which the list has */
        by_voxels.edge = 0.0;
        memset(by_voxels.origin, 0, sizeof by_voxels.origin);
        return svo_voxels_plan(device, opened->voxels, 0, &by_voxels, out);
    }
    return svo_voxels_plan(device, opened->voxels, state->options.has_depth ? (unsigned)state->options.depth : 0,
                           &by_voxels, out);
}

/* The counts and their names. */
typedef struct voxel_count {
    const char *name;
    uint64_t count;
} voxel_count;

enum { VOXEL_COUNTS = 6, LIST_COUNTS = 1 }; /* the last are the list's */

/* How many there are: a copy has no list. */
static int count_counts(const voxel_input *opened)
{
    return opened->voxels != NULL ? VOXEL_COUNTS : VOXEL_COUNTS - LIST_COUNTS;
}

static void list_counts(const voxel_input *opened, voxel_count counts[VOXEL_COUNTS])
{
    counts[0] = (voxel_count){"models", opened->file.models};
    counts[1] = (voxel_count){"instances", opened->file.instances};
    counts[2] = (voxel_count){"rotated_instances", opened->file.rotated_instances};
    counts[3] = (voxel_count){"hidden_instances", opened->file.hidden_instances};
    counts[4] = (voxel_count){"instance_voxels", opened->file.instance_voxels};
    counts[5] = (voxel_count){"distinct_voxels", opened->list.voxel_count};
}

void voxel_input_add_rows(table *rows, const voxel_input *opened)
{
    voxel_count counts[VOXEL_COUNTS];
    if (opened->points.struct_size > 0) {
        points_input_add_rows(rows, &opened->points);
        return;
    }
    list_counts(opened, counts);
    for (int i = 0; i < count_counts(opened); ++i) {
        char name[32];
        snprintf(name, sizeof name, "%s", counts[i].name);
        for (char *c = name; *c != '\0'; ++c) {
            *c = *c == '_' ? ' ' : *c;
        }
        table_cell(rows, "%s", name);
        table_cell(rows, "%s", figure_count(counts[i].count).text);
    }
}

void voxel_input_add_json(cJSON *document, const voxel_input *opened)
{
    voxel_count counts[VOXEL_COUNTS];
    svo_message left_out = {""};
    if (opened->points.struct_size > 0) {
        points_input_add_json(document, &opened->points);
        return;
    }
    cJSON *object = cJSON_AddObjectToObject(document, "voxels");
    list_counts(opened, counts);
    json_add_text(object, "format", svo_name(SVO_NAME_VOXEL_FORMAT, (svo_voxel_format)opened->file.format));
    json_add_count(object, "version", opened->file.version);
    for (int i = 0; i < count_counts(opened); ++i) {
        json_add_count(object, counts[i].name, counts[i].count);
    }
    if (opened->voxels == NULL) {
        return;
    }
    (void)svo_voxels_left_out(&opened->file, &left_out);
    json_add_text(object, "left_out", left_out.text);
    cJSON *low = cJSON_AddArrayToObject(object, "low");
    cJSON *high = cJSON_AddArrayToObject(object, "high");
    for (int axis = 0; axis < 3; ++axis) {
        cJSON_AddItemToArray(low, cJSON_CreateNumber(opened->list.low[axis]));
        cJSON_AddItemToArray(high, cJSON_CreateNumber(opened->list.high[axis]));
    }
}
