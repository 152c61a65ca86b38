/* SPDX-License-Identifier: MIT */
/* shared/layout.h for light field probes: how they are stored, made and asked. */
#ifndef SVO_KERNELS_SHARED_PROBE_LAYOUT_H
#define SVO_KERNELS_SHARED_PROBE_LAYOUT_H

#include "shared/layout.h"
#include "svocl/probe_types.h"

/* Edge of a coarse texel, in texels. */
#define SVO_PROBE_BLOCK 16u
/* The largest code of a distance. */
#define SVO_PROBE_CODE_MAX 65534u
/* Probes that a cell of the field lists. */
#define SVO_PROBE_FIELD_ENTRIES 4u
/* Texels along a side of a probe's maps for diffuse light. */
#define SVO_PROBE_IRRADIANCE_TEXELS 8u
#define SVO_PROBE_MOMENT_TEXELS     16u

/* Parts of a leaf edge in which moments are added up, and the most of them, so that 64 x 64 squares fit 64 bits. */
#define SVO_PROBE_LENGTH_UNIT 256u
#define SVO_PROBE_LENGTH_MAX  0x3ffffffu

/* Of svo_probes_params.flags. */
#define SVO_PROBES_FLAG_RADIANCE 1u /* texels have radiance */
#define SVO_PROBES_FLAG_DIFFUSE  2u /* there are maps of irradiance and moments */

/* What kernels know of probes besides their buffers. World coordinates. 112 bytes. */
SVO_RECORD(svo_probes_params)
{
    SVO_F32 start[3]; /* 0: of the first probe, before it was moved */
    SVO_U32 resolution; /* 12: texels along a side of a probe's map */
    SVO_F32 step[3]; /* 16: between probes */
    SVO_U32 probe_count; /* 28 */
    SVO_U32 counts[3]; /* 32: along x, y and z */
    SVO_U32 flags; /* 44: SVO_PROBES_FLAG_* */
    SVO_F32 low[3]; /* 48: least corner of the field */
    SVO_U32 field_size; /* 60: cells along an axis */
    SVO_F32 field_scale[3]; /* 64: cells of the field per world unit */
    SVO_F32 leaf_edge; /* 76: 1 / C */
    SVO_F32 code_scale; /* 80: C */
    SVO_F32 code_log2; /* 84: log2(C F + 1): the distance of a code q is (exp2(q / 65534 code_log2) - 1) / C */
    SVO_F32 farthest; /* 88: F */
    SVO_F32 sky[3]; /* 92: radiance of what sees nothing */
    SVO_U32 sky_size; /* 104: of the map on top of it, as in svo_light_params */
    SVO_U32 reserved; /* 108 */
};

/* A launch of the kernels that make probes. 32 bytes. */
SVO_RECORD(svo_probe_step)
{
    SVO_U32 first; /* 0: of the launch: a ray, a block, a cell of the field, a probe */
    SVO_U32 count; /* 4: work-items of the launch */
    SVO_U32 hit_words; /* 8: of a record of a hit */
    SVO_U32 cell_edge; /* 12: of the cells that irradiance adds up, texels */
    SVO_F32 half_cell[3]; /* 16: of the field, world units */
    SVO_I32 scale_log2; /* 28: of world units, near 1 / leaf edge */
};

#if !defined(GL_core_profile)
SVO_ASSERT_BYTES(svo_probes_params, 112);
SVO_ASSERT_BYTES(svo_probe_step, 32);
#endif

#endif
