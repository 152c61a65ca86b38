/* SPDX-License-Identifier: MIT */
/* Paged trees for tests. */
#include "paged_walk.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "scenes.h"
#include "support/work_folder.h"
#include "svocl/io.h"
#include "svocl/parts.h"

#define PICTURES_MAX 64u

void paged_scene_make(void **state, const char *spec, unsigned depth, uint32_t need, paged_scene *out)
{
    scene *made = fixture_scene(spec);
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    *out = (paged_scene){.opened = fixture_cl_of_group(state), .name = "tree.svo"};
    options.need = need != 0 ? need : (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL;
    fixture_build(&out->opened, scene_mesh(made), depth, &options, &out->whole);
    scene_destroy(&made);
    svo_message message = {""};
    if (svo_tree_save(out->whole.tree, svo_to_path(path_of(out->name)), NULL, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    work_folder_remember(out->name);
    out->expected = malloc(PAGED_BYTES);
    out->drawn = malloc(PAGED_BYTES);
    assert_non_null(out->expected);
    assert_non_null(out->drawn);
}

void paged_scene_make_parts(const paged_scene *of, const char *spec, unsigned depth)
{
    svo_plan_options options = SVO_PLAN_OPTIONS_INIT;
    svo_parts *parts = NULL;
    svo_message message = {""};
    scene *made = fixture_scene(spec);
    options.need = (uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL;
    svo_device *device = of->opened.device;
    svo_status status = svo_parts_create(device, scene_mesh(made), depth, &options, 400000, path_of("parts"), &message);
    if (status == SVO_OK) {
        status = svo_parts_open(path_of("parts"), &parts, &message);
    }
    assert_true(status != SVO_OK || svo_parts_count(parts) > 4);
    for (size_t i = 0; status == SVO_OK && i < svo_parts_count(parts); ++i) {
        status = svo_parts_build(parts, i, device, NULL, NULL, &message);
    }
    if (status != SVO_OK) {
        fail_msg("%s", message.text);
    }
    svo_parts_close(&parts);
    scene_destroy(&made);
}

void paged_scene_destroy(paged_scene *of)
{
    built_destroy(&of->whole);
    free(of->expected);
    free(of->drawn);
}

svo_paged *paged_scene_open(const paged_scene *of, uint64_t budget_bytes, uint32_t page_levels)
{
    const svo_paged_options options = {.struct_size = sizeof options, .page_levels = page_levels};
    svo_paged *paged = NULL;
    if (svo_paged_open(of->opened.device, path_of(of->name), budget_bytes, &options, &paged) != SVO_OK) {
        fail_msg("%s", svo_device_message(of->opened.device));
    }
    return paged;
}

uint64_t paged_scene_whole_bytes(const paged_scene *of, uint32_t page_levels)
{
    uint64_t bytes = 0;
    for (uint64_t budget = UINT64_MAX, last = 0; budget != last;) {
        svo_paged *paged = paged_scene_open(of, budget, page_levels);
        bytes = paged_info(paged).whole_bytes;
        svo_paged_close(&paged);
        last = budget;
        budget = bytes;
    }
    return bytes;
}

svo_paged_info paged_info(const svo_paged *paged)
{
    svo_paged_info info = SVO_PAGED_INFO_INIT;
    assert_int_equal(svo_paged_get_info(paged, &info), SVO_OK);
    return info;
}

svo_paged_counts paged_counts(const svo_paged *paged)
{
    svo_paged_counts counts = SVO_PAGED_COUNTS_INIT;
    assert_int_equal(svo_paged_get_counts(paged, &counts), SVO_OK);
    return counts;
}

svo_render_options paged_view(const paged_scene *of, svo_render_view view, unsigned k, unsigned count)
{
    svo_render_options options = SVO_RENDER_OPTIONS_INIT;
    options.width = PAGED_WIDTH;
    options.height = PAGED_HEIGHT;
    options.view = view;
    (void)svo_camera_fit(svo_tree_target(of->whole.tree), (float)PAGED_WIDTH / (float)PAGED_HEIGHT, &options.camera);
    svo_camera *camera = &options.camera;
    const double along = count > 1 ? (double)k / (double)(count - 1) : 0.5;
    const double angle = 3.1 * along;
    const double nearer = 1.6 - 1.2 * along;
    const double x = (double)camera->eye[0] - (double)camera->target[0];
    const double y = (double)camera->eye[1] - (double)camera->target[1];
    const double z = (double)camera->eye[2] - (double)camera->target[2];
    camera->eye[0] = camera->target[0] + (float)(nearer * (x * cos(angle) + z * sin(angle)));
    camera->eye[1] = camera->target[1] + (float)(nearer * y);
    camera->eye[2] = camera->target[2] + (float)(nearer * (z * cos(angle) - x * sin(angle)));
    return options;
}

void paged_draw(const paged_scene *of, svo_paged *paged, const svo_render_options *options)
{
    if (svo_paged_render(paged, options, of->drawn) != SVO_OK) {
        fail_msg("%s", svo_device_message(of->opened.device));
    }
}

void paged_update(const paged_scene *of, svo_paged *paged)
{
    if (svo_paged_update(paged) != SVO_OK) {
        fail_msg("%s", svo_device_message(of->opened.device));
    }
}

void paged_draw_tree(const paged_scene *of, svo_tree *tree, const svo_render_options *options)
{
    if (svo_render(svo_tree_target(tree), options, svo_in_host(of->expected),
                   &(svo_submit){.queue = of->opened.queue}) != SVO_OK) {
        fail_msg("%s", svo_device_message(of->opened.device));
    }
}

unsigned paged_complete(const paged_scene *of, svo_paged *paged, const svo_render_options *options)
{
    for (unsigned pictures = 1; pictures <= PICTURES_MAX; ++pictures) {
        paged_draw(of, paged, options);
        if (paged_counts(paged).missed_pages == 0) {
            return pictures;
        }
        paged_update(of, paged);
    }
    fail_msg("%u pictures, and pages are still missed", PICTURES_MAX);
    return 0;
}
