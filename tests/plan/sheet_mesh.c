/* SPDX-License-Identifier: MIT */
/* Generates the sheet. */
#include "sheet_mesh.h"

#include <math.h>
#include <string.h>

#define HEIGHT 0.3 /* of the plane */
#define SQUARE 0.0078125 /* edge: 1 / 128 */

/* Vertex i at x, y in the sheet's plane. */
static void put(sheet_mesh *sheet, size_t i, double x, double y)
{
    sheet->positions[i * 3] = x;
    sheet->positions[i * 3 + 1] = y;
    sheet->positions[i * 3 + 2] = HEIGHT;
}

/* Two triangles around the center of a square. */
static void put_square(sheet_mesh *sheet, size_t square, double covered)
{
    static const double corners[6][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, -1}, {1, 1}, {-1, 1}};
    const size_t column = square % SHEET_SQUARES;
    const size_t row = square / SHEET_SQUARES;
    const double x = ((double)column + 0.5) * SQUARE;
    const double y = ((double)row + 0.5) * SQUARE;
    for (size_t k = 0; k < 6; ++k) {
        const double reach = 0.5 * SQUARE * covered;
        put(sheet, square * 6 + k, x + corners[k][0] * reach, y + corners[k][1] * reach);
    }
}

static void put_extra(sheet_mesh *sheet, sheet_extra extra)
{
    /* Corners, in units of squares. */
    static const double corners[][3][2] = {[SHEET_SPECK] = {{4.5, 5.5}, {4.5, 5.5}, {4.5, 5.5}},
                                           [SHEET_LARGE] = {{1, 1}, {14, 1}, {1, 14}},
                                           [SHEET_OUTSIDE] = {{1.5, 5.5}, {-2.5, 5.5}, {1.5, 6.5}},
                                           [SHEET_BRIDGE] = {{4.5, 5.5}, {5.5, 5.5}, {5.25, 5.625}},
                                           [SHEET_REFUSED] = {{4.5, 5.5}, {5.5, 5.5}, {(double)NAN, 5.625}}};
    for (size_t k = 0; k < 3 && extra != SHEET_ALONE; ++k) {
        put(sheet, (size_t)SHEET_TRIANGLES * 3 + k, corners[extra][k][0] * SQUARE, corners[extra][k][1] * SQUARE);
    }
    sheet->mesh.triangle_count = SHEET_TRIANGLES + (extra != SHEET_ALONE ? 1 : 0);
    sheet->mesh.vertex_count = sheet->mesh.triangle_count * 3;
}

/* Sets the attributes of vertex i. The further triangle is white. */
static void put_vertex(sheet_mesh *sheet, size_t i)
{
    static const size_t speck_square = 5 * SHEET_SQUARES + 4;
    /* The square around the speck is uniform: its means are integers, which a speck cannot change after rounding. */
    const size_t k = i / 6 == speck_square ? speck_square * 6 : i;
    const double turn = (double)k * 0.1;
    sheet->normals[i * 3] = (float)cos(turn);
    sheet->normals[i * 3 + 1] = (float)sin(turn);
    sheet->normals[i * 3 + 2] = 2.0F;
    sheet->uvs[i * 2] = (float)sheet->positions[k * 3];
    sheet->uvs[i * 2 + 1] = (float)sheet->positions[k * 3 + 1];
    for (size_t channel = 0; channel < 4; ++channel) {
        sheet->colors[i * 4 + channel] =
            (uint8_t)(i < (size_t)SHEET_TRIANGLES * 3 ? (k * 4 + channel) * 37 % 251 : 255);
    }
}

static void put_attributes(sheet_mesh *sheet)
{
    for (size_t i = 0; i < sheet->mesh.vertex_count; ++i) {
        put_vertex(sheet, i);
    }
    for (size_t t = 0; t < sheet->mesh.triangle_count; ++t) {
        sheet->triangle_materials[t] = (uint16_t)(t / 2 % 2);
    }
}

/* Allocates the mesh's arrays. */
static void connect(sheet_mesh *sheet)
{
    sheet->materials[0] = (svo_material){{255, 255, 255, 255}, SVO_NO_TEXTURE};
    sheet->materials[1] = (svo_material){{200, 100, 50, 255}, SVO_NO_TEXTURE};
    sheet->textures[0] = (svo_texture){.rgba = sheet->texels, .width = 16, .height = 16};
    sheet->textures[1] =
        (svo_texture){.rgba = sheet->texels + (size_t)SHEET_SMALL_TEXELS * 4, .width = 64, .height = 64};
    sheet->mesh = (svo_mesh){.struct_size = sizeof sheet->mesh,
                             .positions_double = sheet->positions,
                             .normals = sheet->normals,
                             .colors = sheet->colors,
                             .uvs = sheet->uvs,
                             .triangle_materials = sheet->triangle_materials,
                             .materials = sheet->materials,
                             .material_count = 2,
                             .textures = sheet->textures,
                             .texture_count = 2};
}

void sheet_make(sheet_extra extra, double covered, sheet_mesh *out)
{
    memset(out, 0, sizeof *out);
    connect(out);
    for (size_t i = 0; i < sizeof out->texels; ++i) {
        out->texels[i] = (uint8_t)(i < (size_t)SHEET_SMALL_TEXELS * 4 ? i * 7 % 256 : 255);
    }
    for (size_t square = 0; square < (size_t)SHEET_SQUARES * SHEET_SQUARES; ++square) {
        put_square(out, square, covered);
    }
    put_extra(out, extra);
    put_attributes(out);
}

void sheet_set_color(sheet_mesh *sheet, const uint8_t rgba[4], bool differs)
{
    for (size_t i = 0; i < sheet->mesh.vertex_count * 4; ++i) {
        const bool other = differs && i >= (size_t)SHEET_TRIANGLES * 12;
        sheet->colors[i] = other ? 255 : rgba[i % 4];
    }
}

void sheet_set_normal(sheet_mesh *sheet, const float normal[3], bool differs)
{
    for (size_t i = 0; i < sheet->mesh.vertex_count * 3; ++i) {
        const bool other = differs && i >= (size_t)SHEET_TRIANGLES * 9;
        sheet->normals[i] = other ? -normal[i % 3] : normal[i % 3];
    }
}

void sheet_set_material(sheet_mesh *sheet, uint16_t material, bool differs)
{
    for (size_t t = 0; t < sheet->mesh.triangle_count; ++t) {
        const bool other = differs && t >= SHEET_TRIANGLES;
        sheet->triangle_materials[t] = (uint16_t)(other ? 1 - material : material);
    }
}
