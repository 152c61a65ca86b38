/* SPDX-License-Identifier: MIT */
/* The tables of cases. Names are spelled here, so that a renaming in the library does not change them. */
#include "cases.h"

#include <stdio.h>
#include <string.h>

#include "digest.h"

const method methods[METHOD_COUNT] = {
    {"cl cl none blocking", SVO_BUILDER_CL, FRONT_CL, MODE_BLOCKING},
    {"sorted cl none blocking", SVO_BUILDER_SORTED, FRONT_CL, MODE_BLOCKING},
    {"cl gl-expand host blocking", SVO_BUILDER_CL, FRONT_GL_HOST, MODE_BLOCKING},
    {"cl cl none enqueued trimmed", SVO_BUILDER_CL, FRONT_CL, MODE_TRIMMED},
    {"gl-compute gl-expand host blocking", SVO_BUILDER_CL, FRONT_GL_HOST, MODE_GL_COMPUTE},
    {"cl gl-expand copy blocking", SVO_BUILDER_CL, FRONT_GL_COPY, MODE_BLOCKING},
    {"cl cl none enqueued", SVO_BUILDER_CL, FRONT_CL, MODE_ENQUEUED},
    {"cl cl none enqueued twice", SVO_BUILDER_CL, FRONT_CL, MODE_TWICE},
    {"cl cl none counted", SVO_BUILDER_CL, FRONT_CL, MODE_COUNTED},
    {"cl gl-expand host enqueued", SVO_BUILDER_CL, FRONT_GL_HOST, MODE_ENQUEUED},
    {"cl gl-expand copy enqueued trimmed", SVO_BUILDER_CL, FRONT_GL_COPY, MODE_TRIMMED},
    {"sorted gl-expand copy blocking", SVO_BUILDER_SORTED, FRONT_GL_COPY, MODE_BLOCKING},
    {"cl gl-expand copy counted", SVO_BUILDER_CL, FRONT_GL_COPY, MODE_COUNTED},
};

/* The first methods[] are one of each kind. */
#define ONE     0x0001u /* OpenCL alone, blocking */
#define BY_CL   0x000bu /* without OpenGL */
#define EACH    0x001fu /* one of each kind */
#define DRAWN   0x000fu /* the same without compute shaders, which are slow on a processor */
#define WIDE    0x1fefu /* all without compute shaders */
#define ALL     0x1fffu
#define COUNTED 0x0e1fu /* those whose calls are counted */

/* What cases named "all" ask for; it stays when SVO_NEED_ALL grows. */
#define ALL_NEEDS (SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_MATERIAL | SVO_NEED_FILL)
#define NO_FILL   (ALL_NEEDS & ~(unsigned)SVO_NEED_FILL)
#define AREAS     ((unsigned)SVO_NEED_PROJECTED_AREA)
#define CLOSED    .coverage = SVO_COVERAGE_CLOSED
#define THIN      .coverage = SVO_COVERAGE_THIN
#define UNIFORM   .weights = SVO_WEIGHTS_UNIFORM
#define CENTER    .weights = SVO_WEIGHTS_CENTER

const request requests[] = {
    /* Every scene by every method. */
    {"atrium:3000", .depth = 6, .methods = WIDE},
    {"atrium:3000", .depth = 5, .need = ALL_NEEDS, .methods = EACH},
    {"statue:2000", .depth = 7, .methods = WIDE},
    {"statue:2000", .depth = 5, .need = ALL_NEEDS, .methods = EACH},
    {"knot:2000", .depth = 7, .methods = WIDE},
    {"terrain:2000", .depth = 7, .methods = WIDE},
    {"terrain:2000", .depth = 5, .need = ALL_NEEDS, .methods = EACH},
    {"needles:200", .depth = 8, .methods = WIDE},
    {"needles:200", .depth = 6, .need = ALL_NEEDS, .methods = EACH},
    {"dust:2000", .depth = 8, .methods = WIDE},
    {"dust:2000", .depth = 6, .need = ALL_NEEDS, .methods = EACH},
    {"cornell:500", .depth = 6, .methods = WIDE},
    {"cornell:500", .depth = 4, .need = ALL_NEEDS, .methods = EACH},
    {"cube:12", .depth = 6, .methods = WIDE},
    {"cube:12", .depth = 4, .need = ALL_NEEDS, .methods = EACH},
    /* Coverages. */
    {"knot:2000", .depth = 5, .need = ALL_NEEDS, .methods = ALL},
    {"knot:2000", .depth = 5, CLOSED, .need = ALL_NEEDS, .methods = ALL},
    {"knot:2000", .depth = 5, THIN, .need = ALL_NEEDS, .methods = ALL},
    {"needles:200", .depth = 7, CLOSED, .need = ALL_NEEDS, .methods = EACH},
    {"needles:200", .depth = 7, THIN, .need = ALL_NEEDS, .methods = EACH},
    {"dust:2000", .depth = 7, CLOSED, .need = ALL_NEEDS, .methods = EACH},
    {"dust:2000", .depth = 7, THIN, .need = ALL_NEEDS, .methods = EACH},
    {"atrium:3000", .depth = 7, CLOSED, .need = ALL_NEEDS, .methods = ONE},
    {"atrium:3000", .depth = 7, THIN, .need = ALL_NEEDS, .methods = ONE},
    /* Needs and weights. */
    {"statue:2000", .depth = 5, .need = SVO_NEED_NONE, .methods = EACH},
    {"statue:2000", .depth = 5, .need = SVO_NEED_COLOR, .methods = EACH},
    {"statue:2000", .depth = 5, .need = SVO_NEED_NORMAL, .methods = EACH},
    {"statue:2000", .depth = 5, .need = SVO_NEED_RAYS, .methods = EACH},
    {"statue:2000", .depth = 5, .need = SVO_NEED_MATERIAL, .methods = EACH},
    {"statue:2000", .depth = 5, .need = SVO_NEED_FILL, .methods = EACH},
    {"statue:2000", .depth = 5, UNIFORM, .need = SVO_NEED_COLOR, .methods = EACH},
    {"statue:2000", .depth = 5, UNIFORM, .need = SVO_NEED_NORMAL, .methods = EACH},
    {"statue:2000", .depth = 5, CENTER, .need = SVO_NEED_COLOR, .methods = EACH},
    {"statue:2000", .depth = 5, CENTER, .need = SVO_NEED_NORMAL, .methods = EACH},
    {"cornell:500", .depth = 5, .need = SVO_NEED_MATERIAL, .methods = EACH},
    {"cornell:500", .depth = 5, .need = ALL_NEEDS, .methods = EACH},
    {"cornell:500", .depth = 5, UNIFORM, .need = NO_FILL, .methods = EACH},
    {"cornell:500", .depth = 5, CENTER, .need = NO_FILL, .methods = EACH},
    {"knot:2000", .depth = 5, UNIFORM, .need = NO_FILL, .methods = EACH},
    {"knot:2000", .depth = 5, CENTER, .need = NO_FILL, .methods = EACH},
    {"needles:200", .depth = 7, UNIFORM, .need = NO_FILL, .methods = BY_CL},
    {"needles:200", .depth = 7, CENTER, .need = NO_FILL, .methods = BY_CL},
    /* Payload levels. */
    {"knot:2000", .depth = 5, .need = ALL_NEEDS, .payload_level = 3, .methods = EACH},
    {"knot:2000", .depth = 5, .need = ALL_NEEDS, .payload_level = 5, .methods = EACH},
    {"cornell:500", .depth = 5, UNIFORM, .need = NO_FILL, .payload_level = 5, .methods = EACH},
    /* Depths. */
    {"cube:12", .depth = 1, .need = ALL_NEEDS, .methods = EACH},
    {"knot:2000", .depth = 4, .need = ALL_NEEDS, .methods = ALL},
    {"dust:2000", .depth = 11, .need = ALL_NEEDS, .methods = EACH},
    {"dust:2000", .depth = 13, .need = ALL_NEEDS, .methods = EACH},
    {"dust:2000", .depth = 16, .need = ALL_NEEDS, .methods = ONE},
    {"needles:20", .depth = 11, .methods = EACH},
    {"needles:20", .depth = 13, CLOSED, .methods = BY_CL},
    /* Callers' grids: around, across, and one that the mesh misses. */
    {"knot:2000", .depth = 11, .origin = {-20, -20, -20}, .edge = 80, .need = ALL_NEEDS, .methods = DRAWN},
    {"knot:2000", .depth = 5, .origin = {0, 0, -0.5}, .edge = 1, .need = ALL_NEEDS, .methods = EACH},
    {"cube:12", .depth = 6, .origin = {-0.25, -0.25, -0.25}, .edge = 1, CLOSED, .need = ALL_NEEDS, .methods = EACH},
    {"cube:12", .depth = 5, .origin = {3, 3, 3}, .edge = 1, .need = ALL_NEEDS, .methods = EACH},
    /* Meshes in other forms. */
    {"knot:2000", MESH_BARE, .depth = 5, .need = ALL_NEEDS, .methods = EACH},
    {"knot:2000", MESH_BARE, .depth = 5, .methods = EACH},
    {"knot:2000", MESH_TEXTURED, .depth = 5, .need = ALL_NEEDS, .methods = EACH},
    {"knot:2000", MESH_TEXTURED, .depth = 5, UNIFORM, .need = NO_FILL, .methods = EACH},
    {"knot:2000", MESH_TEXTURED, .depth = 5, CENTER, .need = SVO_NEED_COLOR, .methods = EACH},
    {"knot:2000", MESH_BROKEN, .depth = 5, .need = ALL_NEEDS, .methods = EACH},
    {"knot:2000", MESH_DOUBLES, .depth = 5, .need = ALL_NEEDS, .methods = EACH},
    /* Chunks and capacities, large enough and too small. */
    {"knot:2000", .depth = 5, .need = ALL_NEEDS, .chunk_bytes = 16384, .methods = ALL},
    {"dust:2000", .depth = 12, .need = ALL_NEEDS, .chunk_bytes = 16384, .methods = EACH},
    {"knot:2000", .depth = 5, .need = ALL_NEEDS, .fragment_capacity = 1000, .methods = ALL},
    {"knot:2000", .depth = 5, .need = ALL_NEEDS, .fragment_capacity = 100000, .methods = EACH},
    {"knot:2000", .depth = 5, .need = ALL_NEEDS, .worst_case_nodes = 1, .methods = ALL},
    /* Pairs of triangle and leaf, which CPUs evaluate eight at a time: many in a leaf, few, and with textures. */
    {"needles:200", .depth = 5, .need = SVO_NEED_COLOR | SVO_NEED_NORMAL | AREAS, .methods = BY_CL},
    {"statue:2000", .depth = 9, .need = SVO_NEED_COLOR | SVO_NEED_NORMAL, .methods = BY_CL},
    {"knot:2000", MESH_TEXTURED, .depth = 4, .need = SVO_NEED_COLOR | AREAS, .chunk_bytes = 16384, .methods = BY_CL},
    /* Projected areas. */
    {"knot:2000", .depth = 5, .need = AREAS, .methods = ALL},
    {"knot:2000", .depth = 5, .need = ALL_NEEDS | AREAS, .methods = EACH},
    {"knot:2000", .depth = 5, CENTER, .need = NO_FILL | AREAS, .methods = EACH},
    {"knot:2000", .depth = 5, .need = SVO_NEED_COLOR | AREAS, .chunk_bytes = 16384, .methods = ALL},
    {"knot:2000", .depth = 5, .origin = {0, 0, -0.5}, .edge = 1, .need = AREAS, .methods = EACH},
    {"needles:200", .depth = 7, CLOSED, UNIFORM, .need = AREAS, .methods = EACH},
    {"dust:2000", .depth = 13, .need = AREAS, .methods = BY_CL},
};
const size_t request_count = sizeof requests / sizeof requests[0];

const request counted_requests[] = {
    {"knot:500", .depth = 5, .methods = COUNTED},
    {"knot:500", .depth = 5, .need = SVO_NEED_NONE, .methods = COUNTED},
    {"knot:500", .depth = 5, .need = ALL_NEEDS, .methods = COUNTED},
    {"knot:500", .depth = 5, .need = ALL_NEEDS, .chunk_bytes = 16384, .fragment_capacity = 1000, .methods = BY_CL},
    {"knot:500", .depth = 5, .need = AREAS, .methods = COUNTED},
    {"knot:500", .depth = 5, .need = AREAS, .chunk_bytes = 16384, .fragment_capacity = 1000, .methods = BY_CL},
};
const size_t counted_request_count = sizeof counted_requests / sizeof counted_requests[0];

const request query_requests[] = {
    {"knot:2000", .depth = 6, .need = ALL_NEEDS},
    {"atrium:3000", .depth = 7, CLOSED, .need = ALL_NEEDS},
    {"dust:2000", .depth = 8, .need = SVO_NEED_RAYS},
    {"needles:200", .depth = 13, .need = SVO_NEED_RAYS | SVO_NEED_COLOR},
    {"cornell:500", .depth = 6, THIN},
    {"statue:2000", .depth = 6, .need = ALL_NEEDS, .payload_level = 6},
    {"knot:2000", .depth = 7, .origin = {0, 0, -0.5}, .edge = 1, .need = ALL_NEEDS},
};
const size_t query_request_count = sizeof query_requests / sizeof query_requests[0];

const request paged_requests[] = {
    {"knot:2000", .depth = 8, .need = SVO_NEED_COLOR | SVO_NEED_NORMAL},
    {"atrium:3000", .depth = 8, .need = SVO_NEED_COLOR | SVO_NEED_NORMAL},
    {"statue:2000", .depth = 7, .need = ALL_NEEDS},
};
const size_t paged_request_count = sizeof paged_requests / sizeof paged_requests[0];

const request moving_requests[] = {
    {"knot:2000", .depth = 7, .origin = {-2, -2, -2}, .edge = 4, .need = SVO_NEED_COLOR | SVO_NEED_NORMAL},
    {"knot:2000", .depth = 6, CLOSED, .origin = {-2, -2, -2}, .edge = 4, .need = ALL_NEEDS},
    {"knot:2000", MESH_DOUBLES, .depth = 6, .origin = {-2, -2, -2}, .edge = 4, .need = SVO_NEED_NONE},
    {"atrium:3000", .depth = 7, .origin = {-30, -30, -30}, .edge = 60, .need = ALL_NEEDS},
};
const size_t moving_request_count = sizeof moving_requests / sizeof moving_requests[0];

const request instanced_requests[INSTANCED_COUNT] = {
    {"knot:2000", .depth = 5, .need = ALL_NEEDS},
    {"cornell:500", .depth = 4, CLOSED, .need = ALL_NEEDS},
    {"cube:12", .depth = 6, .need = ALL_NEEDS},
};

static void add_needs(line_text *line, uint32_t need)
{
    static const char *const names[] = {"color", "normal", "rays", "material", "fill", "areas"};
    if (need == SVO_NEED_DEFAULT || need == SVO_NEED_NONE || need == ALL_NEEDS) {
        line_text_add(line, " %s", need == SVO_NEED_DEFAULT ? "default" : need == SVO_NEED_NONE ? "none" : "all");
        return;
    }
    const char *separator = " ";
    for (unsigned bit = 0; bit < sizeof names / sizeof names[0]; ++bit) {
        if ((need >> bit & 1u) != 0) {
            line_text_add(line, "%s%s", separator, names[bit]);
            separator = ",";
        }
    }
}

void request_name(const request *wanted, char *name, size_t name_bytes)
{
    static const char *const variants[] = {"", " bare", " textured", " broken", " doubles"};
    static const char *const coverages[] = {"half-open", "closed", "thin"};
    static const char *const weights[] = {"area", "uniform", "center"};
    line_text line = {.used = 0};
    line_text_add(&line, "%s%s d%u %s %s", wanted->scene, variants[wanted->variant], wanted->depth,
                  coverages[wanted->coverage], weights[wanted->weights]);
    add_needs(&line, wanted->need);
    if (wanted->payload_level > 0) {
        line_text_add(&line, " level %u", (unsigned)wanted->payload_level);
    }
    if (wanted->edge > 0) {
        line_text_add(&line, " grid %g,%g,%g+%g", wanted->origin[0], wanted->origin[1], wanted->origin[2],
                      wanted->edge);
    }
    if (wanted->chunk_bytes > 0) {
        line_text_add(&line, " chunks %lu", (unsigned long)wanted->chunk_bytes);
    }
    if (wanted->fragment_capacity > 0) {
        line_text_add(&line, " capacity %lu", (unsigned long)wanted->fragment_capacity);
    }
    if (wanted->worst_case_nodes != 0) {
        line_text_add(&line, " worst-case nodes");
    }
    (void)snprintf(name, name_bytes, "%s", line.text);
}

svo_plan_options request_options(const request *wanted, svo_builder builder)
{
    svo_plan_options options = {.struct_size = sizeof options,
                                .need = wanted->need,
                                .coverage = wanted->coverage,
                                .weights = wanted->weights,
                                .builder = builder,
                                .payload_level = wanted->payload_level,
                                .edge = wanted->edge,
                                .fragment_capacity = wanted->fragment_capacity,
                                .worst_case_nodes = wanted->worst_case_nodes,
                                .chunk_bytes = wanted->chunk_bytes};
    memcpy(options.origin, wanted->origin, sizeof options.origin);
    return options;
}
