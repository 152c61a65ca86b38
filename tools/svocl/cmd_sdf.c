/* SPDX-License-Identifier: MIT */
/* svocl sdf: the signed distance field of a mesh, or of a tree with leaf lists, as a .npy file or as its bytes. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "support/job.h"
#include "support/json.h"
#include "support/options_parse.h"
#include "support/output.h"
#include "support/table.h"
#include "svocl/commands.h"

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

typedef struct field {
    job made;
    svo_sdf *sdf;
    svo_sdf_info info;
    svo_sdf_arrays arrays;
    double make_ms;
    uint64_t file_bytes;
} field;

static const char *sign_name(const program *state)
{
    return state->options.sign == OPTION_SIGN_NONE ? "none"
                                                   : svo_name(SVO_NAME_SOLID_RULE, (svo_solid_rule)state->options.sign);
}

/* ---- the grid ---- */

/* The bounds of the corners of triangles that the library takes. Returns false without any. */
static bool find_bounds(const svo_mesh *mesh, double low[3], double high[3])
{
    bool found = false;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const uint64_t vertex = mesh->indices[i];
        double at[3] = {NAN, NAN, NAN};
        for (size_t axis = 0; axis < 3 && vertex < mesh->vertex_count; ++axis) {
            at[axis] = mesh->positions_double != NULL ? mesh->positions_double[3 * vertex + axis]
                                                      : (double)mesh->positions[3 * vertex + axis];
        }
        if (!isfinite(at[0]) || !isfinite(at[1]) || !isfinite(at[2])) {
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = found ? fmin(low[axis], at[axis]) : at[axis];
            high[axis] = found ? fmax(high[axis], at[axis]) : at[axis];
        }
        found = true;
    }
    return found;
}

/* Rounds up to 24 bits, so that planes between voxels are doubles that neighbors agree on. */
static double round_up(double edge)
{
    int exponent = 0;
    const double share = frexp(edge, &exponent);
    return ldexp(ceil(ldexp(share, 24)), exponent - 24);
}

/* Sets --origin and --edge, unless they are given: a cube around the mesh with room for the band on all sides. */
static int make_room(program *state, const svo_mesh *mesh)
{
    options *given = &state->options;
    const double voxels = ldexp(1.0, (int)given->depth);
    const double wanted = given->margin >= 0 ? given->margin : given->band > 0 ? given->band + BAND_ROOM : DENSE_ROOM;
    double low[3];
    double high[3];
    if (given->edge > 0 || mesh == NULL || !find_bounds(mesh, low, high)) {
        return PROGRAM_DONE;
    }
    if (2 * wanted >= voxels) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "a margin of %g voxels on each side leaves nothing of %g; give a larger --depth or a "
                            "smaller --margin",
                            wanted, voxels);
    }
    const double widest = fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    if (widest > 0) {
        const double edge = round_up(widest * (1 + 0x1p-20) * voxels / (voxels - 2 * wanted));
        for (int axis = 0; axis < 3; ++axis) {
            /* A multiple of a small part of a voxel, so that centers are exact. */
            const double step = edge / voxels * 0x1p-8;
            given->origin[axis] = floor(((low[axis] + high[axis]) / 2 - edge / 2) / step) * step;
        }
        given->edge = edge;
    }
    return PROGRAM_DONE;
}

/* ---- making ---- */

static int make_tree(program *state, field *made)
{
    if (input_is_tree(state)) {
        return job_load(state, 2, &made->made);
    }
    int exit_code = job_open(state, SVO_NEED_RAYS, 2, &made->made);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = make_room(state, made->made.source.mesh);
    if (exit_code == PROGRAM_DONE) {
        exit_code = job_build(state, SVO_NEED_RAYS, &made->made);
    }
    if (exit_code != PROGRAM_DONE) {
        job_release(&made->made);
    }
    return exit_code;
}

static int make_field(program *state, field *made)
{
    const session *opened = &made->made.opened;
    const options *given = &state->options;
    const svo_sdf_options asked = {.struct_size = sizeof asked,
                                   .band = (float)given->band,
                                   .is_unsigned = given->sign == OPTION_SIGN_NONE,
                                   .rule = given->sign == SVO_SOLID_PARITY ? SVO_SOLID_PARITY : SVO_SOLID_WINDING};
    progress_step(state->progress, "finding distances");
    const double started_ms = input_now_ms();
    if (svo_sdf_create(made->made.result.tree, &asked, opened->queue, &made->sdf) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    made->make_ms = input_now_ms() - started_ms;
    if (svo_sdf_download(made->sdf, opened->queue) != SVO_OK) {
        return program_fail_library(state, svo_device_message(opened->device));
    }
    made->info = (svo_sdf_info)SVO_SDF_INFO_INIT;
    made->arrays = (svo_sdf_arrays)SVO_SDF_ARRAYS_INIT;
    (void)svo_sdf_get_info(made->sdf, &made->info);
    (void)svo_sdf_get_arrays(made->sdf, &made->arrays);
    return PROGRAM_DONE;
}

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

static void write_band(output_file *file, const field *made)
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

static void write_dense(output_file *file, const field *made)
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

static int write_field(program *state, field *made)
{
    output_file file;
    const char *path = state->options.output_path;
    progress_step(state->progress, "writing the field");
    const int exit_code = output_open(state, path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
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

static int report_json(program *state, const field *made)
{
    const svo_sdf_info *info = &made->info;
    cJSON *document = json_document();
    json_add_text(document, "input", state->options.input);
    json_add_text(document, "file", state->options.output_path);
    json_add_count(document, "depth", info->depth);
    cJSON_AddNumberToObject(document, "band", (double)info->band);
    json_add_text(document, "sign", sign_name(state));
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

static int report(program *state, const field *made)
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
    static const char *const of_payload[] = {"need", "weights", "payload-level", NULL};
    static const char *const of_lists[] = {"drop-alpha", NULL};
    static const char *const of_meshes[] = {"margin", NULL};
    static const char *const of_grids[] = {"edge", "origin", NULL};
    if (state->options.output_path == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "-o FILE is missing");
    }
    if (options_refuse(state, of_payload, "to distances") != PROGRAM_DONE ||
        options_refuse(state, of_lists, "to distances, which are those to the whole surface") != PROGRAM_DONE ||
        (input_is_tree(state) &&
         options_refuse(state, of_meshes, "to a finished tree, whose grid is as it is") != PROGRAM_DONE) ||
        (state->options.margin >= 0 && options_refuse(state, of_grids, "with --margin") != PROGRAM_DONE)) {
        return PROGRAM_WRONG_USAGE;
    }
    if (input_is_compact(state) || voxel_input_is_given(state)) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "%s has no triangles; sdf takes a mesh, or a .svo file with rays", state->options.input);
    }
    return output_check(state, state->options.output_path);
}

int command_sdf(program *state)
{
    field made = {.sdf = NULL};
    int exit_code = check_options(state);
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_tree(state, &made);
    }
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = make_field(state, &made);
    if (exit_code == PROGRAM_DONE) {
        exit_code = write_field(state, &made);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = report(state, &made);
    }
    svo_sdf_destroy(&made.sdf);
    job_release(&made.made);
    return exit_code;
}
