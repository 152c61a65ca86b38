/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary arrays as a mesh, with arbitrary options, for svo_plan_create, and chunkings of the plan. The
 * result is either a status with a one-line message, or a plan that keeps plan.h's guarantees: every triangle is kept,
 * refused or outside as defined there, rounded like the reference, and in a class whose arithmetic can represent it.
 * OpenCL is not used: a plan needs only the device's message buffer.
 */
#include <math.h>
#include <string.h>

#include "fuzz.h"
#include "mesh_input.h"
#include "mesh_layout.h"
#include "oracle.h"
#include "plan/estimate.h"
#include "plan/grid.h"

#define UNITS_MAX (1 << 29) /* the limit of the arithmetic */
#define UNITS_FAR (1 << 30) /* beyond it */

static void check_refusal(svo_status status, const svo_plan *plan, const svo_device *device)
{
    static const char prefix[] = "svo_plan_create: ";
    REQUIRE(status == SVO_INVALID_ARGUMENT || status == SVO_OUT_OF_HOST_MEMORY || status == SVO_OUT_OF_DEVICE_MEMORY);
    REQUIRE(plan == NULL);
    REQUIRE(strncmp(device->message.text, prefix, strlen(prefix)) == 0);
    REQUIRE(strchr(device->message.text, '\n') == NULL);
}

/* Compares the grid with the reference where doubles are normal; below that range the definition does not apply. */
static void check_grid(const svo_plan *plan, const mesh_input *input, const oracle_positions *positions)
{
    const svo_plan_info *info = &plan->info;
    const svo_plan_options *options = &plan->options;
    oracle_grid grid;
    const bool known = options->edge > 0.0 ? oracle_grid_given(options->origin, options->edge, info->snap_bits, &grid)
                                           : oracle_grid_fit(positions, info->snap_bits, &grid);
    REQUIRE(isfinite(info->edge) && info->edge > 0.0 && isfinite(info->scale) && info->scale > 0.0);
    REQUIRE(info->triangles == input->mesh.triangle_count);
    if (known) {
        REQUIRE(info->edge == grid.edge && info->scale == grid.scale);
        for (unsigned axis = 0; axis < 3; ++axis) {
            REQUIRE(info->origin[axis] == grid.origin[axis] &&
                    !(info->origin[axis] == 0.0 && signbit(info->origin[axis])));
        }
    }
}

typedef enum fate { FATE_REFUSED, FATE_OUTSIDE, FATE_KEPT } fate;

/* The reference's coordinate; UNITS_FAR with its sign beyond the limit. */
static int32_t snap_coordinate(const svo_plan_info *info, double value, unsigned axis)
{
    const oracle_grid grid = {
        {info->origin[0], info->origin[1], info->origin[2]}, info->edge, info->scale, info->snap_bits};
    double position[3] = {info->origin[0], info->origin[1], info->origin[2]};
    int32_t snapped[3];
    position[axis] = value;
    return oracle_snap(&grid, position, snapped) ? snapped[axis] : value > info->origin[axis] ? UNITS_FAR : -UNITS_FAR;
}

/* Classifies a triangle by the definition; corners and snapped are set if it is accepted. */
static fate judge(const svo_plan *plan, const oracle_positions *positions, size_t triangle, uint32_t corners[3],
                  int32_t snapped[9])
{
    const svo_plan_info *info = &plan->info;
    const int32_t end = (int32_t)(1u << info->snap_bits) + (info->coverage == SVO_COVERAGE_CLOSED ? 1 : 0);
    if (!oracle_triangle_accepted(positions, triangle, corners)) {
        return FATE_REFUSED;
    }
    bool outside = false;
    bool far = false;
    for (unsigned axis = 0; axis < 3; ++axis) {
        int32_t low = INT32_MAX;
        int32_t high = INT32_MIN;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t q = snap_coordinate(info, positions->positions[(size_t)corners[corner] * 3 + axis], axis);
            snapped[corner * 3 + axis] = q;
            low = q < low ? q : low;
            high = q > high ? q : high;
        }
        outside = outside || high < 0 || low >= end;
        far = far || low <= -UNITS_MAX || high >= UNITS_MAX;
    }
    return outside ? FATE_OUTSIDE : far ? FATE_REFUSED : FATE_KEPT;
}

/* Compares the plan's corners of a kept triangle with the definition. */
static void check_corners(const svo_plan *plan, uint32_t kept, const uint32_t corners[3], const int32_t snapped[9])
{
    for (unsigned corner = 0; corner < 3; ++corner) {
        REQUIRE(plan->indices[(size_t)kept * 3 + corner] == corners[corner]);
        const int32_t *vertex = plan->vertices + (size_t)corners[corner] * 3;
        REQUIRE(memcmp(vertex, snapped + corner * 3, 3 * sizeof *vertex) == 0);
    }
}

static void check_triangles(const svo_plan *plan, const mesh_input *input, const oracle_positions *positions)
{
    uint64_t refused = 0;
    uint64_t outside = 0;
    uint32_t kept = 0;
    for (size_t t = 0; t < input->mesh.triangle_count; ++t) {
        uint32_t corners[3];
        int32_t snapped[9];
        const fate decided = judge(plan, positions, t, corners, snapped);
        refused += decided == FATE_REFUSED;
        outside += decided == FATE_OUTSIDE;
        if (decided == FATE_KEPT) {
            REQUIRE(kept < plan->triangle_count && plan->triangle_ids[kept] == t);
            check_corners(plan, kept, corners, snapped);
            ++kept;
        }
    }
    REQUIRE(plan->triangle_count == kept);
    REQUIRE(plan->info.refused_triangles == refused && plan->info.outside_triangles == outside);
}

/* The class's arithmetic can represent the triangle, and classes for the inside hold no triangle that reaches out. */
static void check_class(const svo_plan *plan, uint32_t triangle, svo_i_class class_id)
{
    const int32_t units = (int32_t)(1u << plan->info.snap_bits);
    const int32_t closed = plan->info.coverage == SVO_COVERAGE_CLOSED ? 1 : 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        int32_t low = INT32_MAX;
        int32_t high = INT32_MIN;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t q = plan->vertices[(size_t)plan->indices[(size_t)triangle * 3 + corner] * 3 + axis];
            low = q < low ? q : low;
            high = q > high ? q : high;
        }
        REQUIRE(low > -UNITS_MAX && high < UNITS_MAX && high >= 0 && low < units + closed);
        const bool inside = low >= 0 && high < units;
        const int32_t first = (low < closed ? 0 : low - closed) >> plan->voxel_log2;
        const int32_t last = high >> plan->voxel_log2;
        REQUIRE(class_id != SVO_I_CLASS_POINT || (inside && first == last));
        REQUIRE(class_id != SVO_I_CLASS_NARROW || (inside && last - first < SVO_NARROW_VOXELS));
        REQUIRE(class_id != SVO_I_CLASS_REGULAR || (inside && plan->info.snap_bits <= SVO_REGULAR_BITS));
    }
}

/* A triangle not drawn as its bounding rectangle lies inside the grid and is not steeper than its axis allows. */
static void check_flags(const svo_plan *plan, const svo_draw_item *item)
{
    const uint32_t *corners = plan->indices + (size_t)item->triangle * 3;
    const uint32_t axis = item->flags & SVO_DRAW_AXIS_MASK;
    REQUIRE(axis < 3 && (item->flags & ~(SVO_DRAW_AXIS_MASK | SVO_DRAW_BOUNDS)) == 0);
    int64_t normal[3];
    svo_i_plan_normal(plan, corners, normal);
    for (unsigned other = 0; other < 3; ++other) {
        REQUIRE(llabs(normal[other]) <= INT64_C(1) << 61);
        if ((item->flags & SVO_DRAW_BOUNDS) == 0) {
            REQUIRE(normal[axis] != 0 && llabs(normal[other]) <= llabs(normal[axis]));
        }
    }
    for (size_t i = 0; i < 9 && (item->flags & SVO_DRAW_BOUNDS) == 0; ++i) {
        const int32_t q = plan->vertices[(size_t)corners[i / 3] * 3 + i % 3];
        REQUIRE(q >= 0 && q < (int32_t)(1u << plan->info.snap_bits));
    }
}

/* Every kept triangle is exactly one item. */
static void check_items(const svo_plan *plan)
{
    uint8_t *seen = calloc((size_t)plan->triangle_count + 1, 1);
    REQUIRE(seen != NULL);
    REQUIRE(plan->class_begin[0] == 0 && plan->class_begin[SVO_I_CLASS_COUNT] == plan->triangle_count);
    double expected = 0.0;
    for (unsigned class_id = 0; class_id < SVO_I_CLASS_COUNT; ++class_id) {
        REQUIRE(plan->class_begin[class_id] <= plan->class_begin[class_id + 1]);
        for (uint32_t i = plan->class_begin[class_id]; i < plan->class_begin[class_id + 1]; ++i) {
            const svo_draw_item *item = &plan->items[i];
            REQUIRE(item->triangle < plan->triangle_count && !seen[item->triangle]);
            seen[item->triangle] = 1;
            check_class(plan, item->triangle, (svo_i_class)class_id);
            check_flags(plan, item);
            REQUIRE(plan->item_fragments[i] >= 1.0F && isfinite(plan->item_fragments[i]));
            expected += (double)plan->item_fragments[i];
        }
    }
    REQUIRE(fabs(plan->info.expected_fragments - expected) <= 1e-5 * expected);
    free(seen);
}

static void check_payload(const svo_plan *plan, const mesh_input *input)
{
    REQUIRE((plan->info.need & ~(uint32_t)SVO_NEED_ALL) == 0);
    REQUIRE((plan->info.need & SVO_I_NEED_PAYLOAD) == 0 || (plan->records != NULL && plan->material_count >= 1));
    REQUIRE(plan->records == NULL || plan->weight_log2 > SVO_I_FILL_LOG2);
    for (uint32_t t = 0; t < plan->triangle_count && plan->records != NULL; ++t) {
        REQUIRE(plan->records[t].material < plan->material_count);
        REQUIRE(plan->records[t].stretch >= 1u << 30 && plan->records[t].stretch < 1u << 31);
    }
    for (uint32_t i = 0; i < plan->material_count && plan->materials != NULL; ++i) {
        const svo_material_record *material = &plan->materials[i];
        REQUIRE(material->texel_offset + (uint64_t)material->width * material->height <= plan->texel_count);
    }
    for (size_t i = 0; plan->normals != NULL && i < input->mesh.vertex_count * 4; ++i) {
        REQUIRE(plan->normals[i] >= -32767);
    }
}

/* No size wraps around, and the peak covers every buffer. */
static void check_buffers(const svo_plan *plan)
{
    const uint64_t capacity = plan->options.fragment_capacity;
    const uint64_t asked = plan->options.chunk_bytes;
    const uint64_t largest_chunk =
        asked != 0 && asked < plan->device->max_allocation_bytes ? asked : plan->device->max_allocation_bytes;
    const uint64_t most = largest_chunk / svo_i_plan_fragment_bytes(plan); /* fragments of one chunk */
    uint64_t largest = 0;
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    REQUIRE(svo_plan_get_info(plan, &info) == SVO_OK);
    const size_t count = info.buffer_count;
    for (size_t i = 0; i < count; ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        REQUIRE(svo_plan_get_buffer(plan, i, &buffer) == SVO_OK && buffer.name != NULL && buffer.count > 0);
        const uint64_t bytes = buffer.bytes / buffer.count; /* buffers of one name need not all live at the same time */
        largest = bytes > largest ? bytes : largest;
        const uint64_t room = buffer.bytes / svo_i_plan_fragment_bytes(plan);
        REQUIRE(strcmp(buffer.name, "fragments") != 0 || buffer.count > 1 || room >= capacity || room >= most);
    }
    REQUIRE(count > 0 && count < SVO_I_BUFFERS_MAX && info.peak_bytes >= largest);
    REQUIRE(svo_i_plan_inner_nodes(plan, UINT32_MAX, false) <= svo_i_plan_inner_nodes(plan, UINT32_MAX, true));
}

static void check_plan(const svo_plan *plan, const mesh_input *input)
{
    const size_t coordinates = input->mesh.vertex_count * 3;
    double *positions = malloc((coordinates + 1) * sizeof *positions);
    REQUIRE(positions != NULL);
    for (size_t i = 0; i < coordinates; ++i) {
        positions[i] = mesh_input_coordinate(input, i / 3, (unsigned)(i % 3));
    }
    const oracle_positions mesh = {positions, input->mesh.vertex_count, input->mesh.indices,
                                   input->mesh.triangle_count};
    check_grid(plan, input, &mesh);
    check_triangles(plan, input, &mesh);
    free(positions);
    check_items(plan);
    check_payload(plan, input);
    check_buffers(plan);
    check_layouts(plan, input->chunk_bytes, input->seed);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    mesh_input input;
    svo_device device;
    svo_plan *plan = NULL;
    mesh_input_read(&input, data, byte_count);
    memset(&device, 0, sizeof device);
    device.slot_bytes = 128; /* of which sizes are multiples */
    const svo_status status =
        svo_plan_create(&device, &input.mesh, input.depth, input.options_given ? &input.options : NULL, &plan);
    if (status != SVO_OK) {
        check_refusal(status, plan, &device);
    } else {
        check_plan(plan, &input);
    }
    svo_plan_destroy(&plan);
    mesh_input_free(&input);
    return 0;
}
