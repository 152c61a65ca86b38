/* SPDX-License-Identifier: MIT */
/*
 * Pictures of trees against a reference that tests every voxel's box in double: occupied voxels are drawn, the rest is
 * background, from outside and inside, along the axes and across them. Also tests the camera that frames a tree.
 *
 * Trees are made by hand and all black: a pixel is black if all its rays hit and has the row's background if none does.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/device.h"
#include "core/tree.h"
#include "support/info_of.h"
#include "support/suite.h"
#include "svocl/svocl.h"

#define TEST_DEPTH_MAX 5u
#define TEST_CELLS_MAX (1u << (3 * TEST_DEPTH_MAX))
#define WIDTH          96u
#define HEIGHT         64u

static svo_device *device;
static svo_path path;
static cl_command_queue queue;

/* ---- trees by hand ---- */

typedef struct occupancy {
    uint32_t depth;
    bool leaves[TEST_CELLS_MAX]; /* by Morton code */
} occupancy;

static uint32_t morton(uint32_t x, uint32_t y, uint32_t z)
{
    uint32_t code = 0;
    for (uint32_t bit = 0; bit < TEST_DEPTH_MAX; ++bit) {
        code |= (x >> bit & 1) << (3 * bit) | (y >> bit & 1) << (3 * bit + 1) | (z >> bit & 1) << (3 * bit + 2);
    }
    return code;
}

/* Whether the node with this code on this level has a leaf below it. */
static bool is_occupied(const occupancy *voxels, uint32_t level, uint32_t code)
{
    const uint32_t leaves_log2 = 3 * (voxels->depth - level);
    for (uint32_t leaf = code << leaves_log2; leaf < (code + 1) << leaves_log2; ++leaf) {
        if (voxels->leaves[leaf]) {
            return true;
        }
    }
    return false;
}

/* Fills masks and first children breadth-first; returns the number of nodes. codes: capacity for all nodes. */
static uint32_t link_nodes(const occupancy *voxels, svo_tree_info *info, uint8_t *masks, uint32_t *first,
                           uint32_t *codes)
{
    uint32_t node_count = 1;
    codes[0] = 0;
    info->level_begin[0] = 0;
    for (uint32_t level = 0; level < voxels->depth; ++level) {
        info->level_begin[level + 1] = node_count;
        for (uint32_t node = info->level_begin[level]; node < info->level_begin[level + 1]; ++node) {
            first[node] = node_count;
            for (uint32_t octant = 0; octant < 8; ++octant) {
                if (is_occupied(voxels, level + 1, codes[node] << 3 | octant)) {
                    masks[node] = (uint8_t)(masks[node] | 1u << octant);
                    codes[node_count++] = codes[node] << 3 | octant;
                }
            }
        }
    }
    info->level_begin[voxels->depth + 1] = node_count;
    return node_count;
}

static svo_tree *make_tree(const occupancy *voxels, bool black)
{
    svo_tree *tree = svo_i_tree_new(NULL);
    uint32_t *codes = calloc(2 * TEST_CELLS_MAX, sizeof *codes);
    uint8_t *masks = svo_i_alloc_zeroed(NULL, 2 * TEST_CELLS_MAX, sizeof *masks);
    uint32_t *first = svo_i_alloc_zeroed(NULL, 2 * TEST_CELLS_MAX, sizeof *first);
    assert_non_null(tree);
    assert_non_null(codes);
    assert_non_null(masks);
    assert_non_null(first);
    svo_tree_info *info = &tree->info;
    info->node_count = link_nodes(voxels, info, masks, first, codes);
    info->depth = voxels->depth;
    info->snap_bits = 20;
    info->edge = 1;
    info->scale = 0x1p20;
    info->leaf_count = info->node_count - info->level_begin[voxels->depth];
    info->inner_count = info->node_count - info->leaf_count;
    tree->host[SVO_TREE_CHILD_MASK] = masks;
    tree->host[SVO_TREE_FIRST_CHILD] = first;
    tree->downloaded = true;
    if (black) {
        info->need = SVO_NEED_COLOR;
        tree->host[SVO_TREE_COLORS] = svo_i_alloc_zeroed(NULL, info->node_count, 4);
        assert_non_null(tree->host[SVO_TREE_COLORS]);
        for (uint64_t node = 0; node < info->node_count; ++node) { /* opaque */
            ((uint8_t *)tree->host[SVO_TREE_COLORS])[4 * node + 3] = 255;
        }
    }
    free(codes);
    assert_int_equal(svo_tree_upload(tree, device, queue), SVO_OK);
    return tree;
}

static occupancy *new_occupancy(uint32_t depth)
{
    occupancy *voxels = calloc(1, sizeof *voxels);
    assert_non_null(voxels);
    voxels->depth = depth;
    return voxels;
}

/* ---- the reference ---- */

typedef enum reference_answer { REFERENCE_MISS, REFERENCE_HIT, REFERENCE_TOO_CLOSE } reference_answer;

/* The least corners of the occupied cells: the reference visits them once for each ray. */
typedef struct cell_list {
    double (*low)[3];
    uint32_t count;
    double width;
} cell_list;

static cell_list cells_of(const occupancy *voxels)
{
    const uint32_t side = 1u << voxels->depth;
    cell_list out = {.low = malloc(sizeof(double[3]) << (3 * voxels->depth)), .width = 1.0 / side};
    assert_non_null(out.low);
    for (uint32_t cell = 0; cell < side * side * side; ++cell) {
        const uint32_t at[3] = {cell % side, cell / side % side, cell / side / side};
        if (voxels->leaves[morton(at[0], at[1], at[2])]) {
            for (int axis = 0; axis < 3; ++axis) {
                out.low[out.count][axis] = at[axis] * out.width;
            }
            ++out.count;
        }
    }
    return out;
}

typedef struct half_line {
    double eye[3], inverse[3]; /* inverse: of the direction; infinite along a face */
} half_line;

/* Whether it meets the box enlarged by margin on every side. */
static bool meets_box(const half_line *line, const double low[3], double width, double margin)
{
    double entry = 0;
    double exit = HUGE_VAL;
    for (int axis = 0; axis < 3; ++axis) {
        const double near_face = low[axis] - margin - line->eye[axis];
        const double far_face = low[axis] + width + margin - line->eye[axis];
        if (isinf(line->inverse[axis])) {
            if (near_face > 0 || far_face < 0) {
                return false;
            }
            continue;
        }
        const double a = near_face * line->inverse[axis];
        const double b = far_face * line->inverse[axis];
        const double first = a < b ? a : b;
        const double last = a < b ? b : a;
        entry = first > entry ? first : entry;
        exit = last < exit ? last : exit;
        if (entry > exit) {
            return false;
        }
    }
    return true;
}

static reference_answer reference_ray(const cell_list *voxels, const half_line *line)
{
    const double margin = 1e-4;
    reference_answer answer = REFERENCE_MISS;
    for (uint32_t i = 0; i < voxels->count; ++i) {
        if (meets_box(line, voxels->low[i], voxels->width, margin)) {
            if (meets_box(line, voxels->low[i], voxels->width, -margin)) {
                return REFERENCE_HIT;
            }
            answer = REFERENCE_TOO_CLOSE;
        }
    }
    return answer;
}

static void normalized_cross(const double a[3], const double b[3], double out[3])
{
    const double raw[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const double length = sqrt(raw[0] * raw[0] + raw[1] * raw[1] + raw[2] * raw[2]);
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = raw[axis] / length;
    }
}

/* The camera's rays by the definition of a pinhole camera. */
typedef struct pinhole {
    double eye[3], forward[3], right[3], up[3];
    double tangent;
} pinhole;

static pinhole pinhole_of(const svo_camera *camera)
{
    pinhole hole;
    double length = 0;
    double up[3];
    for (int axis = 0; axis < 3; ++axis) {
        hole.eye[axis] = (double)camera->eye[axis];
        hole.forward[axis] = (double)camera->target[axis] - hole.eye[axis];
        length += hole.forward[axis] * hole.forward[axis];
        up[axis] = (double)camera->up[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        hole.forward[axis] /= sqrt(length);
    }
    normalized_cross(hole.forward, up, hole.right);
    normalized_cross(hole.right, hole.forward, hole.up);
    hole.tangent = tan(0.5 * (double)camera->vertical_fov);
    return hole;
}

/* The common result of the four rays of a pixel, if they agree. */
static reference_answer reference_pixel(const cell_list *voxels, const pinhole *hole, uint32_t x, uint32_t y)
{
    reference_answer answer = REFERENCE_TOO_CLOSE;
    for (int sample = 0; sample < 4; ++sample) {
        const double right = (2 * (x + 0.25 + 0.5 * (sample % 2)) / WIDTH - 1) * hole->tangent * WIDTH / HEIGHT;
        const double up =
            (1 - 2 * (y + 0.25 + 0.5 * (sample / 2)) / HEIGHT) * hole->tangent; /* NOLINT: row of samples */
        half_line line = {{hole->eye[0], hole->eye[1], hole->eye[2]}, {0}};
        for (int axis = 0; axis < 3; ++axis) {
            line.inverse[axis] = 1 / (hole->forward[axis] + right * hole->right[axis] + up * hole->up[axis]);
        }
        const reference_answer one = reference_ray(voxels, &line);
        if (sample > 0 && one != answer) {
            return REFERENCE_TOO_CLOSE;
        }
        answer = one;
    }
    return answer;
}

/* ---- pictures ---- */

static const float no_clip[4] = {0};

static void render_clipped(svo_tree *tree, const svo_camera *camera, const float clip[4], svo_render_view view,
                           uint8_t *rgba)
{
    svo_render_options options = {
        .struct_size = sizeof options, .width = WIDTH, .height = HEIGHT, .camera = *camera, .view = view};
    memcpy(options.clip, clip, sizeof options.clip);
    memset(rgba, 0x5a, (size_t)WIDTH * HEIGHT * 4);
    if (svo_render(svo_tree_target(tree), &options, svo_in_host(rgba), &(svo_submit){.queue = queue}) != SVO_OK) {
        fail_msg("%s", svo_device_message(device));
    }
}

static void render(svo_tree *tree, const svo_camera *camera, uint8_t *rgba)
{
    render_clipped(tree, camera, no_clip, SVO_VIEW_SHADED, rgba);
}

static void render_background(uint8_t *rgba)
{
    occupancy *nothing = new_occupancy(1);
    svo_tree *tree = make_tree(nothing, false);
    const svo_camera camera = {{0.5f, 0.5f, 3}, {0.5f, 0.5f, 0}, {0, 1, 0}, 0.6f};
    render(tree, &camera, rgba);
    svo_tree_destroy(&tree);
    free(nothing);
}

static bool is_black(const uint8_t *pixel)
{
    return pixel[0] == 0 && pixel[1] == 0 && pixel[2] == 0 && pixel[3] == 255;
}

/* Compares a picture of black voxels, of which a plane leaves some, with the reference; returns the number of fully
   covered pixels. */
static uint32_t check_clipped(const char *name, const occupancy *voxels, const float clip[4], const occupancy *left,
                              const svo_camera *camera)
{
    static uint8_t picture[WIDTH * HEIGHT * 4];
    static uint8_t background[WIDTH * HEIGHT * 4];
    svo_tree *tree = make_tree(voxels, true);
    render_clipped(tree, camera, clip, SVO_VIEW_SHADED, picture);
    render_background(background);
    const pinhole hole = pinhole_of(camera);
    const cell_list occupied = cells_of(left);
    uint32_t hits = 0;
    for (uint32_t y = 0; y < HEIGHT; ++y) {
        for (uint32_t x = 0; x < WIDTH; ++x) {
            const uint8_t *pixel = picture + 4 * ((size_t)y * WIDTH + x);
            const uint8_t *behind = background + 4 * ((size_t)y * WIDTH + x);
            const reference_answer answer = reference_pixel(&occupied, &hole, x, y);
            if ((answer == REFERENCE_HIT && !is_black(pixel)) ||
                (answer == REFERENCE_MISS && memcmp(pixel, behind, 4) != 0)) {
                fail_msg("%s: pixel %u, %u is %u %u %u; the reference says %s", name, x, y, pixel[0], pixel[1],
                         pixel[2], answer == REFERENCE_HIT ? "hit" : "miss");
            }
            hits += answer == REFERENCE_HIT;
        }
    }
    free(occupied.low);
    svo_tree_destroy(&tree);
    return hits;
}

static uint32_t check_picture(const char *name, const occupancy *voxels, const svo_camera *camera)
{
    return check_clipped(name, voxels, no_clip, voxels, camera);
}

static void an_empty_tree_is_background(void **unused)
{
    (void)unused;
    static uint8_t first[WIDTH * HEIGHT * 4];
    static uint8_t second[WIDTH * HEIGHT * 4];
    render_background(first);
    occupancy *nothing = new_occupancy(4);
    svo_tree *tree = make_tree(nothing, true);
    const svo_camera camera = {{0.3f, 0.6f, 0.2f}, {0.9f, 0.5f, 0}, {0, 0, 1}, 1.6f};
    render(tree, &camera, second);
    assert_memory_equal(first, second, sizeof first);
    for (uint32_t y = 0; y < HEIGHT; ++y) {
        for (uint32_t x = 0; x < WIDTH; ++x) {
            const uint8_t *pixel = first + 4 * ((size_t)y * WIDTH + x);
            assert_memory_equal(pixel, first + 4 * ((size_t)y * WIDTH), 4);
            assert_true(pixel[0] > 150 && pixel[3] == 255);
        }
    }
    svo_tree_destroy(&tree);
    free(nothing);
}

static void one_voxel_covers_its_pixels(void **unused)
{
    (void)unused;
    const svo_camera outside = {{1.7f, 1.4f, 2.6f}, {0.5f, 0.5f, 0.5f}, {0, 1, 0}, 0.7f};
    const svo_camera below = {{0.2f, -1.9f, -0.3f}, {0.5f, 0.5f, 0.5f}, {0, 0, 1}, 0.7f};
    for (uint32_t depth = 1; depth <= TEST_DEPTH_MAX; ++depth) {
        occupancy *voxels = new_occupancy(depth);
        const uint32_t last = (1u << depth) - 1;
        voxels->leaves[morton(last / 2, last, last / 3)] = true;
        assert_true(check_picture("one voxel", voxels, &outside) > 0);
        /* From below, a voxel of the finest test tree covers no pixel completely. */
        assert_true(check_picture("one voxel from below", voxels, &below) > 0 || depth == TEST_DEPTH_MAX);
        free(voxels);
    }
}

static void random_voxels_are_drawn_from_everywhere(void **unused)
{
    (void)unused;
    const svo_camera cameras[] = {
        {{1.5f, 1.2f, 2.1f}, {0.5f, 0.5f, 0.5f}, {0, 1, 0}, 0.6f},
        {{-0.9f, 0.4f, -1.3f}, {0.5f, 0.5f, 0.5f}, {0.1f, 1, 0}, 0.8f},
        {{0.5f, 0.5f, 0.52f}, {0.1f, 0.4f, 0.2f}, {0, 1, 0}, 1.5f}, /* inside */
        {{0.53f, 3.1f, 0.47f}, {0.53f, 0, 0.47f}, {0, 0, 1}, 0.4f}, /* along an axis */
        {{0.5f, 0.5f, -2.5f}, {0.5f, 0.5f, 0}, {1, 0, 0}, 0.4f}, /* along an axis, on cell borders */
    };
    uint32_t state = 12345;
    for (size_t k = 0; k < sizeof cameras / sizeof cameras[0]; ++k) {
        occupancy *voxels = new_occupancy(4);
        for (uint32_t leaf = 0; leaf < 1u << 12; ++leaf) {
            state = state * 1664525u + 1013904223u;
            voxels->leaves[leaf] = state >> 24 < 6;
        }
        /* The voxel that contains the eye remains empty. */
        voxels->leaves[morton(8, 8, 8)] = false;
        assert_true(check_picture("random voxels", voxels, &cameras[k]) > 50);
        free(voxels);
    }
}

/* The voxels of one side of a plane between cells. */
static occupancy *voxels_beyond(const occupancy *voxels, int axis, uint32_t cell, bool above)
{
    occupancy *left = new_occupancy(voxels->depth);
    const uint32_t cells = 1u << voxels->depth;
    for (uint32_t k = 0; k < cells * cells * cells; ++k) {
        const uint32_t at[3] = {k % cells, k / cells % cells, k / cells / cells};
        const uint32_t code = morton(at[0], at[1], at[2]);
        left->leaves[code] = voxels->leaves[code] && (at[axis] >= cell) == above;
    }
    return left;
}

/* How many pixels of a view differ by more than rounding. */
static uint32_t count_differing(svo_tree *clipped, const float clip[4], svo_tree *left, const svo_camera *camera,
                                svo_render_view view)
{
    static uint8_t pictures[2][WIDTH * HEIGHT * 4];
    uint32_t count = 0;
    render_clipped(clipped, camera, clip, view, pictures[0]);
    render_clipped(left, camera, no_clip, view, pictures[1]);
    for (size_t i = 0; i < sizeof pictures[0]; i += 4) {
        count += abs((int)pictures[0][i] - (int)pictures[1][i]) > 1;
    }
    return count;
}

/* What a plane cuts away might as well not be there. */
static void a_plane_cuts_away_what_is_below_it(void **unused)
{
    (void)unused;
    const svo_camera cameras[] = {{{1.5f, 1.2f, 2.1f}, {0.5f, 0.5f, 0.5f}, {0, 1, 0}, 0.6f},
                                  {{0.53f, 0.47f, 0.52f}, {0.1f, 0.4f, 0.2f}, {0, 1, 0}, 1.5f}};
    occupancy *voxels = new_occupancy(4);
    uint32_t state = 4711;
    for (uint32_t leaf = 0; leaf < 1u << 12; ++leaf) {
        state = state * 1664525u + 1013904223u;
        voxels->leaves[leaf] = state >> 24 < 12 && leaf != morton(8, 7, 8);
    }
    svo_tree *tree = make_tree(voxels, false);
    for (int k = 0; k < 12; ++k) {
        const int axis = k % 3;
        const bool above = k / 3 % 2 == 0;
        const svo_camera *camera = &cameras[k / 6];
        const uint32_t cell = 5 + (uint32_t)k;
        float clip[4] = {0};
        clip[axis] = above ? 3.0f : -3.0f; /* of any length */
        clip[3] = -clip[axis] * (float)cell / 16;
        occupancy *left = voxels_beyond(voxels, axis, cell, above);
        svo_tree *rest = make_tree(left, false);
        char name[32];
        (void)snprintf(name, sizeof name, "plane %d", k);
        (void)check_clipped(name, voxels, clip, left, camera);
        for (int view = SVO_VIEW_NORMAL; view <= SVO_VIEW_LEVEL; ++view) {
            if (view != SVO_VIEW_STEPS) { /* empty cells are larger without what was cut away */
                assert_in_range(count_differing(tree, clip, rest, camera, (svo_render_view)view), 0, 8);
            }
        }
        svo_tree_destroy(&rest);
        free(left);
    }
    svo_tree_destroy(&tree);
    free(voxels);
}

static void every_pixel_of_a_wall_is_hit(void **unused)
{
    (void)unused;
    occupancy *voxels = new_occupancy(5);
    for (uint32_t y = 0; y < 32; ++y) {
        for (uint32_t x = 0; x < 32; ++x) {
            voxels->leaves[morton(x, y, 7)] = true;
        }
    }
    const svo_camera straight = {{0.5f, 0.5f, 0.6f}, {0.5f, 0.5f, 0.2f}, {0, 1, 0}, 0.8f};
    const svo_camera aslant = {{0.62f, 0.44f, 0.5f}, {0.5f, 0.5f, 0.2f}, {0.2f, 1, 0}, 0.7f};
    const svo_camera behind = {{0.5f, 0.5f, 0.0f}, {0.5f, 0.5f, 0.2f}, {0, 1, 0}, 0.9f};
    assert_int_equal(check_picture("wall", voxels, &straight), WIDTH * HEIGHT);
    assert_int_equal(check_picture("wall", voxels, &aslant), WIDTH * HEIGHT);
    assert_int_equal(check_picture("wall", voxels, &behind), WIDTH * HEIGHT);
    free(voxels);
}

/* A field of view of 1e-30: all rays have two components that are zero or nearly zero. */
static void parallel_rays_along_an_axis_hit_and_miss(void **unused)
{
    (void)unused;
    static uint8_t picture[WIDTH * HEIGHT * 4];
    occupancy *voxels = new_occupancy(3);
    voxels->leaves[morton(3, 4, 5)] = true;
    svo_tree *tree = make_tree(voxels, true);
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
            svo_camera camera = {{3.5f / 8, 4.5f / 8, 5.5f / 8}, {3.5f / 8, 4.5f / 8, 5.5f / 8}, {0, 0, 0}, 1e-30f};
            camera.eye[axis] = 0.5f + 2.0f * (float)side;
            camera.up[(axis + 1) % 3] = 1;
            render(tree, &camera, picture);
            assert_true(is_black(picture));
            assert_true(is_black(picture + sizeof picture - 4));
            /* One voxel to the side, nothing is hit; on the border between the two, tracing must only terminate. */
            for (int step = 1; step <= 2; ++step) {
                svo_camera beside = camera;
                beside.eye[(axis + 1) % 3] += 0.0625f * (float)step;
                beside.target[(axis + 1) % 3] += 0.0625f * (float)step;
                render(tree, &beside, picture);
                assert_true(step == 1 || !is_black(picture));
            }
        }
    }
    svo_tree_destroy(&tree);
    free(voxels);
}

static occupancy *make_ball(uint32_t depth)
{
    occupancy *voxels = new_occupancy(depth);
    const int cells = 1 << depth;
    for (int z = 0; z < cells; ++z) {
        for (int y = 0; y < cells; ++y) {
            for (int x = 0; x < cells; ++x) {
                const int dx = 2 * x + 1 - cells;
                const int dy = 2 * y + 1 - cells;
                const int dz = 2 * z + 1 - cells;
                voxels->leaves[morton((uint32_t)x, (uint32_t)y, (uint32_t)z)] =
                    dx * dx + dy * dy + dz * dz < cells * cells;
            }
        }
    }
    return voxels;
}

static void pictures_are_repeatable(void **unused)
{
    (void)unused;
    static uint8_t first[WIDTH * HEIGHT * 4];
    static uint8_t second[WIDTH * HEIGHT * 4];
    occupancy *voxels = make_ball(5);
    svo_tree *tree = make_tree(voxels, false);
    svo_camera camera = {.vertical_fov = 0};
    (void)svo_camera_fit(svo_tree_target(tree), (float)WIDTH / HEIGHT, &camera);
    render(tree, &camera, first);
    render(tree, &camera, second);
    assert_memory_equal(first, second, sizeof first);
    svo_tree_destroy(&tree);
    free(voxels);
}

/* A driver may end a launch that takes long, so large pictures take several. Every view, in bands of three tiles. */
static void bands_draw_the_same_picture(void **unused)
{
    (void)unused;
    static uint8_t whole[WIDTH * HEIGHT * 4];
    static uint8_t banded[WIDTH * HEIGHT * 4];
    occupancy *voxels = make_ball(5);
    svo_tree *tree = make_tree(voxels, false);
    svo_render_options options = {.struct_size = sizeof options, .width = WIDTH, .height = HEIGHT};
    (void)svo_camera_fit(svo_tree_target(tree), (float)WIDTH / HEIGHT, &options.camera);
    const cl_uint all = device->band_tiles;
    assert_true(all > (cl_uint)(WIDTH * HEIGHT / 64));
    for (int view = SVO_VIEW_SHADED; view < SVO_VIEW_TRIANGLES; ++view) {
        options.view = (svo_render_view)view;
        assert_int_equal(svo_render(svo_tree_target(tree), &options, svo_in_host(whole), &(svo_submit){.queue = queue}),
                         SVO_OK);
        memset(banded, 0, sizeof banded);
        device->band_tiles = 3;
        assert_int_equal(
            svo_render(svo_tree_target(tree), &options, svo_in_host(banded), &(svo_submit){.queue = queue}), SVO_OK);
        device->band_tiles = all;
        assert_memory_equal(whole, banded, sizeof whole);
    }
    svo_tree_destroy(&tree);
    free(voxels);
}

static double mean_brightness(svo_tree *tree, const svo_camera *camera)
{
    static uint8_t picture[WIDTH * HEIGHT * 4];
    render(tree, camera, picture);
    double sum = 0;
    for (size_t k = 0; k < sizeof picture; ++k) {
        sum += k % 4 == 3 ? 0 : picture[k];
    }
    return sum / (WIDTH * HEIGHT * 3);
}

/* Light comes from the camera's upper side: a ball seen from above is brighter than from below. */
static void a_ball_is_lit_from_above(void **unused)
{
    (void)unused;
    occupancy *voxels = make_ball(5);
    svo_tree *tree = make_tree(voxels, false);
    const svo_camera above = {{0.5f, 2, 2}, {0.5f, 0.5f, 0.5f}, {0, 1, 0}, 0.2f};
    const svo_camera below = {{0.5f, -1, 2}, {0.5f, 0.5f, 0.5f}, {0, 1, 0}, 0.2f};
    const double bright = mean_brightness(tree, &above);
    const double dark = mean_brightness(tree, &below);
    if (!(bright > 1.2 * dark && dark > 10)) {
        fail_msg("mean brightness is %g from above and %g from below", bright, dark);
    }
    svo_tree_destroy(&tree);
    free(voxels);
}

/* ---- the framing camera ---- */

/* Where the outermost corner of the box appears in the picture: 0 is the center, 1 the edge. */
static double seen_extent(const svo_camera *camera, double aspect, const double low[3], const double high[3])
{
    const pinhole hole = pinhole_of(camera);
    double extent = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double right = 0;
        double up = 0;
        double depth = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double offset = ((corner >> axis & 1) != 0 ? high[axis] : low[axis]) - hole.eye[axis];
            right += offset * hole.right[axis];
            up += offset * hole.up[axis];
            depth += offset * hole.forward[axis];
        }
        assert_true(depth > 0);
        extent = fmax(extent, fmax(fabs(right) / (depth * hole.tangent * aspect), fabs(up) / (depth * hole.tangent)));
    }
    return extent;
}

static void expect_no_frame(svo_tree *tree, svo_camera camera)
{
    const svo_camera before = camera;
    assert_int_equal(svo_camera_fit(svo_tree_target(tree), 1.0f, &camera), SVO_INVALID_ARGUMENT);
    assert_memory_equal(&camera, &before, sizeof camera);
}

static void a_fitted_camera_keeps_its_direction(void **unused)
{
    (void)unused;
    occupancy *voxels = make_ball(5);
    svo_tree *tree = make_tree(voxels, false);
    svo_camera framed = {.vertical_fov = 0};
    (void)svo_camera_fit(svo_tree_target(tree), 1.5f, &framed);
    svo_camera zeros = {.vertical_fov = 0};
    assert_int_equal(svo_camera_fit(svo_tree_target(tree), 1.5f, &zeros), SVO_OK);
    assert_memory_equal(&zeros, &framed, sizeof framed);
    svo_camera camera = {.eye = {3, 9, 27}, .target = {2, 11, 30}, .up = {0.1f, 0.2f, 3}, .vertical_fov = 1.25f};
    const pinhole before = pinhole_of(&camera);
    assert_int_equal(svo_camera_fit(svo_tree_target(tree), 1.5f, &camera), SVO_OK);
    const pinhole after = pinhole_of(&camera);
    for (int axis = 0; axis < 3; ++axis) {
        assert_float_equal(after.forward[axis], before.forward[axis], 1e-5);
        assert_float_equal(after.right[axis], before.right[axis], 1e-5);
    }
    assert_true(camera.vertical_fov == 1.25f);
    /* The ball touches the margin, though its box would leave room: the sine of its half angle is radius / distance. */
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        square += (0.5 - (double)camera.eye[axis]) * (0.5 - (double)camera.eye[axis]);
    }
    assert_true(fabs(0.5 / sqrt(square) - sin(atan(tan(0.625) / 1.04))) < 0.03);
    expect_no_frame(tree, (svo_camera){.eye = {0, 1, 0}, .up = {0, 2, 0}, .vertical_fov = 1});
    expect_no_frame(tree, (svo_camera){.eye = {0, 1, 0}, .up = {1, 0, 0}, .vertical_fov = 3.15f});
    expect_no_frame(tree, (svo_camera){.eye = {0, 1, (float)HUGE_VAL}, .up = {1, 0, 0}, .vertical_fov = 1});
    svo_tree_destroy(&tree);
    free(voxels);
}

static void the_framing_camera_shows_the_tree_and_fills_the_picture(void **unused)
{
    (void)unused;
    static const uint32_t bvh[][6] = {
        {0, 0, 0, 8, 8, 8}, {3, 2, 5, 4, 3, 6}, {0, 7, 0, 8, 8, 8}, {0, 0, 2, 1, 8, 3}, {6, 0, 0, 7, 1, 8}};
    static const float aspects[] = {0.3f, 1, 16.0f / 9, 4};
    for (size_t box = 0; box < sizeof bvh / sizeof bvh[0]; ++box) {
        const uint32_t *b = bvh[box];
        occupancy *voxels = new_occupancy(3);
        for (uint32_t code = 0; code < 512; ++code) {
            const uint32_t x = code % 8;
            const uint32_t y = code / 8 % 8;
            const uint32_t z = code / 64;
            voxels->leaves[morton(x, y, z)] = x >= b[0] && x < b[3] && y >= b[1] && y < b[4] && z >= b[2] && z < b[5];
        }
        svo_tree *tree = make_tree(voxels, false);
        const double low[3] = {b[0] / 8.0, b[1] / 8.0, b[2] / 8.0};
        const double high[3] = {b[3] / 8.0, b[4] / 8.0, b[5] / 8.0};
        for (size_t k = 0; k < sizeof aspects / sizeof aspects[0]; ++k) {
            svo_camera camera = {.vertical_fov = 0};
            (void)svo_camera_fit(svo_tree_target(tree), aspects[k], &camera);
            const double extent = seen_extent(&camera, (double)aspects[k], low, high);
            if (!(extent > 0.85 && extent < 1)) {
                fail_msg("box %zu, aspect %g: it extends to %g of the picture", box, (double)aspects[k], extent);
            }
        }
        svo_tree_destroy(&tree);
        free(voxels);
    }
}

/* ---- bad arguments ---- */

static void expect_refusal(svo_tree *tree, const svo_render_options *options, svo_status status, const char *words)
{
    static uint8_t picture[WIDTH * HEIGHT * 4];
    assert_int_equal(svo_render(svo_tree_target(tree), options, svo_in_host(picture), &(svo_submit){.queue = queue}),
                     status);
    if (strstr(svo_device_message(device), words) == NULL) {
        fail_msg("'%s' lacks '%s'", svo_device_message(device), words);
    }
}

static void bad_arguments_are_refused(void **unused)
{
    (void)unused;
    occupancy *voxels = new_occupancy(1);
    voxels->leaves[0] = true;
    svo_tree *tree = make_tree(voxels, false);
    const svo_render_options good = {.struct_size = sizeof good,
                                     .width = WIDTH,
                                     .height = HEIGHT,
                                     .camera = {{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 0.5f}};
    expect_refusal(tree, NULL, SVO_INVALID_ARGUMENT, "options is NULL");
    svo_render_options bad = good;
    bad.struct_size = 1;
    expect_refusal(tree, &bad, SVO_INVALID_ARGUMENT, "struct_size is 1");
    bad = good;
    bad.width = 0;
    expect_refusal(tree, &bad, SVO_INVALID_ARGUMENT, "0 x 64 pixels");
    bad = good;
    bad.height = 16385;
    expect_refusal(tree, &bad, SVO_INVALID_ARGUMENT, "16384");
    bad = good;
    bad.camera.vertical_fov = 3.2f;
    expect_refusal(tree, &bad, SVO_INVALID_ARGUMENT, "vertical_fov 3.2");
    bad = good;
    bad.camera.vertical_fov = NAN;
    expect_refusal(tree, &bad, SVO_INVALID_ARGUMENT, "vertical_fov");
    bad = good;
    bad.clip[3] = INFINITY;
    expect_refusal(tree, &bad, SVO_INVALID_ARGUMENT, "clip 0, 0, 0, inf is not finite");
    bad = good;
    bad.camera.eye[2] = 0; /* eye and target coincide */
    expect_refusal(tree, &bad, SVO_INVALID_ARGUMENT, "camera.eye");
    bad = good;
    bad.camera.up[1] = 0;
    bad.camera.up[2] = 7; /* along the line of sight */
    expect_refusal(tree, &bad, SVO_INVALID_ARGUMENT, "up is along");
    bad = good;
    bad.camera.target[0] = INFINITY;
    expect_refusal(tree, &bad, SVO_INVALID_ARGUMENT, "not finite");
    svo_tree_destroy(&tree);
    svo_tree *absent = svo_i_tree_new(NULL);
    assert_non_null(absent);
    static uint8_t picture[WIDTH * HEIGHT * 4];
    assert_int_equal(svo_render(svo_tree_target(absent), &good, svo_in_host(picture), &(svo_submit){.queue = queue}),
                     SVO_NOT_ON_DEVICE); /* it has no device to say so */
    svo_tree_destroy(&absent);
    free(voxels);
}

static int open_device(void **unused)
{
    (void)unused;
    svo_message message = {""};
    const svo_device_options options = {.struct_size = sizeof options, .path = path};
    if (svo_device_create_default(&options, &device, &message) != SVO_OK) {
        print_error("no OpenCL device: %s\n", message.text);
        return -1;
    }
    /* Out of order: every dependency must be explicit. */
    cl_int error = CL_SUCCESS;
    queue = clCreateCommandQueue(info_of_device(device).context, info_of_device(device).device,
                                 CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &error);
    if (error != CL_SUCCESS) {
        queue = clCreateCommandQueue(info_of_device(device).context, info_of_device(device).device, 0, &error);
    }
    return error == CL_SUCCESS ? 0 : -1;
}

static int close_device(void **unused)
{
    (void)unused;
    clReleaseCommandQueue(queue);
    svo_device_destroy(&device);
    return 0;
}

/* As on GPUs: pixel by pixel, not by packets of rays. */
static int open_device_for_pixels(void **state)
{
    path = SVO_PATH_GPU;
    return open_device(state);
}

TEST_GROUP(trace)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_tree_is_background),
        cmocka_unit_test(one_voxel_covers_its_pixels),
        cmocka_unit_test(random_voxels_are_drawn_from_everywhere),
        cmocka_unit_test(a_plane_cuts_away_what_is_below_it),
        cmocka_unit_test(every_pixel_of_a_wall_is_hit),
        cmocka_unit_test(parallel_rays_along_an_axis_hit_and_miss),
        cmocka_unit_test(pictures_are_repeatable),
        cmocka_unit_test(bands_draw_the_same_picture),
        cmocka_unit_test(a_ball_is_lit_from_above),
        cmocka_unit_test(a_fitted_camera_keeps_its_direction),
        cmocka_unit_test(the_framing_camera_shows_the_tree_and_fills_the_picture),
        cmocka_unit_test(bad_arguments_are_refused),
    };
    return cmocka_run_group_tests_name("packets", tests, open_device, close_device) +
           cmocka_run_group_tests_name("pixels", tests, open_device_for_pixels, close_device);
}
