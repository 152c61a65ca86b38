/* SPDX-License-Identifier: MIT */
/*
 * Known answers of the kernels that make plans (kernels/plan): for reductions a plain loop, and else the host's plan of
 * the same meshes (proof_mesh.c), step by step.
 */
#include <stdlib.h>
#include <string.h>

#include "core/proof.h"
#include "plan/device_plan.h"
#include "plan/plan.h"
#include "plan/programs.h"
#include "plan/proof_mesh.h"

#define RUN           (SVO_SCAN_TILE / SVO_GROUP_ITEMS) /* elements of a work-item */
#define SCRATCH_BYTES (sizeof(cl_ulong) * SVO_GROUP_ITEMS)

/* ---- reductions ---- */

/* More rows than a group has work-items. */
#define ROWS (2 * SVO_GROUP_ITEMS + 3)

typedef struct totals_case {
    uint64_t rows[ROWS * SVO_PLAN_SUMS], after[ROWS * SVO_PLAN_SUMS];
    uint64_t totals[SVO_PLAN_SUMS];
} totals_case;

/* Columns whose largest number comes first or last, differs from others in one word alone, or occurs twice. */
static void fill_totals(totals_case *c, bool largest)
{
    uint64_t random = 6;
    memset(c->totals, 0, sizeof c->totals);
    for (uint32_t i = 0; i < ROWS * SVO_PLAN_SUMS; ++i) {
        const uint32_t column = i % SVO_PLAN_SUMS;
        const uint32_t row = i / SVO_PLAN_SUMS;
        const uint64_t x = svo_i_proof_next(&random);
        const uint64_t kinds[4] = {x >> 1, x << 32 >> 1, x >> 33, x & UINT64_C(0x8000000080000001)};
        const bool is_extreme = row == column % 4 * (ROWS - 1) / 3;
        c->rows[i] = largest && is_extreme ? UINT64_MAX - column : kinds[column % 4];
        c->after[i] = largest ? c->rows[i] : c->totals[column];
        c->totals[column] = !largest                         ? c->totals[column] + c->rows[i]
                            : c->rows[i] > c->totals[column] ? c->rows[i]
                                                             : c->totals[column];
    }
}

static svo_status prove_reduction(svo_i_proof *proof, totals_case *c, bool largest)
{
    static const char kernel[] = "svo_k_plan_totals";
    const svo_plan_total_params params = {ROWS, SVO_PLAN_SUMS, largest ? 1 : 0, 0};
    cl_mem rows = NULL;
    cl_mem totals = NULL;
    fill_totals(c, largest);
    SVO_I_TRY(svo_i_proof_buffer(proof, c->rows, sizeof c->rows, &rows));
    SVO_I_TRY(svo_i_work_alloc(&proof->work, "proof", sizeof c->totals, &totals));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(rows), SVO_I_ARGUMENT(totals), SVO_I_ARGUMENT(params),
                                        SVO_I_LOCAL(SCRATCH_BYTES)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, kernel, SVO_I_ARGUMENTS(arguments), SVO_GROUP_ITEMS));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, totals, c->totals, sizeof c->totals));
    return svo_i_proof_expect(proof, kernel, rows, c->after, sizeof c->after);
}

static svo_status prove_totals(svo_i_proof *proof)
{
    void *memory = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_i_proof_alloc(proof, sizeof(totals_case), &memory));
    SVO_I_TRY_CLEANUP(prove_reduction(proof, memory, true));
    SVO_I_TRY_CLEANUP(prove_reduction(proof, memory, false));
cleanup:
    svo_i_free(memory);
    return status;
}

/* ---- a mesh, step by step ---- */

#define VERTICES  ((size_t)SVO_I_PROOF_VERTICES)
#define TRIANGLES ((size_t)SVO_I_PROOF_TRIANGLES)
#define GROUPS    SVO_I_PROOF_GROUPS
#define MATERIALS SVO_I_PROOF_MATERIALS

typedef struct plan_case {
    svo_i_proof_mesh host;
    svo_i_grid_run run; /* its buffers are not used */
    svo_i_device_mesh on_device;
    cl_mem used_marks, snapped, fates_given, fragments_given, kept_marks;
} plan_case;

static void begin_run(svo_i_proof *proof, plan_case *c)
{
    c->run = (svo_i_grid_run){.plan = c->host.plan, .work = &proof->work, .mesh = &c->on_device};
    svo_i_grid_begin(&c->run, TRIANGLES, c->host.is_open);
    c->run.params.flags |= SVO_PLAN_SOME | SVO_PLAN_INDEXED;
    memcpy(c->run.params.class_begin, c->host.plan->class_begin, sizeof c->run.params.class_begin);
}

static svo_status launch(svo_i_proof *proof, const char *kernel, const svo_i_argument *arguments,
                         cl_uint argument_count, size_t elements)
{
    return svo_i_work_launch(&proof->work, kernel, arguments, argument_count, (elements + RUN - 1) / RUN);
}

/* A buffer that kernels read, or one that they write. */
static svo_status give(svo_i_proof *proof, const void *content, size_t bytes, cl_mem *out)
{
    return svo_i_work_constants(&proof->work, "proof", content, bytes, out);
}

static svo_status make(svo_i_proof *proof, size_t bytes, cl_mem *out)
{
    return svo_i_work_alloc(&proof->work, "proof", bytes, out);
}

/* The buffers that all steps read: the first of the proof. */
#define MESH_BUFFERS 7

static svo_status give_mesh(svo_i_proof *proof, plan_case *c)
{
    SVO_I_TRY(give(proof, c->host.is_open ? (const void *)c->host.doubles : c->host.floats,
                   c->host.is_open ? sizeof c->host.doubles : sizeof c->host.floats, &c->on_device.positions));
    SVO_I_TRY(give(proof, c->host.indices, sizeof c->host.indices, &c->on_device.indices));
    SVO_I_TRY(give(proof, c->host.used, sizeof c->host.used, &c->used_marks));
    SVO_I_TRY(give(proof, c->host.vertices, sizeof c->host.vertices, &c->snapped));
    SVO_I_TRY(give(proof, c->host.fates, sizeof c->host.fates, &c->fates_given));
    SVO_I_TRY(give(proof, c->host.fragments, sizeof c->host.fragments, &c->fragments_given));
    return give(proof, c->host.kept, sizeof c->host.kept, &c->kept_marks);
}

static svo_status prove_accept(svo_i_proof *proof, const plan_case *c)
{
    static const char kernel[] = "svo_k_plan_accept";
    cl_mem used = NULL;
    SVO_I_TRY(make(proof, VERTICES, &used));
    SVO_I_TRY(svo_i_work_fill_zero(&proof->work, used, VERTICES));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(c->on_device.positions), SVO_I_ARGUMENT(c->on_device.indices),
                                        SVO_I_ARGUMENT(used), SVO_I_ARGUMENT(c->run.params)};
    SVO_I_TRY(launch(proof, kernel, SVO_I_ARGUMENTS(arguments), TRIANGLES));
    return svo_i_proof_expect(proof, kernel, used, c->host.used, sizeof c->host.used);
}

static svo_status prove_bounds(svo_i_proof *proof, const plan_case *c)
{
    static const char kernel[] = "svo_k_plan_bounds";
    cl_mem rows = NULL;
    SVO_I_TRY(make(proof, sizeof c->host.bounds, &rows));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(c->on_device.positions), SVO_I_ARGUMENT(c->used_marks),
                                        SVO_I_ARGUMENT(rows), SVO_I_ARGUMENT(c->run.params),
                                        SVO_I_LOCAL(SCRATCH_BYTES)};
    SVO_I_TRY(launch(proof, kernel, SVO_I_ARGUMENTS(arguments), VERTICES));
    return svo_i_proof_expect(proof, kernel, rows, c->host.bounds, sizeof c->host.bounds);
}

static svo_status prove_snap(svo_i_proof *proof, const plan_case *c)
{
    static const char kernel[] = "svo_k_plan_snap";
    cl_mem vertices = NULL;
    cl_mem remainders = NULL;
    SVO_I_TRY(make(proof, sizeof c->host.vertices, &vertices));
    SVO_I_TRY(make(proof, sizeof c->host.remainders, &remainders));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(c->on_device.positions), SVO_I_ARGUMENT(c->used_marks),
                                        SVO_I_ARGUMENT(vertices), SVO_I_ARGUMENT(remainders),
                                        SVO_I_ARGUMENT(c->run.params)};
    SVO_I_TRY(launch(proof, kernel, SVO_I_ARGUMENTS(arguments), VERTICES));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, vertices, c->host.vertices, sizeof c->host.vertices));
    return svo_i_proof_expect(proof, kernel, remainders, c->host.remainders, sizeof c->host.remainders);
}

static svo_status prove_classify(svo_i_proof *proof, const plan_case *c)
{
    static const char kernel[] = "svo_k_plan_classify";
    cl_mem fates = NULL;
    cl_mem fragments = NULL;
    cl_mem rows = NULL;
    SVO_I_TRY(make(proof, sizeof c->host.fates, &fates));
    SVO_I_TRY(make(proof, sizeof c->host.fragments, &fragments));
    SVO_I_TRY(make(proof, sizeof c->host.rows, &rows));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(c->snapped),    SVO_I_ARGUMENT(c->on_device.indices),
                                        SVO_I_ARGUMENT(c->used_marks), SVO_I_ARGUMENT(fates),
                                        SVO_I_ARGUMENT(fragments),     SVO_I_ARGUMENT(rows),
                                        SVO_I_ARGUMENT(c->run.params), SVO_I_LOCAL(SCRATCH_BYTES)};
    SVO_I_TRY(launch(proof, kernel, SVO_I_ARGUMENTS(arguments), TRIANGLES));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, fates, c->host.fates, sizeof c->host.fates));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, fragments, c->host.fragments, sizeof c->host.fragments));
    return svo_i_proof_expect(proof, kernel, rows, c->host.rows, sizeof c->host.rows);
}

/* The sums of a closed mesh cancel. */
static svo_status prove_closed(svo_i_proof *proof, const plan_case *c)
{
    static const char kernel[] = "svo_k_plan_closed";
    svo_i_edge_sums rows[GROUPS] = {{{0}}};
    cl_mem sums = NULL;
    SVO_I_TRY(make(proof, sizeof rows, &sums));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(c->on_device.positions), SVO_I_ARGUMENT(c->on_device.indices),
                                        SVO_I_ARGUMENT(c->fates_given),         SVO_I_ARGUMENT(sums),
                                        SVO_I_ARGUMENT(c->run.params),          SVO_I_LOCAL(SCRATCH_BYTES)};
    SVO_I_TRY(launch(proof, kernel, SVO_I_ARGUMENTS(arguments), TRIANGLES));
    SVO_I_TRY(svo_i_work_read(&proof->work, sums, 0, rows, sizeof rows));
    rows[0].words[0] += rows[1].words[0];
    rows[0].words[1] += rows[1].words[1];
    return svo_i_edges_are_open(&rows[0]) == c->host.plan->work.both_sides ? SVO_OK : svo_i_proof_fail(proof, kernel);
}

static int compare_items(const void *a, const void *b)
{
    const uint32_t x = ((const svo_large_item *)a)->item;
    const uint32_t y = ((const svo_large_item *)b)->item;
    return x < y ? -1 : x > y ? 1 : 0;
}

/* The large triangles, whose order differs from run to run. */
static svo_status expect_large(svo_i_proof *proof, const plan_case *c, cl_mem large, cl_mem count)
{
    static const char kernel[] = "svo_k_plan_keep";
    void *memory = NULL;
    const size_t bytes = c->host.plan->large_count * sizeof(svo_large_item);
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, count, &c->host.plan->large_count, sizeof c->host.plan->large_count));
    SVO_I_TRY(svo_i_proof_alloc(proof, bytes + 1, &memory));
    svo_status status = svo_i_work_read(&proof->work, large, 0, memory, bytes);
    if (status == SVO_OK) {
        qsort(memory, c->host.plan->large_count, sizeof(svo_large_item), compare_items);
        status = memcmp(memory, c->host.plan->large, bytes) == 0 ? SVO_OK : svo_i_proof_fail(proof, kernel);
    }
    svo_i_free(memory);
    return status;
}

/* What svo_k_plan_keep writes. */
typedef struct kept_arrays {
    cl_mem indices, triangle_ids, items, item_fragments, large, large_count, kept;
} kept_arrays;

static svo_status make_kept(svo_i_proof *proof, kept_arrays *out)
{
    SVO_I_TRY(make(proof, TRIANGLES * 12, &out->indices));
    SVO_I_TRY(make(proof, TRIANGLES * 4, &out->triangle_ids));
    SVO_I_TRY(make(proof, TRIANGLES * sizeof(svo_draw_item), &out->items));
    SVO_I_TRY(make(proof, TRIANGLES * 4, &out->item_fragments));
    SVO_I_TRY(make(proof, TRIANGLES * sizeof(svo_large_item), &out->large));
    SVO_I_TRY(make(proof, sizeof(cl_uint), &out->large_count));
    SVO_I_TRY(svo_i_work_fill_zero(&proof->work, out->large_count, sizeof(cl_uint)));
    SVO_I_TRY(make(proof, VERTICES, &out->kept));
    return svo_i_work_fill_zero(&proof->work, out->kept, VERTICES);
}

static svo_status expect_kept(svo_i_proof *proof, const plan_case *c, const kept_arrays *made)
{
    static const char kernel[] = "svo_k_plan_keep";
    const svo_plan *plan = c->host.plan;
    const size_t count = plan->triangle_count;
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, made->indices, plan->indices, count * 12));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, made->triangle_ids, plan->triangle_ids, count * 4));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, made->items, plan->items, count * sizeof(svo_draw_item)));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, made->item_fragments, plan->item_fragments, count * 4));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, made->kept, c->host.kept, sizeof c->host.kept));
    return expect_large(proof, c, made->large, made->large_count);
}

static svo_status prove_keep(svo_i_proof *proof, const plan_case *c)
{
    cl_mem before = NULL;
    kept_arrays made = {NULL, NULL, NULL, NULL, NULL, NULL, NULL};
    SVO_I_TRY(give(proof, c->host.before, sizeof c->host.before, &before));
    SVO_I_TRY(make_kept(proof, &made));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(c->snapped),
                                        SVO_I_ARGUMENT(c->on_device.indices),
                                        SVO_I_ARGUMENT(c->fates_given),
                                        SVO_I_ARGUMENT(c->fragments_given),
                                        SVO_I_ARGUMENT(before),
                                        SVO_I_ARGUMENT(made.indices),
                                        SVO_I_ARGUMENT(made.triangle_ids),
                                        SVO_I_ARGUMENT(made.items),
                                        SVO_I_ARGUMENT(made.item_fragments),
                                        SVO_I_ARGUMENT(made.large),
                                        SVO_I_ARGUMENT(made.large_count),
                                        SVO_I_ARGUMENT(made.kept),
                                        SVO_I_ARGUMENT(c->run.params),
                                        SVO_I_LOCAL(SCRATCH_BYTES),
                                        SVO_I_LOCAL(sizeof(cl_ushort) * SVO_SIZE_COUNT * SVO_SIZE_PITCH)};
    SVO_I_TRY(launch(proof, "svo_k_plan_keep", SVO_I_ARGUMENTS(arguments), TRIANGLES));
    return expect_kept(proof, c, &made);
}

/* What depends on the kept vertices alone: their snapped and their own positions. */
static svo_status prove_vertices(svo_i_proof *proof, const plan_case *c)
{
    cl_mem vertices = NULL;
    cl_mem positions = NULL;
    SVO_I_TRY(svo_i_proof_buffer(proof, c->host.vertices, sizeof c->host.vertices, &vertices));
    SVO_I_TRY(make(proof, sizeof c->host.positions, &positions));
    const svo_i_argument clears[] = {SVO_I_ARGUMENT(c->kept_marks), SVO_I_ARGUMENT(vertices),
                                     SVO_I_ARGUMENT(c->run.params)};
    const svo_i_argument copies[] = {SVO_I_ARGUMENT(c->on_device.positions), SVO_I_ARGUMENT(c->kept_marks),
                                     SVO_I_ARGUMENT(positions), SVO_I_ARGUMENT(c->run.params)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_plan_clear", SVO_I_ARGUMENTS(clears), VERTICES));
    SVO_I_TRY(svo_i_proof_expect(proof, "svo_k_plan_clear", vertices, c->host.plan->vertices, sizeof c->host.vertices));
    SVO_I_TRY(svo_i_work_launch(&proof->work, "svo_k_plan_positions", SVO_I_ARGUMENTS(copies), VERTICES));
    return svo_i_proof_expect(proof, "svo_k_plan_positions", positions, c->host.positions,
                              c->host.is_open ? sizeof c->host.doubles : sizeof c->host.floats);
}

static svo_status prove_normals(svo_i_proof *proof, const plan_case *c)
{
    static const char kernel[] = "svo_k_plan_normals";
    const cl_uint count = VERTICES;
    cl_mem from = NULL;
    cl_mem normals = NULL;
    SVO_I_TRY(give(proof, c->host.normals, sizeof c->host.normals, &from));
    SVO_I_TRY(make(proof, VERTICES * 8, &normals));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(from), SVO_I_ARGUMENT(normals), SVO_I_ARGUMENT(count)};
    SVO_I_TRY(svo_i_work_launch(&proof->work, kernel, SVO_I_ARGUMENTS(arguments), VERTICES));
    return svo_i_proof_expect(proof, kernel, normals, c->host.plan->normals, VERTICES * 8);
}

/* What they find of the first triangle: the color and the normal of its first corner, and its record. */
static bool finds_the_first(const svo_plan *plan, const uint64_t found[4])
{
    const size_t corner = plan->indices[0];
    const svo_triangle_record *first = plan->records;
    uint32_t color = 0;
    uint64_t normal = 0;
    memcpy(&color, (const uint8_t *)plan->colors + corner * sizeof color, sizeof color);
    memcpy(&normal, (const uint8_t *)plan->normals + corner * sizeof normal, sizeof normal);
    return found[0] == color && found[1] == normal &&
           found[2] == ((uint64_t)first->normal_xy << 32 | first->material) &&
           found[3] == ((uint64_t)first->stretch << 32 | first->normal_z_flags);
}

/* What kernels find about all triangles: the largest numbers of the groups' rows. */
static bool finds_the_same(const plan_case *c, const uint64_t rows[GROUPS][SVO_PLAN_FINDINGS])
{
    uint64_t most[SVO_PLAN_FINDINGS] = {0};
    uint64_t area = 0;
    for (unsigned column = 0; column < SVO_PLAN_FINDINGS; ++column) {
        most[column] = rows[0][column] > rows[1][column] ? rows[0][column] : rows[1][column];
    }
    memcpy(&area, &c->host.found.largest_area, sizeof area);
    return finds_the_first(c->host.plan, most + 5) && most[0] == area && (most[1] != 0) == c->host.found.colors_vary &&
           (most[2] != 0) == c->host.found.normals_vary && (most[3] != ~most[4]) == c->host.found.own_normals_vary;
}

static svo_status prove_records(svo_i_proof *proof, const plan_case *c)
{
    static const char kernel[] = "svo_k_plan_records";
    const svo_plan *plan = c->host.plan;
    const uint8_t textured[MATERIALS] = {0};
    svo_plan_params params = c->run.params;
    uint64_t found[GROUPS][SVO_PLAN_FINDINGS] = {{0}};
    cl_mem given[9] = {NULL};
    cl_mem made[3] = {NULL};
    params.triangle_count = plan->triangle_count;
    params.material_count = MATERIALS;
    params.flags = SVO_PLAN_TEXTURED;
    SVO_I_TRY(give(proof, plan->vertices, sizeof c->host.vertices, &given[0]));
    SVO_I_TRY(give(proof, plan->indices, (size_t)plan->triangle_count * 12, &given[1]));
    SVO_I_TRY(give(proof, plan->triangle_ids, (size_t)plan->triangle_count * 4, &given[2]));
    SVO_I_TRY(give(proof, c->host.triangle_materials, sizeof c->host.triangle_materials, &given[3]));
    SVO_I_TRY(give(proof, plan->colors, sizeof c->host.colors, &given[4]));
    SVO_I_TRY(give(proof, plan->normals, VERTICES * 8, &given[5]));
    SVO_I_TRY(give(proof, textured, sizeof textured, &given[6]));
    SVO_I_TRY(give(proof, plan->remainders, VERTICES * 8, &given[7]));
    SVO_I_TRY(make(proof, MATERIALS, &made[0]));
    SVO_I_TRY(svo_i_work_fill_zero(&proof->work, made[0], MATERIALS));
    SVO_I_TRY(make(proof, TRIANGLES * sizeof(svo_triangle_record), &made[1]));
    SVO_I_TRY(svo_i_proof_buffer(proof, found, sizeof found, &made[2]));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(given[0]), SVO_I_ARGUMENT(given[1]), SVO_I_ARGUMENT(given[2]),
                                        SVO_I_ARGUMENT(given[3]), SVO_I_ARGUMENT(given[4]), SVO_I_ARGUMENT(given[5]),
                                        SVO_I_ARGUMENT(given[6]), SVO_I_ARGUMENT(made[0]),  SVO_I_ARGUMENT(made[1]),
                                        SVO_I_ARGUMENT(made[2]),  SVO_I_ARGUMENT(params),   SVO_I_LOCAL(SCRATCH_BYTES),
                                        SVO_I_ARGUMENT(given[7])};
    SVO_I_TRY(launch(proof, kernel, SVO_I_ARGUMENTS(arguments), plan->triangle_count));
    SVO_I_TRY(
        svo_i_proof_expect(proof, kernel, made[1], plan->records, plan->triangle_count * sizeof(svo_triangle_record)));
    SVO_I_TRY(svo_i_proof_expect(proof, kernel, made[0], c->host.material_used, MATERIALS));
    SVO_I_TRY(svo_i_work_read(&proof->work, made[2], 0, found, sizeof found));
    return finds_the_same(c, found) ? SVO_OK : svo_i_proof_fail(proof, kernel);
}

/* Releases the buffers from the first one on. */
static svo_status end_step(svo_i_proof *proof, size_t first, svo_status status)
{
    for (size_t i = first; i < SVO_I_WORK_BUFFERS_MAX; ++i) {
        cl_mem buffer = proof->work.buffers[i];
        if (buffer != NULL) {
            svo_i_work_free(&proof->work, &buffer);
        }
    }
    return status;
}

static svo_status prove_steps(svo_i_proof *proof, plan_case *c)
{
    typedef svo_status step(svo_i_proof * proof, const plan_case *c);
    static step *const steps[] = {prove_accept, prove_bounds,   prove_snap,    prove_classify, prove_closed,
                                  prove_keep,   prove_vertices, prove_normals, prove_records};
    SVO_I_TRY(give_mesh(proof, c));
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; ++i) {
        SVO_I_TRY(end_step(proof, MESH_BUFFERS, steps[i](proof, c)));
    }
    return SVO_OK;
}

static svo_status prove_mesh(svo_i_proof *proof, plan_case *c, bool is_open)
{
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(svo_i_proof_mesh_make(proof, is_open, &c->host));
    begin_run(proof, c);
    SVO_I_TRY_CLEANUP(end_step(proof, 0, prove_steps(proof, c)));
cleanup:
    svo_plan_destroy(&c->host.plan);
    return status;
}

static svo_status prove_plan(svo_i_proof *proof, void *memory)
{
    SVO_I_TRY(prove_totals(proof));
    (void)end_step(proof, 0, SVO_OK);
    SVO_I_TRY(prove_mesh(proof, memory, false));
    return prove_mesh(proof, memory, true);
}

svo_status svo_i_prove_plan(svo_device *device, const char *function, const svo_i_program_entry *made,
                            const char **wrong)
{
    return svo_i_proof_run(device, function, made, wrong, sizeof(plan_case), prove_plan);
}
