/* SPDX-License-Identifier: MIT */
/*
 * Polygons to triangles, and faces over a list of vertices, which are cut into triangles and gathered.
 *
 * The choices (which corner a fan begins at, which ear comes first) and their arithmetic in single precision are those
 * of assimp's aiProcess_Triangulate, so that a mesh has the same triangles whichever of the two read it.
 */
#include "io/import_faces.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/message.h"

/* ---- polygons ---- */

#define PI_FLOAT 3.14159265358979323846f

bool svo_i_polygon_reserve(polygon *shape, size_t corner_count)
{
    if (corner_count <= shape->corner_capacity) {
        return true;
    }
    size_t bytes = 0;
    const size_t capacity = corner_count < SIZE_MAX / 2 ? 2 * corner_count : corner_count;
    if (!svo_i_mul_size(capacity, 3 * sizeof(float), &bytes)) {
        return false;
    }
    svo_i_polygon_free(shape);
    shape->corners = malloc(bytes);
    shape->triangles = malloc(bytes);
    shape->flat = malloc(capacity * sizeof *shape->flat);
    shape->before = malloc(capacity * sizeof *shape->before);
    shape->after = malloc(capacity * sizeof *shape->after);
    shape->ears = malloc(capacity);
    if (shape->corners == NULL || shape->triangles == NULL || shape->flat == NULL || shape->before == NULL ||
        shape->after == NULL || shape->ears == NULL) {
        svo_i_polygon_free(shape);
        return false;
    }
    shape->corner_capacity = capacity;
    return true;
}

void svo_i_polygon_free(polygon *shape)
{
    free(shape->corners);
    free(shape->triangles);
    free(shape->flat);
    free(shape->before);
    free(shape->after);
    free(shape->ears);
    *shape = (polygon){.crossed_count = shape->crossed_count};
}

/* Four corners */

/* A vector of length 1 in the direction of to - from, or that difference where it has no length. */
static void direction(const float from[3], const float to[3], float out[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = to[axis] - from[axis];
    }
    const float length = sqrtf(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    if (length == 0) {
        return;
    }
    const float inverse = 1.0f / length;
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] *= inverse;
    }
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The corner whose angle, measured to the diagonal on both sides, is above 180 degrees; else 0. */
static uint32_t inward_corner(float (*corners)[3])
{
    float edges[4][3], diagonals[2][3], sides[2][3], across[3];
    for (uint32_t i = 0; i < 4; ++i) {
        direction(corners[i], corners[(i + 1) % 4], edges[i]);
    }
    direction(corners[0], corners[2], diagonals[0]);
    direction(corners[1], corners[3], diagonals[1]);
    for (uint32_t i = 0; i < 4; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            sides[0][axis] = -edges[(i + 3) % 4][axis];
            sides[1][axis] = edges[i][axis];
            across[axis] = i < 2 ? diagonals[i % 2][axis] : -diagonals[i % 2][axis];
        }
        const float left = dot(sides[0], across), right = dot(sides[1], across);
        /* Two angles within [0, 180] degrees have a sum above 180 where their cosines have one below 0. The slow
           functions decide only where rounding might. */
        if (left + right < 1e-3f && acosf(left) + acosf(right) > PI_FLOAT) {
            return i;
        }
    }
    return 0;
}

static void cut_four(polygon *shape)
{
    const uint32_t first = inward_corner(shape->corners);
    const uint32_t cut[6] = {first, (first + 1) % 4, (first + 2) % 4, first, (first + 2) % 4, (first + 3) % 4};
    memcpy(shape->triangles, cut, sizeof cut);
}

/* More corners */

/* The plane that the polygon covers most of, its axes ordered so that corners run counterclockwise. Newell's normal. */
static void project(polygon *shape, uint32_t corner_count)
{
    float(*const corners)[3] = shape->corners;
    float normal[3] = {0, 0, 0};
    for (uint32_t i = 0; i < corner_count; ++i) {
        const float *low = corners[i], *at = corners[(i + 1) % corner_count], *high = corners[(i + 2) % corner_count];
        normal[0] += at[1] * (high[2] - low[2]);
        normal[1] += at[2] * (high[0] - low[0]);
        normal[2] += at[0] * (high[1] - low[1]);
    }
    const float x = fabsf(normal[0]), y = fabsf(normal[1]), z = fabsf(normal[2]);
    int left_out = 2;
    if (x > y) {
        left_out = x > z ? 0 : 2;
    } else if (y > z) {
        left_out = 1;
    }
    const bool swapped = normal[left_out] < 0;
    const int first = (left_out + (swapped ? 2 : 1)) % 3, second = (left_out + (swapped ? 1 : 2)) % 3;
    for (uint32_t i = 0; i < corner_count; ++i) {
        shape->flat[i][0] = corners[i][first];
        shape->flat[i][1] = corners[i][second];
    }
}

/* Half the cross product, positive where the three turn clockwise. */
static double clockwise_area(const float a[2], const float b[2], const float c[2])
{
    return 0.5 * (a[0] * ((double)c[1] - b[1]) + b[0] * ((double)a[1] - c[1]) + c[0] * ((double)b[1] - a[1]));
}

static bool is_inside(const float a[2], const float b[2], const float c[2], const float point[2])
{
    const float u[2] = {b[0] - a[0], b[1] - a[1]}, v[2] = {c[0] - a[0], c[1] - a[1]};
    const float w[2] = {point[0] - a[0], point[1] - a[1]};
    const double uu = u[0] * u[0] + u[1] * u[1], vv = v[0] * v[0] + v[1] * v[1], uv = u[0] * v[0] + u[1] * v[1];
    const double uw = u[0] * w[0] + u[1] * w[1], vw = v[0] * w[0] + v[1] * w[1];
    const double determinant = uu * vv - uv * uv;
    if (determinant == 0) {
        return false;
    }
    const double inverse = 1.0 / determinant;
    const double s = (vv * uw - uv * vw) * inverse, t = (uu * vw - uv * uw) * inverse;
    return s > 0 && t > 0 && s + t < 1;
}

static bool is_same(const float a[2], const float b[2])
{
    return a[0] == b[0] && a[1] == b[1];
}

/* Whether the triangle of a corner and its neighbors lies inside the polygon. Corners that were cut off count too, so
   the answer changes with the neighbors alone. */
static bool test_ear(const polygon *shape, uint32_t corner_count, uint32_t ear)
{
    const float *before = shape->flat[shape->before[ear]], *at = shape->flat[ear],
                *after = shape->flat[shape->after[ear]];
    if (clockwise_area(before, at, after) > 0) {
        return false;
    }
    for (uint32_t i = 0; i < corner_count; ++i) {
        const float *other = shape->flat[i];
        if (is_inside(before, at, after, other) && !is_same(other, at) && !is_same(other, after) &&
            !is_same(other, before)) {
            return false;
        }
    }
    return true;
}

enum { EAR_UNKNOWN = 0, EAR_YES, EAR_NO };

static bool is_ear(const polygon *shape, uint32_t corner_count, uint32_t corner)
{
    if (shape->ears[corner] == EAR_UNKNOWN) {
        shape->ears[corner] = test_ear(shape, corner_count, corner) ? EAR_YES : EAR_NO;
    }
    return shape->ears[corner] == EAR_YES;
}

static uint32_t *take_ear(polygon *shape, uint32_t ear, uint32_t *out)
{
    const uint32_t before = shape->before[ear], after = shape->after[ear];
    out[0] = before;
    out[1] = ear;
    out[2] = after;
    shape->after[before] = after;
    shape->before[after] = before;
    shape->ears[before] = EAR_UNKNOWN;
    shape->ears[after] = EAR_UNKNOWN;
    return out + 3;
}

/* The first ear at or after a corner; without one, after two rounds, the corner itself. */
static uint32_t find_ear(polygon *shape, uint32_t corner_count, uint32_t from, bool *found)
{
    unsigned rounds = 0;
    for (uint32_t ear = from;; ear = shape->after[ear]) {
        rounds += shape->after[ear] < ear ? 1 : 0;
        *found = rounds < 2;
        if (!*found) {
            return from;
        }
        if (is_ear(shape, corner_count, ear)) {
            return ear;
        }
    }
}

/* The last three corners of the ring, in ascending order. */
static void take_rest(const polygon *shape, uint32_t any, uint32_t *out)
{
    uint32_t first = any;
    for (int i = 0; i < 3; ++i) {
        any = shape->after[any];
        first = any < first ? any : first;
    }
    out[0] = first;
    out[1] = shape->after[first];
    out[2] = shape->after[out[1]];
}

static void cut_ears(polygon *shape, uint32_t corner_count)
{
    for (uint32_t i = 0; i < corner_count; ++i) {
        shape->before[i] = (i + corner_count - 1) % corner_count;
        shape->after[i] = (i + 1) % corner_count;
        shape->ears[i] = EAR_UNKNOWN;
    }
    uint32_t *out = shape->triangles;
    uint32_t next = 0;
    bool found = true;
    for (uint32_t left_count = corner_count; left_count > 3; --left_count) {
        /* A polygon that crosses itself may have no ear. Its corners are then taken in their order. */
        const uint32_t ear = found ? find_ear(shape, corner_count, next, &found) : next;
        next = shape->after[ear];
        out = take_ear(shape, ear, out);
    }
    shape->crossed_count += found ? 0 : 1;
    take_rest(shape, next, out);
}

void svo_i_polygon_cut(polygon *shape, uint32_t corner_count)
{
    if (corner_count == 3) {
        memcpy(shape->triangles, (const uint32_t[]){0, 1, 2}, 3 * sizeof *shape->triangles);
    } else if (corner_count == 4) {
        cut_four(shape);
    } else {
        project(shape, corner_count);
        cut_ears(shape, corner_count);
    }
}

/* ---- faces ---- */

svo_status svo_i_faces_begin(face_list *faces, const mesh_reader *reader, uint64_t vertex_count)
{
    *faces = (face_list){.reader = reader};
    if (vertex_count >= GATHER_NO_VERTEX) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "%" PRIu64 " vertices; at most %" PRIu32 " are possible",
                          vertex_count, GATHER_NO_VERTEX - 1);
    }
    faces->vertices = malloc((size_t)(vertex_count + 1) * sizeof *faces->vertices);
    faces->known = malloc((size_t)(vertex_count + 1) * sizeof *faces->known);
    faces->gathered = malloc((size_t)(vertex_count + 1) * sizeof *faces->gathered);
    if (faces->vertices == NULL || faces->known == NULL || faces->gathered == NULL) {
        return svo_i_read_out_of_memory(reader);
    }
    const gather_vertex neutral = {.color = {255, 255, 255, 255}};
    for (size_t i = 0; i < vertex_count; ++i) {
        faces->vertices[i] = neutral;
        faces->known[i] = GATHER_NO_VERTEX;
        faces->gathered[i] = GATHER_NO_VERTEX;
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

static bool gather_vertex_of(face_list *faces, size_t number, uint32_t corner, bool with_uvs, uint32_t *index)
{
    gather *mesh = faces->reader->mesh;
    if (with_uvs) {
        gather_vertex vertex = faces->vertices[number];
        memcpy(vertex.uv, faces->corner_uvs[corner], sizeof vertex.uv);
        return svo_i_gather_vertex(mesh, &vertex, index);
    }
    const size_t vertex = faces->first != NULL ? faces->first[number] : number;
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

static bool gather_corner(face_list *faces, uint32_t corner, bool with_uvs, uint32_t *index)
{
    const int64_t number = faces->corners[corner];
    *index = GATHER_NO_VERTEX;
    if (number < 0 || (uint64_t)number >= faces->vertex_count) {
        return true;
    }
    if (!gather_vertex_of(faces, (size_t)number, corner, with_uvs, index)) {
        return false;
    }
    if (faces->gathered[number] == GATHER_NO_VERTEX) {
        faces->gathered[number] = *index;
    }
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

void svo_i_faces_end(face_list *faces)
{
    const mesh_reader *reader = faces->reader;
    uint64_t used_count = 0;
    for (size_t i = 0; i < faces->vertex_count; ++i) {
        used_count += faces->gathered[i] != GATHER_NO_VERTEX ? 1 : 0;
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
    reader->mesh->file_vertices = faces->gathered;
    reader->mesh->file_vertex_count = faces->vertex_count;
    faces->gathered = NULL;
}

void svo_i_faces_free(face_list *faces)
{
    free(faces->vertices);
    free(faces->known);
    free(faces->gathered);
    free(faces->first);
    free(faces->corners);
    free(faces->corner_uvs);
    svo_i_polygon_free(&faces->shape);
}
