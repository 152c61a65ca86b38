/* SPDX-License-Identifier: MIT */
/* One list of extracts serves summary.md and the marked tables of docs/. */
#include "report/summary.h"

#include <math.h>
#include <string.h>

#include "report/text.h"

#define PICKS_MAX   3
#define COLUMNS_MAX 16

/* Rows whose column has that text. Without a text: those with the column's largest number among the rows that the picks
   before leave. */
typedef struct pick {
    const char *column, *text;
} pick;

struct summary_extract {
    const char *id; /* in the markers of docs/ */
    const char *table_id, *title;
    bool in_summary;
    pick picks[PICKS_MAX]; /* a column of NULL: no more */
    const char *columns[COLUMNS_MAX]; /* ends with NULL */
    /* Not NULL: a column whose numbers become columns. Then columns are two: what a row is of, and what it shows. */
    const char *across;
};

static const summary_extract extracts[] = {
    /* README.md */
    {.id = "exactness",
     .table_id = "e1-voxelization",
     .title = "Voxels of the statue on the finest grid",
     .picks = {{"scene", "statue"}, {"grid edge", NULL}},
     .columns = {"method", "time", "missed", "surplus"}},
    /* docs/performance.md */
    {.id = "stages",
     .table_id = "builders",
     .title = "A build, stage by stage",
     .picks = {{"builder", "cl"}, {"depth", NULL}},
     .columns = {"scene", "depth", "triangles", "fragments", "nodes", "voxelize", "transfer", "subdivide", "link",
                 "pack", "filter", "total"}},
    {.id = "frontends",
     .table_id = "voxelize",
     .title = "Front ends",
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "fragments", "frontend", "share", "voxelize", "transfer", "rate", "ratio"}},
    {.id = "filter",
     .table_id = "filter",
     .title = "Payload by weights",
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "nodes", "attributes", "weights", "filter", "list to tree", "ratio"}},
    {.id = "startup",
     .table_id = "startup",
     .title = "Start-up",
     .columns = {"scene", "depth", "method", "cold", "cold compile", "warm", "warm compile"}},
    {.id = "rays",
     .table_id = "rays",
     .title = "Rays, compared with Embree",
     .in_summary = true,
     .columns = {"scene", "triangles", "rays", "svocl", "Embree", "ratio", "wrong", "Embree wrong"}},
    {.id = "ray-calls",
     .table_id = "ray-calls",
     .title = "Rays, Embree call by call",
     .columns = {"scene", "instruction set", "rays", "svocl", "1 ray", "8 rays", "16 rays", "low", "high", "robust",
                 "best", "ratio"}},
    {.id = "ray-structures",
     .table_id = "peer-embree",
     .title = "Building what rays need",
     .columns = {"scene", "triangles", "depth", "svocl tree", "BVH", "svocl", "BVH time", "Embree", "ratio"}},
    {.id = "builders",
     .table_id = "builders",
     .title = "Builders",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "builder", "subdivide", "link", "pack", "filter", "list to tree", "ratio"}},
    {.id = "share",
     .table_id = "share",
     .title = "Share paths",
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "list", "frontend", "share", "voxelize", "transfer", "ratio"}},
    {.id = "leaving-out",
     .table_id = "e6-leaving-out",
     .title = "Time and bytes of each need",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "need", "builder", "build", "peak", "tree", "tree per leaf", "ratio"}},
    {.id = "sizes",
     .table_id = "scene-sizes",
     .title = "From no triangle to a million",
     .columns = {"triangles", "depth", "need", "leaves", "peak", "tree", "build"}},
    {.id = "memory",
     .table_id = "memory",
     .title = "Bytes of occupancy alone",
     .columns = {"scene", "depth", "leaves", "tree", "tree per leaf", "fragment list", "full octree",
                 "list of 36 bytes"}},
    {.id = "thesis-2020",
     .table_id = "thesis-2020",
     .title = "Octree-building thesis (2020)",
     .in_summary = true,
     .columns = {"scene", "depth", "published depth", "voxelize", "structure", "transfer", "total",
                 "published structure", "published total"}},
    {.id = "thesis-2016",
     .table_id = "thesis-2016",
     .title = "Voxel cone tracing thesis (2016), 512³",
     .in_summary = true,
     .picks = {{"voxels per axis", NULL}},
     .columns = {"system", "fragment list", "full octree", "sparse octree", "voxelize", "first build", "second build"}},
    {.id = "gpu",
     .table_id = "gpu",
     .title = "A machine in one table",
     .in_summary = true,
     .columns = {"step", "input", "method", "verdict", "voxelize", "list to tree", "build", "wall", "gaps", "rate",
                 "launches", "uploads", "waits", "allocations", "reads", "reason"}},
    {.id = "gpu-kernels",
     .table_id = "gpu-kernels",
     .title = "Kernels",
     .in_summary = true,
     .columns = {"kernel", "local", "private", "multiple", "registers"}},
    {.id = "import",
     .table_id = "import",
     .title = "Reading meshes",
     .columns = {"scene", "format", "triangles", "file", "svocl", "assimp", "svocl rate", "assimp rate",
                 "svocl/assimp"}},
    /* The chapters of what is made from trees. */
    {.id = "voxel-rays",
     .table_id = "voxel-rays",
     .title = "Rays through voxels",
     .in_summary = true,
     .columns = {"scene", "depth", "voxels", "rays", "svocl", "NanoVDB", "ratio to NanoVDB", "brickmap",
                 "ratio to brickmap", "svocl wrong", "NanoVDB wrong", "brickmap wrong"}},
    {.id = "compact",
     .table_id = "compact",
     .title = "Compact trees",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "leaves", "form", "made", "per leaf", "primary", "primary ratio", "incoherent",
                 "incoherent ratio"}},
    {.id = "compact-shared",
     .table_id = "compact-shared",
     .title = "Shared subtrees and merged leaves",
     .columns = {"scene", "depth", "voxels", "inner nodes", "records", "per voxel", "made", "merged leaves",
                 "merged per voxel", "merged made"}},
    {.id = "compact-mirrored",
     .table_id = "compact-shared",
     .title = "Mirrored subtrees",
     .columns = {"scene", "depth", "voxels", "records", "mirrored records", "nodes", "mirrored nodes", "mirrored share",
                 "per voxel", "mirrored per voxel", "mirrored primary ratio", "mirrored incoherent ratio"}},
    {.id = "compact-packed",
     .table_id = "compact-packed",
     .title = "Packed payload",
     .columns = {"scene", "depth", "leaves", "array", "change", "plain", "zstd -19", "packed", "largest error",
                 "mean error", "packing", "read", "read ratio", "picture ratio"}},
    {.id = "solid",
     .table_id = "solid",
     .title = "Solids",
     .in_summary = true,
     .columns = {"scene", "depth", "surface voxels", "inside voxels", "tests", "tree", "fill", "wrong"}},
    {.id = "convert",
     .table_id = "convert",
     .title = "Given voxels",
     .columns = {"step", "voxels", "time", "rate", "bytes", "ratio"}},
    {.id = "scenes",
     .table_id = "scene",
     .title = "Scenes of placed trees",
     .in_summary = true,
     .columns = {"model", "depth", "instances", "build", "refit", "primary", "merged primary", "Embree primary",
                 "incoherent", "merged incoherent", "Embree incoherent", "same"}},
    {.id = "parts",
     .table_id = "parts",
     .title = "Trees in parts",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "form", "limit", "parts", "runs", "build", "ratio", "peak"}},
    {.id = "parts-large",
     .table_id = "parts-large",
     .title = "Trees larger than memory",
     .in_summary = true,
     .columns = {"scene", "depth", "grid", "limit", "parts", "leaves", "file", "time", "peak"}},
    {.id = "parts-workers",
     .table_id = "parts-workers",
     .title = "Trees in parts, by workers",
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "parts", "workers", "runs", "time", "speedup", "model", "model speedup"}},
    {.id = "moving",
     .table_id = "moving",
     .title = "Updates of scenes that move",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "pairs", "changed", "update", "build", "ratio"}},
    {.id = "moving-stages",
     .table_id = "moving",
     .title = "Updates, stage by stage",
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "changed", "move", "voxelize", "weigh", "merge", "nodes", "payload", "update"}},
    {.id = "moving-rays",
     .table_id = "moving-rays",
     .title = "Rays through scenes that move",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "triangles", "moved", "objects", "whole", "ratio", "primary", "whole primary",
                 "incoherent", "whole incoherent"}},
    {.id = "moving-light",
     .table_id = "moving-light",
     .title = "Light of scenes that move",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "photons", "width", "changed", "traced", "photons again", "photons anew", "update",
                 "nothing", "ratio"}},
    {.id = "paged",
     .table_id = "paged",
     .title = "Paged trees along a camera path",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "room", "buffers", "complete stops", "pictures", "misses", "read", "read ratio",
                 "picture", "update", "in core"}},
    {.id = "light-stages",
     .table_id = "light-stages",
     .title = "Light, stage by stage",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "form", "stage", "photons", "time", "published", "ratio", "rate"}},
    {.id = "light-bytes",
     .table_id = "light-bytes",
     .title = "Bytes of light",
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "nodes", "form", "opacity", "radiance", "all", "dense", "share", "RGBA8 pyramid",
                 "filters", "RGBA8 pyramid, passes"}},
    {.id = "light-counts",
     .table_id = "light-bytes",
     .title = "What photons light",
     .in_summary = true,
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "form", "lit leaves", "missed leaves", "lit nodes"}},
    {.id = "light-frames",
     .table_id = "light-frames",
     .title = "Frames of five cones a pixel",
     .picks = {{"depth", NULL}},
     .columns = {"scene", "depth", "form", "pixels", "points", "first hits", "cones", "frames", "published"}},
    /* docs/accuracy.md */
    {.id = "e1",
     .table_id = "e1-voxelization",
     .title = "Voxels of the statue on the finest grid",
     .in_summary = true,
     .picks = {{"scene", "statue"}, {"grid edge", NULL}},
     .columns = {"grid edge", "method", "coverage", "time", "missed", "surplus", "false negatives", "false positives"}},
    {.id = "e2",
     .table_id = "e2-rays",
     .title = "Rays",
     .picks = {{"triangles", NULL}},
     .columns = {"rays", "method", "time", "missed", "wrong", "error", "error of t, mean", "error of t, largest"}},
    {.id = "e2-edges",
     .table_id = "e2-rays",
     .title = "Rays aimed at edges",
     .in_summary = true,
     .picks = {{"rays", "at edges"}, {"triangles", NULL}},
     .columns = {"method", "time", "missed", "wrong", "error", "error of t, mean", "error of t, largest"}},
    {.id = "e3-color",
     .table_id = "e3-attributes",
     .title = "Colors of voxels, in 1/255",
     .in_summary = true,
     .picks = {{"attribute", "color, 1/255"}, {"depth", NULL}},
     .columns = {"method", "time", "error, mean", "error, 99th percentile", "error, largest", "order, largest"}},
    {.id = "e3-normal",
     .table_id = "e3-attributes",
     .title = "Normals of voxels, in degrees",
     .picks = {{"attribute", "normal, degrees"}, {"depth", NULL}},
     .columns = {"method", "time", "error, mean", "error, 99th percentile", "error, largest", "order, largest"}},
    {.id = "e4",
     .table_id = "e4-detail",
     .title = "Levels of detail",
     .columns = {"scene", "depth", "voxels", "size", "time", "distance of centers", "area by fill, error",
                 "area by faces, error", "volume, error"}},
    {.id = "e5-voxels-aspect",
     .table_id = "e5-conditioning",
     .title = "Voxels and the aspect ratio",
     .picks = {{"problem", "voxelization"}, {"conditioning", "aspect ratio"}},
     .columns = {"method", "error"},
     .across = "value"},
    {.id = "e5-voxels-offset",
     .table_id = "e5-conditioning",
     .title = "Voxels and the offset from the origin",
     .picks = {{"problem", "voxelization"}, {"conditioning", "offset from the origin"}},
     .columns = {"method", "error"},
     .across = "value"},
    {.id = "e5-voxels-scale",
     .table_id = "e5-conditioning",
     .title = "Voxels and the scale ratio",
     .picks = {{"problem", "voxelization"}, {"conditioning", "scale ratio"}},
     .columns = {"method", "error"},
     .across = "value"},
    {.id = "e5-rays-aspect",
     .table_id = "e5-conditioning",
     .title = "Rays and the aspect ratio",
     .picks = {{"problem", "rays"}, {"conditioning", "aspect ratio"}},
     .columns = {"method", "error"},
     .across = "value"},
    {.id = "e5-rays-offset",
     .table_id = "e5-conditioning",
     .title = "Rays and the offset from the origin",
     .picks = {{"problem", "rays"}, {"conditioning", "offset from the origin"}},
     .columns = {"method", "error"},
     .across = "value"},
    {.id = "e5-rays-scale",
     .table_id = "e5-conditioning",
     .title = "Rays and the scale ratio",
     .picks = {{"problem", "rays"}, {"conditioning", "scale ratio"}},
     .columns = {"method", "error"},
     .across = "value"},
    {.id = "e7",
     .table_id = "e7-cones",
     .title = "Cones and rays in the atrium",
     .in_summary = true,
     .picks = {{"scene", "atrium"}},
     .columns = {"method", "depth", "cones or rays", "step", "size", "time", "AO, RMSE", "AO, bias", "time with light",
                 "light, RMSE", "light, bias"}},
    {.id = "e7-alternatives",
     .table_id = "e7-alternatives",
     .title = "Cones, and the rays of the same error",
     .columns = {"scene", "cones", "AO, RMSE", "AO, time", "rays", "svocl, ratio", "Embree, ratio", "light, RMSE",
                 "light, time", "paths", "paths, ratio"}},
    {.id = "e7-directions",
     .table_id = "e7-directions",
     .title = "Cones without any other error",
     .columns = {"scene", "AO, RMSE"},
     .across = "cones"},
    {.id = "e7-equal",
     .table_id = "e7-equal",
     .title = "Kinds of light, by cones and by rays",
     .in_summary = true,
     .columns = {"scene", "light", "16 cones, RMSE", "16 cones, bias", "16 cones, time", "64 paths, RMSE",
                 "64 paths, bias", "64 paths, time", "rays, same error", "ratio"}},
    {.id = "e7-embree",
     .table_id = "e7-embree",
     .title = "Rays of light, beside Embree",
     .columns = {"scene", "rays", "packets", "svocl", "Embree", "svocl, point", "Embree, point", "ratio"}},
    /* docs/probes.md */
    {.id = "e8-primary",
     .table_id = "e8-probes",
     .title = "Rays of a camera through probes",
     .picks = {{"scene", "atrium"}, {"rays", "primary"}},
     .columns = {"method", "resolution", "field", "size", "making", "hit", "unknown", "wrong hits", "wrong misses",
                 "error, 99th percentile", "time", "ratio"}},
    {.id = "e8-cosine",
     .table_id = "e8-probes",
     .title = "Secondary rays through probes",
     .in_summary = true,
     .picks = {{"scene", "atrium"}, {"rays", "cosine"}},
     .columns = {"method", "resolution", "field", "size", "making", "hit", "unknown", "wrong hits", "wrong misses",
                 "error, 99th percentile", "time", "ratio"}},
    {.id = "e8-random",
     .table_id = "e8-probes",
     .title = "Random rays through probes",
     .picks = {{"scene", "atrium"}, {"rays", "random"}},
     .columns = {"method", "resolution", "field", "size", "making", "hit", "unknown", "wrong hits", "wrong misses",
                 "error, 99th percentile", "time", "ratio"}},
    {.id = "e8-choices",
     .table_id = "e8-choices",
     .title = "The field and the eight nearest probes",
     .in_summary = true,
     .columns = {"scene", "rays", "probes", "resolution", "wrong, field", "wrong, eight", "unknown, field",
                 "unknown, eight", "share", "ratio, field", "ratio, eight"}},
    {.id = "e8-light",
     .table_id = "e8-light",
     .title = "Light by probes",
     .columns = {"scene", "method", "rays or cones", "size", "making", "relighting", "time", "RMSE", "bias"}},
};

const summary_extract *summary_find(const char *id)
{
    for (size_t i = 0; i < sizeof extracts / sizeof extracts[0]; ++i) {
        if (strcmp(extracts[i].id, id) == 0) {
            return &extracts[i];
        }
    }
    return NULL;
}

/* ---- rows ---- */

static bool has_text(const result_cell *cell, const char *text)
{
    return cell != NULL && cell->kind == RESULT_TEXT && strcmp(cell->text, text) == 0;
}

/* Whether the first pick_count picks leave the row. */
static bool fits(const result_table *table, size_t row, const pick *picks, size_t pick_count)
{
    for (size_t i = 0; i < pick_count && picks[i].column != NULL; ++i) {
        const size_t column = result_find_column(table, picks[i].column);
        const result_cell *cell = result_cell_at(table, row, column);
        if (picks[i].text != NULL && !has_text(cell, picks[i].text)) {
            return false;
        }
        if (picks[i].text != NULL) {
            continue;
        }
        double most = -HUGE_VAL;
        for (size_t other = 0; other < result_row_count(table); ++other) {
            const result_cell *beside = result_cell_at(table, other, column);
            if (beside != NULL && beside->kind == RESULT_NUMBER && fits(table, other, picks, i)) {
                most = fmax(most, beside->number);
            }
        }
        if (cell == NULL || cell->kind != RESULT_NUMBER || cell->number < most) {
            return false;
        }
    }
    return true;
}

/* Whether the table has what the extract names. */
static bool is_there(const summary_extract *wanted, const result_table *table)
{
    if (table == NULL) {
        return false;
    }
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        if (result_find_column(table, wanted->columns[i]) == table->column_count) {
            return false;
        }
    }
    if (wanted->across != NULL && result_find_column(table, wanted->across) == table->column_count) {
        return false;
    }
    for (size_t row = 0; row < result_row_count(table); ++row) {
        if (fits(table, row, wanted->picks, PICKS_MAX)) {
            return true;
        }
    }
    return false;
}

/* ---- Markdown ---- */

/* The unit that a column is shown in, and what its numbers are divided by. */
static double unit_of(const result_table *table, size_t column, const char **unit)
{
    return text_choose_unit(table, column, unit);
}

static void write_text(const char *cell, FILE *text)
{
    for (const char *c = cell; *c != '\0'; ++c) {
        fputs(*c == '|' ? "\\" : "", text);
        fputc(*c, text);
    }
}

static void write_heads(const summary_extract *wanted, const result_table *table, FILE *text)
{
    fputs("|", text);
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        const char *unit = "";
        unit_of(table, result_find_column(table, wanted->columns[i]), &unit);
        fprintf(text, " %s%s%s |", wanted->columns[i], unit[0] != '\0' ? ", " : "", unit);
    }
    fputs("\n|", text);
    for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
        const result_cell *cell = result_cell_at(table, 0, result_find_column(table, wanted->columns[i]));
        fputs(cell->kind == RESULT_TEXT ? " --- |" : " ---: |", text);
    }
    fputs("\n", text);
}

static void write_cell(const result_table *table, size_t row, size_t column, FILE *text)
{
    const char *unit = "";
    const result_cell *cell = result_cell_at(table, row, column);
    fputc(' ', text);
    if (cell->kind == RESULT_NUMBER) {
        fputs(text_format_number(cell->number / unit_of(table, column, &unit)).text, text);
    } else if (cell->kind == RESULT_TEXT) {
        write_text(cell->text, text);
    }
    fputs(" |", text);
}

static void write_rows(const summary_extract *wanted, const result_table *table, FILE *text)
{
    write_heads(wanted, table, text);
    for (size_t row = 0; row < result_row_count(table); ++row) {
        if (!fits(table, row, wanted->picks, PICKS_MAX)) {
            continue;
        }
        fputs("|", text);
        for (size_t i = 0; i < COLUMNS_MAX && wanted->columns[i] != NULL; ++i) {
            write_cell(table, row, result_find_column(table, wanted->columns[i]), text);
        }
        fputs("\n", text);
    }
}

/* ---- a column's numbers as columns ---- */

typedef struct crossing {
    const summary_extract *wanted;
    const result_table *table;
    size_t label, shown, across; /* columns */
} crossing;

/* Whether the row is one of the extract's and has that label. NULL: any. */
static bool is_labeled(const crossing *of, size_t row, const char *label)
{
    return fits(of->table, row, of->wanted->picks, PICKS_MAX) &&
           (label == NULL || has_text(result_cell_at(of->table, row, of->label), label));
}

/* Whether no row before this one has the same label. */
static bool begins_label(const crossing *of, size_t row)
{
    const result_cell *label = result_cell_at(of->table, row, of->label);
    if (label->kind != RESULT_TEXT || !is_labeled(of, row, label->text)) {
        return false;
    }
    for (size_t before = 0; before < row; ++before) {
        if (is_labeled(of, before, label->text)) {
            return false;
        }
    }
    return true;
}

/* The rows of one label, from the one that begins it: what is shown of each, or the heads above. */
static void write_label(const crossing *of, size_t begin, size_t column, FILE *text)
{
    const char *label = result_cell_at(of->table, begin, of->label)->text;
    for (size_t row = begin; row < result_row_count(of->table); ++row) {
        if (is_labeled(of, row, label)) {
            write_cell(of->table, row, column, text);
        }
    }
    fputs("\n", text);
}

/* Every label has a row for each of the values, in the same order. */
static void write_crossing(const crossing *of, FILE *text)
{
    bool has_heads = false;
    for (size_t row = 0; row < result_row_count(of->table); ++row) {
        if (!begins_label(of, row)) {
            continue;
        }
        const char *label = result_cell_at(of->table, row, of->label)->text;
        if (!has_heads) {
            fprintf(text, "| %s |", of->wanted->columns[0]);
            write_label(of, row, of->across, text);
            fputs("| --- |", text);
            for (size_t other = row; other < result_row_count(of->table); ++other) {
                fputs(is_labeled(of, other, label) ? " ---: |" : "", text);
            }
            fputs("\n", text);
            has_heads = true;
        }
        fputs("| ", text);
        write_text(label, text);
        fputs(" |", text);
        write_label(of, row, of->shown, text);
    }
}

static size_t next_column(const result_table *table, size_t column)
{
    return column + (result_has_quartiles(table, column) ? 3 : 1);
}

/* With the two columns after it where they are its interval: "31.2 [30.9, 33.0]". */
static void write_cell_with_interval(const result_table *table, size_t row, size_t column, FILE *text)
{
    const char *unit = "";
    const double divisor = unit_of(table, column, &unit);
    const result_cell *cell = result_cell_at(table, row, column);
    if (!result_has_quartiles(table, column) || cell[0].kind != RESULT_NUMBER || cell[1].kind != RESULT_NUMBER ||
        cell[2].kind != RESULT_NUMBER) {
        write_cell(table, row, column, text);
        return;
    }
    fprintf(text, " %s [%s, %s] |", text_format_number(cell[0].number / divisor).text,
            text_format_number(cell[1].number / divisor).text, text_format_number(cell[2].number / divisor).text);
}

void summary_write_table(const result_table *table, FILE *text)
{
    fputs("|", text);
    for (size_t i = 0; i < table->column_count; i = next_column(table, i)) {
        const char *unit = "";
        unit_of(table, i, &unit);
        fprintf(text, " %s%s%s |", table->columns[i].name, unit[0] != '\0' ? ", " : "", unit);
    }
    fputs("\n|", text);
    for (size_t i = 0; i < table->column_count; i = next_column(table, i)) {
        const result_cell *cell = result_cell_at(table, 0, i);
        fputs(cell != NULL && cell->kind == RESULT_NUMBER ? " ---: |" : " --- |", text);
    }
    fputs("\n", text);
    for (size_t row = 0; row < result_row_count(table); ++row) {
        fputs("|", text);
        for (size_t i = 0; i < table->column_count; i = next_column(table, i)) {
            write_cell_with_interval(table, row, i, text);
        }
        fputs("\n", text);
    }
}

bool summary_write_extract(const summary_extract *wanted, const result_set *results, FILE *text)
{
    const result_table *table = result_find(results, wanted->table_id);
    if (!is_there(wanted, table)) {
        return false;
    }
    if (wanted->across == NULL) {
        write_rows(wanted, table, text);
    } else {
        const crossing of = {.wanted = wanted,
                             .table = table,
                             .label = result_find_column(table, wanted->columns[0]),
                             .shown = result_find_column(table, wanted->columns[1]),
                             .across = result_find_column(table, wanted->across)};
        write_crossing(&of, text);
    }
    return true;
}

/* A row of one fact, or of two with a text between them. */
static void write_fact(const char *name, const char *fact, const char *between, const char *more, FILE *text)
{
    if (fact[0] == '\0') {
        return;
    }
    fprintf(text, "| %s | ", name);
    write_text(fact, text);
    write_text(between, text);
    write_text(more, text);
    fputs(" |\n", text);
}

void summary_write_machine(const result_machine *machine, FILE *text)
{
    char threads[16];
    snprintf(threads, sizeof threads, "%u", machine->cpu_threads);
    fputs("| measured on | |\n| --- | --- |\n", text);
    write_fact("OpenCL", machine->device, ", driver ", machine->driver, text);
    write_fact("OpenGL", machine->renderer, "", "", text);
    if (machine->processor[0] != '\0') {
        write_fact("processor", machine->processor, machine->clock[0] != '\0' ? ", " : "", machine->clock, text);
        write_fact("memory", machine->memory, "", "", text);
    }
    write_fact("instruction set", machine->instruction_set, "", "", text);
    write_fact("threads", threads, "", "", text);
    write_fact("svocl", machine->svocl, machine->date[0] != '\0' ? ", " : "", machine->date, text);
}

void summary_write(const result_set *results, FILE *text)
{
    summary_write_machine(&results->machine, text);
    for (size_t i = 0; i < sizeof extracts / sizeof extracts[0]; ++i) {
        if (extracts[i].in_summary && is_there(&extracts[i], result_find(results, extracts[i].table_id))) {
            fprintf(text, "\n**%s**\n\n", extracts[i].title);
            summary_write_extract(&extracts[i], results, text);
        }
    }
}
