/* SPDX-License-Identifier: MIT */
/*
 * Paged trees: with room for all, pictures are those of the whole tree, byte for byte; with less there are no holes,
 * the pages that went were not used for longest, and the same calls give the same pictures and counts.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "paged/paged.h"
#include "paged_walk.h"
#include "shared/page.h"
#include "support/fixture_folder.h"
#include "support/meshes.h"
#include "support/suite.h"
#include "svocl/io.h"
#include "svocl/parts.h"
#include "svocl/parts_tree.h"

#define DEPTH     7u
#define VIEWS     6u /* of a flight */
#define RUN_SPACE 512u
#define RUN_STEPS 20000u
#define PAGES_MAX 4096u

/* ---- runs ---- */

/* Takes and gives back at random; a map of the elements says where the first fit is. */
static void test_runs(void **state)
{
    (void)state;
    static uint32_t begins[RUN_SPACE], counts[RUN_SPACE];
    static uint8_t taken[RUN_SPACE];
    svo_i_runs runs;
    uint64_t seed = 20;
    size_t live = 0;
    assert_true(svo_i_runs_begin(&runs, NULL, 100, RUN_SPACE));
    for (int step = 0; step < (int)RUN_STEPS; ++step) {
        if (live > 0 && random_below(&seed, 100) < 48) {
            const size_t which = random_below(&seed, (uint32_t)live);
            svo_i_runs_give_back(&runs, begins[which], counts[which]);
            memset(taken + begins[which] - 100, 0, counts[which]);
            begins[which] = begins[--live];
            counts[which] = counts[live];
            continue;
        }
        const uint32_t count = 1 + random_below(&seed, 12);
        uint32_t expected = 0, free_count = 0, begin = 0;
        while (expected + free_count < RUN_SPACE && free_count < count) {
            const uint32_t at = expected + free_count;
            free_count = taken[at] == 0 ? free_count + 1 : 0;
            expected = free_count == 0 ? at + 1 : expected;
        }
        assert_true(svo_i_runs_reserve(&runs));
        assert_int_equal(svo_i_runs_take(&runs, count, &begin), free_count == count);
        if (free_count == count) {
            assert_int_equal(begin, 100 + expected);
            memset(taken + expected, 1, count);
            begins[live] = begin;
            counts[live++] = count;
        }
    }
    svo_i_runs_end(&runs);
}

/* ---- with room for all ---- */

static void check_whole(void **state, const char *spec, unsigned depth, uint32_t need)
{
    paged_scene scene;
    paged_scene_make(state, spec, depth, need, &scene);
    for (uint32_t page_levels = PAGED_LEVELS_MIN; page_levels <= PAGED_LEVELS_MAX; ++page_levels) {
        const uint64_t budget = paged_scene_whole_bytes(&scene, page_levels);
        svo_paged *paged = paged_scene_open(&scene, budget, page_levels);
        assert_int_equal(paged_info(paged).device_bytes, budget);
        assert_true(paged_info(paged).page_count > 0);
        for (int view = SVO_VIEW_SHADED; view <= SVO_VIEW_LEVEL; ++view) {
            const svo_render_options options =
                paged_view(&scene, (svo_render_view)view, (unsigned)view, SVO_VIEW_LEVEL + 1);
            (void)paged_complete(&scene, paged, &options);
            paged_draw_tree(&scene, scene.whole.tree, &options);
            assert_memory_equal(scene.drawn, scene.expected, PAGED_BYTES);
        }
        const svo_paged_counts counts = paged_counts(paged);
        assert_int_equal(counts.all_evicted_pages, 0);
        assert_int_equal(counts.held_pages, counts.all_read_pages);
        assert_true(counts.all_read_pages > 0);
        svo_paged_close(&paged);
    }
    paged_scene_destroy(&scene);
}

static void test_pictures_are_those_of_the_whole_tree(void **state)
{
    check_whole(state, "statue:4000", DEPTH, 0);
    check_whole(state, "atrium:6000", 8, 0);
}

static void test_payload_that_is_constant_or_missing(void **state)
{
    check_whole(state, "cornell", DEPTH, SVO_NEED_COLOR);
    check_whole(state, "cube", DEPTH, SVO_NEED_COLOR | SVO_NEED_NORMAL);
    check_whole(state, "knot:3000", DEPTH, SVO_NEED_NONE);
    check_whole(state, "knot:3000", DEPTH, SVO_NEED_NORMAL | SVO_NEED_RAYS);
}

/* Where the top levels are all there is, the first picture is complete. */
static void test_a_tree_without_pages(void **state)
{
    for (unsigned depth = 1; depth <= 5; ++depth) {
        paged_scene scene;
        paged_scene_make(state, "knot:500", depth, 0, &scene);
        svo_paged *paged = paged_scene_open(&scene, UINT64_MAX, 0);
        const svo_render_options options = paged_view(&scene, SVO_VIEW_SHADED, 0, 1);
        assert_int_equal(paged_info(paged).page_count, 0);
        assert_int_equal(paged_info(paged).top_level, depth);
        assert_int_equal(paged_complete(&scene, paged, &options), 1);
        paged_draw_tree(&scene, scene.whole.tree, &options);
        assert_memory_equal(scene.drawn, scene.expected, PAGED_BYTES);
        svo_paged_close(&paged);
        paged_scene_destroy(&scene);
    }
}

static void test_the_empty_tree(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_mesh mesh = SVO_MESH_INIT;
    uint8_t *rgba = calloc(1, PAGED_BYTES);
    built empty;
    svo_paged *paged = NULL;
    fixture_build(&opened, &mesh, DEPTH, NULL, &empty);
    assert_int_equal(svo_tree_save(empty.tree, svo_to_path(path_of("tree.svo")), NULL, NULL), SVO_OK);
    work_folder_remember("tree.svo");
    for (uint64_t budget = 4096; budget <= 4096 * 1024; budget *= 1024) {
        assert_int_equal(svo_paged_open(opened.device, path_of("tree.svo"), budget, NULL, &paged), SVO_OK);
        svo_render_options options = {
            .struct_size = sizeof options, .width = PAGED_WIDTH, .height = PAGED_HEIGHT, .view = SVO_VIEW_LEVEL};
        (void)svo_camera_fit(svo_tree_target(empty.tree), 1.0F, &options.camera);
        assert_int_equal(svo_paged_render(paged, &options, rgba), SVO_OK);
        for (size_t i = 0; i < PAGED_BYTES; ++i) {
            assert_int_equal(rgba[i], 255);
        }
        assert_int_equal(paged_counts(paged).missed_pages, 0);
        assert_int_equal(svo_paged_update(paged), SVO_OK);
        svo_paged_close(&paged);
    }
    built_destroy(&empty);
    free(rgba);
}

/* ---- with less ---- */

static bool is_covered(const uint8_t *rgba, size_t pixel)
{
    return (rgba[4 * pixel] & rgba[4 * pixel + 1] & rgba[4 * pixel + 2]) != 255;
}

/* Every pixel that the whole tree covers is covered, and none that the tree of the top levels does not. */
static void check_cover(const paged_scene *scene, svo_tree *coarse, const svo_render_options *options)
{
    size_t pixel = 0;
    paged_draw_tree(scene, scene->whole.tree, options);
    for (pixel = 0; pixel < PAGED_BYTES / 4; ++pixel) {
        assert_true(is_covered(scene->drawn, pixel) || !is_covered(scene->expected, pixel));
    }
    paged_draw_tree(scene, coarse, options);
    for (pixel = 0; pixel < PAGED_BYTES / 4; ++pixel) {
        assert_true(is_covered(scene->expected, pixel) || !is_covered(scene->drawn, pixel));
    }
}

static void check_flight(const paged_scene *scene, uint64_t budget, svo_render_view view)
{
    svo_paged *paged = paged_scene_open(scene, budget, 3);
    const uint32_t top_level = paged_info(paged).top_level;
    svo_tree *coarse = NULL;
    const svo_load_options levels = {.struct_size = sizeof levels, .last_level = top_level};
    assert_true(paged_info(paged).device_bytes <= budget);
    assert_int_equal(svo_tree_load(svo_from_path(path_of(scene->name)), &levels, &coarse, NULL), SVO_OK);
    assert_int_equal(svo_tree_upload(coarse, scene->opened.device, NULL), SVO_OK);
    for (unsigned k = 0; k < 3 * VIEWS; ++k) {
        const svo_render_options options = paged_view(scene, view, k, 3 * VIEWS);
        paged_draw(scene, paged, &options);
        check_cover(scene, coarse, &options);
        paged_update(scene, paged);
    }
    assert_true(paged_counts(paged).all_read_pages > 0);
    svo_tree_destroy(&coarse);
    svo_paged_close(&paged);
}

static void test_no_holes(void **state)
{
    paged_scene scene;
    paged_scene_make(state, "statue:4000", 8, 0, &scene);
    const uint64_t whole = paged_scene_whole_bytes(&scene, 3);
    for (uint64_t share = 2; share <= 16; share *= 2) {
        check_flight(&scene, whole / share, SVO_VIEW_LEVEL);
        check_flight(&scene, whole / share, SVO_VIEW_DEPTH);
    }
    paged_scene_destroy(&scene);
}

/* ---- what goes, and when ---- */

/* The table of a paged tree before an update. */
typedef struct snapshot {
    uint32_t begin[PAGES_MAX], used[PAGES_MAX];
    uint32_t mark[PAGES_MAX];
    uint32_t page_count;
} snapshot;

static void take_snapshot(const svo_paged *paged, snapshot *out)
{
    out->page_count = paged->layout.page_count;
    assert_true(out->page_count <= PAGES_MAX);
    for (uint32_t page = 0; page < out->page_count; ++page) {
        out->begin[page] = paged->pages[page].inner_at;
        out->used[page] = paged->pages[page].used;
        out->mark[page] = paged->table[SVO_PAGE_WORDS * page + SVO_PAGE_MARK];
        assert_int_equal(paged->table[SVO_PAGE_WORDS * page + SVO_PAGE_BEGIN], out->begin[page]);
    }
}

/* Pages go by their last use, and of the same picture the later ones first. Those of the last picture stay. */
static bool goes_before(const snapshot *before, uint32_t a, uint32_t b)
{
    return before->used[a] != before->used[b] ? before->used[a] < before->used[b] : a > b;
}

static uint64_t check_eviction(const svo_paged *paged, const snapshot *before, uint32_t now)
{
    static snapshot after;
    uint64_t evicted = 0;
    uint32_t last_gone = UINT32_MAX;
    take_snapshot(paged, &after);
    for (uint32_t page = 0; page < before->page_count; ++page) {
        if (before->begin[page] != 0 && after.begin[page] == 0) {
            assert_int_not_equal(before->used[page], now);
            last_gone = last_gone == UINT32_MAX || goes_before(before, last_gone, page) ? page : last_gone;
            ++evicted;
        } else if (before->begin[page] == 0 && after.begin[page] != 0) {
            assert_int_not_equal(before->mark[page], 0);
        }
    }
    for (uint32_t page = 0; page < before->page_count && evicted > 0; ++page) {
        if (before->begin[page] != 0 && after.begin[page] != 0) {
            assert_true(goes_before(before, last_gone, page));
        }
    }
    return evicted;
}

/* What is there is there with everything above it, and nothing lies on anything else. */
static void check_places(const svo_paged *paged)
{
    const uint32_t capacity = paged->layout.inner_capacity + paged->layout.leaf_capacity;
    uint8_t *owned = calloc(1, capacity);
    assert_non_null(owned);
    for (uint32_t page = 0; page < paged->layout.page_count; ++page) {
        uint32_t inner_count = 0, leaf_count = 0;
        svo_i_paged_size(paged, page, &inner_count, &leaf_count);
        const paged_page *place = &paged->pages[page];
        for (uint32_t i = 0; place->inner_at != 0 && i < inner_count + leaf_count; ++i) {
            const uint32_t at = i < inner_count ? place->inner_at + i : place->leaf_at + i - inner_count;
            assert_true(at < capacity && at >= paged->layout.top_inner_count);
            assert_int_equal(at >= paged->layout.inner_capacity, i >= inner_count);
            assert_int_equal(owned[at]++, 0);
        }
    }
    free(owned);
}

static void test_the_least_recently_used_go(void **state)
{
    static snapshot before;
    paged_scene scene;
    uint64_t evicted = 0;
    paged_scene_make(state, "statue:4000", 8, 0, &scene);
    svo_paged *paged = paged_scene_open(&scene, paged_scene_whole_bytes(&scene, 3) / 6, 3);
    for (unsigned k = 0; k < 60; ++k) {
        const svo_render_options options = paged_view(&scene, SVO_VIEW_NORMAL, k * 7 % 60, 60);
        paged_draw(&scene, paged, &options);
        take_snapshot(paged, &before);
        paged_update(&scene, paged);
        const svo_paged_counts counts = paged_counts(paged);
        const uint64_t gone = check_eviction(paged, &before, (uint32_t)counts.pictures);
        assert_int_equal(gone, counts.evicted_pages);
        check_places(paged);
        evicted += gone;
    }
    assert_true(evicted > 100);
    assert_int_equal(evicted, paged_counts(paged).all_evicted_pages);
    svo_paged_close(&paged);
    paged_scene_destroy(&scene);
}

/* The same flight twice: the same pictures, misses, reads and evictions. */
static void test_the_same_flight_twice(void **state)
{
    paged_scene scene;
    paged_scene_make(state, "statue:4000", 8, 0, &scene);
    const uint64_t budget = paged_scene_whole_bytes(&scene, 2) / 8;
    svo_paged *first = paged_scene_open(&scene, budget, 2);
    svo_paged *second = paged_scene_open(&scene, budget, 2);
    for (unsigned k = 0; k < 24; ++k) {
        const svo_render_options options = paged_view(&scene, SVO_VIEW_SHADED, k * 5 % 24, 24);
        paged_draw(&scene, first, &options);
        memcpy(scene.expected, scene.drawn, PAGED_BYTES);
        paged_update(&scene, first);
        paged_draw(&scene, second, &options);
        paged_update(&scene, second);
        assert_memory_equal(scene.drawn, scene.expected, PAGED_BYTES);
        const svo_paged_counts a = paged_counts(first);
        const svo_paged_counts b = paged_counts(second);
        assert_memory_equal(&a, &b, sizeof a);
    }
    assert_true(paged_counts(first).all_evicted_pages > 0);
    svo_paged_close(&first);
    svo_paged_close(&second);
    paged_scene_destroy(&scene);
}

/* ---- bytes ---- */

static uint64_t buffer_bytes(cl_mem buffer)
{
    size_t bytes = 0;
    if (buffer != NULL) {
        assert_int_equal(clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL), CL_SUCCESS);
    }
    return bytes;
}

/* Whatever is given, no more is taken; what is too little is told. */
static void test_budgets(void **state)
{
    paged_scene scene;
    paged_scene_make(state, "statue:4000", 8, 0, &scene);
    const uint64_t whole = paged_scene_whole_bytes(&scene, 0);
    uint64_t least = 0;
    for (uint64_t budget = whole + 1000; budget > 0 && least == 0; budget = budget * 4 / 5) {
        svo_paged *paged = NULL;
        const svo_status status = svo_paged_open(scene.opened.device, path_of(scene.name), budget, NULL, &paged);
        if (status != SVO_OK) {
            assert_int_equal(status, SVO_CAPACITY_EXCEEDED);
            const char *below = strstr(svo_device_message(scene.opened.device), " is below ");
            assert_non_null(below);
            least = strtoull(below + strlen(" is below "), NULL, 10);
            assert_true(least > budget);
            break;
        }
        const svo_paged_info info = paged_info(paged);
        uint64_t bytes = buffer_bytes(paged->links) + buffer_bytes(paged->device_table);
        for (int i = 0; i < PAGED_ARRAYS; ++i) {
            bytes += buffer_bytes(paged->arrays[i]);
        }
        assert_int_equal(bytes, info.device_bytes);
        assert_true(bytes <= budget);
        assert_true(info.least_bytes <= budget);
        svo_paged_close(&paged);
    }
    assert_true(least > 0);
    svo_paged *paged = paged_scene_open(&scene, least, 0);
    assert_int_equal(paged_info(paged).device_bytes, least);
    svo_paged_close(&paged);
    assert_int_equal(svo_paged_open(scene.opened.device, path_of(scene.name), least - 1, NULL, &paged),
                     SVO_CAPACITY_EXCEEDED);
    paged_scene_destroy(&scene);
}

/* Updates that may read little: each reads one page more than the limit at most, and in the end everything is there. */
static void test_updates_with_a_limit(void **state)
{
    paged_scene scene;
    paged_scene_make(state, "statue:4000", DEPTH, 0, &scene);
    const svo_paged_options options = {.struct_size = sizeof options, .page_levels = 3, .update_bytes = 20000};
    const svo_render_options view = paged_view(&scene, SVO_VIEW_SHADED, 0, 1);
    svo_paged *paged = NULL;
    assert_int_equal(
        svo_paged_open(scene.opened.device, path_of(scene.name), paged_scene_whole_bytes(&scene, 3), &options, &paged),
        SVO_OK);
    uint64_t waiting = 0;
    do {
        paged_draw(&scene, paged, &view);
        paged_update(&scene, paged);
        const svo_paged_counts counts = paged_counts(paged);
        assert_true(counts.read_bytes < options.update_bytes + 584 * 11);
        assert_int_equal(counts.read_pages + counts.waiting_pages, counts.missed_pages);
        waiting += counts.waiting_pages;
    } while (paged_counts(paged).missed_pages > 0);
    assert_true(waiting > 0);
    paged_draw_tree(&scene, scene.whole.tree, &view);
    assert_memory_equal(scene.drawn, scene.expected, PAGED_BYTES);
    svo_paged_close(&paged);
    paged_scene_destroy(&scene);
}

/* ---- failures ---- */

static size_t failing_bytes; /* a read of so many fails after it has brought them */

/* NOLINTBEGIN(readability-identifier-naming) */
cl_int __real_clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                  void *to, cl_uint num_wait, const cl_event *wait, cl_event *event);
cl_int __wrap_clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                  void *to, cl_uint num_wait, const cl_event *wait, cl_event *event);

cl_int __wrap_clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t bytes,
                                  void *to, cl_uint num_wait, const cl_event *wait, cl_event *event)
{
    const cl_int error = __real_clEnqueueReadBuffer(queue, buffer, blocking, offset, bytes, to, num_wait, wait, event);
    return bytes == failing_bytes ? CL_OUT_OF_RESOURCES : error;
}
/* NOLINTEND(readability-identifier-naming) */

/* A picture whose marks could not be read has missed nothing, whatever came of the read. */
static void test_marks_that_cannot_be_read(void **state)
{
    paged_scene scene;
    paged_scene_make(state, "knot:500", DEPTH, 0, &scene);
    const svo_render_options view = paged_view(&scene, SVO_VIEW_NORMAL, 0, 1);
    svo_paged *paged = paged_scene_open(&scene, paged_scene_whole_bytes(&scene, 2) / 8, 2);
    failing_bytes = paged_info(paged).page_count * SVO_PAGE_WORDS * sizeof(uint32_t);
    assert_int_not_equal(svo_paged_render(paged, &view, scene.drawn), SVO_OK);
    failing_bytes = 0;
    assert_int_equal(paged_counts(paged).missed_pages, 0);
    paged_update(&scene, paged);
    assert_int_equal(paged_counts(paged).read_pages + paged_counts(paged).waiting_pages, 0);
    paged_draw(&scene, paged, &view);
    assert_true(paged_counts(paged).missed_pages > 0);
    svo_paged_close(&paged);
    paged_scene_destroy(&scene);
}

/* ---- folders of parts ---- */

/* The same calls give the same pictures, misses and reads as the stitched file does. */
static void test_a_folder_of_parts(void **state)
{
    static const char spec[] = "statue:4000";
    paged_scene file, folder;
    paged_scene_make(state, spec, DEPTH, 0, &file);
    paged_scene_make_parts(&file, spec, DEPTH);
    folder = file;
    folder.name = "parts";
    folder.drawn = file.expected;
    const uint64_t whole = paged_scene_whole_bytes(&file, 0);
    assert_int_equal(paged_scene_whole_bytes(&folder, 0), whole);
    for (uint64_t budget = whole; budget >= whole / 4; budget -= whole / 4) {
        svo_paged *of_file = paged_scene_open(&file, budget, 0);
        svo_paged *of_folder = paged_scene_open(&folder, budget, 0);
        for (unsigned k = 0; k < 3 * VIEWS; ++k) {
            const svo_render_options view = paged_view(&file, SVO_VIEW_SHADED, k / 3, VIEWS);
            paged_draw(&file, of_file, &view);
            paged_draw(&folder, of_folder, &view);
            assert_memory_equal(file.drawn, folder.drawn, PAGED_BYTES);
            const svo_paged_counts a = paged_counts(of_file), b = paged_counts(of_folder);
            assert_memory_equal(&a, &b, sizeof a);
            paged_update(&file, of_file);
            paged_update(&folder, of_folder);
        }
        assert_true(paged_counts(of_file).all_read_pages > 0);
        svo_paged_close(&of_file);
        svo_paged_close(&of_folder);
    }
    paged_scene_destroy(&file);
}

/* What lies under a node down to a level: the picture of its tree in core. */
static void test_a_region_of_parts(void **state)
{
    static const char spec[] = "statue:4000";
    paged_scene scene;
    svo_message message = {""};
    svo_tree *part = NULL;
    svo_paged *paged = NULL;
    svo_parts_tree *tree = NULL;
    svo_parts_region region = SVO_PARTS_REGION_INIT;
    svo_paged_options options = SVO_PAGED_OPTIONS_INIT;
    paged_scene_make(state, spec, DEPTH, 0, &scene);
    paged_scene_make_parts(&scene, spec, DEPTH);
    svo_device *device = scene.opened.device;
    region.level = 1;
    region.code = 2;
    region.last_level = DEPTH - 1;
    options.region = &region;
    options.page_levels = 2;
    assert_int_equal(svo_parts_tree_open(path_of("parts"), &tree, &message), SVO_OK);
    assert_int_equal(svo_parts_tree_load(tree, &region, &part, &message), SVO_OK);
    assert_int_equal(svo_tree_upload(part, device, NULL), SVO_OK);
    assert_int_equal(svo_paged_open(device, path_of("parts"), 60000, &options, &paged), SVO_OK);
    assert_int_equal(paged_info(paged).depth, DEPTH - 2);
    assert_true(paged_info(paged).page_count > 0);
    svo_render_options view = paged_view(&scene, SVO_VIEW_NORMAL, 0, 1);
    assert_int_equal(svo_camera_fit(svo_tree_target(part), 4.0f / 3.0f, &view.camera), SVO_OK);
    (void)paged_complete(&scene, paged, &view);
    paged_draw_tree(&scene, part, &view);
    assert_memory_equal(scene.drawn, scene.expected, PAGED_BYTES);
    svo_paged_close(&paged);
    assert_int_equal(svo_paged_open(device, path_of(scene.name), 1 << 20, &options, &paged), SVO_INVALID_ARGUMENT);
    assert_non_null(strstr(svo_device_message(device), "is no folder of parts"));
    svo_parts_tree_close(&tree);
    svo_tree_destroy(&part);
    assert_int_equal(svo_parts_remove(path_of("parts"), &message), SVO_OK);
    paged_scene_destroy(&scene);
}

/* ---- arguments ---- */

static void test_arguments(void **state)
{
    paged_scene scene;
    svo_paged *paged = NULL;
    svo_paged_options options = SVO_PAGED_OPTIONS_INIT;
    paged_scene_make(state, "knot:500", DEPTH, 0, &scene);
    svo_device *device = scene.opened.device;
    const char *path = path_of(scene.name);
    assert_int_equal(svo_paged_open(NULL, path, 1 << 20, NULL, &paged), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_paged_open(device, NULL, 1 << 20, NULL, &paged), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_paged_open(device, path, 1 << 20, NULL, NULL), SVO_INVALID_ARGUMENT);
    options.page_levels = PAGED_LEVELS_MAX + 1;
    assert_int_equal(svo_paged_open(device, path, 1 << 20, &options, &paged), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(device), "svo_paged_open: options.page_levels 6 is not in 2 .. 5");
    options.page_levels = 1;
    assert_int_equal(svo_paged_open(device, path, 1 << 20, &options, &paged), SVO_INVALID_ARGUMENT);
    assert_null(paged);
    assert_int_equal(svo_paged_update(NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_paged_get_info(NULL, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_paged_get_counts(NULL, NULL), SVO_INVALID_ARGUMENT);
    svo_paged_close(NULL);
    svo_paged_close(&paged);
    paged = paged_scene_open(&scene, 1 << 20, 0);
    svo_render_options view = paged_view(&scene, SVO_VIEW_TRIANGLES, 0, 1);
    assert_int_equal(svo_paged_render(NULL, &view, scene.drawn), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_paged_render(paged, NULL, scene.drawn), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_paged_render(paged, &view, scene.drawn), SVO_INVALID_ARGUMENT);
    assert_string_equal(
        svo_device_message(device),
        "svo_paged_render: options.view 5 is none of a paged tree, which has SVO_VIEW_SHADED, NORMAL, DEPTH, STEPS "
        "and LEVEL");
    view.view = SVO_VIEW_NORMAL;
    assert_int_equal(svo_paged_render(paged, &view, NULL), SVO_INVALID_ARGUMENT);
    assert_int_equal(svo_paged_update(paged), SVO_OK); /* nothing was drawn, so nothing is missed */
    assert_int_equal(paged_counts(paged).read_pages, 0);
    svo_paged_close(&paged);
    paged_scene_destroy(&scene);
}

TEST_GROUP(paged)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_runs),
        cmocka_unit_test(test_pictures_are_those_of_the_whole_tree),
        cmocka_unit_test(test_payload_that_is_constant_or_missing),
        cmocka_unit_test(test_a_tree_without_pages),
        cmocka_unit_test(test_the_empty_tree),
        cmocka_unit_test(test_no_holes),
        cmocka_unit_test(test_the_least_recently_used_go),
        cmocka_unit_test(test_the_same_flight_twice),
        cmocka_unit_test(test_budgets),
        cmocka_unit_test(test_updates_with_a_limit),
        cmocka_unit_test(test_marks_that_cannot_be_read),
        cmocka_unit_test(test_a_folder_of_parts),
        cmocka_unit_test(test_a_region_of_parts),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests_name("paged", tests, fixture_folder_setup, fixture_folder_teardown);
}
