/* SPDX-License-Identifier: MIT */
/*
 * What `svocl tune` measures of errors. A quantity is a number at each sampled point: a distance, an angle, a
 * difference. A measure is a statistic of a quantity. Samples are kept as sums over blocks of points: small enough for
 * a file, and as good as the points for intervals by the bootstrap (resample.h).
 */
#ifndef SVOCL_TOOLS_TUNE_MEASURES_H
#define SVOCL_TOOLS_TUNE_MEASURES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "support/program.h"

typedef enum tune_quantity {
    QUANTITY_VOXEL = 0, /* from a voxel's center to the surface, voxels */
    QUANTITY_FACE, /* from a point of an exposed face to the surface, voxels */
    QUANTITY_SURFACE, /* from a point of the surface to the nearest voxel's center, voxels */
    QUANTITY_EXPOSED, /* exposed faces of a voxel, 0 .. 6 */
    QUANTITY_ENCLOSED, /* enclosed volume, as a share of the mesh's; one number, in every block */
    QUANTITY_DEPTH, /* between where a ray meets the voxels and the triangles, voxels */
    QUANTITY_TRIANGLE, /* 1: a ray hits another triangle than the exact reference's, not one at the same t */
    QUANTITY_T, /* between where a ray hits a triangle and where it does exactly, voxels */
    QUANTITY_SILHOUETTE, /* 1: a ray meets the one, and not the other */
    QUANTITY_COLOR, /* between colors, linear light, root of the mean square of three channels */
    QUANTITY_DELTA_E, /* the same, CIEDE2000 */
    QUANTITY_NORMAL, /* between normals, degrees */
    QUANTITY_OCCLUSION, /* gathered openness less the true one */
    QUANTITY_LIGHT, /* gathered irradiance less the true one, in units of its mean */
    QUANTITY_DIRECT, /* the same of the lights' own */
    QUANTITY_COUNT
} tune_quantity;

/* Settings that agree in some dimensions have the same errors: of the nodes, of rays, of the payload, of what is
   gathered. */
typedef enum tune_kind { KIND_SHAPE = 0, KIND_RAYS, KIND_PAYLOAD, KIND_LIGHT, KIND_COUNT } tune_kind;
tune_kind quantity_kind(tune_quantity quantity);
/* The svo_need bit without which a tree has nothing to measure; 0: it always has. */
uint32_t quantity_need(tune_quantity quantity);
const char *quantity_name(tune_quantity quantity); /* in files */

#define SAMPLE_BLOCKS 64u

typedef struct sample_block {
    double count, sum, square_sum, most; /* most: the largest magnitude */
} sample_block;

/* The samples of one quantity. */
typedef struct samples {
    sample_block blocks[SAMPLE_BLOCKS];
} samples;

/* index: of the point; it says in which block it counts. Values that are not finite are left out. */
void samples_add(samples *of, size_t index, double value);
/* The sum of all blocks. */
sample_block samples_sum(const samples *of);

/* The errors of settings of one kind. */
typedef struct tune_errors {
    tune_kind kind;
    double voxel; /* width, world units */
    double faces; /* the area of a voxel's six faces times the voxels, halved, over the mesh's area */
    uint64_t voxels;
    samples of[QUANTITY_COUNT];
    size_t rungs; /* of sample points that are in it */
} tune_errors;

/* What a ray hits: a triangle of the mesh, or SVO_NO_TRIANGLE. */
typedef struct tune_hit {
    uint32_t triangle;
    double t;
} tune_hit;

/* Adds QUANTITY_TRIANGLE of a ray that meets something in one of the hits, and QUANTITY_T of one that does in both. Ts
   that are equal up to rounding in float are a tie. errors->voxel is known. */
void samples_add_hit(tune_errors *errors, size_t index, tune_hit exact, tune_hit found);

typedef enum tune_statistic {
    STATISTIC_MEAN = 0,
    STATISTIC_RMS,
    STATISTIC_MOST, /* of the points that were sampled */
    STATISTIC_BIAS, /* the signed mean */
    STATISTIC_AREA, /* of QUANTITY_EXPOSED: how far the faces' area is off, % */
    STATISTIC_VOLUME, /* of QUANTITY_ENCLOSED: how far the volume is off, % */
} tune_statistic;

typedef struct tune_measure {
    const char *name; /* "voxel-rms" */
    const char *unit; /* "voxels" */
    tune_quantity quantity;
    tune_statistic statistic;
    bool in_units; /* times the width of a voxel */
    const char *meaning;
} tune_measure;

/* All of them; NULL past the last. */
const tune_measure *tune_measure_at(size_t index);
size_t tune_measure_count(void);
/* The index of a name of that length; tune_measure_count() for an unknown one. */
size_t tune_measure_find(const char *name, size_t length);

/* The value of a block of samples; NAN without samples. Of STATISTIC_BIAS it is signed. */
double tune_measure_value(const tune_measure *which, const tune_errors *errors, const sample_block *sum);

/* An error that must not be exceeded. */
typedef struct tune_bound {
    size_t measure;
    double most; /* INFINITY: it is to be the least, instead */
} tune_bound;

#define TUNE_BOUNDS_MAX 16u
typedef struct tune_bounds {
    tune_bound list[TUNE_BOUNDS_MAX];
    size_t count;
    size_t least; /* the measure without a number; tune_measure_count(): none */
    double time_ms, bytes; /* INFINITY: none */
} tune_bounds;

/* Reads the text of --error, "voxel-rms:.5,ao:.03,normal". Returns the exit code. */
int tune_bounds_read(program *state, const char *text, tune_bounds *bounds);

/* The measures of bounds, then what is to be the least; NULL past the last. */
const tune_measure *tune_bounds_at(const tune_bounds *bounds, size_t index);
/* Whether one of them is of that kind. */
bool tune_bounds_ask(const tune_bounds *bounds, tune_kind kind);

#endif
