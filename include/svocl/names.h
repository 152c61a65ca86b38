/* SPDX-License-Identifier: MIT */
/**
 * \file
 * Names of enumerators, as reports, options and messages have them. The comments of the enumerators say most of them.
 */
#ifndef SVOCL_NAMES_H
#define SVOCL_NAMES_H

#include <stdint.h>

#include "svocl/export.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Enumerations with names. */
typedef enum svo_name_kind {
    SVO_NAME_STATUS = 0, /**< svo_status: "SVO_OK", ... */
    SVO_NAME_STATUS_TEXT, /**< svo_status: what it means, the text in SVO_STATUS_LIST */
    SVO_NAME_NEED, /**< one bit of svo_need: "color", "normal", ...; "none" for anything else */
    SVO_NAME_COVERAGE, /**< svo_coverage: "half-open", "closed", "thin" */
    SVO_NAME_WEIGHTS, /**< svo_weights: "area", "uniform", "center" */
    SVO_NAME_BUILDER, /**< svo_builder: "cl", "sorted" */
    SVO_NAME_PLACE, /**< svo_place: "default", "host", "device" */
    SVO_NAME_STAGE, /**< svo_stage: "grid", "compile", ... */
    SVO_NAME_CERTAINTY, /**< svo_certainty: "exact", "bound", "estimate" */
    SVO_NAME_PATH, /**< svo_path: "auto", "cpu", "gpu" */
    SVO_NAME_TREE_BUFFER, /**< svo_tree_buffer: "child_mask", ... */
    SVO_NAME_FORM, /**< svo_form: "descriptor", "implied", "shared", "mirrored" */
    SVO_NAME_COMPACT_BUFFER, /**< svo_compact_buffer: "nodes", ... */
    SVO_NAME_SOLID_RULE, /**< svo_solid_rule: "winding", "parity", "generalized" */
    SVO_NAME_LIGHT_FORM, /**< svo_light_form: "faces", "bricks", "voxels" */
    SVO_NAME_LIGHT_BUFFER, /**< svo_light_buffer: "opacity", ... */
    SVO_NAME_LIGHT_STAGE, /**< svo_light_stage: "opacity", ... */
    SVO_NAME_PROBES_BUFFER, /**< svo_probes_buffer: "places", ... */
    SVO_NAME_PROBES_STAGE, /**< svo_probes_stage: "placing", ... */
    SVO_NAME_VOXEL_FORMAT, /**< svo_voxel_format: "auto", "vox", "svx", "binvox", "ply", "obj",
                               "nvdb", "slab6", "bt", "las", "laz", "vdb" */
    SVO_NAME_GL_CONTEXT_KIND, /**< svo_gl_context_kind: "surfaceless", "egl-device", "osmesa", "wrapped" */
    SVO_NAME_GL_RASTER, /**< svo_gl_raster: "auto", "gl-expand", "gl-hw", "gl-hybrid" */
    SVO_NAME_GL_SHARE, /**< svo_gl_share: "auto", "interop", "host", "copy" */
    SVO_NAME_EDIT_VERB, /**< svo_edit_verb: "set", "add", "clear", "keep", "paint" */
    SVO_NAME_EDIT_SHAPE, /**< svo_edit_shape: "box", "sphere", "capsule", "voxels" */
    SVO_NAME_KINDS /**< number of kinds */
} svo_name_kind;

/** Names an enumerator.
 *
 * \param kind of which enumeration
 * \param value any value of it, and any other
 * \returns the name; "unknown stage", "unknown form" and so on for a value without one, "unknown" for a kind that is
 * none. Static string. */
SVO_API const char *svo_name(svo_name_kind kind, uint32_t value);

#ifdef __cplusplus
}
#endif

#endif
