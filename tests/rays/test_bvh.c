/* SPDX-License-Identifier: MIT */
/*
 * The BVH that rays traverse, as the device makes it: against the reference on the host, node by node; what a BVH must
 * hold, in both qualities and after refits; bytes that depend neither on the device's chunks nor on its threads; and
 * meshes that are hard to split.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "bvh_reference.h"
#include "core/device.h"
#include "rays/bvh_device.h"
#include "rays/bvh_fit.h"
#include "scenes.h"
#include "support/fixture.h"
#include "support/suite.h"
#include "svocl/svocl.h"

#define SNAP_BITS 20
#define WIDTH     (1 << SNAP_BITS)

static svo_device *device;

static int open_device(void **state)
{
    svo_message message;
    const svo_device_options options = {.struct_size = sizeof options, .path = fixture_path()};
    (void)state;
    return svo_device_create_default(&options, &device, &message) == SVO_OK ? 0 : -1;
}

static int close_device(void **state)
{
    (void)state;
    svo_device_destroy(&device);
    return 0;
}

/* ---- meshes ---- */

typedef struct soup {
    uint32_t triangle_count;
    int32_t *vertices; /* three per triangle */
    float *floats; /* what leaves hold of them: something else */
    double *doubles; /* NULL: floats alone */
    uint32_t *indices, *triangle_ids;
    uint32_t *list; /* NULL: all triangles lie inside the grid */
    uint32_t list_count;
} soup;

static uint64_t next_random(uint64_t *random)
{
    *random = *random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return *random >> 33;
}

static int32_t between(uint64_t *random, int32_t low, int32_t high)
{
    return low + (int32_t)(next_random(random) % (uint64_t)(high - low + 1));
}

static soup make_soup(uint32_t triangle_count)
{
    soup made = {.triangle_count = triangle_count};
    made.vertices = calloc((size_t)triangle_count * 9 + 1, sizeof *made.vertices);
    made.floats = calloc((size_t)triangle_count * 9 + 1, sizeof *made.floats);
    made.indices = calloc((size_t)triangle_count * 3 + 1, sizeof *made.indices);
    made.triangle_ids = calloc((size_t)triangle_count + 1, sizeof *made.triangle_ids);
    if (made.vertices == NULL || made.floats == NULL || made.indices == NULL || made.triangle_ids == NULL) {
        abort(); /* no memory */
    }
    for (uint32_t i = 0; i < triangle_count * 3; ++i) {
        made.indices[i] = i;
        made.triangle_ids[i / 3] = 2 * (i / 3) + 5;
    }
    for (uint32_t i = 0; i < triangle_count * 9; ++i) {
        made.floats[i] = (float)i * 0.75F;
    }
    return made;
}

/* Leaves of the soup hold doubles too. */
static void give_doubles(soup *to)
{
    to->doubles = calloc((size_t)to->triangle_count * 9 + 1, sizeof *to->doubles);
    assert_non_null(to->doubles);
    for (uint32_t i = 0; i < to->triangle_count * 9; ++i) {
        to->doubles[i] = (double)i / 3;
    }
}

static void free_soup(soup *made)
{
    free(made->vertices);
    free(made->floats);
    free(made->doubles);
    free(made->indices);
    free(made->triangle_ids);
    free(made->list);
}

/* Triangles of that size anywhere in a cube of the grid. */
static soup random_soup(uint32_t triangle_count, int32_t reach, int32_t size, uint64_t seed)
{
    soup made = make_soup(triangle_count);
    for (uint32_t i = 0; i < triangle_count; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            const int32_t at = between(&seed, 0, reach - size);
            for (int corner = 0; corner < 3; ++corner) {
                made.vertices[9 * (size_t)i + (size_t)(3 * corner + axis)] = at + between(&seed, 0, size - 1);
            }
        }
    }
    return made;
}

/* All in one place. */
static soup coincident_soup(uint32_t triangle_count)
{
    soup made = make_soup(triangle_count);
    for (uint32_t i = 0; i < triangle_count * 9; ++i) {
        made.vertices[i] = (int32_t)(1000 + i % 9 * 77);
    }
    return made;
}

/* Each half the size of the one before, about one corner: a split by area takes off one at a time. */
static soup shrinking_soup(uint32_t triangle_count)
{
    soup made = make_soup(triangle_count);
    for (uint32_t i = 0; i < triangle_count; ++i) {
        const int32_t size = WIDTH >> (i % 20);
        const int32_t corners[9] = {0, 0, 0, size - 1, 0, 0, 0, size - 1, size - 1};
        memcpy(made.vertices + 9 * (size_t)i, corners, sizeof corners);
    }
    return made;
}

/* Some reach out of the grid and some are beside it; the list has those that meet it, some of them twice. */
static soup leaving_soup(uint32_t triangle_count, uint64_t seed)
{
    soup made = random_soup(triangle_count, WIDTH, WIDTH / 16, seed);
    made.list = calloc((size_t)triangle_count * 2, sizeof *made.list);
    assert_non_null(made.list);
    for (uint32_t i = 0; i < triangle_count; ++i) {
        int32_t *corners = made.vertices + 9 * (size_t)i;
        const int32_t shift = i % 3 == 0 ? WIDTH : 0;
        corners[0] += i % 5 == 0 ? 3 * WIDTH : 0;
        for (int k = 0; k < 9; k += 3) {
            corners[k + 1] -= shift;
        }
        if (corners[1] >= 0 || corners[4] >= 0 || corners[7] >= 0) {
            made.list[made.list_count++] = i;
            if (i % 4 == 0) {
                made.list[made.list_count++] = i;
            }
        }
    }
    return made;
}

/* A procedural scene on a grid that fits it. */
static soup scene_soup(const char *name)
{
    svo_message message;
    scene *made = NULL;
    assert_int_equal(scene_create(name, &made, &message), SVO_OK);
    const svo_mesh *mesh = scene_mesh(made);
    float low[3] = {0};
    float edge = 0;
    for (int axis = 0; axis < 3; ++axis) {
        float high = low[axis] = mesh->positions[axis];
        for (size_t i = (size_t)axis; i < (size_t)mesh->vertex_count * 3; i += 3) {
            low[axis] = mesh->positions[i] < low[axis] ? mesh->positions[i] : low[axis];
            high = mesh->positions[i] > high ? mesh->positions[i] : high;
        }
        edge = high - low[axis] > edge ? high - low[axis] : edge;
    }
    soup out = make_soup((uint32_t)mesh->triangle_count);
    for (size_t i = 0; i < (size_t)out.triangle_count * 3; ++i) {
        for (size_t axis = 0; axis < 3; ++axis) {
            const float at = mesh->positions[3 * (size_t)mesh->indices[i] + axis] - low[axis];
            out.vertices[3 * i + axis] = (int32_t)(at / edge * (float)(WIDTH - 1));
        }
    }
    scene_destroy(&made);
    return out;
}

/* ---- BVHs of the device, on the host ---- */

typedef struct placed {
    cl_mem buffers[6];
    svo_i_bvh_mesh mesh;
} placed;

static cl_mem to_device(const void *data, size_t bytes)
{
    cl_int error = CL_SUCCESS;
    uint32_t none = 0;
    const cl_mem made = clCreateBuffer(device->context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, bytes > 0 ? bytes : 4,
                                       bytes > 0 ? (void *)(uintptr_t)data : &none, &error);
    assert_int_equal(error, CL_SUCCESS);
    return made;
}

static placed place(const soup *from)
{
    const size_t count = from->triangle_count;
    placed out = {.buffers = {to_device(from->vertices, count * 36), to_device(from->indices, count * 12),
                              to_device(from->triangle_ids, count * 4), to_device(from->list, from->list_count * 4),
                              to_device(from->floats, count * 36),
                              from->doubles != NULL ? to_device(from->doubles, count * 72) : NULL}};
    out.mesh = (svo_i_bvh_mesh){.vertices = out.buffers[0],
                                .indices = out.buffers[1],
                                .triangle_ids = out.buffers[2],
                                .list = out.buffers[3],
                                .floats = out.buffers[4],
                                .doubles = out.buffers[5],
                                .vertex_count = count * 3,
                                .list_count = from->list_count,
                                .triangle_count = from->triangle_count,
                                .snap_bits = SNAP_BITS};
    return out;
}

static void take_away(placed *of)
{
    for (int i = 0; i < 6; ++i) {
        if (of->buffers[i] != NULL) {
            clReleaseMemObject(of->buffers[i]);
        }
    }
}

static void *from_device(cl_mem buffer, size_t bytes)
{
    cl_command_queue queue = NULL;
    void *to = malloc(bytes);
    assert_non_null(to);
    assert_int_equal(svo_i_device_queue(device, "test_bvh", NULL, &queue), SVO_OK);
    assert_int_equal(clEnqueueReadBuffer(queue, buffer, CL_TRUE, 0, bytes, to, 0, NULL, NULL), CL_SUCCESS);
    return to;
}

static bvh read_back(const svo_i_device_bvh *made)
{
    return (bvh){.nodes = from_device(made->nodes, (size_t)made->node_bytes),
                 .node_count = (size_t)made->node_bytes / sizeof(svo_ray_node),
                 .leaves = from_device(made->leaves, (size_t)made->leaf_bytes),
                 .leaf_words = (size_t)made->leaf_bytes / 4};
}

static svo_i_device_bvh make_there(const placed *on, const svo_i_bvh_options *options)
{
    svo_i_device_bvh made;
    const svo_status status = svo_i_bvh_make(device, "test_bvh", NULL, &on->mesh, options, &made);
    if (status != SVO_OK) {
        fail_msg("%s", svo_device_message(device));
        return made;
    }
    return made;
}

static bvh make(const soup *from, const svo_i_bvh_options *options)
{
    placed on = place(from);
    svo_i_device_bvh made = make_there(&on, options);
    const bvh out = read_back(&made);
    svo_i_bvh_release(&made);
    take_away(&on);
    return out;
}

static bvh_source source_of(const soup *from)
{
    return (bvh_source){.vertices = from->vertices,
                        .floats = from->floats,
                        .doubles = from->doubles,
                        .indices = from->indices,
                        .triangle_ids = from->triangle_ids,
                        .list = from->list,
                        .list_count = from->list_count,
                        .triangle_count = from->triangle_count,
                        .snap_bits = SNAP_BITS};
}

static void assert_same_bytes(const bvh *a, const bvh *b)
{
    assert_int_equal(a->node_count, b->node_count);
    assert_int_equal(a->leaf_words, b->leaf_words);
    assert_memory_equal(a->nodes, b->nodes, a->node_count * sizeof *a->nodes);
    assert_memory_equal(a->leaves, b->leaves, a->leaf_words * sizeof *a->leaves);
}

/* ---- against the reference ---- */

/* The same children with the same bounds and the same leaves, whatever the order of the nodes. */
static void assert_same_node(const bvh *a, size_t index_a, const bvh *b, size_t index_b, bool has_doubles)
{
    const svo_ray_node *node_a = &a->nodes[index_a];
    const svo_ray_node *node_b = &b->nodes[index_b];
    assert_memory_equal(node_a->low, node_b->low, sizeof node_a->low);
    assert_memory_equal(node_a->high, node_b->high, sizeof node_a->high);
    for (int i = 0; i < 8; ++i) {
        const uint32_t child_a = node_a->child[i];
        const uint32_t child_b = node_b->child[i];
        assert_int_equal(child_a & SVO_RAY_LEAF, child_b & SVO_RAY_LEAF);
        if ((child_a & SVO_RAY_LEAF) == 0) {
            assert_same_node(a, child_a, b, child_b, has_doubles);
            continue;
        }
        const uint32_t *leaf_a = a->leaves + (size_t)(child_a & ~SVO_RAY_LEAF) * 4;
        const uint32_t *leaf_b = b->leaves + (size_t)(child_b & ~SVO_RAY_LEAF) * 4;
        assert_int_equal(leaf_a[3], leaf_b[3]);
        assert_memory_equal(leaf_a, leaf_b, bvh_reference_leaf_words(has_doubles, leaf_a[3]) * sizeof *leaf_a);
    }
}

static void assert_is_reference(const soup *from)
{
    const bvh_source source = source_of(from);
    bvh expected;
    bvh made = make(from, &(svo_i_bvh_options){.quality = SVO_BVH_BEST});
    assert_true(bvh_reference_make(&source, &expected));
    assert_int_equal(made.node_count, expected.node_count);
    assert_int_equal(made.leaf_words, expected.leaf_words);
    assert_same_node(&made, 0, &expected, 0, from->doubles != NULL);
    bvh_reference_free(&made);
    bvh_reference_free(&expected);
}

static void the_best_bvh_is_that_of_the_reference(void **state)
{
    static const char *const names[] = {"statue:20000", "atrium", "needles:5000", "dust:9000", "cornell"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        soup from = scene_soup(names[i]);
        assert_is_reference(&from);
        free_soup(&from);
    }
    soup leaving = leaving_soup(12000, 3);
    assert_is_reference(&leaving);
    give_doubles(&leaving);
    assert_is_reference(&leaving);
    free_soup(&leaving);
}

static void hard_meshes_are_split_as_by_the_reference(void **state)
{
    (void)state;
    for (uint32_t count = 0; count <= 40; ++count) {
        soup few = random_soup(count, WIDTH, WIDTH / 4, count);
        assert_is_reference(&few);
        free_soup(&few);
    }
    soup coincident = coincident_soup(100000);
    assert_is_reference(&coincident);
    free_soup(&coincident);
    soup shrinking = shrinking_soup(5000);
    assert_is_reference(&shrinking);
    free_soup(&shrinking);
}

/* ---- what a BVH must hold ---- */

typedef struct inspection {
    const soup *from;
    const bvh *of;
    uint8_t *met; /* by triangle */
    uint32_t depth; /* nodes on the longest path */
} inspection;

static uint32_t bound_of(const uint32_t words[12], int axis, int child)
{
    return words[4 * axis + child / 2] >> (16 * (child % 2)) & 0xffff;
}

/* A triangle of a leaf: its corners are those of the mesh, and the snapped ones are inside the boxes above as far as
   inside the grid. */
static void inspect_triangle(inspection *i, const uint32_t *record, uint32_t lane, const uint32_t low[3],
                             const uint32_t high[3])
{
    const uint32_t count = record[3];
    const uint32_t *words = record + SVO_RAY_LEAF_HEAD_WORDS;
    const uint32_t id = words[bvh_reference_ids_begin(i->from->doubles != NULL, count) + lane];
    const uint32_t triangle = (id - 5) / 2;
    assert_in_range(triangle, 0, i->from->triangle_count - 1);
    assert_int_equal(i->met[triangle], 0);
    i->met[triangle] = 1;
    for (uint32_t k = 0; k < 9; ++k) {
        const uint32_t axis = k / 3;
        const size_t at = 9 * (size_t)triangle + 3 * (k % 3) + axis;
        const int32_t snapped = i->from->vertices[at];
        assert_memory_equal(&words[k * count + lane], &i->from->floats[at], sizeof(float));
        const int32_t inside = snapped < 0 ? 0 : snapped > WIDTH ? WIDTH : snapped;
        const uint32_t step = (uint32_t)inside >> (SNAP_BITS - SVO_RAY_BOX_BITS);
        assert_in_range(step < 0xffff ? step : 0xffff, low[axis], high[axis]);
    }
}

static void inspect_node(inspection *i, size_t index, const uint32_t low[3], const uint32_t high[3], uint32_t depth)
{
    assert_true(index < i->of->node_count);
    const svo_ray_node *node = &i->of->nodes[index];
    i->depth = depth > i->depth ? depth : i->depth;
    for (int child = 0; child < 8; ++child) {
        uint32_t child_low[3];
        uint32_t child_high[3];
        const uint32_t at = node->child[child];
        if (at == SVO_RAY_LEAF) {
            assert_int_equal(bound_of(node->low, 0, child), 0xffff);
            assert_int_equal(bound_of(node->high, 0, child), 0);
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            child_low[axis] = bound_of(node->low, axis, child);
            child_high[axis] = bound_of(node->high, axis, child);
            assert_in_range(child_low[axis], low[axis], high[axis]);
            assert_in_range(child_high[axis], child_low[axis], high[axis]);
        }
        if ((at & SVO_RAY_LEAF) == 0) {
            inspect_node(i, at, child_low, child_high, depth + 1);
            continue;
        }
        const uint32_t *record = i->of->leaves + (size_t)(at & ~SVO_RAY_LEAF) * 4;
        const uint32_t count = record[3];
        assert_in_range(count, 1, SVO_RAY_LEAF_TRIANGLES);
        for (uint32_t lane = 0; lane < count; ++lane) {
            inspect_triangle(i, record, lane, child_low, child_high);
        }
    }
}

/* Each listed triangle is in one leaf, inside all boxes above it, and no path is longer than stacks allow. Returns the
   nodes on the longest. */
static uint32_t inspect(const soup *from, const bvh *of)
{
    const uint32_t low[3] = {0, 0, 0};
    const uint32_t high[3] = {0xffff, 0xffff, 0xffff};
    inspection i = {.from = from, .of = of, .met = calloc((size_t)from->triangle_count + 1, 1)};
    uint32_t listed = 0;
    assert_non_null(i.met);
    inspect_node(&i, 0, low, high, 1);
    for (uint32_t k = 0; from->list != NULL && k < from->list_count; ++k) {
        assert_true(i.met[from->list[k]] != 0);
        i.met[from->list[k]] = 2;
    }
    for (uint32_t triangle = 0; triangle < from->triangle_count; ++triangle) {
        assert_true(i.met[triangle] == (from->list != NULL ? 2 : 1) || (from->list != NULL && i.met[triangle] == 0));
        listed += i.met[triangle] != 0 ? 1 : 0;
    }
    assert_true(from->list != NULL || listed == from->triangle_count);
    assert_in_range(i.depth, 1, SVO_BVH_DEPTH_MAX);
    free(i.met);
    return i.depth;
}

static uint32_t inspect_made(const soup *from, svo_bvh_quality quality)
{
    bvh made = make(from, &(svo_i_bvh_options){.quality = quality});
    const uint32_t depth = inspect(from, &made);
    bvh_reference_free(&made);
    return depth;
}

static void each_triangle_is_in_one_leaf_inside_its_boxes(void **state)
{
    (void)state;
    for (svo_bvh_quality quality = SVO_BVH_BEST; quality <= SVO_BVH_FAST; ++quality) {
        for (uint32_t count = 0; count <= 30; ++count) {
            soup few = random_soup(count, WIDTH, WIDTH / 4, count);
            inspect_made(&few, quality);
            free_soup(&few);
        }
        soup soups[] = {scene_soup("statue:30000"),  scene_soup("atrium"),  random_soup(20000, WIDTH, 9, 1),
                        random_soup(3000, 40, 3, 2), leaving_soup(9000, 5), random_soup(4000, WIDTH, WIDTH, 7)};
        for (size_t i = 0; i < sizeof soups / sizeof soups[0]; ++i) {
            inspect_made(&soups[i], quality);
            free_soup(&soups[i]);
        }
    }
}

static void a_million_coincident_triangles_are_split_by_count(void **state)
{
    soup coincident = coincident_soup(1000000);
    (void)state;
    /* Halved until they fit leaves: 2^17 parts, so 17 splits at most are on a path of nodes. */
    assert_in_range(inspect_made(&coincident, SVO_BVH_BEST), 6, 17);
    assert_in_range(inspect_made(&coincident, SVO_BVH_FAST), 6, 17);
    free_soup(&coincident);
}

/* Triangles that a split by area takes off a few at a time, a thousand of each size. */
static void no_path_is_longer_than_the_stack(void **state)
{
    soup shrinking = shrinking_soup(20000);
    (void)state;
    inspect_made(&shrinking, SVO_BVH_BEST);
    inspect_made(&shrinking, SVO_BVH_FAST);
    free_soup(&shrinking);
}

/* ---- the same bytes ---- */

static void bytes_do_not_depend_on_chunks_and_jobs(void **state)
{
    static const uint32_t sizes[][2] = {{64, 64}, {100, 257}, {777, 1000}, {1u << 20, 1u << 20}};
    soup from = scene_soup("statue:20000");
    bvh expected = make(&from, &(svo_i_bvh_options){.quality = SVO_BVH_BEST});
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        bvh made = make(&from, &(svo_i_bvh_options){
                                   .quality = SVO_BVH_BEST, .chunk_items = sizes[i][0], .subtree_items = sizes[i][1]});
        assert_same_bytes(&made, &expected);
        bvh_reference_free(&made);
    }
    bvh_reference_free(&expected);
    free_soup(&from);
}

static uint64_t digest_of(const void *data, size_t bytes, uint64_t sum)
{
    for (size_t i = 0; i < bytes; ++i) {
        sum = (sum ^ ((const uint8_t *)data)[i]) * UINT64_C(0x100000001b3); /* FNV-1a */
    }
    return sum;
}

/* Known digests, whatever the device, its driver and its threads. The jobs are small, so that all kernels run. */
static void bytes_are_the_same_on_every_device(void **state)
{
    static const uint64_t expected[2] = {UINT64_C(0x4212d63e1f5ef644), UINT64_C(0x6afff29c887a1a4d)};
    soup from = leaving_soup(1500, 9);
    (void)state;
    for (svo_bvh_quality quality = SVO_BVH_BEST; quality <= SVO_BVH_FAST; ++quality) {
        bvh made = make(&from, &(svo_i_bvh_options){.quality = quality, .chunk_items = 64, .subtree_items = 64});
        const uint64_t nodes = digest_of(made.nodes, made.node_count * sizeof *made.nodes, 1);
        assert_int_equal(digest_of(made.leaves, made.leaf_words * sizeof *made.leaves, nodes), expected[quality]);
        bvh_reference_free(&made);
    }
    free_soup(&from);
}

/* ---- refits ---- */

static void write_vertices(const placed *to, const soup *from)
{
    cl_command_queue queue = NULL;
    assert_int_equal(svo_i_device_queue(device, "test_bvh", NULL, &queue), SVO_OK);
    assert_int_equal(clEnqueueWriteBuffer(queue, to->mesh.vertices, CL_TRUE, 0, (size_t)from->triangle_count * 36,
                                          from->vertices, 0, NULL, NULL),
                     CL_SUCCESS);
}

/* Moves vertices, some of them far. */
static void move_vertices(soup *of, uint64_t seed)
{
    for (size_t i = 0; i < (size_t)of->triangle_count * 9; ++i) {
        const int32_t far = i % 4000 == 0 ? WIDTH / 2 : 300;
        const int32_t moved = of->vertices[i] + between(&seed, -far, far);
        of->vertices[i] = moved < 0 ? 0 : moved >= WIDTH ? WIDTH - 1 : moved;
    }
}

/* Fits the BVH and waits. */
static void refit(const placed *on, svo_i_device_bvh *made)
{
    svo_bvh_extent told = {.outside = 7};
    cl_event done = NULL;
    assert_int_equal(svo_i_bvh_refit(device, "test_bvh", NULL, &on->mesh, made, NULL, &told, &done), SVO_OK);
    assert_int_equal(clWaitForEvents(1, &done), CL_SUCCESS);
    assert_int_equal(told.outside, 0);
    clReleaseEvent(done);
}

static void a_refit_follows_the_vertices(void **state)
{
    (void)state;
    for (svo_bvh_quality quality = SVO_BVH_BEST; quality <= SVO_BVH_FAST; ++quality) {
        soup from = scene_soup("knot:15000");
        placed on = place(&from);
        svo_i_device_bvh made = make_there(&on, &(svo_i_bvh_options){.quality = quality, .can_refit = true});
        bvh before = read_back(&made);
        refit(&on, &made);
        bvh unmoved = read_back(&made);
        assert_same_bytes(&unmoved, &before);
        move_vertices(&from, 11);
        write_vertices(&on, &from);
        refit(&on, &made);
        bvh moved = read_back(&made);
        inspect(&from, &moved);
        assert_int_equal(moved.node_count, before.node_count);
        bvh_reference_free(&before);
        bvh_reference_free(&unmoved);
        bvh_reference_free(&moved);
        svo_i_bvh_release(&made);
        take_away(&on);
        free_soup(&from);
    }
}

/* small: only what is repeated with another number of threads. */
TEST_GROUP(bvh)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_best_bvh_is_that_of_the_reference),
        cmocka_unit_test(hard_meshes_are_split_as_by_the_reference),
        cmocka_unit_test(each_triangle_is_in_one_leaf_inside_its_boxes),
        cmocka_unit_test(a_million_coincident_triangles_are_split_by_count),
        cmocka_unit_test(no_path_is_longer_than_the_stack),
        cmocka_unit_test(bytes_do_not_depend_on_chunks_and_jobs),
        cmocka_unit_test(bytes_are_the_same_on_every_device),
        cmocka_unit_test(a_refit_follows_the_vertices),
    };
    return cmocka_run_group_tests_name("bvh", tests, open_device, close_device);
}
