/* SPDX-License-Identifier: MIT */
/* The table of measures, their values, and the reader of --error. */
#include "tune/measures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure/ray_sets.h"
#include "support/suggest.h"
#include "svocl/plan.h"

/* ---- quantities ---- */

static const struct {
    const char *name;
    tune_kind kind;
    uint32_t need;
} quantities[QUANTITY_COUNT] = {
    [QUANTITY_VOXEL] = {"voxel", KIND_SHAPE, 0},
    [QUANTITY_FACE] = {"face", KIND_SHAPE, 0},
    [QUANTITY_SURFACE] = {"surface", KIND_SHAPE, 0},
    [QUANTITY_EXPOSED] = {"exposed", KIND_SHAPE, 0},
    [QUANTITY_ENCLOSED] = {"enclosed", KIND_SHAPE, 0},
    [QUANTITY_DEPTH] = {"depth", KIND_RAYS, 0},
    [QUANTITY_SILHOUETTE] = {"silhouette", KIND_RAYS, 0},
    [QUANTITY_TRIANGLE] = {"triangle", KIND_RAYS, SVO_NEED_RAYS},
    [QUANTITY_T] = {"t", KIND_RAYS, SVO_NEED_RAYS},
    [QUANTITY_COLOR] = {"color", KIND_PAYLOAD, SVO_NEED_COLOR},
    [QUANTITY_DELTA_E] = {"delta-e", KIND_PAYLOAD, SVO_NEED_COLOR},
    [QUANTITY_NORMAL] = {"normal", KIND_PAYLOAD, SVO_NEED_NORMAL},
    [QUANTITY_OCCLUSION] = {"ao", KIND_LIGHT, 0},
    [QUANTITY_LIGHT] = {"light", KIND_LIGHT, 0},
    [QUANTITY_DIRECT] = {"direct", KIND_LIGHT, 0},
};

tune_kind quantity_kind(tune_quantity quantity)
{
    return quantities[quantity].kind;
}

uint32_t quantity_need(tune_quantity quantity)
{
    return quantities[quantity].need;
}

const char *quantity_name(tune_quantity quantity)
{
    return quantities[quantity].name;
}

void samples_add(samples *of, size_t index, double value)
{
    sample_block *block = &of->blocks[index % SAMPLE_BLOCKS];
    if (isfinite(value)) {
        block->count += 1;
        block->sum += value;
        block->square_sum += value * value;
        block->most = fmax(block->most, fabs(value));
    }
}

sample_block samples_sum(const samples *of)
{
    sample_block sum = {0, 0, 0, 0};
    for (size_t i = 0; i < SAMPLE_BLOCKS; ++i) {
        sum.count += of->blocks[i].count;
        sum.sum += of->blocks[i].sum;
        sum.square_sum += of->blocks[i].square_sum;
        sum.most = fmax(sum.most, of->blocks[i].most);
    }
    return sum;
}

void samples_add_hit(tune_errors *errors, size_t index, tune_hit exact, tune_hit found)
{
    const bool is_met = exact.triangle != SVO_NO_TRIANGLE;
    const bool is_found = found.triangle != SVO_NO_TRIANGLE;
    if (is_met || is_found) {
        const bool same = exact.triangle == found.triangle || (is_met && is_found && ray_ties(exact.t, found.t));
        samples_add(&errors->of[QUANTITY_TRIANGLE], index, !same);
    }
    if (is_met && is_found) {
        samples_add(&errors->of[QUANTITY_T], index, fabs(exact.t - found.t) / errors->voxel);
    }
}

/* ---- measures ---- */

#define DISTANCES(name, quantity, meaning)                                                          \
    {name "-mean", "voxels", quantity, STATISTIC_MEAN, false, meaning ", mean"},                    \
        {name "-rms", "voxels", quantity, STATISTIC_RMS, false, meaning ", RMS"},                   \
        {name "-max", "voxels", quantity, STATISTIC_MOST, false, meaning ", largest (Hausdorff)"},  \
        {name "-mean-units", "units", quantity, STATISTIC_MEAN, true, meaning ", mean"},            \
        {name "-rms-units", "units", quantity, STATISTIC_RMS, true, meaning ", RMS"},               \
    {                                                                                               \
        name "-max-units", "units", quantity, STATISTIC_MOST, true, meaning ", largest (Hausdorff)" \
    }

static const tune_measure measures[] = {
    DISTANCES("voxel", QUANTITY_VOXEL, "voxel centers to the surface"),
    DISTANCES("face", QUANTITY_FACE, "exposed faces to the surface"),
    DISTANCES("surface", QUANTITY_SURFACE, "the surface to voxel centers"),
    {"area", "%", QUANTITY_EXPOSED, STATISTIC_AREA, false, "half of the exposed faces' area against the mesh's"},
    {"volume", "%", QUANTITY_ENCLOSED, STATISTIC_VOLUME, false, "enclosed volume against the mesh's, if closed"},
    {"color", "linear", QUANTITY_COLOR, STATISTIC_RMS, false, "color in linear light, 0 to 1, RMS"},
    {"color-max", "linear", QUANTITY_COLOR, STATISTIC_MOST, false, "color in linear light, largest"},
    {"delta-e", "CIEDE2000", QUANTITY_DELTA_E, STATISTIC_MEAN, false, "difference of colors, mean"},
    {"delta-e-max", "CIEDE2000", QUANTITY_DELTA_E, STATISTIC_MOST, false, "difference of colors, largest"},
    {"normal", "degrees", QUANTITY_NORMAL, STATISTIC_MEAN, false, "angle between normals, mean"},
    {"normal-rms", "degrees", QUANTITY_NORMAL, STATISTIC_RMS, false, "angle between normals, RMS"},
    {"normal-max", "degrees", QUANTITY_NORMAL, STATISTIC_MOST, false, "angle between normals, largest"},
    {"depth", "voxels", QUANTITY_DEPTH, STATISTIC_MEAN, false, "rays to voxels against rays to triangles, mean"},
    {"depth-rms", "voxels", QUANTITY_DEPTH, STATISTIC_RMS, false, "rays to voxels against rays to triangles, RMS"},
    {"depth-rms-units", "units", QUANTITY_DEPTH, STATISTIC_RMS, true, "rays to voxels against triangles, RMS"},
    {"silhouette", "%", QUANTITY_SILHOUETTE, STATISTIC_MEAN, false, "rays that meet voxels or triangles alone"},
    {"triangle", "%", QUANTITY_TRIANGLE, STATISTIC_MEAN, false, "rays that hit another triangle, but for ties"},
    {"t-rms", "voxels", QUANTITY_T, STATISTIC_RMS, false, "where rays hit triangles, RMS"},
    {"t-rms-units", "units", QUANTITY_T, STATISTIC_RMS, true, "where rays hit triangles, RMS"},
    {"t-max-units", "units", QUANTITY_T, STATISTIC_MOST, true, "where rays hit triangles, largest"},
    {"ao", "openness", QUANTITY_OCCLUSION, STATISTIC_RMS, false, "ambient occlusion, RMSE"},
    {"ao-bias", "openness", QUANTITY_OCCLUSION, STATISTIC_BIAS, false, "ambient occlusion, signed mean"},
    {"light", "of mean", QUANTITY_LIGHT, STATISTIC_RMS, false, "irradiance after a bounce, RMSE"},
    {"light-bias", "of mean", QUANTITY_LIGHT, STATISTIC_BIAS, false, "irradiance after a bounce, signed mean"},
    {"direct", "of mean", QUANTITY_DIRECT, STATISTIC_RMS, false, "irradiance by the lights, RMSE"},
    {"direct-bias", "of mean", QUANTITY_DIRECT, STATISTIC_BIAS, false, "irradiance by the lights, signed mean"},
};

const tune_measure *tune_measure_at(size_t index)
{
    return index < tune_measure_count() ? &measures[index] : NULL;
}

size_t tune_measure_count(void)
{
    return sizeof measures / sizeof measures[0];
}

size_t tune_measure_find(const char *name, size_t length)
{
    size_t index = 0;
    while (index < tune_measure_count() &&
           (strlen(measures[index].name) != length || strncmp(measures[index].name, name, length) != 0)) {
        ++index;
    }
    return index;
}

double tune_measure_value(const tune_measure *which, const tune_errors *errors, const sample_block *sum)
{
    const double mean = sum->count > 0 ? sum->sum / sum->count : NAN;
    const bool is_share = which->quantity == QUANTITY_SILHOUETTE || which->quantity == QUANTITY_TRIANGLE;
    const double scale = is_share ? 100 : which->in_units ? errors->voxel : 1;
    switch (which->statistic) {
    case STATISTIC_RMS:
        return sum->count > 0 ? scale * sqrt(sum->square_sum / sum->count) : NAN;
    case STATISTIC_MOST:
        return sum->count > 0 ? scale * sum->most : NAN;
    case STATISTIC_AREA:
        return 100 * fabs(mean / 6 * errors->faces - 1);
    case STATISTIC_VOLUME:
        return 100 * fabs(mean - 1);
    case STATISTIC_MEAN:
    case STATISTIC_BIAS:
    default:
        return scale * mean;
    }
}

/* ---- bounds ---- */

static int fail_name(program *state, const char *name, size_t length)
{
    suggestion near = suggestion_begin(name, length);
    for (size_t i = 0; i < tune_measure_count(); ++i) {
        suggestion_offer(&near, measures[i].name);
    }
    return program_fail(state, PROGRAM_WRONG_USAGE, "--error: '%.*s' is no measure, see tune --help%s", (int)length,
                        name, suggestion_end(&near).text);
}

/* One "NAME" or "NAME:NUMBER", which ends at *end. */
static int read_bound(program *state, const char *text, size_t length, tune_bounds *bounds)
{
    const size_t name_length = strcspn(text, ":,");
    const size_t measure = tune_measure_find(text, name_length);
    char *end = NULL;
    if (measure == tune_measure_count()) {
        return fail_name(state, text, name_length);
    }
    if (name_length == length) {
        if (bounds->least != tune_measure_count()) {
            return program_fail(state, PROGRAM_WRONG_USAGE, "--error: %s and %s both lack a number, and one may",
                                measures[bounds->least].name, measures[measure].name);
        }
        bounds->least = measure;
        return PROGRAM_DONE;
    }
    const double most = strtod(text + name_length + 1, &end);
    if (end != text + length || end == text + name_length + 1 || !isfinite(most) || most < 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--error: '%.*s' is not NAME:NUMBER with a number of at least 0", (int)length, text);
    }
    if (bounds->count == TUNE_BOUNDS_MAX) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--error: more than %u bounds", TUNE_BOUNDS_MAX);
    }
    bounds->list[bounds->count++] = (tune_bound){.measure = measure, .most = most};
    return PROGRAM_DONE;
}

int tune_bounds_read(program *state, const char *text, tune_bounds *bounds)
{
    *bounds = (tune_bounds){.least = tune_measure_count(), .time_ms = INFINITY, .bytes = INFINITY};
    int exit_code = PROGRAM_DONE;
    while (text != NULL && exit_code == PROGRAM_DONE) {
        const size_t length = strcspn(text, ",");
        exit_code = read_bound(state, text, length, bounds);
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    return exit_code;
}

const tune_measure *tune_bounds_at(const tune_bounds *bounds, size_t index)
{
    return index < bounds->count    ? &measures[bounds->list[index].measure]
           : index == bounds->count ? tune_measure_at(bounds->least)
                                    : NULL;
}

bool tune_bounds_ask(const tune_bounds *bounds, tune_kind kind)
{
    bool asked = false;
    for (size_t i = 0; tune_bounds_at(bounds, i) != NULL; ++i) {
        asked = asked || quantity_kind(tune_bounds_at(bounds, i)->quantity) == kind;
    }
    return asked;
}
