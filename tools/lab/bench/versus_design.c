/* SPDX-License-Identifier: MIT */
/* Which cells there are. */
#include "bench/versus_design.h"

#include <stdlib.h>
#include <string.h>

#define NEED_PAYLOAD (SVO_NEED_COLOR | SVO_NEED_NORMAL)

/* The first value of need, weights and coverage is the central one. */
static const versus_level paths[] = {{"cpu", SVO_PATH_CPU}, {"gpu", SVO_PATH_GPU}, {NULL, 0}};
static const versus_level lists[] = {{"cl", OPTION_FRONTEND_CL},
                                     {"gl-expand", OPTION_FRONTEND_GL_EXPAND},
                                     {"gl-hw", OPTION_FRONTEND_GL_HW},
                                     {"gl-hybrid", OPTION_FRONTEND_GL_HYBRID},
                                     {NULL, 0}};
static const versus_level shares[] = {{"none", SVO_GL_SHARE_AUTO},
                                      {"host", SVO_GL_SHARE_HOST},
                                      {"copy", SVO_GL_SHARE_COPY},
                                      {"interop", SVO_GL_SHARE_INTEROP},
                                      {NULL, 0}};
static const versus_level builders[] = {
    {"cl", SVO_BUILDER_CL}, {"sorted", SVO_BUILDER_SORTED}, {"gl-compute", OPTION_BUILDER_GL_COMPUTE}, {NULL, 0}};
static const versus_level needs[] = {{"color,normal,rays", NEED_PAYLOAD | SVO_NEED_RAYS},
                                     {"color,normal", NEED_PAYLOAD},
                                     {"none", SVO_NEED_NONE},
                                     {NULL, 0}};
static const versus_level weights[] = {
    {"area", SVO_WEIGHTS_AREA}, {"uniform", SVO_WEIGHTS_UNIFORM}, {"center", SVO_WEIGHTS_CENTER}, {NULL, 0}};
static const versus_level coverages[] = {
    {"half-open", SVO_COVERAGE_HALF_OPEN}, {"closed", SVO_COVERAGE_CLOSED}, {"thin", SVO_COVERAGE_THIN}, {NULL, 0}};

const versus_level *versus_levels(versus_column factor)
{
    static const versus_level *const all[VERSUS_FACTORS] = {
        [VERSUS_PATH] = paths, [VERSUS_LIST] = lists,      [VERSUS_SHARE] = shares,      [VERSUS_BUILDER] = builders,
        [VERSUS_NEED] = needs, [VERSUS_WEIGHTS] = weights, [VERSUS_COVERAGE] = coverages};
    return all[factor];
}

static unsigned level_count(const versus_design *design, versus_column factor)
{
    const versus_level *levels = versus_levels(factor);
    unsigned count = 0;
    while (levels[count].name != NULL) {
        ++count;
    }
    return design->quick && factor >= VERSUS_NEED ? 2 : count;
}

bool versus_is_central(const versus_design *design, const versus_cell *cell, unsigned factors)
{
    bool central = true;
    for (versus_column i = 0; i < VERSUS_FACTORS; ++i) {
        const unsigned center = i == VERSUS_DEPTH ? design->depth : 0;
        central = central && ((factors & VERSUS_BIT(i)) == 0 || cell->level[i] == center);
    }
    return central;
}

/* The list by OpenCL takes no path of sharing, so the second path of kernels has one method for each of its builders:
   what else there is differs by what the device's own path differs by. */
static bool is_method(const versus_design *design, const versus_cell *cell)
{
    if (cell->level[VERSUS_PATH] == design->own_path) {
        return true;
    }
    return design->has_gpu_path && lists[cell->level[VERSUS_LIST]].value == OPTION_FRONTEND_CL &&
           cell->level[VERSUS_SHARE] == 0 && builders[cell->level[VERSUS_BUILDER]].value != OPTION_BUILDER_GL_COMPUTE;
}

static bool is_wanted(const versus_design *design, const versus_cell *cell)
{
    const unsigned payload = VERSUS_BIT(VERSUS_NEED) | VERSUS_BIT(VERSUS_WEIGHTS) | VERSUS_BIT(VERSUS_COVERAGE);
    const bool is_crossed = versus_is_central(design, cell, VERSUS_BIT(VERSUS_SCENE) | VERSUS_BIT(VERSUS_DEPTH));
    const bool has_payload = versus_is_central(design, cell, payload);
    const bool has_depths = design->each_has_depths || cell->level[VERSUS_SCENE] == 0;
    const bool in_series = has_payload && (has_depths || cell->level[VERSUS_DEPTH] == design->depth);
    return is_method(design, cell) && (design->full || is_crossed || in_series);
}

/* Every combination, counted through like the digits of a number, the first factor slowest. */
static size_t list(const versus_design *design, const unsigned *depths, unsigned depth_count, versus_cell *out)
{
    unsigned sizes[VERSUS_FACTORS] = {[VERSUS_SCENE] = (unsigned)design->scene_count, [VERSUS_DEPTH] = depth_count};
    size_t all = design->scene_count * depth_count;
    size_t count = 0;
    for (versus_column i = VERSUS_PATH; i < VERSUS_FACTORS; ++i) {
        sizes[i] = level_count(design, i);
        all *= sizes[i];
    }
    for (size_t number = 0; number < all; ++number) {
        versus_cell cell;
        size_t rest = number;
        for (unsigned i = VERSUS_FACTORS; i-- > 0;) {
            cell.level[i] = (unsigned)(rest % sizes[i]);
            rest /= sizes[i];
        }
        cell.level[VERSUS_DEPTH] = depths[cell.level[VERSUS_DEPTH]];
        if (is_wanted(design, &cell) && out != NULL) {
            out[count] = cell;
        }
        count += is_wanted(design, &cell);
    }
    return count;
}

versus_cell *versus_list(const versus_design *design, size_t *count)
{
    unsigned depths[SUITE_LIST_MAX + 1] = {0};
    unsigned depth_count = 0;
    bool has_center = false;
    for (; design->depths[depth_count] != 0; ++depth_count) {
        depths[depth_count] = design->depths[depth_count];
        has_center = has_center || depths[depth_count] == design->depth;
    }
    if (!has_center) {
        depths[depth_count++] = design->depth;
    }
    *count = list(design, depths, depth_count, NULL);
    versus_cell *cells = calloc(*count + 1, sizeof *cells);
    if (cells != NULL) {
        list(design, depths, depth_count, cells);
    }
    return cells;
}
