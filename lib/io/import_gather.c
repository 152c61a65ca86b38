/* SPDX-License-Identifier: MIT */
/* Growing arrays of an import child and the hash table that keeps their vertices distinct. */
#include "io/import_gather.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/message.h"
#include "io/import_stream.h"

#define FIRST_CAPACITY    ((size_t)1024)
#define MATCH_BLOCK_COUNT 32 /* vertices that are looked up together */
#define SEND_BLOCK_COUNT  2048 /* records per block that is written */
#define SEND_FIELD_BYTES  sizeof(svo_finish) /* the most of a field */

static_assert(sizeof(gather_vertex) == 36, "a vertex is compared as bytes and must have no padding");

/* Makes room for one more element: doubles the capacity when it is used up. */
static bool reserve(void **array, size_t count, size_t *capacity, size_t element_bytes)
{
    if (count < *capacity) {
        return true;
    }
    const size_t larger = *capacity == 0 ? FIRST_CAPACITY : 2 * *capacity;
    size_t bytes = 0;
    if (!svo_i_mul_size(larger, element_bytes, &bytes)) {
        return false;
    }
    void *grown = realloc(*array, bytes);
    if (grown == NULL) {
        return false;
    }
    *array = grown;
    *capacity = larger;
    return true;
}

/* Compared as bytes: -0 and 0 differ, a NaN equals itself. */
static bool is_same(const gather_vertex *a, const gather_vertex *b)
{
    return memcmp((const uint8_t *)a, (const uint8_t *)b, sizeof *a) == 0;
}

static uint32_t hash_of(const gather_vertex *vertex)
{
    return (uint32_t)XXH3_64bits(vertex, sizeof *vertex);
}

/* The vertex's slot, or the free one where it belongs: linear probing. */
static size_t find_slot(const gather *mesh, const gather_vertex *vertex, uint32_t hash)
{
    size_t slot = hash & (mesh->slot_count - 1);
    while (mesh->slots[slot].index != GATHER_NO_VERTEX &&
           (mesh->slots[slot].hash != hash || !is_same(&mesh->vertices[mesh->slots[slot].index], vertex))) {
        slot = (slot + 1) & (mesh->slot_count - 1);
    }
    return slot;
}

/* A larger table, which takes over the slots in use by their hashes. */
static bool grow_slots(gather *mesh, size_t slot_count)
{
    gather_slot *slots = malloc(slot_count * sizeof *slots);
    if (slots == NULL) {
        return false;
    }
    memset(slots, 0xff, slot_count * sizeof *slots);
    for (size_t i = 0; i < mesh->slot_count; ++i) {
        if (mesh->slots[i].index != GATHER_NO_VERTEX) {
            size_t slot = mesh->slots[i].hash & (slot_count - 1);
            while (slots[slot].index != GATHER_NO_VERTEX) {
                slot = (slot + 1) & (slot_count - 1);
            }
            slots[slot] = mesh->slots[i];
        }
    }
    free(mesh->slots);
    mesh->slots = slots;
    mesh->slot_count = slot_count;
    return true;
}

static bool resize(void **array, size_t capacity, size_t element_bytes)
{
    size_t bytes = 0;
    void *grown = svo_i_mul_size(capacity, element_bytes, &bytes) ? realloc(*array, bytes) : NULL;
    if (grown != NULL) {
        *array = grown;
    }
    return grown != NULL;
}

/* Looks the vertices of a block up, all of whose slots are on their way from memory. */
static void match_block(const gather_vertex *vertices, size_t begin, size_t end, const uint32_t *hashes,
                        gather_slot *slots, size_t mask, uint32_t *first)
{
    for (size_t i = begin; i < end; ++i) {
        const uint32_t hash = hashes[i - begin];
        size_t slot = hash & mask;
        while (slots[slot].index != GATHER_NO_VERTEX &&
               (slots[slot].hash != hash || !is_same(&vertices[slots[slot].index], &vertices[i]))) {
            slot = (slot + 1) & mask;
        }
        if (slots[slot].index == GATHER_NO_VERTEX) {
            slots[slot] = (gather_slot){.hash = hash, .index = (uint32_t)i};
        }
        first[i] = slots[slot].index;
    }
}

bool svo_i_gather_match(const gather_vertex *vertices, size_t count, uint32_t *first)
{
    uint32_t hashes[MATCH_BLOCK_COUNT];
    size_t slot_count = 2 * FIRST_CAPACITY;
    while (slot_count / 2 < count) {
        slot_count *= 2;
    }
    gather_slot *slots = malloc(slot_count * sizeof *slots);
    if (slots == NULL) {
        return false;
    }
    memset(slots, 0xff, slot_count * sizeof *slots);
    for (size_t begin = 0; begin < count; begin += MATCH_BLOCK_COUNT) {
        const size_t end = count - begin < MATCH_BLOCK_COUNT ? count : begin + MATCH_BLOCK_COUNT;
        for (size_t i = begin; i < end; ++i) {
            hashes[i - begin] = hash_of(&vertices[i]);
            __builtin_prefetch(&slots[hashes[i - begin] & (slot_count - 1)], 1);
        }
        match_block(vertices, begin, end, hashes, slots, slot_count - 1, first);
    }
    free(slots);
    return true;
}

bool svo_i_gather_reserve(gather *mesh, size_t vertex_count, size_t triangle_count, bool hashed)
{
    size_t slot_count = 2 * FIRST_CAPACITY;
    while (slot_count / 2 <= vertex_count && slot_count <= SIZE_MAX / 4) {
        slot_count *= 2;
    }
    void *vertices = mesh->vertices, *indices = mesh->indices, *materials = mesh->triangle_materials;
    bool done = !hashed || slot_count <= mesh->slot_count || grow_slots(mesh, slot_count);
    if (done && vertex_count > mesh->vertex_capacity) {
        done = resize(&vertices, vertex_count, sizeof *mesh->vertices);
        mesh->vertices = vertices;
        mesh->vertex_capacity = done ? vertex_count : mesh->vertex_capacity;
    }
    if (done && triangle_count > mesh->triangle_capacity) {
        done = resize(&indices, triangle_count, 3 * sizeof *mesh->indices);
        mesh->indices = indices;
        done = done && resize(&materials, triangle_count, sizeof *mesh->triangle_materials);
        mesh->triangle_materials = materials;
        mesh->triangle_capacity = done ? triangle_count : mesh->triangle_capacity;
    }
    return done;
}

bool svo_i_gather_append(gather *mesh, const gather_vertex *vertex, uint32_t *index)
{
    void *vertices = mesh->vertices;
    if (mesh->vertex_count >= GATHER_NO_VERTEX ||
        !reserve(&vertices, mesh->vertex_count, &mesh->vertex_capacity, sizeof *vertex)) {
        return false;
    }
    mesh->vertices = vertices;
    mesh->vertices[mesh->vertex_count] = *vertex;
    *index = (uint32_t)mesh->vertex_count++;
    return true;
}

bool svo_i_gather_vertex(gather *mesh, const gather_vertex *vertex, uint32_t *index)
{
    if (2 * (mesh->vertex_count + 1) > mesh->slot_count &&
        !grow_slots(mesh, mesh->slot_count == 0 ? 2 * FIRST_CAPACITY : 2 * mesh->slot_count)) {
        return false;
    }
    const uint32_t hash = hash_of(vertex);
    gather_slot *slot = &mesh->slots[find_slot(mesh, vertex, hash)];
    if (slot->index == GATHER_NO_VERTEX) {
        uint32_t added = 0;
        if (!svo_i_gather_append(mesh, vertex, &added)) {
            return false;
        }
        *slot = (gather_slot){.hash = hash, .index = added};
    }
    *index = slot->index;
    return true;
}

bool svo_i_gather_triangle(gather *mesh, const uint32_t corners[3], uint16_t material)
{
    if (mesh->triangle_count >= UINT32_MAX) {
        return false;
    }
    /* Both arrays grow in step: the capacity is written by the second. */
    size_t capacity = mesh->triangle_capacity;
    void *indices = mesh->indices;
    bool grown = reserve(&indices, mesh->triangle_count, &capacity, 3 * sizeof *mesh->indices);
    mesh->indices = indices;
    if (!grown) {
        return false;
    }
    void *materials = mesh->triangle_materials;
    grown = reserve(&materials, mesh->triangle_count, &mesh->triangle_capacity, sizeof *mesh->triangle_materials);
    mesh->triangle_materials = materials;
    if (!grown) {
        return false;
    }
    memcpy(mesh->indices + 3 * mesh->triangle_count, corners, 3 * sizeof *corners);
    mesh->triangle_materials[mesh->triangle_count++] = material;
    return true;
}

gather_material svo_i_gather_plain_material(void)
{
    return (gather_material){.base = {.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE},
                             .normal_map = {.texture_index = SVO_NO_TEXTURE, .scale = 1}};
}

bool svo_i_gather_is_textured(const gather_material *material)
{
    return material->base.texture_index != SVO_NO_TEXTURE || material->normal_map.texture_index != SVO_NO_TEXTURE;
}

bool svo_i_gather_material(gather *mesh, const gather_material *material)
{
    void *materials = mesh->materials;
    const bool grown = reserve(&materials, mesh->material_count, &mesh->material_capacity, sizeof *material);
    mesh->materials = materials;
    if (grown) {
        mesh->materials[mesh->material_count++] = *material;
    }
    return grown;
}

/* Whether a material is diffuse and does not emit. */
static bool is_diffuse(const gather_material *material)
{
    bool diffuse = true;
    for (int k = 0; k < 3; ++k) {
        diffuse = diffuse && material->finish.emission[k] == 0 && material->finish.specular[k] == 0;
    }
    return diffuse;
}

void svo_i_gather_drop_plain_materials(gather *mesh)
{
    const gather_material plain = svo_i_gather_plain_material();
    for (size_t i = 0; i < mesh->material_count; ++i) {
        const gather_material *material = &mesh->materials[i];
        if (memcmp(&material->base, &plain.base, sizeof plain.base) != 0 || svo_i_gather_is_textured(material) ||
            !is_diffuse(material)) {
            return;
        }
    }
    mesh->material_count = 0;
}

void svo_i_gather_free(gather *mesh)
{
    free(mesh->vertices);
    free(mesh->slots);
    free(mesh->indices);
    free(mesh->triangle_materials);
    free(mesh->materials);
    free(mesh->file_vertices);
    memset(mesh, 0, sizeof *mesh);
}

/* A field of records. */
typedef struct record_field {
    const void *records;
    size_t count, record_bytes;
    size_t offset, bytes; /* of the field, at most SEND_FIELD_BYTES */
} record_field;

/* It, of all records, as an array of its own. */
static int send_field(const record_field *field, int stream, stream_kind kind)
{
    uint8_t block[SEND_BLOCK_COUNT * SEND_FIELD_BYTES];
    const uint64_t payload_bytes = (uint64_t)field->count * field->bytes;
    if (svo_i_stream_begin(stream, kind, payload_bytes) != 0) {
        return -1;
    }
    for (size_t begin = 0; begin < field->count; begin += SEND_BLOCK_COUNT) {
        const size_t left_count = field->count - begin;
        const size_t count = left_count < SEND_BLOCK_COUNT ? left_count : SEND_BLOCK_COUNT;
        for (size_t i = 0; i < count; ++i) {
            const uint8_t *record = (const uint8_t *)field->records + (begin + i) * field->record_bytes;
            memcpy(block + i * field->bytes, record + field->offset, field->bytes);
        }
        if (svo_i_stream_write(stream, block, count * field->bytes) != 0) {
            return -1;
        }
    }
    return svo_i_stream_pad(stream, payload_bytes);
}

/* Materials, and of these what some have. */
static int send_materials(const gather *mesh, int stream)
{
    const gather_material *material = NULL;
    const record_field bases = {mesh->materials, mesh->material_count, sizeof *material,
                                offsetof(gather_material, base), sizeof material->base};
    const record_field finishes = {mesh->materials, mesh->material_count, sizeof *material,
                                   offsetof(gather_material, finish), sizeof material->finish};
    const record_field maps = {mesh->materials, mesh->material_count, sizeof *material,
                               offsetof(gather_material, normal_map), sizeof material->normal_map};
    bool all_diffuse = true;
    bool has_maps = false;
    for (size_t i = 0; i < mesh->material_count; ++i) {
        all_diffuse = all_diffuse && is_diffuse(&mesh->materials[i]);
        has_maps = has_maps || mesh->materials[i].normal_map.texture_index != SVO_NO_TEXTURE;
    }
    if (mesh->material_count > 0 &&
        (send_field(&bases, stream, STREAM_MATERIALS) != 0 ||
         svo_i_stream_frame(stream, STREAM_TRIANGLE_MATERIALS, mesh->triangle_materials,
                            mesh->triangle_count * sizeof *mesh->triangle_materials) != 0)) {
        return -1;
    }
    if (!all_diffuse && send_field(&finishes, stream, STREAM_FINISHES) != 0) {
        return -1;
    }
    return has_maps ? send_field(&maps, stream, STREAM_NORMAL_MAPS) : 0;
}

static int send_vertices(const gather *mesh, int stream, stream_kind kind, size_t offset, size_t bytes)
{
    const record_field field = {mesh->vertices, mesh->vertex_count, sizeof *mesh->vertices, offset, bytes};
    return send_field(&field, stream, kind);
}

int svo_i_gather_send(const gather *mesh, int stream)
{
    const gather_vertex *vertex = NULL;
    if (send_vertices(mesh, stream, STREAM_POSITIONS, offsetof(gather_vertex, position), sizeof vertex->position) !=
        0) {
        return -1;
    }
    if (mesh->has_normals &&
        send_vertices(mesh, stream, STREAM_NORMALS, offsetof(gather_vertex, normal), sizeof vertex->normal) != 0) {
        return -1;
    }
    if (mesh->has_colors &&
        send_vertices(mesh, stream, STREAM_COLORS, offsetof(gather_vertex, color), sizeof vertex->color) != 0) {
        return -1;
    }
    if (mesh->has_uvs && send_vertices(mesh, stream, STREAM_UVS, offsetof(gather_vertex, uv), sizeof vertex->uv) != 0) {
        return -1;
    }
    if (send_materials(mesh, stream) != 0) {
        return -1;
    }
    if (mesh->file_vertices != NULL && svo_i_stream_frame(stream, STREAM_FILE_VERTICES, mesh->file_vertices,
                                                          mesh->file_vertex_count * sizeof *mesh->file_vertices) != 0) {
        return -1;
    }
    return svo_i_stream_frame(stream, STREAM_INDICES, mesh->indices, 3 * mesh->triangle_count * sizeof *mesh->indices);
}
