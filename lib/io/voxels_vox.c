/* SPDX-License-Identifier: MIT */
/*
 * The .vox reader: places the models of a file, which voxels_vox_file.c reads, as the scene says, or one of them where
 * there is no scene. The scene is walked twice: once to count instances and voxels against their limits, once to place
 * them. Transforms compose as R = Rp Rc, T = Rp Tc + Tp for parent p and child c: a child's translation turns with its
 * parent.
 */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "io/voxels_formats.h"
#include "io/voxels_vox_file.h"

/* Groups may share children, so that a small file could be walked for ever. */
#define VISITS_MAX      (UINT64_C(4) * SVO_VOXEL_INSTANCES_MAX)
#define TRANSLATION_MAX (INT64_C(1) << 30)

/* A node on the way from the root. */
typedef struct step {
    vox_node *node;
    vox_transform transform; /* of what is in the node */
    bool hidden;
    uint32_t next_child;
} step;

/* A model where it is placed. */
typedef struct placed_model {
    size_t model;
    vox_transform transform;
} placed_model;

typedef struct walk {
    vox_file *file;
    bool counts; /* else it places */
    placed_model *placed; /* where models are listed in place of their voxels; else NULL */
    size_t placed_count;
    step *path; /* VOX_DEPTH_MAX of them */
    size_t depth;
    uint64_t visits;
    uint64_t voxels;
} walk;

static const vox_transform identity = {.column = {0, 1, 2}, .sign = {1, 1, 1}};

static svo_status node_damaged(const walk *w, const vox_node *node, const char *what, int32_t value)
{
    static const char *const names[] = {"nTRN", "nGRP", "nSHP"};
    return svo_i_voxels_damaged(w->file->reader, "chunk %s at byte %zu: node %" PRId32 " %s %" PRId32,
                                names[node->kind], node->offset, node->id, what, value);
}

static int compare_nodes(const void *a, const void *b)
{
    const vox_node *left = a;
    const vox_node *right = b;
    return (left->id > right->id) - (left->id < right->id);
}

static vox_node *find_node(const vox_file *file, int32_t id)
{
    const vox_node key = {.id = id};
    return bsearch(&key, file->nodes, file->node_count, sizeof key, compare_nodes);
}

static int compare_layers(const void *a, const void *b)
{
    const vox_layer *left = a;
    const vox_layer *right = b;
    return left->id != right->id ? (left->id > right->id) - (left->id < right->id)
                                 : (left->offset > right->offset) - (left->offset < right->offset);
}

/* Whether a layer is hidden; the last chunk of an id counts. */
static bool is_hidden_layer(const vox_file *file, int32_t id)
{
    size_t begin = 0; /* layers before it have at most this id */
    size_t end = file->layer_count;
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (file->layers[middle].id <= id) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    return begin > 0 && file->layers[begin - 1].id == id && file->layers[begin - 1].hidden;
}

static vox_transform compose(const vox_transform *parent, const vox_transform *child)
{
    vox_transform made = identity;
    for (int row = 0; row < 3; ++row) {
        const uint8_t through = parent->column[row];
        made.column[row] = child->column[through];
        made.sign[row] = (int8_t)(parent->sign[row] * child->sign[through]);
        made.translation[row] = parent->sign[row] * child->translation[through] + parent->translation[row];
    }
    return made;
}

static bool is_rotated(const vox_transform *transform)
{
    return memcmp(transform->column, identity.column, sizeof identity.column) != 0 ||
           memcmp(transform->sign, identity.sign, sizeof identity.sign) != 0;
}

/* n / 2 rounded down. */
static int32_t half(int32_t n)
{
    return n >= 0 ? n / 2 : -((1 - n) / 2);
}

/* Voxel p of a model of size s goes to floor(R (2 p + 1 - 2 floor(s / 2)) / 2) + T: the model turns about the corner of
   its middle voxel. */
static void place_model(walk *w, const vox_model *model, const vox_transform *transform)
{
    voxel_reader *reader = w->file->reader;
    for (uint32_t i = 0; i < model->count; ++i) {
        const uint8_t *entry = model->voxels + 4 * (size_t)i;
        int32_t doubled[3];
        int32_t place[3];
        if (entry[3] == 0) {
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            doubled[axis] = 2 * entry[axis] + 1 - model->size[axis] / 2 * 2;
        }
        for (int row = 0; row < 3; ++row) {
            place[row] =
                half(transform->sign[row] * doubled[transform->column[row]]) + (int32_t)transform->translation[row];
        }
        svo_voxel voxel = {.x = place[0], .y = place[1], .z = place[2], .material = entry[3]};
        memcpy(voxel.rgba, w->file->palette[entry[3]], 4);
        svo_i_voxels_add(reader, voxel);
    }
}

/* Counts or places the model of a shape. */
static svo_status visit_shape(walk *w, const step *at)
{
    vox_file *file = w->file;
    svo_voxel_file_info *info = &file->reader->info;
    if ((size_t)at->node->child >= file->model_count) {
        return node_damaged(w, at->node, "names a model that the file does not have:", at->node->child);
    }
    vox_model *model = &file->models[at->node->child];
    if (at->hidden && file->reader->options.hidden == 0) {
        info->hidden_instances += w->counts ? 1 : 0;
        return SVO_OK;
    }
    if (!w->counts && w->placed != NULL) {
        w->placed[w->placed_count++] = (placed_model){(size_t)at->node->child, at->transform};
        return SVO_OK;
    }
    if (!w->counts) {
        place_model(w, model, &at->transform);
        return SVO_OK;
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t t = at->transform.translation[axis];
        if (t < -TRANSLATION_MAX || t > TRANSLATION_MAX) {
            return node_damaged(w, at->node, "is moved beyond 2^30 along axis", axis);
        }
    }
    if (info->instances == SVO_VOXEL_INSTANCES_MAX) {
        return node_damaged(w, at->node, "is beyond the limit of instances,", SVO_VOXEL_INSTANCES_MAX);
    }
    ++info->instances;
    model->is_placed = true;
    info->rotated_instances += is_rotated(&at->transform) ? 1 : 0;
    w->voxels += model->filled;
    return SVO_OK;
}

/* Goes to a node below the one that the walk is at. */
static svo_status enter(walk *w, const vox_node *from, int32_t id)
{
    vox_node *node = find_node(w->file, id);
    if (node == NULL) {
        return node_damaged(w, from, "has a child that is not there:", id);
    }
    if (node->on_path) {
        return node_damaged(w, node, "contains itself, by its child", from->id);
    }
    if (w->depth == VOX_DEPTH_MAX) {
        return node_damaged(w, node, "lies deeper than", VOX_DEPTH_MAX);
    }
    if (++w->visits > VISITS_MAX) {
        return node_damaged(w, node, "is visited too often: the limit of all visits is", (int32_t)VISITS_MAX);
    }
    const step *parent = w->depth > 0 ? &w->path[w->depth - 1] : NULL;
    step *entered = &w->path[w->depth];
    *entered = (step){.node = node,
                      .transform = parent != NULL ? parent->transform : identity,
                      .hidden = (parent != NULL && parent->hidden) || node->hidden};
    if (node->kind == VOX_NODE_TRANSFORM) {
        entered->transform = compose(&entered->transform, &node->transform);
        entered->hidden = entered->hidden || is_hidden_layer(w->file, node->layer);
    }
    node->on_path = true;
    ++w->depth;
    return SVO_OK;
}

/* Enters the next child of the node that the walk is at, or leaves the node. */
static svo_status advance(walk *w)
{
    step *at = &w->path[w->depth - 1];
    vox_node *node = at->node;
    const uint32_t children =
        node->kind == VOX_NODE_GROUP ? node->child_count : (node->kind == VOX_NODE_TRANSFORM ? 1 : 0);
    if (at->next_child < children) {
        int32_t id = node->child;
        if (node->kind == VOX_NODE_GROUP) {
            memcpy(&id, node->children + (size_t)at->next_child * VOX_NODE_BYTES, sizeof id);
        }
        ++at->next_child;
        return enter(w, node, id);
    }
    const svo_status status = node->kind == VOX_NODE_SHAPE ? visit_shape(w, at) : SVO_OK;
    node->on_path = false;
    --w->depth;
    return status;
}

static svo_status walk_scene(walk *w)
{
    w->visits = 0;
    SVO_I_TRY(enter(w, &w->file->nodes[0], 0));
    while (w->depth > 0) {
        SVO_I_TRY(advance(w));
    }
    return SVO_OK;
}

/* Sorts the layers and the nodes by id; each node's id may occur once, and node 0 is the root. */
static svo_status sort_scene(const walk *w)
{
    vox_file *file = w->file;
    if (file->layer_count > 0) {
        qsort(file->layers, file->layer_count, sizeof *file->layers, compare_layers);
    }
    qsort(file->nodes, file->node_count, sizeof *file->nodes, compare_nodes);
    for (size_t i = 1; i < file->node_count; ++i) {
        if (file->nodes[i - 1].id == file->nodes[i].id) {
            return node_damaged(w, &file->nodes[i], "has the id of another node:", file->nodes[i].id);
        }
    }
    return find_node(file, 0) != NULL ? SVO_OK
                                      : node_damaged(w, &file->nodes[0], "has the least id; there is no root,", 0);
}

/* ---- models by themselves ---- */

static int compare_placed(const void *a, const void *b)
{
    const placed_model *left = a;
    const placed_model *right = b;
    for (int row = 0; left->model == right->model && row < 3; ++row) {
        const int64_t l = left->transform.translation[row];
        const int64_t r = right->transform.translation[row];
        if (l != r) {
            return (l > r) - (l < r);
        }
    }
    return left->model != right->model ? (left->model > right->model) - (left->model < right->model)
                                       : memcmp(&left->transform, &right->transform, 6); /* columns and signs */
}

/* The matrix of a transform; turned: where y is up in the list, and (x, y, z) of the file is (x, z, -y). */
static void write_transform(const vox_transform *transform, bool turned, double out[12])
{
    static const size_t axes[3] = {0, 2, 1}; /* of the list, by those of the file; and back */
    memset(out, 0, 12 * sizeof *out);
    for (size_t row = 0; row < 3; ++row) {
        const uint8_t column = transform->column[row];
        const size_t to = turned ? axes[row] : row;
        const size_t from = turned ? axes[column] : column;
        const int sign = turned && (row == 1) != (column == 1) ? -transform->sign[row] : transform->sign[row];
        const int64_t at = transform->translation[row];
        out[4 * to + from] = sign;
        out[4 * to + 3] = (double)(turned && row == 1 ? -at : at);
    }
}

/* Gives the models to the reader's take_part, one after the other. */
static svo_status give_models(vox_file *file, placed_model *placed, size_t count)
{
    voxel_reader *reader = file->reader;
    const bool turned = svo_i_voxels_are_turned((svo_axes)reader->options.axes, SVO_VOXEL_FORMAT_VOX);
    walk w = {.file = file};
    svo_status status = SVO_OK;
    double *transforms = svo_i_alloc_zeroed(&reader->memory, count, 12 * sizeof *transforms);
    if (transforms == NULL) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %zu instances", count);
    }
    qsort(placed, count, sizeof *placed, compare_placed);
    for (size_t i = 0, end = 0; i < count; i = end) {
        const vox_model *model = &file->models[placed[i].model];
        for (end = i; end < count && placed[end].model == placed[i].model; ++end) {
            write_transform(&placed[end].transform, turned, transforms + 12 * (end - i));
        }
        if (model->filled > 0) {
            reader->voxel_count = 0;
            SVO_I_TRY_CLEANUP(svo_i_voxels_reserve(reader, model->filled));
            place_model(&w, model, &identity);
            SVO_I_TRY_CLEANUP(reader->take_part(reader, placed[i].model, transforms, end - i));
        }
    }
cleanup:
    svo_i_free(transforms);
    return status;
}

/* The same for all that a walk places, after it has counted. */
static svo_status give_scene(walk *w)
{
    const svo_voxel_file_info *info = &w->file->reader->info;
    w->placed = svo_i_alloc_zeroed(&w->file->reader->memory, (size_t)info->instances + 1, sizeof *w->placed);
    if (w->placed == NULL) {
        return svo_i_voxels_fail(w->file->reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %" PRIu64 " instances",
                                 info->instances);
    }
    w->counts = false;
    svo_status status = walk_scene(w);
    if (status == SVO_OK && w->placed_count > 0) {
        status = give_models(w->file, w->placed, w->placed_count);
    }
    svo_i_free(w->placed);
    return status;
}

/* Counts what the scene shows; then places it where places is true. */
static svo_status place_scene(vox_file *file, bool places)
{
    svo_status status = SVO_OK;
    step *path = svo_i_alloc_zeroed(&file->reader->memory, VOX_DEPTH_MAX, sizeof *path);
    walk w = {.file = file, .counts = true, .path = path};
    if (path == NULL) {
        return svo_i_voxels_fail(file->reader, SVO_OUT_OF_HOST_MEMORY, "no memory for the scene");
    }
    SVO_I_TRY_CLEANUP(sort_scene(&w));
    SVO_I_TRY_CLEANUP(walk_scene(&w));
    file->reader->info.instance_voxels = w.voxels;
    if (file->reader->take_part != NULL) {
        SVO_I_TRY_CLEANUP(give_scene(&w));
    } else if (places) {
        SVO_I_TRY_CLEANUP(svo_i_voxels_reserve(file->reader, w.voxels));
        w.counts = false;
        SVO_I_TRY_CLEANUP(walk_scene(&w));
    }
cleanup:
    svo_i_free(path);
    return status;
}

/* Without a scene the frame is the number of a model, whose voxels stay where they are. */
static svo_status place_frame(vox_file *file, bool places)
{
    voxel_reader *reader = file->reader;
    const uint32_t frame = reader->options.frame;
    if (file->model_count == 0) {
        return svo_i_voxels_damaged(reader, "chunk MAIN at byte 8: no model in it");
    }
    if (frame >= file->model_count) {
        return svo_i_voxels_fail(reader, SVO_INVALID_ARGUMENT, "frame %" PRIu32 " is not below its %zu models", frame,
                                 file->model_count);
    }
    vox_model *model = &file->models[frame];
    walk w = {.file = file};
    vox_transform where_it_is = identity;
    for (int axis = 0; axis < 3; ++axis) {
        where_it_is.translation[axis] = model->size[axis] / 2;
    }
    model->is_placed = true;
    reader->info.instances = 1;
    reader->info.instance_voxels = model->filled;
    if (reader->take_part != NULL) {
        return give_models(file, &(placed_model){frame, where_it_is}, 1);
    }
    if (places) {
        SVO_I_TRY(svo_i_voxels_reserve(reader, model->filled));
        place_model(&w, model, &where_it_is);
    }
    return SVO_OK;
}

static svo_status place(vox_file *file, bool places)
{
    svo_voxel_file_info *info = &file->reader->info;
    info->instances = 0;
    SVO_I_TRY(file->node_count > 0 ? place_scene(file, places) : place_frame(file, places));
    for (size_t i = 0; i < file->model_count; ++i) {
        info->left_out_models += file->models[i].is_placed ? 0 : 1;
    }
    return SVO_OK;
}

static svo_status read_vox(voxel_reader *reader, bool places)
{
    vox_file file = {.reader = reader, .packed = -1};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_vox_read_file(&file));
    SVO_I_TRY_CLEANUP(place(&file, places));
cleanup:
    svo_i_free(file.models);
    svo_i_free(file.nodes);
    svo_i_free(file.layers);
    return status;
}

svo_status svo_i_voxels_read_vox(voxel_reader *reader)
{
    return read_vox(reader, true);
}

svo_status svo_i_voxels_check_vox(voxel_reader *reader)
{
    return read_vox(reader, false);
}
