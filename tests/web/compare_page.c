/* SPDX-License-Identifier: MIT */
/*
 * Compares what the page of svocl export-web finds along rays with what the library finds in the tree that it was made
 * from, or in one as deep as the page: node and level.
 *
 * The two round floats differently, so a ray through an edge may end beside it. At least 99.9 % must be equal, and the
 * others must be what the library finds a hair's breadth beside the ray.
 *
 * usage: compare_page TREE RAYS; exit code 1 where they differ. TREE: a .svo file, or a .svc file of the implied form.
 * RAYS: the footprint in the first line; then for each ray its origin in cells, its direction, 1 or 0 for a hit or
 * none, the node and the level.
 *
 * usage: compare_page TREE.svo TREE.svc: writes the compact tree in the form of a page, with full leaves merged.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/compact.h"
#include "svocl/io.h"
#include "svocl/svocl.h"

#define RAYS_MAX    65536
#define SHARE_EQUAL 0.999
/* Radians beside a ray, and part of the footprint. Rounding moves a crossing by some 2^-24 of the distance. */
#define HAIR 1e-6

typedef struct page_ray {
    double origin[3]; /* in cells */
    float direction[3];
    int met;
    uint32_t node, level;
} page_ray;

typedef struct page_rays {
    float footprint;
    size_t count;
    page_ray list[RAYS_MAX];
} page_rays;

/* One of the two. */
typedef struct subject {
    svo_tree *tree;
    svo_compact *compact;
    svo_grid grid;
} subject;

static page_rays rays;
static svo_ray cast[RAYS_MAX];
static svo_voxel_hit hits[RAYS_MAX];

static int read_rays(const char *path)
{
    FILE *file = fopen(path, "r");
    page_ray one;
    if (file == NULL || fscanf(file, "%f", &rays.footprint) != 1) {
        fprintf(stderr, "%s: no footprint\n", path);
        return 0;
    }
    while (rays.count < RAYS_MAX &&
           fscanf(file, "%lf %lf %lf %f %f %f %d %" SCNu32 " %" SCNu32, &one.origin[0], &one.origin[1], &one.origin[2],
                  &one.direction[0], &one.direction[1], &one.direction[2], &one.met, &one.node, &one.level) == 9) {
        rays.list[rays.count++] = one;
    }
    fclose(file);
    return 1;
}

/* The ray in world coordinates, tilted by a hair along x and y or z. */
static svo_ray world_ray(const svo_grid *grid, const page_ray *ray, double tilt_x, double tilt_yz)
{
    const double edge = svo_grid_cell_edge(grid, grid->depth);
    svo_ray out = {.t_min = 0.0f, .t_max = INFINITY};
    for (int axis = 0; axis < 3; ++axis) {
        const double tilt = axis == 0 ? tilt_x : axis == 1 ? tilt_yz : -tilt_yz;
        out.origin[axis] = (float)(grid->origin[axis] + edge * ray->origin[axis]);
        out.direction[axis] = (float)((double)ray->direction[axis] + tilt);
    }
    return out;
}

static svo_status trace(const subject *in, const svo_ray *list, svo_voxel_hit *found, size_t count, float footprint)
{
    return in->tree != NULL ? svo_trace_voxels(svo_tree_target(in->tree), svo_in_host(list), svo_in_host(found), count,
                                               footprint, 0, NULL)
                            : svo_trace_voxels(svo_compact_target(in->compact), svo_in_host(list), svo_in_host(found),
                                               count, footprint, 0, NULL);
}

static int is_equal(const page_ray *ray, const svo_voxel_hit *hit)
{
    const int met = hit->node != SVO_NO_NODE;
    return met == ray->met && (!met || (hit->node == ray->node && hit->level == ray->level));
}

/* Whether the page found what the library finds beside the ray. */
static int is_on_edge(const subject *in, const page_ray *ray)
{
    svo_ray beside[9];
    svo_voxel_hit found[9];
    for (int k = 0; k < 9; ++k) {
        const int row = k / 3 - 1;
        beside[k] = world_ray(&in->grid, ray, HAIR * (k % 3 - 1), HAIR * row);
    }
    for (int k = -1; k <= 1; ++k) {
        const float footprint = (float)((double)rays.footprint * (1.0 + HAIR * k));
        if (trace(in, beside, found, 9, footprint) != SVO_OK) {
            return 0;
        }
        for (int i = 0; i < 9; ++i) {
            if (is_equal(ray, &found[i])) {
                return 1;
            }
        }
    }
    return 0;
}

static int compare(const subject *in)
{
    size_t equal = 0, met = 0, beyond = 0;
    for (size_t i = 0; i < rays.count; ++i) {
        cast[i] = world_ray(&in->grid, &rays.list[i], 0.0, 0.0);
    }
    if (trace(in, cast, hits, rays.count, rays.footprint) != SVO_OK) {
        return 0;
    }
    for (size_t i = 0; i < rays.count; ++i) {
        met += hits[i].node != SVO_NO_NODE;
        if (is_equal(&rays.list[i], &hits[i])) {
            ++equal;
        } else if (!is_on_edge(in, &rays.list[i])) {
            printf("ray %zu: node %" PRIu32 " on level %" PRIu32 ", not %" PRIu32 " on %" PRIu32 "\n", i,
                   rays.list[i].node, rays.list[i].level, hits[i].node, hits[i].level);
            ++beyond;
        }
    }
    printf("%zu rays, footprint %g: %zu hits, %zu equal, %zu beside an edge, %zu others\n", rays.count,
           (double)rays.footprint, met, equal, rays.count - equal - beyond, beyond);
    return beyond == 0 && met > rays.count / 8 && met < rays.count && (double)equal >= SHARE_EQUAL * (double)rays.count;
}

static int has_suffix(const char *path, const char *suffix)
{
    const size_t length = strlen(path);
    return length >= strlen(suffix) && strcmp(path + length - strlen(suffix), suffix) == 0;
}

static svo_status load_compact(const char *path, svo_device *device, subject *out, svo_message *message)
{
    svo_compact_info info = SVO_COMPACT_INFO_INIT;
    const svo_status status = svo_compact_load(svo_from_path(path), NULL, &out->compact, message);
    if (status != SVO_OK) {
        return status;
    }
    (void)svo_compact_get_info(out->compact, &info);
    out->grid = (svo_grid){.depth = info.depth, .snap_bits = info.snap_bits, .scale = info.scale, .edge = info.edge};
    memcpy(out->grid.origin, info.origin, sizeof info.origin);
    return svo_compact_upload(out->compact, device, NULL);
}

static svo_status load_tree(const char *path, svo_device *device, subject *out, svo_message *message)
{
    const svo_status status = svo_tree_load(svo_from_path(path), NULL, &out->tree, message);
    if (status != SVO_OK) {
        return status;
    }
    (void)svo_tree_get_grid(out->tree, &out->grid);
    return svo_tree_upload(out->tree, device, NULL);
}

static svo_status write_compact(const subject *in, svo_device *device, const char *path, svo_message *message)
{
    svo_compact *compact = NULL;
    svo_compact_options options = SVO_COMPACT_OPTIONS_INIT;
    options.form = SVO_FORM_IMPLIED;
    options.directory_step_log2 = 4;
    options.minimize = 1;
    svo_status status = svo_compact_create(device, in->tree, &options, NULL, &compact);
    if (status == SVO_OK) {
        status = svo_compact_download(compact, NULL);
    }
    if (status == SVO_OK) {
        status = svo_compact_save(compact, svo_to_path(path), NULL, message);
    }
    svo_compact_destroy(&compact);
    return status;
}

static svo_status run(svo_device *device, char **arguments, subject *in, int *same, svo_message *message)
{
    const svo_status status = has_suffix(arguments[1], ".svc") ? load_compact(arguments[1], device, in, message)
                                                               : load_tree(arguments[1], device, in, message);
    if (status == SVO_OK && has_suffix(arguments[2], ".svc")) {
        return write_compact(in, device, arguments[2], message);
    }
    *same = status == SVO_OK && read_rays(arguments[2]) && compare(in);
    return status;
}

int main(int argument_count, char **arguments)
{
    svo_message message = {""};
    svo_device *device = NULL;
    subject in = {0};
    int same = 1;
    if (argument_count != 3) {
        fprintf(stderr, "usage: compare_page TREE RAYS, or TREE.svo TREE.svc\n");
        return 2;
    }
    svo_status status = svo_device_create_default(NULL, &device, &message);
    if (status == SVO_OK) {
        status = run(device, arguments, &in, &same, &message);
    }
    if (status != SVO_OK) {
        fprintf(stderr, "%s %s\n", message.text, device != NULL ? svo_device_message(device) : "");
    }
    svo_tree_destroy(&in.tree);
    svo_compact_destroy(&in.compact);
    svo_device_destroy(&device);
    return status == SVO_OK && same ? 0 : 1;
}
