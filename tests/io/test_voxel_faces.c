/* SPDX-License-Identifier: MIT */
/*
 * Merged faces against a search through all voxels: each outer face is in one rectangle of its color, the surface is
 * closed, and what a rectangle touches is filled, so that a build on the same grid has no other voxels.
 */
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/suite.h"
#include "svocl/voxel_files.h"
#include "vox_bytes.h"

enum { SIDE = 9, CELLS = SIDE * SIDE * SIDE, RECTANGLES_MAX = 6 * CELLS, EDGES_MAX = 4 * RECTANGLES_MAX };

/* A box of voxels that lies at low; color 0: empty. */
typedef struct box {
    int32_t low[3];
    uint8_t color[SIDE][SIDE][SIDE];
} box;

/* Corners in voxels, from the least voxel on. */
typedef struct quad {
    double corner[4][3];
    uint8_t rgba[4];
} quad;

static quad quads[RECTANGLES_MAX];

static int append(void *user, const void *bytes, size_t byte_count)
{
    bytes_put(user, bytes, byte_count);
    return 0;
}

static uint8_t color_at(const box *of, int x, int y, int z)
{
    const bool inside = x >= 0 && y >= 0 && z >= 0 && x < SIDE && y < SIDE && z < SIDE;
    return inside ? of->color[x][y][z] : 0;
}

static svo_voxels *list_of(const box *of, double edge, const double origin[3])
{
    static svo_voxel voxels[CELLS];
    svo_voxels *made = NULL;
    svo_voxels_source source = {.struct_size = sizeof source, .voxels = voxels, .voxel_edge = edge};
    for (int i = 0; i < CELLS; ++i) {
        const int at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
        const uint8_t color = of->color[at[0]][at[1]][at[2]];
        if (color != 0) {
            voxels[source.voxel_count++] = (svo_voxel){.x = of->low[0] + at[0],
                                                       .y = of->low[1] + at[1],
                                                       .z = of->low[2] + at[2],
                                                       .rgba = {color, (uint8_t)(3 * color), 9, 255}};
        }
    }
    memcpy(source.origin, origin, sizeof source.origin);
    assert_int_equal(svo_voxels_create(&source, &made, NULL), SVO_OK);
    return made;
}

/* ---- reading ---- */

static size_t parse_ply(const byte_list *file)
{
    size_t vertices = 0;
    size_t faces = 0;
    const char *text = (const char *)file->bytes;
    const char *body = strstr(text, "end_header\n");
    assert_non_null(body);
    assert_int_equal(sscanf(strstr(text, "element vertex"), "element vertex %zu", &vertices), 1);
    assert_int_equal(sscanf(strstr(text, "element face"), "element face %zu", &faces), 1);
    assert_int_equal(vertices, 4 * faces);
    assert_true(faces <= RECTANGLES_MAX);
    const uint8_t *at = (const uint8_t *)body + strlen("end_header\n");
    assert_int_equal(file->bytes + file->count - at, 16 * vertices + 17 * faces);
    for (size_t i = 0; i < vertices; ++i, at += 16) {
        float place[3];
        memcpy(place, at, sizeof place);
        for (int axis = 0; axis < 3; ++axis) {
            quads[i / 4].corner[i % 4][axis] = (double)place[axis];
        }
        assert_true(i % 4 == 0 || memcmp(quads[i / 4].rgba, at + 12, 4) == 0);
        memcpy(quads[i / 4].rgba, at + 12, 4);
    }
    for (size_t i = 0; i < faces; ++i, at += 17) {
        for (uint32_t corner = 0; corner < 4; ++corner) {
            uint32_t index = 0;
            memcpy(&index, at + 1 + 4 * (size_t)corner, 4);
            assert_int_equal(index, 4 * i + corner);
        }
        assert_int_equal(at[0], 4);
    }
    return faces;
}

static size_t parse_obj(byte_list *file)
{
    size_t vertices = 0;
    size_t faces = 0;
    bytes_put_u8(file, 0);
    for (char *line = strtok((char *)file->bytes, "\n"); line != NULL; line = strtok(NULL, "\n")) {
        double color[3];
        size_t index[4];
        quad *q = &quads[(line[0] == 'v' ? vertices : 4 * faces) / 4];
        double *corner = q->corner[vertices % 4];
        if (line[0] == 'v') {
            assert_int_equal(sscanf(line, "v %lf %lf %lf %lf %lf %lf", &corner[0], &corner[1], &corner[2], &color[0],
                                    &color[1], &color[2]),
                             6);
            for (int channel = 0; channel < 3; ++channel) {
                q->rgba[channel] = (uint8_t)lrint(255.0 * color[channel]);
                corner[channel] = (double)(float)corner[channel];
            }
            q->rgba[3] = 255;
            ++vertices;
        } else if (line[0] == 'f') {
            assert_int_equal(sscanf(line, "f %zu %zu %zu %zu", &index[0], &index[1], &index[2], &index[3]), 4);
            for (size_t i = 0; i < 4; ++i) {
                assert_int_equal(index[i], 4 * faces + i + 1);
            }
            ++faces;
        }
    }
    assert_int_equal(vertices, 4 * faces);
    return faces;
}

/* ---- checks ---- */

/* The unit faces of a rectangle: of voxels with its color, with nothing behind them. Counts them in seen. */
static void check_quad(const box *of, const quad *q, uint8_t seen[6][SIDE][SIDE][SIDE])
{
    double low[3] = {INFINITY, INFINITY, INFINITY};
    double high[3] = {-INFINITY, -INFINITY, -INFINITY};
    double normal[3];
    for (int i = 0; i < 4; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = fmin(low[axis], q->corner[i][axis]);
            high[axis] = fmax(high[axis], q->corner[i][axis]);
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        normal[axis] = (q->corner[1][u] - q->corner[0][u]) * (q->corner[2][v] - q->corner[0][v]) -
                       (q->corner[1][v] - q->corner[0][v]) * (q->corner[2][u] - q->corner[0][u]);
    }
    const int axis = low[0] == high[0] ? 0 : low[1] == high[1] ? 1 : 2;
    const int side = normal[axis] > 0.0 ? 1 : 0;
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    assert_true(low[axis] == high[axis] && normal[u] == 0.0 && normal[v] == 0.0);
    int at[3];
    at[axis] = (int)lrint(low[axis]) - side;
    for (at[u] = (int)lrint(low[u]); at[u] < (int)lrint(high[u]); ++at[u]) {
        for (at[v] = (int)lrint(low[v]); at[v] < (int)lrint(high[v]); ++at[v]) {
            int beside[3] = {at[0], at[1], at[2]};
            beside[axis] += 2 * side - 1;
            assert_int_equal(color_at(of, at[0], at[1], at[2]), q->rgba[0]);
            assert_int_equal(q->rgba[1], (uint8_t)(3 * q->rgba[0]));
            assert_int_equal(color_at(of, beside[0], beside[1], beside[2]), 0);
            ++seen[2 * axis + side][at[0]][at[1]][at[2]];
        }
    }
    /* What the closed rectangle touches, with voxels that have their near faces alone. */
    for (at[0] = (int)floor(low[0]); at[0] <= (int)floor(high[0]); ++at[0]) {
        for (at[1] = (int)floor(low[1]); at[1] <= (int)floor(high[1]); ++at[1]) {
            for (at[2] = (int)floor(low[2]); at[2] <= (int)floor(high[2]); ++at[2]) {
                assert_int_not_equal(color_at(of, at[0], at[1], at[2]), 0);
            }
        }
    }
}

/* A directed side of a rectangle along an axis. */
typedef struct edge {
    int axis;
    double line[2];
    double at; /* an end */
    int change; /* of the sum of directions from here on */
} edge;

static int compare_edges(const void *a, const void *b)
{
    const edge *x = a;
    const edge *y = b;
    return x->axis != y->axis         ? x->axis - y->axis
           : x->line[0] != y->line[0] ? (x->line[0] > y->line[0] ? 1 : -1)
           : x->line[1] != y->line[1] ? (x->line[1] > y->line[1] ? 1 : -1)
                                      : (x->at > y->at) - (x->at < y->at);
}

/* Along each line sides of one direction cancel those of the other, but for pieces that are no longer than allowed. */
static void check_closed(size_t count, double allowed)
{
    static edge edges[2 * EDGES_MAX];
    size_t used = 0;
    for (size_t i = 0; i < 4 * count; ++i) {
        const double *from = quads[i / 4].corner[i % 4];
        const double *to = quads[i / 4].corner[(i + 1) % 4];
        const int axis = from[0] != to[0] ? 0 : from[1] != to[1] ? 1 : 2;
        const int sign = from[axis] < to[axis] ? 1 : -1;
        edge made = {.axis = axis, .line = {from[(axis + 1) % 3], from[(axis + 2) % 3]}};
        made.at = fmin(from[axis], to[axis]);
        made.change = sign;
        edges[used++] = made;
        made.at = fmax(from[axis], to[axis]);
        made.change = -sign;
        edges[used++] = made;
    }
    qsort(edges, used, sizeof edges[0], compare_edges);
    int sum = 0;
    for (size_t i = 0; i < used; ++i) {
        sum += edges[i].change;
        const edge *next = &edges[i + 1 < used ? i + 1 : i];
        const bool same_line =
            next->axis == edges[i].axis && next->line[0] == edges[i].line[0] && next->line[1] == edges[i].line[1];
        if (sum != 0 && (!same_line || next->at - edges[i].at > allowed)) {
            fail_msg("a side is open from %.9g to %.9g along axis %d", edges[i].at, next->at, edges[i].axis);
        }
    }
    assert_int_equal(sum, 0);
}

/* Writes the faces as a format, and checks them. Returns how many rectangles there are. */
static size_t check_faces(const box *of, svo_voxel_format format)
{
    static uint8_t seen[6][SIDE][SIDE][SIDE];
    static const double origin[3] = {0.0, 0.0, 0.0};
    byte_list file = {0};
    svo_message message = {""};
    svo_voxels_save_info info = SVO_VOXELS_SAVE_INFO_INIT;
    svo_voxels *voxels = list_of(of, 1.0, origin);
    uint64_t expected = 0;
    if (svo_voxels_save_faces(voxels, svo_to_callback(append, &file), format, &info, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    assert_int_equal(info.bytes, file.count);
    const size_t count = format == SVO_VOXEL_FORMAT_PLY ? parse_ply(&file) : parse_obj(&file);
    memset(seen, 0, sizeof seen);
    for (size_t i = 0; i < count; ++i) {
        for (int corner = 0; corner < 12; ++corner) {
            quads[i].corner[corner / 3][corner % 3] -= (double)of->low[corner % 3]; /* exact: few bits */
        }
        check_quad(of, &quads[i], seen);
    }
    check_closed(count, 0.0);
    for (int i = 0; i < 6 * CELLS; ++i) {
        const int at[3] = {i / SIDE / SIDE % SIDE, i / SIDE % SIDE, i % SIDE};
        int beside[3] = {at[0], at[1], at[2]};
        beside[i / CELLS / 2] += i / CELLS % 2 != 0 ? 1 : -1;
        const bool is_outer =
            color_at(of, at[0], at[1], at[2]) != 0 && color_at(of, beside[0], beside[1], beside[2]) == 0;
        assert_int_equal(seen[i / CELLS][at[0]][at[1]][at[2]], is_outer);
        expected += is_outer ? 1 : 0;
    }
    assert_int_equal(info.faces, count);
    assert_int_equal(info.voxel_faces, expected);
    bytes_free(&file);
    svo_voxels_destroy(&voxels);
    return count;
}

static void fill(box *of, const int low[3], const int high[3], uint8_t color)
{
    for (int x = low[0]; x < high[0]; ++x) {
        for (int y = low[1]; y < high[1]; ++y) {
            for (int z = low[2]; z < high[2]; ++z) {
                of->color[x][y][z] = color;
            }
        }
    }
}

static void test_boxes_have_six_rectangles(void **state)
{
    (void)state;
    static const int low[3] = {1, 2, 3};
    static const int high[3] = {5, 8, 9};
    static const int middle[3] = {5, 8, 6};
    static const int one[3] = {2, 3, 4};
    box made = {.low = {-4, 0, 17}};
    assert_int_equal(check_faces(&made, SVO_VOXEL_FORMAT_PLY), 0);
    fill(&made, low, one, 7);
    assert_int_equal(check_faces(&made, SVO_VOXEL_FORMAT_OBJ), 6);
    fill(&made, low, high, 7);
    assert_int_equal(check_faces(&made, SVO_VOXEL_FORMAT_OBJ), 6);
    assert_int_equal(check_faces(&made, SVO_VOXEL_FORMAT_PLY), 6);
    fill(&made, low, middle, 8); /* another color below half of it */
    assert_int_equal(check_faces(&made, SVO_VOXEL_FORMAT_PLY), 10);
}

static void test_random_voxels(void **state)
{
    (void)state;
    uint32_t dice = 4711;
    for (unsigned share = 1; share < 10; ++share) {
        for (int round = 0; round < 4; ++round) {
            box made = {.low = {round * 1000, -5, 3 - 9 * round}};
            for (int i = 0; i < CELLS; ++i) {
                dice = dice * 1664525u + 1013904223u;
                const uint8_t color = (uint8_t)(1 + (dice >> 20) % 3);
                made.color[i % SIDE][i / SIDE % SIDE][i / SIDE / SIDE] = (dice >> 8) % 10 < share ? color : 0;
            }
            const svo_voxel_format format = round % 2 == 0 ? SVO_VOXEL_FORMAT_PLY : SVO_VOXEL_FORMAT_OBJ;
            assert_true(check_faces(&made, format) > 6);
        }
    }
}

/* Planes that are no floats: faces on far sides stay below them, those on near sides above. */
static void test_planes_that_are_no_floats(void **state)
{
    (void)state;
    static const double widths[] = {0.1, 1.0 / 3.0, 1e-30, 3e20, 1.0};
    static const double origins[][3] = {{0.0, 0.0, 0.0}, {0.3, -0.7, 1e-3}};
    static const int low[3] = {0, 0, 0};
    static const int high[3] = {9, 9, 9};
    box made = {.low = {-5, -4, 7}};
    fill(&made, low, high, 1);
    for (size_t i = 0; i < 10; ++i) {
        const double width = widths[i / 2];
        const double *origin = origins[width > 1e-3 && width < 1e3 ? i % 2 : 0];
        byte_list file = {0};
        svo_voxels *voxels = list_of(&made, width, origin);
        assert_int_equal(
            svo_voxels_save_faces(voxels, svo_to_callback(append, &file), SVO_VOXEL_FORMAT_PLY, NULL, NULL), SVO_OK);
        assert_int_equal(parse_ply(&file), 6);
        for (int corner = 0; corner < 24 * 3; ++corner) {
            const int axis = corner % 3;
            const double at = quads[corner / 12].corner[corner / 3 % 4][axis];
            const long double least = (long double)origin[axis] + (long double)made.low[axis] * (long double)width;
            const long double end = least + (long double)SIDE * (long double)width;
            assert_true((long double)at >= least && (long double)at < end);
            assert_true((long double)at < least + (long double)width / 1000 ||
                        (long double)at > end - (long double)width / 1000);
        }
        bytes_free(&file);
        svo_voxels_destroy(&voxels);
    }
}

static void expect_refused(const svo_voxels *voxels, svo_sink sink, svo_voxel_format format, const char *words)
{
    svo_message message = {""};
    assert_int_equal(svo_voxels_save_faces(voxels, sink, format, NULL, &message), SVO_INVALID_ARGUMENT);
    assert_string_equal(message.text, words);
}

static int refuse_bytes(void *user, const void *bytes, size_t byte_count)
{
    (void)user;
    (void)bytes;
    (void)byte_count;
    return 1;
}

static void test_what_is_refused(void **state)
{
    (void)state;
    static const double nowhere[3] = {0.0, 0.0, 0.0};
    static const double far_away[3] = {0.0, 4194304.0, 0.0};
    static const double too_far[3] = {0.0, 8388608.0, 0.0};
    box made = {.low = {0, 0, 0}};
    byte_list file = {0};
    svo_message message = {""};
    svo_voxels_save_info small = {.struct_size = 8};
    made.color[1][1][1] = 1;
    svo_voxels *voxels = list_of(&made, 2.0, nowhere);
    const svo_sink sink = svo_to_callback(append, &file);
    expect_refused(NULL, sink, SVO_VOXEL_FORMAT_PLY, "svo_voxels_save_faces: voxels is NULL");
    expect_refused(voxels, sink, SVO_VOXEL_FORMAT_VOX, "svo_voxels_save_faces: format 1 is neither 4 nor 5");
    expect_refused(voxels, svo_to_path("a.vox"), SVO_VOXEL_FORMAT_AUTO,
                   "svo_voxels_save_faces: the suffix of 'a.vox' is neither ply nor obj, and format is 1");
    assert_int_equal(svo_voxels_save_faces(voxels, sink, SVO_VOXEL_FORMAT_OBJ, &small, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(
        svo_voxels_save_faces(voxels, svo_to_callback(refuse_bytes, NULL), SVO_VOXEL_FORMAT_OBJ, NULL, &message),
        SVO_FILE_ERROR);
    svo_voxels_destroy(&voxels);
    voxels = list_of(&made, 2.0, far_away);
    assert_int_equal(svo_voxels_save_faces(voxels, sink, SVO_VOXEL_FORMAT_PLY, NULL, NULL), SVO_OK);
    svo_voxels_destroy(&voxels);
    voxels = list_of(&made, 2.0, too_far);
    expect_refused(voxels, sink, SVO_VOXEL_FORMAT_PLY,
                   "svo_voxels_save_faces: voxels of width 2 lie at up to 8.38861e+06, where floats are 1 apart");
    svo_voxels_destroy(&voxels);
    bytes_free(&file);
}

TEST_GROUP(voxel_faces)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boxes_have_six_rectangles),
        cmocka_unit_test(test_random_voxels),
        cmocka_unit_test(test_planes_that_are_no_floats),
        cmocka_unit_test(test_what_is_refused),
    };
    return cmocka_run_group_tests_name("voxel_faces", tests, NULL, NULL);
}
