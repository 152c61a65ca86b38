/* SPDX-License-Identifier: MIT */
/*
 * Mesh files read in blocks of triangles, for trees in parts: a window moves over the file, and a reader fills the
 * block. Of binary STL, whether any facet has a color of its own shows with the bounds. Of binary PLY, faces come one
 * after the other; their vertices are read from where the file has them, through a cache of pages, so that faces which
 * are near each other in the file cost little.
 */
#define _POSIX_C_SOURCE 200809L
#include "parts/blocks.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/file_format.h"
#include "io/import_faces.h"
#include "io/import_formats.h"
#include "io/import_gather.h"
#include "io/import_ply_file.h"

#define PAGE_VERTICES 256
#define CACHE_BYTES   ((size_t)8 << 20)
#define PAGES_MAX     4096
/* A face with its other properties is at most this long, and has at most so many corners; others are imported, where
   the time that polygons take has a limit. */
#define FACE_BYTES_MAX   ((size_t)64 << 10)
#define FACE_CORNERS_MAX 1024

#define NO_PAGE UINT64_MAX

#define WINDOW_BYTES ((size_t)256 << 10)

typedef struct blocks_ply blocks_ply;

/* Bytes of a vertex in the file that its place in memory gets as they are. */
typedef struct vertex_copy {
    size_t from, to, bytes;
} vertex_copy;

struct svo_i_blocks {
    const char *path; /* a copy */
    svo_message *message;
    int file;
    uint64_t file_bytes;
    char *window;
    uint64_t window_begin; /* its place in the file */
    size_t window_count, window_at; /* bytes in it, and those that have been read */

    float *positions, *normals; /* of the block */
    uint8_t *colors;
    size_t filled; /* triangles */
    bool has_normals, has_colors;

    blocks_ply *ply; /* NULL: STL */
    stl_begin stl;
    uint64_t items_read, items_end; /* faces or facets */
    bool is_uneven;
};

/* Fails with the path and words. */
static svo_status fail(const svo_i_blocks *blocks, svo_status status, const char *words)
{
    return svo_i_fail(blocks->message, status, "%s: %s", blocks->path, words);
}

static svo_status no_memory(const svo_i_blocks *blocks)
{
    return fail(blocks, SVO_OUT_OF_HOST_MEMORY, "no memory for a block of triangles");
}

/* ---- the window ---- */

/* Reads bytes of any place. */
static svo_status read_at(const svo_i_blocks *blocks, uint64_t offset, void *out, size_t byte_count)
{
    size_t got = 0;
    const int error = svo_i_read_at(blocks->file, offset, out, byte_count, &got);
    return got == byte_count ? SVO_OK
                             : svo_i_fail(blocks->message, SVO_FILE_ERROR, "%s: cannot be read: %s", blocks->path,
                                          error != 0 ? strerror(error) : "it has become shorter");
}

/* Moves the window on until it has so many bytes ahead, at most WINDOW_BYTES, or the rest of the file. */
static svo_status need(svo_i_blocks *blocks, size_t byte_count)
{
    const size_t ahead = blocks->window_count - blocks->window_at;
    const uint64_t behind = blocks->file_bytes - blocks->window_begin - blocks->window_count;
    if (ahead >= byte_count || behind == 0) {
        return SVO_OK;
    }
    memmove(blocks->window, blocks->window + blocks->window_at, ahead);
    const size_t room = WINDOW_BYTES - ahead;
    const size_t more = behind < room ? (size_t)behind : room;
    blocks->window_begin += blocks->window_at;
    blocks->window_at = 0;
    blocks->window_count = ahead;
    SVO_I_TRY(read_at(blocks, blocks->window_begin + ahead, blocks->window + ahead, more));
    blocks->window_count = ahead + more;
    return SVO_OK;
}

/* Sets where the window is. */
static void seek(svo_i_blocks *blocks, uint64_t offset)
{
    blocks->window_begin = offset;
    blocks->window_count = 0;
    blocks->window_at = 0;
}

/* ---- the block ---- */

/* Adds a corner to the block: the triangle filled, corner 0 .. 2. */
static void put(svo_i_blocks *blocks, unsigned corner, const gather_vertex *vertex)
{
    const size_t at = blocks->filled * 3 + corner;
    memcpy(blocks->positions + at * 3, vertex->position, sizeof vertex->position);
    memcpy(blocks->normals + at * 3, vertex->normal, sizeof vertex->normal);
    memcpy(blocks->colors + at * 4, vertex->color, sizeof vertex->color);
}

/* ---- STL ---- */

static svo_status open_stl(svo_i_blocks *blocks)
{
    if (blocks->window_count < STL_BEGIN_BYTES ||
        svo_i_stl_is_text(blocks->window, blocks->window_count, blocks->file_bytes)) {
        return fail(blocks, SVO_UNSUPPORTED, "an STL file in text");
    }
    blocks->stl = svo_i_stl_read_begin(blocks->window);
    const uint64_t needed_bytes = STL_BEGIN_BYTES + (uint64_t)blocks->stl.facet_count * STL_FACET_BYTES;
    if (needed_bytes > blocks->file_bytes) {
        return svo_i_fail(blocks->message, SVO_IMPORT_FAILED,
                          "%s: byte 80: %" PRIu32 " facets need %" PRIu64 " bytes, and the file has %" PRIu64,
                          blocks->path, blocks->stl.facet_count, needed_bytes, blocks->file_bytes);
    }
    blocks->has_normals = true;
    return SVO_OK;
}

static svo_status fill_stl(svo_i_blocks *blocks)
{
    for (; blocks->filled < BLOCK_TRIANGLES && blocks->items_read < blocks->items_end; ++blocks->items_read) {
        float facet[12];
        gather_vertex vertex = {.uv = {0.0f, 0.0f}};
        SVO_I_TRY(need(blocks, STL_FACET_BYTES));
        (void)svo_i_stl_read_facet(blocks->window + blocks->window_at, &blocks->stl, facet, vertex.color);
        blocks->window_at += STL_FACET_BYTES;
        memcpy(vertex.normal, facet, sizeof vertex.normal);
        for (unsigned corner = 0; corner < 3; ++corner) {
            memcpy(vertex.position, facet + 3 + (size_t)corner * 3, sizeof vertex.position);
            put(blocks, corner, &vertex);
        }
        ++blocks->filled;
    }
    return SVO_OK;
}

struct blocks_ply {
    svo_message words; /* of the value readers, without the path */
    mesh_reader reader;
    ply_source source;
    ply_header header;
    const ply_element *vertices, *faces;
    ply_slot slots[PLY_PROPERTIES_MAX];
    gather_vertex blank;
    vertex_copy copies[PLY_SLOT_END];
    size_t copy_count; /* 0: vertices are not like that */
    size_t vertex_bytes;
    uint64_t vertex_begin, face_begin; /* places in the file */
    size_t index_list; /* the property of faces */

    char *cache;
    size_t page_count;
    uint64_t pages[PAGES_MAX]; /* what each slot of the cache holds */

    size_t face_bytes; /* of each, where all have even_corners as the first has; 0: they have not */
    uint64_t even_corners;
    bool must_be_even; /* some of the faces are read */
    int64_t corners[FACE_CORNERS_MAX]; /* of the face that is being given */
    polygon shape;
    uint32_t triangle_count, triangles_given;
};

/* ---- PLY: the header ---- */

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
    if (ply->faces == NULL || svo_i_ply_fixed_bytes(ply->vertices) == 0) {
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
        return fail(blocks, SVO_UNSUPPORTED, "a PLY file with a long header");
    }
    if (status != SVO_OK) {
        return fail(blocks, status, ply->words.text);
    }
    const char *why = why_whole(ply);
    ply->source.format = ply->header.format;
    ply->vertex_begin = (uint64_t)(ply->source.cursor.at - blocks->window);
    return why == NULL ? SVO_OK : fail(blocks, SVO_UNSUPPORTED, why);
}

/* Compares the counts with the length of the file; then no product of them overflows. */
static svo_status check_counts(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    svo_status status = svo_i_ply_check_fit(&ply->source, ply->vertices);
    if (status == SVO_OK) {
        ply->vertex_bytes = svo_i_ply_fixed_bytes(ply->vertices);
        ply->face_begin = ply->vertex_begin + ply->vertices->count * ply->vertex_bytes;
        seek(blocks, ply->face_begin);
        show_window(blocks);
        status = svo_i_ply_check_fit(&ply->source, ply->faces);
    }
    return status == SVO_OK ? SVO_OK : fail(blocks, status, ply->words.text);
}

static bool host_is_little_endian(void)
{
    const uint16_t one = 1;
    uint8_t low = 0;
    memcpy(&low, &one, sizeof low);
    return low == 1;
}

/* Where a slot's value is in a vertex, and how it is kept there. */
static size_t place_of_slot(unsigned slot, ply_type *type)
{
    *type = slot >= PLY_SLOT_COLOR ? PLY_UINT8 : PLY_FLOAT;
    return slot >= PLY_SLOT_COLOR    ? offsetof(gather_vertex, color) + (slot - PLY_SLOT_COLOR)
           : slot >= PLY_SLOT_UV     ? offsetof(gather_vertex, uv) + (slot - PLY_SLOT_UV) * sizeof(float)
           : slot >= PLY_SLOT_NORMAL ? offsetof(gather_vertex, normal) + (slot - PLY_SLOT_NORMAL) * sizeof(float)
                                     : offsetof(gather_vertex, position) + (slot - PLY_SLOT_POSITION) * sizeof(float);
}

/* Lists what of a vertex is copied, if that is all of it, each slot once. */
static void list_copies(blocks_ply *ply)
{
    size_t from = 0;
    unsigned seen = 0;
    for (size_t k = 0; k < ply->vertices->property_count; ++k) {
        const ply_property *property = &ply->vertices->properties[k];
        const size_t bytes = svo_i_ply_type_bytes(property->type);
        ply_type type = PLY_NO_TYPE;
        const size_t to = place_of_slot(ply->slots[k], &type);
        vertex_copy *last = ply->copy_count > 0 ? &ply->copies[ply->copy_count - 1] : NULL;
        if (ply->slots[k] != PLY_SLOT_NONE && (property->type != type || (seen >> ply->slots[k] & 1u) != 0)) {
            ply->copy_count = 0;
            return;
        }
        seen |= ply->slots[k] != PLY_SLOT_NONE ? 1u << ply->slots[k] : 0;
        if (ply->slots[k] != PLY_SLOT_NONE && last != NULL && last->from + last->bytes == from &&
            last->to + last->bytes == to) {
            last->bytes += bytes;
        } else if (ply->slots[k] != PLY_SLOT_NONE) {
            ply->copies[ply->copy_count++] = (vertex_copy){from, to, bytes};
        }
        from += bytes;
    }
}

/* The length of faces, if all can have the number of corners of the first: they fill the file then. */
static void find_even(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    size_t bytes = 0;
    for (size_t k = 0; k < ply->faces->property_count; ++k) {
        const ply_property *property = &ply->faces->properties[k];
        if (k != ply->index_list && property->count_type != PLY_NO_TYPE) {
            return;
        }
        bytes += k != ply->index_list ? svo_i_ply_type_bytes(property->type) : 0;
    }
    const ply_property *list = &ply->faces->properties[ply->index_list];
    bytes += svo_i_ply_type_bytes(list->count_type) + ply->even_corners * svo_i_ply_type_bytes(list->type);
    const uint64_t filled = blocks->file_bytes - ply->face_begin;
    ply->face_bytes = filled / bytes == ply->faces->count && filled % bytes == 0 ? bytes : 0;
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
    return ply->cache != NULL && svo_i_polygon_reserve(&ply->shape, FACE_CORNERS_MAX) ? SVO_OK : no_memory(blocks);
}

static svo_status look_at_first(svo_i_blocks *blocks);

static svo_status open_ply(svo_i_blocks *blocks)
{
    blocks->ply = svo_i_alloc_zeroed(NULL, 1, sizeof *blocks->ply);
    if (blocks->ply == NULL) {
        return no_memory(blocks);
    }
    blocks_ply *ply = blocks->ply;
    ply->reader.message = &ply->words;
    ply->source.reader = &ply->reader;
    ply->source.numbers.reader = &ply->reader;
    SVO_I_TRY(read_header(blocks));
    SVO_I_TRY(check_counts(blocks));
    svo_i_ply_note_slots(ply->vertices, false, ply->slots, &blocks->has_normals, &blocks->has_colors);
    ply->blank = svo_i_ply_blank_vertex(ply->vertices, ply->slots);
    if (ply->header.format == PLY_LITTLE_ENDIAN && host_is_little_endian()) {
        list_copies(ply);
    }
    SVO_I_TRY(alloc_cache(blocks));
    return look_at_first(blocks);
}

static void close_ply(svo_i_blocks *blocks)
{
    if (blocks->ply != NULL) {
        svo_i_ply_header_free(&blocks->ply->header);
        svo_i_polygon_free(&blocks->ply->shape);
        svo_i_free(blocks->ply->cache);
        svo_i_free(blocks->ply);
        blocks->ply = NULL;
    }
}

static void select_ply(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    if (ply->face_bytes == 0) {
        blocks->items_read = 0;
        blocks->items_end = ply->faces->count;
    }
    ply->must_be_even = blocks->items_read > 0 || blocks->items_end < ply->faces->count;
    seek(blocks, ply->face_begin + blocks->items_read * ply->face_bytes);
    ply->triangle_count = 0;
    ply->triangles_given = 0;
}

/* ---- PLY: vertices ---- */

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
        SVO_I_TRY(read_at(blocks, ply->vertex_begin + page * page_bytes, at, count * ply->vertex_bytes));
        ply->pages[slot] = page;
    }
    *record = at + (size_t)(vertex % PAGE_VERTICES) * ply->vertex_bytes;
    return SVO_OK;
}

/* Reads a vertex. Its parts that lie in the file as they do in memory are copied. */
static svo_status parse_vertex(const blocks_ply *ply, const char *record, gather_vertex *vertex)
{
    *vertex = ply->blank;
    for (size_t i = 0; i < ply->copy_count; ++i) {
        const vertex_copy *copy = &ply->copies[i];
        memcpy((char *)vertex + copy->to, record + copy->from, copy->bytes);
    }
    if (ply->copy_count > 0) {
        return SVO_OK;
    }
    ply_source source = ply->source;
    source.element = ply->vertices;
    source.cursor = (text_cursor){.at = record, .end = record + ply->vertex_bytes};
    return svo_i_ply_read_vertex(&source, ply->vertices, ply->slots, vertex);
}

/* The vertex of a corner; NaN where there is none. */
static svo_status find_vertex(svo_i_blocks *blocks, uint32_t corner, gather_vertex *vertex)
{
    blocks_ply *ply = blocks->ply;
    const int64_t number = ply->corners[corner];
    const char *record = NULL;
    if (number < 0 || (uint64_t)number >= ply->vertices->count) {
        *vertex = ply->blank;
        for (unsigned axis = 0; axis < 3; ++axis) {
            vertex->position[axis] = NAN;
        }
        return SVO_OK;
    }
    SVO_I_TRY(find_record(blocks, (uint64_t)number, &record));
    return parse_vertex(ply, record, vertex);
}

/* ---- PLY: faces ---- */

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
    SVO_I_TRY(need(blocks, FACE_BYTES_MAX));
    show_window(blocks);
    ply->source.element = ply->faces;
    ply->source.instance = blocks->items_read;
    const svo_status status = read_properties(blocks, corner_count);
    /* Reading may have begun within a face. */
    if (ply->must_be_even && (status != SVO_OK || *corner_count != ply->even_corners)) {
        blocks->is_uneven = true;
        return fail(blocks, SVO_UNSUPPORTED, "its faces have different numbers of corners");
    }
    if (status == SVO_UNSUPPORTED || (status == SVO_IMPORT_FAILED && ply->source.later_bytes > 0)) {
        return svo_i_fail(blocks->message, SVO_UNSUPPORTED, "%s: face %" PRIu64 " has more than %d corners or is long",
                          blocks->path, blocks->items_read, FACE_CORNERS_MAX);
    }
    if (status != SVO_OK) {
        return fail(blocks, status, ply->words.text);
    }
    blocks->window_at = (size_t)(ply->source.cursor.at - blocks->window);
    ++blocks->items_read;
    return SVO_OK;
}

/* Finds the number of corners of the first face. What is wrong with it is told when it is read. */
static svo_status look_at_first(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    seek(blocks, ply->face_begin);
    SVO_I_TRY(need(blocks, FACE_BYTES_MAX));
    show_window(blocks);
    ply->source.element = ply->faces;
    if (ply->faces->count > 0 && read_properties(blocks, &ply->even_corners) == SVO_OK) {
        find_even(blocks);
    }
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
        put(blocks, corner, &vertex);
    }
    ++blocks->filled;
    return SVO_OK;
}

static svo_status fill_ply(svo_i_blocks *blocks)
{
    blocks_ply *ply = blocks->ply;
    while (blocks->filled < BLOCK_TRIANGLES) {
        uint64_t corner_count = 0;
        if (ply->triangles_given < ply->triangle_count) {
            SVO_I_TRY(give_triangle(blocks));
            continue;
        }
        if (blocks->items_read == blocks->items_end) {
            return SVO_OK;
        }
        SVO_I_TRY(read_face(blocks, &corner_count));
        if (corner_count >= 3) {
            SVO_I_TRY(cut_face(blocks, (uint32_t)corner_count));
        }
    }
    return SVO_OK;
}

/* ---- blocks ---- */

svo_status svo_i_blocks_next(svo_i_blocks *blocks, svo_mesh *block)
{
    blocks->filled = 0;
    SVO_I_TRY(blocks->ply != NULL ? fill_ply(blocks) : fill_stl(blocks));
    *block = (svo_mesh){.struct_size = sizeof *block,
                        .positions = blocks->positions,
                        .normals = blocks->has_normals ? blocks->normals : NULL,
                        .colors = blocks->has_colors ? blocks->colors : NULL,
                        .vertex_count = 3 * blocks->filled,
                        .triangle_count = blocks->filled};
    return SVO_OK;
}

svo_i_blocks_extent svo_i_blocks_get_extent(const svo_i_blocks *blocks)
{
    const blocks_ply *ply = blocks->ply;
    return (svo_i_blocks_extent){.file_bytes = blocks->file_bytes,
                                 .items = ply != NULL ? ply->faces->count : blocks->stl.facet_count,
                                 .vertices = ply != NULL ? ply->vertices->count : blocks->stl.facet_count,
                                 .is_even = ply == NULL || ply->face_bytes > 0,
                                 .has_normals = blocks->has_normals,
                                 .has_colors = blocks->has_colors};
}

void svo_i_blocks_select(svo_i_blocks *blocks, uint64_t begin, uint64_t end, bool any_color)
{
    blocks->items_read = begin;
    blocks->items_end = end;
    if (blocks->ply != NULL) {
        select_ply(blocks);
        return;
    }
    blocks->has_colors = blocks->stl.is_magics || any_color;
    seek(blocks, STL_BEGIN_BYTES + begin * STL_FACET_BYTES);
}

bool svo_i_blocks_is_uneven(const svo_i_blocks *blocks)
{
    return blocks->is_uneven;
}

/* ---- bounds ---- */

static void widen(svo_i_bounds *bounds, const float *corners, unsigned count)
{
    for (unsigned i = 0; i < count; ++i) {
        if (!isfinite(corners[i])) {
            return;
        }
    }
    bounds->any = true;
    for (unsigned i = 0; i < count; ++i) {
        const double x = (double)corners[i];
        bounds->low[i % 3] = x < bounds->low[i % 3] ? x : bounds->low[i % 3];
        bounds->high[i % 3] = x > bounds->high[i % 3] ? x : bounds->high[i % 3];
    }
}

svo_status svo_i_blocks_bounds(svo_i_blocks *blocks, uint64_t begin, uint64_t end, svo_i_bounds *bounds,
                               bool *any_color)
{
    const blocks_ply *ply = blocks->ply;
    const size_t bytes = ply != NULL ? ply->vertex_bytes : STL_FACET_BYTES;
    seek(blocks, (ply != NULL ? ply->vertex_begin : STL_BEGIN_BYTES) + begin * bytes);
    for (uint64_t i = begin; i < end; ++i) {
        float facet[12];
        gather_vertex vertex = {.uv = {0.0f, 0.0f}};
        SVO_I_TRY(need(blocks, bytes));
        const char *from = blocks->window + blocks->window_at;
        if (ply != NULL) {
            SVO_I_TRY(parse_vertex(ply, from, &vertex));
            widen(bounds, vertex.position, 3);
        } else {
            *any_color = svo_i_stl_read_facet(from, &blocks->stl, facet, vertex.color) || *any_color;
            widen(bounds, facet + 3, 9);
        }
        blocks->window_at += bytes;
    }
    return SVO_OK;
}

/* ---- opening ---- */

static svo_status open_file(svo_i_blocks *blocks)
{
    struct stat found;
    blocks->file = open(blocks->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (blocks->file < 0 || fstat(blocks->file, &found) != 0) {
        return svo_i_fail(blocks->message, SVO_FILE_ERROR, "%s: cannot be read: %s", blocks->path, strerror(errno));
    }
    if (!S_ISREG(found.st_mode)) {
        return fail(blocks, SVO_FILE_ERROR, "cannot be read: not a regular file");
    }
    blocks->file_bytes = (uint64_t)found.st_size;
    return SVO_OK;
}

static bool alloc_block(svo_i_blocks *blocks)
{
    const size_t corners = (size_t)BLOCK_TRIANGLES * 3;
    blocks->window = svo_i_alloc(NULL, WINDOW_BYTES);
    blocks->positions = svo_i_alloc(NULL, corners * 3 * sizeof *blocks->positions);
    blocks->normals = svo_i_alloc(NULL, corners * 3 * sizeof *blocks->normals);
    blocks->colors = svo_i_alloc(NULL, corners * 4);
    return blocks->window != NULL && blocks->positions != NULL && blocks->normals != NULL && blocks->colors != NULL;
}

static svo_status open_format(svo_i_blocks *blocks)
{
    SVO_I_TRY(open_file(blocks));
    if (!alloc_block(blocks)) {
        return no_memory(blocks);
    }
    SVO_I_TRY(need(blocks, WINDOW_BYTES));
    switch (svo_i_mesh_format(blocks->path, blocks->window, blocks->window_count)) {
    case MESH_FORMAT_PLY:
        return open_ply(blocks);
    case MESH_FORMAT_STL:
        return open_stl(blocks);
    default:
        return fail(blocks, SVO_UNSUPPORTED, "neither binary PLY nor binary STL");
    }
}

svo_status svo_i_blocks_open(const char *path, svo_i_blocks **out, svo_message *message)
{
    svo_i_blocks *blocks = svo_i_alloc_zeroed(NULL, 1, sizeof *blocks);
    char *copy = svo_i_copy_text(NULL, path);
    if (blocks == NULL || copy == NULL) {
        svo_i_free(blocks);
        svo_i_free(copy);
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory to read it", path);
    }
    blocks->path = copy;
    blocks->message = message;
    blocks->file = -1;
    const svo_status status = open_format(blocks);
    if (status != SVO_OK) {
        svo_i_blocks_close(&blocks);
        return status;
    }
    svo_i_blocks_select(blocks, 0, svo_i_blocks_get_extent(blocks).items, false);
    *out = blocks;
    return SVO_OK;
}

void svo_i_blocks_close(svo_i_blocks **blocks)
{
    svo_i_blocks *b = *blocks;
    if (b == NULL) {
        return;
    }
    if (b->file >= 0) {
        (void)close(b->file);
    }
    close_ply(b);
    svo_i_free(b->window);
    svo_i_free(b->positions);
    svo_i_free(b->normals);
    svo_i_free(b->colors);
    svo_i_free((void *)b->path);
    svo_i_free(b);
    *blocks = NULL;
}
