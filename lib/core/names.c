/* SPDX-License-Identifier: MIT */
/* Names of all public enumerators, also of those that other libraries of svocl use. */
#include "svocl/names.h"

#include <stddef.h>

#include "svocl/compact.h"
#include "svocl/device.h"
#include "svocl/gl.h"
#include "svocl/light.h"
#include "svocl/plan.h"
#include "svocl/probes.h"
#include "svocl/solid.h"
#include "svocl/status.h"
#include "svocl/tree.h"
#include "svocl/voxel_files.h"

/* The names of an enumeration, by value; for a bit by its index. */
typedef struct name_list {
    const char *const *names; /* NULL where there is none */
    uint32_t count;
    const char *unknown;
} name_list;

#define NAME_LIST(names, unknown)                                       \
    {                                                                   \
        (names), (uint32_t)(sizeof(names) / sizeof *(names)), (unknown) \
    }

#define STATUS_NAME(name, value, text) [value] = #name,
#define STATUS_TEXT(name, value, text) [value] = (text),
static const char *const statuses[] = {SVO_STATUS_LIST(STATUS_NAME)};
static const char *const status_texts[] = {SVO_STATUS_LIST(STATUS_TEXT)};

static const char *const needs[] = {"color", "normal", "rays", "material", "fill", "projected-area"};
_Static_assert(SVO_NEED_ALL == (1 << (sizeof needs / sizeof *needs)) - 1, "a name for each bit");
static const char *const coverages[] = {"half-open", "closed", "thin"};
static const char *const weights[] = {"area", "uniform", "center"};
static const char *const builders[] = {"cl", "sorted"};
static const char *const places[] = {"default", "host", "device"};
static const char *const stages[SVO_STAGE_COUNT] = {"grid", "compile", "voxelize", "transfer", "subdivide",
                                                    "pack", "link",    "filter",   "drop"};
static const char *const certainties[] = {"exact", "bound", "estimate"};
static const char *const paths[] = {"auto", "cpu", "gpu"};
static const char *const tree_buffers[SVO_TREE_BUILD_STATE + 1] = {
    "child_mask", "first_child", "colors",    "normals",          "list_begin",
    "list",       "vertices",    "indices",   "triangle_ids",     "materials",
    "fills",      "areas",       "positions", "positions_double", [SVO_TREE_BUILD_STATE] = "build_state"};
static const char *const forms[SVO_FORM_COUNT] = {"descriptor", "implied", "shared", "mirrored"};
static const char *const compact_buffers[SVO_COMPACT_BUFFER_COUNT] = {"nodes",   "links",     "bases", "colors",
                                                                      "normals", "materials", "fills"};
static const char *const solid_rules[] = {
    [SVO_SOLID_WINDING] = "winding", [SVO_SOLID_PARITY] = "parity", [SVO_SOLID_GENERALIZED] = "generalized"};
static const char *const light_forms[SVO_LIGHT_FORM_COUNT] = {"faces", "bricks", "voxels"};
static const char *const light_buffers[SVO_LIGHT_BUFFER_COUNT] = {"opacity", "cover", "lit", "radiance", "flux"};
static const char *const light_stages[SVO_LIGHT_STAGE_COUNT] = {"opacity", "opacity filter", "light view",
                                                                "photons", "exchange",       "radiance filter"};
static const char *const probes_buffers[SVO_PROBES_BUFFER_COUNT] = {"places", "texels",     "least",
                                                                    "field",  "irradiance", "moments"};
static const char *const probes_stages[SVO_PROBES_STAGE_COUNT] = {"placing", "texels", "radiance",
                                                                  "least",   "field",  "prefilter"};
static const char *const voxel_formats[] = {"auto", "vox",   "svx", "binvox", "ply", "obj",
                                            "nvdb", "slab6", "bt",  "las",    "laz", "vdb"};
static const char *const context_kinds[SVO_GL_WRAPPED + 1] = {[SVO_GL_SURFACELESS] = "surfaceless",
                                                              [SVO_GL_EGL_DEVICE] = "egl-device",
                                                              [SVO_GL_OSMESA] = "osmesa",
                                                              [SVO_GL_WRAPPED] = "wrapped"};
static const char *const rasters[] = {"auto", "gl-expand", "gl-hw", "gl-hybrid"};
static const char *const shares[] = {"auto", "interop", "host", "copy"};
static const char *const edit_verbs[] = {"set", "add", "clear", "keep", "paint"};
static const char *const edit_shapes[] = {"box", "sphere", "capsule", "voxels"};

static const name_list lists[SVO_NAME_KINDS] = {
    [SVO_NAME_STATUS] = NAME_LIST(statuses, "unknown status"),
    [SVO_NAME_STATUS_TEXT] = NAME_LIST(status_texts, "unknown status"),
    [SVO_NAME_NEED] = NAME_LIST(needs, "none"),
    [SVO_NAME_COVERAGE] = NAME_LIST(coverages, "unknown coverage"),
    [SVO_NAME_WEIGHTS] = NAME_LIST(weights, "unknown weights"),
    [SVO_NAME_BUILDER] = NAME_LIST(builders, "unknown builder"),
    [SVO_NAME_PLACE] = NAME_LIST(places, "unknown place"),
    [SVO_NAME_STAGE] = NAME_LIST(stages, "unknown stage"),
    [SVO_NAME_CERTAINTY] = NAME_LIST(certainties, "unknown certainty"),
    [SVO_NAME_PATH] = NAME_LIST(paths, "unknown path"),
    [SVO_NAME_TREE_BUFFER] = NAME_LIST(tree_buffers, "unknown buffer"),
    [SVO_NAME_FORM] = NAME_LIST(forms, "unknown form"),
    [SVO_NAME_COMPACT_BUFFER] = NAME_LIST(compact_buffers, "unknown buffer"),
    [SVO_NAME_SOLID_RULE] = NAME_LIST(solid_rules, "unknown rule"),
    [SVO_NAME_LIGHT_FORM] = NAME_LIST(light_forms, "unknown form"),
    [SVO_NAME_LIGHT_BUFFER] = NAME_LIST(light_buffers, "unknown buffer"),
    [SVO_NAME_LIGHT_STAGE] = NAME_LIST(light_stages, "unknown stage"),
    [SVO_NAME_PROBES_BUFFER] = NAME_LIST(probes_buffers, "unknown buffer"),
    [SVO_NAME_PROBES_STAGE] = NAME_LIST(probes_stages, "unknown stage"),
    [SVO_NAME_VOXEL_FORMAT] = NAME_LIST(voxel_formats, "unknown format"),
    [SVO_NAME_GL_CONTEXT_KIND] = NAME_LIST(context_kinds, "unknown context kind"),
    [SVO_NAME_GL_RASTER] = NAME_LIST(rasters, "unknown"),
    [SVO_NAME_GL_SHARE] = NAME_LIST(shares, "unknown"),
    [SVO_NAME_EDIT_VERB] = NAME_LIST(edit_verbs, "unknown verb"),
    [SVO_NAME_EDIT_SHAPE] = NAME_LIST(edit_shapes, "unknown shape"),
};

/* The index of a bit; more than any for what is no single bit. */
static uint32_t index_of_bit(uint32_t bit)
{
    uint32_t index = 0;
    while (index < 32 && bit != UINT32_C(1) << index) {
        ++index;
    }
    return index;
}

const char *svo_name(svo_name_kind kind, uint32_t value)
{
    if ((uint32_t)kind >= SVO_NAME_KINDS) {
        return "unknown";
    }
    const name_list *list = &lists[kind];
    const uint32_t index = kind == SVO_NAME_NEED ? index_of_bit(value) : value;
    return index < list->count && list->names[index] != NULL ? list->names[index] : list->unknown;
}
