/* SPDX-License-Identifier: MIT */
/* Voxels for programs that show meshes: points at their centers (.ply), and cubes with the faces that show (.obj). */
#include <inttypes.h>
#include <string.h>

#include "io/voxels_formats.h"
#include "io/voxels_text.h"

#define POSITION_DIGITS 9 /* give every float back */

/* Whether a voxel has another material than 0, which voxels without materials have. */
static bool has_materials(const voxel_writer *writer)
{
    bool has = writer->list.property_count > 0;
    for (uint64_t i = 0; i < writer->list.voxel_count && !has; ++i) {
        has = writer->voxels[i].material != 0;
    }
    return has;
}

svo_status svo_i_voxels_write_ply(voxel_writer *writer)
{
    const bool with_materials = has_materials(writer);
    SVO_I_TRY(svo_i_voxels_print(writer,
                                 "ply\nformat binary_little_endian 1.0\nelement vertex %" PRIu64
                                 "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
                                 "property uchar green\nproperty uchar blue\nproperty uchar alpha\n"
                                 "%send_header\n",
                                 writer->list.voxel_count, with_materials ? "property ushort material\n" : ""));
    for (uint64_t i = 0; i < writer->list.voxel_count; ++i) {
        const svo_voxel *voxel = &writer->voxels[i];
        const float center[3] = {(float)svo_i_voxels_world(writer, 0, (double)voxel->x + 0.5),
                                 (float)svo_i_voxels_world(writer, 1, (double)voxel->y + 0.5),
                                 (float)svo_i_voxels_world(writer, 2, (double)voxel->z + 0.5)};
        SVO_I_TRY(svo_i_voxels_put(writer, center, sizeof center));
        SVO_I_TRY(svo_i_voxels_put(writer, voxel->rgba, sizeof voxel->rgba));
        SVO_I_TRY(svo_i_voxels_put(writer, &voxel->material, with_materials ? sizeof voxel->material : 0));
    }
    return SVO_OK;
}

/* Corner c of a cube is at (c & 1, c >> 1 & 1, c >> 2). The corners of each face, counterclockwise from outside; face
   2 a + s is that of axis a on its low (0) or high (1) side. */
static const uint8_t face_corners[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

/* Whether there is a voxel, by its Morton code. */
static bool is_filled(const voxel_writer *writer, const int32_t place[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        if (place[axis] < writer->list.low[axis] || place[axis] >= writer->list.high[axis]) {
            return false;
        }
    }
    const svo_voxel key = {.x = place[0], .y = place[1], .z = place[2]};
    const uint64_t code = svo_i_voxel_code(&key, writer->list.low);
    uint64_t begin = 0;
    uint64_t end = writer->list.voxel_count;
    while (begin < end) {
        const uint64_t middle = begin + (end - begin) / 2;
        const uint64_t found = svo_i_voxel_code(&writer->voxels[middle], writer->list.low);
        if (found == code) {
            return true;
        }
        if (found < code) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    return false;
}

/* A bit for each face behind which there is no voxel. */
static unsigned outer_faces(const voxel_writer *writer, const svo_voxel *voxel)
{
    unsigned faces = 0;
    for (unsigned face = 0; face < 6; ++face) {
        int32_t place[3] = {voxel->x, voxel->y, voxel->z};
        place[face / 2] += face % 2 != 0 ? 1 : -1;
        faces |= is_filled(writer, place) ? 0u : 1u << face;
    }
    return faces;
}

static svo_status put_corner(voxel_writer *writer, const svo_voxel *voxel, unsigned corner)
{
    char text[6][VOXEL_NUMBER_BYTES];
    const int32_t place[3] = {voxel->x, voxel->y, voxel->z};
    for (int axis = 0; axis < 3; ++axis) {
        const double at = (double)place[axis] + (double)(corner >> axis & 1u);
        (void)svo_i_voxel_number(text[axis], svo_i_voxels_world(writer, axis, at), POSITION_DIGITS);
        (void)svo_i_voxel_number(text[3 + axis], voxel->rgba[axis] / 255.0, POSITION_DIGITS);
    }
    return svo_i_voxels_print(writer, "v %s %s %s %s %s %s\n", text[0], text[1], text[2], text[3], text[4], text[5]);
}

/* Writes the outer faces of a cube and their corners. *corners: how many the file has. */
static svo_status put_cube(voxel_writer *writer, const svo_voxel *voxel, uint64_t *corners)
{
    uint64_t index[8] = {0};
    const unsigned faces = outer_faces(writer, voxel);
    for (unsigned corner = 0; corner < 8; ++corner) {
        bool used = false;
        for (unsigned face = 0; face < 6; ++face) {
            used = used || ((faces >> face & 1u) != 0 && memchr(face_corners[face], (int)corner, 4) != NULL);
        }
        if (used) {
            index[corner] = ++*corners;
            SVO_I_TRY(put_corner(writer, voxel, corner));
        }
    }
    for (unsigned face = 0; face < 6; ++face) {
        const uint8_t *c = face_corners[face];
        if ((faces >> face & 1u) != 0) {
            ++writer->info.faces;
            SVO_I_TRY(svo_i_voxels_print(writer, "f %" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", index[c[0]],
                                         index[c[1]], index[c[2]], index[c[3]]));
        }
    }
    return SVO_OK;
}

svo_status svo_i_voxels_write_obj(voxel_writer *writer)
{
    uint64_t corners = 0;
    SVO_I_TRY(svo_i_voxels_print(writer, "# %" PRIu64 " voxels; v x y z red green blue\n", writer->list.voxel_count));
    for (uint64_t i = 0; i < writer->list.voxel_count; ++i) {
        SVO_I_TRY(put_cube(writer, &writer->voxels[i], &corners));
    }
    return SVO_OK;
}
