/* SPDX-License-Identifier: MIT */
/* Lists of triangles that grow. After memory ran out a list stays as it is, and says so. */
#include "view/ui.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void ui_drawing_clear(ui_drawing *drawing)
{
    drawing->vertex_count = 0;
    drawing->index_count = 0;
    drawing->batch_count = 0;
}

void ui_drawing_free(ui_drawing *drawing)
{
    free(drawing->vertices);
    free(drawing->indices);
    free(drawing->batches);
    *drawing = (ui_drawing){.vertices = NULL};
}

/* Makes room for more elements behind count; false when memory runs out. */
static bool reserve(ui_drawing *drawing, void **elements, size_t *capacity, size_t count, size_t element_bytes)
{
    if (drawing->failed || count <= *capacity) {
        return !drawing->failed;
    }
    const size_t enough = count + count / 2 + 64;
    void *larger = realloc(*elements, enough * element_bytes);
    if (larger == NULL) {
        drawing->failed = true;
        return false;
    }
    *elements = larger;
    *capacity = enough;
    return true;
}

void ui_drawing_batch(ui_drawing *drawing, uint32_t texture, const int clip[4])
{
    if (drawing->batch_count > 0) {
        ui_batch *last = &drawing->batches[drawing->batch_count - 1];
        if (last->texture == texture && memcmp(last->clip, clip, sizeof last->clip) == 0) {
            return;
        }
        if (last->index_count == 0) {
            --drawing->batch_count;
        }
    }
    void *batches = drawing->batches;
    const bool enough =
        reserve(drawing, &batches, &drawing->batch_capacity, drawing->batch_count + 1, sizeof *drawing->batches);
    drawing->batches = batches;
    if (enough) {
        ui_batch *added = &drawing->batches[drawing->batch_count++];
        *added = (ui_batch){.index_begin = (uint32_t)drawing->index_count, .texture = texture};
        memcpy(added->clip, clip, sizeof added->clip);
    }
}

uint32_t ui_drawing_vertices(ui_drawing *drawing, const ui_vertex *vertices, size_t count)
{
    const size_t first = drawing->vertex_count;
    void *room = drawing->vertices;
    const bool enough = reserve(drawing, &room, &drawing->vertex_capacity, first + count, sizeof *vertices);
    drawing->vertices = room;
    if (enough && count > 0) {
        memcpy(drawing->vertices + first, vertices, count * sizeof *vertices);
        drawing->vertex_count += count;
    }
    return (uint32_t)first;
}

void ui_drawing_triangles(ui_drawing *drawing, uint32_t first, const uint16_t *indices, size_t count)
{
    void *room = drawing->indices;
    const bool enough =
        reserve(drawing, &room, &drawing->index_capacity, drawing->index_count + count, sizeof *drawing->indices);
    drawing->indices = room;
    if (!enough || drawing->batch_count == 0) {
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        drawing->indices[drawing->index_count++] = first + indices[i];
    }
    drawing->batches[drawing->batch_count - 1].index_count += (uint32_t)count;
}

void ui_drawing_rectangle(ui_drawing *drawing, const float place[4], const float texture[4], uint32_t color)
{
    static const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    const ui_vertex corners[4] = {{place[0], place[1], texture[0], texture[1], color},
                                  {place[2], place[1], texture[2], texture[1], color},
                                  {place[2], place[3], texture[2], texture[3], color},
                                  {place[0], place[3], texture[0], texture[3], color}};
    ui_drawing_triangles(drawing, ui_drawing_vertices(drawing, corners, 4), indices, 6);
}

/* ---- texts ---- */

static bool is_rest_of_character(char byte)
{
    return ((unsigned char)byte & 0xC0U) == 0x80;
}

bool ui_fit(const ui *toolkit, const char *text, float width, char *out, size_t out_bytes)
{
    static const char dots[] = "...";
    size_t length = strlen(text);
    if (length < out_bytes && ui_text_width(toolkit, text) <= width) {
        memcpy(out, text, length + 1);
        return true;
    }
    const size_t most = out_bytes - sizeof dots;
    length = length < most ? length : most;
    bool is_word = true;
    do {
        size_t end = length;
        while (end > 0 && text[end - 1] != ' ') {
            --end;
        }
        is_word = is_word && end > 1;
        /* A word that is too wide alone is cut between characters. */
        length = is_word ? end - 1 : length > 0 ? length - 1 : 0;
        while (length > 0 && is_rest_of_character(text[length])) {
            --length;
        }
        (void)snprintf(out, out_bytes, "%.*s%s", (int)length, text, dots);
    } while (length > 0 && ui_text_width(toolkit, out) > width);
    return false;
}
