/* SPDX-License-Identifier: MIT */
/* Pictures of lit trees: the host side of kernels/light/picture.cl. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/struct_size.h"
#include "light/gather.h"
#include "rays/camera.h"
#include "rays/rays.h"

_Static_assert((uint32_t)SVO_LIGHT_VIEW_FULL == SVO_LIT_VIEW_FULL && (uint32_t)SVO_LIGHT_VIEW_AO == SVO_LIT_VIEW_AO &&
                   (uint32_t)SVO_LIGHT_VIEW_DIRECT == SVO_LIT_VIEW_DIRECT &&
                   (uint32_t)SVO_LIGHT_VIEW_INDIRECT == SVO_LIT_VIEW_INDIRECT &&
                   (uint32_t)SVO_LIGHT_VIEW_SPECULAR == SVO_LIT_VIEW_SPECULAR,
               "svo_light_view and kernels/light/picture.cl number the views alike");

#define TILE_EDGE SVO_LIGHT_BAND_ROWS
/* Tiles of a launch, so that none takes long enough for a driver to end it. */
#define BAND_TILES 256u

static const char function[] = "svo_light_render";

/* ---- parameters ---- */

static svo_status check_band(const svo_light *light, const svo_light_picture *picture)
{
    if (picture->first_row >= picture->height || picture->first_row % TILE_EDGE != 0) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                 "%s: picture.first_row %u is not a multiple of %u below height %u", function,
                                 picture->first_row, TILE_EDGE, picture->height);
    }
    return picture->row_count % TILE_EDGE == 0 ? SVO_OK
                                               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                                                   "%s: picture.row_count %u is not a multiple of %u",
                                                                   function, picture->row_count, TILE_EDGE);
}

static svo_status check_picture(const svo_light *light, const svo_light_picture *picture)
{
    SVO_I_TRY(svo_i_camera_check(light->device, function, &picture->camera, picture->width, picture->height));
    if ((unsigned)picture->view > SVO_LIGHT_VIEW_SPECULAR) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: picture.view %d is not in 0 .. %d", function,
                                 (int)picture->view, (int)SVO_LIGHT_VIEW_SPECULAR);
    }
    return picture->exposure >= 0.0F && isfinite(picture->exposure)
               ? check_band(light, picture)
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                   "%s: picture.exposure %g is negative or not finite", function,
                                   (double)picture->exposure);
}

static svo_status fill_params(const svo_light *light, const svo_light_picture *picture, svo_lit_picture_params *params)
{
    svo_i_pinhole hole;
    SVO_I_TRY(
        svo_i_pinhole_from_camera(light->device, function, &picture->camera, picture->width, picture->height, &hole));
    *params = (svo_lit_picture_params){.view = picture->view,
                                       .width = picture->width,
                                       .height = picture->height,
                                       .exposure = picture->exposure > 0.0F ? picture->exposure : 1.0F,
                                       .source_count = (uint32_t)light->setup.source_count,
                                       .finish_count = (uint32_t)light->setup.finish_count};
    for (int axis = 0; axis < 3; ++axis) {
        params->eye[axis] = picture->camera.eye[axis];
        params->corner[axis] = hole.corner[axis];
        params->across[axis] = hole.across[axis];
        params->down[axis] = hole.down[axis];
        params->sky[axis] = light->params.sky[axis];
    }
    return SVO_OK;
}

/* The caller's options for what the view shows of them. */
static svo_status fill_gather(const svo_light *light, const svo_light_picture *picture, svo_gather_params *gather)
{
    SVO_I_TRY(svo_i_gather_params(light, function, &picture->gather, gather));
    if (picture->view == SVO_LIGHT_VIEW_AO) {
        gather->with_light = 0;
    }
    return SVO_OK;
}

/* ---- drawing ---- */

typedef struct drawing {
    svo_i_compact_work work;
    cl_kernel kernel;
    cl_mem sources, finishes; /* NULL: none */
    cl_mem pixels;
} drawing;

static bool has_triangles(const svo_tree *tree)
{
    return (tree->info.need & SVO_NEED_RAYS) != 0 && tree->info.coverage != SVO_COVERAGE_THIN;
}

/* " -DSVO_x -DSVO_ONE_x" as far as the tree has that payload. */
static void add_define(const svo_tree *tree, svo_tree_buffer buffer, const char *held, const char *constant,
                       char *defines, size_t defines_bytes)
{
    if (tree->buffers[buffer] != NULL) {
        const size_t used = strlen(defines);
        (void)snprintf(defines + used, defines_bytes - used, "%s%s", held,
                       svo_i_tree_is_constant(&tree->info, buffer) ? constant : "");
    }
}

static svo_status make_kernel(const svo_light *light, drawing *drawn)
{
    const svo_tree *tree = light->tree;
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    (void)snprintf(defines, sizeof defines, "%s%s", svo_i_gather_defines(light),
                   has_triangles(tree) ? " -DSVO_PICTURE_TRIANGLES" : "");
    add_define(tree, SVO_TREE_COLORS, " -DSVO_COLOR", " -DSVO_ONE_COLOR", defines, sizeof defines);
    add_define(tree, SVO_TREE_NORMALS, " -DSVO_NORMAL", " -DSVO_ONE_NORMAL", defines, sizeof defines);
    if (light->setup.finish_count > 0) {
        add_define(tree, SVO_TREE_MATERIALS, " -DSVO_FINISHES", " -DSVO_ONE_MATERIAL", defines, sizeof defines);
    }
    SVO_I_TRY(svo_i_work_use(&drawn->work, SVO_I_PROGRAM_LIGHT_PICTURE, defines));
    return svo_i_kernel_create(light->device, function, drawn->work.program, "svo_k_light_picture", &drawn->kernel);
}

/* A buffer with a list of the setup; none for an empty list. */
static svo_status upload(drawing *drawn, const char *name, const void *list, size_t bytes, cl_mem *out)
{
    if (bytes == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_work_alloc(&drawn->work, name, bytes, out));
    return svo_i_work_write(&drawn->work, *out, list, bytes);
}

static svo_status prepare(svo_light *light, const svo_light_picture *picture, drawing *drawn)
{
    const svo_i_light_setup *setup = &light->setup;
    const uint64_t pixel_bytes = (uint64_t)picture->width * picture->height * 4;
    SVO_I_TRY(upload(drawn, "sources", setup->sources, setup->source_count * sizeof *setup->sources, &drawn->sources));
    SVO_I_TRY(
        upload(drawn, "finishes", setup->finishes, setup->finish_count * sizeof *setup->finishes, &drawn->finishes));
    SVO_I_TRY(svo_i_work_alloc(&drawn->work, "picture", pixel_bytes, &drawn->pixels));
    return make_kernel(light, drawn);
}

static svo_status set_arguments(const svo_light *light, const drawing *drawn, const svo_gather_params *gather,
                                const svo_lit_picture_params *params)
{
    svo_tree *tree = light->tree;
    const svo_i_argument own[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_COLORS]),
                                  SVO_I_ARGUMENT(tree->buffers[SVO_TREE_NORMALS]),
                                  SVO_I_ARGUMENT(tree->buffers[SVO_TREE_MATERIALS]),
                                  SVO_I_ARGUMENT(drawn->finishes),
                                  SVO_I_ARGUMENT(drawn->sources),
                                  {sizeof *gather, gather, false},
                                  {sizeof *params, params, false},
                                  SVO_I_ARGUMENT(drawn->pixels)};
    SVO_I_TRY(svo_i_rays_set_tree(tree, function, drawn->kernel, 0));
    SVO_I_TRY(svo_i_light_set_args(light, function, drawn->kernel, SVO_TREE_ARGUMENTS));
    return svo_i_kernel_set_from(light->device, function, drawn->kernel, SVO_TREE_ARGUMENTS + SVO_LIGHT_ARGUMENTS,
                                 SVO_I_ARGUMENTS(own));
}

/* Draws some tiles. */
static svo_status draw_band(drawing *drawn, uint64_t tiles)
{
    const size_t local = SVO_GROUP_ITEMS;
    const size_t global = (size_t)tiles * local;
    svo_i_compact_work *work = &drawn->work;
    cl_event event = NULL;
    const cl_int error =
        clEnqueueNDRangeKernel(work->queue, drawn->kernel, 1, NULL, &global, &local, work->last != NULL ? 1 : 0,
                               work->last != NULL ? &work->last : NULL, &event);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(work->device, function, "clEnqueueNDRangeKernel", error);
    }
    svo_i_work_follow(work, event);
    return SVO_OK;
}

/* Rows of the picture's band. */
static uint32_t rows_of_band(const svo_light_picture *picture)
{
    const uint32_t below = picture->height - picture->first_row;
    return picture->row_count == 0 || picture->row_count > below ? below : picture->row_count;
}

static svo_status draw(const svo_light *light, const svo_light_picture *picture, const svo_gather_params *gather,
                       svo_lit_picture_params *params, drawing *drawn)
{
    const uint64_t across = (params->width + TILE_EDGE - 1) / TILE_EDGE;
    const uint64_t begin = across * (picture->first_row / TILE_EDGE);
    const uint64_t end = begin + across * ((rows_of_band(picture) + TILE_EDGE - 1) / TILE_EDGE);
    for (uint64_t first = begin; first < end; first += BAND_TILES) {
        params->first_tile = (uint32_t)first;
        SVO_I_TRY(set_arguments(light, drawn, gather, params));
        SVO_I_TRY(draw_band(drawn, end - first < BAND_TILES ? end - first : BAND_TILES));
    }
    return SVO_OK;
}

svo_status svo_light_render(svo_light *light, const svo_light_picture *picture, cl_command_queue queue, uint8_t *rgba)
{
    svo_light_picture asked;
    svo_lit_picture_params params;
    svo_gather_params gather;
    drawing drawn = {.kernel = NULL};
    svo_status status = SVO_OK;
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    if (picture == NULL || rgba == NULL) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 picture == NULL ? "picture" : "rgba");
    }
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(light->device), function, "picture", picture, &asked,
                                SVO_I_STRUCT_SIZES(svo_light_picture, exposure)));
    SVO_I_TRY(svo_i_tree_check(light->tree, function));
    SVO_I_TRY(check_picture(light, &asked));
    SVO_I_TRY(fill_params(light, &asked, &params));
    SVO_I_TRY(fill_gather(light, &asked, &gather));
    SVO_I_TRY(svo_i_work_begin(light->device, function, queue, &drawn.work));
    SVO_I_TRY_CLEANUP(prepare(light, &asked, &drawn));
    SVO_I_TRY_CLEANUP(draw(light, &asked, &gather, &params, &drawn));
    SVO_I_TRY_CLEANUP(svo_i_work_read(&drawn.work, drawn.pixels, (size_t)asked.width * asked.first_row * 4, rgba,
                                      (size_t)asked.width * rows_of_band(&asked) * 4));

cleanup:
    svo_i_work_end(&drawn.work);
    if (drawn.kernel != NULL) {
        clReleaseKernel(drawn.kernel);
    }
    return status;
}
