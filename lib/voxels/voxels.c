/* SPDX-License-Identifier: MIT */
/* Lists of voxels: each place once, in Morton order. Files and trees are made from them, and they from those. */
#include "voxels/voxels.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory.h"
#include "core/struct_size.h"
#include "core/tree.h"
#include "shared/nodes.clh"
#include "svocl/nodes.h"

#define COORDINATE_MAX (1 << 30)
#define MATERIAL_MAX   65534u
#define PROPERTIES_MAX UINT32_MAX

static const char create_name[] = "svo_voxels_create";
static const char get_name[] = "svo_tree_get_voxels";

static svo_status check_source(const svo_voxels_source *source, svo_message *message)
{
    if (source->voxel_count > SVO_VOXELS_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source.voxel_count %" PRIu64 " is above %u", create_name,
                          source->voxel_count, SVO_VOXELS_MAX);
    }
    if ((source->voxels == NULL && source->voxel_count > 0) ||
        (source->properties == NULL && source->property_count > 0)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source.%s is NULL", create_name,
                          source->voxels == NULL && source->voxel_count > 0 ? "voxels" : "properties");
    }
    if (source->property_count > PROPERTIES_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source.property_count %zu is above %u", create_name,
                          source->property_count, PROPERTIES_MAX);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (!isfinite(source->origin[axis])) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source.origin[%d] %g is not finite", create_name,
                              axis, source->origin[axis]);
        }
    }
    if (!isfinite(source->voxel_edge) || source->voxel_edge < 0.0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source.voxel_edge %g is not finite and at least 0",
                          create_name, source->voxel_edge);
    }
    for (size_t i = 0; i < source->property_count; ++i) {
        const svo_voxel_property *one = &source->properties[i];
        if (one->key == NULL || one->key[0] == '\0' || one->value == NULL || one->material > MATERIAL_MAX) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                              "%s: source.properties[%zu] has no key, no value or a material above %u", create_name, i,
                              MATERIAL_MAX);
        }
    }
    return SVO_OK;
}

/* Checks the voxels and finds their bounds. */
static svo_status find_bounds(const svo_voxel *voxels, uint64_t count, svo_voxels_info *info, svo_message *message)
{
    int32_t low[3] = {INT32_MAX, INT32_MAX, INT32_MAX};
    int32_t high[3] = {INT32_MIN, INT32_MIN, INT32_MIN};
    uint32_t material_count = 0;
    for (uint64_t i = 0; i < count; ++i) {
        if (voxels[i].reserved != 0) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source.voxels[%llu].reserved %u is not 0",
                              create_name, (unsigned long long)i, voxels[i].reserved);
        }
        const int32_t place[3] = {voxels[i].x, voxels[i].y, voxels[i].z};
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = place[axis] < low[axis] ? place[axis] : low[axis];
            high[axis] = place[axis] > high[axis] ? place[axis] : high[axis];
        }
        material_count = voxels[i].material >= material_count ? voxels[i].material + 1u : material_count;
    }
    for (int axis = 0; axis < 3 && count > 0; ++axis) {
        if (low[axis] < -COORDINATE_MAX || high[axis] > COORDINATE_MAX) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %c coordinates %d .. %d are not in %d .. %d",
                              create_name, "xyz"[axis], low[axis], high[axis], -COORDINATE_MAX, COORDINATE_MAX);
        }
        if ((int64_t)high[axis] - low[axis] >= SVO_VOXELS_EXTENT_MAX) {
            return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %c coordinates %d .. %d span more than %d voxels",
                              create_name, "xyz"[axis], low[axis], high[axis], SVO_VOXELS_EXTENT_MAX);
        }
        info->low[axis] = low[axis];
        info->high[axis] = high[axis] + 1;
    }
    if (material_count > MATERIAL_MAX + 1) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: a voxel's material %u is above %u", create_name,
                          material_count - 1, MATERIAL_MAX);
    }
    info->material_count = material_count;
    return SVO_OK;
}

/* Keeps the last voxel of each place. Returns how many there are. */
static size_t keep_last(svo_voxel *voxels, size_t count)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        const svo_voxel *last = kept > 0 ? &voxels[kept - 1] : NULL;
        if (last != NULL && last->x == voxels[i].x && last->y == voxels[i].y && last->z == voxels[i].z) {
            --kept;
        }
        voxels[kept++] = voxels[i];
    }
    return kept;
}

/* By material, then by key, then in the given order. */
static int compare_properties(const void *a, const void *b)
{
    const svo_voxel_property *left = *(const svo_voxel_property *const *)a;
    const svo_voxel_property *right = *(const svo_voxel_property *const *)b;
    if (left->material != right->material) {
        return left->material < right->material ? -1 : 1;
    }
    const int order = strcmp(left->key, right->key);
    return order != 0 ? order : (left > right) - (left < right);
}

static char *put_text(char **end, const char *text)
{
    char *begin = *end;
    const size_t bytes = strlen(text) + 1;
    memcpy(begin, text, bytes);
    *end += bytes;
    return begin;
}

static svo_status copy_properties(const svo_voxels_source *source, svo_voxels *made, svo_message *message)
{
    const size_t count = source->property_count;
    size_t bytes = 1;
    for (size_t i = 0; i < count; ++i) {
        bytes += strlen(source->properties[i].key) + strlen(source->properties[i].value) + 2;
    }
    const svo_voxel_property **sorted = svo_i_alloc(&made->memory, (count + 1) * sizeof *sorted);
    made->properties = svo_i_alloc(&made->memory, (count + 1) * sizeof *made->properties);
    made->texts = svo_i_alloc(&made->memory, bytes);
    if (sorted == NULL || made->properties == NULL || made->texts == NULL) {
        svo_i_free((void *)sorted);
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu properties", create_name, count);
    }
    for (size_t i = 0; i < count; ++i) {
        sorted[i] = &source->properties[i];
    }
    qsort((void *)sorted, count, sizeof *sorted, compare_properties);
    char *end = made->texts;
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        const bool last = i + 1 == count || sorted[i]->material != sorted[i + 1]->material ||
                          strcmp(sorted[i]->key, sorted[i + 1]->key) != 0;
        if (last) {
            made->properties[kept++] = (svo_voxel_property){.material = sorted[i]->material,
                                                            .key = put_text(&end, sorted[i]->key),
                                                            .value = put_text(&end, sorted[i]->value)};
        }
    }
    svo_i_free((void *)sorted);
    made->info.property_count = kept;
    return SVO_OK;
}

/* What normals need while they are sorted with their voxels. All arrays are owned. */
typedef struct sorting {
    svo_voxel *spare; /* NULL: nothing is sorted */
    uint32_t *colors; /* of all voxels, which have their numbers in their place; NULL without normals */
    int16_t *normals; /* the sorted ones; NULL without normals */
} sorting;

static void sorting_free(sorting *s)
{
    svo_i_free(s->spare);
    svo_i_free(s->colors);
    svo_i_free(s->normals);
}

/* Lets each voxel carry its number, by which it gets its color and its normal back. */
static void number_voxels(svo_voxels *made, const sorting *s, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        const uint32_t number = (uint32_t)i;
        memcpy(&s->colors[i], made->voxels[i].rgba, sizeof s->colors[i]);
        memcpy(made->voxels[i].rgba, &number, sizeof number);
    }
}

static void follow_numbers(svo_voxels *made, sorting *s, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        uint32_t number = 0;
        memcpy(&number, made->voxels[i].rgba, sizeof number);
        memcpy(made->voxels[i].rgba, &s->colors[number], sizeof s->colors[number]);
        memcpy(s->normals + 3 * i, made->normals + 3 * (size_t)number, 3 * sizeof *s->normals);
    }
    int16_t *sorted = s->normals;
    s->normals = made->normals;
    made->normals = sorted;
}

/* Sorts the list's voxels and leaves out those that others replace. Frees what that needs. */
static void sort_voxels(svo_voxels *made, sorting *s, size_t count)
{
    if (made->normals != NULL) {
        number_voxels(made, s, count);
    }
    svo_i_voxel_sort(made->voxels, s->spare, count, made->info.low, svo_i_voxel_bits(made->info.low, made->info.high),
                     SVO_I_VOXEL_MORTON);
    const size_t kept = keep_last(made->voxels, count);
    made->info.voxel_count = kept;
    if (made->normals != NULL) {
        follow_numbers(made, s, kept);
    }
    sorting_free(s); /* first, since less memory may mean another block */
    *s = (sorting){NULL, NULL, NULL};
    svo_voxel *smaller = kept < count ? svo_i_grow(&made->memory, made->voxels, kept * sizeof *smaller) : NULL;
    made->voxels = smaller != NULL ? smaller : made->voxels;
}

/* Whether each voxel's code is above that of the one before. */
static bool is_sorted(const svo_voxels *made)
{
    uint64_t before = 0;
    for (uint64_t i = 0; i < made->info.voxel_count; ++i) {
        const uint64_t code = svo_i_voxel_code(&made->voxels[i], made->info.low);
        if (i > 0 && code <= before) {
            return false;
        }
        before = code;
    }
    return true;
}

static svo_status allocate_sorting(const svo_voxels *made, sorting *s, svo_message *message)
{
    const size_t count = (size_t)made->info.voxel_count;
    const bool has_normals = made->normals != NULL;
    s->spare = svo_i_alloc(&made->memory, count * sizeof *s->spare);
    s->colors = has_normals ? svo_i_alloc(&made->memory, count * sizeof *s->colors) : NULL;
    s->normals = has_normals ? svo_i_alloc(&made->memory, count * 3 * sizeof *s->normals) : NULL;
    return s->spare != NULL && (!has_normals || (s->colors != NULL && s->normals != NULL))
               ? SVO_OK
               : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory to sort %zu voxels", create_name, count);
}

svo_status svo_i_voxels_take(const svo_i_memory *memory, const svo_voxels_source *source, svo_voxel *voxels,
                             int16_t *normals, svo_voxels **out, svo_message *message)
{
    svo_status status = SVO_OK;
    sorting s = {NULL, NULL, NULL};
    svo_voxels *made = svo_i_alloc_zeroed(memory, 1, sizeof *made);
    if (made == NULL) {
        svo_i_free(voxels);
        svo_i_free(normals);
        status = svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the list", create_name);
        goto cleanup;
    }
    made->memory = *memory;
    made->voxels = voxels;
    made->normals = normals;
    made->info = (svo_voxels_info){.struct_size = sizeof made->info,
                                   .voxel_count = source->voxel_count,
                                   .given_count = source->voxel_count,
                                   .voxel_edge = source->voxel_edge > 0.0 ? source->voxel_edge : 1.0};
    for (int axis = 0; axis < 3; ++axis) {
        made->info.origin[axis] = source->origin[axis] + 0.0; /* + 0.0 turns -0 into 0; their hashes differ */
    }
    SVO_I_TRY_CLEANUP(find_bounds(voxels, source->voxel_count, &made->info, message));
    SVO_I_TRY_CLEANUP(copy_properties(source, made, message));
    if (!is_sorted(made)) {
        SVO_I_TRY_CLEANUP(allocate_sorting(made, &s, message));
        sort_voxels(made, &s, (size_t)source->voxel_count);
    }
    const uint32_t bits = svo_i_voxel_bits(made->info.low, made->info.high);
    made->info.depth = bits < 1 ? 1 : bits > SVO_DEPTH_MAX ? 0 : bits;
    *out = made;
    made = NULL;
cleanup:
    sorting_free(&s);
    svo_voxels_destroy(&made);
    return status;
}

svo_status svo_voxels_create(const svo_voxels_source *source, svo_voxels **out, svo_message *message)
{
    svo_voxels_source given;
    if (source == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", create_name,
                          source == NULL ? "source" : "out");
    }
    SVO_I_TRY(svo_i_struct_read(message, create_name, "source", source, &given,
                                SVO_I_STRUCT_SIZES(svo_voxels_source, voxel_edge)));
    svo_i_memory memory;
    SVO_I_TRY(svo_i_memory_read(message, create_name, "source.memory", given.memory, &memory));
    SVO_I_TRY(check_source(&given, message));
    size_t bytes = 0;
    const bool fits = svo_i_mul_size((size_t)given.voxel_count, sizeof(svo_voxel), &bytes);
    const size_t normal_bytes = given.normals != NULL ? (size_t)given.voxel_count * 3 * sizeof *given.normals : 0;
    svo_voxel *voxels = fits ? svo_i_alloc(&memory, bytes + 1) : NULL;
    int16_t *normals = fits && given.normals != NULL ? svo_i_alloc(&memory, normal_bytes + 1) : NULL;
    if (voxels == NULL || (normals == NULL && given.normals != NULL)) {
        svo_i_free(voxels);
        svo_i_free(normals);
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %" PRIu64 " voxels", create_name,
                          given.voxel_count);
    }
    if (given.voxel_count > 0) {
        memcpy(voxels, given.voxels, bytes);
    }
    if (normal_bytes > 0) {
        memcpy(normals, given.normals, normal_bytes);
    }
    return svo_i_voxels_take(&memory, &given, voxels, normals, out, message);
}

svo_status svo_voxels_set_axes(svo_voxels *voxels, svo_axes axes)
{
    if ((unsigned)axes > SVO_AXES_Z_UP) {
        return SVO_INVALID_ARGUMENT;
    }
    voxels->axes = axes;
    return SVO_OK;
}

void svo_voxels_destroy(svo_voxels **voxels)
{
    if (voxels == NULL || *voxels == NULL) {
        return;
    }
    svo_i_free((*voxels)->voxels);
    svo_i_free((*voxels)->properties);
    svo_i_free((*voxels)->texts);
    svo_i_free((*voxels)->counts);
    svo_i_free((*voxels)->normals);
    svo_i_free(*voxels);
    *voxels = NULL;
}

svo_status svo_voxels_get_info(const svo_voxels *voxels, svo_voxels_info *info)
{
    if (voxels == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    return svo_i_struct_write(NULL, "svo_voxels_get_info", "info", &voxels->info, info,
                              SVO_I_STRUCT_SIZES(svo_voxels_info, property_count));
}

const svo_voxel *svo_voxels_get(const svo_voxels *voxels)
{
    return voxels->voxels;
}

const uint64_t *svo_voxels_get_counts(const svo_voxels *voxels)
{
    return voxels->counts;
}

const int16_t *svo_voxels_get_normals(const svo_voxels *voxels)
{
    return voxels->normals;
}

const svo_voxel_property *svo_voxels_get_properties(const svo_voxels *voxels)
{
    return voxels->properties;
}

/*
 * ---- of a tree ----
 *
 * Its leaves with their places. They lie in Morton order from the grid's least corner on, which is the list's order too
 * where they begin at that corner.
 */

/* The payload of leaf k is at index of_leaves + k. */
static void fill_leaf(const svo_tree *tree, uint64_t leaf, const uint32_t cell[3], const int32_t offset[3],
                      svo_voxel *voxel)
{
    const uint64_t payload = tree->info.inner_count - tree->info.level_begin[tree->info.payload_level] + leaf;
    const uint8_t *colors = tree->host[SVO_TREE_COLORS];
    const uint16_t *materials = tree->host[SVO_TREE_MATERIALS];
    *voxel = (svo_voxel){.x = offset[0] + (int32_t)cell[0],
                         .y = offset[1] + (int32_t)cell[1],
                         .z = offset[2] + (int32_t)cell[2],
                         .rgba = {255, 255, 255, 255},
                         .material = materials != NULL ? materials[payload] : 0};
    if (colors != NULL) {
        memcpy(voxel->rgba, colors + 4 * payload, 4);
    }
}

/* The normals of all leaves; *out stays NULL where the tree has none. */
static svo_status copy_normals(const svo_tree *tree, int16_t **out, svo_message *message)
{
    const svo_tree_info *info = &tree->info;
    const int16_t *normals = tree->host[SVO_TREE_NORMALS];
    const size_t bytes = (size_t)info->leaf_count * 3 * sizeof *normals;
    if (normals == NULL) {
        return SVO_OK;
    }
    *out = svo_i_alloc(&tree->memory, bytes + 1);
    if (*out == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu normals", get_name,
                          (unsigned long long)info->leaf_count);
    }
    memcpy(*out, normals + 3 * (size_t)(info->inner_count - info->level_begin[info->payload_level]), bytes);
    return SVO_OK;
}

/* Goes through the tree in depth-first order, which meets the leaves one after the other. */
static void fill_leaves(const svo_tree *tree, const int32_t offset[3], svo_voxel *voxels)
{
    const uint8_t *masks = tree->host[SVO_TREE_CHILD_MASK];
    const uint32_t *first_child = tree->host[SVO_TREE_FIRST_CHILD];
    const uint32_t depth = tree->info.depth;
    uint32_t nodes[SVO_LEVELS_MAX] = {0}; /* on the way from the root, and the children left to visit */
    uint32_t left[SVO_LEVELS_MAX] = {0};
    uint32_t cell[3] = {0, 0, 0};
    uint64_t leaf = 0;
    uint32_t level = 0;
    left[0] = masks[0];
    for (;;) {
        while (level > 0 && left[level] == 0) {
            --level;
        }
        if (left[level] == 0) {
            return;
        }
        const uint32_t octant = svo_count_bits(~left[level] & (left[level] - 1)); /* its lowest bit */
        left[level] &= left[level] - 1;
        const uint32_t shift = depth - level - 1;
        for (unsigned axis = 0; axis < 3; ++axis) {
            cell[axis] = (cell[axis] >> (shift + 1) << 1 | (octant >> axis & 1u)) << shift;
        }
        if (level + 1 == depth) {
            fill_leaf(tree, leaf, cell, offset, &voxels[leaf]);
            ++leaf;
            continue;
        }
        const uint32_t before = masks[nodes[level]] & ((1u << octant) - 1u);
        nodes[level + 1] = first_child[nodes[level]] + svo_count_bits(before);
        left[level + 1] = masks[nodes[level + 1]];
        ++level;
    }
}

/* Whether the grid's voxels are those of the world: one unit wide, from whole numbers on. */
static bool is_unit_grid(const svo_tree_info *info)
{
    bool whole =
        info->edge == ldexp(1.0, (int)info->depth) && info->scale == ldexp(1.0, (int)(info->snap_bits - info->depth));
    for (int axis = 0; axis < 3; ++axis) {
        whole = whole && rint(info->origin[axis]) == info->origin[axis] && fabs(info->origin[axis]) < 1 << 29;
    }
    return whole;
}

/* The width of a leaf. It follows from edge, without the rounding of scale, but in older files (nodes.h). */
static double leaf_edge(const svo_tree_info *info)
{
    const double units = ldexp(1.0, (int)info->snap_bits);
    return info->scale == units / info->edge ? ldexp(info->edge, -(int)info->depth)
                                             : ldexp(1.0, (int)(info->snap_bits - info->depth)) / info->scale;
}

svo_status svo_tree_get_voxels(const svo_tree *tree, svo_voxels **out, svo_message *message)
{
    if (tree == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s is NULL", get_name, tree == NULL ? "tree" : "out");
    }
    const char *undefined = svo_i_tree_undefined(tree);
    if (undefined != NULL || !tree->downloaded) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: %s", get_name,
                          undefined != NULL ? undefined : "the tree has no host arrays; call svo_tree_download first");
    }
    const svo_tree_info *info = &tree->info;
    if (info->leaf_count > SVO_VOXELS_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: the tree has %llu leaves, above %u", get_name,
                          (unsigned long long)info->leaf_count, SVO_VOXELS_MAX);
    }
    /* Twice while the list is made. */
    const uint64_t voxel_bytes = sizeof(svo_voxel) + (tree->host[SVO_TREE_NORMALS] != NULL ? 8 : 0);
    const uint64_t needed_bytes = 2 * info->leaf_count * voxel_bytes;
    if (needed_bytes > svo_i_host_memory_bytes()) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: %llu voxels need %s, above the %s that are there",
                          get_name, (unsigned long long)info->leaf_count, svo_i_bytes(needed_bytes).text,
                          svo_i_bytes(svo_i_host_memory_bytes()).text);
    }
    const bool of_world = is_unit_grid(info);
    int32_t offset[3] = {0, 0, 0};
    svo_voxels_source source = {
        .struct_size = sizeof source, .voxel_count = info->leaf_count, .voxel_edge = of_world ? 1.0 : leaf_edge(info)};
    for (int axis = 0; axis < 3; ++axis) {
        offset[axis] = of_world ? (int32_t)info->origin[axis] : 0;
        source.origin[axis] = of_world ? 0.0 : info->origin[axis];
    }
    svo_voxel *voxels = svo_i_alloc_zeroed(&tree->memory, (size_t)info->leaf_count + 1, sizeof *voxels);
    if (voxels == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu voxels", get_name,
                          (unsigned long long)info->leaf_count);
    }
    fill_leaves(tree, offset, voxels);
    int16_t *normals = NULL;
    svo_status status = copy_normals(tree, &normals, message);
    if (status != SVO_OK) {
        svo_i_free(voxels);
        return status;
    }
    status = svo_i_voxels_take(&tree->memory, &source, voxels, normals, out, message);
    if (status != SVO_OK) {
        svo_i_message_rename(message, get_name);
    }
    return status;
}
