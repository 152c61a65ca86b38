/* SPDX-License-Identifier: MIT */
/*
 * Plans from meshes in OpenCL buffers: packed, interleaved at odd offsets, with either width of indices. They equal
 * the plan of the same mesh on the host, and of the mesh no byte crosses to the host, in plans and in builds.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "plan_compare.h"
#include "support/attributed_mesh.h"
#include "support/counting.h"
#include "support/fixture.h"
#include "support/info_of.h"
#include "support/suite.h"

enum { TRIANGLES = 3000, DEPTH = 6 };

/* Totals, a byte per material, the first triangle's record; counters and the head of a tree. */
#define READ_BYTES_MAX 2048

/* A mesh with every attribute, on the host in floats and in buffers. */
typedef struct subject {
    fixture opened;
    attributed_mesh made;
    float *positions;
    svo_mesh mesh;
    svo_mesh_buffers buffers;
} subject;

static cl_mem buffer_of(const fixture *opened, const void *bytes, size_t count)
{
    cl_int error = CL_SUCCESS;
    const cl_mem buffer =
        clCreateBuffer(info_of_device(opened->device).context, CL_MEM_READ_WRITE, count + 1, NULL, &error);
    assert_int_equal(error, CL_SUCCESS);
    if (count > 0) {
        error = clEnqueueWriteBuffer(opened->queue, buffer, CL_TRUE, 0, count, bytes, 0, NULL, NULL);
    }
    assert_int_equal(error, CL_SUCCESS);
    return buffer;
}

/* Element i lies at offset + i * stride. */
static svo_mesh_view view_of(const fixture *opened, const void *elements, size_t count, size_t element_bytes,
                             size_t offset, size_t gap)
{
    const size_t stride = element_bytes + gap;
    unsigned char *bytes = malloc(offset + count * stride + 1);
    assert_non_null(bytes);
    memset(bytes, 0xee, offset + count * stride + 1);
    for (size_t i = 0; i < count; ++i) {
        memcpy(bytes + offset + i * stride, (const unsigned char *)elements + i * element_bytes, element_bytes);
    }
    const svo_mesh_view view = {.memory = buffer_of(opened, bytes, offset + count * stride),
                                .offset_bytes = offset,
                                .stride_bytes = gap != 0 ? stride : 0};
    free(bytes);
    return view;
}

/* gap, offset: 0 for packed arrays. index_bytes: 2 or 4. */
static void open_subject(void **state, size_t triangles, size_t offset, size_t gap, uint32_t index_bytes, subject *out)
{
    *out = (subject){.opened = fixture_cl_of_group(state)};
    attributed_mesh_create(triangles, triangles, 0.2, &out->made);
    svo_mesh *mesh = &out->mesh;
    *mesh = out->made.mesh;
    mesh->struct_size = sizeof *mesh;
    const size_t vertices = mesh->vertex_count;
    out->positions = malloc((vertices * 3 + 1) * sizeof *out->positions);
    uint16_t *narrow = malloc((triangles * 3 + 1) * sizeof *narrow);
    assert_true(out->positions != NULL && narrow != NULL && vertices < 65536);
    for (size_t i = 0; i < vertices * 3; ++i) {
        out->positions[i] = (float)mesh->positions_double[i];
    }
    for (size_t i = 0; i < triangles * 3; ++i) {
        narrow[i] = (uint16_t)mesh->indices[i];
    }
    mesh->positions = out->positions;
    mesh->positions_double = NULL;
    const fixture *opened = &out->opened;
    const void *indices = index_bytes == 2 ? (const void *)narrow : mesh->indices;
    out->buffers =
        (svo_mesh_buffers){.struct_size = sizeof out->buffers,
                           .vertex_count = vertices,
                           .triangle_count = triangles,
                           .positions = view_of(opened, mesh->positions, vertices, 12, offset, gap),
                           .indices = view_of(opened, indices, triangles * 3, index_bytes, offset, gap),
                           .index_bytes = index_bytes,
                           .normals = view_of(opened, mesh->normals, vertices, 12, offset, gap),
                           .colors = view_of(opened, mesh->colors, vertices, 4, offset, gap),
                           .uvs = view_of(opened, mesh->uvs, vertices, 8, offset, gap),
                           .triangle_materials = view_of(opened, mesh->triangle_materials, triangles, 2, offset, gap),
                           .materials = mesh->materials,
                           .material_count = mesh->material_count,
                           .textures = mesh->textures,
                           .texture_count = mesh->texture_count};
    free(narrow);
}

static void close_subject(subject *of)
{
    const svo_mesh_view *views[] = {&of->buffers.positions, &of->buffers.indices, &of->buffers.normals,
                                    &of->buffers.colors,    &of->buffers.uvs,     &of->buffers.triangle_materials};
    for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i) {
        clReleaseMemObject(views[i]->memory);
    }
    free(of->positions);
    attributed_mesh_destroy(&of->made);
}

static svo_plan *plan_of(const subject *of, const svo_plan_options *options, svo_place place)
{
    svo_plan_options placed = *options;
    svo_plan *plan = NULL;
    placed.struct_size = sizeof placed;
    placed.place = place;
    const svo_status status = place == SVO_PLACE_HOST
                                  ? svo_plan_create(of->opened.device, &of->mesh, DEPTH, &placed, &plan)
                                  : svo_plan_create_from_buffers(of->opened.device, &of->buffers, DEPTH, &placed,
                                                                 of->opened.queue, 0, NULL, &plan);
    if (status != SVO_OK) {
        fail_msg("%s", svo_device_message(of->opened.device));
        return NULL;
    }
    return plan;
}

static void buffers_give_the_plan_of_the_host(void **state)
{
    static const struct {
        size_t triangles, offset, gap;
        uint32_t index_bytes;
    } layouts[] = {{TRIANGLES, 0, 0, 4},   {TRIANGLES, 0, 0, 2}, {TRIANGLES, 6, 5, 2},
                   {TRIANGLES, 16, 12, 4}, {1, 1, 0, 4},         {0, 0, 0, 4}};
    static const uint32_t needs[] = {SVO_NEED_NONE, SVO_NEED_DEFAULT, SVO_NEED_ALL};
    for (size_t i = 0; i < sizeof layouts / sizeof layouts[0]; ++i) {
        subject of;
        open_subject(state, layouts[i].triangles, layouts[i].offset, layouts[i].gap, layouts[i].index_bytes, &of);
        for (size_t n = 0; n < sizeof needs / sizeof needs[0]; ++n) {
            const svo_plan_options options = {.need = needs[n], .edge = 1.0};
            svo_plan *host = plan_of(&of, &options, SVO_PLACE_HOST);
            svo_plan *device = plan_of(&of, &options, SVO_PLACE_DEVICE);
            plan_compare(host, device);
            svo_plan_destroy(&host);
            svo_plan_destroy(&device);
        }
        close_subject(&of);
    }
}

/* The list fits one chunk, as usual. Large triangles are the front end's, and read for its tiles. */
static void no_byte_of_the_mesh_crosses_to_the_host(void **state)
{
    const svo_plan_options options = {.need = SVO_NEED_ALL, .edge = 1.0};
    subject of;
    open_subject(state, TRIANGLES, 0, 0, 4, &of);
    of.opened.device->tests_programs = false; /* which reads answers */
    counting_begin();
    svo_plan *plan = plan_of(&of, &options, SVO_PLACE_DEVICE);
    const uint64_t large_bytes = plan->large_count * sizeof(svo_large_item);
    assert_in_range(counting_read().read_bytes, large_bytes + 1, large_bytes + READ_BYTES_MAX);
    svo_tree *tree = NULL;
    assert_int_equal(svo_build(plan, of.opened.cl, of.opened.queue, &tree, NULL), SVO_OK);
    assert_in_range(counting_read().read_bytes, large_bytes + 1, large_bytes + 2 * READ_BYTES_MAX);
    assert_null(plan->vertices);
    assert_null(plan->indices);
    assert_null(plan->items);
    assert_null(plan->records);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    of.opened.device->tests_programs = true;
    close_subject(&of);
}

/* The mesh is written by a command that waits for the caller. */
static void plans_wait_for_the_events_given(void **state)
{
    const svo_plan_options options = {.need = SVO_NEED_NONE, .edge = 1.0};
    subject of;
    open_subject(state, TRIANGLES, 0, 0, 4, &of);
    cl_int error = CL_SUCCESS;
    const float beyond = 3.0F;
    const size_t bytes = of.mesh.vertex_count * 12;
    cl_event written = NULL;
    assert_int_equal(clEnqueueFillBuffer(of.opened.queue, of.buffers.positions.memory, &beyond, sizeof beyond, 0, bytes,
                                         0, NULL, NULL),
                     CL_SUCCESS);
    cl_command_queue other =
        clCreateCommandQueue(info_of_device(of.opened.device).context, info_of_device(of.opened.device).device,
                             CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &error);
    assert_int_equal(error, CL_SUCCESS);
    clFinish(of.opened.queue);
    assert_int_equal(clEnqueueWriteBuffer(of.opened.queue, of.buffers.positions.memory, CL_FALSE, 0, bytes,
                                          of.positions, 0, NULL, &written),
                     CL_SUCCESS);
    svo_plan *host = plan_of(&of, &options, SVO_PLACE_HOST);
    svo_plan *device = NULL;
    svo_plan_options sized = options;
    sized.struct_size = sizeof sized;
    assert_int_equal(
        svo_plan_create_from_buffers(of.opened.device, &of.buffers, DEPTH, &sized, other, 1, &written, &device),
        SVO_OK);
    plan_compare(host, device);
    svo_plan_destroy(&host);
    svo_plan_destroy(&device);
    clReleaseEvent(written);
    clReleaseCommandQueue(other);
    close_subject(&of);
}

static void expect_refusal(const subject *of, const svo_mesh_buffers *buffers, const svo_plan_options *options,
                           const char *text)
{
    svo_plan *plan = NULL;
    assert_int_equal(svo_plan_create_from_buffers(of->opened.device, buffers, DEPTH, options, NULL, 0, NULL, &plan),
                     SVO_INVALID_ARGUMENT);
    assert_null(plan);
    if (strstr(svo_device_message(of->opened.device), text) == NULL) {
        fail_msg("'%s' is not in: %s", text, svo_device_message(of->opened.device));
    }
}

static void wrong_buffers_are_refused(void **state)
{
    subject of;
    open_subject(state, 100, 0, 0, 4, &of);
    svo_mesh_buffers wrong = of.buffers;
    svo_plan_options host = SVO_PLAN_OPTIONS_INIT;
    host.place = SVO_PLACE_HOST;
    wrong.positions.memory = NULL;
    expect_refusal(&of, &wrong, NULL, "svo_plan_create_from_buffers: buffers.positions names no buffer");
    wrong = of.buffers;
    wrong.normals.offset_bytes = 16;
    expect_refusal(&of, &wrong, NULL, "svo_plan_create_from_buffers: normals ends at byte");
    wrong = of.buffers;
    wrong.uvs.stride_bytes = 7;
    expect_refusal(&of, &wrong, NULL, "svo_plan_create_from_buffers: uvs.stride_bytes 7 is below the 8");
    wrong = of.buffers;
    wrong.index_bytes = 3;
    expect_refusal(&of, &wrong, NULL, "svo_plan_create_from_buffers: buffers.index_bytes 3");
    expect_refusal(&of, &of.buffers, &host, "svo_plan_create_from_buffers: options.place is host");
    expect_refusal(&of, NULL, NULL, "svo_plan_create_from_buffers: buffers is NULL");
    close_subject(&of);
}

TEST_GROUP(plan_buffers)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(buffers_give_the_plan_of_the_host),
        cmocka_unit_test(no_byte_of_the_mesh_crosses_to_the_host),
        cmocka_unit_test(plans_wait_for_the_events_given),
        cmocka_unit_test(wrong_buffers_are_refused),
    };
    return cmocka_run_group_tests_name("plan_buffers", tests, fixture_group_setup, fixture_group_teardown);
}
