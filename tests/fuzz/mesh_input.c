/* SPDX-License-Identifier: MIT */
/* Decodes bytes to a mesh for fuzz_mesh; mesh_input.h describes the format. */
#include "mesh_input.h"

#include <string.h>

#include "fuzz.h"

#define TEXTURE_EDGE_MAX 8u /* from 0 texels, which is an error, up to this */

typedef struct reader {
    const uint8_t *data;
    size_t byte_count;
    mesh_input *input;
} reader;

static void read_bytes(reader *from, void *out, size_t byte_count)
{
    const size_t there = byte_count < from->byte_count ? byte_count : from->byte_count;
    memset(out, 0, byte_count);
    if (there > 0) {
        memcpy(out, from->data, there);
        from->data += there;
        from->byte_count -= there;
    }
}

static uint8_t read_byte(reader *from)
{
    uint8_t byte;
    read_bytes(from, &byte, sizeof byte);
    return byte;
}

static void *new_array(reader *from, size_t byte_count)
{
    REQUIRE(from->input->array_count < MESH_INPUT_ARRAYS_MAX);
    /* No byte of an empty array may be read. NOLINTNEXTLINE(clang-analyzer-optin.portability.UnixAPI) */
    void *array = malloc(byte_count);
    REQUIRE(array != NULL || byte_count == 0);
    from->input->arrays[from->input->array_count++] = array;
    return array;
}

static void *read_array(reader *from, size_t byte_count)
{
    void *array = new_array(from, byte_count);
    read_bytes(from, array, byte_count);
    return array;
}

static double read_small(reader *from)
{
    int16_t small;
    read_bytes(from, &small, sizeof small);
    return small / 256.0;
}

static void read_positions(reader *from, position_form form)
{
    svo_mesh *mesh = &from->input->mesh;
    const size_t count = mesh->vertex_count * 3;
    if (form == POSITION_FLOAT || form == POSITION_BOTH) {
        mesh->positions = read_array(from, count * sizeof(float));
    }
    if (form == POSITION_DOUBLE || form == POSITION_BOTH) {
        mesh->positions_double = read_array(from, count * sizeof(double));
    }
    if (form == POSITION_SMALL_FLOAT) {
        float *positions = new_array(from, count * sizeof *positions);
        for (size_t i = 0; i < count; ++i) {
            positions[i] = (float)read_small(from);
        }
        mesh->positions = positions;
    }
    if (form == POSITION_SMALL_DOUBLE) {
        double *positions = new_array(from, count * sizeof *positions);
        for (size_t i = 0; i < count; ++i) {
            positions[i] = read_small(from);
        }
        mesh->positions_double = positions;
    }
}

/* One byte per index; three of its values stand for indices out of range. */
static void read_indices(reader *from)
{
    svo_mesh *mesh = &from->input->mesh;
    uint32_t *indices = new_array(from, mesh->triangle_count * 3 * sizeof *indices);
    for (size_t i = 0; i < mesh->triangle_count * 3; ++i) {
        const uint8_t byte = read_byte(from);
        indices[i] = byte == 255   ? UINT32_MAX
                     : byte == 254 ? (uint32_t)mesh->vertex_count
                     : byte == 253 ? UINT32_C(0x80000000)
                                   : byte;
    }
    mesh->indices = indices;
}

static void read_materials(reader *from)
{
    svo_mesh *mesh = &from->input->mesh;
    svo_material *materials = new_array(from, mesh->material_count * sizeof *materials);
    for (size_t i = 0; i < mesh->material_count; ++i) {
        read_bytes(from, materials[i].rgba, sizeof materials[i].rgba);
        const uint8_t texture_index = read_byte(from);
        materials[i].texture_index = texture_index == 255 ? SVO_NO_TEXTURE : texture_index;
    }
    mesh->materials = materials;
}

static void read_textures(reader *from)
{
    svo_mesh *mesh = &from->input->mesh;
    svo_texture *textures = new_array(from, mesh->texture_count * sizeof *textures);
    for (size_t i = 0; i < mesh->texture_count; ++i) {
        const uint32_t width = read_byte(from) % (TEXTURE_EDGE_MAX + 1);
        const uint32_t height = read_byte(from) % (TEXTURE_EDGE_MAX + 1);
        const svo_wrap wrap_u = (svo_wrap)(read_byte(from) % 3);
        const svo_wrap wrap_v = (svo_wrap)(read_byte(from) % 3);
        textures[i] = (svo_texture){read_array(from, (size_t)width * height * 4), width, height, wrap_u, wrap_v};
    }
    mesh->textures = textures;
}

static void read_optional_arrays(reader *from, uint8_t arrays)
{
    svo_mesh *mesh = &from->input->mesh;
    if ((arrays & ARRAY_INDICES) != 0) {
        read_indices(from);
    }
    if ((arrays & ARRAY_NORMALS) != 0) {
        mesh->normals = read_array(from, mesh->vertex_count * 3 * sizeof(float));
    }
    if ((arrays & ARRAY_COLORS) != 0) {
        mesh->colors = read_array(from, mesh->vertex_count * 4);
    }
    if ((arrays & ARRAY_UVS) != 0) {
        mesh->uvs = read_array(from, mesh->vertex_count * 2 * sizeof(float));
    }
    if ((arrays & ARRAY_TRIANGLE_MATERIALS) != 0) {
        mesh->triangle_materials = read_array(from, mesh->triangle_count * sizeof(uint16_t));
    }
    if ((arrays & ARRAY_MATERIALS) != 0) {
        read_materials(from);
    }
    if ((arrays & ARRAY_TEXTURES) != 0) {
        read_textures(from);
    }
}

static void read_options(mesh_input *input, const mesh_input_head *head)
{
    svo_plan_options *options = &input->options;
    input->options_given = (head->options & OPTIONS_GIVEN) != 0;
    options->struct_size = sizeof *options;
    options->coverage = (svo_coverage)(head->coverage % (SVO_COVERAGE_THIN + 2));
    options->need = (head->options & OPTIONS_NEED_ANY) != 0 ? head->need : head->need % 64;
    options->weights = (svo_weights)(head->weights % (SVO_WEIGHTS_CENTER + 2));
    if ((head->options & OPTIONS_GRID) != 0) {
        memcpy(options->origin, head->origin, sizeof options->origin);
        options->edge = head->edge;
    }
    if ((head->options & OPTIONS_CAPACITY) != 0) {
        options->fragment_capacity = head->fragment_capacity;
    }
}

void mesh_input_read(mesh_input *input, const uint8_t *data, size_t byte_count)
{
    memset(input, 0, sizeof *input);
    for (size_t i = 0; i < byte_count; ++i) {
        input->seed = (input->seed ^ data[i]) * UINT64_C(0x100000001B3); /* FNV-1a */
    }
    reader from = {.data = data, .byte_count = byte_count, .input = input};
    mesh_input_head head;
    read_bytes(&from, &head, sizeof head);
    input->depth = head.depth % (SVO_DEPTH_MAX + 2);
    input->chunk_bytes = ((uint64_t)head.chunk_kibibytes % 65536 + 16) * 1024;
    read_options(input, &head);
    svo_mesh *mesh = &input->mesh;
    mesh->struct_size = sizeof *mesh;
    mesh->vertex_count = head.vertex_count;
    mesh->triangle_count = head.triangle_count;
    mesh->material_count = head.material_count;
    mesh->texture_count = head.texture_count;
    read_positions(&from, (position_form)(head.position_form % POSITION_FORMS));
    read_optional_arrays(&from, head.arrays);
}

void mesh_input_free(mesh_input *input)
{
    for (size_t i = 0; i < input->array_count; ++i) {
        free(input->arrays[i]);
    }
    input->array_count = 0;
}

double mesh_input_coordinate(const mesh_input *input, size_t vertex, unsigned axis)
{
    const svo_mesh *mesh = &input->mesh;
    const size_t index = vertex * 3 + axis;
    return mesh->positions_double != NULL ? mesh->positions_double[index] : (double)mesh->positions[index];
}
