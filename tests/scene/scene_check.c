/* SPDX-License-Identifier: MIT */
/* Places trees at random and finds the first voxel along a ray by boxes in double. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "scene_check.h"
#include "scenes.h"

fixture opened;
models shapes;
const svo_instance identity = {0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};

/* ---- models ---- */

void models_make(models *out)
{
    static const char *const specs[MODELS] = {"knot:1000", "cube", "statue:2000"};
    static const unsigned depths[MODELS] = {6, 3, 5};
    svo_plan_options options = {.need = (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL};
    for (int i = 0; i < MODELS; ++i) {
        /* The cube has a grid of its own, with faces that floats hold: cells of 0.25, of which it fills 2 to 6. */
        options.edge = i == 1 ? 2.0 : 0.0;
        options.origin[0] = options.origin[1] = options.origin[2] = i == 1 ? -0.5 : 0.0;
        scene *made = fixture_scene(specs[i]);
        fixture_build(&opened, scene_mesh(made), depths[i], &options, &out->trees[i]);
        out->handles[i] = out->trees[i].tree;
        scene_destroy(&made);
    }
}

void models_destroy(models *made)
{
    for (int i = 0; i < MODELS; ++i) {
        built_destroy(&made->trees[i]);
    }
}

static double grid_width(const svo_tree_info *info)
{
    return ldexp(1.0, (int)info->snap_bits) / info->scale;
}

/* ---- instances ---- */

static double spread(uint64_t *random, double from, double to)
{
    return from + (to - from) * random_unit(random);
}

/* A turn by three angles. */
static void random_turn(uint64_t *random, double out[9])
{
    double turn[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int axis = 0; axis < 3; ++axis) {
        const double angle = spread(random, 0, 6.2831853);
        const int a = (axis + 1) % 3;
        const int b = (axis + 2) % 3;
        for (int row = 0; row < 3; ++row) {
            const double u = turn[3 * row + a];
            const double v = turn[3 * row + b];
            turn[3 * row + a] = cos(angle) * u - sin(angle) * v;
            turn[3 * row + b] = sin(angle) * u + cos(angle) * v;
        }
    }
    memcpy(out, turn, sizeof turn);
}

static void random_linear(uint64_t *random, placement kind, double out[9])
{
    random_turn(random, out);
    if (kind == PLACE_MOVED) {
        return;
    }
    const double size = pow(10, spread(random, -3, 3));
    for (int k = 0; k < 3; ++k) {
        /* One axis in four is mirrored. */
        const double factor = size * spread(random, 0.5, 2) * (random_below(random, 4) == 0 ? -1 : 1);
        const double sheared = kind == PLACE_SHEARED ? spread(random, -0.7, 0.7) : 0;
        for (int row = 0; row < 3; ++row) {
            out[3 * row + k] = factor * (out[3 * row + k] + sheared * out[3 * row + (k + 1) % 3]);
        }
    }
}

void random_instances(uint64_t *random, placement kind, double width, svo_instance *out, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        double linear[9];
        random_linear(random, kind, linear);
        out[i].tree = random_below(random, MODELS);
        for (int row = 0; row < 3; ++row) {
            for (int k = 0; k < 3; ++k) {
                out[i].transform[4 * row + k] = (float)linear[3 * row + k];
            }
            out[i].transform[4 * row + 3] = (float)spread(random, -0.5 * width, 0.5 * width);
        }
    }
}

void random_scene_rays(uint64_t *random, const models *of, const svo_instance *instances, uint32_t instance_count,
                       svo_ray *out, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        const svo_instance *at = &instances[random_below(random, instance_count)];
        const svo_tree_info *info = &of->trees[at->tree].info;
        double inside[3];
        for (int axis = 0; axis < 3; ++axis) {
            inside[axis] = info->origin[axis] + grid_width(info) * spread(random, -0.1, 1.1);
        }
        const double away = pow(10, spread(random, -1, 1));
        double size = 0;
        for (int k = 0; k < 12; ++k) {
            size = k % 4 < 3 ? fmax(size, fabs((double)at->transform[k])) : size;
        }
        for (int row = 0; row < 3; ++row) {
            const float *matrix = at->transform + (ptrdiff_t)4 * row;
            const double target = (double)matrix[0] * inside[0] + (double)matrix[1] * inside[1] +
                                  (double)matrix[2] * inside[2] + (double)matrix[3];
            out[i].origin[row] = (float)(target + away * size * grid_width(info) * spread(random, -1, 1));
            out[i].direction[row] = (float)(target - (double)out[i].origin[row]);
        }
        out[i].t_min = 0;
        out[i].t_max = random_below(random, 8) == 0 ? (float)spread(random, 0.5, 1.5) : INFINITY;
    }
}

svo_scene *make_placed_scene(const models *of, const svo_instance *instances, uint32_t count, uint32_t need)
{
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = of->handles,
                                       .tree_count = MODELS,
                                       .instances = instances,
                                       .instance_count = count,
                                       .need = need};
    svo_scene *made = NULL;
    if (svo_scene_create(opened.device, &options, opened.queue, &made) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened.device));
    }
    return made;
}

void trace_scene(svo_scene *traced, const svo_ray *rays, svo_scene_hit *hits, size_t count, float footprint,
                 uint32_t flags)
{
    memset(hits, 0x5a, count * sizeof *hits);
    if (svo_trace_voxels(svo_scene_target(traced), svo_in_host(rays), svo_in_host(hits), count, footprint, flags,
                         &(svo_submit){.queue = opened.queue}) != SVO_OK) {
        fail_msg("%s", svo_device_message(opened.device));
    }
}

/* ---- references ---- */

void invert_linear(const float transform[12], double out[9])
{
    long double m[3][3];
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k) {
            m[row][k] = (long double)transform[4 * row + k];
        }
    }
    long double determinant = 0;
    for (int k = 0; k < 3; ++k) {
        determinant += m[0][k] * (m[1][(k + 1) % 3] * m[2][(k + 2) % 3] - m[1][(k + 2) % 3] * m[2][(k + 1) % 3]);
    }
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k) {
            const int r1 = (k + 1) % 3;
            const int r2 = (k + 2) % 3;
            const int c1 = (row + 1) % 3;
            const int c2 = (row + 2) % 3;
            out[3 * row + k] = (double)((m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]) / determinant);
        }
    }
}

typedef struct wide_ray {
    double origin[3], direction[3], t_min, t_max;
} wide_ray;

static wide_ray wide_ray_in_tree(const svo_instance *instance, const svo_ray *ray)
{
    double inverse[9];
    wide_ray out = {.t_min = (double)ray->t_min, .t_max = (double)ray->t_max};
    invert_linear(instance->transform, inverse);
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k) {
            const double from = (double)ray->origin[k] - (double)instance->transform[4 * k + 3];
            out.origin[row] += inverse[3 * row + k] * from;
            out.direction[row] += inverse[3 * row + k] * (double)ray->direction[k];
        }
    }
    return out;
}

svo_ray ray_in_tree(const svo_instance *instance, const svo_ray *ray)
{
    const wide_ray wide = wide_ray_in_tree(instance, ray);
    svo_ray out = {.t_min = ray->t_min, .t_max = ray->t_max};
    for (int axis = 0; axis < 3; ++axis) {
        out.origin[axis] = (float)wide.origin[axis];
        out.direction[axis] = (float)wide.direction[axis];
    }
    return out;
}

/* Where the ray enters the box; infinity if it does not. */
static double enter_box(const wide_ray *ray, const double low[3], double width)
{
    double enter = ray->t_min;
    double leave = ray->t_max;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = low[axis] - ray->origin[axis];
        const double b = a + width;
        if (ray->direction[axis] == 0) {
            if (a > 0 || b < 0) {
                return HUGE_VAL;
            }
            continue;
        }
        enter = fmax(enter, fmin(a / ray->direction[axis], b / ray->direction[axis]));
        leave = fmin(leave, fmax(a / ray->direction[axis], b / ray->direction[axis]));
    }
    return enter <= leave ? enter : HUGE_VAL;
}

/* The first leaf below a node; boxes that begin behind the best so far hold none. */
static double enter_node(const built *tree, const wide_ray *ray, uint32_t node, const double low[3], double width,
                         double best)
{
    const double enter = enter_box(ray, low, width);
    if (!(enter < best)) {
        return best;
    }
    if (node >= tree->info.inner_count) {
        return enter;
    }
    uint32_t child = tree->arrays.first_child[node];
    for (int octant = 0; octant < 8; ++octant) {
        if ((tree->arrays.child_mask[node] >> octant & 1) != 0) {
            const double inner[3] = {low[0] + 0.5 * width * (octant & 1), low[1] + 0.5 * width * (octant >> 1 & 1),
                                     low[2] + 0.5 * width * (octant >> 2)};
            best = enter_node(tree, ray, child++, inner, 0.5 * width, best);
        }
    }
    return best;
}

reference_hit reference_closest(const models *of, const svo_instance *instances, uint32_t count, const svo_ray *ray)
{
    reference_hit best = {HUGE_VAL, SVO_NO_INSTANCE};
    for (uint32_t i = 0; i < count; ++i) {
        const built *tree = &of->trees[instances[i].tree];
        const wide_ray inside = wide_ray_in_tree(&instances[i], ray);
        const double t = enter_node(tree, &inside, 0, tree->info.origin, grid_width(&tree->info), HUGE_VAL);
        if (t < best.t) {
            best = (reference_hit){t, i};
        }
    }
    return best;
}

/* ---- what tests share ---- */

int scene_group_open(void **state)
{
    (void)state;
    fixture_open_cl(&(fixture_options){.share = SVO_GL_SHARE_AUTO}, &opened);
    models_make(&shapes);
    return 0;
}

int scene_group_close(void **state)
{
    (void)state;
    models_destroy(&shapes);
    fixture_close(&opened);
    return 0;
}

void expect_words(svo_status status, svo_status expected, const char *words)
{
    if (status != expected || strstr(svo_device_message(opened.device), words) == NULL) {
        fail_msg("%s with '%s', not %s with '%s'", svo_name(SVO_NAME_STATUS, status), svo_device_message(opened.device),
                 svo_name(SVO_NAME_STATUS, expected), words);
    }
}

void assert_same_hits(const char *what, uint32_t count, const void *hits, const void *expected, size_t bytes)
{
    for (size_t i = 0; i < RAYS; ++i) {
        const unsigned char *a = (const unsigned char *)hits + i * bytes;
        const unsigned char *b = (const unsigned char *)expected + i * bytes;
        if (memcmp(a, b, bytes) != 0) {
            float t[2];
            memcpy(&t[0], a, sizeof t[0]);
            memcpy(&t[1], b, sizeof t[1]);
            fail_msg("%s, %u instances, ray %zu: t %a, not %a, or other numbers", what, count, i, (double)t[0],
                     (double)t[1]);
        }
    }
}

void compare_with_new_scene(svo_scene *moved, const svo_instance *placed, uint32_t count, const svo_ray *rays)
{
    static svo_scene_hit hits[RAYS];
    static svo_scene_hit expected[RAYS];
    svo_scene *fresh = make_placed_scene(&shapes, placed, count, SVO_NEED_NONE);
    trace_scene(moved, rays, hits, RAYS, 0, SVO_SCENE_CLOSEST);
    trace_scene(fresh, rays, expected, RAYS, 0, SVO_SCENE_CLOSEST);
    assert_same_hits("moved", count, hits, expected, sizeof hits[0]);
    svo_scene_destroy(&fresh);
}
