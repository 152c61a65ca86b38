/* SPDX-License-Identifier: MIT */
/* The solid of a tree, for build and verify. */
#include "support/solid_report.h"

#include "support/table.h"

bool solid_is_wanted(const program *state)
{
    return state->options.solid != 0;
}

svo_solid_rule solid_rule(const program *state)
{
    return (svo_solid_rule)(state->options.solid - 1);
}

uint32_t solid_need(const program *state, uint32_t need)
{
    return solid_is_wanted(state) ? (need & ~(uint32_t)SVO_NEED_NONE) | (uint32_t)SVO_NEED_RAYS : need;
}

int solid_make(program *state, const svo_device *device, const svo_tree *tree, solid_result *out)
{
    *out = (solid_result){.info = SVO_SOLID_INFO_INIT, .form = SVO_COMPACT_INFO_INIT};
    if (!solid_is_wanted(state)) {
        return PROGRAM_DONE;
    }
    const svo_solid_options asked = {.struct_size = sizeof asked, .rule = solid_rule(state)};
    const double compiled_ms = svo_device_compile_ms(device);
    progress_step(state->progress, "finding the inside");
    const double start_ms = input_now_ms();
    if (svo_solid_create(tree, &asked, NULL, &out->solid, &out->info) != SVO_OK) {
        return program_fail_library(state, svo_device_message(device));
    }
    out->compile_ms = svo_device_compile_ms(device) - compiled_ms;
    out->ms = input_now_ms() - start_ms - out->compile_ms;
    (void)svo_compact_get_info(out->solid, &out->form);
    return PROGRAM_DONE;
}

void solid_release(solid_result *made)
{
    svo_compact_destroy(&made->solid);
}

static bool is_closed(const svo_solid_info *info)
{
    return info->open_columns[0] == 0 && info->open_columns[1] == 0 && info->open_columns[2] == 0;
}

static void add_row(table *rows, const char *name, uint64_t voxels, uint64_t leaves)
{
    table_cell(rows, "%s", name);
    table_cell(rows, "%s", figure_count(voxels).text);
    table_cell(rows, "%s", figure_count(leaves).text);
}

void solid_print(const program *state, const solid_result *made)
{
    const svo_solid_info *info = &made->info;
    if (made->solid == NULL) {
        return;
    }
    table_gap();
    table_heading("solid by %s, %s, and %s of compiling", svo_solid_rule_name(solid_rule(state)),
                  figure_ms(made->ms).text, figure_ms(made->compile_ms).text);
    table *rows = table_create("lrr");
    table_cell(rows, "%s", "");
    table_cell(rows, "voxels");
    table_cell(rows, "leaves");
    add_row(rows, "surface", info->surface_voxels, info->surface_voxels);
    add_row(rows, "inside", info->inside_voxels, info->inside_leaves);
    add_row(rows, "ambiguous", info->ambiguous_voxels, info->ambiguous_cells);
    table_print(rows);
    table_line("%s empty cells tested, %s of words and payload", figure_count(info->tests).text,
               figure_bytes(made->form.total_bytes).text);
    if (!is_closed(info)) {
        table_line("the surface is not closed: crossings do not cancel in %s columns along x, %s along y, %s along z",
                   figure_count(info->open_columns[0]).text, figure_count(info->open_columns[1]).text,
                   figure_count(info->open_columns[2]).text);
    }
}

cJSON *solid_add_json(cJSON *document, const program *state, const solid_result *made)
{
    const svo_solid_info *info = &made->info;
    static const char *const axes[3] = {"x", "y", "z"};
    if (made->solid == NULL) {
        return NULL;
    }
    cJSON *object = cJSON_AddObjectToObject(document, "solid");
    json_add_text(object, "rule", svo_solid_rule_name(solid_rule(state)));
    json_add_count(object, "surface_voxels", info->surface_voxels);
    json_add_count(object, "inside_voxels", info->inside_voxels);
    json_add_count(object, "inside_leaves", info->inside_leaves);
    json_add_count(object, "tests", info->tests);
    json_add_count(object, "ambiguous_cells", info->ambiguous_cells);
    json_add_count(object, "ambiguous_voxels", info->ambiguous_voxels);
    cJSON *columns = cJSON_AddObjectToObject(object, "open_columns");
    for (int axis = 0; axis < 3; ++axis) {
        json_add_count(columns, axes[axis], info->open_columns[axis]);
    }
    json_add_count(object, "bytes", made->form.total_bytes);
    json_add_count(object, "scratch_bytes", info->scratch_bytes);
    cJSON_AddNumberToObject(object, "ms", made->ms);
    cJSON_AddNumberToObject(object, "compile_ms", made->compile_ms);
    return object;
}
