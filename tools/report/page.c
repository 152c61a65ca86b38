/* SPDX-License-Identifier: MIT */
/* The order of the page, its words, and everything that is not a table or a chart. */
#include "report/page.h"

#include <ctype.h>
#include <string.h>

#include "report/charts.h"
#include "report/table_html.h"
#include "report/text.h"

extern const char page_style[];

typedef struct section {
    const char *group; /* a heading above it; NULL: that of the one before */
    const char *table_id;
    const char *heading;
    const char *lead;
} section;

static const section sections[] = {
    {"Error beside run time", "e1-voxelization", "E1: voxelization",
     "Which voxels does a triangle touch? Rasterizers and float32 tests answer approximately; svocl decides in "
     "integers, "
     "and every front end gives the same set."},
    {NULL, "e2-rays", "E2: rays",
     "Rays aimed at corners, at edges and along surfaces separate the tests that have gaps from those that have none. "
     "Random rays hardly do."},
    {NULL, "e3-attributes", "E3: attributes",
     "A voxel's color and normal stand for all surface inside it. Running averages in eight bits drift and depend on "
     "the "
     "order in which samples come; integers do not."},
    {NULL, "e4-detail", "E4: level of detail",
     "What is lost by stopping at a depth: the distance of voxels from the surface, its area, and the volume it "
     "encloses."},
    {NULL, "e5-conditioning", "E5: stiffness",
     "Thin triangles, coordinates far from the origin, and very different sizes are what float32 ways break on."},
    {"OpenCL and OpenGL side by side", "voxelize", "Front ends",
     "The same fragments by OpenCL alone and by OpenGL's rasterizer."},
    {NULL, "builders", "Builders",
     "The same octree, bit for bit, from the root down (cl), from the leaves up (sorted), and by OpenGL's compute "
     "shaders "
     "(gl-compute)."},
    {NULL, "share", "Sharing", "What it costs to bring OpenGL's list to OpenCL."},
    {NULL, "filter", "Payload", "Colors, normals, materials and fill by the weights that were asked for."},
    {NULL, "startup", "Start-up", "From the start of the process to its end, with the drivers' caches empty and full."},
    {"Only what the scene needs", "e6-leaving-out", "E6: leaving out",
     "Every buffer, pass and kernel that a request does not use is left out; this is what each costs."},
    {NULL, "scene-sizes", "Scene sizes", "From no triangle at all to a million."},
    {NULL, "memory", "Memory", "Bytes of an octree of occupancy alone, beside ways that keep everything."},
    {"Beside older systems", "older-a", "The first older system",
     "Its scenes' stand-ins and sizes, with its published figures."},
    {NULL, "older-b", "The second older system", "Its grids and measures, with its published figures."},
    {"Beside other libraries", "rays", "Rays beside Embree", "The same rays against the same triangles."},
    {NULL, "peer-embree", "Structures for rays", "The octree and its boxes beside Embree's hierarchy."},
    {NULL, "peer-openvdb", "Volumes", "The octree beside OpenVDB's volume of the same resolution."},
};

#define SECTION_COUNT (sizeof sections / sizeof sections[0])

static bool has_section(const char *table_id)
{
    for (size_t i = 0; i < SECTION_COUNT; ++i) {
        if (strcmp(sections[i].table_id, table_id) == 0) {
            return true;
        }
    }
    return false;
}

/* ---- head ---- */

static void write_fact(const char *name, const char *text, FILE *page)
{
    if (text[0] != '\0') {
        fprintf(page, "<div><dt>%s</dt><dd>", name);
        text_escape(text, page);
        fputs("</dd></div>\n", page);
    }
}

static void write_machine(const result_machine *machine, FILE *page)
{
    char threads[32];
    snprintf(threads, sizeof threads, "%u", machine->cpu_threads);
    fputs("<dl class=\"facts\">\n", page);
    write_fact("OpenCL device", machine->device, page);
    write_fact("Driver", machine->driver, page);
    write_fact("Platform", machine->platform, page);
    write_fact("OpenGL renderer", machine->renderer, page);
    write_fact("CPU threads", threads, page);
    write_fact("svocl", machine->svocl, page);
    write_fact("Date", machine->date, page);
    fputs("</dl>\n", page);
}

static void write_contents(const page_content *content, FILE *page)
{
    fputs("<nav aria-label=\"Contents\"><h2>Contents</h2>\n", page);
    for (size_t i = 0; i < SECTION_COUNT; ++i) {
        if (sections[i].group != NULL) {
            fprintf(page, "%s<div><h3>%s</h3><ul>\n", i > 0 ? "</ul></div>\n" : "", sections[i].group);
        }
        const bool there = result_find(content->results, sections[i].table_id) != NULL;
        fprintf(page, "<li><a href=\"#%s\"%s>%s</a></li>\n", sections[i].table_id, there ? "" : " class=\"absent\"",
                sections[i].heading);
    }
    fputs("</ul></div>\n<div><h3>Further</h3><ul><li><a href=\"#pictures\">Pictures</a></li>"
          "<li><a href=\"#reading\">How to read this</a></li></ul></div></nav>\n",
          page);
}

static void write_start(const page_content *content, FILE *page)
{
    fputs("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
          "<title>svocl: error beside run time</title>\n<style>\n",
          page);
    fputs(page_style, page);
    fputs("</style>\n</head>\n<body>\n<header>\n<h1>svocl <span>error beside run time</span></h1>\n"
          "<p class=\"lead\">Exact sparse voxel octrees of triangle meshes, measured beside the usual ways: how long "
          "each "
          "takes, and how wrong each is.</p>\n",
          page);
    write_machine(&content->results->machine, page);
    fputs("<p class=\"note\">", page);
    text_escape(content->source, page);
    fputs("</p>\n</header>\n", page);
    write_contents(content, page);
    fputs("<main>\n", page);
}

/* ---- body ---- */

static void write_picture(const picture *one, FILE *page)
{
    fprintf(page, "<figure class=\"picture %s\"><img alt=\"", one->name);
    text_escape(one->caption, page);
    fprintf(page, "\" width=\"%u\" height=\"%u\" src=\"data:image/png;base64,", one->width, one->height);
    text_base64(one->png, one->png_bytes, page);
    fputs("\"><figcaption>", page);
    text_escape(one->caption, page);
    fputs("</figcaption></figure>\n", page);
}

static void write_pictures(const pictures *drawn, FILE *page)
{
    fputs("<section id=\"pictures\" class=\"gallery\">\n<h2>Pictures</h2>\n<div class=\"pictures\">\n", page);
    for (size_t i = 0; i < drawn->count; ++i) {
        write_picture(&drawn->list[i], page);
    }
    fputs("</div>\n</section>\n", page);
}

/* As a sentence. */
static void write_note(const char *note, FILE *page)
{
    const size_t length = strlen(note);
    if (length > 0) {
        fprintf(page, "<p class=\"note\">%c", toupper((unsigned char)note[0]));
        text_escape(note + 1, page);
        fputs(note[length - 1] == '.' ? "</p>\n" : ".</p>\n", page);
    }
}

static int write_table(program *state, const result_table *table, FILE *page)
{
    int exit_code = PROGRAM_DONE;
    const chart_figure *figure = NULL;
    for (size_t i = 0; (figure = charts_of(table->id, i)) != NULL && exit_code == PROGRAM_DONE; ++i) {
        exit_code = charts_draw(state, figure, table, page);
    }
    if (result_row_count(table) > 0) {
        table_html_write(table, page);
    } else {
        fputs("<p class=\"missing\">Nothing was measured.</p>\n", page);
    }
    write_note(table->note, page);
    return exit_code;
}

static int write_section(program *state, const page_content *content, const section *one, FILE *page)
{
    const result_table *table = result_find(content->results, one->table_id);
    int exit_code = PROGRAM_DONE;
    if (one->group != NULL) {
        fprintf(page, "<h2>%s</h2>\n", one->group);
    }
    fprintf(page, "<section id=\"%s\">\n<h3>%s</h3>\n<p>%s</p>\n", one->table_id, one->heading, one->lead);
    if (table != NULL) {
        exit_code = write_table(state, table, page);
    } else {
        fprintf(page, "<p class=\"missing\">Missing: ");
        text_escape(content->absence, page);
        fputs("</p>\n", page);
    }
    fputs("</section>\n", page);
    return exit_code;
}

/* Tables that no section is for. */
static int write_others(program *state, const page_content *content, FILE *page)
{
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; i < content->results->table_count && exit_code == PROGRAM_DONE; ++i) {
        const result_table *table = content->results->tables[i];
        if (!has_section(table->id)) {
            fprintf(page, "<section id=\"%s\">\n<h3>", text_make_name(table->id).text);
            text_escape(table->title, page);
            fputs("</h3>\n", page);
            exit_code = write_table(state, table, page);
            fputs("</section>\n", page);
        }
    }
    return exit_code;
}

static void write_end(FILE *page)
{
    fputs(
        "<section id=\"reading\">\n<h2>How to read this</h2>\n"
        "<p>Every way has its color and its mark, the same in all charts. Time runs to the right and error upwards, "
        "both "
        "on logarithmic axes where they span decades; an error of nothing stands on the floor of its chart and is "
        "labelled 0. A ring marks a point of the Pareto front: no other point is both faster and better.</p>\n"
        "<p>Medians have their quartiles in small print beside them. The CSV files and the JSON file in the folder of "
        "this page hold the same figures in full precision.</p>\n</section>\n</main>\n</body>\n</html>\n",
        page);
}

int page_write(program *state, const page_content *content, FILE *page)
{
    int exit_code = PROGRAM_DONE;
    progress_step(state->progress, "drawing charts");
    write_start(content, page);
    write_pictures(content->drawn, page);
    for (size_t i = 0; i < SECTION_COUNT && exit_code == PROGRAM_DONE; ++i) {
        exit_code = write_section(state, content, &sections[i], page);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_others(state, content, page);
    }
    write_end(page);
    return exit_code;
}
