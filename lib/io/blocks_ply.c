/* SPDX-License-Identifier: MIT */
/*
 * Binary PLY in blocks. Faces come one after the other; their vertices are read from where the file has them, through a
 * cache of pages, so that faces which are near each other in the file cost little.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/blocks_file.h"
#include "io/import_ply_vertex.h"
#include "io/import_polygon.h"

#define PAGE_VERTICES 256
#define CACHE_BYTES   ((size_t)8 << 20)
#define PAGES_MAX     4096
/* A face with its other properties is at most this long, and has at most so many corners; others are imported, where
   the time that polygons take has a limit. */
#define FACE_BYTES_MAX   ((size_t)64 << 10)
#define FACE_CORNERS_MAX 1024

#define NO_PAGE UINT64_MAX

struct blocks_ply {
    svo_message words; /* of the value readers, without the path */
    mesh_reader reader;
    ply_source source;
    ply_header header;
    const ply_element *vertices, *faces;
    ply_slot slots[PLY_PROPERTIES_MAX];
    gather_vertex blank;
    size_t vertex_bytes;
    uint64_t vertex_begin, face_begin; /* places in the file */
    size_t index_list; /* the property of faces */

    char *cache;
    size_t page_count;
    uint64_t pages[PAGES_MAX]; /* what each slot of the cache holds */

    uint64_t faces_read;
    int64_t corners[FACE_CORNERS_MAX]; /* of the face that is being given */
    polygon shape;
    uint32_t triangle_count, triangles_given;
};

/* ---- the header ---- */

/* Bytes of an element's instance; 0: it has lists. */
static size_t fixed_bytes(const ply_element *element)
{
    size_t bytes = 0;
    for (size_t i = 0; i < element->property_count; ++i) {
        if (element->properties[i].count_type != PLY_NO_TYPE) {
            return 0;
        }
        bytes += svo_i_ply_type_bytes(element->properties[i].type);
    }
    return bytes;
}

/* Why a file is imported whole, or NULL. */
static const char *why_whole(blocks_ply *ply)
{
    const ply_header *header = &ply->header;
    for (size_t i = 0; i < header->element_count; ++i) {
        const ply_element *element = &header->elements[i];
        const bool is_vertex = strcmp(element->name, "vertex") == 0;
        const bool is_face = strcmp(element->name, "face") == 0;
        if ((is_vertex && (ply->vertices != NULL || ply->faces != NULL)) ||
            (is_face && (ply->vertices == NULL || ply->faces != NULL)) ||
            (!is_vertex && !is_face && element->count > 0)) {
            return "a PLY file with more than vertices and faces";
        }
        ply->vertices = is_vertex ? element : ply->vertices;
        ply->faces = is_face ? element : ply->faces;
    }
    if (header->format == PLY_ASCII) {
        return "a PLY file in text";
    }
    if (ply->faces == NULL || fixed_bytes(ply->vertices) == 0) {
        return "a PLY file without faces, or with lists in its vertices";
    }
    ply->index_list = svo_i_ply_find_index_list(ply->faces);
    if (ply->index_list == ply->faces->property_count ||
        ply->faces->properties[ply->index_list].count_type == PLY_NO_TYPE) {
        return "a PLY file whose faces have no list of vertices";
    }
    return header->texture_file[0] != '\0' && svo_i_ply_declares_uvs(header) ? "a PLY file with a texture" : NULL;
}

static void show_window(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    ply->reader.bytes = blocks->window;
    ply->reader.byte_count = blocks->window_count;
    ply->source.earlier_bytes = blocks->window_begin;
    ply->source.later_bytes = blocks->file_bytes - blocks->window_begin - blocks->window_count;
    ply->source.cursor =
        (text_cursor){.at = blocks->window + blocks->window_at, .end = blocks->window + blocks->window_count};
}

static svo_status read_header(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    show_window(blocks);
    const svo_status status = svo_i_ply_read_header(&ply->reader, &ply->source.cursor, &ply->header);
    if (status == SVO_IMPORT_FAILED && ply->source.later_bytes > 0) {
        return svo_i_blocks_fail(blocks, SVO_UNSUPPORTED, "a PLY file with a long header");
    }
    if (status != SVO_OK) {
        return svo_i_blocks_fail(blocks, status, ply->words.text);
    }
    const char *why = why_whole(ply);
    ply->source.format = ply->header.format;
    ply->vertex_begin = (uint64_t)(ply->source.cursor.at - blocks->window);
    return why == NULL ? SVO_OK : svo_i_blocks_fail(blocks, SVO_UNSUPPORTED, why);
}

/* Compares the counts with the length of the file; then no product of them overflows. */
static svo_status check_counts(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    svo_status status = svo_i_ply_check_fit(&ply->source, ply->vertices);
    if (status == SVO_OK) {
        ply->vertex_bytes = fixed_bytes(ply->vertices);
        ply->face_begin = ply->vertex_begin + ply->vertices->count * ply->vertex_bytes;
        svo_i_blocks_seek(blocks, ply->face_begin);
        show_window(blocks);
        status = svo_i_ply_check_fit(&ply->source, ply->faces);
    }
    return status == SVO_OK ? SVO_OK : svo_i_blocks_fail(blocks, status, ply->words.text);
}

static svo_status alloc_cache(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    const size_t page_bytes = PAGE_VERTICES * ply->vertex_bytes;
    const size_t fitting = CACHE_BYTES / page_bytes;
    ply->page_count = fitting > PAGES_MAX ? PAGES_MAX : fitting;
    ply->cache = svo_i_alloc(NULL, ply->page_count * page_bytes);
    for (size_t i = 0; i < PAGES_MAX; ++i) {
        ply->pages[i] = NO_PAGE;
    }
    return ply->cache != NULL && svo_i_polygon_reserve(&ply->shape, FACE_CORNERS_MAX) ? SVO_OK
                                                                                      : svo_i_blocks_no_memory(blocks);
}

svo_status svo_i_blocks_open_ply(svo_i_blocks *blocks)
{
    blocks->ply = svo_i_alloc_zeroed(NULL, 1, sizeof *blocks->ply);
    if (blocks->ply == NULL) {
        return svo_i_blocks_no_memory(blocks);
    }
    blocks_ply *ply = blocks->ply;
    ply->reader.message = &ply->words;
    ply->source.reader = &ply->reader;
    ply->source.numbers.reader = &ply->reader;
    SVO_I_TRY(read_header(blocks));
    SVO_I_TRY(check_counts(blocks));
    svo_i_ply_note_slots(ply->vertices, false, ply->slots, &blocks->has_normals, &blocks->has_colors);
    ply->blank = svo_i_ply_blank_vertex(ply->vertices, ply->slots);
    return alloc_cache(blocks);
}

void svo_i_blocks_close_ply(svo_i_blocks *blocks)
{
    if (blocks->ply != NULL) {
        svo_i_ply_header_free(&blocks->ply->header);
        svo_i_polygon_free(&blocks->ply->shape);
        svo_i_free(blocks->ply->cache);
        svo_i_free(blocks->ply);
        blocks->ply = NULL;
    }
}

void svo_i_blocks_rewind_ply(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    svo_i_blocks_seek(blocks, ply->face_begin);
    ply->faces_read = 0;
    ply->triangle_count = 0;
    ply->triangles_given = 0;
}

/* ---- vertices ---- */

/* Brings the page of a vertex into the cache; *record is the vertex in it. */
static svo_status find_record(svo_i_blocks *blocks, uint64_t vertex, const char **record)
{
    blocks_ply *ply = blocks->ply;
    const size_t page_bytes = PAGE_VERTICES * ply->vertex_bytes;
    const uint64_t page = vertex / PAGE_VERTICES;
    const size_t slot = (size_t)(page % ply->page_count);
    char *at = ply->cache + slot * page_bytes;
    if (ply->pages[slot] != page) {
        const uint64_t left = ply->vertices->count - page * PAGE_VERTICES;
        const size_t count = left < PAGE_VERTICES ? (size_t)left : PAGE_VERTICES;
        ply->pages[slot] = NO_PAGE;
        SVO_I_TRY(svo_i_blocks_read_at(blocks, ply->vertex_begin + page * page_bytes, at, count * ply->vertex_bytes));
        ply->pages[slot] = page;
    }
    *record = at + (size_t)(vertex % PAGE_VERTICES) * ply->vertex_bytes;
    return SVO_OK;
}

/* The vertex of a corner; NaN where there is none. */
static svo_status find_vertex(svo_i_blocks *blocks, uint32_t corner, gather_vertex *vertex)
{
    blocks_ply *ply = blocks->ply;
    const int64_t number = ply->corners[corner];
    const char *record = NULL;
    *vertex = ply->blank;
    if (number < 0 || (uint64_t)number >= ply->vertices->count) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            vertex->position[axis] = NAN;
        }
        return SVO_OK;
    }
    SVO_I_TRY(find_record(blocks, (uint64_t)number, &record));
    ply_source source = ply->source;
    source.element = ply->vertices;
    source.cursor = (text_cursor){.at = record, .end = record + ply->vertex_bytes};
    return svo_i_ply_read_vertex(&source, ply->vertices, ply->slots, vertex);
}

/* ---- faces ---- */

static svo_status read_corners(svo_i_blocks *blocks, const ply_property *property, uint64_t *count)
{
    blocks_ply *ply = blocks->ply;
    SVO_I_TRY(svo_i_ply_list_length(&ply->source, property, count));
    if (*count > FACE_CORNERS_MAX) {
        return SVO_UNSUPPORTED;
    }
    for (uint64_t i = 0; i < *count; ++i) {
        SVO_I_TRY(svo_i_ply_integer(&ply->source, property->type, &ply->corners[i]));
    }
    return SVO_OK;
}

static svo_status read_properties(svo_i_blocks *blocks, uint64_t *corner_count)
{
    blocks_ply *ply = blocks->ply;
    for (size_t k = 0; k < ply->faces->property_count; ++k) {
        const ply_property *property = &ply->faces->properties[k];
        SVO_I_TRY(k == ply->index_list ? read_corners(blocks, property, corner_count)
                                       : svo_i_ply_skip(&ply->source, property));
    }
    return SVO_OK;
}

/* Reads the next face. One that does not end in the window is too long, unless the file ends there. */
static svo_status read_face(svo_i_blocks *blocks, uint64_t *corner_count)
{
    blocks_ply *ply = blocks->ply;
    SVO_I_TRY(svo_i_blocks_need(blocks, FACE_BYTES_MAX));
    show_window(blocks);
    ply->source.element = ply->faces;
    ply->source.instance = ply->faces_read;
    const svo_status status = read_properties(blocks, corner_count);
    if (status == SVO_UNSUPPORTED || (status == SVO_IMPORT_FAILED && ply->source.later_bytes > 0)) {
        return svo_i_fail(blocks->message, SVO_UNSUPPORTED, "%s: face %" PRIu64 " has more than %d corners or is long",
                          blocks->path, ply->faces_read, FACE_CORNERS_MAX);
    }
    if (status != SVO_OK) {
        return svo_i_blocks_fail(blocks, status, ply->words.text);
    }
    blocks->window_at = (size_t)(ply->source.cursor.at - blocks->window);
    ++ply->faces_read;
    return SVO_OK;
}

/* Cuts a face into triangles, as import_faces.c does: one with a corner that does not exist as a fan. */
static svo_status cut_face(svo_i_blocks *blocks, uint32_t corner_count)
{
    blocks_ply *ply = blocks->ply;
    polygon *shape = &ply->shape;
    bool whole = true;
    for (uint32_t i = 0; i < corner_count; ++i) {
        whole = whole && ply->corners[i] >= 0 && (uint64_t)ply->corners[i] < ply->vertices->count;
    }
    for (uint32_t i = 0; !whole && i + 2 < corner_count; ++i) {
        memcpy(shape->triangles + 3 * (size_t)i, (const uint32_t[]){0, i + 1, i + 2}, 3 * sizeof(uint32_t));
    }
    for (uint32_t i = 0; whole && corner_count > 3 && i < corner_count; ++i) {
        gather_vertex vertex;
        SVO_I_TRY(find_vertex(blocks, i, &vertex));
        memcpy(shape->corners[i], vertex.position, sizeof shape->corners[i]);
    }
    if (whole) {
        svo_i_polygon_cut(shape, corner_count);
    }
    ply->triangle_count = corner_count - 2;
    ply->triangles_given = 0;
    return SVO_OK;
}

static svo_status give_triangle(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    const uint32_t *corners = ply->shape.triangles + 3 * (size_t)ply->triangles_given++;
    for (unsigned corner = 0; corner < 3; ++corner) {
        gather_vertex vertex;
        SVO_I_TRY(find_vertex(blocks, corners[corner], &vertex));
        svo_i_blocks_put(blocks, corner, &vertex);
    }
    ++blocks->filled;
    return SVO_OK;
}

svo_status svo_i_blocks_fill_ply(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    while (blocks->filled < BLOCK_TRIANGLES) {
        uint64_t corner_count = 0;
        if (ply->triangles_given < ply->triangle_count) {
            SVO_I_TRY(give_triangle(blocks));
            continue;
        }
        if (ply->faces_read == ply->faces->count) {
            return SVO_OK;
        }
        SVO_I_TRY(read_face(blocks, &corner_count));
        if (corner_count >= 3) {
            SVO_I_TRY(cut_face(blocks, (uint32_t)corner_count));
        }
    }
    return SVO_OK;
}
