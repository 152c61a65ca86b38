/* SPDX-License-Identifier: MIT */
/*
 * What light at points truly is: ambient occlusion, direct light, and light after some bounces (Kajiya, "The Rendering
 * Equation", 1986), by paths against the triangles. The rays are the tree's own; the rest is double precision on the
 * host. The samples of a point are 16 independent sets, each with one sample in every cell of a square of strata (Cook,
 * Porter, Carpenter, "Distributed Ray Tracing", 1984); their scatter gives the standard error. To sources with a size
 * go 256 rays from a point, and one from what its paths meet. The same on every run and with every number of threads.
 *
 * Surfaces are opaque, reflect diffusely by their linear color, on the side that a ray meets, and emit on both sides.
 */
#ifndef SVOCL_TOOLS_PATH_H
#define SVOCL_TOOLS_PATH_H

#include <stdbool.h>

#include "scenes/maths.h"
#include "svocl/light.h"
#include "svocl/light_types.h"
#include "svocl/mesh.h"

#define PATH_SETS        16u
#define PATH_SAMPLES_MAX 262144u

typedef struct path_scene {
    svo_tree *tree; /* of the mesh, with SVO_NEED_RAYS, on a device */
    const svo_mesh *mesh; /* its colors */
    cl_command_queue queue; /* NULL: the device's own */
    const svo_light_setup *setup; /* sources, finishes, sky */
    double range; /* of occlusion, world units; 0: unlimited. Light has no range */
    double falloff; /* lambda of the occlusion's weight 1 / (1 + lambda t) */
    unsigned bounces; /* rays of a path, so often are sources reflected; 0: one */
    unsigned threads;
} path_scene;

typedef struct path_result {
    bool is_gathered; /* false: outside the grid or without a normal; open then, and without light */
    double openness; /* ambient occlusion: 1 is open, 0 closed */
    double openness_error; /* its standard error */
    double direct[3]; /* irradiance from the sources: red, green, blue */
    double irradiance[3]; /* irradiance from surfaces, which reflect the sources' light or emit, and from the sky */
    double irradiance_error[3]; /* its standard error */
} path_result;

/* The samples of a point that are taken for so many: 16 squares, at least 16. */
unsigned path_sample_count(unsigned samples);

/* Traces the points; of their records it reads position and normal. samples: 1 .. PATH_SAMPLES_MAX a point, and the
   same seed takes the same ones. A failure leaves the reason in the message of the tree's device, or is
   SVO_OUT_OF_HOST_MEMORY. */
svo_status path_trace(const path_scene *scene, const svo_gather_point *points, size_t point_count, unsigned samples,
                      uint32_t seed, path_result *results);

/* ---- parts of it ---- */

/* A source of light as a place sees it, without what stands between. */
typedef struct source_view {
    vector3 direction; /* unit, towards the source */
    double distance; /* world units; infinite for directional light */
    double strength; /* irradiance of a surface that faces the source, for a value of 1 */
} source_view;

/* False where the source sends no light to the place. It is the middle of the source that is seen. */
bool path_source_view(const svo_light_source *source, vector3 place, source_view *view);
/* Turns the view of a source with a size to the point of it that two numbers in [0, 1) choose, evenly over the disk
   that it shows. */
void path_source_spread(const svo_light_source *source, const double chosen[2], source_view *view);

#endif
