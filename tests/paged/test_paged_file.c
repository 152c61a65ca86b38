/* SPDX-License-Identifier: MIT */
/*
 * Files of paged trees: what is damaged, older or compressed is refused when it is opened, by words; what changes
 * afterwards is noticed when a page of it is read, and the tree stays as it was.
 */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/file_format.h"
#include "paged_walk.h"
#include "scenes.h"
#include "support/fixture_folder.h"
#include "support/meshes.h"
#include "support/older_file.h"
#include "support/suite.h"
#include "svocl/io.h"

#define DEPTH       6u
#define PAGE_LEVELS 2u
#define FLIP_COUNT  4000
#define CUT_COUNT   300

/* Room for all pages of the scene at hand. */
static uint64_t budget;

typedef struct file_bytes {
    uint8_t *bytes;
    size_t count;
} file_bytes;

static file_bytes read_file(const char *path)
{
    file_bytes file = {NULL, 0};
    FILE *from = fopen(path, "rb");
    assert_non_null(from);
    assert_int_equal(fseek(from, 0, SEEK_END), 0);
    file.count = (size_t)ftell(from);
    rewind(from);
    file.bytes = malloc(file.count);
    assert_non_null(file.bytes);
    assert_int_equal(fread(file.bytes, 1, file.count, from), file.count);
    assert_int_equal(fclose(from), 0);
    return file;
}

static svo_status open_file(const paged_scene *of, const char *name, svo_paged **out)
{
    const svo_paged_options options = {.struct_size = sizeof options, .page_levels = PAGE_LEVELS};
    return svo_paged_open(of->opened.device, path_of(name), budget, &options, out);
}

static void make_scene(void **state, uint32_t need, paged_scene *out)
{
    paged_scene_make(state, "statue:2000", DEPTH, need, out);
    budget = paged_scene_whole_bytes(out, PAGE_LEVELS);
}

/* The chunk that a byte belongs to; NULL: the header and its table. */
static const file_chunk *chunk_of(const uint8_t *bytes, size_t at)
{
    const file_header *header = (const file_header *)(const void *)bytes;
    const file_chunk *chunks = (const file_chunk *)(const void *)(bytes + sizeof *header);
    for (uint32_t i = 0; i < header->chunk_count; ++i) {
        if (at >= chunks[i].offset && at < chunks[i].offset + chunks[i].stored_bytes) {
            return &chunks[i];
        }
    }
    return NULL;
}

/* Whether pictures need the chunk. */
static bool is_shown(const file_chunk *chunk)
{
    const uint32_t array = chunk->kind & ((1u << FILE_KIND_BITS) - 1);
    return array == SVO_TREE_CHILD_MASK || array == SVO_TREE_COLORS || array == SVO_TREE_NORMALS;
}

static void test_flipped_bits(void **state)
{
    paged_scene shown;
    uint64_t seed = 7;
    size_t refused = 0, accepted = 0;
    make_scene(state, (uint32_t)SVO_NEED_ALL, &shown);
    file_bytes file = read_file(path_of(shown.name));
    for (int i = 0; i < FLIP_COUNT; ++i) {
        const size_t at = i < 400 ? (size_t)i : random_below(&seed, (uint32_t)file.count);
        const file_chunk *chunk = chunk_of(file.bytes, at);
        svo_paged *paged = NULL;
        file.bytes[at] ^= (uint8_t)(1u << random_below(&seed, 8));
        const bool refuses = chunk == NULL || is_shown(chunk);
        write_bytes("flipped.svo", file.bytes, file.count);
        const svo_status status = open_file(&shown, "flipped.svo", &paged);
        if (refuses && status != SVO_FILE_DAMAGED) {
            fail_msg("byte %zu: %s", at, svo_name(SVO_NAME_STATUS, status));
        }
        if (!refuses) {
            assert_int_equal(status, SVO_OK);
        }
        refused += refuses ? 1 : 0;
        accepted += refuses ? 0 : 1;
        svo_paged_close(&paged);
        free(file.bytes);
        file = read_file(path_of(shown.name));
    }
    assert_true(refused > 1000);
    assert_true(accepted > 100);
    free(file.bytes);
    paged_scene_destroy(&shown);
}

static void test_truncated_files(void **state)
{
    paged_scene shown;
    make_scene(state, 0, &shown);
    const file_bytes file = read_file(path_of(shown.name));
    for (size_t i = 0; i < CUT_COUNT; ++i) {
        svo_paged *paged = NULL;
        write_bytes("cut.svo", file.bytes, i < 250 ? i : file.count - (i - 249));
        assert_int_equal(open_file(&shown, "cut.svo", &paged), SVO_FILE_DAMAGED);
        assert_null(paged);
    }
    free(file.bytes);
    paged_scene_destroy(&shown);
}

static void expect_refused(const paged_scene *of, const char *name, svo_status status, const char *words)
{
    svo_paged *paged = NULL;
    assert_int_equal(open_file(of, name, &paged), status);
    if (strstr(svo_device_message(of->opened.device), words) == NULL) {
        fail_msg("\"%s\" is not in \"%s\"", words, svo_device_message(of->opened.device));
    }
    assert_null(paged);
}

static void test_files_that_cannot_be_paged(void **state)
{
    paged_scene shown;
    make_scene(state, 0, &shown);
    const svo_save_options compressed = {.struct_size = sizeof compressed, .compress = 1};
    size_t byte_count = 0;
    uint8_t *older = older_file_make(shown.whole.tree, 2, &byte_count);
    write_bytes("older.svo", older, byte_count);
    expect_refused(&shown, "older.svo", SVO_UNSUPPORTED, "version 2 is not by levels");
    free(older);
    assert_int_equal(svo_tree_save(shown.whole.tree, svo_to_path(path_of("packed.svo")), &compressed, NULL), SVO_OK);
    work_folder_remember("packed.svo");
    expect_refused(&shown, "packed.svo", SVO_UNSUPPORTED, "is compressed, and pages are read from chunks that are not");
    expect_refused(&shown, "missing.svo", SVO_FILE_ERROR, "cannot be read");
    expect_refused(&shown, "", SVO_FILE_ERROR, "plan: cannot be opened"); /* a folder without parts */
    write_text("text.svo", "not a tree");
    expect_refused(&shown, "text.svo", SVO_FILE_DAMAGED, "not a .svo file");
    paged_scene_destroy(&shown);
}

static void test_payload_not_on_all_levels(void **state)
{
    paged_scene shown;
    make_scene(state, 0, &shown);
    const svo_plan_options options = {
        .struct_size = sizeof options, .need = (uint32_t)SVO_NEED_NORMAL, .payload_level = DEPTH};
    scene *made = fixture_scene("statue:2000");
    built deep;
    fixture_build(&shown.opened, scene_mesh(made), DEPTH, &options, &deep);
    assert_int_equal(svo_tree_save(deep.tree, svo_to_path(path_of("deep.svo")), NULL, NULL), SVO_OK);
    work_folder_remember("deep.svo");
    expect_refused(&shown, "deep.svo", SVO_UNSUPPORTED, "payload from level 6 on only");
    scene_destroy(&made);
    built_destroy(&deep);
    paged_scene_destroy(&shown);
}

/* ---- files that change ---- */

/* Writes bytes into the file that is there, or cuts it. */
static void overwrite(const char *name, const uint8_t *bytes, size_t count)
{
    FILE *to = fopen(path_of(name), "r+b");
    assert_non_null(to);
    assert_int_equal(fwrite(bytes, 1, count, to), count);
    assert_int_equal(fclose(to), 0);
    assert_int_equal(truncate(path_of(name), (off_t)count), 0);
}

/* An update fails while the file is another, reads nothing then, and succeeds when the file is itself again. */
static void check_changed(const paged_scene *of, const file_bytes *file, const uint8_t *changed, size_t count)
{
    const svo_render_options view = paged_view(of, SVO_VIEW_SHADED, 0, 1);
    svo_paged *paged = NULL;
    assert_int_equal(open_file(of, of->name, &paged), SVO_OK);
    paged_draw(of, paged, &view);
    const svo_paged_counts before = paged_counts(paged);
    assert_true(before.missed_pages > 0);
    overwrite(of->name, changed, count);
    memcpy(of->expected, of->drawn, PAGED_BYTES);
    assert_int_equal(svo_paged_update(paged), SVO_FILE_DAMAGED);
    assert_int_equal(paged_counts(paged).held_pages, 0);
    assert_int_equal(paged_counts(paged).read_pages, 0);
    overwrite(of->name, file->bytes, file->count);
    paged_update(of, paged); /* what was missed is still known */
    assert_int_equal(paged_counts(paged).read_pages, before.missed_pages);
    (void)paged_complete(of, paged, &view);
    paged_draw_tree(of, of->whole.tree, &view);
    assert_memory_equal(of->drawn, of->expected, PAGED_BYTES);
    svo_paged_close(&paged);
}

static void test_files_that_change(void **state)
{
    paged_scene shown;
    make_scene(state, 0, &shown);
    const file_bytes file = read_file(path_of(shown.name));
    uint8_t *changed = malloc(file.count);
    assert_non_null(changed);
    memcpy(changed, file.bytes, file.count);
    for (size_t at = file.count / 8; at < file.count; ++at) {
        changed[at] = (uint8_t)~changed[at];
    }
    check_changed(&shown, &file, changed, file.count);
    check_changed(&shown, &file, file.bytes, file.count / 8);
    free(changed);
    free(file.bytes);
    paged_scene_destroy(&shown);
}

/* A file of the same name is not the one that was opened. */
static void test_a_file_that_is_replaced(void **state)
{
    paged_scene shown;
    svo_paged *paged = NULL;
    make_scene(state, 0, &shown);
    const svo_render_options view = paged_view(&shown, SVO_VIEW_SHADED, 0, 1);
    assert_int_equal(open_file(&shown, shown.name, &paged), SVO_OK);
    write_text("other.svo", "another file");
    char other[256];
    (void)snprintf(other, sizeof other, "%s", path_of("other.svo"));
    assert_int_equal(rename(other, path_of(shown.name)), 0);
    (void)paged_complete(&shown, paged, &view);
    paged_draw_tree(&shown, shown.whole.tree, &view);
    assert_memory_equal(shown.drawn, shown.expected, PAGED_BYTES);
    svo_paged_close(&paged);
    paged_scene_destroy(&shown);
}

TEST_GROUP(paged_file)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flipped_bits),
        cmocka_unit_test(test_truncated_files),
        cmocka_unit_test(test_files_that_cannot_be_paged),
        cmocka_unit_test(test_payload_not_on_all_levels),
        cmocka_unit_test(test_files_that_change),
        cmocka_unit_test(test_a_file_that_is_replaced),
    };
    return cmocka_run_group_tests_name("paged_file", tests, fixture_folder_setup, fixture_folder_teardown);
}
