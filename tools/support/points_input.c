/* SPDX-License-Identifier: MIT */
/* Reads point clouds and says what they hold. */
#include "support/points_input.h"

#include <stdio.h>
#include <string.h>

#include "support/options_parse.h"
#include "support/table.h"

bool points_input_is_given(const program *state)
{
    const char *input = state->options.input;
    const svo_voxel_format format =
        svo_voxel_format_of_path(piped_is(&state->piped, input) ? state->piped.suffix : input);
    if (format == SVO_VOXEL_FORMAT_PLY) {
        return svo_points_format(piped_source(&state->piped, input)) == SVO_VOXEL_FORMAT_PLY;
    }
    return format == SVO_VOXEL_FORMAT_LAS || format == SVO_VOXEL_FORMAT_LAZ;
}

int points_input_read(program *state, svo_voxels **voxels, svo_points_info *info)
{
    const options *given = &state->options;
    svo_message message = {""};
    svo_points_options asked = {.struct_size = sizeof asked,
                                .depth = given->has_depth ? (uint32_t)given->depth : 0,
                                .axes = (uint32_t)given->axes,
                                .voxel_edge = given->voxel_size,
                                .edge = given->edge,
                                .memory_bytes = given->max_memory,
                                .voxels_max = given->max_voxels < SVO_VOXELS_MAX ? given->max_voxels : SVO_VOXELS_MAX,
                                .counts = (uint32_t)given->counts,
                                .log = program_log,
                                .log_user = state};
    memcpy(asked.origin, given->origin, sizeof asked.origin);
    *info = (svo_points_info)SVO_POINTS_INFO_INIT;
    return svo_points_load(piped_source(&state->piped, given->input), &asked, voxels, info, &message) == SVO_OK
               ? PROGRAM_DONE
               : program_fail_library(state, message.text);
}

/* ---- the report ---- */

static const char *name_of_color(const svo_points_info *info)
{
    static const char *const names[] = {"white", "rgb", "intensity"};
    return names[info->color];
}

/* "LAS 1.4, point format 7" */
static void name_format(const svo_points_info *info, char *text, size_t text_bytes)
{
    if (info->format == SVO_VOXEL_FORMAT_LAS) {
        (void)snprintf(text, text_bytes, "LAS %u.%u, point format %u", info->version / 10, info->version % 10,
                       info->point_format);
    } else {
        (void)snprintf(text, text_bytes, "PLY");
    }
}

static void add_left_out(table *rows, const char *name, uint64_t count)
{
    if (count > 0) {
        table_cell(rows, "%s", name);
        table_cell(rows, "%s, left out", figure_count(count).text);
    }
}

void points_input_add_rows(struct table *rows, const svo_points_info *info)
{
    char format[64];
    name_format(info, format, sizeof format);
    table_cell(rows, "format");
    table_cell(rows, "%s", format);
    table_cell(rows, "points");
    table_cell(rows, "%s", figure_count(info->point_count).text);
    add_left_out(rows, "withheld", info->withheld_count);
    add_left_out(rows, "not finite", info->not_finite_count);
    add_left_out(rows, "outside", info->outside_count);
    table_cell(rows, "low");
    table_cell(rows, "%.9g, %.9g, %.9g", info->low[0], info->low[1], info->low[2]);
    table_cell(rows, "high");
    table_cell(rows, "%.9g, %.9g, %.9g", info->high[0], info->high[1], info->high[2]);
    table_cell(rows, "color");
    table_cell(rows, "%s", name_of_color(info));
    if (info->voxel_count > 0) {
        table_cell(rows, "voxels");
        table_cell(rows, "%s of %.9g, at most %s points in one", figure_count(info->voxel_count).text, info->voxel_edge,
                   figure_count(info->count_max).text);
    }
}

void points_input_add_json(cJSON *document, const svo_points_info *info)
{
    cJSON *object = cJSON_AddObjectToObject(document, "points");
    json_add_text(object, "format", svo_name(SVO_NAME_VOXEL_FORMAT, info->format));
    json_add_count(object, "version", info->version);
    json_add_count(object, "point_format", info->point_format);
    json_add_count(object, "points", info->point_count);
    json_add_count(object, "taken", info->taken_count);
    json_add_count(object, "withheld", info->withheld_count);
    json_add_count(object, "not_finite", info->not_finite_count);
    json_add_count(object, "outside", info->outside_count);
    json_add_text(object, "color", name_of_color(info));
    json_add_count(object, "rgb_max", info->rgb_max);
    json_add_count(object, "intensity_max", info->intensity_max);
    json_add_vector(object, "low", info->low);
    json_add_vector(object, "high", info->high);
    json_add_vector(object, "origin", info->origin);
    cJSON_AddNumberToObject(object, "voxel_edge", info->voxel_edge);
    json_add_count(object, "voxels", info->voxel_count);
    json_add_count(object, "count_max", info->count_max);
}
