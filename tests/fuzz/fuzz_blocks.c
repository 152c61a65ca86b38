/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as a mesh file that is read in blocks, after a byte that is 1 for PLY, else STL. Either
 * the file is refused or left to the import with a one-line message, or both passes give the triangles that the import
 * gives.
 */
#define _GNU_SOURCE /* memfd_create */
#include <math.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "fuzz.h"
#include "io/import_formats.h"
#include "parts/blocks.h"

#define PATH_BYTES 64

/* Bit for bit: NaN and zeros of both signs are told apart. */
static bool are_same_floats(const float *a, const void *b, size_t count)
{
    return memcmp((const void *)a, b, count * sizeof *a) == 0;
}

/* Whether a corner of a block is that of the imported mesh. */
static bool is_same_corner(const svo_mesh *block, size_t corner, const gather *mesh, uint32_t index)
{
    const float *position = block->positions + corner * 3;
    if (index == GATHER_NO_VERTEX) {
        return isnan(position[0]);
    }
    const gather_vertex *vertex = &mesh->vertices[index];
    return are_same_floats(position, vertex->position, 3) &&
           (block->normals == NULL || are_same_floats(block->normals + corner * 3, vertex->normal, 3)) &&
           (block->colors == NULL || memcmp(block->colors + corner * 4, vertex->color, sizeof vertex->color) == 0);
}

/* Reads all blocks. mesh: what they must be; NULL: not known. */
static svo_status read_all(svo_i_blocks *blocks, const gather *mesh)
{
    svo_mesh block;
    size_t triangles = 0;
    do {
        const svo_status status = svo_i_blocks_next(blocks, &block);
        if (status != SVO_OK) {
            return status;
        }
        REQUIRE(block.triangle_count <= BLOCK_TRIANGLES && block.vertex_count == 3 * block.triangle_count);
        REQUIRE(mesh == NULL || block.triangle_count <= mesh->triangle_count - triangles);
        for (size_t i = 0; i < block.vertex_count && mesh != NULL; ++i) {
            REQUIRE(is_same_corner(&block, i, mesh, mesh->indices[triangles * 3 + i]));
        }
        triangles += block.triangle_count;
    } while (block.triangle_count > 0);
    REQUIRE(mesh == NULL || triangles == mesh->triangle_count);
    return SVO_OK;
}

/* The second pass beside the import. */
static void compare(svo_i_blocks *blocks, const uint8_t *data, size_t byte_count)
{
    gather mesh = {0};
    stream_counts counts;
    svo_message message = {""};
    mesh_reader reader = {.bytes = (const char *)data + 1,
                          .byte_count = byte_count - 1,
                          .stream = -1,
                          .mesh = &mesh,
                          .counts = &counts,
                          .message = &message};
    const svo_status status = svo_i_read_mesh(&reader, data[0] == 1 ? MESH_FORMAT_PLY : MESH_FORMAT_STL);
    REQUIRE(status == SVO_OK || strcmp(message.text, "no triangles") == 0);
    const svo_i_blocks_extent extent = svo_i_blocks_get_extent(blocks);
    svo_i_bounds bounds = {.any = false};
    bool any_color = false;
    REQUIRE(svo_i_blocks_bounds(blocks, 0, extent.vertices, &bounds, &any_color) == SVO_OK);
    svo_i_blocks_select(blocks, 0, extent.items, any_color);
    REQUIRE(read_all(blocks, &mesh) == SVO_OK);
    for (uint64_t i = 0; extent.is_even && i < 3; ++i) {
        svo_i_blocks_select(blocks, extent.items * i / 3, extent.items * (i + 1) / 3, any_color);
        REQUIRE(read_all(blocks, NULL) == SVO_OK || svo_i_blocks_is_uneven(blocks));
    }
    svo_i_gather_free(&mesh);
}

static void read_file(const char *path, const uint8_t *data, size_t byte_count)
{
    svo_i_blocks *blocks = NULL;
    svo_message message = {""};
    svo_status status = svo_i_blocks_open(path, &blocks, &message);
    if (status == SVO_OK) {
        status = read_all(blocks, NULL);
    }
    if (status == SVO_OK) {
        compare(blocks, data, byte_count);
    } else {
        REQUIRE(status == SVO_UNSUPPORTED || status == SVO_IMPORT_FAILED || status == SVO_OUT_OF_HOST_MEMORY);
        REQUIRE(strncmp(message.text, path, strlen(path)) == 0 && strchr(message.text, '\n') == NULL);
    }
    svo_i_blocks_close(&blocks);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    static char folder[] = "/tmp/svocl-fuzz-blocks-XXXXXX";
    char path[PATH_BYTES];
    char target[PATH_BYTES];
    if (byte_count == 0) {
        return 0;
    }
    REQUIRE(mkdtemp(folder) != NULL);
    const int file = memfd_create("mesh", 0);
    REQUIRE(file >= 0 && write(file, data + 1, byte_count - 1) == (ssize_t)(byte_count - 1));
    (void)snprintf(target, sizeof target, "/proc/self/fd/%d", file);
    (void)snprintf(path, sizeof path, "%s/a.%s", folder, data[0] == 1 ? "ply" : "stl");
    REQUIRE(symlink(target, path) == 0);
    read_file(path, data, byte_count);
    (void)unlink(path);
    (void)rmdir(folder);
    (void)snprintf(folder + sizeof folder - 7, 7, "XXXXXX");
    (void)close(file);
    return 0;
}
