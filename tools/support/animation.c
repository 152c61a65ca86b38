/* SPDX-License-Identifier: MIT */
/* Objects out of a scene's surfaces, their grid, and their places in a frame. */
#include "support/animation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/picture.h"
#include "support/viewpoint.h"

#define FRAMES_DEFAULT 60u

static int fail_library(const animation *film)
{
    return program_fail_library(film->state, svo_device_message(film->device));
}

/* ---- the scene ---- */

/* The instances, of which those that are static come first, and the others are at the origin, where transforms move
   them from. */
static int sort_instances(program *state, const scene_file *file, svo_instance **sorted)
{
    size_t used = 0;
    size_t motion = 0;
    *sorted = malloc(file->instance_count * sizeof **sorted);
    if (*sorted == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for %zu instances", file->instance_count);
    }
    for (size_t i = 0; i < file->instance_count; ++i) {
        const bool moves = motion < file->motion_count && file->motions[motion].instance == i;
        motion += moves ? 1 : 0;
        if (!moves) {
            (*sorted)[used++] = file->instances[i];
        }
    }
    if (used == 0) {
        return program_fail(state, PROGRAM_FAILED, "%s: all instances have a 'motion'; one must be static",
                            file->source.path);
    }
    for (size_t i = 0; i < file->motion_count; ++i) {
        (*sorted)[used++] =
            (svo_instance){file->instances[file->motions[i].instance].tree, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    }
    return PROGRAM_DONE;
}

static const svo_mesh *part_of(const animation *film, const svo_instance *instance)
{
    const scene_input *opened = &film->opened;
    const svo_mesh *mesh = opened->sources[instance->tree].mesh;
    return mesh != NULL ? mesh : &opened->voxels[instance->tree].mesh;
}

/* Cuts vertices and triangles out of the scene's mesh. */
static bool cut(const svo_mesh *whole, const size_t first[2], const size_t count[2], animation_actor *out)
{
    out->mesh = *whole;
    out->mesh.vertex_count = count[0];
    out->mesh.triangle_count = count[1];
    out->mesh.positions_double = whole->positions_double + first[0] * 3;
    out->mesh.normals = whole->normals != NULL ? whole->normals + first[0] * 3 : NULL;
    out->mesh.colors = whole->colors != NULL ? whole->colors + first[0] * 4 : NULL;
    out->mesh.uvs = whole->uvs != NULL ? whole->uvs + first[0] * 2 : NULL;
    out->mesh.triangle_materials = whole->triangle_materials != NULL ? whole->triangle_materials + first[1] : NULL;
    out->indices = malloc((count[1] * 3 + 1) * sizeof *out->indices);
    for (size_t i = 0; i < count[1] * 3 && out->indices != NULL; ++i) {
        out->indices[i] = whole->indices[first[1] * 3 + i] - (uint32_t)first[0];
    }
    out->mesh.indices = out->indices;
    return out->indices != NULL;
}

/* Cuts the scene's mesh into the static one and the objects. sorted: its instances. */
static int make_actors(animation *film, const scene_file *sorted)
{
    const svo_mesh *whole = &film->opened.placed.mesh;
    const size_t still_count = sorted->instance_count - sorted->motion_count;
    size_t first[2] = {0, 0};
    bool fits = true;
    film->actors = calloc(sorted->motion_count + 1, sizeof *film->actors);
    film->actor_count = film->actors != NULL ? sorted->motion_count : 0;
    for (size_t i = 0; i < sorted->instance_count && film->actors != NULL; ++i) {
        const svo_mesh *part = part_of(film, &sorted->instances[i]);
        const size_t count[2] = {part->vertex_count, part->triangle_count};
        if (i >= still_count) {
            animation_actor *made = &film->actors[i - still_count];
            made->motion = &sorted->motions[i - still_count];
            fits = fits && cut(whole, first, count, made);
        }
        first[0] += count[0];
        first[1] += count[1];
        if (i + 1 == still_count) {
            fits = fits && cut(whole, (const size_t[2]){0, 0}, first, &film->still);
        }
    }
    return fits && film->actors != NULL
               ? PROGRAM_DONE
               : program_fail(film->state, PROGRAM_FAILED, "out of memory for %zu objects", sorted->motion_count);
}

/* ---- time ---- */

uint64_t animation_frame_count(const program *state)
{
    return state->options.frames != 0 ? state->options.frames : FRAMES_DEFAULT;
}

static void find_times(animation *film, const scene_file *file)
{
    film->first_time = INFINITY;
    film->last_time = -INFINITY;
    for (size_t i = 0; i < file->motion_count; ++i) {
        const scene_motion *motion = &file->motions[i];
        film->first_time = fminf(film->first_time, motion->keys[0].time);
        film->last_time = fmaxf(film->last_time, motion->keys[motion->key_count - 1].time);
    }
}

double animation_time(const animation *film, uint64_t frame)
{
    const double part = film->frame_count > 1 ? (double)frame / (double)(film->frame_count - 1) : 0.0;
    return (double)film->first_time + part * (double)(film->last_time - film->first_time);
}

static void transform_at(const animation *film, const animation_actor *one, uint64_t frame, double out[12])
{
    float matrix[12];
    const scene_place place = scene_motion_at(one->motion, (float)animation_time(film, frame));
    scene_place_compose(&place, matrix);
    for (int i = 0; i < 12; ++i) {
        out[i] = (double)matrix[i];
    }
}

/* ---- the grid ---- */

/* A box in the world. */
typedef struct box {
    double low[3], high[3];
} box;

static void grow(box *b, const double p[3])
{
    for (int k = 0; k < 3; ++k) {
        b->low[k] = fmin(b->low[k], p[k]);
        b->high[k] = fmax(b->high[k], p[k]);
    }
}

static void grow_by_actor(box *b, const animation_actor *one, const double m[12])
{
    for (size_t v = 0; v < one->mesh.vertex_count; ++v) {
        const double *p = one->mesh.positions_double + v * 3;
        double q[3];
        for (size_t k = 0; k < 3; ++k) {
            const double *row = m + 4 * k;
            q[k] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
        }
        grow(b, q);
    }
}

static double area_of(const svo_mesh *mesh)
{
    double area = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const double *a = mesh->positions_double + (size_t)mesh->indices[t * 3] * 3;
        const double *b = mesh->positions_double + (size_t)mesh->indices[t * 3 + 1] * 3;
        const double *c = mesh->positions_double + (size_t)mesh->indices[t * 3 + 2] * 3;
        double n[3];
        for (int k = 0; k < 3; ++k) {
            const int i = (k + 1) % 3;
            const int j = (k + 2) % 3;
            n[k] = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
        }
        area += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }
    return isfinite(area) ? area : 0.0;
}

/* The largest factor by which the keys of a motion enlarge areas. */
static double enlargement(const scene_motion *motion)
{
    double most = 0.0;
    for (size_t i = 0; i < motion->key_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            most = fmax(most, fabs((double)motion->keys[i].place.scale[k]));
        }
    }
    return most * most;
}

/* A grid around all frames, unless the options have one, and room for the areas of all. */
static void choose_grid(animation *film)
{
    const options *given = &film->state->options;
    static const double still[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    box around = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    film->grid = (svo_moving_options){.struct_size = sizeof film->grid};
    film->grid.max_area = 1.01 * area_of(&film->still.mesh);
    grow_by_actor(&around, &film->still, still);
    for (size_t i = 0; i < film->actor_count; ++i) {
        film->grid.max_area += 1.01 * area_of(&film->actors[i].mesh) * enlargement(film->actors[i].motion);
        for (uint64_t frame = 0; frame < film->frame_count; ++frame) {
            double transform[12];
            transform_at(film, &film->actors[i], frame, transform);
            grow_by_actor(&around, &film->actors[i], transform);
        }
    }
    film->grid.edge = given->edge;
    memcpy(film->grid.origin, given->origin, sizeof film->grid.origin);
    if (given->edge > 0.0) {
        return;
    }
    for (int k = 0; k < 3; ++k) {
        film->grid.edge = fmax(film->grid.edge, 1.01 * (around.high[k] - around.low[k]));
    }
    for (int k = 0; k < 3; ++k) {
        film->grid.origin[k] = around.low[k] - 0.005 * film->grid.edge;
    }
}

/* ---- opening ---- */

static int start_scene(animation *film)
{
    const options *given = &film->state->options;
    choose_grid(film);
    film->grid.need = picture_need(&(input){.mesh = &film->opened.placed.mesh}, given->need);
    film->grid.coverage = (svo_coverage)given->coverage;
    film->grid.weights = (svo_weights)given->weights;
    film->grid.drop_alpha = given->drop_alpha;
    if (svo_moving_create(film->device, &film->still.mesh, (unsigned)given->depth, &film->grid, film->queue,
                          &film->moving) != SVO_OK) {
        return fail_library(film);
    }
    for (size_t i = 0; i < film->actor_count; ++i) {
        double transform[12];
        transform_at(film, &film->actors[i], 0, transform);
        if (svo_moving_add(film->moving, &film->actors[i].mesh, transform, &film->actors[i].object) != SVO_OK) {
            return fail_library(film);
        }
    }
    return PROGRAM_DONE;
}

int animation_open(program *state, const scene_file *file, svo_device *device, cl_command_queue queue, animation *out)
{
    scene_file sorted = *file;
    *out = (animation){.state = state, .device = device, .queue = queue, .frame_count = animation_frame_count(state)};
    find_times(out, file);
    int exit_code = sort_instances(state, file, &sorted.instances);
    exit_code = exit_code == PROGRAM_DONE ? scene_input_open(state, &sorted, &out->opened) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? make_actors(out, &sorted) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? start_scene(out) : exit_code;
    free(sorted.instances);
    if (exit_code != PROGRAM_DONE) {
        animation_close(out);
    }
    return exit_code;
}

void animation_close(animation *film)
{
    svo_moving_destroy(&film->moving);
    free(film->still.indices);
    for (size_t i = 0; i < film->actor_count; ++i) {
        free(film->actors[i].indices);
    }
    free(film->actors);
    scene_input_close(&film->opened);
    *film = (animation){.actor_count = 0};
}

/* ---- frames ---- */

svo_status animation_update(animation *film, uint64_t frame, svo_moving_report *report)
{
    for (size_t i = 0; i < film->actor_count; ++i) {
        double transform[12];
        transform_at(film, &film->actors[i], frame, transform);
        const svo_status status = svo_moving_set_transform(film->moving, film->actors[i].object, transform);
        if (status != SVO_OK) {
            return status;
        }
    }
    return svo_moving_update(film->moving, NULL, report);
}

svo_tree *animation_tree(const animation *film)
{
    return svo_moving_tree(film->moving);
}

int animation_camera(const animation *film, const scene_file *file, float aspect, svo_camera *camera)
{
    const bool framed = !file->has_camera || film->state->options.from_side > 0;
    if (framed && svo_tree_download(animation_tree(film), film->queue) != SVO_OK) {
        return fail_library(film);
    }
    const viewpoint_subject shown = {.camera = file->has_camera ? &file->camera : NULL,
                                     .target = svo_tree_target(animation_tree(film)),
                                     .aspect = aspect};
    return viewpoint_place(film->state, &shown, camera);
}
