/* SPDX-License-Identifier: MIT */
/*
 * What texels of probes store, on the device and on the host: the octahedral map, normals of two bytes, distances of
 * 16 bits, R11G11B10F. Each against what its formula says in double precision.
 */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "probes/encoding.h"
#include "shared/probe_layout.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/meshes.h"
#include "support/suite.h"

extern const char probe_codes_source[];

#define PI         3.14159265358979323846
#define RANDOM     1000000u
#define SPECIAL    (27u + 24u)
#define DIRECTIONS (RANDOM + SPECIAL)

/* ---- kernels ---- */

typedef struct device_kernel {
    const fixture *opened;
    cl_kernel kernel;
    cl_uint argument;
    cl_mem buffers[8];
    cl_uint buffer_count;
} device_kernel;

static device_kernel make_kernel(const fixture *opened, const char *name)
{
    const char *source = probe_codes_source;
    const cl_device_id device = info_of_device(opened->device).device;
    cl_program program = clCreateProgramWithSource(info_of_device(opened->device).context, 1, &source, NULL, NULL);
    if (clBuildProgram(program, 1, &device, "-cl-std=CL1.2", NULL, NULL) != CL_SUCCESS) {
        static char log[4096];
        clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, sizeof log, log, NULL);
        fail_msg("%s", log);
    }
    const device_kernel out = {.opened = opened, .kernel = clCreateKernel(program, name, NULL)};
    clReleaseProgram(program);
    assert_non_null(out.kernel);
    return out;
}

static void add_value(device_kernel *of, const void *value, size_t bytes)
{
    assert_int_equal(clSetKernelArg(of->kernel, of->argument++, bytes, value), CL_SUCCESS);
}

/* data: NULL for an output. */
static void add_buffer(device_kernel *of, const void *data, size_t bytes)
{
    cl_mem buffer = clCreateBuffer(info_of_device(of->opened->device).context, CL_MEM_READ_WRITE, bytes, NULL, NULL);
    assert_non_null(buffer);
    of->buffers[of->buffer_count++] = buffer;
    if (data != NULL) {
        assert_int_equal(clEnqueueWriteBuffer(of->opened->queue, buffer, CL_TRUE, 0, bytes, data, 0, NULL, NULL),
                         CL_SUCCESS);
    }
    add_value(of, &buffer, sizeof buffer);
}

static void run(const device_kernel *of, size_t items)
{
    const size_t local = 1;
    assert_int_equal(clEnqueueNDRangeKernel(of->opened->queue, of->kernel, 1, NULL, &items, &local, 0, NULL, NULL),
                     CL_SUCCESS);
}

/* The copy of a buffer; released by free. */
static void *read_back(const device_kernel *of, cl_uint buffer, size_t bytes)
{
    void *copy = malloc(bytes);
    assert_non_null(copy);
    assert_int_equal(
        clEnqueueReadBuffer(of->opened->queue, of->buffers[buffer], CL_TRUE, 0, bytes, copy, 0, NULL, NULL),
        CL_SUCCESS);
    return copy;
}

static void release(device_kernel *of)
{
    for (cl_uint i = 0; i < of->buffer_count; ++i) {
        clReleaseMemObject(of->buffers[i]);
    }
    clReleaseKernel(of->kernel);
}

/* ---- directions ---- */

/* Random ones over the sphere, of lengths from 1e-6 to 1e6. */
static void random_direction(uint64_t *random, float direction[3])
{
    const double z = 2 * random_unit(random) - 1;
    const double angle = 2 * PI * random_unit(random);
    const double length = pow(10, 12 * random_unit(random) - 6);
    const double across = sqrt(1 - z * z);
    direction[0] = (float)(length * across * cos(angle));
    direction[1] = (float)(length * across * sin(angle));
    direction[2] = (float)(length * z);
}

/* Axes, edges and corners of the octahedron and of the cube, with zeros of both signs; and next to them. Returns how
   many. */
static size_t special_directions(float *directions)
{
    size_t count = 0;
    for (int k = 0; k < 27; ++k) {
        if (k != 13) {
            const int corner[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
            for (size_t axis = 0; axis < 3; ++axis) {
                directions[3 * count + axis] = (float)corner[axis];
            }
            ++count;
        }
    }
    for (int k = 0; k < 24; ++k) {
        float *to = directions + 3 * count++;
        const float zero = k % 2 != 0 ? -0.0F : k % 4 == 0 ? 0.0F : FLT_MIN;
        to[k % 3] = k / 12 != 0 ? 1.0F : -1.0F;
        to[(k + 1) % 3] = zero;
        to[(k + 2) % 3] = k / 6 % 2 != 0 ? -zero : zero;
    }
    return count;
}

/* The point of a direction as the specification has it. */
static void point_of(const float direction[3], double point[2])
{
    const double sum = fabs((double)direction[0]) + fabs((double)direction[1]) + fabs((double)direction[2]);
    const double x = (double)direction[0] / sum;
    const double y = (double)direction[1] / sum;
    const bool folds = direction[2] < 0.0F;
    point[0] = folds ? (1 - fabs(y)) * (x >= 0 ? 1 : -1) : x;
    point[1] = folds ? (1 - fabs(x)) * (y >= 0 ? 1 : -1) : y;
}

static double angle_between(const float a[3], const float b[3])
{
    double cross[3];
    double dot = 0;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3;
        const int j = (k + 2) % 3;
        cross[k] = (double)a[i] * (double)b[j] - (double)a[j] * (double)b[i];
        dot += (double)a[k] * (double)b[k];
    }
    return atan2(sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]), dot);
}

/* A coordinate of the square against the texel that it is said to be in. */
static void expect_in_texel(const float direction[3], uint32_t resolution, uint32_t column, uint32_t row)
{
    double point[2];
    const uint32_t place[2] = {column, row};
    point_of(direction, point);
    for (int k = 0; k < 2; ++k) {
        const double texels = (point[k] + 1) / 2 * resolution;
        if (!(place[k] < resolution && texels >= place[k] - 3e-4 && texels <= place[k] + 1 + 3e-4)) {
            fail_msg("(%a, %a, %a) is at %.6f of %u texels, not in texel %u", (double)direction[0],
                     (double)direction[1], (double)direction[2], texels, resolution, place[k]);
            return;
        }
    }
}

/* Within a degree, and the bytes are those of round(127 p) but where that is a tie. */
static void expect_normal(const float direction[3], uint32_t word, const float device[3])
{
    double point[2];
    float host[3];
    point_of(direction, point);
    svo_probe_normal(word, host);
    for (int k = 0; k < 2; ++k) {
        const int byte = (int)(word >> (16 + 8 * k) & 0xffu);
        const int code = byte < 128 ? byte : byte - 256;
        if (!(fabs(127 * point[k] - code) <= 0.5 + 1e-4) || (word & 0xffffu) != 0) {
            fail_msg("(%a, %a, %a): %.6f became %d", (double)direction[0], (double)direction[1], (double)direction[2],
                     127 * point[k], code);
            return;
        }
    }
    if (!(angle_between(direction, host) <= PI / 180) || !(angle_between(device, host) <= 1e-6)) {
        fail_msg("(%a, %a, %a): off by %g degrees, the device by %g from the host", (double)direction[0],
                 (double)direction[1], (double)direction[2], angle_between(direction, host) * 180 / PI,
                 angle_between(device, host));
    }
}

static void directions_come_back(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const uint32_t resolutions[] = {64, 144, 1024};
    float *directions = malloc((size_t)DIRECTIONS * 3 * sizeof *directions);
    uint64_t random = 17;
    assert_non_null(directions);
    size_t count = special_directions(directions);
    for (; count < DIRECTIONS - 1; ++count) {
        random_direction(&random, directions + 3 * count);
    }
    for (int k = 0; k < 3; ++k) {
        device_kernel kernel = make_kernel(&opened, "code_directions");
        add_buffer(&kernel, directions, count * 3 * sizeof(float));
        add_value(&kernel, &resolutions[k], sizeof resolutions[k]);
        add_buffer(&kernel, NULL, count * sizeof(uint32_t));
        add_buffer(&kernel, NULL, count * sizeof(uint32_t));
        add_buffer(&kernel, NULL, count * 3 * sizeof(float));
        add_buffer(&kernel, NULL, count * 2 * sizeof(float));
        run(&kernel, count);
        uint32_t *texels = read_back(&kernel, 1, count * sizeof *texels);
        uint32_t *normals = read_back(&kernel, 2, count * sizeof *normals);
        float *back = read_back(&kernel, 3, count * 3 * sizeof *back);
        float *points = read_back(&kernel, 4, count * 2 * sizeof *points);
        for (size_t i = 0; i < count; ++i) {
            uint32_t column = 0;
            uint32_t row = 0;
            double point[2];
            svo_probe_texel(resolutions[k], directions + 3 * i, &column, &row);
            expect_in_texel(directions + 3 * i, resolutions[k], column, row);
            expect_in_texel(directions + 3 * i, resolutions[k], texels[i] % resolutions[k], texels[i] / resolutions[k]);
            expect_normal(directions + 3 * i, normals[i], back + 3 * i);
            point_of(directions + 3 * i, point);
            assert_true(fabs(points[2 * i] - point[0]) <= 1e-6 && fabs(points[2 * i + 1] - point[1]) <= 1e-6);
        }
        free(texels);
        free(normals);
        free(back);
        free(points);
        release(&kernel);
    }
    free(directions);
}

/* Axes are exact. */
static void axes_are_exact_normals(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const uint32_t resolution = 64;
    float axes[6][3] = {{0}};
    for (int k = 0; k < 6; ++k) {
        axes[k][k / 2] = k % 2 != 0 ? -1.0F : 1.0F;
    }
    device_kernel kernel = make_kernel(&opened, "code_directions");
    add_buffer(&kernel, axes, sizeof axes);
    add_value(&kernel, &resolution, sizeof resolution);
    add_buffer(&kernel, NULL, 6 * sizeof(uint32_t));
    add_buffer(&kernel, NULL, 6 * sizeof(uint32_t));
    add_buffer(&kernel, NULL, sizeof axes);
    add_buffer(&kernel, NULL, 12 * sizeof(float));
    run(&kernel, 6);
    uint32_t *words = read_back(&kernel, 2, 6 * sizeof *words);
    float *back = read_back(&kernel, 3, sizeof axes);
    for (int k = 0; k < 6; ++k) {
        float normal[3];
        svo_probe_normal(words[k], normal);
        for (int axis = 0; axis < 3; ++axis) {
            assert_true(normal[axis] == axes[k][axis]);
            assert_true(back[3 * k + axis] == axes[k][axis]);
        }
    }
    free(words);
    free(back);
    release(&kernel);
}

/* Each texel's center lies in that texel, and its whole-number direction is that of the center. */
static void centers_lie_in_their_texels(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static const uint32_t resolutions[] = {8, 64, 80, 1024};
    for (int k = 0; k < 4; ++k) {
        const uint32_t resolution = resolutions[k];
        const size_t count = (size_t)resolution * resolution;
        device_kernel kernel = make_kernel(&opened, "code_vectors");
        add_value(&kernel, &resolution, sizeof resolution);
        add_buffer(&kernel, NULL, count * 3 * sizeof(int32_t));
        run(&kernel, count);
        int32_t *vectors = read_back(&kernel, 0, count * 3 * sizeof *vectors);
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t place[2] = {i % resolution, i / resolution};
            float direction[3];
            float vector[3];
            int32_t own[3];
            double point[2];
            uint32_t column = 0;
            uint32_t row = 0;
            svo_i_probe_texel_vector(resolution, place[0], place[1], own);
            assert_memory_equal(own, vectors + (size_t)3 * i, sizeof own);
            for (int axis = 0; axis < 3; ++axis) {
                vector[axis] = (float)own[axis];
            }
            point_of(vector, point);
            assert_true(fabs(point[0] - ((2.0 * place[0] + 1) / resolution - 1)) < 1e-12);
            assert_true(fabs(point[1] - ((2.0 * place[1] + 1) / resolution - 1)) < 1e-12);
            svo_probe_direction(resolution, place[0], place[1], direction);
            assert_true(angle_between(direction, vector) < 1e-6);
            svo_probe_texel(resolution, direction, &column, &row);
            assert_int_equal(column, place[0]);
            assert_int_equal(row, place[1]);
        }
        free(vectors);
        release(&kernel);
    }
}

/* ---- distances ---- */

static svo_probe_info grid_of(double leaf_edges, float leaf_edge)
{
    svo_probe_info info = SVO_PROBE_INFO_INIT;
    info.leaf_edge = leaf_edge;
    info.farthest = (float)(leaf_edges * leaf_edge);
    return info;
}

/* The bound of the error of a distance, in leaf edges. */
static double distance_bound(double distance, double farthest)
{
    return (1 + 1e-4) * (distance + 1) * log(farthest + 1) / 131068;
}

static void check_distances(const fixture *opened, const svo_probe_info *info)
{
    enum { COUNT = 200000 };
    const double leaf_edge = (double)info->leaf_edge;
    const double farthest = (double)info->farthest / leaf_edge;
    const svo_probes_params params = {.leaf_edge = info->leaf_edge, .code_log2 = (float)log2(farthest + 1)};
    static uint64_t thresholds[SVO_I_PROBE_CODES];
    static float distances[COUNT];
    uint64_t random = 5;
    svo_i_probe_thresholds(info->farthest, info->leaf_edge, thresholds);
    for (int i = 0; i < COUNT; ++i) {
        const double share = i < 2 ? i : random_unit(&random);
        distances[i] = (float)((i % 2 != 0 ? share * farthest : pow(farthest + 1, share) - 1) * leaf_edge);
    }
    device_kernel kernel = make_kernel(opened, "code_distances");
    add_buffer(&kernel, distances, sizeof distances);
    add_buffer(&kernel, thresholds, sizeof thresholds);
    add_value(&kernel, &params, sizeof params);
    add_buffer(&kernel, NULL, COUNT * sizeof(uint32_t));
    add_buffer(&kernel, NULL, COUNT * sizeof(float));
    run(&kernel, COUNT);
    uint32_t *codes = read_back(&kernel, 2, COUNT * sizeof *codes);
    float *back = read_back(&kernel, 3, COUNT * sizeof *back);
    for (int i = 0; i < COUNT; ++i) {
        const double distance = (double)distances[i] / leaf_edge;
        const double decoded = svo_probe_distance(info, codes[i]) / leaf_edge;
        const double on_device = (double)back[i] / leaf_edge;
        const double bound = distance_bound(distance, farthest);
        if (!(fabs(decoded - distance) <= bound) || !(fabs(on_device - decoded) <= 2e-6 * (decoded + 1))) {
            fail_msg("distance %.9g of %.9g became code %u, %.9g, on the device %.9g: bound %g", distance, farthest,
                     codes[i], decoded, on_device, bound);
            break;
        }
    }
    assert_int_equal(codes[0], 0);
    assert_int_equal(codes[1], SVO_PROBE_CODE_MAX);
    free(codes);
    free(back);
    release(&kernel);
}

static void distances_are_within_their_bound(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_probe_info grids[] = {grid_of(sqrt(3) * 2, 0.5F), grid_of(sqrt(3) * 64, 1.0F / 64),
                                    grid_of(sqrt(3) * 1024, 3.7F), grid_of(sqrt(3) * 65536, 1e-20F),
                                    grid_of(1e6, 1e15F)};
    for (size_t k = 0; k < sizeof grids / sizeof grids[0]; ++k) {
        check_distances(&opened, &grids[k]);
        assert_true(isinf(svo_probe_distance(&grids[k], SVO_PROBE_NOTHING)));
    }
}

/* Keys are doubles but for what a double cannot hold. */
static void keys_are_squares(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    enum { COUNT = 100000 };
    static float ts[COUNT];
    static uint32_t lengths2[COUNT];
    const int32_t scale_log2 = 7;
    uint64_t random = 11;
    for (int i = 0; i < COUNT; ++i) {
        ts[i] = (float)ldexp(1 + random_unit(&random), (int)random_below(&random, 120) - 60);
        lengths2[i] = i % 2 != 0 ? 1 + random_below(&random, 1u << 20) : (1u << 20) >> i % 21;
    }
    ts[0] = 0.0F;
    device_kernel kernel = make_kernel(&opened, "make_keys");
    add_buffer(&kernel, ts, sizeof ts);
    add_buffer(&kernel, lengths2, sizeof lengths2);
    add_value(&kernel, &scale_log2, sizeof scale_log2);
    add_buffer(&kernel, NULL, COUNT * sizeof(uint64_t));
    add_buffer(&kernel, NULL, COUNT * sizeof(uint64_t));
    run(&kernel, COUNT);
    double *keys = read_back(&kernel, 2, COUNT * sizeof *keys);
    double *squares = read_back(&kernel, 3, COUNT * sizeof *squares);
    assert_true(keys[0] == 0 && squares[0] == 0);
    for (int i = 1; i < COUNT; ++i) {
        const double exact = (double)ts[i] * (double)ts[i] * lengths2[i];
        if (!(fabs(keys[i] - exact) <= exact * 0x1p-41) || squares[i] != ldexp((double)ts[i], -2 * scale_log2)) {
            fail_msg("%a^2 * %u became %a instead of %a; the square %a", (double)ts[i], lengths2[i], keys[i], exact,
                     squares[i]);
            break;
        }
    }
    free(keys);
    free(squares);
    release(&kernel);
}

/* Thresholds lie halfway between codes, in the exponent; lengths are distances in parts of a leaf edge. */
static void tables_are_those_of_the_formula(void **state)
{
    (void)state;
    static const double grids[] = {3.4, 111, 1773.6, 113511.7, 1e6};
    static uint64_t thresholds[SVO_I_PROBE_CODES];
    static uint32_t lengths[SVO_I_PROBE_CODES];
    for (size_t k = 0; k < sizeof grids / sizeof grids[0]; ++k) {
        const svo_probe_info info = grid_of(grids[k], 0.375F);
        const double growth = log1p((double)info.farthest / 0.375);
        svo_i_probe_thresholds(info.farthest, info.leaf_edge, thresholds);
        svo_i_probe_lengths(info.farthest, info.leaf_edge, lengths);
        assert_true(thresholds[0] == 0 && lengths[0] == 0);
        for (uint32_t code = 1; code < SVO_I_PROBE_CODES; ++code) {
            const double distance = 0.375 * expm1(growth * (code - 0.5) / 65534);
            const double parts = fmin(256 * expm1(growth * code / 65534), SVO_PROBE_LENGTH_MAX);
            double squared = 0;
            memcpy(&squared, &thresholds[code], sizeof squared);
            if (!(fabs(squared - distance * distance) <= 1e-8 * squared) || !(fabs(lengths[code] - parts) <= 0.5001) ||
                thresholds[code] <= thresholds[code - 1]) {
                fail_msg("code %u of %g: threshold %.9g instead of %.9g, length %u instead of %.3f", code, grids[k],
                         squared, distance * distance, lengths[code], parts);
                return;
            }
        }
    }
}

/* ---- radiance ---- */

/* The nearest number with so many bits of mantissa, ties to even, as R11G11B10F has it. */
static double nearest_small(double value, int mantissa_bits)
{
    const double largest = ldexp(2 - ldexp(1, -mantissa_bits), 15);
    int exponent = 0;
    if (!(value > 0)) {
        return 0;
    }
    (void)frexp(value, &exponent);
    const double unit = ldexp(1, (exponent - 1 < -14 ? -14 : exponent - 1) - mantissa_bits);
    return value < largest ? fmin(rint(value / unit) * unit, largest) : largest;
}

static void check_radiance(const fixture *opened, const float *radiance, size_t count)
{
    device_kernel kernel = make_kernel(opened, "code_radiance");
    add_buffer(&kernel, radiance, count * 3 * sizeof(float));
    add_buffer(&kernel, NULL, count * sizeof(uint32_t));
    add_buffer(&kernel, NULL, count * 3 * sizeof(float));
    run(&kernel, count);
    uint32_t *words = read_back(&kernel, 1, count * sizeof *words);
    float *back = read_back(&kernel, 2, count * 3 * sizeof *back);
    for (size_t i = 0; i < 3 * count; ++i) {
        float host[3];
        svo_probe_radiance(words[i / 3], host);
        const double expected = nearest_small((double)radiance[i], i % 3 == 2 ? 5 : 6);
        if ((double)host[i % 3] != expected || back[i] != host[i % 3]) {
            fail_msg("%a became %a on the host, %a on the device, instead of %a", (double)radiance[i],
                     (double)host[i % 3], (double)back[i], expected);
            break;
        }
    }
    free(words);
    free(back);
    release(&kernel);
}

static void radiance_is_rounded_to_the_nearest(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    enum { COUNT = 30000 };
    static float radiance[COUNT];
    static const float special[] = {0.0F,     -0.0F,    -1.0F,    NAN,      INFINITY, -INFINITY, 65024.0F, 65023.0F,
                                    65025.0F, 64512.0F, 64511.0F, 65535.0F, 1e30F,    FLT_MIN,   1e-40F,   0x1p-20F,
                                    0x1p-21F, 0x3p-21F, 0x1p-14F, 0x1p-15F, 1.0F,     0.5F,      64000.0F, 2.0F};
    const size_t specials = sizeof special / sizeof special[0];
    uint64_t random = 3;
    for (size_t i = 0; i < COUNT; ++i) {
        radiance[i] = i < 3 * specials ? special[i / 3] /* in each channel */
                      : i % 2 != 0     ? (float)exp2(36 * random_unit(&random) - 20)
                                       : (float)ldexp(random_below(&random, 512), (int)random_below(&random, 24) - 22);
    }
    check_radiance(&opened, radiance, COUNT / 3);
}

/* All codes come back as themselves. */
static void codes_of_radiance_come_back(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    enum { CODES = 31 * 64 };
    static float radiance[CODES * 3];
    for (uint32_t code = 0; code < CODES; ++code) {
        const uint32_t word = code | code << 11 | code / 2 << 22;
        svo_probe_radiance(word, radiance + (size_t)3 * code);
    }
    assert_true(radiance[3 * (CODES - 1)] == 65024.0F && radiance[3 * (CODES - 1) + 2] == 64512.0F);
    assert_true(radiance[3] == 0x1p-20F && radiance[3 * 2 + 2] == 0x1p-19F);
    check_radiance(&opened, radiance, CODES);
}

TEST_GROUP(probe_codes)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directions_come_back),
        cmocka_unit_test(axes_are_exact_normals),
        cmocka_unit_test(centers_lie_in_their_texels),
        cmocka_unit_test(distances_are_within_their_bound),
        cmocka_unit_test(keys_are_squares),
        cmocka_unit_test(tables_are_those_of_the_formula),
        cmocka_unit_test(radiance_is_rounded_to_the_nearest),
        cmocka_unit_test(codes_of_radiance_come_back),
    };
    return cmocka_run_group_tests_name("probe_codes", tests, fixture_group_setup, fixture_group_teardown);
}
