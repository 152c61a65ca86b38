/* SPDX-License-Identifier: MIT */
/*
 * Planning from a mesh file by ranges of its triangles. Each range goes through the same steps, in any process that
 * sees the file and the folder; between two steps the planner puts the results of all ranges together:
 *
 *   bounds  vertices of the range -> their bounds: the grid, if triangles use those on it
 *   used    triangles -> the bounds of what they use, where that must be known first
 *   count   triangles -> what all parts share of them, and their histogram (cells.h): the cut
 *   write   triangles -> sections of the parts' files (sections.h)
 *
 * A task and a result are bytes, so that they can travel: a head and a list. Numbers are those of the machine.
 */
#ifndef SVO_LIB_PARTS_RANGES_H
#define SVO_LIB_PARTS_RANGES_H

#include "core/device.h"
#include "parts/blocks.h"
#include "parts/sections.h"
#include "plan/part.h"

typedef enum svo_i_step { STEP_BOUNDS, STEP_USED, STEP_COUNT, STEP_WRITE, STEP_DONE } svo_i_step;

/* The head of a task. After it: the sections, then the paths of the mesh and of the folder for the parts' files, each
   with its terminator. */
typedef struct svo_i_range_task {
    uint8_t magic[8];
    uint64_t bytes; /* of the whole task */
    uint32_t version, step, range;
    uint32_t depth, cells_level, fields;
    uint32_t section_count, path_bytes, place_bytes;
    uint32_t any_color;
    uint64_t file_bytes; /* of the mesh */
    uint64_t begin, end; /* the range: vertices in the step bounds, else faces or facets */
    uint64_t first_name; /* kept triangles of the ranges before */
    svo_i_bounds bounds; /* of the grid */
    svo_plan_options options; /* without pointers */
    svo_part_header header; /* in the step write */
} svo_i_range_task;

/* The head of a result. After it: the cells of a count, or the hashes of what was written. */
typedef struct svo_i_range_result {
    uint8_t magic[8];
    uint64_t bytes;
    uint32_t version, step, range;
    uint32_t is_uneven; /* nothing was done: the file cannot be read by ranges */
    uint32_t any_color, cells_level;
    uint64_t list_count;
    svo_i_triangle_hash kept; /* of the kept triangles, without names */
    svo_i_survey_sums sums;
} svo_i_range_result;

#define RANGE_TASK_MAGIC   "\x89SVQ\r\n\x1a\n"
#define RANGE_RESULT_MAGIC "\x89SVR\r\n\x1a\n"
#define RANGE_VERSION      1u

/* Called now and then while a range is read; NULL allowed. */
typedef svo_status svo_i_range_alive(void *user, svo_message *message);

/* Does a task. result: receives bytes, to be released by svo_i_free. */
svo_status svo_i_range_run(svo_device *device, const svo_i_range_task *task, svo_i_range_alive *alive, void *user,
                           svo_i_range_result **result, svo_message *message);
/* Whether bytes are a task, or the result of one. */
bool svo_i_range_is_task(const void *bytes, size_t byte_count);
bool svo_i_range_is_result(const void *bytes, size_t byte_count, const svo_i_range_task *task);

const svo_i_section *svo_i_range_sections(const svo_i_range_task *task);
const char *svo_i_range_path(const svo_i_range_task *task);

#endif
