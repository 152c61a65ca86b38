/* SPDX-License-Identifier: MIT */
/** \file
 * Records of probes (probes.h), as they lie in buffers and in kernels of the caller's own. One text for C, C++, OpenCL
 * C and GLSL. Records hold 32-bit integers and floats only, without padding; numbers at the front of comments are
 * offsets in bytes.
 *
 * A texel is two words:
 *
 *     word 0   31 .. 24   23 .. 16   15 .. 0      normal y, normal x, distance
 *     word 1   31 .. 22   21 .. 11   10 .. 0      blue, green, red: unsigned floats of 10, 11 and 11 bits (R11G11B10F)
 *
 * Normals are octahedral, signed bytes, 127 = 1, and face the probe. A distance is a code q: world units
 * d = ((C F + 1)^(q / 65534) - 1) / C, where C is 1 / leaf edge and F the farthest a probe can see; SVO_PROBE_NOTHING:
 * the texel sees nothing, and its radiance is the sky's.
 */
#ifndef SVOCL_PROBE_TYPES_H
#define SVOCL_PROBE_TYPES_H

#include "svocl/record.h"

#define SVO_PROBE_NOTHING 0xffffu /**< a distance, a least distance: there is nothing */
#define SVO_PROBE_NONE    0xffffu /**< an entry of the field: no probe */
#define SVO_NO_TEXEL      0xffffffffu /**< svo_probe_hit.texel: none */

#define SVO_PROBE_OFF      0u /**< svo_probe.state: it saw surfaces from behind and no free place was near */
#define SVO_PROBE_IN_PLACE 1u /**< svo_probe.state: where the grid has it */
#define SVO_PROBE_MOVED    2u /**< svo_probe.state: moved within half a step */

#define SVO_PROBE_MISS    0u /**< svo_probe_hit.state: nothing is along the ray */
#define SVO_PROBE_HIT     1u /**< svo_probe_hit.state: a surface */
#define SVO_PROBE_UNKNOWN 2u /**< svo_probe_hit.state: the ray went where no probe saw */

/** A probe. 16 bytes. */
SVO_RECORD(svo_probe)
{
    SVO_F32 position[3]; /**< 0: world */
    SVO_U32 state; /**< 12: SVO_PROBE_OFF, SVO_PROBE_IN_PLACE or SVO_PROBE_MOVED */
};

/** What probes know of a ray. 32 bytes. */
SVO_RECORD(svo_probe_hit)
{
    SVO_F32 t; /**< 0: in lengths of the ray's direction. Miss: infinity. Unknown: up to here the ray is known */
    SVO_U32 state; /**< 4: SVO_PROBE_MISS, SVO_PROBE_HIT or SVO_PROBE_UNKNOWN */
    /** 8: the texel that was hit, into the texels of all probes: its probe is texel / resolution^2; or SVO_NO_TEXEL */
    SVO_U32 texel;
    SVO_U32 normal; /**< 12: of the surface, as in word 0 of a texel: bits 16 .. 31; the others are 0 */
    SVO_F32 radiance[3]; /**< 16: of the surface; of a miss, the sky's */
    SVO_U32 visited; /**< 28: texels, coarse and fine ones, of all probes together */
};

/** Diffuse light of probes at a point. 16 bytes. */
SVO_RECORD(svo_probe_irradiance)
{
    SVO_F32 irradiance[3]; /**< 0: red, green, blue */
    SVO_F32 weight; /**< 12: of all probes together; 0: none sees the point, and there is no light */
};

/** \cond */
#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_probe, 16);
SVO_ASSERT_BYTES(svo_probe_hit, 32);
SVO_ASSERT_BYTES(svo_probe_irradiance, 16);
#endif
/** \endcond */

#endif
