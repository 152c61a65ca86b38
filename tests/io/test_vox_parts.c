/* SPDX-License-Identifier: MIT */
/*
 * .vox files by their models: put together by their matrices, they are the list of the file, for all rotations and
 * mirrors below a rotated transform, models without a scene, and real files.
 */
#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/suite.h"
#include "svocl/voxel_files.h"
#include "vox_bytes.h"

static svo_source source_of(const byte_list *file)
{
    return svo_from_memory(file->bytes, file->count, "file.vox");
}

/* Voxels of all parts, where they are placed. */
typedef struct assembled {
    svo_voxel *voxels;
    size_t count, capacity;
    uint64_t parts, instances;
    int64_t last_model;
    uint64_t stop_at; /* the callback ends the reading there; 0: nowhere */
} assembled;

static svo_status assemble(void *user, const svo_voxel_part *part)
{
    assembled *all = user;
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(part->voxels, &info), SVO_OK);
    assert_true(info.voxel_count > 0 && part->transform_count > 0);
    assert_true((int64_t)part->model > all->last_model);
    all->last_model = (int64_t)part->model;
    ++all->parts;
    all->instances += part->transform_count;
    for (uint64_t i = 0; i < part->transform_count * info.voxel_count; ++i) {
        const double *m = part->transforms + 12 * (i / info.voxel_count);
        svo_voxel voxel = svo_voxels_get(part->voxels)[i % info.voxel_count];
        const double middle[3] = {voxel.x + 0.5, voxel.y + 0.5, voxel.z + 0.5};
        int32_t *const place[3] = {&voxel.x, &voxel.y, &voxel.z};
        for (size_t row = 0; row < 3; ++row) {
            const double at = m[4 * row] * middle[0] + m[4 * row + 1] * middle[1] + m[4 * row + 2] * middle[2];
            *place[row] = (int32_t)floor(at + m[4 * row + 3]);
        }
        if (all->count == all->capacity) {
            all->capacity = 2 * all->capacity + 1024;
            all->voxels = realloc(all->voxels, all->capacity * sizeof *all->voxels);
            assert_non_null(all->voxels);
        }
        all->voxels[all->count++] = voxel;
    }
    return all->parts == all->stop_at ? SVO_CANCELED : SVO_OK;
}

/* Compares the parts of a file with its list: places, and colors and materials where no instances overlap. */
static svo_voxel_file_info expect_parts(svo_source file, const svo_voxels_load_options *options)
{
    assembled all = {.last_model = -1};
    svo_message message = {""};
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    svo_voxel_file_info of_list = SVO_VOXEL_FILE_INFO_INIT;
    svo_voxels_info put = SVO_VOXELS_INFO_INIT;
    svo_voxels_info read = SVO_VOXELS_INFO_INIT;
    svo_voxels *list = NULL;
    svo_voxels *again = NULL;
    assert_int_equal(svo_voxels_load(file, options, &list, &of_list, &message), SVO_OK);
    assert_int_equal(svo_voxels_load_parts(file, options, assemble, &all, &info, &message), SVO_OK);
    assert_memory_equal(&info, &of_list, sizeof info);
    assert_int_equal(svo_voxels_get_info(list, &read), SVO_OK);
    const svo_voxels_source source = {.struct_size = sizeof source, .voxels = all.voxels, .voxel_count = all.count};
    assert_int_equal(svo_voxels_create(&source, &again, &message), SVO_OK);
    assert_int_equal(svo_voxels_get_info(again, &put), SVO_OK);
    assert_int_equal(put.voxel_count, read.voxel_count);
    const bool overlap = read.given_count != read.voxel_count;
    for (uint64_t i = 0; i < read.voxel_count; ++i) {
        const svo_voxel *a = svo_voxels_get(list) + i;
        const svo_voxel *b = svo_voxels_get(again) + i;
        assert_memory_equal(a, b, overlap ? 3 * sizeof(int32_t) : sizeof *a);
    }
    svo_voxels_destroy(&list);
    svo_voxels_destroy(&again);
    free(all.voxels);
    return info;
}

/* All 48 rotations and mirrors, below a rotated transform, of models of odd and even sizes. */
static byte_list rotated_scene(void)
{
    const int32_t sizes[2][3] = {{3, 4, 2}, {5, 1, 7}};
    const uint8_t voxels[2][12] = {{0, 0, 0, 1, 2, 3, 1, 2, 1, 0, 1, 3}, {4, 0, 6, 9, 0, 0, 2, 8, 1, 0, 0, 7}};
    const int32_t moved[3] = {-7, 11, 2};
    int32_t children[96];
    size_t count = 0;
    byte_list chunks = {NULL, 0, 0};
    for (int i = 0; i < 2; ++i) {
        vox_put_model(&chunks, sizes[i], voxels[i], 3);
    }
    vox_put_transform(&chunks, 0, 1, -1, 2 | 0 << 2 | 5 << 4, moved);
    for (int byte = 0; byte < 128; ++byte) {
        const int first = byte & 3;
        const int second = byte >> 2 & 3;
        if (first > 2 || second > 2 || first == second) {
            continue;
        }
        for (int model = 0; model < 2; ++model) {
            const int32_t at[3] = {(int32_t)(20 * (count % 10)), (int32_t)(20 * (count / 10)), 3 * byte};
            children[count] = (int32_t)(2 + 2 * count);
            vox_put_transform(&chunks, children[count], children[count] + 1, -1, byte, at);
            vox_put_shape(&chunks, children[count] + 1, model);
            ++count;
        }
    }
    vox_put_group(&chunks, 1, children, count);
    return vox_file(200, &chunks);
}

static void test_parts_are_the_list(void **state)
{
    (void)state;
    byte_list file = rotated_scene();
    const svo_voxel_file_info info = expect_parts(source_of(&file), NULL);
    assert_int_equal(info.instances, 96);
    const svo_voxels_load_options as_is = {.struct_size = sizeof as_is, .axes = SVO_AXES_KEEP};
    expect_parts(source_of(&file), &as_is);
    assembled all = {.last_model = -1, .stop_at = 1};
    svo_message message;
    assert_int_equal(svo_voxels_load_parts(source_of(&file), NULL, assemble, &all, NULL, &message), SVO_CANCELED);
    assert_non_null(strstr(message.text, "the callback ended the reading at model 0"));
    assert_int_equal(svo_voxels_load_parts(source_of(&file), NULL, NULL, NULL, NULL, &message), SVO_INVALID_ARGUMENT);
    free(all.voxels);
    bytes_free(&file);
}

static void test_parts_of_models_without_a_scene(void **state)
{
    (void)state;
    const int32_t size[3] = {5, 4, 3};
    const uint8_t voxels[8] = {4, 0, 1, 7, 0, 3, 2, 9};
    byte_list chunks = {NULL, 0, 0};
    vox_put_model(&chunks, size, voxels, 1);
    vox_put_model(&chunks, size, voxels, 2);
    byte_list file = vox_file(150, &chunks);
    const svo_voxels_load_options second = {.struct_size = sizeof second, .frame = 1};
    expect_parts(source_of(&file), NULL);
    expect_parts(source_of(&file), &second);
    bytes_free(&file);
}

static void test_parts_of_real_files(void **state)
{
    (void)state;
    DIR *folder = opendir(SHARED_SCENES "/vox");
    uint64_t instances = 0;
    if (folder == NULL) {
        skip();
    }
    for (const struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
        char path[1024];
        (void)snprintf(path, sizeof path, "%s/vox/%s", SHARED_SCENES, entry->d_name);
        if (svo_voxel_format_of_path(path) == SVO_VOXEL_FORMAT_VOX) {
            instances += expect_parts(svo_from_path(path), NULL).instances;
        }
    }
    (void)closedir(folder);
    assert_true(instances > 20);
}

TEST_GROUP(vox_parts)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_are_the_list),
        cmocka_unit_test(test_parts_of_models_without_a_scene),
        cmocka_unit_test(test_parts_of_real_files),
    };
    return cmocka_run_group_tests_name("vox_parts", tests, NULL, NULL);
}
