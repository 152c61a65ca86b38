/* SPDX-License-Identifier: MIT */
/* Reads what a scene's file places, and makes one mesh of it. */
#include "support/scene_input.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/session.h"
#include "support/voxel_input.h"
#include "svocl/nodes.h"

/* ---- placed meshes: what all instances need is counted, then one after the other is written ---- */

#define MATERIALS_MAX 65535u
/* Most triangles of a placed mesh, and a third of its most vertices. */
#define PLACED_TRIANGLES_MAX (UINT32_C(1) << 24)

/* The color of an albedo of 0.6 by the sRGB curve. */
static const svo_material clay = {.rgba = {203, 203, 203, 255}, .texture_index = SVO_NO_TEXTURE};

/* What of the arrays some part has, and how long they are. */
typedef struct totals {
    uint64_t vertices, triangles, materials, textures;
    bool normals, colors, uvs, looks, finishes, maps; /* looks: materials, or colors, which need them */
} totals;

/* Where a part's materials and textures begin. */
typedef struct part_range {
    size_t first_material, first_texture;
} part_range;

typedef struct placing {
    const svo_mesh *const *parts;
    const part_range *ranges;
    totals all;
    placed_mesh *out;
    size_t vertex_count, triangle_count; /* written so far */
} placing;

/* ---- counts ---- */

static size_t materials_of(const svo_mesh *part)
{
    return part->material_count > 0 ? part->material_count : 1;
}

static void count_part(const svo_mesh *part, totals *all, part_range *range)
{
    *range = (part_range){(size_t)all->materials, (size_t)all->textures};
    all->materials += materials_of(part);
    all->textures += part->texture_count;
    all->normals = all->normals || part->normals != NULL;
    all->colors = all->colors || part->colors != NULL;
    all->uvs = all->uvs || part->uvs != NULL;
    all->looks = all->looks || part->colors != NULL || part->material_count > 0;
    all->finishes = all->finishes || part->finishes != NULL;
    all->maps = all->maps || part->normal_maps != NULL;
}

/* Vertices: as many as triangles without indices have. */
static int check_totals(program *state, const char *name, const totals *all)
{
    if (all->vertices > 3 * (uint64_t)PLACED_TRIANGLES_MAX) {
        return program_fail(state, PROGRAM_FAILED,
                            "%s: %" PRIu64 " placed vertices are above %" PRIu64 ", the most that views of light take",
                            name, all->vertices, 3 * (uint64_t)PLACED_TRIANGLES_MAX);
    }
    if (all->triangles > PLACED_TRIANGLES_MAX) {
        return program_fail(state, PROGRAM_FAILED,
                            "%s: %" PRIu64 " placed triangles are above %" PRIu32 ", the most that views of light take",
                            name, all->triangles, PLACED_TRIANGLES_MAX);
    }
    return all->materials <= MATERIALS_MAX
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED, "%s: %" PRIu64 " materials are above %u", name, all->materials,
                              MATERIALS_MAX);
}

/* ---- arrays ---- */

/* An array that is left out where it is not wanted. *worked: becomes false without memory. */
static void *make_array(bool wanted, size_t count, size_t element_bytes, bool *worked)
{
    void *made = wanted ? calloc(count > 0 ? count : 1, element_bytes) : NULL;
    *worked = *worked && (!wanted || made != NULL);
    return made;
}

static bool make_arrays(const totals *all, placed_mesh *out)
{
    const size_t vertices = (size_t)all->vertices;
    const size_t triangles = (size_t)all->triangles;
    bool worked = true;
    out->positions = make_array(true, vertices, 3 * sizeof *out->positions, &worked);
    out->indices = make_array(true, triangles, 3 * sizeof *out->indices, &worked);
    out->normals = make_array(all->normals, vertices, 3 * sizeof *out->normals, &worked);
    out->colors = make_array(all->colors, vertices, 4, &worked);
    out->uvs = make_array(all->uvs, vertices, 2 * sizeof *out->uvs, &worked);
    out->triangle_materials = make_array(all->looks, triangles, sizeof *out->triangle_materials, &worked);
    out->materials = make_array(all->looks, (size_t)all->materials, sizeof *out->materials, &worked);
    out->textures = make_array(all->looks, (size_t)all->textures, sizeof *out->textures, &worked);
    out->finishes = make_array(all->finishes, (size_t)all->materials, sizeof *out->finishes, &worked);
    out->normal_maps = make_array(all->maps, (size_t)all->materials, sizeof *out->normal_maps, &worked);
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions_double = out->positions,
                           .vertex_count = vertices,
                           .indices = out->indices,
                           .triangle_count = triangles,
                           .normals = out->normals,
                           .colors = out->colors,
                           .uvs = out->uvs,
                           .triangle_materials = out->triangle_materials,
                           .materials = out->materials,
                           .material_count = all->looks ? (size_t)all->materials : 0,
                           .textures = out->textures,
                           .texture_count = all->looks ? (size_t)all->textures : 0,
                           .finishes = out->finishes,
                           .normal_maps = out->normal_maps};
    return worked;
}

static void placed_mesh_free(placed_mesh *placed)
{
    free(placed->positions);
    free(placed->indices);
    free(placed->normals);
    free(placed->colors);
    free(placed->uvs);
    free(placed->triangle_materials);
    free(placed->materials);
    free(placed->textures);
    free(placed->finishes);
    free(placed->normal_maps);
    *placed = (placed_mesh){.positions = NULL};
}

/* ---- looks ---- */

/* A part's normal maps, or none, for materials of which it has one at least. */
static void add_normal_maps(const svo_mesh *part, const part_range *range, placed_mesh *out)
{
    for (size_t i = 0; i < materials_of(part); ++i) {
        const svo_normal_map map = part->normal_maps != NULL && i < part->material_count
                                       ? part->normal_maps[i]
                                       : (svo_normal_map){SVO_NO_TEXTURE, 1};
        out->normal_maps[range->first_material + i] = (svo_normal_map){
            map.texture_index < part->texture_count ? map.texture_index + (uint32_t)range->first_texture
                                                    : SVO_NO_TEXTURE,
            map.scale};
    }
}

/* A part's materials and textures, behind those of the parts before it. */
static void add_looks(const svo_mesh *part, const part_range *range, placed_mesh *out)
{
    svo_material *materials = out->materials + range->first_material;
    materials[0] = part->colors != NULL ? (svo_material){{255, 255, 255, 255}, SVO_NO_TEXTURE} : clay;
    for (size_t i = 0; i < part->material_count; ++i) {
        materials[i] = part->materials[i];
        materials[i].texture_index = materials[i].texture_index < part->texture_count
                                         ? materials[i].texture_index + (uint32_t)range->first_texture
                                         : SVO_NO_TEXTURE;
    }
    for (size_t i = 0; i < part->texture_count; ++i) {
        out->textures[range->first_texture + i] = part->textures[i];
    }
    for (size_t i = 0; part->finishes != NULL && i < part->material_count; ++i) {
        out->finishes[range->first_material + i] = part->finishes[i];
    }
    if (out->normal_maps != NULL) {
        add_normal_maps(part, range, out);
    }
}

/* ---- an instance ---- */

static void place_point(const float m[12], const double from[3], double to[3])
{
    for (size_t row = 0; row < 3; ++row) {
        to[row] = (double)m[4 * row] * from[0] + (double)m[4 * row + 1] * from[1] + (double)m[4 * row + 2] * from[2] +
                  (double)m[4 * row + 3];
    }
}

/* The matrix of normals: the inverse's transpose, times the determinant. Returns the determinant. */
static double find_cofactors(const float m[12], double out[9])
{
    for (size_t row = 0; row < 3; ++row) {
        const float *next = m + 4 * ((row + 1) % 3);
        const float *last = m + 4 * ((row + 2) % 3);
        for (size_t column = 0; column < 3; ++column) {
            const size_t a = (column + 1) % 3;
            const size_t b = (column + 2) % 3;
            out[3 * row + column] = (double)next[a] * (double)last[b] - (double)next[b] * (double)last[a];
        }
    }
    return (double)m[0] * out[0] + (double)m[1] * out[1] + (double)m[2] * out[2];
}

/* In unit length; zero where it has no direction. */
static void place_normal(const double cofactors[9], double side, const float from[3], float to[3])
{
    double normal[3];
    double squared = 0;
    for (size_t row = 0; row < 3; ++row) {
        const double *c = cofactors + 3 * row;
        normal[row] = side * (c[0] * (double)from[0] + c[1] * (double)from[1] + c[2] * (double)from[2]);
        squared += normal[row] * normal[row];
    }
    for (size_t row = 0; row < 3; ++row) {
        to[row] = squared > 0 && isfinite(squared) ? (float)(normal[row] / sqrt(squared)) : 0.0F;
    }
}

static void add_vertices(const placing *work, const svo_mesh *part, const float transform[12])
{
    placed_mesh *out = work->out;
    double cofactors[9];
    const double side = find_cofactors(transform, cofactors) < 0 ? -1 : 1;
    for (size_t i = 0; i < part->vertex_count; ++i) {
        const size_t to = work->vertex_count + i;
        double from[3];
        for (size_t axis = 0; axis < 3; ++axis) {
            from[axis] = part->positions_double != NULL ? part->positions_double[3 * i + axis]
                                                        : (double)part->positions[3 * i + axis];
        }
        place_point(transform, from, out->positions + 3 * to);
        if (part->normals != NULL) {
            place_normal(cofactors, side, part->normals + 3 * i, out->normals + 3 * to);
        }
    }
    if (out->colors != NULL && part->colors != NULL) {
        memcpy(out->colors + 4 * work->vertex_count, part->colors, 4 * part->vertex_count);
    } else if (out->colors != NULL) {
        memset(out->colors + 4 * work->vertex_count, 255, 4 * part->vertex_count);
    }
    if (part->uvs != NULL) {
        memcpy(out->uvs + 2 * work->vertex_count, part->uvs, 2 * part->vertex_count * sizeof *part->uvs);
    }
}

/* A vertex of a triangle in the placed mesh; one out of range stays so. */
static uint32_t vertex_of(const placing *work, const svo_mesh *part, size_t corner)
{
    const size_t vertex = part->indices != NULL ? part->indices[corner] : corner;
    return vertex < part->vertex_count ? (uint32_t)(work->vertex_count + vertex) : UINT32_MAX;
}

/* Mirrored triangles are turned around, so that their own normals stay outside. */
static void add_triangles(const placing *work, const svo_mesh *part, const svo_instance *instance)
{
    double cofactors[9];
    const size_t mirrored = find_cofactors(instance->transform, cofactors) < 0 ? 1 : 0;
    placed_mesh *out = work->out;
    for (size_t i = 0; i < part->triangle_count; ++i) {
        const size_t to = work->triangle_count + i;
        out->indices[3 * to] = vertex_of(work, part, 3 * i);
        out->indices[3 * to + 1 + mirrored] = vertex_of(work, part, 3 * i + 1);
        out->indices[3 * to + 2 - mirrored] = vertex_of(work, part, 3 * i + 2);
        if (out->triangle_materials != NULL) {
            const size_t given = part->triangle_materials != NULL ? part->triangle_materials[i] : 0;
            const size_t own = given < part->material_count ? given : 0;
            out->triangle_materials[to] = (uint16_t)(work->ranges[instance->tree].first_material + own);
        }
    }
}

static void add_instances(placing *work, const svo_instance *instances, size_t instance_count)
{
    for (size_t i = 0; i < instance_count; ++i) {
        const svo_mesh *part = work->parts[instances[i].tree];
        add_vertices(work, part, instances[i].transform);
        add_triangles(work, part, &instances[i]);
        work->vertex_count += part->vertex_count;
        work->triangle_count += part->triangle_count;
    }
}

/* ---- all of it ---- */

/* Places parts by instances, whose trees number the parts. Normals stay on their side, also under mirrors. Parts
   without colors are clay, unless none has colors. Texels are borrowed from the parts. name: of the scene, for
   messages. Returns the exit code; on failure nothing is left to free. */
static int placed_mesh_make(program *state, const char *name, const svo_mesh *const *parts, size_t part_count,
                            const svo_instance *instances, size_t instance_count, placed_mesh *out)
{
    part_range *ranges = calloc(part_count, sizeof *ranges);
    placing work = {.parts = parts, .ranges = ranges, .out = out};
    *out = (placed_mesh){.positions = NULL};
    if (ranges == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu meshes", part_count);
    }
    for (size_t i = 0; i < part_count; ++i) {
        count_part(parts[i], &work.all, &ranges[i]);
    }
    for (size_t i = 0; i < instance_count; ++i) {
        work.all.vertices += parts[instances[i].tree]->vertex_count;
        work.all.triangles += parts[instances[i].tree]->triangle_count;
    }
    int exit_code = check_totals(state, name, &work.all);
    if (exit_code == PROGRAM_DONE && !make_arrays(&work.all, out)) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: out of memory for %" PRIu64 " placed triangles", name,
                                 work.all.triangles);
    }
    if (exit_code == PROGRAM_DONE) {
        for (size_t i = 0; i < part_count && work.all.looks; ++i) {
            add_looks(parts[i], &ranges[i], out);
        }
        add_instances(&work, instances, instance_count);
    } else {
        placed_mesh_free(out);
    }
    free(ranges);
    return exit_code;
}

/* ---- surfaces of voxels: of the six neighbors of each leaf; faces are counted, then written ---- */

typedef struct faces {
    const svo_tree *tree;
    svo_tree_info info;
    svo_grid grid;
    svo_tree_arrays arrays;
    placed_mesh *out; /* NULL: counts alone */
    uint64_t count;
} faces;

/* Whether the cell beside a leaf is outside the grid or empty. step: -1 or 1. */
static bool is_open(const faces *f, const svo_node *leaf, int axis, int step)
{
    uint32_t cell[3] = {leaf->cell[0], leaf->cell[1], leaf->cell[2]};
    svo_node found = {.index = 0};
    cell[axis] += (uint32_t)step; /* below 0: wraps, and is out of range */
    return cell[axis] >> f->info.depth != 0 || svo_tree_find_cell(f->tree, f->info.depth, cell, &found) != SVO_OK ||
           found.level < f->info.depth;
}

/* The four vertices from first on get the leaf's payload. */
static void write_payload(const faces *f, const svo_node *leaf, size_t first)
{
    const size_t place = leaf->index - f->info.level_begin[f->info.payload_level];
    for (size_t vertex = first; vertex < first + 4; ++vertex) {
        if (f->arrays.colors != NULL) {
            memcpy(f->out->colors + 4 * vertex, f->arrays.colors + 4 * place, 4);
        }
        for (size_t axis = 0; axis < 3 && f->arrays.normals != NULL; ++axis) {
            f->out->normals[3 * vertex + axis] = (float)f->arrays.normals[3 * place + axis] / 32767;
        }
    }
}

/* The corners of a face go around it so that it looks outwards. */
static void write_face(const faces *f, const svo_node *leaf, int axis, int step)
{
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    const size_t first = (size_t)(4 * f->count);
    const int a = (axis + (step > 0 ? 1 : 2)) % 3;
    const int b = (axis + (step > 0 ? 2 : 1)) % 3;
    double box[2][3];
    svo_grid_cell_box(&f->grid, f->info.depth, leaf->cell, box[0], box[1]);
    for (size_t corner = 0; corner < 4; ++corner) {
        double *at = f->out->positions + 3 * (first + corner);
        at[axis] = box[step > 0 ? 1 : 0][axis];
        at[a] = box[corner == 1 || corner == 2 ? 1 : 0][a];
        at[b] = box[corner >= 2 ? 1 : 0][b];
    }
    write_payload(f, leaf, first);
    for (size_t i = 0; i < 6; ++i) {
        f->out->indices[6 * f->count + i] = (uint32_t)first + corners[i];
    }
}

static void go_through(faces *f)
{
    svo_node leaf = {.index = 0};
    f->count = 0;
    for (uint64_t i = f->info.inner_count; i < f->info.node_count; ++i) {
        (void)svo_tree_find_node(f->tree, (uint32_t)i, &leaf);
        for (int side = 0; side < 6; ++side) {
            const int axis = side / 2;
            const int step = side % 2 == 0 ? -1 : 1;
            if (!is_open(f, &leaf, axis, step)) {
                continue;
            }
            if (f->out != NULL) {
                write_face(f, &leaf, axis, step);
            }
            ++f->count;
        }
    }
}

static bool make_face_arrays(const faces *f, placed_mesh *out)
{
    const size_t count = (size_t)f->count;
    out->positions = calloc(4 * count, 3 * sizeof *out->positions);
    out->indices = calloc(6 * count, sizeof *out->indices);
    out->colors = f->arrays.colors != NULL ? calloc(4 * count, 4) : NULL;
    out->normals = f->arrays.normals != NULL ? calloc(4 * count, 3 * sizeof *out->normals) : NULL;
    out->mesh = (svo_mesh){.struct_size = sizeof out->mesh,
                           .positions_double = out->positions,
                           .vertex_count = 4 * count,
                           .indices = out->indices,
                           .triangle_count = 2 * count,
                           .normals = out->normals,
                           .colors = out->colors};
    return out->positions != NULL && out->indices != NULL && (out->colors != NULL || f->arrays.colors == NULL) &&
           (out->normals != NULL || f->arrays.normals == NULL);
}

/* tree: with host arrays. Vertices have the colors and normals of their voxels, as far as the tree has them. name: of
   the tree, for messages. Returns the exit code; on failure nothing is left to free. */
static int voxel_faces_make(program *state, const char *name, const svo_tree *tree, placed_mesh *out)
{
    faces f = {.tree = tree, .info = SVO_TREE_INFO_INIT, .arrays = SVO_TREE_ARRAYS_INIT};
    *out = (placed_mesh){.positions = NULL};
    (void)svo_tree_get_info(tree, &f.info);
    (void)svo_tree_get_grid(tree, &f.grid);
    (void)svo_tree_get_arrays(tree, &f.arrays);
    go_through(&f);
    if (f.count == 0) {
        return program_fail(state, PROGRAM_FAILED, "%s: the tree has no voxels", name);
    }
    if (2 * f.count > PLACED_TRIANGLES_MAX) {
        return program_fail(state, PROGRAM_FAILED,
                            "%s: %" PRIu64 " triangles around its voxels are above %" PRIu32
                            ", the most that views of light take",
                            name, 2 * f.count, PLACED_TRIANGLES_MAX);
    }
    if (!make_face_arrays(&f, out)) {
        placed_mesh_free(out);
        return program_fail(state, PROGRAM_FAILED, "%s: out of memory for %" PRIu64 " faces of voxels", name, f.count);
    }
    f.out = out;
    go_through(&f);
    return PROGRAM_DONE;
}

/* ---- scenes ---- */

static int read_voxels(program *state, placed_mesh *out)
{
    svo_tree *tree = NULL;
    int exit_code = input_load_tree(state, &tree);
    if (exit_code == PROGRAM_DONE) {
        exit_code = voxel_faces_make(state, state->options.input, tree, out);
    }
    svo_tree_destroy(&tree);
    return exit_code;
}

/* The tree of a list of voxels, at the least depth unless the scene's file names one, as pictures of it have. */
static int build_voxels(program *state, const voxel_input *list, unsigned depth, placed_mesh *out)
{
    session opened;
    svo_tree *tree = NULL;
    int exit_code = session_open_device(state, &opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (svo_voxels_build(opened.device, list->voxels, depth, NULL, opened.queue, &tree, NULL) != SVO_OK ||
        svo_tree_download(tree, opened.queue) != SVO_OK) {
        exit_code = program_fail_library(state, svo_device_message(opened.device));
    } else {
        exit_code = voxel_faces_make(state, state->options.input, tree, out);
    }
    svo_tree_destroy(&tree);
    session_close(&opened);
    return exit_code;
}

static int read_voxel_file(program *state, unsigned depth, placed_mesh *out)
{
    voxel_input list;
    progress_step(state->progress, "reading the voxels");
    int exit_code = voxel_input_open(state, &list);
    if (exit_code == PROGRAM_DONE) {
        exit_code = build_voxels(state, &list, depth, out);
    }
    voxel_input_close(&list);
    return exit_code;
}

/* The tree's path stands in for INPUT. */
static int read_tree(program *state, const scene_file_tree *tree, input *source, placed_mesh *voxels)
{
    const char *before = state->options.input;
    const double voxel_size = state->options.voxel_size;
    int exit_code = PROGRAM_DONE;
    state->options.input = tree->path;
    state->options.voxel_size = 0.0; /* of trees, which are not made here */
    if (input_is_tree(state)) {
        exit_code = read_voxels(state, voxels);
    } else if (voxel_input_is_given(state)) {
        exit_code = read_voxel_file(state, tree->depth, voxels);
    } else {
        exit_code = input_open(state, source);
    }
    state->options.input = before;
    state->options.voxel_size = voxel_size;
    return exit_code;
}

static int read_trees(program *state, const scene_file *file, scene_input *out)
{
    int exit_code = PROGRAM_DONE;
    out->sources = calloc(file->tree_count, sizeof *out->sources);
    out->voxels = calloc(file->tree_count, sizeof *out->voxels);
    if (out->sources == NULL || out->voxels == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu trees", file->tree_count);
    }
    out->count = file->tree_count;
    for (size_t i = 0; i < file->tree_count && exit_code == PROGRAM_DONE; ++i) {
        exit_code = read_tree(state, &file->trees[i], &out->sources[i], &out->voxels[i]);
    }
    return exit_code;
}

static int place(program *state, const scene_file *file, scene_input *out)
{
    const svo_mesh **parts = calloc(out->count, sizeof *parts);
    if (parts == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu trees", out->count);
    }
    for (size_t i = 0; i < out->count; ++i) {
        parts[i] = out->sources[i].mesh != NULL ? out->sources[i].mesh : &out->voxels[i].mesh;
    }
    const int exit_code = placed_mesh_make(state, file->source.path, parts, out->count, file->instances,
                                           file->instance_count, &out->placed);
    free(parts);
    return exit_code;
}

int scene_input_open(program *state, const scene_file *file, scene_input *out)
{
    *out = (scene_input){.count = 0};
    int exit_code = read_trees(state, file, out);
    if (exit_code == PROGRAM_DONE) {
        exit_code = place(state, file, out);
    }
    if (exit_code != PROGRAM_DONE) {
        scene_input_close(out);
    }
    return exit_code;
}

void scene_input_close(scene_input *opened)
{
    placed_mesh_free(&opened->placed);
    for (size_t i = 0; i < opened->count; ++i) {
        input_close(&opened->sources[i]);
        placed_mesh_free(&opened->voxels[i]);
    }
    free(opened->sources);
    free(opened->voxels);
    *opened = (scene_input){.count = 0};
}
