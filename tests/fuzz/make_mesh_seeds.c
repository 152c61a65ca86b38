/* SPDX-License-Identifier: MIT */
/*
 * Writes the seeds of fuzz_mesh into a folder: small meshes that together use every array and option, so that a fuzzer
 * starts from meaningful inputs. seeds/README.md says when to run it.
 */
#include <math.h>
#include <string.h>

#include "fuzz.h"
#include "mesh_input.h"

#define SEED_BYTES_MAX 4096

typedef struct seed {
    uint8_t bytes[SEED_BYTES_MAX];
    size_t byte_count;
} seed;

static void append(seed *to, const void *bytes, size_t byte_count)
{
    REQUIRE(byte_count <= SEED_BYTES_MAX - to->byte_count);
    memcpy(to->bytes + to->byte_count, bytes, byte_count);
    to->byte_count += byte_count;
}

static void append_zeros(seed *to, size_t byte_count)
{
    REQUIRE(byte_count <= SEED_BYTES_MAX - to->byte_count);
    memset(to->bytes + to->byte_count, 0, byte_count);
    to->byte_count += byte_count;
}

static void write_seed(const char *folder, const char *name, const seed *from)
{
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    REQUIRE(file != NULL);
    REQUIRE(fwrite(from->bytes, 1, from->byte_count, file) == from->byte_count);
    REQUIRE(fclose(file) == 0);
}

/* The corners of a cube of edge 2 around the origin, and two triangles per side. */
static void append_cube(seed *to, bool attributes_follow)
{
    static const uint8_t indices[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                        2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    for (unsigned corner = 0; corner < 8; ++corner) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            const int16_t coordinate = (corner >> axis & 1u) != 0 ? 256 : -256;
            append(to, &coordinate, sizeof coordinate);
        }
    }
    append(to, indices, sizeof indices);
    if (attributes_follow) {
        append_zeros(to, 8 * 3 * sizeof(float));
    }
}

static void write_cube(const char *folder, const char *name, uint8_t depth, svo_coverage coverage)
{
    seed to = {.byte_count = 0};
    const mesh_input_head head = {.depth = depth,
                                  .position_form = POSITION_SMALL_FLOAT,
                                  .arrays = ARRAY_INDICES,
                                  .options = OPTIONS_GIVEN,
                                  .coverage = (uint8_t)coverage,
                                  .vertex_count = 8,
                                  .triangle_count = 12,
                                  .need = SVO_NEED_RAYS};
    append(&to, &head, sizeof head);
    append_cube(&to, false);
    write_seed(folder, name, &to);
}

/* A cube that reaches outside the caller's grid of the given edge. */
static void write_outside(const char *folder, const char *name, double edge)
{
    seed to = {.byte_count = 0};
    const mesh_input_head head = {.depth = 10,
                                  .position_form = POSITION_SMALL_DOUBLE,
                                  .arrays = ARRAY_INDICES,
                                  .options = OPTIONS_GIVEN | OPTIONS_GRID | OPTIONS_CAPACITY,
                                  .vertex_count = 8,
                                  .triangle_count = 12,
                                  .origin = {0.5, -1.0, 1.0 - edge},
                                  .edge = edge,
                                  .fragment_capacity = 5000};
    append(&to, &head, sizeof head);
    append_cube(&to, false);
    write_seed(folder, name, &to);
}

/* Every optional array, and a texture. */
static void write_textured(const char *folder, const char *name)
{
    static const uint8_t materials[2 * 5] = {255, 128, 64, 255, 0, 1, 2, 3, 4, 255};
    static const uint8_t texture[4 + 4 * 4] = {2, 2, SVO_WRAP_MIRROR, SVO_WRAP_CLAMP, 9, 99};
    seed to = {.byte_count = 0};
    const mesh_input_head head = {.depth = 6,
                                  .position_form = POSITION_SMALL_FLOAT,
                                  .arrays = ARRAY_INDICES | ARRAY_NORMALS | ARRAY_COLORS | ARRAY_UVS |
                                            ARRAY_TRIANGLE_MATERIALS | ARRAY_MATERIALS | ARRAY_TEXTURES,
                                  .options = OPTIONS_GIVEN,
                                  .vertex_count = 8,
                                  .triangle_count = 12,
                                  .material_count = 2,
                                  .texture_count = 1,
                                  .need = SVO_NEED_COLOR | SVO_NEED_NORMAL};
    append(&to, &head, sizeof head);
    append_cube(&to, true);
    append_zeros(&to, 8 * 4 + 8 * 2 * sizeof(float) + 12 * sizeof(uint16_t));
    append(&to, materials, sizeof materials);
    append(&to, texture, sizeof texture);
    write_seed(folder, name, &to);
}

/* Triangles from extreme coordinates: not finite, at the ends of the range, and zero. */
static void write_garbage(const char *folder, const char *name)
{
    static const double coordinates[] = {0.0,    1.0,  -0.0,  1e-310, 1e308,     -1e308, NAN, INFINITY, -INFINITY,
                                         5e-324, 1e38, 1e-38, 0.1,    -16777216, 1e5,    1e5, 1e5,      1e5 + 1e-9};
    seed to = {.byte_count = 0};
    const mesh_input_head head = {
        .depth = 9, .position_form = POSITION_DOUBLE, .arrays = ARRAY_INDICES, .vertex_count = 6, .triangle_count = 5};
    const uint8_t indices[15] = {0, 1, 2, 3, 4, 5, 3, 3, 4, 255, 254, 253, 4, 5, 5};
    append(&to, &head, sizeof head);
    append(&to, coordinates, sizeof coordinates);
    append(&to, indices, sizeof indices);
    write_seed(folder, name, &to);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        (void)fprintf(stderr, "usage: make_mesh_seeds FOLDER\n");
        return 2;
    }
    write_cube(argv[1], "cube", 5, SVO_COVERAGE_HALF_OPEN);
    write_cube(argv[1], "cube_closed", 10, SVO_COVERAGE_CLOSED);
    write_cube(argv[1], "cube_thin", 12, SVO_COVERAGE_THIN);
    write_cube(argv[1], "cube_deep", SVO_DEPTH_MAX, SVO_COVERAGE_HALF_OPEN);
    write_outside(argv[1], "outside", 1.0);
    write_outside(argv[1], "far_outside", 1.0 / 256.0);
    write_textured(argv[1], "textured");
    write_garbage(argv[1], "garbage");
    return 0;
}
