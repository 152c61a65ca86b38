/* SPDX-License-Identifier: MIT */
/*
 * Renders what moves in a scene: instances without a motion are the static mesh of one tree, each of the others is an
 * object in it. Between frames the tree is updated, not built.
 */
#include "svocl/render_animation.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/output.h"
#include "support/picture.h"
#include "support/scene_file.h"
#include "support/scene_input.h"
#include "support/session.h"
#include "support/table.h"
#include "support/viewpoint.h"

#define FRAMES_DEFAULT 60
#define DIGITS         3
#define PATH_BYTES     4200

/* A part of the scene's mesh: an object, or the static mesh. */
typedef struct actor {
    const scene_motion *motion; /* NULL: static */
    svo_mesh mesh; /* a view of the scene's arrays, but for its indices */
    uint32_t *indices; /* owned */
    uint32_t object; /* its number */
} actor;

typedef struct animation {
    program *state;
    scene_file file;
    scene_input opened;
    session session;
    actor still, *actors; /* what is static, and objects */
    size_t actor_count;
    svo_moving *moving;
    svo_moving_options grid;
    svo_camera camera;
    float first_time, last_time;
    uint64_t frame_count;
    cJSON *frames; /* for --json */
    double update_ms, build_ms; /* of all frames but the first */
} animation;

static int fail_library(const animation *film)
{
    return program_fail_library(film->state, svo_device_message(film->session.device));
}

/* ---- the scene ---- */

/* Puts the instances that are static first, and the others at the origin, where transforms move them from. */
static int sort_instances(animation *film)
{
    scene_file *file = &film->file;
    const size_t count = file->instance_count;
    svo_instance *sorted = malloc(count * sizeof *sorted);
    size_t used = 0;
    size_t motion = 0;
    if (sorted == NULL) {
        return program_fail(film->state, PROGRAM_FAILED, "out of memory for %zu instances", count);
    }
    for (size_t i = 0; i < count; ++i) {
        const bool moves = motion < file->motion_count && file->motions[motion].instance == i;
        motion += moves ? 1 : 0;
        if (!moves) {
            sorted[used++] = file->instances[i];
        }
    }
    for (size_t i = 0; i < file->motion_count; ++i) {
        const svo_instance origin = {file->instances[file->motions[i].instance].tree,
                                     {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
        sorted[used++] = origin;
    }
    free(file->instances);
    file->instances = sorted;
    return used > file->motion_count
               ? PROGRAM_DONE
               : program_fail(film->state, PROGRAM_FAILED, "%s: all instances have a 'motion'; one must be static",
                              file->source.path);
}

static const svo_mesh *part_of(const animation *film, size_t instance)
{
    const uint32_t tree = film->file.instances[instance].tree;
    const scene_input *opened = &film->opened;
    return opened->sources[tree].mesh != NULL ? opened->sources[tree].mesh : &opened->voxels[tree].mesh;
}

/* Cuts vertices and triangles out of the scene's mesh. */
static bool cut(const svo_mesh *whole, const size_t first[2], const size_t count[2], actor *out)
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

/* Cuts the scene's mesh into the static one and the objects. */
static int make_actors(animation *film)
{
    const svo_mesh *whole = &film->opened.placed.mesh;
    const size_t still_count = film->file.instance_count - film->file.motion_count;
    size_t first[2] = {0, 0};
    bool fits = true;
    film->actors = calloc(film->file.motion_count + 1, sizeof *film->actors);
    film->actor_count = film->actors != NULL ? film->file.motion_count : 0;
    for (size_t i = 0; i < film->file.instance_count && film->actors != NULL; ++i) {
        const svo_mesh *part = part_of(film, i);
        const size_t count[2] = {part->vertex_count, part->triangle_count};
        if (i >= still_count) {
            actor *made = &film->actors[i - still_count];
            made->motion = &film->file.motions[i - still_count];
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
               : program_fail(film->state, PROGRAM_FAILED, "out of memory for %zu objects", film->file.motion_count);
}

/* ---- time ---- */

static void find_times(animation *film)
{
    film->first_time = INFINITY;
    film->last_time = -INFINITY;
    for (size_t i = 0; i < film->file.motion_count; ++i) {
        const scene_motion *motion = &film->file.motions[i];
        film->first_time = fminf(film->first_time, motion->keys[0].time);
        film->last_time = fmaxf(film->last_time, motion->keys[motion->key_count - 1].time);
    }
}

static void transform_at(const animation *film, const actor *one, uint64_t frame, double out[12])
{
    float matrix[12];
    const double part = film->frame_count > 1 ? (double)frame / (double)(film->frame_count - 1) : 0.0;
    const double time = (double)film->first_time + part * (double)(film->last_time - film->first_time);
    const scene_place place = scene_motion_at(one->motion, (float)time);
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

static void grow_by_actor(box *b, const actor *one, const double m[12])
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

/* ---- frames ---- */

static int start_scene(animation *film)
{
    const options *given = &film->state->options;
    const session *opened = &film->session;
    choose_grid(film);
    film->grid.need = picture_need(&(input){.mesh = &film->opened.placed.mesh}, given->need);
    film->grid.coverage = (svo_coverage)given->coverage;
    film->grid.weights = (svo_weights)given->weights;
    if (svo_moving_create(opened->device, &film->still.mesh, (unsigned)given->depth, &film->grid, opened->queue,
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

static int update(animation *film, uint64_t frame, svo_moving_report *report)
{
    for (size_t i = 0; i < film->actor_count; ++i) {
        double transform[12];
        transform_at(film, &film->actors[i], frame, transform);
        if (svo_moving_set_transform(film->moving, film->actors[i].object, transform) != SVO_OK) {
            return fail_library(film);
        }
    }
    return svo_moving_update(film->moving, film->session.queue, report) == SVO_OK ? PROGRAM_DONE : fail_library(film);
}

static bool hash_of(const animation *film, svo_tree *tree, char hash[SVO_HASH_TEXT_BYTES])
{
    return svo_tree_download(tree, film->session.queue) == SVO_OK && svo_tree_hash(tree, SVO_HASH_ALL, hash) == SVO_OK;
}

/* Builds the frame's mesh anew and compares the hashes. */
static int verify(animation *film, uint64_t frame, const char *hash)
{
    char expected[SVO_HASH_TEXT_BYTES] = "";
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    svo_mesh mesh;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    if (svo_moving_get_mesh(film->moving, &mesh) != SVO_OK || svo_moving_get_info(film->moving, &info) != SVO_OK) {
        return fail_library(film);
    }
    svo_plan_options pinned = {.struct_size = sizeof pinned,
                               .need = info.need,
                               .coverage = film->grid.coverage,
                               .weights = film->grid.weights,
                               .edge = film->grid.edge,
                               .weight_log2 = info.weight_log2};
    memcpy(pinned.origin, film->grid.origin, sizeof pinned.origin);
    const double start_ms = input_now_ms();
    const bool built =
        svo_plan_create(film->session.device, &mesh, (unsigned)film->state->options.depth, &pinned, &plan) == SVO_OK &&
        svo_build(plan, film->session.cl, film->session.queue, &tree, NULL) == SVO_OK;
    film->build_ms += frame > 0 ? input_now_ms() - start_ms : 0.0;
    const int exit_code = built && hash_of(film, tree, expected) ? PROGRAM_DONE : fail_library(film);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return exit_code != PROGRAM_DONE || strcmp(hash, expected) == 0
               ? exit_code
               : program_fail(film->state, PROGRAM_FAILED, "frame %llu: hash %s, and %s of a full build",
                              (unsigned long long)frame, hash, expected);
}

/* "film.png" becomes "film_007.png". */
static void name_frame(const char *path, uint64_t frame, char out[PATH_BYTES])
{
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash != NULL ? slash : path, '.');
    const int stem = (int)(dot != NULL ? dot - path : (ptrdiff_t)strlen(path));
    (void)snprintf(out, PATH_BYTES, "%.*s_%0*llu%s", stem, path, DIGITS, (unsigned long long)frame,
                   dot != NULL ? dot : "");
}

static int choose_camera(animation *film)
{
    const options *given = &film->state->options;
    film->camera = film->file.camera;
    if (!film->file.has_camera) {
        svo_camera_frame(svo_moving_tree(film->moving), (float)given->width / (float)given->height, &film->camera);
    }
    return viewpoint_apply(film->state, !film->file.has_camera, &film->camera);
}

static int draw(animation *film, const char *path)
{
    const options *given = &film->state->options;
    const svo_render_options view = {.struct_size = sizeof view,
                                     .width = given->width,
                                     .height = given->height,
                                     .camera = film->camera,
                                     .view = (svo_render_view)given->view};
    uint8_t *rgba = malloc((size_t)given->width * given->height * 4);
    if (rgba == NULL) {
        return program_fail(film->state, PROGRAM_FAILED, "out of memory for %ux%u pixels", given->width, given->height);
    }
    int exit_code =
        svo_tree_render(film->session.device, svo_moving_tree(film->moving), &view, film->session.queue, rgba) == SVO_OK
            ? PROGRAM_DONE
            : fail_library(film);
    if (exit_code == PROGRAM_DONE) {
        exit_code = picture_write_as(film->state, path, given->width, given->height, rgba);
    }
    free(rgba);
    return exit_code;
}

static void report_frame(animation *film, const char *path, const char *hash, const svo_moving_report *report)
{
    cJSON *entry = cJSON_CreateObject();
    json_add_text(entry, "file", path);
    json_add_text(entry, "hash", hash);
    json_add_count(entry, "fragments", report->fragments);
    json_add_count(entry, "changed_fragments", report->changed_fragments);
    cJSON_AddNumberToObject(entry, "update_ms", report->total_ms);
    cJSON_AddItemToArray(film->frames, entry);
}

static int show_frame(animation *film, uint64_t frame)
{
    char path[PATH_BYTES];
    char hash[SVO_HASH_TEXT_BYTES] = "";
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    int exit_code = update(film, frame, &report);
    film->update_ms += frame > 0 ? report.total_ms : 0.0;
    if (exit_code == PROGRAM_DONE && !hash_of(film, svo_moving_tree(film->moving), hash)) {
        exit_code = fail_library(film);
    }
    if (exit_code == PROGRAM_DONE && film->state->options.verify_frames != 0) {
        exit_code = verify(film, frame, hash);
    }
    if (exit_code == PROGRAM_DONE && frame == 0) {
        exit_code = choose_camera(film);
    }
    if (exit_code == PROGRAM_DONE) {
        name_frame(film->state->options.output_path, frame, path);
        exit_code = draw(film, path);
    }
    if (exit_code == PROGRAM_DONE) {
        report_frame(film, path, hash, &report);
        progress_step(film->state->progress, "frames");
    }
    return exit_code;
}

/* ---- all of it ---- */

static int open_film(animation *film)
{
    program *state = film->state;
    int exit_code = scene_file_open(state, state->options.input, &film->file);
    if (exit_code == PROGRAM_DONE && film->file.motion_count == 0) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%s: no instance has a 'motion'", state->options.input);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    film->frame_count = state->options.frames != 0 ? state->options.frames : FRAMES_DEFAULT;
    program_begin_progress(state, (unsigned)(film->file.tree_count + film->frame_count));
    find_times(film);
    exit_code = sort_instances(film);
    exit_code = exit_code == PROGRAM_DONE ? scene_input_open(state, &film->file, &film->opened) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? make_actors(film) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? session_open(state, &film->session) : exit_code;
    if (exit_code == PROGRAM_DONE && film->session.cl == NULL) {
        exit_code = program_fail(state, PROGRAM_WRONG_USAGE, "--animate takes the front end cl");
    }
    return exit_code == PROGRAM_DONE ? start_scene(film) : exit_code;
}

static void close_film(animation *film)
{
    svo_moving_destroy(&film->moving);
    session_close(&film->session);
    free(film->still.indices);
    for (size_t i = 0; i < film->actor_count; ++i) {
        free(film->actors[i].indices);
    }
    free(film->actors);
    scene_input_close(&film->opened);
    scene_file_close(&film->file);
    cJSON_Delete(film->frames);
}

static int report_film(animation *film)
{
    const options *given = &film->state->options;
    const double frames = film->frame_count > 1 ? (double)(film->frame_count - 1) : 1.0;
    if (given->json) {
        cJSON *document = json_document();
        json_add_text(document, "input", given->input);
        json_add_count(document, "width", given->width);
        json_add_count(document, "height", given->height);
        cJSON_AddBoolToObject(document, "verified", given->verify_frames != 0);
        cJSON_AddItemToObject(document, "frames", film->frames);
        film->frames = NULL;
        return json_print(film->state, document);
    }
    if (!given->quiet) {
        progress_hide(film->state->progress);
        table_line("%s: %llu frames of %ux%u pixels, %s an update", given->input, (unsigned long long)film->frame_count,
                   given->width, given->height, figure_ms(film->update_ms / frames).text);
        if (given->verify_frames != 0) {
            table_line("each frame's hash is that of its full build, %s", figure_ms(film->build_ms / frames).text);
        }
    }
    return PROGRAM_DONE;
}

int render_animation_check(program *state)
{
    const options *given = &state->options;
    if (given->animate == 0) {
        return (given->given_groups & (unsigned)OPTION_ANIMATION) == 0
                   ? PROGRAM_DONE
                   : program_fail(state, PROGRAM_WRONG_USAGE, "--frames and --verify require --animate");
    }
    if (!scene_file_is_input(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--animate takes a scene, a .json file");
    }
    if (strcmp(given->output_path, "-") == 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--animate writes several files, not to standard output");
    }
    return given->through == 0 && given->view < OPTION_VIEW_LIGHT &&
                   (given->given_groups & (unsigned)(OPTION_LIGHT | OPTION_PAGED)) == 0
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--animate takes no lights, cones, probes or pages");
}

int render_animation(program *state)
{
    animation film = {.state = state, .frames = cJSON_CreateArray()};
    int exit_code = open_film(&film);
    for (uint64_t frame = 0; frame < film.frame_count && exit_code == PROGRAM_DONE; ++frame) {
        exit_code = show_frame(&film, frame);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report_film(&film);
    }
    close_film(&film);
    return exit_code;
}
