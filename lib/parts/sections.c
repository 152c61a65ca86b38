/* SPDX-License-Identifier: MIT */
/*
 * The writing pass: triangles go down the tree of parts by the test that counted them, and wait in a buffer of their
 * part until it is full. Files are opened for each buffer, so that their number has no limit.
 */
#define _POSIX_C_SOURCE 200809L
#include "parts/sections.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/file_format.h"
#include "output/output.h"
#include "parts/lease.h"
#include "parts/part_file.h"
#include "svocl/nodes.h"

/* All buffers take about so much, unless that is too little for this many records each. */
#define BUFFERS_BYTES      ((size_t)8 << 20)
#define BUFFER_BYTES_MAX   ((size_t)256 << 10)
#define BUFFER_RECORDS_MIN 32
#define NAME_BYTES         48

/* A node's children: 0 none; a node's index; a part's place in the list | IS_PART. */
#define IS_PART UINT32_C(0x80000000)

typedef struct part_node {
    uint32_t children[8];
} part_node;

typedef struct buffer {
    unsigned char *bytes; /* NULL until the first record */
    size_t filled;
    svo_i_triangle_hash hash; /* of all records so far */
    uint64_t written; /* records */
} buffer;

struct svo_i_sections {
    const svo_part_header *header;
    uint32_t cells_level, fields;
    const char *place;
    const svo_i_section *list;
    size_t count;
    svo_message *message;
    size_t record_bytes, buffer_bytes;
    part_node *nodes; /* the first is the root */
    size_t node_count, node_capacity;
    uint32_t root; /* as a node's children */
    buffer *buffers; /* count */
    svo_i_placing placing;
    const unsigned char *record; /* of the triangle that is added */
    uint64_t hash_of_record;
    uint32_t name;
};

static svo_status no_memory(const svo_i_sections *s)
{
    return svo_i_fail(s->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for triangles of %zu parts", s->place,
                      s->count);
}

/* ---- the tree of parts ---- */

static bool new_node(svo_i_sections *s, uint32_t *index)
{
    if (s->node_count == s->node_capacity) {
        const size_t capacity = s->node_capacity * 2 + 64;
        part_node *grown = svo_i_grow(NULL, s->nodes, capacity * sizeof *grown);
        if (grown == NULL) {
            return false;
        }
        s->nodes = grown;
        s->node_capacity = capacity;
    }
    s->nodes[s->node_count] = (part_node){.children = {0}};
    *index = (uint32_t)s->node_count++;
    return true;
}

static bool add_part(svo_i_sections *s, uint32_t part)
{
    const svo_i_section *section = &s->list[part];
    uint32_t node = 0;
    if (section->level == 0) {
        s->root = part | IS_PART;
        return true;
    }
    for (uint32_t below = section->level; below-- > 0;) {
        const unsigned octant = (unsigned)(section->code >> 3 * below) & 7u;
        if (below == 0) {
            s->nodes[node].children[octant] = part | IS_PART;
        } else if (s->nodes[node].children[octant] == 0) {
            uint32_t made = 0;
            if (!new_node(s, &made)) {
                return false;
            }
            s->nodes[node].children[octant] = made;
            node = made;
        } else {
            node = s->nodes[node].children[octant] & ~IS_PART;
        }
    }
    return true;
}

static bool make_tree(svo_i_sections *s)
{
    bool made = new_node(s, &s->root);
    for (uint32_t part = 0; part < s->count && made; ++part) {
        made = add_part(s, part);
    }
    return made;
}

svo_status svo_i_sections_begin(const svo_part_header *header, uint32_t cells_level, uint32_t fields, const char *place,
                                const svo_i_section *list, size_t count, svo_message *message, svo_i_sections **out)
{
    svo_i_sections *s = svo_i_alloc_zeroed(NULL, 1, sizeof *s);
    if (s == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for triangles", place);
    }
    s->header = header;
    s->cells_level = cells_level;
    s->fields = fields;
    s->place = place;
    s->list = list;
    s->count = count;
    s->message = message;
    s->record_bytes = svo_i_triangle_bytes(fields);
    const size_t share = BUFFERS_BYTES / (count + 1);
    const size_t records = (share < BUFFER_BYTES_MAX ? share : BUFFER_BYTES_MAX) / s->record_bytes;
    s->buffer_bytes = (records > BUFFER_RECORDS_MIN ? records : BUFFER_RECORDS_MIN) * s->record_bytes;
    s->buffers = svo_i_alloc_zeroed(NULL, count + 1, sizeof *s->buffers);
    if (s->buffers == NULL || !make_tree(s)) {
        svo_i_sections_free(&s);
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for triangles of %zu parts", place, count);
    }
    *out = s;
    return SVO_OK;
}

/* ---- writing ---- */

static int write_buffer(const svo_i_sections *s, uint32_t part, const char *path)
{
    const buffer *from = &s->buffers[part];
    const uint64_t offset = (s->list[part].first + from->written) * s->record_bytes;
    const svo_i_output output = {.descriptor = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666)};
    if (output.descriptor < 0) {
        return errno;
    }
    const int error = svo_i_output_write_at(&output, offset, from->bytes, from->filled);
    return close(output.descriptor) != 0 && error == 0 ? errno : error;
}

static svo_status flush(svo_i_sections *s, uint32_t part)
{
    char name[NAME_BYTES];
    (void)snprintf(name, sizeof name, "%" PRIu32 "-%" PRIx64 ".tri", s->list[part].level, s->list[part].code);
    char *path = svo_i_path_join(s->place, name);
    if (path == NULL) {
        return no_memory(s);
    }
    const int error = write_buffer(s, part, path);
    const svo_status status = error == 0 ? SVO_OK
                                         : svo_i_fail(s->message, svo_i_file_status(error), "%s: cannot be written: %s",
                                                      path, strerror(error));
    svo_i_free(path);
    s->buffers[part].written += s->buffers[part].filled / s->record_bytes;
    s->buffers[part].filled = 0;
    return status;
}

static svo_status changed(const svo_i_sections *s, uint32_t part)
{
    return svo_i_fail(s->message, SVO_FILE_ERROR,
                      "%s: the part %" PRIu32 "-%" PRIx64
                      " has other triangles than were counted: the mesh has changed "
                      "meanwhile",
                      s->place, s->list[part].level, s->list[part].code);
}

static svo_status append(svo_i_sections *s, uint32_t part)
{
    buffer *to = &s->buffers[part];
    if (to->hash.count == s->list[part].count) {
        return changed(s, part);
    }
    if (to->bytes == NULL) {
        to->bytes = svo_i_alloc(NULL, s->buffer_bytes);
        if (to->bytes == NULL) {
            return no_memory(s);
        }
    }
    memcpy(to->bytes + to->filled, s->record, s->record_bytes);
    to->filled += s->record_bytes;
    svo_i_triangle_hash_add(&to->hash, s->hash_of_record, s->name);
    return to->filled == s->buffer_bytes ? flush(s, part) : SVO_OK;
}

static svo_status go_down(svo_i_sections *s, uint32_t node, uint32_t level, const uint32_t cell[3])
{
    if ((node & IS_PART) != 0) {
        return append(s, node & ~IS_PART);
    }
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint32_t child = s->nodes[node].children[octant];
        const uint32_t below[3] = {2 * cell[0] + (octant & 1u), 2 * cell[1] + (octant >> 1 & 1u),
                                   2 * cell[2] + (octant >> 2 & 1u)};
        if (child != 0 && svo_i_placing_meets(&s->placing, s->header->snap_bits, level + 1, below)) {
            SVO_I_TRY(go_down(s, child, level + 1, below));
        }
    }
    return SVO_OK;
}

/* The cell that has the whole triangle is reached without a test. */
svo_status svo_i_sections_add(svo_i_sections *s, const int32_t corners[3][3], const unsigned char *record,
                              uint64_t hash_of_record, uint32_t name)
{
    uint32_t node = s->root;
    uint32_t level = 0;
    uint32_t cell[3] = {0};
    svo_i_placing_make(s->header, s->cells_level, corners, &s->placing);
    for (; (node & IS_PART) == 0 && level < s->placing.inside_level; ++level) {
        unsigned octant = 0;
        for (unsigned axis = 0; axis < 3; ++axis) {
            cell[axis] = s->placing.first[axis] >> (s->cells_level - level - 1);
            octant |= (cell[axis] & 1u) << axis;
        }
        node = s->nodes[node].children[octant];
        if (node == 0) {
            return SVO_OK; /* of a mesh that has changed; the counts tell */
        }
    }
    s->record = record;
    s->hash_of_record = hash_of_record;
    s->name = name;
    return go_down(s, node, level, cell);
}

svo_status svo_i_sections_finish(svo_i_sections *s, svo_i_triangle_hash *hashes)
{
    for (uint32_t part = 0; part < s->count; ++part) {
        if (s->buffers[part].hash.count != s->list[part].count) {
            return changed(s, part);
        }
        if (s->buffers[part].filled > 0) {
            SVO_I_TRY(flush(s, part));
        }
        hashes[part] = s->buffers[part].hash;
    }
    return SVO_OK;
}

void svo_i_sections_free(svo_i_sections **sections)
{
    svo_i_sections *s = *sections;
    if (s == NULL) {
        return;
    }
    for (size_t part = 0; s->buffers != NULL && part < s->count; ++part) {
        svo_i_free(s->buffers[part].bytes);
    }
    svo_i_free(s->buffers);
    svo_i_free(s->nodes);
    svo_i_free(s);
    *sections = NULL;
}
