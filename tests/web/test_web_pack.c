/* SPDX-License-Identifier: MIT */
/*
 * The data of pages (tools/web/pack.h): a cut at any level is the front part of each array, what is packed unpacks to
 * what each level adds to it, levels are complete where the data say so, normals keep their direction, and the bounds
 * are those of the cells.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#define ZLIB_CONST /* what is read is const */
#include <zlib.h>

#include "scenes.h"
#include "support/fixture.h"
#include "support/suite.h"
#include "svocl/compact.h"
#include "web/pack.h"
#include "web/sky.h"

#define DEPTH 7u

enum { WINDOW_BITS = 15, AS_GZIP = 16 };

/* A tree, the compact tree of it that pages have, and what a page reads. */
typedef struct packable {
    built made;
    svo_compact *compact;
    web_tree tree;
} packable;

static void make_of_mesh(void **state, const svo_mesh *mesh, const svo_plan_options *plan_options, uint32_t minimize,
                         packable *out)
{
    const fixture opened = fixture_cl_of_group(state);
    svo_compact_options options = SVO_COMPACT_OPTIONS_INIT;
    fixture_build(&opened, mesh, DEPTH, plan_options, &out->made);
    options.form = SVO_FORM_IMPLIED;
    options.directory_step_log2 = WEB_DIRECTORY_STEP_LOG2;
    options.minimize = minimize;
    assert_int_equal(svo_compact_create(opened.device, out->made.tree, &options, opened.queue, &out->compact), SVO_OK);
    assert_int_equal(svo_compact_download(out->compact, opened.queue), SVO_OK);
    out->tree = web_tree_of(out->compact);
}

static void make(void **state, const char *scene_spec, const svo_plan_options *plan_options, uint32_t minimize,
                 packable *out)
{
    struct scene *source = fixture_scene(scene_spec);
    make_of_mesh(state, scene_mesh(source), plan_options, minimize, out);
    scene_destroy(&source);
}

static void release(packable *made)
{
    svo_compact_destroy(&made->compact);
    built_destroy(&made->made);
}

/* ---- cuts ---- */

/* The stream of a cut, unpacked; by malloc. */
static unsigned char *unpack(const unsigned char *packed, size_t packed_count, uint64_t byte_count)
{
    z_stream stream = {0};
    unsigned char *bytes = malloc((size_t)byte_count + 1);
    unsigned char *copy = malloc(packed_count);
    assert_non_null(bytes);
    assert_non_null(copy);
    memcpy(copy, packed, packed_count);
    assert_int_equal(inflateInit2(&stream, WINDOW_BITS | AS_GZIP), Z_OK);
    stream.next_in = copy;
    stream.avail_in = (uInt)packed_count;
    stream.next_out = bytes;
    stream.avail_out = (uInt)byte_count + 1;
    assert_int_equal(inflate(&stream, Z_FINISH), Z_STREAM_END);
    assert_int_equal(stream.total_out, byte_count);
    assert_int_equal(inflateEnd(&stream), Z_OK);
    free(copy);
    return bytes;
}

/* What a cut has more than another of an array: compares it, and moves on. */
static void check_part(const unsigned char **at, const void *array, size_t each, uint64_t first, uint64_t last)
{
    if (last > first) {
        assert_memory_equal(*at, (const unsigned char *)array + each * first, each * (last - first));
        *at += each * (last - first);
    }
}

static const unsigned char *check_level(const web_tree *tree, const web_cut *above, const web_cut *cut,
                                        uint64_t mask_count, const unsigned char *at)
{
    const uint64_t end = 16 * cut->directory_count;
    check_part(&at, tree->arrays.nodes, 1, 16 * above->directory_count, end < mask_count ? end : mask_count);
    for (uint64_t i = 16 * above->directory_count > mask_count ? end : mask_count; i < end; ++i) {
        assert_int_equal(*at++, 0);
    }
    check_part(&at, tree->arrays.links, 4, above->directory_count, cut->directory_count);
    check_part(&at, tree->arrays.colors, 4, above->colors.count, cut->colors.count);
    for (uint64_t i = above->normals.count; i < cut->normals.count; ++i) {
        unsigned char normal[2];
        web_pack_normal(tree->arrays.normals + 3 * i, normal);
        assert_memory_equal(at, normal, 2);
        at += 2;
    }
    check_part(&at, tree->light != NULL ? tree->light->texels : NULL, 24, above->light.count, cut->light.count);
    return at;
}

static void check_bytes(const web_tree *tree, const web_cut *cut, const unsigned char *bytes)
{
    const unsigned char *at = bytes;
    web_cut above = {0};
    for (uint32_t level = 1; level <= cut->level; ++level) {
        const web_cut here = web_cut_at(tree, level);
        at = check_level(tree, &above, &here, cut->mask_count, at);
        assert_int_equal(at - bytes, here.byte_count);
        above = here;
    }
    assert_int_equal(at - bytes, cut->byte_count);
}

/* What is in front of each end unpacks to whole levels, more each time. */
static void check_ends(const web_tree *tree, const web_cut *cut, const web_packed *packed)
{
    uint32_t level = 0;
    assert_true(packed->end_count >= 1 && packed->end_count <= cut->level);
    assert_int_equal(packed->ends[packed->end_count - 1], packed->count);
    for (unsigned i = 0; i < packed->end_count; ++i) {
        z_stream stream = {0};
        unsigned char *bytes = malloc((size_t)cut->byte_count + 1);
        assert_non_null(bytes);
        assert_int_equal(inflateInit2(&stream, WINDOW_BITS | AS_GZIP), Z_OK);
        stream.next_in = packed->bytes;
        stream.avail_in = (uInt)packed->ends[i];
        stream.next_out = bytes;
        stream.avail_out = (uInt)cut->byte_count + 1;
        assert_int_equal(inflate(&stream, Z_SYNC_FLUSH), i + 1 == packed->end_count ? Z_STREAM_END : Z_OK);
        do {
            assert_true(++level <= cut->level);
        } while (web_cut_at(tree, level).byte_count < stream.total_out);
        assert_int_equal(web_cut_at(tree, level).byte_count, stream.total_out);
        assert_int_equal(inflateEnd(&stream), Z_OK);
        free(bytes);
    }
    assert_int_equal(web_cut_at(tree, level).byte_count, cut->byte_count);
}

/* Packs a cut into just its length, and not into a byte less. */
static void check_packed(const web_tree *tree, const web_cut *cut)
{
    web_packed packed;
    web_packed again;
    assert_int_equal(web_pack(tree, cut, SIZE_MAX / 4, &packed), WEB_PACK_DONE);
    assert_int_equal(web_pack(tree, cut, packed.count - 1, &again), WEB_PACK_TOO_LARGE);
    assert_int_equal(web_pack(tree, cut, 0, &again), WEB_PACK_TOO_LARGE);
    assert_null(again.bytes);
    assert_int_equal(web_pack(tree, cut, packed.count, &again), WEB_PACK_DONE);
    assert_int_equal(again.count, packed.count);
    assert_memory_equal(again.bytes, packed.bytes, packed.count);
    unsigned char *bytes = unpack(packed.bytes, packed.count, cut->byte_count);
    check_bytes(tree, cut, bytes);
    check_ends(tree, cut, &packed);
    free(bytes);
    free(packed.bytes);
    free(again.bytes);
}

static void cuts_are_front_parts(void **state)
{
    packable made = {0};
    make(state, "statue:20000", NULL, 0, &made);
    const svo_tree_info *info = &made.made.info;
    for (uint32_t level = 1; level <= DEPTH; ++level) {
        const web_cut cut = web_cut_at(&made.tree, level);
        assert_int_equal(cut.mask_count, info->level_begin[level]);
        assert_int_equal(cut.node_count, info->level_begin[level + 1]);
        assert_int_equal(cut.leaf_count, info->level_begin[level + 1] - info->level_begin[level]);
        assert_int_equal(cut.colors.count, cut.node_count);
        assert_int_equal(cut.normals.count, cut.node_count);
        check_packed(&made.tree, &cut);
    }
    release(&made);
}

static void merged_leaves_stay(void **state)
{
    const svo_plan_options options = {.need = SVO_NEED_NONE};
    packable made = {0};
    make(state, "cornell", &options, 1, &made);
    assert_true(made.tree.info.leaf_count < made.made.info.leaf_count);
    const web_cut cut = web_cut_at(&made.tree, DEPTH);
    assert_int_equal(cut.leaf_count, made.tree.info.leaf_count);
    assert_int_equal(cut.node_count, made.tree.info.leaf_count + made.tree.info.inner_count);
    assert_int_equal(cut.colors.count + cut.normals.count, 0);
    check_packed(&made.tree, &cut);
    release(&made);
}

static void payload_may_begin_below_the_root(void **state)
{
    const svo_plan_options options = {.need = SVO_NEED_NORMAL, .payload_level = 4};
    packable made = {0};
    make(state, "knot:5000", &options, 0, &made);
    for (uint32_t level = 1; level <= DEPTH; ++level) {
        const web_cut cut = web_cut_at(&made.tree, level);
        const uint32_t first = made.made.info.level_begin[4];
        assert_int_equal(cut.normals.count, level < 4 ? 0 : cut.node_count - first);
        assert_int_equal(cut.normals.first, first);
        assert_int_equal(cut.normals.stride, 1);
        check_packed(&made.tree, &cut);
    }
    release(&made);
}

static void constant_payload_is_one_element(void **state)
{
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 1};
    const svo_plan_options options = {.need = SVO_NEED_COLOR};
    svo_mesh white = SVO_MESH_INIT; /* a mesh without colors */
    packable made = {0};
    white.positions = corners;
    white.vertex_count = 3;
    white.triangle_count = 1;
    make_of_mesh(state, &white, &options, 0, &made);
    const web_cut cut = web_cut_at(&made.tree, DEPTH);
    assert_true((made.tree.info.constant & SVO_NEED_COLOR) != 0);
    assert_int_equal(cut.colors.count, 1);
    assert_int_equal(cut.colors.first, 0);
    assert_int_equal(cut.colors.stride, 0);
    check_packed(&made.tree, &cut);
    release(&made);
}

static void light_ends_with_its_level(void **state)
{
    packable made = {0};
    make(state, "knot:5000", NULL, 0, &made);
    web_light light = {.level = 4, .node_count = made.made.info.level_begin[5]};
    light.texels = malloc((size_t)light.node_count * sizeof *light.texels);
    assert_non_null(light.texels);
    for (uint64_t i = 0; i < light.node_count * sizeof *light.texels; ++i) {
        ((unsigned char *)light.texels)[i] = (unsigned char)(i * 7u + (i >> 8));
    }
    made.tree.light = &light;
    for (uint32_t level = 1; level <= DEPTH; ++level) {
        const web_cut cut = web_cut_at(&made.tree, level);
        assert_int_equal(cut.light.count, made.made.info.level_begin[(level < 4 ? level : 4) + 1]);
        check_packed(&made.tree, &cut);
    }
    free(light.texels);
    release(&made);
}

/* ---- skies ---- */

#define SKY_WIDTH  1100u
#define SKY_HEIGHT 700u

static double unpacked(const unsigned char texel[4], int channel)
{
    return texel[channel] / 255.0 * exp2(texel[3] - 128.0);
}

/* Solid angle times texels, of 4 pi, of a channel. */
static double light_of(const web_sky *sky, int channel)
{
    const double pi = 3.14159265358979323846;
    double sum = 0;
    for (uint32_t i = 0; i < sky->width * sky->height; ++i) {
        const uint32_t row = i / sky->width;
        sum += unpacked(sky->texels[i], channel) / sky->width / 2 *
               (cos(pi * row / sky->height) - cos(pi * (row + 1) / sky->height));
    }
    return sum;
}

/* However many texels are left, a sky of a radiance keeps it, a small sun its light, and what is red up and blue down
   its colors; what fits is kept as it is. */
static void skies_keep_their_light(void **state)
{
    (void)state;
    float *texels = malloc((size_t)3 * SKY_WIDTH * SKY_HEIGHT * sizeof *texels);
    web_sky sky;
    assert_non_null(texels);
    for (uint32_t i = 0; i < SKY_WIDTH * SKY_HEIGHT; ++i) {
        const uint32_t row = i / SKY_WIDTH;
        texels[3 * i] = 0.7F;
        texels[3 * i + 1] = row == 200 && i % SKY_WIDTH == 900 ? 5000 : 0;
        texels[3 * i + 2] = row >= SKY_HEIGHT / 2 ? 2 : 0;
    }
    svo_light_setup setup = {.sky_map = texels, .sky_width = SKY_WIDTH, .sky_height = SKY_HEIGHT};
    const double sun = 5000.0 / SKY_WIDTH / 2 * (cos(200 * 3.14159265358979 / 700) - cos(201 * 3.14159265358979 / 700));
    for (size_t limit = 4000000; limit > 100; limit /= 30) {
        assert_true(web_sky_make(&setup, limit, &sky));
        assert_true(sky.width <= WEB_SKY_WIDTH_MAX && sky.height <= WEB_SKY_HEIGHT_MAX);
        assert_true((size_t)4 * sky.width * sky.height <= limit);
        assert_true(fabs(light_of(&sky, 0) - 0.7) < 0.004);
        assert_true(fabs(light_of(&sky, 1) / sun - 1) < 0.01);
        assert_true(fabs(light_of(&sky, 2) - 1) < 0.006);
        assert_true(unpacked(sky.texels[0], 2) == 0);
        free(sky.texels);
    }
    assert_int_equal(sky.width * sky.height, 32); /* 8 x 4, of the last limit */
    setup.sky_width = 3;
    setup.sky_height = 1;
    assert_true(web_sky_make(&setup, 1 << 20, &sky));
    assert_int_equal(sky.width, 3);
    assert_true(fabs(unpacked(sky.texels[2], 0) - 0.7) < 0.002);
    free(sky.texels);
    setup.sky_map = NULL;
    assert_true(web_sky_make(&setup, 1 << 20, &sky));
    assert_true(sky.width == 0 && sky.texels == NULL);
    free(texels);
}

/* ---- bounds ---- */

static void bounds_are_those_of_the_cells(void **state)
{
    packable made = {0};
    make(state, "knot:5000", NULL, 0, &made);
    uint32_t low[3] = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    uint32_t high[3] = {0, 0, 0};
    for (uint32_t i = made.made.info.level_begin[6]; i < made.made.info.level_begin[7]; ++i) {
        svo_node node;
        assert_int_equal(svo_tree_find_node(made.made.tree, i, &node), SVO_OK);
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = 2 * node.cell[axis] < low[axis] ? 2 * node.cell[axis] : low[axis];
            high[axis] = 2 * node.cell[axis] + 2 > high[axis] ? 2 * node.cell[axis] + 2 : high[axis];
        }
    }
    uint32_t found_low[3];
    uint32_t found_high[3];
    assert_true(web_tree_bounds(&made.tree, found_low, found_high));
    assert_memory_equal(found_low, low, sizeof low);
    assert_memory_equal(found_high, high, sizeof high);
    release(&made);
}

/* ---- normals ---- */

/* The direction that a page reads (tools/web/nodes.glsl). */
static void read_normal(const unsigned char stored[2], double out[3])
{
    const double u = ((double)stored[0] - 128.0) / 127.0;
    const double v = ((double)stored[1] - 128.0) / 127.0;
    out[0] = u;
    out[1] = v;
    out[2] = 1.0 - fabs(u) - fabs(v);
    if (out[2] < 0.0) {
        out[0] = (1.0 - fabs(v)) * (u >= 0.0 ? 1.0 : -1.0);
        out[1] = (1.0 - fabs(u)) * (v >= 0.0 ? 1.0 : -1.0);
    }
}

static double angle_between(const double a[3], const int16_t b[3])
{
    const double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const double sine = sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
    return atan2(sine, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * 57.29577951308232;
}

static void normals_keep_their_direction(void **state)
{
    (void)state;
    double worst = 0.0;
    size_t count = 0;
    /* Directions on a cube of 49 points along each edge: with all axes, edges and corners. */
    for (int i = 0; i < 49 * 49 * 49; ++i) {
        const int16_t normal[3] = {(int16_t)((i % 49 - 24) * 780), (int16_t)((i / 49 % 49 - 24) * 780),
                                   (int16_t)((i / 2401 - 24) * 780)};
        unsigned char packed[2];
        double read[3];
        web_pack_normal(normal, packed);
        const double length =
            sqrt((double)normal[0] * normal[0] + (double)normal[1] * normal[1] + (double)normal[2] * normal[2]);
        assert_int_equal(packed[0] == 0 && packed[1] == 0, length <= 0.2 * 32767.0);
        if (packed[0] != 0 || packed[1] != 0) {
            read_normal(packed, read);
            const double angle = angle_between(read, normal);
            const int axes = (normal[0] != 0) + (normal[1] != 0) + (normal[2] != 0);
            if (axes == 1) {
                assert_true(angle < 1e-9); /* axes are exact */
            }
            worst = angle > worst ? angle : worst;
            ++count;
        }
    }
    print_message("%zu normals, at most %.3f degrees off\n", count, worst);
    assert_true(worst < 1.0);
}

TEST_GROUP(web_pack)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cuts_are_front_parts),
        cmocka_unit_test(merged_leaves_stay),
        cmocka_unit_test(payload_may_begin_below_the_root),
        cmocka_unit_test(constant_payload_is_one_element),
        cmocka_unit_test(light_ends_with_its_level),
        cmocka_unit_test(skies_keep_their_light),
        cmocka_unit_test(bounds_are_those_of_the_cells),
        cmocka_unit_test(normals_keep_their_direction),
    };
    return cmocka_run_group_tests_name("web_pack", tests, fixture_group_setup, fixture_group_teardown);
}
