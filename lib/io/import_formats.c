/* SPDX-License-Identifier: MIT */
/* Which reader a file is for. */
#define _POSIX_C_SOURCE 200809L
#include "io/import_formats.h"

#include <strings.h>

#include "core/message.h"
#include "io/import_gltf.h"
#include "io/import_obj.h"
#include "io/import_off.h"
#include "io/import_ply.h"
#include "io/import_stl.h"

static bool begins_with(const char *bytes, size_t byte_count, const char *text)
{
    return byte_count >= strlen(text) && memcmp(bytes, text, strlen(text)) == 0;
}

mesh_format svo_i_mesh_format(const char *path, const char *bytes, size_t byte_count)
{
    static const struct {
        const char *suffix;
        mesh_format format;
    } known[] = {{".obj", MESH_FORMAT_OBJ}, {".ply", MESH_FORMAT_PLY},  {".stl", MESH_FORMAT_STL},
                 {".off", MESH_FORMAT_OFF}, {".glb", MESH_FORMAT_GLTF}, {".gltf", MESH_FORMAT_GLTF}};
    const size_t length = strlen(path);
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        const size_t suffix_length = strlen(known[i].suffix);
        if (length > suffix_length && strcasecmp(path + length - suffix_length, known[i].suffix) == 0) {
            return known[i].format;
        }
    }
    if (begins_with(bytes, byte_count, "ply\n") || begins_with(bytes, byte_count, "ply\r")) {
        return MESH_FORMAT_PLY;
    }
    if (begins_with(bytes, byte_count, "glTF")) {
        return MESH_FORMAT_GLTF;
    }
    return begins_with(bytes, byte_count, "OFF\n") || begins_with(bytes, byte_count, "OFF\r") ? MESH_FORMAT_OFF
                                                                                              : MESH_FORMAT_OTHER;
}

svo_status svo_i_read_mesh(mesh_reader *reader, mesh_format format)
{
    static const stream_reader names[] = {STREAM_READER_ASSIMP, STREAM_READER_OBJ, STREAM_READER_PLY,
                                          STREAM_READER_STL,    STREAM_READER_OFF, STREAM_READER_GLTF};
    *reader->counts = (stream_counts){.reader = names[format]};
    switch (format) {
    case MESH_FORMAT_OBJ:
        SVO_I_TRY(svo_i_read_obj(reader));
        break;
    case MESH_FORMAT_PLY:
        SVO_I_TRY(svo_i_read_ply(reader));
        break;
    case MESH_FORMAT_STL:
        SVO_I_TRY(svo_i_read_stl(reader));
        break;
    case MESH_FORMAT_GLTF:
        SVO_I_TRY(svo_i_read_gltf(reader));
        break;
    default:
        SVO_I_TRY(svo_i_read_off(reader));
        break;
    }
    return reader->mesh->triangle_count > 0 ? SVO_OK : svo_i_fail(reader->message, SVO_IMPORT_FAILED, "no triangles");
}
