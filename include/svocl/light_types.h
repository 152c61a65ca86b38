/* SPDX-License-Identifier: MIT */
/** \file
 * Records of light (light.h), as they lie in buffers and in kernels of the caller's own. One text for C, C++, OpenCL C
 * and GLSL. Records hold 32-bit integers and floats only, without padding; numbers at the front of comments are offsets
 * in bytes.
 */
#ifndef SVOCL_LIGHT_TYPES_H
#define SVOCL_LIGHT_TYPES_H

#include "svocl/record.h"

#define SVO_SOURCE_DIRECTIONAL 0u /**< svo_light_source.kind: parallel light; value is its irradiance E */
#define SVO_SOURCE_POINT       1u /**< svo_light_source.kind: value is its intensity I, per unit of solid angle */
#define SVO_SOURCE_SPOT        2u /**< svo_light_source.kind: a point source within a cone; value is I on its axis */
#define SVO_SOURCE_DISK        3u /**< svo_light_source.kind: a flat disk, shines to one side; value is I on its axis */

/** A source of light, in world coordinates and linear units. Between its angles a spot has the share s^2 (3 - 2 s) of
 *  its value, where s goes from 1 to 0 with the cosine of the angle from the axis. A disk has the cosine of the angle
 *  from its axis as its share, as a panel of one radiance does. 64 bytes. */
SVO_RECORD(svo_light_source)
{
    SVO_U32 kind; /**< 0: SVO_SOURCE_* */
    SVO_F32 position[3]; /**< 4: all but directional */
    SVO_F32 direction[3]; /**< 16: all but point: where the light goes, any length above 0 */
    SVO_F32 value[3]; /**< 28: red, green, blue, not negative */
    SVO_F32 inner_angle; /**< 40: spot: radians from the axis up to which it has its full value */
    SVO_F32 outer_angle; /**< 44: spot: radians at which it ends, above inner_angle and below pi / 2 */
    /** 48: 0, or the source's size, which shadows show: of a point or spot the radius of a ball around its position,
     *  world units; of a disk its own; of a directional source radians from its axis, below pi / 2. Rays honor it;
     *  photons leave its middle. Outside a ball, value is what it is without a size. Places inside see a point. */
    SVO_F32 radius;
    SVO_U32 reserved[3]; /**< 52: zero */
};

/** What a material does besides its color. Materials without one are diffuse and do not emit. 32 bytes. */
SVO_RECORD(svo_finish)
{
    SVO_F32 emission[3]; /**< 0: radiance that it emits, linear red, green, blue, not negative */
    SVO_F32 specular[3]; /**< 12: specular color, linear, 0 .. 1 */
    SVO_F32 exponent; /**< 24: of the Phong lobe, not negative */
    SVO_U32 reserved; /**< 28: zero */
};

/** A point whose light is asked for. 48 bytes. */
SVO_RECORD(svo_gather_point)
{
    SVO_F32 position[3]; /**< 0: world, on a surface or in the open */
    SVO_F32 normal[3]; /**< 12: any length above 0. Zero: the result is that of an empty scene without light */
    SVO_F32 reflected[3]; /**< 24: direction of the specular cone, any length; zero: none */
    SVO_F32 exponent; /**< 36: of the specular lobe, not negative */
    SVO_U32 reserved[2]; /**< 40: zero */
};

/** What was gathered at a point. 56 bytes. */
SVO_RECORD(svo_gather_result)
{
    SVO_F32 openness; /**< 0: ambient occlusion: 1 is open, 0 closed */
    SVO_F32 irradiance[3]; /**< 4: by surfaces and the sky: pi times the mean radiance, weighted by the cosine */
    SVO_F32 specular[3]; /**< 16: mean radiance of the lobe around the reflected direction */
    SVO_U32 steps; /**< 28: of all cones together; the rays that were traced */
    SVO_F32 direct[3]; /**< 32: irradiance by the sources, with exact shadows; not part of the other */
    SVO_F32 openness_error; /**< 44: standard error of openness; not a number for cones, which do not know theirs */
    SVO_F32 irradiance_error; /**< 48: of irradiance, that of the channel with the largest; likewise */
    SVO_F32 specular_error; /**< 52: of specular, likewise */
};

/** \cond */
#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_light_source, 64);
SVO_ASSERT_BYTES(svo_finish, 32);
SVO_ASSERT_BYTES(svo_gather_point, 48);
SVO_ASSERT_BYTES(svo_gather_result, 56);
#endif
/** \endcond */

#endif
