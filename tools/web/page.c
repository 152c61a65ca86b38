/* SPDX-License-Identifier: MIT */
/*
 * Fills the template of the page, page.html. The scripts find JSON that says what is in the data:
 *
 *   {"version": "0.1.0", "name": "statue",
 *    "depth": 8, "level": 8,            of the tree; the deepest level that the page has
 *    "voxels": 117010, "leaves": 117010,                     of the tree; of the page
 *    "nodes": [1, 9, ..., 154867],      of the page, down to each of its levels
 *    "bytes": 976543, "packed": 412345, of the data, unpacked and packed
 *    "colors": {"count": 154867, "first": 0, "stride": 1}, "normals": null, "light": null,
 *    "low": [0, 4, 12], "high": [256, 248, 240],             the occupied part, in cells of the level
 *    "origin": [0, 0, 0], "edge": 0.0039,                    of the grid; of a cell, in world units
 *    "view": 0,                         the first
 *    "camera": {"up": [0, 1, 0], "fov": 0.56, "eye": [2, 2, 2], "at": [0, 0, 0]},   0, without eye and at: as framed
 *    "lightLevel": 6, "sky": [1, 1, 1], "exposure": 1, "sources": [...],            with light
 *    "skyMap": {"width": 512, "height": 256, "texels": "gICAgQ..."}}     where the sky is a map, as web_sky has it
 *
 * Behind the scripts the data (pack.h) follow in base64, in blocks, coarse levels first. After each of them one line of
 * script hands it over as soon as the parser is there. A block is a megabyte long, or ends with a level.
 */
#include "web/page.h"

#include <stdlib.h>

#include "support/json.h"
#include "support/page_template.h"

extern const char web_template[], web_style[], web_shader_nodes[], web_shader_walk[], web_shader_light[],
    web_shader_picture[], web_shader_probe[], web_script_data[], web_script_camera[], web_script_drawing[],
    web_script_fly[], web_script_page[];

#define DATA_PLACE   "<script id=\"data\"></script>"
#define BLOCK_OPEN   "<script type=\"application/octet-stream\">"
#define BLOCK_CLOSE  "</script><script>take()</script>\n"
#define BLOCK_BYTES  ((size_t)3 << 18) /* a megabyte of base64 */
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

/* Voxels of the tree as cells of the page's level. */
static void add_bounds(cJSON *object, const char *name, const web_page *page, const uint32_t voxels[3])
{
    double cells[3];
    for (int axis = 0; axis < 3; ++axis) {
        cells[axis] = (double)voxels[axis] / (double)(1u << (page->tree->info.depth - page->cut.level));
    }
    json_add_vector(object, name, cells);
}

static void add_numbers(cJSON *object, const char *name, const float numbers[3])
{
    cJSON_AddItemToObject(object, name, cJSON_CreateFloatArray(numbers, 3));
}

static void add_camera(cJSON *object, const web_start *start)
{
    cJSON *camera = cJSON_AddObjectToObject(object, "camera");
    add_numbers(camera, "up", start->camera.up);
    cJSON_AddNumberToObject(camera, "fov", start->has_fov ? (double)start->camera.vertical_fov : 0.0);
    if (start->has_place) {
        add_numbers(camera, "eye", start->camera.eye);
        add_numbers(camera, "at", start->camera.target);
    }
}

/* Nothing without a map. False when out of memory. */
static bool add_sky_map(cJSON *object, const web_sky *sky)
{
    char *text = NULL;
    size_t text_bytes = 0;
    FILE *stream = sky->width > 0 ? open_memstream(&text, &text_bytes) : NULL;
    if (stream == NULL) {
        return sky->width == 0;
    }
    page_template_base64(sky->texels[0], (size_t)4 * sky->width * sky->height, stream);
    const bool is_whole = fclose(stream) == 0;
    cJSON *added = cJSON_AddObjectToObject(object, "skyMap");
    json_add_count(added, "width", sky->width);
    json_add_count(added, "height", sky->height);
    json_add_text(added, "texels", is_whole ? text : "");
    free(text);
    return is_whole;
}

static void add_shine(cJSON *object, const web_page *page)
{
    const web_shine *shine = &page->shine;
    cJSON *sources = cJSON_AddArrayToObject(object, "sources");
    json_add_count(object, "lightLevel", page->tree->light->level);
    add_numbers(object, "sky", shine->sky);
    cJSON_AddNumberToObject(object, "exposure", shine->exposure);
    for (size_t i = 0; i < shine->source_count; ++i) {
        const svo_light_source *source = &shine->sources[i];
        cJSON *added = cJSON_CreateObject();
        json_add_count(added, "kind", source->kind);
        add_numbers(added, "position", source->position);
        add_numbers(added, "direction", source->direction);
        add_numbers(added, "value", source->value);
        cJSON_AddNumberToObject(added, "inner", (double)source->inner_angle);
        cJSON_AddNumberToObject(added, "outer", (double)source->outer_angle);
        cJSON_AddItemToArray(sources, added);
    }
}

static void add_counts(cJSON *object, const web_page *page)
{
    const web_cut *cut = &page->cut;
    cJSON *nodes = cJSON_AddArrayToObject(object, "nodes");
    for (uint32_t level = 0; level <= cut->level; ++level) {
        const uint64_t count = web_cut_at(page->tree, level).node_count;
        cJSON_AddItemToArray(nodes, cJSON_CreateNumber((double)count));
    }
    json_add_count(object, "bytes", cut->byte_count);
    json_add_count(object, "packed", page->packed.count);
    add_payload(object, "colors", &cut->colors);
    add_payload(object, "normals", &cut->normals);
    add_payload(object, "light", &cut->light);
}

/* JSON text by malloc; NULL when out of memory. */
static char *describe(const web_page *page)
{
    const svo_compact_info *info = &page->tree->info;
    cJSON *object = json_document();
    json_add_text(object, "name", page->name);
    json_add_count(object, "depth", info->depth);
    json_add_count(object, "level", page->cut.level);
    json_add_count(object, "voxels", info->voxel_count);
    json_add_count(object, "leaves", page->cut.leaf_count);
    add_counts(object, page);
    add_bounds(object, "low", page, page->low);
    add_bounds(object, "high", page, page->high);
    json_add_vector(object, "origin", info->origin);
    cJSON_AddNumberToObject(object, "edge", web_tree_edge(page->tree, page->cut.level));
    json_add_count(object, "view", (uint64_t)page->start.view);
    add_camera(object, &page->start);
    bool is_whole = true;
    if (page->cut.light.count > 0) {
        add_shine(object, page);
        is_whole = add_sky_map(object, &page->shine.sky_map);
    }
    char *text = is_whole ? cJSON_PrintUnformatted(object) : NULL;
    cJSON_Delete(object);
    return text;
}

/* ---- the data ---- */

/* How many bytes the block at a byte of the data has: it ends with a level, or when it is full. */
static size_t block_bytes(const web_packed *packed, size_t at)
{
    unsigned next = 0;
    while (packed->ends[next] <= at) {
        ++next;
    }
    const size_t left = packed->ends[next] - at;
    return left < BLOCK_BYTES ? left : BLOCK_BYTES;
}

static size_t blocks_measure(const web_packed *packed)
{
    size_t byte_count = 0;
    for (size_t at = 0, here = 0; at < packed->count; at += here) {
        here = block_bytes(packed, at);
        byte_count += sizeof BLOCK_OPEN - 1 + (here + 2) / 3 * 4 + sizeof BLOCK_CLOSE - 1;
    }
    return byte_count;
}

/* The blocks by malloc; NULL when out of memory. */
static char *encode(const web_packed *packed)
{
    char *text = NULL;
    size_t text_bytes = 0;
    FILE *stream = open_memstream(&text, &text_bytes);
    if (stream == NULL) {
        return NULL;
    }
    for (size_t at = 0, here = 0; at < packed->count; at += here) {
        here = block_bytes(packed, at);
        fputs(BLOCK_OPEN, stream);
        page_template_base64(packed->bytes + at, here, stream);
        fputs(BLOCK_CLOSE, stream);
    }
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
        {SHADER("nodes") "</script>", SHADER("nodes"), web_shader_nodes, "</script>", false},
        {SHADER("walk") "</script>", SHADER("walk"), web_shader_walk, "</script>", false},
        {SHADER("light") "</script>", SHADER("light"), web_shader_light, "</script>", false},
        {SHADER("picture-shader") "</script>", SHADER("picture-shader"), web_shader_picture, "</script>", false},
        {SHADER("probe") "</script>", SHADER("probe"), web_shader_probe, "</script>", false},
        {SCRIPT("data"), "<script>", web_script_data, "</script>", false},
        {SCRIPT("camera"), "<script>", web_script_camera, "</script>", false},
        {SCRIPT("drawing"), "<script>", web_script_drawing, "</script>", false},
        {SCRIPT("fly"), "<script>", web_script_fly, "</script>", false},
        {SCRIPT("page"), "<script>", web_script_page, "</script>", false},
        {DATA_PLACE, "", data, "", false},
    };
    return page_template_write(state, web_template, parts, sizeof parts / sizeof parts[0], out);
}

int web_page_measure(program *state, const web_page *page, size_t *byte_count)
{
    char *text = NULL;
    char *tree = describe(page);
    FILE *stream = tree != NULL ? open_memstream(&text, byte_count) : NULL;
    int exit_code = stream != NULL ? fill(state, tree, "", stream) : fail_without_memory(state);
    if (stream != NULL && fclose(stream) != 0 && exit_code == PROGRAM_DONE) {
        exit_code = fail_without_memory(state);
    }
    *byte_count += blocks_measure(&page->packed);
    free(text);
    free(tree);
    return exit_code;
}

int web_page_write(program *state, const web_page *page, FILE *out)
{
    char *tree = describe(page);
    char *data = encode(&page->packed);
    const int exit_code = tree != NULL && data != NULL ? fill(state, tree, data, out) : fail_without_memory(state);
    free(data);
    free(tree);
    return exit_code;
}
