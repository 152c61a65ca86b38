/* SPDX-License-Identifier: MIT */
/*
 * Uploads and results through staging memory, as on devices with memory of their own, of a few KiB here: the same bytes
 * at the same place for sizes around those of its halves, on in-order and out-of-order queues, whether a call waits or
 * not; the same trees. Devices that share the host's memory have none.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/device.h"
#include "core/staging.h"
#include "core/work.h"
#include "scenes.h"
#include "support/counting.h"
#include "support/enqueued.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

#define HALF   4096u
#define LEAST  256u
#define OFFSET 12u
#define MOST   (5u * HALF + 17u)

static const size_t sizes[] = {1,        LEAST - 1,    LEAST,    HALF - 1,     HALF, HALF + 1, 2 * HALF - 1,
                               2 * HALF, 2 * HALF + 1, 3 * HALF, 4 * HALF + 1, MOST};
#define SIZES (sizeof sizes / sizeof sizes[0])

/* Opens a device with staging memory. */
static void open_staged(cl_command_queue_properties properties, fixture *out)
{
    fixture_open_cl(&(fixture_options){.path = SVO_PATH_GPU, .queue_properties = properties}, out);
    assert_int_equal(out->device->staging_bytes, 0); /* PoCL shares the host's memory */
    out->device->staging_bytes = HALF;
    out->device->staged_bytes_min = LEAST;
}

static uint64_t count_parts(size_t bytes)
{
    return bytes < LEAST ? 1 : (bytes + HALF - 1) / HALF;
}

/* Different bytes for each size. */
static void fill(unsigned char *bytes, size_t count, unsigned seed)
{
    for (size_t i = 0; i < count; ++i) {
        bytes[i] = (unsigned char)((i * 2654435761u + seed * 40503u) >> 7);
    }
}

static void compare(const fixture *opened, cl_mem buffer, size_t offset, const unsigned char *expected, size_t bytes)
{
    static unsigned char found[MOST];
    assert_int_equal(clFinish(opened->queue), CL_SUCCESS);
    assert_int_equal(clEnqueueReadBuffer(opened->queue, buffer, CL_TRUE, offset, bytes, found, 0, NULL, NULL),
                     CL_SUCCESS);
    assert_memory_equal(found, expected, bytes);
}

static cl_mem make_buffer(const fixture *opened)
{
    cl_mem made = clCreateBuffer(info_of_device(opened->device).context, CL_MEM_READ_WRITE, MOST + OFFSET, NULL, NULL);
    assert_non_null(made);
    return made;
}

static void write_all_sizes(cl_command_queue_properties properties)
{
    static unsigned char bytes[MOST];
    fixture opened;
    open_staged(properties, &opened);
    cl_mem buffer = make_buffer(&opened);
    for (size_t i = 0; i < SIZES; ++i) {
        fill(bytes, sizes[i], (unsigned)i);
        counting_begin();
        succeed(&opened, svo_i_device_write(opened.device, "test", opened.queue, buffer, OFFSET, bytes, sizes[i]));
        assert_int_equal(counting_read().writes, count_parts(sizes[i]));
        compare(&opened, buffer, OFFSET, bytes, sizes[i]);
    }
    clReleaseMemObject(buffer);
    fixture_close(&opened);
}

static void writes_have_all_bytes(void **state)
{
    (void)state;
    write_all_sizes(0);
    write_all_sizes(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
}

/* Writes that do not wait follow each other through the same halves, and read nothing of the array afterwards, where
   all of them are staged. */
static void writes_that_do_not_wait_have_all_bytes(void **state)
{
    static unsigned char bytes[SIZES][MOST];
    static unsigned char scratch[MOST];
    (void)state;
    fixture opened;
    svo_i_device_work work;
    cl_mem buffers[SIZES];
    open_staged(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &opened);
    succeed(&opened, svo_i_work_begin(opened.device, "test", opened.queue, &work));
    for (size_t i = 2; i < SIZES; ++i) {
        buffers[i] = make_buffer(&opened);
        fill(bytes[i], sizes[i], (unsigned)i);
        memcpy(scratch, bytes[i], sizes[i]);
        succeed(&opened, svo_i_work_write_later(&work, buffers[i], scratch, sizes[i]));
        memset(scratch, 0xa5, sizeof scratch);
    }
    succeed(&opened, svo_i_work_wait(&work));
    for (size_t i = 2; i < SIZES; ++i) {
        compare(&opened, buffers[i], 0, bytes[i], sizes[i]);
        clReleaseMemObject(buffers[i]);
    }
    svo_i_work_end(&work);
    fixture_close(&opened);
}

/* Reads what a write that is not waited for brings. found: has one byte more. Returns the calls. */
static counted write_and_read(const fixture *opened, cl_mem buffer, const unsigned char *bytes, size_t count,
                              unsigned char *found)
{
    cl_event written = NULL;
    assert_int_equal(clEnqueueWriteBuffer(opened->queue, buffer, CL_FALSE, OFFSET, count, bytes, 0, NULL, &written),
                     CL_SUCCESS);
    const svo_i_download_from from = {
        .queue = opened->queue, .buffer = buffer, .offset = OFFSET, .bytes = count, .wait = &written};
    memset(found, 0xa5, count + 1);
    counting_begin();
    assert_int_equal(svo_i_download(opened->device, &from, found), CL_SUCCESS);
    const counted did = counting_read();
    clReleaseEvent(written);
    return did;
}

static void reads_have_all_bytes(void **state)
{
    static unsigned char bytes[MOST];
    static unsigned char found[MOST + 1];
    (void)state;
    fixture opened;
    open_staged(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &opened);
    cl_mem buffer = make_buffer(&opened);
    (void)write_and_read(&opened, buffer, bytes, MOST, found); /* maps the memory */
    for (size_t i = 0; i < SIZES; ++i) {
        fill(bytes, sizes[i], (unsigned)i);
        const counted did = write_and_read(&opened, buffer, bytes, sizes[i], found);
        assert_int_equal(did.waits, count_parts(sizes[i])); /* for parts, or a blocking read */
        assert_int_equal(did.reads, sizes[i] < LEAST ? 1 : 0);
        assert_memory_equal(found, bytes, sizes[i]);
        assert_int_equal(found[sizes[i]], 0xa5);
    }
    clReleaseMemObject(buffer);
    fixture_close(&opened);
}

/* Plans by the host and by kernels, and their builds. */
static void build_hashes(const fixture *opened, const svo_mesh *mesh, char hashes[2][SVO_HASH_TEXT_BYTES])
{
    static const svo_place places[] = {SVO_PLACE_HOST, SVO_PLACE_DEVICE};
    for (unsigned i = 0; i < 2; ++i) {
        svo_plan *plan = make_plan(opened, mesh, 6, (svo_plan_options){.need = SVO_NEED_ALL, .place = places[i]});
        svo_tree *tree = NULL;
        succeed(opened, svo_build(plan, opened->cl, opened->queue, &tree, NULL));
        succeed(opened, svo_tree_download(tree, opened->queue));
        succeed(opened, svo_tree_hash(tree, SVO_HASH_ALL, hashes[i]));
        svo_tree_destroy(&tree);
        svo_plan_destroy(&plan);
    }
}

static void trees_are_the_same(void **state)
{
    char direct[2][SVO_HASH_TEXT_BYTES];
    char staged[2][SVO_HASH_TEXT_BYTES];
    (void)state;
    fixture opened;
    scene *knot = fixture_scene("knot:2000");
    open_staged(0, &opened);
    opened.device->staging_bytes = 0;
    build_hashes(&opened, scene_mesh(knot), direct); /* tests programs */
    counting_begin();
    build_hashes(&opened, scene_mesh(knot), direct);
    const uint64_t writes = counting_read().writes;
    opened.device->staging_bytes = HALF;
    counting_begin();
    build_hashes(&opened, scene_mesh(knot), staged);
    assert_true(counting_read().writes > writes + 20); /* in parts */
    for (unsigned i = 0; i < 2; ++i) {
        assert_string_equal(direct[i], staged[i]);
    }
    scene_destroy(&knot);
    fixture_close(&opened);
}

TEST_GROUP(upload)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(writes_have_all_bytes),
                                       cmocka_unit_test(writes_that_do_not_wait_have_all_bytes),
                                       cmocka_unit_test(reads_have_all_bytes), cmocka_unit_test(trees_are_the_same)};
    return cmocka_run_group_tests_name("upload", tests, NULL, NULL);
}
