/* SPDX-License-Identifier: MIT */
/*
 * Light of a picture by few rays or cones. A band of the picture is gathered with as many rows of cells beside it as
 * the filter reaches, so that what a pixel shows does not depend on bands.
 */
#include "light/screen.h"

#include "light/gather.h"
#include "light/programs.h"

/* Steps of the filter: each reaches 2, 4, 8 .. cells. */
#define STEPS 3u
/* Standard errors by which light may differ in the first step; a half of it in each that follows. */
#define TOLERANCE 4.0F
/* Rows to either side that a pixel depends on: those of the steps, of errors, and of pixels between cells. */
#define BESIDE (2u * ((1u << STEPS) - 1u) + 4u)
/* Cells of a band, unless it has a single row. */
#define BAND_CELLS 1048576u
/* Paths of a launch, so that none takes long enough for a driver to end it; and how many take as long as a cone. */
#define BAND_PATHS 1048576u
#define CONE_PATHS 16u
/* World units within which surfaces are near each other, in leaf edges. */
#define NEAR 4.0F

static svo_status make_buffers(svo_i_light_screen *screen, svo_i_device_work *work)
{
    const uint64_t rows = (uint64_t)screen->band_rows + (uint64_t)2 * BESIDE;
    const uint64_t cells = (rows < screen->height ? rows : screen->height) * screen->params.columns;
    SVO_I_TRY(svo_i_work_alloc(work, "screen_cells", cells * sizeof(svo_gather_point), &screen->cells));
    SVO_I_TRY(svo_i_work_alloc(work, "screen_gathered", cells * sizeof(svo_gather_result), &screen->gathered));
    SVO_I_TRY(svo_i_work_alloc(work, "screen_guide", cells * sizeof(cl_float4), &screen->guide));
    SVO_I_TRY(svo_i_work_alloc(work, "screen_light", cells * sizeof(cl_float4), &screen->light));
    if (screen->mirrors) {
        SVO_I_TRY(svo_i_work_alloc(work, "screen_specular", cells * sizeof(cl_float4), &screen->specular));
    }
    return svo_i_work_alloc(work, "screen_spare", cells * sizeof(cl_float4), &screen->spare);
}

svo_status svo_i_light_screen_begin(const svo_i_light_shader *first, const svo_gather_params *gather, uint32_t width,
                                    uint32_t height, uint32_t row_count, bool mirrors, svo_i_light_screen *out)
{
    const uint32_t columns = (width + SVO_I_SCREEN_CELL - 1) / SVO_I_SCREEN_CELL;
    const uint32_t rows = (row_count + SVO_I_SCREEN_CELL - 1) / SVO_I_SCREEN_CELL;
    const uint32_t most = BAND_CELLS / columns > 0 ? BAND_CELLS / columns : 1;
    *out = (svo_i_light_screen){.asked = *gather,
                                .mirrors = mirrors,
                                .height = (height + SVO_I_SCREEN_CELL - 1) / SVO_I_SCREEN_CELL,
                                .params = {.columns = columns, .near = NEAR * first->light->params.voxel_edge},
                                .band_rows = rows < most ? rows : most};
    SVO_I_TRY(make_buffers(out, first->work));
    SVO_I_TRY(svo_i_light_points_also(first, gather, &out->gather));
    /* The last program of the work has the filter too. */
    return svo_i_light_shader_also(first, &svo_i_program_screen, "svo_k_screen_points", "", &out->points);
}

/* Smooths one of two kinds of light. *light: receives it. */
static svo_status smooth(svo_i_light_screen *screen, bool is_specular, cl_mem *light)
{
    svo_i_device_work *work = screen->points.work;
    const uint64_t cells = (uint64_t)screen->params.columns * screen->params.rows;
    cl_mem from = NULL;
    screen->params.is_specular = is_specular;
    const svo_i_argument of_guide[] = {SVO_I_ARGUMENT(screen->gathered), SVO_I_ARGUMENT(screen->guide),
                                       SVO_I_ARGUMENT(screen->params)};
    SVO_I_TRY(svo_i_work_launch(work, "svo_k_screen_guide", SVO_I_ARGUMENTS(of_guide), cells));
    for (uint32_t step = 0; step < STEPS; ++step) {
        screen->params.step = 1u << step;
        screen->params.tolerance = TOLERANCE / (float)(1u << step);
        const svo_i_argument arguments[] = {SVO_I_ARGUMENT(screen->cells), SVO_I_ARGUMENT(screen->gathered),
                                            SVO_I_ARGUMENT(screen->guide), SVO_I_ARGUMENT(from),
                                            SVO_I_ARGUMENT(screen->spare), SVO_I_ARGUMENT(screen->params)};
        SVO_I_TRY(svo_i_work_launch(work, "svo_k_screen_filter", SVO_I_ARGUMENTS(arguments), cells));
        from = screen->spare;
        screen->spare = *light;
        *light = from;
    }
    return SVO_OK;
}

/* Gathers in launches of so many paths. */
static svo_status gather(const svo_i_light_screen *screen, uint32_t cells)
{
    const size_t groups = ((size_t)cells + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS;
    const uint32_t paths = screen->asked.paths != 0 ? screen->asked.paths : CONE_PATHS * screen->asked.cones;
    const size_t in_band = BAND_PATHS / SVO_GROUP_ITEMS / paths;
    const size_t most = in_band > 0 ? in_band : 1;
    SVO_I_TRY(svo_i_light_points_set(&screen->gather, &screen->asked, 0, screen->cells, screen->gathered, cells));
    for (size_t first = 0; first < groups; first += most) {
        SVO_I_TRY(svo_i_light_shader_launch(&screen->gather, first, groups - first < most ? groups - first : most));
    }
    return SVO_OK;
}

svo_status svo_i_light_screen_band(svo_i_light_screen *screen, const svo_lit_picture_params *picture,
                                   uint32_t first_row, uint32_t end_row)
{
    const uint32_t begin = first_row > BESIDE ? first_row - BESIDE : 0;
    const uint32_t end = end_row + BESIDE < screen->height ? end_row + BESIDE : screen->height;
    const uint32_t cells = screen->params.columns * (end - begin);
    screen->params.first_row = begin;
    screen->params.rows = end - begin;
    const svo_i_argument own[] = {SVO_I_ARGUMENT(screen->cells), SVO_I_ARGUMENT(screen->params)};
    SVO_I_TRY(svo_i_light_shader_set(&screen->points, &screen->asked, picture, SVO_I_ARGUMENTS(own)));
    SVO_I_TRY(svo_i_light_shader_launch(&screen->points, 0, (cells + SVO_GROUP_ITEMS - 1) / SVO_GROUP_ITEMS));
    SVO_I_TRY(gather(screen, cells));
    SVO_I_TRY(smooth(screen, false, &screen->light));
    return screen->mirrors ? smooth(screen, true, &screen->specular) : SVO_OK;
}

void svo_i_light_screen_end(svo_i_light_screen *screen)
{
    svo_i_light_shader_end(&screen->points);
    svo_i_light_shader_end(&screen->gather);
}
