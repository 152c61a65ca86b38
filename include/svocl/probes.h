/* SPDX-License-Identifier: MIT */
/** \file
 * Light field probes: a grid of points, each with a map of what is around it, through which rays are traced without the
 * geometry (after McGuire et al., "Real-Time Global Illumination using Precomputed Light Field Probes", 2017).
 *
 * A probe holds resolution x resolution texels over the sphere of directions, mapped onto a square by an octahedron,
 * and per texel the nearest surface along the texel's center: distance, normal and radiance, 8 bytes (probe_types.h).
 * Texel (column i, row j) is the direction of the point p = (2 (i + 1/2) / R - 1, 2 (j + 1/2) / R - 1) of the square:
 * (p.x, p.y, 1 - |p.x| - |p.y|), where a negative z folds x and y outwards. Distances come from the exact rays of the
 * tree, from rays against voxels for trees without triangles, and from the same of a scene's instances. Radiance is the
 * light's, where there is one.
 *
 * A probe that sees surfaces from behind in more than half of its directions, or that lies within a leaf's edge of a
 * surface, moves to the nearest cell center where neither is so, within half a step along each axis and inside the box,
 * else it is switched off. 32 x 32 directions decide. Cells are as wide as a leaf, doubled until no step has more than
 * 16 of them.
 *
 * What is stored, but for radiance and irradiance, is the same bytes on every device and run, where exact rays give the
 * same hits (trace.h). Radiance is single-precision, as cones are: the same on every run of a device, and between
 * devices within a step of its encoding, 1/64 of red and green and 1/32 of blue. Texels where rounding decides, at the
 * edge of a shadow or of surfaces that share cones, may differ by more.
 *
 * Probes refer to their tree or scene and to their light; these must outlive them and stay as they are.
 *
 * Thread-safety: several threads may call functions that take const svo_probes. All others need exclusive use of the
 * probes and of their device handle.
 */
#ifndef SVOCL_PROBES_H
#define SVOCL_PROBES_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/light.h"
#include "svocl/probe_types.h"
#include "svocl/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SVO_PROBES_MAX               65534u /**< most probes */
#define SVO_PROBES_RESOLUTION_MIN    64u /**< least texels along a side of a probe's map */
#define SVO_PROBES_RESOLUTION_MAX    1024u /**< most of them */
#define SVO_PROBES_RESOLUTION_STEP   16u /**< resolutions are multiples of it: the edge of a coarse texel */
#define SVO_PROBES_FIELD_MAX         256u /**< most cells of the field along an axis */
#define SVO_PROBES_IRRADIANCE_TEXELS 8u /**< along a side of a map of irradiance */
#define SVO_PROBES_MOMENT_TEXELS     16u /**< along a side of a map of moments */

/** A grid of probes. */
typedef struct svo_probes svo_probes;

/** Options of probes. */
typedef struct svo_probe_options {
    size_t struct_size; /**< sizeof(svo_probe_options) */
    uint32_t counts[3]; /**< probes along x, y and z, from 1 on; at most SVO_PROBES_MAX in all. All 0: 4, 4, 4 */
    /** Texels along a side of a probe's map: 64 .. 1024, a multiple of 16; 0: 256, or the most below it that max_bytes
     *  allows. */
    uint32_t resolution;
    float start[3]; /**< of the first probe, world; read on axes with a step */
    /** Between probes, world units, by axis; 0: as many equal cells as there are probes fill the tree's grid or the
     *  scene's box, and probes are at their centers. */
    float step[3];
    uint64_t max_bytes; /**< of the texels of all probes; 0: 1 GiB */
    uint32_t field_size; /**< cells of the field along an axis, 1 .. 256; 0: 64 */
    uint32_t keep_places; /**< not 0: probes are neither moved nor switched off */
    uint32_t diffuse; /**< not 0: maps of irradiance and distances for diffuse light too; needs a light */
    uint32_t cones; /**< of the light, for the radiance of texels: 1, 5, 6, 16 or 64; 0 means 16 */
    svo_light *light; /**< of the same tree; NULL: no radiance. Scenes have none */
    /** What probes see, of which one is given: a complete tree on a device, or a scene, where its instances are now. It
     *  must outlive the probes. With SVO_NEED_RAYS, coverage half-open or closed, they see its triangles, else its
     *  voxels. */
    svo_tree *tree;
    svo_scene *scene; /**< in place of tree */
} svo_probe_options;

/** All defaults, but for tree or scene. */
#define SVO_PROBE_OPTIONS_INIT SVO_STRUCT_INIT(svo_probe_options)

/** The buffers of probes. The index of a probe is x + counts[0] * (y + counts[1] * z). */
typedef enum svo_probes_buffer {
    SVO_PROBES_PLACES = 0, /**< "places": svo_probe, one each */
    SVO_PROBES_TEXELS, /**< "texels": two u32, (probe * R + row) * R + column */
    /** "least": u16, the least distance of 16 x 16 texels, (probe * R / 16 + row) * R / 16 + column */
    SVO_PROBES_LEAST,
    /** "field": four u16, x + n * (y + n * z): the nearest probes that see the cell's center, by distance and index */
    SVO_PROBES_FIELD,
    SVO_PROBES_IRRADIANCE, /**< "irradiance": u32 as word 1 of a texel, (probe * 8 + row) * 8 + column; with diffuse */
    /** "moments": two f32, mean distance in leaf edges and mean square of it, (probe * 16 + row) * 16 + column; with
     *  diffuse. What sees nothing counts as the farthest distance. */
    SVO_PROBES_MOMENTS,
    SVO_PROBES_BUFFER_COUNT /**< number of buffers */
} svo_probes_buffer;

/** The stages of probes, for times. */
typedef enum svo_probes_stage {
    SVO_PROBES_STAGE_PLACE = 0, /**< "placing": moving and switching off */
    SVO_PROBES_STAGE_TEXELS, /**< "texels": rays to distances and normals */
    SVO_PROBES_STAGE_RADIANCE, /**< "radiance": of the light */
    SVO_PROBES_STAGE_LEAST, /**< "least": least distances */
    SVO_PROBES_STAGE_FIELD, /**< "field": which probes see a cell */
    SVO_PROBES_STAGE_FILTER, /**< "prefilter": irradiance and moments */
    SVO_PROBES_STAGE_COUNT /**< number of stages */
} svo_probes_stage;

/** What probes are. */
typedef struct svo_probe_info {
    size_t struct_size; /**< sizeof(svo_probe_info) */
    uint32_t counts[3]; /**< along x, y and z */
    uint32_t resolution; /**< texels along a side of a probe's map */
    float start[3]; /**< of the first probe, world, before it was moved */
    float step[3]; /**< between probes, world units */
    float low[3]; /**< least corner of the tree's grid or the scene's box, which the field spans */
    float high[3]; /**< its greatest corner */
    float leaf_edge; /**< 1 / C, world units: of a scene, the smallest of its instances */
    float farthest; /**< F, world units: from a probe to a corner of the box, at least the box's diagonal */
    uint32_t probe_count; /**< counts[0] * counts[1] * counts[2] */
    uint32_t moved; /**< of those; 0 in a plan */
    uint32_t off; /**< of those, switched off; 0 in a plan */
    uint32_t field_size; /**< cells of the field along an axis */
    uint64_t rays; /**< of texels: one each, without those of probes that are off. In a plan: of all */
    uint64_t place_rays; /**< of the search for places. In a plan: the most */
    uint64_t bytes[SVO_PROBES_BUFFER_COUNT]; /**< of each buffer; 0: not held */
    uint64_t total_bytes; /**< of all buffers */
    uint64_t scratch_bytes; /**< what making them takes besides; it is released */
    double stage_ms[SVO_PROBES_STAGE_COUNT]; /**< of the last run of each stage; 0: it did not run */
} svo_probe_info;

/** An empty output. */
#define SVO_PROBE_INFO_INIT SVO_STRUCT_INIT(svo_probe_info)

/* ---- making ---- */

/** Says what svo_probes_create would make, before anything is compiled or allocated.
 *
 * \param options with a tree or a scene
 * \param info receives places, resolution, bytes and rays
 * \returns SVO_INVALID_ARGUMENT when an option is out of its range, when there is not one of tree and scene, or when
 *          the texels take more than max_bytes. */
SVO_API svo_status svo_probes_plan(const svo_probe_options *options, svo_probe_info *info);

/** Makes probes and waits for them.
 *
 * \param options with a tree or a scene
 * \param queue on the context of the device of tree or scene; NULL: the device's own
 * \param out receives the probes
 * \returns SVO_INVALID_ARGUMENT, SVO_UNSUPPORTED (the grid is beyond the range of floats), SVO_OUT_OF_HOST_MEMORY,
 *          SVO_OUT_OF_DEVICE_MEMORY, SVO_COMPILE_FAILED or SVO_CL_ERROR on failure. */
SVO_API svo_status svo_probes_create(const svo_probe_options *options, cl_command_queue queue, svo_probes **out);

/** Makes radiance, and irradiance with svo_probe_options.diffuse, anew from the light as it is now. Places, distances,
 *  normals and the field stay. After a failed call the radiance is undefined.
 *
 * \param probes with a light
 * \param queue on the context of their device; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT (no light), or what svo_probes_create returns, on failure. */
SVO_API svo_status svo_probes_relight(svo_probes *probes, cl_command_queue queue);

/** Destroys probes.
 *
 * \param probes set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_probes_destroy(svo_probes **probes);

/* ---- what they hold ---- */

/** Describes probes.
 *
 * \param probes not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_probes_get_info(const svo_probes *probes, svo_probe_info *info);

/** A device buffer of the probes.
 *
 * \param probes not NULL
 * \param buffer which one
 * \returns the buffer, which belongs to the probes; NULL where it is not held. */
SVO_API cl_mem svo_probes_get_buffer(const svo_probes *probes, svo_probes_buffer buffer);

/** Hashes what probes store with XXH3-128: u32 counts[3], resolution, field_size; f32 start[3], step[3], low[3],
 *  high[3], leaf_edge, farthest; then each buffer in the order of svo_probes_buffer, its length in bytes as u64 before
 *  its elements; length 0 where it is not held. Little-endian, seed 0. Without a light the hash does not depend on
 *  device or time.
 *
 * \param probes not NULL
 * \param queue on the context of their device; NULL: the device's own
 * \param text receives 32 lowercase hexadecimal digits, the high half first
 * \returns SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_probes_hash(const svo_probes *probes, cl_command_queue queue, char text[SVO_HASH_TEXT_BYTES]);

/** The direction of a texel's center.
 *
 * \param resolution of the probe's map
 * \param column below resolution
 * \param row below resolution
 * \param direction receives a unit vector */
SVO_API void svo_probe_direction(uint32_t resolution, uint32_t column, uint32_t row, float direction[3]);

/** The texel whose square of directions a direction is in.
 *
 * \param resolution of the probe's map
 * \param direction any length above 0
 * \param column receives the texel's column
 * \param row receives its row */
SVO_API void svo_probe_texel(uint32_t resolution, const float direction[3], uint32_t *column, uint32_t *row);

/** The distance of a code.
 *
 * \param info of the probes
 * \param code 0 .. 65534
 * \returns world units; infinity for SVO_PROBE_NOTHING. */
SVO_API double svo_probe_distance(const svo_probe_info *info, uint32_t code);

/** The normal of a texel.
 *
 * \param word word 0 of the texel, or svo_probe_hit.normal
 * \param normal receives a unit vector */
SVO_API void svo_probe_normal(uint32_t word, float normal[3]);

/** The radiance of a texel.
 *
 * \param word word 1 of the texel, or an element of SVO_PROBES_IRRADIANCE
 * \param radiance receives red, green, blue */
SVO_API void svo_probe_radiance(uint32_t word, float radiance[3]);

/* ---- rays through probes ---- */

/** Options of rays through probes. */
typedef struct svo_probe_trace_options {
    size_t struct_size; /**< sizeof(svo_probe_trace_options) */
    float thickness; /**< factor to how far behind their points surfaces hold, above 0; 0 means 1 */
} svo_probe_trace_options;

/** All defaults. */
#define SVO_PROBE_TRACE_OPTIONS_INIT SVO_STRUCT_INIT(svo_probe_trace_options)

/** Traces rays through probes. Computed in single precision. What a ray begins on is told from what is behind that by
 *  height: rays from a surface should begin between a fiftieth of a leaf's edge and half of one above it.
 *
 * \param probes not NULL
 * \param rays ray_count records of svo_ray; all zero allowed when that is 0
 * \param hits receives a record of svo_probe_hit for each ray, in their order
 * \param ray_count at most SVO_TRACE_RAYS_MAX
 * \param options NULL means all defaults
 * \param submit NULL: the device's own queue, and the call waits
 * \returns SVO_INVALID_ARGUMENT, SVO_COMPILE_FAILED, SVO_CL_ERROR or SVO_OUT_OF_DEVICE_MEMORY on failure. */
SVO_API svo_status svo_probes_trace(svo_probes *probes, svo_array rays, svo_array hits, size_t ray_count,
                                    const svo_probe_trace_options *options, const svo_submit *submit);

/** Diffuse light at points, from the prefiltered maps of the probes around them.
 *
 * \param probes with svo_probe_options.diffuse
 * \param points point_count records of svo_gather_point, of which position and normal count; all zero allowed when
 *        that is 0
 * \param results receives a record of svo_probe_irradiance for each point, in their order
 * \param point_count at most SVO_TRACE_RAYS_MAX
 * \param submit NULL: the device's own queue, and the call waits
 * \returns what svo_probes_trace returns. */
SVO_API svo_status svo_probes_irradiance(svo_probes *probes, svo_array points, svo_array results, size_t point_count,
                                         const svo_submit *submit);

/** Number of kernel arguments that SVO_PROBES_PARAMETERS declares. */
#define SVO_PROBES_ARGUMENTS 8u

/** Probes as a target: kernels of the caller's. svo_kernel_source declares
 *
 *     SVO_PROBES_PARAMETERS    among a kernel's parameters, SVO_PROBES_ARGUMENTS of them
 *     SVO_PROBES_MAKE(probes)    an svo_probes from these parameters
 *     svo_ray, svo_probe_hit, svo_probe_irradiance    as in ray_types.h and probe_types.h
 *     uint svo_trace_probes(const svo_probes *, const svo_ray *, float thickness, svo_probe_hit *)
 *         the hit's state; thickness: a factor, 1 by default
 *     svo_probe_irradiance svo_gather_probes(const svo_probes *, float3 position, float3 normal)
 *
 * svo_kernel_options has one more where the light of the probes had a map of its sky when it was taken.
 *
 * \param probes NULL: calls are refused, but svo_kernel_source and svo_kernel_options answer
 * \returns the target. */
SVO_API svo_target svo_probes_target(svo_probes *probes);

#ifdef __cplusplus
}
#endif

#endif
