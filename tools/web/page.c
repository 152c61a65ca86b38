/* SPDX-License-Identifier: MIT */
/*
 * Fills the template of the page, page.html. The scripts find two blocks in it: the data (pack.h) in base64, and JSON
 * that says what is in them:
 *
 *   {"version": "0.1.0", "name": "statue",
 *    "depth": 8, "level": 8,            of the tree; the deepest level that the page has
 *    "voxels": 117010, "leaves": 117010, "nodes": 154867,    of the tree; of the page
 *    "masks": 37857, "directory": 2367, "bytes": 976543,
 *    "colors": {"count": 154867, "first": 0, "stride": 1}, "normals": null,
 *    "origin": [0, 0, 0], "edge": 0.0039}                    of the grid; of a cell, in world units
 */
#include "web/page.h"

#include <stdlib.h>

#include "support/json.h"
#include "support/page_template.h"
#include "svocl/nodes.h"

extern const char web_template[], web_style[], web_shader_nodes[], web_shader_walk[], web_shader_light[],
    web_shader_picture[], web_shader_probe[], web_script_data[], web_script_camera[], web_script_drawing[],
    web_script_page[];

#define DATA_OPEN    "<script id=\"data\" type=\"application/octet-stream\">"
#define TREE_OPEN    "<script id=\"tree\" type=\"application/json\">"
#define SHADER(name) "<script id=\"" name "\" type=\"x-shader/x-glsl\">"
#define SCRIPT(name) "<script src=\"" name ".js\"></script>"

/* ---- what is in the data ---- */

static void add_payload(cJSON *object, const char *name, const web_payload *payload)
{
    if (payload->count == 0) {
        cJSON_AddNullToObject(object, name);
        return;
    }
    cJSON *added = cJSON_AddObjectToObject(object, name);
    json_add_count(added, "count", payload->count);
    json_add_count(added, "first", payload->first);
    json_add_count(added, "stride", payload->stride);
}

/* JSON text by malloc; NULL when out of memory. */
static char *describe(const web_page *page)
{
    const svo_compact_info *info = &page->tree->info;
    const web_cut *cut = &page->cut;
    const svo_grid grid = {.depth = info->depth,
                           .snap_bits = info->snap_bits,
                           .origin = {info->origin[0], info->origin[1], info->origin[2]},
                           .scale = info->scale};
    cJSON *object = json_document();
    json_add_text(object, "name", page->name);
    json_add_count(object, "depth", info->depth);
    json_add_count(object, "level", cut->level);
    json_add_count(object, "voxels", info->voxel_count);
    json_add_count(object, "leaves", cut->leaf_count);
    json_add_count(object, "nodes", cut->node_count);
    json_add_count(object, "masks", cut->mask_count);
    json_add_count(object, "directory", cut->directory_count);
    json_add_count(object, "bytes", cut->byte_count);
    add_payload(object, "colors", &cut->colors);
    add_payload(object, "normals", &cut->normals);
    json_add_vector(object, "origin", info->origin);
    cJSON_AddNumberToObject(object, "edge", svo_grid_cell_edge(&grid, cut->level));
    char *text = cJSON_PrintUnformatted(object);
    cJSON_Delete(object);
    return text;
}

/* Base64 text by malloc; NULL when out of memory. */
static char *encode(const unsigned char *bytes, size_t byte_count)
{
    char *text = NULL;
    size_t text_bytes = 0;
    FILE *stream = open_memstream(&text, &text_bytes);
    if (stream == NULL) {
        return NULL;
    }
    page_template_base64(bytes, byte_count, stream);
    if (fclose(stream) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

/* ---- the page ---- */

static int fail_without_memory(program *state)
{
    return program_fail(state, PROGRAM_FAILED, "out of memory for the page");
}

static int fill(program *state, const char *tree, const char *data, FILE *out)
{
    const page_part parts[] = {
        {"<link rel=\"stylesheet\" href=\"page.css\">", "<style>", web_style, "</style>", false},
        {TREE_OPEN "null</script>", TREE_OPEN, tree, "</script>", true},
        {DATA_OPEN "</script>", DATA_OPEN, data, "</script>", false},
        {SHADER("nodes") "</script>", SHADER("nodes"), web_shader_nodes, "</script>", false},
        {SHADER("walk") "</script>", SHADER("walk"), web_shader_walk, "</script>", false},
        {SHADER("light") "</script>", SHADER("light"), web_shader_light, "</script>", false},
        {SHADER("picture-shader") "</script>", SHADER("picture-shader"), web_shader_picture, "</script>", false},
        {SHADER("probe") "</script>", SHADER("probe"), web_shader_probe, "</script>", false},
        {SCRIPT("data"), "<script>", web_script_data, "</script>", false},
        {SCRIPT("camera"), "<script>", web_script_camera, "</script>", false},
        {SCRIPT("drawing"), "<script>", web_script_drawing, "</script>", false},
        {SCRIPT("page"), "<script>", web_script_page, "</script>", false},
    };
    return page_template_write(state, web_template, parts, sizeof parts / sizeof parts[0], out);
}

int web_page_measure(program *state, const web_page *page, size_t *shell_bytes)
{
    char *text = NULL;
    char *tree = describe(page);
    FILE *stream = tree != NULL ? open_memstream(&text, shell_bytes) : NULL;
    int exit_code = stream != NULL ? fill(state, tree, "", stream) : fail_without_memory(state);
    if (stream != NULL && fclose(stream) != 0 && exit_code == PROGRAM_DONE) {
        exit_code = fail_without_memory(state);
    }
    free(text);
    free(tree);
    return exit_code;
}

size_t web_page_room(uint64_t page_bytes, size_t shell_bytes)
{
    return page_bytes > shell_bytes ? (size_t)(page_bytes - shell_bytes) / 4 * 3 : 0;
}

int web_page_write(program *state, const web_page *page, FILE *out)
{
    char *tree = describe(page);
    char *data = encode(page->packed, page->packed_count);
    const int exit_code = tree != NULL && data != NULL ? fill(state, tree, data, out) : fail_without_memory(state);
    free(data);
    free(tree);
    return exit_code;
}
