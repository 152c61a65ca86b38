/* SPDX-License-Identifier: MIT */
/* Faces over a list of vertices: cut into triangles and gathered. */
#include "io/import_faces.h"

#include <inttypes.h>
#include <stdlib.h>

#include "core/message.h"

svo_status svo_i_faces_begin(face_list *faces, const mesh_reader *reader, uint64_t vertex_count)
{
    *faces = (face_list){.reader = reader};
    if (vertex_count >= GATHER_NO_VERTEX) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "%" PRIu64 " vertices; at most %" PRIu32 " are possible",
                          vertex_count, GATHER_NO_VERTEX - 1);
    }
    faces->vertices = malloc((size_t)(vertex_count + 1) * sizeof *faces->vertices);
    faces->known = malloc((size_t)(vertex_count + 1) * sizeof *faces->known);
    faces->used = calloc((size_t)vertex_count + 1, sizeof *faces->used);
    if (faces->vertices == NULL || faces->known == NULL || faces->used == NULL) {
        return svo_i_read_out_of_memory(reader);
    }
    const gather_vertex neutral = {.color = {255, 255, 255, 255}};
    for (size_t i = 0; i < vertex_count; ++i) {
        faces->vertices[i] = neutral;
        faces->known[i] = GATHER_NO_VERTEX;
    }
    faces->vertex_count = (size_t)vertex_count;
    return SVO_OK;
}

svo_status svo_i_faces_end_vertices(face_list *faces, bool corner_uvs)
{
    bool done = svo_i_gather_reserve(faces->reader->mesh, faces->vertex_count, 0, corner_uvs);
    if (done && !corner_uvs) {
        faces->first = malloc((faces->vertex_count + 1) * sizeof *faces->first);
        done = faces->first != NULL && svo_i_gather_match(faces->vertices, faces->vertex_count, faces->first);
    }
    return done ? SVO_OK : svo_i_read_out_of_memory(faces->reader);
}

svo_status svo_i_faces_reserve(face_list *faces, uint64_t corner_count)
{
    if (corner_count <= faces->corner_capacity) {
        return SVO_OK;
    }
    const size_t capacity = 2 * (size_t)corner_count;
    free(faces->corners);
    faces->corner_capacity = 0;
    faces->corners = corner_count <= UINT32_MAX / 4 ? calloc(capacity, sizeof *faces->corners) : NULL;
    if (faces->corners == NULL || !svo_i_polygon_reserve(&faces->shape, (size_t)corner_count)) {
        return svo_i_read_out_of_memory(faces->reader);
    }
    faces->corner_capacity = capacity;
    return SVO_OK;
}

svo_status svo_i_faces_reserve_uvs(face_list *faces, uint64_t corner_count)
{
    if (corner_count <= faces->uv_capacity) {
        return SVO_OK;
    }
    free(faces->corner_uvs);
    faces->uv_capacity = 0;
    faces->corner_uvs = calloc(2 * (size_t)corner_count, sizeof *faces->corner_uvs);
    if (faces->corner_uvs == NULL) {
        return svo_i_read_out_of_memory(faces->reader);
    }
    faces->uv_capacity = 2 * (size_t)corner_count;
    return SVO_OK;
}

/* Counts a face with an index out of range; returns whether it has one. */
static bool note_bad(face_list *faces, uint32_t corner_count)
{
    for (uint32_t i = 0; i < corner_count; ++i) {
        if (faces->corners[i] < 0 || (uint64_t)faces->corners[i] >= faces->vertex_count) {
            if (faces->bad_count++ == 0) {
                faces->first_bad = faces->corners[i];
                faces->first_bad_face = faces->face_count;
            }
            return true;
        }
    }
    return false;
}

static void cut(face_list *faces, uint32_t corner_count, bool bad)
{
    polygon *shape = &faces->shape;
    if (bad) {
        for (uint32_t i = 0; i < corner_count - 2; ++i) {
            memcpy(shape->triangles + 3 * (size_t)i, (const uint32_t[]){0, i + 1, i + 2}, 3 * sizeof(uint32_t));
        }
        return;
    }
    for (uint32_t i = 0; corner_count > 3 && i < corner_count; ++i) {
        memcpy(shape->corners[i], faces->vertices[faces->corners[i]].position, sizeof shape->corners[i]);
    }
    svo_i_polygon_cut(shape, corner_count);
}

static bool gather_corner(face_list *faces, uint32_t corner, bool with_uvs, uint32_t *index)
{
    gather *mesh = faces->reader->mesh;
    const int64_t number = faces->corners[corner];
    *index = GATHER_NO_VERTEX;
    if (number < 0 || (uint64_t)number >= faces->vertex_count) {
        return true;
    }
    faces->used[number] = 1;
    if (with_uvs) {
        gather_vertex vertex = faces->vertices[number];
        memcpy(vertex.uv, faces->corner_uvs[corner], sizeof vertex.uv);
        return svo_i_gather_vertex(mesh, &vertex, index);
    }
    const size_t vertex = faces->first != NULL ? faces->first[number] : (size_t)number;
    if (faces->known[vertex] == GATHER_NO_VERTEX) {
        const gather_vertex *source = &faces->vertices[vertex];
        if (!(faces->first != NULL ? svo_i_gather_append(mesh, source, &faces->known[vertex])
                                   : svo_i_gather_vertex(mesh, source, &faces->known[vertex]))) {
            return false;
        }
    }
    *index = faces->known[vertex];
    return true;
}

svo_status svo_i_faces_add(face_list *faces, uint32_t corner_count, bool with_uvs)
{
    const bool bad = note_bad(faces, corner_count);
    ++faces->face_count;
    if (corner_count < 3) {
        ++faces->small_count;
        return SVO_OK;
    }
    cut(faces, corner_count, bad);
    const uint32_t *at = faces->shape.triangles;
    for (uint32_t i = 0; i < corner_count - 2; ++i, at += 3) {
        uint32_t indices[3];
        if (!gather_corner(faces, at[0], with_uvs, &indices[0]) ||
            !gather_corner(faces, at[1], with_uvs, &indices[1]) ||
            !gather_corner(faces, at[2], with_uvs, &indices[2]) ||
            !svo_i_gather_triangle(faces->reader->mesh, indices, 0)) {
            return svo_i_read_out_of_memory(faces->reader);
        }
    }
    return SVO_OK;
}

void svo_i_faces_warn(const face_list *faces)
{
    const mesh_reader *reader = faces->reader;
    uint64_t used_count = 0;
    for (size_t i = 0; i < faces->vertex_count; ++i) {
        used_count += faces->used[i];
    }
    svo_i_read_count_vertices(reader, used_count, faces->vertex_count);
    svo_i_read_count_faces(reader, faces->small_count, faces->face_count);
    if (faces->bad_count > 0) {
        svo_i_read_warn(reader,
                        "%" PRIu64 " of %" PRIu64 " faces name a vertex that does not exist; the first is face %" PRIu64
                        " with vertex %" PRId64 ", which is not in 0 .. %" PRId64,
                        faces->bad_count, faces->face_count, faces->first_bad_face, faces->first_bad,
                        (int64_t)faces->vertex_count - 1);
    }
    if (faces->shape.crossed_count > 0) {
        svo_i_read_warn(reader, "%" PRIu64 " polygons cross themselves; their triangles overlap",
                        faces->shape.crossed_count);
    }
}

void svo_i_faces_free(face_list *faces)
{
    free(faces->vertices);
    free(faces->known);
    free(faces->used);
    free(faces->first);
    free(faces->corners);
    free(faces->corner_uvs);
    svo_i_polygon_free(&faces->shape);
}
