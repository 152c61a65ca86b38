/* SPDX-License-Identifier: MIT */
/* shared/layout.h for light: constants and records of opacity, photons, radiance, cones and pictures of them. */
#ifndef SVO_KERNELS_SHARED_LIGHT_LAYOUT_H
#define SVO_KERNELS_SHARED_LIGHT_LAYOUT_H

#include "shared/layout.h"
#include "svocl/light_types.h"

/* Extinctions are in units of 2^-12 octaves: 4096 halves what passes. */
#define SVO_EXTINCTION_UNIT 4096
/* A projected area as large as a face of its node. */
#define SVO_AREA_UNIT 4096u
/* Samples of a brick, and the most levels from the root to a leaf. */
#define SVO_BRICK_SAMPLES 27
#define SVO_LIGHT_LEVELS  17
/* The cells in and around the node of a brick, the points in and around these, and a group's words for both. */
#define SVO_BRICK_CELL_COUNT  64
#define SVO_BRICK_POINT_COUNT 343
#define SVO_BRICK_ROOM_WORDS  (SVO_BRICK_CELL_COUNT + SVO_BRICK_POINT_COUNT)

/* Of the flags below. */
#define SVO_LIGHT_FLAG_NORMALS    1u /* the tree has normals */
#define SVO_LIGHT_FLAG_ONE_NORMAL 2u /* one for all nodes */
#define SVO_LIGHT_FLAG_LIT        4u /* there is radiance */
#define SVO_LIGHT_FLAG_COLORS     8u /* the tree has colors */
#define SVO_LIGHT_FLAG_ONE_COLOR  16u /* one for all nodes */
#define SVO_LIGHT_FLAG_ONE_SIDE   32u /* areas count for rays that meet the front alone */

/* What cones know of a light besides its buffers. 32 bytes. */
SVO_RECORD(svo_light_params)
{
    SVO_U32 depth; /* 0 */
    SVO_U32 flags; /* 4: SVO_LIGHT_FLAG_* */
    SVO_F32 unit; /* 8: radiance of a unit of the radiance buffer, a power of two */
    SVO_F32 voxel_edge; /* 12: of a leaf, world units */
    SVO_F32 sky[3]; /* 16: radiance from outside */
    SVO_U32 sky_size; /* 28: of the map on top of it: width, and from bit 16 on height, texels; 0: none */
};

/* How cones gather. 32 bytes. */
SVO_RECORD(svo_gather_params)
{
    SVO_U32 cones; /* 0: 1, 5, 6, 16 or 64 */
    SVO_F32 step; /* 4: widths of the cone */
    SVO_F32 range; /* 8: world units; 0: to the end of the grid */
    SVO_F32 falloff; /* 12: lambda, per world unit */
    SVO_U32 with_light; /* 16: 0: occlusion alone */
    SVO_U32 paths; /* 20: the most paths of a point, a power of two, at least 16; 0: cones */
    SVO_U32 bounces; /* 24: the most rays of a path */
    SVO_F32 goal; /* 28: the error at which a point has enough paths; 0: none */
};

/* Arguments of the kernels that make and filter light. 32 bytes. */
SVO_RECORD(svo_light_step)
{
    SVO_U32 depth; /* 0 */
    SVO_U32 leaf_begin; /* 4: the first leaf */
    SVO_U32 first; /* 8: node of the launch */
    SVO_U32 count; /* 12: nodes of the launch */
    SVO_U32 level; /* 16: of those nodes */
    SVO_U32 flags; /* 20: SVO_LIGHT_FLAG_* */
    SVO_U32 elements; /* 24: of what is copied, in a node; else 0 */
    SVO_U32 box_count; /* 28: that a tree has changed in; else 0 */
};

/* A photon's leaf: it met nothing; it met a triangle of which no leaf is near. */
#define SVO_PHOTON_MISSED 0xffffffffu
#define SVO_PHOTON_LOST   0xfffffffeu
/* The slot of a leaf that has none. */
#define SVO_SLOT_NONE 0xffffffffu
/* What is known of the radiance of a slot: the bits of the largest value, before it gets its unit, and flags: it is to
   be made anew; it has been. */
#define SVO_SLOT_BITS  0xffu
#define SVO_SLOT_STALE 0x80000000u
#define SVO_SLOT_FRESH 0x40000000u

/* Sums of a lit leaf, of 64 bits each: flux red, green, blue; all flux times the direction of its photons, 2^24 = 1 on
   x, y, z; and, where radiance has directions, the flux of each channel times the cosine for each of the six
   directions, three channels a direction. */
#define SVO_FLUX_SUMS          6
#define SVO_FACE_SUMS          18
#define SVO_FLUX_UNIT_LOG2     24 /* of a direction's component */
#define SVO_COSINE_UNIT_LOG2   16 /* of a normal's component */
#define SVO_WEIGHT_UNIT_LOG2   31 /* of svo_photon_weight */
#define SVO_FLUX_TOTAL_LOG2    50 /* all photons together have less flux, so that no sum overflows */
#define SVO_RADIANCE_MOST_LOG2 30 /* radiance from photons and emission are at most this each */
#define SVO_TILE_PIXELS_LOG2   3 /* photons come in square tiles of pixels, in Morton order inside */
#define SVO_ITEM_PHOTONS       4 /* of a work-item: two by two pixels */
#define SVO_SPREAD_CELLS       8 /* that the photons of a work-item reach at most */
#define SVO_SPREAD_PARTS       15 /* of a photon: each goes to a leaf */

/* What photons count. */
#define SVO_PHOTON_SLOTS      0 /* slots that have been claimed */
#define SVO_PHOTON_HITS       1
#define SVO_PHOTON_UNMET      2 /* leaves that should have met one */
#define SVO_PHOTON_BITS       3 /* of the largest radiance, before it gets its unit */
#define SVO_PHOTON_NO_LEAF    4 /* lost flux: red, green, blue, 64 bits each */
#define SVO_PHOTON_IN_LEAF    10 /* the flux of the lit leaves, likewise */
#define SVO_PHOTON_TAKEN      16 /* hits that are taken back */
#define SVO_PHOTON_FREE       17 /* slots without photons, whose numbers follow the counters */
#define SVO_PHOTON_FIRST_SLOT 18 /* of those that are claimed when no slot is free any more */
#define SVO_PHOTON_GONE       19 /* slots whose leaves are gone, although photons of theirs stay: 0 */
#define SVO_PHOTON_THROUGH    20 /* photons that go through what they met */
#define SVO_PHOTON_ON         21 /* photons that surfaces have sent on */
#define SVO_PHOTON_COUNTERS   22

/* What becomes of photons that met something: svo_photon_params.spreads. */
#define SVO_SPREAD_NOTHING 0u /* their leaves are told, and get no slots */
#define SVO_SPREAD_VIEW    1u /* those of a view spread, leaves get slots, and hits are counted */
#define SVO_SPREAD_WHOLE   2u /* each goes to its own leaf; else the same */
#define SVO_SPREAD_ON      3u /* the same, and hits are not counted: they were */

/* A photon's flux relative to that of a pixel in the middle of the view, 2^31 = 1; 0: none is shot. And 1 / length of
   its direction, 2^31 = 1. 8 bytes. */
SVO_RECORD(svo_photon_weight)
{
    SVO_U32 flux; /* 0 */
    SVO_U32 inverse_length; /* 4 */
};

/* How the photons of a work-item spread: cells that they reach, and how many of SVO_SPREAD_PARTS each of them gets of
   each photon. 48 bytes. */
SVO_RECORD(svo_photon_spread)
{
    SVO_U32 leaves[8]; /* 0: of the cells; SVO_PHOTON_LOST: there is none, and it gets nothing. Slots in what is kept */
    SVO_U32 parts[4]; /* 32: of a photon: four bits for each cell, the first lowest */
};

/* The pixels that a source sees, and photons of them. Pixel i, j is at x = (2 i + 1 - columns) half_x and
   y = (2 j + 1 - rows) half_y. 108 bytes. */
SVO_RECORD(svo_light_view_params)
{
    SVO_F32 base[3]; /* 0: world: a point source's position; of parallel light, the middle of its plane */
    SVO_U32 columns; /* 12: pixels */
    SVO_F32 right[3]; /* 16: unit */
    SVO_U32 rows; /* 28 */
    SVO_F32 up[3]; /* 32: unit */
    SVO_U32 tile_columns; /* 44 */
    SVO_F32 forward[3]; /* 48: direction at x = y = 0; for parallel light everywhere, unit */
    SVO_U32 parallel; /* 60: not 0: all photons go forward */
    SVO_F32 half_x; /* 64: half a pixel, world units; of a point source at distance 1 */
    SVO_F32 half_y; /* 68 */
    SVO_U32 first; /* 72: of the launch's photons, a multiple of a tile's */
    SVO_U32 count; /* 76: photons of the launch */
    SVO_U32 flux[6]; /* 80: of a photon of weight 1: red, green, blue, 64 bits each */
    SVO_U32 kept_first; /* 104: of kept photons: the view's first, a multiple of a group's; else 0 */
};

/* Arguments of the kernels that bring photons to leaves. 32 bytes. */
SVO_RECORD(svo_photon_params)
{
    SVO_U32 depth; /* 0 */
    SVO_U32 snap_bits; /* 4: the grid is 2^snap_bits units wide */
    SVO_U32 leaf_begin; /* 8: first leaf */
    SVO_U32 leaf_count; /* 12 */
    SVO_U32 triangle_count; /* 16: of those with ids */
    SVO_U32 count; /* 20: photons, slots or leaves of the launch */
    SVO_U32 spreads; /* 24: SVO_SPREAD_* */
    SVO_F32 cells; /* 28: leaves along a world unit */
};

/* A photon that does not come from a view. 36 bytes. */
SVO_RECORD(svo_carried_photon)
{
    SVO_U32 flux[6]; /* 0: red, green, blue, 64 bits each; zeros: it has ended */
    SVO_I32 way[3]; /* 24: its direction, 2^SVO_FLUX_UNIT_LOG2 = 1 */
};

/* A piece of a triangle in a leaf that emits. 76 bytes. */
SVO_RECORD(svo_emitter_piece)
{
    SVO_F32 corner[3]; /* 0: world units */
    SVO_F32 first_edge[3]; /* 12: to the second corner */
    SVO_F32 second_edge[3]; /* 24: to the third one */
    SVO_I32 normal[3]; /* 36: of either side, 2^SVO_FLUX_UNIT_LOG2 = 1 */
    SVO_U32 end; /* 48: photons of this piece and those before */
    SVO_U32 flux[6]; /* 52: of each photon: red, green, blue, 64 bits each */
};

/* Arguments of the kernels of photons that go on: through what shows in part, from what emits or from what they met.
   48 bytes. */
SVO_RECORD(svo_onward_params)
{
    SVO_U32 count; /* 0: photons of the launch */
    SVO_U32 seed; /* 4: of the numbers that decide; another one for each view, bounce and layer */
    SVO_U32 first; /* 8: of the launch's photons that leave pieces of triangles */
    SVO_U32 piece_count; /* 12 */
    SVO_U32 flags; /* 16: SVO_ONWARD_* */
    SVO_U32 leaf_begin; /* 20: the first leaf's place in the payload */
    SVO_F32 offset; /* 24: from a surface to a ray that leaves it, world units */
    SVO_U32 least[2]; /* 28: photons with less flux in all channels end; 64 bits */
    SVO_U32 through; /* 36: what SVO_PHOTON_THROUGH has counted before */
    SVO_U32 reserved[2]; /* 40 */
};

#define SVO_ONWARD_COLORS    1u /* the tree has colors */
#define SVO_ONWARD_ONE_COLOR 2u /* for all nodes */
#define SVO_ONWARD_VIEW      4u /* photons are those of a view, and carry nothing yet */
#define SVO_ONWARD_LISTED    8u /* photons are listed: they have been searched behind what they met */
#define SVO_ONWARD_LAST      16u /* they stop at what they meet */

/* Arguments of the kernel that finds photons whose rays meet what changed. 32 bytes. */
SVO_RECORD(svo_crossing_params)
{
    SVO_U32 group_count; /* 0: of the view */
    SVO_U32 view; /* 4: its number */
    SVO_U32 box_count; /* 8 */
    SVO_F32 cells; /* 12: leaves along a world unit */
    SVO_F32 beside; /* 16: so many leaves from a hit to a box matter, besides the photon's footprint */
    SVO_U32 reserved[3]; /* 20 */
};

/* Arguments of the kernel that looks for leaves that should have met a photon. 48 bytes. */
SVO_RECORD(svo_unmet_params)
{
    SVO_F32 origin[3]; /* 0: of the grid, world */
    SVO_F32 edge; /* 12: of a leaf, world units */
    SVO_U32 inner_count; /* 16: nodes above the leaves */
    SVO_U32 first; /* 20: of the launch's leaves */
    SVO_U32 count; /* 24: leaves of the launch */
    SVO_F32 reach; /* 28: so far before a leaf parallel light begins, world units */
    SVO_F32 outer_cosine; /* 32: of a spot; else 0 */
    SVO_U32 reserved[3]; /* 36 */
};

/* Which radiance is made: svo_exchange_params.kept. */
#define SVO_RADIANCE_OF_LEAVES 0u /* that of all lit leaves, in their order; none is kept */
#define SVO_RADIANCE_OF_STALE  1u /* by slots, that of stale ones */
#define SVO_RADIANCE_OF_SLOTS  2u /* by slots, all */

/* What the tree holds: svo_exchange_params.flags. */
#define SVO_EXCHANGE_COLORS       1u
#define SVO_EXCHANGE_ONE_COLOR    2u /* for all nodes */
#define SVO_EXCHANGE_ONE_MATERIAL 4u
#define SVO_EXCHANGE_FILLS        8u
#define SVO_EXCHANGE_AREAS        16u
#define SVO_EXCHANGE_ONE_NORMAL   32u
#define SVO_EXCHANGE_ONE_SIDE     64u

/* Lobes of surfaces that shine: fractional bits; steps of the table of an exponential function, and its entries: an
   exponent of 2 / (1/3) and one more. */
#define SVO_LOBE_BITS  15
#define SVO_LOBE_STEPS 256
#define SVO_LOBE_TABLE (6 * SVO_LOBE_STEPS + 1)

/* A material's finish. 32 bytes. */
SVO_RECORD(svo_finish_record)
{
    SVO_U32 emission[3]; /* 0: in the unit of radiance */
    SVO_U32 specular[3]; /* 12: 2^16 = 1 */
    SVO_U32 variance; /* 24: 1 / exponent, 2^SVO_LOBE_BITS = 1 */
    SVO_U32 reserved; /* 28 */
};

/* Arguments of the kernels that make radiance of sums. 32 bytes. */
SVO_RECORD(svo_exchange_params)
{
    SVO_U32 count; /* 0: lit leaves */
    SVO_U32 leaf_begin; /* 4: the first leaf's place in the payload */
    SVO_U32 finish_count; /* 8: 0: none that matters */
    SVO_U32 flags; /* 12: SVO_EXCHANGE_* */
    SVO_U32 factor_low; /* 16: radiance is sums times factor / 2^(63 + shift), rounded half up */
    SVO_U32 factor_high; /* 20 */
    SVO_U32 shift; /* 24 */
    SVO_U32 kept; /* 28: SVO_RADIANCE_* */
};

/* What a picture of a light shows: in the order of svo_render_view. */
#define SVO_LIT_VIEW_FULL     0u
#define SVO_LIT_VIEW_AO       1u
#define SVO_LIT_VIEW_DIRECT   2u
#define SVO_LIT_VIEW_INDIRECT 3u
#define SVO_LIT_VIEW_SPECULAR 4u
/* And for maps, which are looked at from elsewhere: full without specular light. */
#define SVO_LIT_VIEW_MATTE 5u

/* Arguments of pictures of lights, world coordinates. 128 bytes. */
SVO_RECORD(svo_lit_picture_params)
{
    SVO_F32 eye[3]; /* 0 */
    SVO_U32 view; /* 12: SVO_LIT_VIEW_* */
    SVO_F32 corner[3]; /* 16: from the eye to the picture's upper left corner, at any distance */
    SVO_U32 width; /* 28: pixels */
    SVO_F32 across[3]; /* 32: from a pixel to its right neighbor, at that distance */
    SVO_U32 height; /* 44: pixels */
    SVO_F32 down[3]; /* 48: from a pixel to the one below, at that distance */
    SVO_F32 exposure; /* 60 */
    SVO_U32 source_count; /* 64 */
    SVO_U32 finish_count; /* 68 */
    SVO_U32 first_tile; /* 72: of the rows that are drawn */
    SVO_U32 samples; /* 76: camera rays of a pixel */
    SVO_U32 pixel_flags; /* 80: SVO_PIXEL_* */
    SVO_F32 background[3]; /* 84: what is behind everything, with SVO_PIXEL_COLOR */
    SVO_U32 emitter_count; /* 96 */
    SVO_F32 clip[4]; /* 100: a plane; what is below it is not seen (kernels/rays/part.clh). Zeros: none */
    SVO_U32 mesh_flags; /* 116: SVO_MESH_* */
    SVO_F32 sample_width; /* 120: of a camera ray's share of the picture, at distance 1 from the eye */
    SVO_U32 source_rays_log2; /* 124: rays from what is lit to each source that has a size */
};

/* svo_lit_picture_params.mesh_flags, of the mesh that a light was given */
#define SVO_MESH_COLORS  1u /* it has materials or vertex colors */
#define SVO_MESH_NORMALS 2u
#define SVO_MESH_CLEAR   4u /* some of it shows in part */

/* What a triangle of that mesh looks like: at its corners, unless said otherwise. 56 bytes. */
SVO_RECORD(svo_mesh_triangle)
{
    SVO_F32 uvs[6]; /* 0: u, v each */
    SVO_U32 colors[3]; /* 24: RGBA8 */
    SVO_U32 normals[3]; /* 36: unit, octahedral, two numbers of 16 bits in -32767 .. 32767 */
    SVO_U32 material; /* 48: and SVO_MESH_TRIANGLE_CLEAR if it may show in part */
    SVO_F32 level; /* 52: logarithm to base 2 of its texels in a world unit */
};

#define SVO_MESH_TRIANGLE_CLEAR 0x80000000u

/* How a triangle of that mesh bends normals. 16 bytes. */
SVO_RECORD(svo_mesh_bend)
{
    SVO_F32 scale; /* 0: of the map's x and y, y negative where its frame is left-handed; 0: the triangle has no map */
    SVO_U32 direction; /* 4: along u, packed as normals are */
    SVO_U32 material; /* 8: the record of the map, behind those of materials */
    SVO_F32 level; /* 12: logarithm to base 2 of its texels in a world unit */
};

/* A triangle that emits. 48 bytes. */
SVO_RECORD(svo_emitter_record)
{
    SVO_F32 corner[3]; /* 0: world units */
    SVO_F32 first_edge[3]; /* 12: to the second corner */
    SVO_F32 second_edge[3]; /* 24: to the third one */
    SVO_U32 triangle; /* 36: as hits name it */
    SVO_U32 end; /* 40: its share ends here, and that of the next begins; SVO_EMITTER_SHARES for the last */
    SVO_F32 density; /* 44: of points on it that rays aim at, per square world unit */
};

#define SVO_EMITTER_SHARES 0x80000000u

/* Of rays that aim at rows of the sky's map, and of those at the texels of a row (light/sky.clh). Numbers of paths tell
   as many apart. */
#define SVO_SKY_SHARES 0x1000000u

/* Of kernels/light/screen.cl: the cells of a band of a picture, 2 x 2 pixels each. 32 bytes. */
SVO_RECORD(svo_screen_params)
{
    SVO_U32 columns; /* 0: cells across the picture */
    SVO_U32 rows; /* 4: of the band */
    SVO_U32 first_row; /* 8: of the band in the picture */
    SVO_U32 step; /* 12: of the filter: cells from a neighbor to the next */
    SVO_F32 tolerance; /* 16: of the filter: standard errors by which light may differ */
    SVO_F32 near; /* 20: world units within which surfaces are near each other */
    SVO_U32 is_specular; /* 24: the filter smooths what surfaces mirror */
    SVO_U32 reserved; /* 28 */
};

#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_screen_params, 32);
SVO_ASSERT_BYTES(svo_emitter_record, 48);
SVO_ASSERT_BYTES(svo_mesh_triangle, 56);
SVO_ASSERT_BYTES(svo_mesh_bend, 16);
SVO_ASSERT_BYTES(svo_light_params, 32);
SVO_ASSERT_BYTES(svo_gather_params, 32);
SVO_ASSERT_BYTES(svo_light_step, 32);
SVO_ASSERT_BYTES(svo_photon_weight, 8);
SVO_ASSERT_BYTES(svo_photon_spread, 48);
SVO_ASSERT_BYTES(svo_light_view_params, 108);
SVO_ASSERT_BYTES(svo_photon_params, 32);
SVO_ASSERT_BYTES(svo_carried_photon, 36);
SVO_ASSERT_BYTES(svo_emitter_piece, 76);
SVO_ASSERT_BYTES(svo_onward_params, 48);
SVO_ASSERT_BYTES(svo_crossing_params, 32);
SVO_ASSERT_BYTES(svo_unmet_params, 48);
SVO_ASSERT_BYTES(svo_finish_record, 32);
SVO_ASSERT_BYTES(svo_exchange_params, 32);
SVO_ASSERT_BYTES(svo_lit_picture_params, 128);
#endif

#endif
