/* SPDX-License-Identifier: MIT */
/* Reads the golden table. A line that cannot be parsed is an error, so that no count is skipped silently. */
#include "golden.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Finds or adds the scene of that name; NULL if the table is full. */
static golden_scene *find_scene(golden_table *table, const char *name)
{
    golden_scene *scene;

    for (size_t i = 0; i < table->scene_count; i++)
        if (strcmp(table->scenes[i].name, name) == 0)
            return &table->scenes[i];
    if (table->scene_count == GOLDEN_SCENES_MAX)
        return NULL;
    scene = &table->scenes[table->scene_count++];
    snprintf(scene->name, sizeof(scene->name), "%s", name);
    return scene;
}

/* "T scene triangle x0 y0 z0 x1 y1 z1 x2 y2 z2" */
static bool read_triangle(golden_table *table, const char *line)
{
    char name[GOLDEN_NAME_BYTES];
    size_t index;
    int32_t v[9];
    int32_t *vertices;
    golden_scene *scene;

    if (sscanf(line,
               "T %31s %zu %" SCNd32 " %" SCNd32 " %" SCNd32 " %" SCNd32 " %" SCNd32 " %" SCNd32 " %" SCNd32 " %" SCNd32
               " %" SCNd32,
               name, &index, &v[0], &v[1], &v[2], &v[3], &v[4], &v[5], &v[6], &v[7], &v[8]) != 11)
        return false;
    scene = find_scene(table, name);
    if (!scene || index != scene->triangle_count)
        return false;
    vertices = realloc(scene->vertices, (index + 1) * sizeof(v));
    if (!vertices)
        return false;
    memcpy(vertices + 9 * index, v, sizeof(v));
    scene->vertices = vertices;
    scene->triangle_count++;
    return true;
}

/* "C scene coverage depth voxels pairs" */
static bool read_count(golden_table *table, const char *line)
{
    char name[GOLDEN_NAME_BYTES], coverage[16];
    golden_count count;
    golden_scene *scene;

    if (sscanf(line, "C %31s %15s %u %" SCNu64 " %" SCNu64, name, coverage, &count.depth, &count.voxels,
               &count.pairs) != 5)
        return false;
    count.is_closed = strcmp(coverage, "closed") == 0;
    if (!count.is_closed && strcmp(coverage, "half-open") != 0)
        return false;
    scene = find_scene(table, name);
    if (!scene || scene->count_count == GOLDEN_COUNTS_MAX)
        return false;
    scene->counts[scene->count_count++] = count;
    return true;
}

static bool read_line(golden_table *table, const char *line)
{
    if (line[0] == 'T')
        return read_triangle(table, line);
    if (line[0] == 'C')
        return read_count(table, line);
    return line[0] == '#' || line[0] == '\n';
}

golden_table *golden_load(const char *path)
{
    FILE *file = fopen(path, "r");
    golden_table *table = calloc(1, sizeof(*table));
    char line[512];
    int line_number = 0;
    bool is_good = file && table;

    while (is_good && fgets(line, sizeof(line), file)) {
        line_number++;
        is_good = read_line(table, line);
    }
    if (!is_good || table->scene_count == 0) {
        fprintf(stderr, "%s: line %d: cannot be read as golden counts\n", path, line_number);
        golden_free(table);
        table = NULL;
    }
    if (file)
        fclose(file);
    return table;
}

void golden_free(golden_table *table)
{
    if (!table)
        return;
    for (size_t i = 0; i < table->scene_count; i++)
        free(table->scenes[i].vertices);
    free(table);
}
