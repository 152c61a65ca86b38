/* SPDX-License-Identifier: MIT */
#include "support/hybrid.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "output/output.h"
#include "support/info_of.h"
#include "support/kernel_folder.h"

#define TURNS       4 /* builds of a threshold; the first warms up */
#define LINE_BYTES  1024
#define LINES_MAX   256 /* pairs of one user; the oldest leaves */
#define KEPT_BYTES  ((size_t)LINES_MAX * LINE_BYTES)
#define NOTHING     UINT32_MAX /* columns: kernels make all */
#define DRIVER_NAME 256

static const uint32_t thresholds[] = {1, 8, 64, 512, 4096, NOTHING};

/* ---- the file ---- */

static bool file_name(char *path, size_t path_bytes)
{
    char folder[KERNEL_FOLDER_BYTES];
    return kernel_folder_name(folder) && snprintf(path, path_bytes, "%s/hybrid", folder) < (int)path_bytes;
}

/* A pair's line from the tab on. Drivers choose their names, so tabs and line ends in them become spaces. */
static void describe_pair(const opengl *opened, const svo_device *device, char text[LINE_BYTES])
{
    char driver[DRIVER_NAME] = "";
    const svo_device_info on = info_of_device(device);
    (void)clGetDeviceInfo(on.device, CL_DRIVER_VERSION, sizeof driver, driver, NULL);
    driver[sizeof driver - 1] = '\0';
    const int length = snprintf(text, LINE_BYTES, "\t%.256s\t%s\t%.256s\n", on.name, driver, opengl_renderer(opened));
    unsigned tabs = 0;
    for (int i = 0; i < length - 1; ++i) {
        const bool divides = text[i] == '\t' && tabs < 3;
        tabs += divides ? 1 : 0;
        text[i] = divides || (unsigned char)text[i] >= ' ' ? text[i] : ' ';
    }
}

/* The lines of the file; freed by the caller. "" where there is no file that this user alone writes to. */
static char *read_lines(void)
{
    char path[KERNEL_FOLDER_BYTES + 16];
    char folder[KERNEL_FOLDER_BYTES];
    char *lines = calloc(1, KEPT_BYTES + 1);
    FILE *file =
        lines != NULL && kernel_folder_name(folder) && kernel_folder_is_own(folder) && file_name(path, sizeof path)
            ? fopen(path, "rb")
            : NULL;
    if (file != NULL) {
        lines[fread(lines, 1, KEPT_BYTES, file)] = '\0';
        fclose(file);
    }
    return lines;
}

/* The columns of a line of this pair; 0: it is another's. */
static uint32_t columns_of_line(const char *line, const char *pair)
{
    char *end = NULL;
    const unsigned long long columns = strtoull(line, &end, 10);
    const bool fits = end != line && columns > 0 && columns <= UINT32_MAX;
    return fits && strncmp(end, pair, strlen(pair)) == 0 ? (uint32_t)columns : 0;
}

/* The pair's line first, then those of other pairs. Returns an errno, or 0. */
static int write_lines(const svo_i_output *file, const char *pair, uint32_t columns, char *lines)
{
    char number[16];
    int error = svo_i_output_write(file, number, (size_t)snprintf(number, sizeof number, "%" PRIu32, columns));
    error = error == 0 ? svo_i_output_write(file, pair, strlen(pair)) : error;
    size_t kept = 1;
    for (char *line = lines, *end; error == 0 && (end = strchr(line, '\n')) != NULL && kept < LINES_MAX;
         line = end + 1) {
        if (columns_of_line(line, pair) == 0) {
            error = svo_i_output_write(file, line, (size_t)(end + 1 - line));
            ++kept;
        }
    }
    return error;
}

static int keep(program *state, const opengl *opened, const svo_device *device, uint32_t columns)
{
    char folder[KERNEL_FOLDER_BYTES];
    char path[KERNEL_FOLDER_BYTES + 16];
    char pair[LINE_BYTES];
    svo_i_output file;
    if (!kernel_folder_name(folder) || !kernel_folder_make(folder) || !file_name(path, sizeof path)) {
        return program_fail(state, PROGRAM_FAILED, "--tune: there is no folder to keep the result in");
    }
    char *lines = read_lines();
    if (lines == NULL) {
        return program_fail(state, PROGRAM_FAILED, "--tune: out of memory");
    }
    describe_pair(opened, device, pair);
    int error = svo_i_output_open(path, NULL, &file);
    if (error == 0) {
        error = write_lines(&file, pair, columns, lines);
        error = error == 0 ? svo_i_output_commit(&file) : error;
        svo_i_output_abandon(&file);
    }
    free(lines);
    return error == 0 ? PROGRAM_DONE
                      : program_fail(state, PROGRAM_FAILED, "--tune: %s cannot be written: %s", path, strerror(error));
}

/* ---- use ---- */

static void explain(uint32_t columns, svo_message *reason)
{
    if (columns == NOTHING) {
        snprintf(reason->text, sizeof reason->text,
                 "measured: kernels are faster than the rasterizer for all triangles");
    } else {
        snprintf(reason->text, sizeof reason->text,
                 "measured: the rasterizer is faster for triangles of more than %" PRIu32 " columns", columns);
    }
}

svo_frontend *hybrid_recall(opengl *opened, const svo_device *device, svo_frontend *cl, svo_message *reason)
{
    char pair[LINE_BYTES];
    uint32_t columns = 0;
    char *lines = read_lines();
    describe_pair(opened, device, pair);
    for (char *line = lines, *end; columns == 0 && line != NULL && (end = strchr(line, '\n')) != NULL; line = end + 1) {
        columns = columns_of_line(line, pair);
    }
    free(lines);
    svo_frontend *found = columns == 0         ? NULL
                          : columns == NOTHING ? cl
                                               : opengl_hybrid_frontend(opened, columns, reason);
    if (found != NULL) {
        explain(columns, reason);
    }
    return found;
}

/* ---- measurement ---- */

/* The least time that a list takes, milliseconds. */
static svo_status measure(svo_plan *plan, svo_frontend *frontend, cl_command_queue queue, double *least_ms)
{
    for (unsigned turn = 0; turn < TURNS; ++turn) {
        svo_build_report report = {.struct_size = sizeof report};
        svo_stage_time voxelize, transfer;
        svo_tree *tree = NULL;
        const svo_status status = svo_build(plan, frontend, queue, &tree, &report);
        svo_tree_destroy(&tree);
        if (status != SVO_OK) {
            return status;
        }
        svo_build_report_stage(&report, SVO_STAGE_VOXELIZE, &voxelize);
        svo_build_report_stage(&report, SVO_STAGE_TRANSFER, &transfer);
        const double ms = voxelize.ms + transfer.ms;
        *least_ms = turn <= 1 || ms < *least_ms ? ms : *least_ms;
    }
    return SVO_OK;
}

int hybrid_tune(program *state, opengl *opened, svo_plan *plan, cl_command_queue queue, svo_frontend **best,
                svo_message *reason)
{
    const svo_device *device = opengl_device(opened);
    uint32_t columns = NOTHING;
    double least_ms = 0.0;
    for (size_t i = 0; i < sizeof thresholds / sizeof thresholds[0]; ++i) {
        double ms = 0.0;
        svo_frontend *frontend = opengl_hybrid_frontend(opened, thresholds[i], reason);
        if (frontend == NULL) {
            return program_fail(state, PROGRAM_FAILED, "--tune: %s", reason->text);
        }
        if (measure(plan, frontend, queue, &ms) != SVO_OK) {
            return program_fail_library(state, svo_device_message(device));
        }
        if (i == 0 || ms < least_ms) {
            columns = thresholds[i];
            least_ms = ms;
        }
    }
    *best = opengl_hybrid_frontend(opened, columns, reason);
    explain(columns, reason);
    return keep(state, opened, device, columns);
}
