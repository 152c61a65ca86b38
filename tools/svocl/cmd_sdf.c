/* SPDX-License-Identifier: MIT */
/* svocl sdf: the signed distance field of a mesh, or of a tree with leaf lists, as a .npy file or as its bytes. */
#include <stdio.h>
#include <string.h>

#include "support/json.h"
#include "support/output.h"
#include "support/table.h"
#include "svocl/commands.h"
#include "svocl/distance_field.h"
#include "svocl/voxel_files.h"

/* Voxels of room around a mesh besides its band; of a dense field all that there are. */
#define BAND_ROOM  1.0
#define DENSE_ROOM 4.0

/* The header of a .npy file: a multiple of this long. */
#define NPY_ALIGNMENT 64
#define NPY_BYTES     256

/* Voxels of a band that are written at a time. */
#define RECORDS 4096

/* Bytes of a voxel of a band: its place, three u16, and its distance. */
#define RECORD_BYTES 10

/* ---- writing ---- */

/* The header of numpy's format, version 1: the type of an element, and how many there are along each axis. */
static void write_npy_header(output_file *file, const svo_sdf_info *info)
{
    char text[NPY_BYTES];
    char padded[NPY_BYTES + NPY_ALIGNMENT];
    const unsigned long long voxels = info->band > 0 ? info->voxel_count : UINT64_C(1) << info->depth;
    const int used =
        info->band > 0
            ? snprintf(text, sizeof text,
                       "{'descr': [('voxel', '<u2', (3,)), ('distance', '<f4')], 'fortran_order': False, "
                       "'shape': (%llu,), }",
                       voxels)
            : snprintf(text, sizeof text, "{'descr': '<f4', 'fortran_order': True, 'shape': (%llu, %llu, %llu), }",
                       voxels, voxels, voxels);
    const size_t total = ((size_t)used + 10 + 1 + NPY_ALIGNMENT - 1) / NPY_ALIGNMENT * NPY_ALIGNMENT;
    const unsigned char begin[10] = {
        0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0, (unsigned char)((total - 10) & 255), (unsigned char)((total - 10) >> 8)};
    memset(padded, ' ', sizeof padded);
    memcpy(padded, begin, sizeof begin);
    memcpy(padded + sizeof begin, text, (size_t)used);
    padded[total - 1] = '\n';
    output_write(file, padded, total);
}

/* Four bytes, the lowest first. */
static void put_float(unsigned char *to, float number)
{
    uint32_t bits = 0;
    memcpy(&bits, &number, sizeof bits);
    for (int i = 0; i < 4; ++i) {
        to[i] = (unsigned char)(bits >> 8 * i);
    }
}

static void write_band(output_file *file, const distance_field *made)
{
    static unsigned char bytes[RECORDS * RECORD_BYTES];
    size_t used = 0;
    for (size_t i = 0; i < made->info.voxel_count; ++i) {
        uint32_t cell[3];
        svo_code_to_cell(made->arrays.codes[i], cell);
        for (int axis = 0; axis < 3; ++axis) {
            bytes[used++] = (unsigned char)(cell[axis] & 255);
            bytes[used++] = (unsigned char)(cell[axis] >> 8);
        }
        put_float(bytes + used, made->arrays.distances[i]);
        used += 4;
        if (used == sizeof bytes || i + 1 == made->info.voxel_count) {
            output_write(file, bytes, used);
            used = 0;
        }
    }
}

static void write_dense(output_file *file, const distance_field *made)
{
    unsigned char bytes[4 * 1024];
    size_t used = 0;
    for (size_t i = 0; i < made->info.voxel_count; ++i) {
        put_float(bytes + used, made->arrays.distances[i]);
        used += 4;
        if (used == sizeof bytes || i + 1 == made->info.voxel_count) {
            output_write(file, bytes, used);
            used = 0;
        }
    }
}

static int write_field(program *state, const distance_field *made)
{
    output_file file;
    svo_message message = {""};
    const char *path = state->options.output_path;
    progress_step(state->progress, "writing the field");
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    const svo_voxel_format format = svo_voxel_format_of_path(path);
    if (format != SVO_VOXEL_FORMAT_AUTO) {
        const svo_status status = svo_sdf_save_as(made->sdf, output_sink(&file), format, &message);
        if (status != SVO_OK && file.error == 0) { /* else output_commit reports it */
            output_abandon(&file);
            return program_fail_library(state, message.text);
        }
        return output_commit(state, &file);
    }
    if (output_has_suffix(path, ".npy")) {
        write_npy_header(&file, &made->info);
    }
    if (made->info.band > 0) {
        write_band(&file, made);
    } else {
        write_dense(&file, made);
    }
    return output_commit(state, &file);
}

/* ---- the report ---- */

static int report_json(program *state, const distance_field *made)
{
    const svo_sdf_info *info = &made->info;
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "file", state->options.output_path);
    json_add_count(document, "depth", info->depth);
    cJSON_AddNumberToObject(document, "band", (double)info->band);
    json_add_text(document, "sign", distance_field_sign(state));
    json_add_count(document, "voxels", info->voxel_count);
    cJSON_AddNumberToObject(document, "spacing", info->spacing);
    json_add_vector(document, "first", info->first);
    json_add_vector(document, "origin", info->origin);
    cJSON_AddNumberToObject(document, "edge", info->edge);
    cJSON *open = cJSON_AddArrayToObject(document, "open_columns");
    for (int axis = 0; axis < 3; ++axis) {
        cJSON_AddItemToArray(open, cJSON_CreateNumber((double)info->open_columns[axis]));
    }
    json_add_count(document, "bytes", info->bytes);
    cJSON_AddNumberToObject(document, "sdf_ms", made->make_ms);
    return json_print(state, document);
}

static int report(program *state, const distance_field *made)
{
    const svo_sdf_info *info = &made->info;
    const uint64_t open = info->open_columns[0] + info->open_columns[1] + info->open_columns[2];
    if (state->options.json) {
        return report_json(state, made);
    }
    if (state->options.quiet) {
        return PROGRAM_DONE;
    }
    progress_hide(state->progress);
    if (info->band > 0) {
        table_line("%s: %s voxels within %g voxels of the surface, of %u^3, in %s",
                   output_name(state->options.output_path), figure_count(info->voxel_count).text, (double)info->band,
                   1U << info->depth, figure_ms(made->make_ms).text);
    } else {
        table_line("%s: %u^3 voxels, in %s", output_name(state->options.output_path), 1U << info->depth,
                   figure_ms(made->make_ms).text);
    }
    table_line("spacing %.17g; the center of voxel 0, 0, 0 is at %.17g, %.17g, %.17g", info->spacing, info->first[0],
               info->first[1], info->first[2]);
    if (open > 0) {
        table_line("the surface is not closed: %s columns of voxels", figure_count(open).text);
    }
    return PROGRAM_DONE;
}

/* ---- the command ---- */

static int check_options(program *state)
{
    if (state->options.output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    const int exit_code = distance_field_check(state, "distances");
    return exit_code == PROGRAM_DONE ? output_check(state, state->options.output_path) : exit_code;
}

int command_sdf(program *state)
{
    const options *given = &state->options;
    distance_field made;
    int exit_code = check_options(state);
    if (exit_code == PROGRAM_DONE) {
        const double room = given->margin >= 0 ? given->margin : given->band > 0 ? given->band + BAND_ROOM : DENSE_ROOM;
        exit_code = distance_field_open(state, SVO_NEED_RAYS, room, 0, 2, &made);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = distance_field_make(state, (float)given->band, &made);
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_field(state, &made);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, &made);
    }
    distance_field_release(&made);
    return exit_code;
}
