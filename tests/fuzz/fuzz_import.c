/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as an OBJ, PLY, STL, OFF, MTL or glTF file, the first byte saying which. Either they are
 * refused with a one-line message, or the mesh is well formed: each triangle has vertices that exist, or none, and a
 * material.
 */
#include <fcntl.h>
#include <math.h>
#include <string.h>

#include "core/message.h"
#include "fuzz.h"
#include "io/import_formats.h"
#include "io/import_obj_mesh.h"

static void check_mesh(const gather *mesh)
{
    REQUIRE(mesh->triangle_count > 0);
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        REQUIRE(mesh->indices[i] < mesh->vertex_count || mesh->indices[i] == GATHER_NO_VERTEX);
    }
    for (size_t i = 0; i < mesh->triangle_count && mesh->material_count > 0; ++i) {
        REQUIRE(mesh->triangle_materials[i] < mesh->material_count);
    }
    for (size_t i = 0; i < mesh->material_count; ++i) {
        REQUIRE(isfinite(mesh->materials[i].normal_map.scale));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    static int nowhere = -1;
    if (nowhere < 0) {
        nowhere = open("/dev/null", O_WRONLY);
    }
    if (byte_count == 0) {
        return 0;
    }
    gather mesh = {0};
    stream_counts counts;
    svo_message message = {""};
    const unsigned kind = data[0] % 6u;
    mesh_reader reader = {.bytes = (const char *)data + 1,
                          .byte_count = byte_count - 1,
                          .stream = nowhere,
                          .mesh = &mesh,
                          .normal_maps = true,
                          .counts = &counts,
                          .message = &message};
    svo_status status = SVO_OK;
    if (kind == 4) {
        mtl_library library = {.slot_count = 0};
        status = svo_i_mtl_read(&library, &reader, "name", reader.bytes, reader.byte_count);
        svo_i_mtl_free(&library);
    } else {
        status = svo_i_read_mesh(&reader, kind == 5 ? MESH_FORMAT_GLTF : (mesh_format)(MESH_FORMAT_OBJ + kind));
        if (status == SVO_OK) {
            check_mesh(&mesh);
        }
    }
    if (status != SVO_OK) {
        REQUIRE(status == SVO_IMPORT_FAILED || status == SVO_OUT_OF_HOST_MEMORY);
        REQUIRE(message.text[0] != '\0' && strchr(message.text, '\n') == NULL);
    }
    svo_i_gather_free(&mesh);
    return 0;
}
