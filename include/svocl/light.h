/* SPDX-License-Identifier: MIT */
/** \file
 * Light in a tree: ambient occlusion, indirect light and reflections, at points and in pictures. By paths of exact
 * rays, or by voxel cone tracing (after Crassin et al., "Interactive Indirect Illumination Using Voxel Cone Tracing",
 * 2011): opacity on all levels, photons from light sources into the leaves, filtered upwards, and cones that gather
 * both.
 *
 * A light is made of a built tree and refers to it; the tree must outlive it and stay as it is. Opacity is made once;
 * svo_light_set_sources reruns the stages of the sources alone, and svo_light_update makes the light of a changed
 * tree. What is stored is integers, the same bytes on every device and run. What is gathered is single-precision, the
 * same on every run, and within 1e-4 between devices; unless rounding sends a path past the other side of an edge,
 * which changes a point by that path's share.
 *
 * Forms. SVO_LIGHT_FACES: six opacities and radiances a node, for rays along +x, -x, +y, -y, +z, -z, interpolated
 * between the eight nodes around a point; walls let little light through, whatever the width of the cone.
 * SVO_LIGHT_BRICKS: 27 samples for an inner node, at the corners of its children, without direction; the quickest.
 * SVO_LIGHT_VOXELS: one opacity and radiance a node, without interpolation; the smallest. Both let light through walls
 * that are thin beside a cone: a closed room of 64 voxels is open to seven tenths and more.
 *
 * Thread-safety: several threads may call functions that take a const svo_light. All others need exclusive use of it
 * and of its device handle.
 */
#ifndef SVOCL_LIGHT_H
#define SVOCL_LIGHT_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/device.h"
#include "svocl/light_types.h"
#include "svocl/mesh.h"
#include "svocl/nodes.h"
#include "svocl/trace.h"
#include "svocl/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The light of a tree. */
typedef struct svo_light svo_light;

/** How a light stores opacity and radiance. */
typedef enum svo_light_form {
    SVO_LIGHT_FACES = 0, /**< "faces": six directions a node */
    SVO_LIGHT_BRICKS = 1, /**< "bricks": 27 samples an inner node */
    SVO_LIGHT_VOXELS = 2, /**< "voxels": one value a node */
    SVO_LIGHT_FORM_COUNT /**< number of forms */
} svo_light_form;

/** How opaque a leaf is. */
typedef enum svo_opacity {
    SVO_OPACITY_AREA = 0, /**< alpha times min(1, projected area), by direction; full for trees without areas */
    SVO_OPACITY_FULL = 1 /**< alpha */
} svo_opacity;

/** Options of a light. */
typedef struct svo_light_options {
    size_t struct_size; /**< sizeof(svo_light_options) */
    svo_light_form form; /**< how to store it */
    svo_opacity opacity; /**< how opaque leaves are */
    uint32_t one_side; /**< not 0: surface of a closed mesh holds back rays that meet its front alone, by the winding of
                            its triangles; else both sides do, as they do for photons and rays. Open meshes have both
                            sides in any case, and so has SVO_OPACITY_FULL */
    uint32_t no_cones; /**< not 0: nothing is stored and no photons leave, since rays alone gather; cones are refused */
} svo_light_options;

/** All defaults. */
#define SVO_LIGHT_OPTIONS_INIT SVO_STRUCT_INIT(svo_light_options)

/** The buffers of a light. */
typedef enum svo_light_buffer {
    SVO_LIGHT_OPACITY = 0, /**< "opacity": as the form has it */
    SVO_LIGHT_COVER, /**< "cover": projected areas of nodes; SVO_LIGHT_FACES */
    SVO_LIGHT_LIT, /**< "lit": the place of each node's radiance, or SVO_NO_NODE */
    SVO_LIGHT_RADIANCE, /**< "radiance": as the form has it */
    SVO_LIGHT_FLUX, /**< "flux": sums of photons of the lit leaves */
    SVO_LIGHT_BUFFER_COUNT /**< number of buffers */
} svo_light_buffer;

/** The stages of a light, for times. */
typedef enum svo_light_stage {
    SVO_LIGHT_STAGE_OPACITY = 0, /**< "opacity": of the leaves and up to the deepest filtered level */
    SVO_LIGHT_STAGE_OPACITY_FILTER, /**< "opacity filter": the levels above */
    SVO_LIGHT_STAGE_VIEW, /**< "light view": rays from the sources */
    SVO_LIGHT_STAGE_PHOTONS, /**< "photons": from hits to the sums of leaves */
    SVO_LIGHT_STAGE_EXCHANGE, /**< "exchange": from sums to the radiance of leaves */
    SVO_LIGHT_STAGE_FILTER, /**< "radiance filter": the levels above */
    SVO_LIGHT_STAGE_COUNT /**< number of stages */
} svo_light_stage;

/** What a light holds. */
typedef struct svo_light_info {
    size_t struct_size; /**< sizeof(svo_light_info) */
    svo_light_form form; /**< how it is stored */
    svo_opacity opacity; /**< SVO_OPACITY_FULL where the tree holds no areas */
    uint64_t photons; /**< rays from the sources and from what emits */
    uint64_t photon_hits; /**< of those, that met the tree */
    uint64_t lit_leaves; /**< leaves with light: photons or emission */
    uint64_t lit_nodes; /**< of all levels */
    uint64_t missed_leaves; /**< leaves without a photon, although they are what a ray from a source to their center
                                 meets first; 0 without svo_light_setup.diagnose */
    double flux[3]; /**< of all photons that hit: red, green, blue, world units; with bounces each time that they do */
    double lost_flux; /**< share of it that found no leaf */
    uint64_t bytes[SVO_LIGHT_BUFFER_COUNT]; /**< of each buffer; 0: not held */
    uint64_t total_bytes; /**< of all buffers */
    uint64_t scratch_bytes; /**< the most that svo_light_create and since then svo_light_set_sources, from the light
                                 views to the radiance filter, took besides at a time; it is released */
    double stage_ms[SVO_LIGHT_STAGE_COUNT]; /**< of the last run of each stage; 0: it did not run */
    uint64_t traced_photons; /**< of photons, those whose rays were traced by the newest call */
    uint64_t kept_bytes; /**< held for svo_light_update, besides total_bytes */
    uint64_t emitter_bytes; /**< held for rays that aim at triangles that emit, from the first rays on that
                                 gather light; besides total_bytes */
    uint64_t sky_bytes; /**< held for the map of the sky, its means and, where it is bright in places, the shares by
                             which paths aim at it; besides total_bytes */
    uint64_t mesh_bytes; /**< held for the mesh of svo_light_set_mesh; besides total_bytes */
    uint64_t sent_photons; /**< rays of photons that surfaces sent on: svo_light_setup.bounces */
} svo_light_info;

/** An empty output. */
#define SVO_LIGHT_INFO_INIT SVO_STRUCT_INIT(svo_light_info)

/** Says what svo_light_create would make, before anything is compiled or allocated. Buffers of sources are 0: their
 *  sizes follow from the photons.
 *
 * \param tree complete
 * \param options NULL means all defaults
 * \param info receives form, opacity and bytes
 * \returns SVO_INVALID_ARGUMENT when an option is out of its range. */
SVO_API svo_status svo_light_plan(const svo_tree *tree, const svo_light_options *options, svo_light_info *info);

/** Makes the opacity of a tree and waits for it; without cones there is nothing to make. There is no light yet but the
 *  sky's, which is 0.
 *
 * \param tree on a device; must outlive the light. Colors give alpha and albedo (absent: opaque, albedo 0.6), normals
 *        and areas (SVO_NEED_PROJECTED_AREA) make cones exact; payload from level 0
 * \param options NULL means all defaults
 * \param queue on the context of the tree's device; NULL: the device's own
 * \param out receives the light
 * \returns SVO_INVALID_ARGUMENT, SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY, SVO_COMPILE_FAILED or SVO_CL_ERROR
 *          on failure. */
SVO_API svo_status svo_light_create(svo_tree *tree, const svo_light_options *options, cl_command_queue queue,
                                    svo_light **out);

/** Destroys a light.
 *
 * \param light set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_light_destroy(svo_light **light);

/** Describes a light.
 *
 * \param light not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_light_get_info(const svo_light *light, svo_light_info *info);

/** A device buffer of the light.
 *
 * \param light not NULL
 * \param buffer which one
 * \returns the buffer, which belongs to the light; NULL where it is not held. */
SVO_API cl_mem svo_light_get_buffer(const svo_light *light, svo_light_buffer buffer);

/** Hashes what a light stores with XXH3-128: u32 form, opacity, depth; f32 the radiance of a unit of
 *  SVO_LIGHT_RADIANCE, 0 without light; then each buffer in the order of svo_light_buffer, its length in bytes as u64
 *  before its elements; length 0 where it is not held. Little-endian, seed 0. The hash does not depend on device or
 *  time.
 *
 * \param light not NULL
 * \param queue on the context of its device; NULL: the device's own
 * \param text receives 32 lowercase hexadecimal digits, the high half first
 * \returns SVO_CL_ERROR or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_light_hash(const svo_light *light, cl_command_queue queue, char text[SVO_HASH_TEXT_BYTES]);

#define SVO_EMISSION_PHOTONS_MAX (1u << 30) /**< the most of svo_light_setup.emission_photons */
#define SVO_LIGHT_BOUNCES_MAX    64u /**< the most of svo_light_setup.bounces */
#define SVO_SKY_WIDTH_MAX        8192u /**< the most columns of svo_light_setup.sky_map */
#define SVO_SKY_HEIGHT_MAX       4096u /**< the most rows of svo_light_setup.sky_map */

/** What lights a tree. Arrays are borrowed for the call. */
typedef struct svo_light_setup {
    size_t struct_size; /**< sizeof(svo_light_setup) */
    const svo_light_source *sources; /**< source_count; NULL when that is 0 */
    size_t source_count; /**< at most 1024 */
    const svo_finish *finishes; /**< finish_count: by material index, for trees with materials; NULL when that is 0 */
    size_t finish_count; /**< at most 65535; materials beyond are diffuse and do not emit */
    float sky[3]; /**< radiance from outside: linear red, green, blue, not negative */
    uint32_t view_resolution; /**< photons along a side of each light's view, 1 .. 16384; 0: four per facing leaf */
    uint32_t diagnose; /**< not 0: counts missed_leaves too, by one more ray a leaf and source */
    uint32_t no_photons; /**< not 0: no photons leave the sources: surfaces have their direct light, and others' by rays
                              but not by cones */
    uint32_t updatable; /**< not 0: photons are kept for svo_light_update, in about 36 bytes each, 280 a lit leaf and
                              17 an inner node */
    /** Radiance from outside by direction, on top of sky: sky_height rows of sky_width texels of linear red, green,
     *  blue, not negative. Equirectangular, as someone sees it who stands inside: the first row is around the zenith,
     *  +y, the last one around -y; columns go to the right all around, with -z in the middle of the row and +x at
     *  three quarters. Between the centers of texels it is linear. Cones see its means, and rays of paths aim at what
     *  is bright in it. NULL: there is none. */
    const float *sky_map;
    uint32_t sky_width; /**< 1 .. SVO_SKY_WIDTH_MAX; 0 without a map */
    uint32_t sky_height; /**< 1 .. SVO_SKY_HEIGHT_MAX; 0 without a map */
    /** So many photons leave the triangles in leaves whose finish emits, so that cones have what surfaces reflect of
     *  emission; a power of two is spread best, at most SVO_EMISSION_PHOTONS_MAX. Each has the same share of the power,
     *  pi times emission, area and alpha on both sides. 0: cones see emission itself, and nothing that it lights. Trees
     *  without triangles or materials shoot none. svo_light_info.scratch_bytes has what it takes: 76 bytes a piece of
     *  a triangle in a leaf, and 36 a photon of 262,144 at a time. */
    uint32_t emission_photons;
    /** So often do surfaces reflect the light of photons for cones, at most, 1 .. SVO_LIGHT_BOUNCES_MAX; 0 means 1.
     *  From 2 on a photon goes on from what it met, with what the albedo of the leaf leaves of its flux, until less
     *  than 2^-12 of the brightest photon's is left. */
    uint32_t bounces;
    uint32_t photon_alpha; /**< not 0: photons go through what shows in part, as rays to sources do: of those that meet
                                triangles in a leaf, or its voxel in trees without triangles, its alpha's share stops
                                there. Else what photons meet stops them whole, as it stops those that OpenGL casts from
                                sources in any case */
} svo_light_setup;

/** No light. */
#define SVO_LIGHT_SETUP_INIT SVO_STRUCT_INIT(svo_light_setup)

/** Lights a tree: shoots photons by the tree's exact rays, sums them in the leaves, and filters radiance upwards, where
 *  it is lit; without cones it keeps what shines. Replaces the light of earlier calls; a failed call leaves it dark.
 *
 * Trees without SVO_NEED_RAYS, or of coverage thin, are lit by rays against their voxels, in single precision. Their
 * light is the same on every run of a device; others' is the same on every device with cl_khr_fp64.
 *
 * \param light not NULL
 * \param setup sources, finishes and sky
 * \param queue on the context of its device; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT (a value that is not finite or negative, a zero direction, angles, counts),
 *          SVO_UNSUPPORTED, SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY, SVO_COMPILE_FAILED or SVO_CL_ERROR on
 *          failure. */
SVO_API svo_status svo_light_set_sources(svo_light *light, const svo_light_setup *setup, cl_command_queue queue);

/** Gives a light the mesh that its tree was made of, in place of an earlier one. Pictures then have its textures,
 *  vertex colors, materials, vertex normals and normal maps at the points that the camera sees; far away, where rays
 *  are wider than leaves, the payload of the leaf as without a mesh. Textures have levels of half the size each, which
 *  take a third more. All rays of light go through what shows in part by the alpha of the mesh at the point. Where the
 *  mesh has materials or vertex colors, paths find these, too, where they meet it: what surfaces reflect and emit then
 *  has no error of the leaves that several of them share. Photons and cones have the colors of leaves as before.
 *
 * The light of later sources has the mesh, too; svo_light_update takes it away, since triangles may have changed.
 *
 * \param light not NULL; its tree has SVO_NEED_RAYS
 * \param mesh of as many triangles as the tree was made of, in their order; read during the call. Finishes are those of
 *        svo_light_setup. NULL: none from now on
 * \param queue on the context of the light's device; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT (a mesh that svo_plan_create would refuse, another number of triangles, a tree without
 *          rays), SVO_OUT_OF_HOST_MEMORY, SVO_OUT_OF_DEVICE_MEMORY or SVO_CL_ERROR on failure: the light then has no
 *          mesh. */
SVO_API svo_status svo_light_set_mesh(svo_light *light, const svo_mesh *mesh, cl_command_queue queue);

/** The most boxes of svo_light_update. */
#define SVO_LIGHT_BOXES_MAX 1048576u

/** Makes the light that of another tree, in place of the one before: its opacity, and the light of the sources that the
 *  light has. What is stored is, byte for byte, what svo_light_create and svo_light_set_sources make of the tree.
 *
 * With svo_light_setup.updatable, photons are shot again only where rays cross a box before they hit, or hit beside
 * one; of the others flux and leaves are kept. All are shot where the grid or the bounds of the leaves have changed,
 * since views follow from them, where the kind of payload has, and with diagnose, without leaf lists, or after sources
 * that OpenGL saw. The radiance of leaves is made where photons came or went, and in the boxes. From the second update
 * on, opacity is made of nodes that a box touches, and radiance of nodes above such leaves.
 *
 * The tree before is not read and may be gone, as after svo_moving_update. After a failure the light is still that of
 * the tree before, and the next update shoots all photons.
 *
 * \param light not NULL. Its buffers are new after a success
 * \param tree on the device of the light; must outlive the light from now on
 * \param changed change_count boxes that hold all triangles that have come, gone or moved since the tree before, where
 *        they were and where they are: svo_moving_get_changes has them. A box that is missing makes the light
 *        undefined, or fails. Numbers of other triangles may have changed, but not their order. The trees weigh
 *        payload alike (svo_plan_options.weight_log2), as those of a scene that moves do; and where their projected
 *        areas are those of a closed mesh and of an open one, a box is around all leaves. NULL when that is 0
 * \param change_count at most SVO_LIGHT_BOXES_MAX
 * \param queue on the context of its device; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT (a box that is not finite or empty, a tree of another device, lit leaves that went
 *          outside the boxes), or what svo_light_create and svo_light_set_sources return. */
SVO_API svo_status svo_light_update(svo_light *light, svo_tree *tree, const svo_box *changed, size_t change_count,
                                    cl_command_queue queue);

/* ---- light at points ---- */

/** How light is gathered. */
typedef enum svo_gather_method {
    SVO_GATHER_AUTO = 0, /**< "auto": cones where options name their number or step, else rays */
    SVO_GATHER_CONES = 1, /**< "cones": blurred by the width of the cones, without noise; openings narrower than a cone
                               are darker than they are, and one reflection of the sources counts */
    SVO_GATHER_RAYS = 2, /**< "rays": paths of exact rays; noise alone, which their number lessens */
    SVO_GATHER_METHOD_COUNT /**< number of methods */
} svo_gather_method;

/** Options of gathering. */
typedef struct svo_gather_options {
    size_t struct_size; /**< sizeof(svo_gather_options) */
    uint32_t cones; /**< 1, 5, 6, 16 or 64; 0 means 16 */
    float step; /**< of a cone, in its widths: 0.25 .. 1; 0 means 0.5 */
    float range; /**< world units that occlusion reaches, above 0; 0: to the end of the grid. Light has no range by
                      rays; cones end there */
    float falloff; /**< lambda of the occlusion's weight 1 / (1 + lambda t), per world unit, not negative */
    uint32_t no_light; /**< not 0: ambient occlusion alone; all light is 0 */
    svo_gather_method method; /**< how */
    uint32_t paths; /**< paths of a point, at most: a power of two, 16 .. 65536; 0 means 64. In pictures
                         paths of 2 x 2 pixels, which are smoothed over surfaces; 0 means 16 */
    uint32_t bounces; /**< rays of a path, at most, 1 .. 64: so often are sources reflected; 0 means 1, in
                           pictures 3 */
    float error; /**< a point has paths enough when the standard error of its openness is at most this, and that of its
                      irradiance as a share of it; not negative; 0: it has all */
} svo_gather_options;

/** All defaults. */
#define SVO_GATHER_OPTIONS_INIT SVO_STRUCT_INIT(svo_gather_options)

/** Gathers ambient occlusion, irradiance and specular radiance at points, and the direct light of the sources, which is
 *  not part of irradiance: that is what surfaces reflect and emit, and the sky.
 *
 * Rays meet what the tree's exact rays meet: triangles, else voxels. What they meet has the color of its leaf, or
 * that of the mesh which svo_light_set_mesh gave, and reflects on the side that is met; emission, as finishes have it,
 * leaves both sides. Directions follow from the bits of a point's position and normal alone, so that results do not
 * depend on what else is in a call. A fourth of paths more, 16 at least, samples the lobe around the reflected
 * direction, if there is one. Where materials of triangles emit, a ray more aims at one of them wherever a path goes
 * on, which leaves the mean as it is and lessens the noise.
 *
 * Points outside the grid, by more than half a voxel, and points whose normal is zero or not finite get openness 1 and
 * no light.
 *
 * \param light not NULL
 * \param points point_count records of svo_gather_point; all zero allowed when that is 0
 * \param results receives a record of svo_gather_result for each point, in their order
 * \param point_count at most SVO_TRACE_RAYS_MAX
 * \param options NULL means all defaults
 * \param submit NULL: the device's own queue, and the call waits
 * \returns SVO_INVALID_ARGUMENT (also numbers of paths for cones, or of cones for rays), SVO_UNSUPPORTED (the grid is
 *          beyond the range of floats), SVO_COMPILE_FAILED, SVO_CL_ERROR or SVO_OUT_OF_DEVICE_MEMORY on failure. */
SVO_API svo_status svo_gather(svo_light *light, svo_array points, svo_array results, size_t point_count,
                              const svo_gather_options *options, const svo_submit *submit);

/* ---- pictures, and kernels of the caller's ---- */

#define SVO_LIGHT_BAND_ROWS 16u /**< bands of a picture have multiples of so many rows */

/** Number of kernel arguments that SVO_LIGHT_PARAMETERS declares. */
#define SVO_LIGHT_ARGUMENTS 10u

/** A light as a target: svo_render, svo_camera_fit and kernels of the caller's.
 *
 * Its pictures show a lit tree: first hits, shadows, openness, indirect and specular light by exact rays; where
 * svo_render_options.gather says so, by cones. Sources, finishes and sky are those of svo_light_set_sources. Trees
 * without triangles show their voxels. SVO_VIEW_SHADED has direct, indirect and specular light and emission on the
 * surfaces' colors.
 *
 * Light is linear. Up to a half, radiance times exposure is the share of white that a pixel shows; above, highlights
 * roll off as 1 - exp(1 - 2 radiance) / 2. Openness is shown as it is. Shares are coded by the sRGB curve.
 *
 * svo_kernel_source, for cones, which the light then must have (svo_light_options.no_cones), declares
 *
 *     SVO_LIGHT_PARAMETERS    among a kernel's parameters, SVO_LIGHT_ARGUMENTS of them
 *     SVO_LIGHT_MAKE(light)    an svo_light from these parameters
 *     svo_gather_point, svo_gather_result    as in light_types.h
 *     svo_cone    origin and unit direction in world coordinates, tangent of the half angle, start and range in world
 *                 units, step in widths, falloff, and the unit normal of the surface that the origin lies on (zero:
 *                 none): the apex is then two voxels above it, and samples do not reach down to it
 *     svo_cone_result svo_trace_cone(const svo_light *, const svo_cone *)    occlusion, what passes, radiance, steps
 *     svo_gather_result svo_gather(const svo_light *, const svo_gather_point *, uint cones, float step, float range,
 *                                  float falloff)
 *
 * svo_kernel_options are those of a tree, one that selects the light's form, and one that reads the map of its sky: a
 * kernel that was compiled while the light had no map does not see a later one.
 *
 * \param light NULL: calls are refused, but svo_kernel_source answers. The light and its tree stay as they are until
 *        pictures are drawn
 * \returns the target. */
SVO_API svo_target svo_light_target(svo_light *light);

#ifdef __cplusplus
}
#endif

#endif
