/* SPDX-License-Identifier: MIT */
/*
 * Meshes for the known answers of the plan's kernels. The host makes their plans as it always does; what it does not
 * keep, such as the fate of each triangle and the rows of groups, follows from those by plain loops.
 */
#include "plan/proof_mesh.h"

#include <math.h>
#include <string.h>

#include "plan/estimate.h"
#include "plan/grid.h"
#include "shared/fine.clh"
#include "shared/snap.clh"

#define SOLIDS    SVO_I_PROOF_SOLIDS
#define VERTICES  SVO_I_PROOF_VERTICES
#define TRIANGLES SVO_I_PROOF_TRIANGLES
#define MATERIALS SVO_I_PROOF_MATERIALS
#define DEPTH     8
#define SNAP_BITS 20
#define RUN       (SVO_SCAN_TILE / SVO_GROUP_ITEMS) /* elements of a work-item */

/* A corner of the grid's lattice of units, or the number beside it. */
static double near_unit(uint64_t random)
{
    const double unit = ldexp((double)(random % (UINT64_C(3) << (SNAP_BITS - 1))), 1 - SNAP_BITS) - 1.5;
    return random >> 40 & 1 ? unit : nextafter(unit, random >> 41 & 1 ? 2.0 : -2.0);
}

/* Tetrahedra of all sizes from that of the grid to far below a voxel. */
static void fill_positions(svo_i_proof_mesh *c)
{
    uint64_t random = 7;
    for (size_t solid = 0; solid < SOLIDS; ++solid) {
        const double size = ldexp(1.0, -(int)(solid % 13));
        for (size_t axis = 0; axis < 3; ++axis) {
            const double base = (1.0 - size) * (double)(svo_i_proof_next(&random) >> 11) * 0x1p-53;
            for (size_t corner = 0; corner < 4; ++corner) {
                const uint64_t x = svo_i_proof_next(&random);
                const size_t i = (solid * 4 + corner) * 3 + axis;
                c->floats[i] = (float)(base + size * (double)(x >> 11) * 0x1p-53);
                c->doubles[i] = solid % 3 != 0 ? near_unit(x) : (double)c->floats[i];
            }
        }
    }
    static const float odd[9] = {-0.0F, 1e-40F, 0.0F, INFINITY, 0.5F, NAN, 0.25F, 3e6F, -2e9F};
    for (size_t i = 0; i < 9; ++i) {
        c->floats[(size_t)12 * SOLIDS + i] = odd[i];
        c->doubles[(size_t)12 * SOLIDS + i] = (double)odd[i];
    }
}

/* In an open mesh some corners are no vertex, or one of the last three. */
static void fill_corners(svo_i_proof_mesh *c)
{
    static const uint32_t sides[12] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
    for (uint32_t i = 0; i < 12 * SOLIDS; ++i) {
        c->indices[i] = i / 12 * 4 + sides[i % 12];
        if (c->is_open && i % 41 == 40) {
            c->indices[i] = i % 4 == 0 ? UINT32_MAX - i : 4 * SOLIDS + i % 3;
        }
    }
    memcpy(c->indices + (size_t)12 * SOLIDS, (const uint32_t[]){0, 1, VERTICES}, 3 * sizeof *c->indices);
}

static void fill_attributes(svo_i_proof_mesh *c)
{
    uint64_t random = 8;
    for (size_t i = 0; i < VERTICES; ++i) {
        c->colors[i] = (uint32_t)svo_i_proof_next(&random);
        for (size_t axis = 0; axis < 3; ++axis) {
            c->normals[i * 3 + axis] = i % 5 == 0 ? 0.0F : (float)((int64_t)svo_i_proof_next(&random) >> 20);
        }
    }
    for (size_t t = 0; t < TRIANGLES; ++t) {
        c->triangle_materials[t] = (uint16_t)(t % 2 == 0 ? 1 : t % (MATERIALS + 2));
    }
}

static void fill_mesh(svo_i_proof_mesh *c, bool is_open)
{
    c->is_open = is_open;
    fill_positions(c);
    fill_corners(c);
    fill_attributes(c);
    c->mesh = (svo_mesh){.struct_size = sizeof c->mesh,
                         .positions = is_open ? NULL : c->floats,
                         .positions_double = is_open ? c->doubles : NULL,
                         .vertex_count = VERTICES,
                         .indices = c->indices,
                         .triangle_count = TRIANGLES,
                         .normals = c->normals,
                         .colors = (const uint8_t *)c->colors,
                         .triangle_materials = c->triangle_materials,
                         .materials = c->materials,
                         .material_count = MATERIALS};
}

/* The host's plan of the mesh, as far as kernels make plans. */
static svo_status plan_on_host(svo_i_proof *proof, svo_i_proof_mesh *c)
{
    void *memory = NULL;
    SVO_I_TRY(svo_i_proof_alloc(proof, sizeof *c->plan, &memory));
    svo_plan *plan = c->plan = memory;
    plan->device = proof->work.device;
    plan->progress.function = proof->work.function;
    plan->options.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_PROJECTED_AREA;
    plan->options.edge = c->is_open ? 2.0 : 0.0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        plan->options.origin[axis] = -1.0;
    }
    plan->info.depth = DEPTH;
    plan->info.snap_bits = SNAP_BITS;
    plan->voxel_log2 = SNAP_BITS - DEPTH;
    c->found.material_used = c->material_used;
    SVO_I_TRY(svo_i_plan_grid(plan, &c->mesh));
    svo_i_plan_resolve_need(plan, &c->mesh, true);
    return svo_i_plan_find(plan, &c->mesh, &c->found);
}

static bool is_accepted(const svo_i_proof_mesh *c, size_t t)
{
    bool accepted = true;
    for (size_t i = 3 * t; i < 3 * t + 3; ++i) {
        const uint32_t vertex = c->indices[i];
        for (unsigned axis = 0; axis < 3 && accepted; ++axis) {
            accepted = vertex < VERTICES && isfinite(svo_i_mesh_coordinate(&c->mesh, vertex, axis));
        }
    }
    return accepted;
}

static void mark_vertices(svo_i_proof_mesh *c)
{
    for (size_t t = 0; t < TRIANGLES; ++t) {
        for (size_t i = 3 * t; i < (is_accepted(c, t) ? 3 * t + 3 : 0); ++i) {
            c->used[c->indices[i]] = 1;
        }
    }
    for (size_t i = 0; i < (size_t)c->plan->triangle_count * 3; ++i) {
        c->kept[c->plan->indices[i]] = 1;
    }
}

static uint64_t key_of(double x)
{
    uint64_t bits = 0;
    memcpy(&bits, &x, sizeof bits);
    return bits >> 63 != 0 ? ~bits : bits | UINT64_C(1) << 63;
}

static void raise(uint64_t *largest, uint64_t x)
{
    *largest = x > *largest ? x : *largest;
}

/* What becomes of each vertex. */
static void expect_vertices(svo_i_proof_mesh *c)
{
    const svo_plan *plan = c->plan;
    const svo_snap snap = svo_make_snap(plan->info.scale, plan->info.edge, SNAP_BITS);
    const size_t words = c->is_open ? 6 : 3;
    for (uint32_t v = 0; v < VERTICES; ++v) {
        int32_t parts[3];
        for (unsigned axis = 0; axis < 3; ++axis) {
            const double origin = plan->info.origin[axis];
            const double x = c->used[v] != 0 ? svo_i_mesh_coordinate(&c->mesh, v, axis) : origin;
            const int32_t q = c->vertices[v * 3 + axis] = svo_snap_coordinate(&snap, x, origin);
            parts[axis] = svo_snap_remainder(&snap, x, origin, q, (int32_t)(SVO_SUB_LOG2 - plan->voxel_log2));
            if (c->used[v] != 0) {
                raise(&c->bounds[v / SVO_SCAN_TILE][axis], key_of(-x));
                raise(&c->bounds[v / SVO_SCAN_TILE][3 + axis], key_of(x));
            }
        }
        c->remainders[v] = svo_pack_remainders(parts[0], parts[1], parts[2]);
        if (c->kept[v] != 0) {
            const void *const from = c->is_open ? (const void *)c->doubles : c->floats;
            memcpy((char *)c->positions + v * words * 4, (const char *)from + v * words * 4, words * 4);
        }
    }
}

/* The columns of voxels that a kept triangle is drawn in, as far as items are sorted by them. */
static uint32_t size_of(const svo_i_proof_mesh *c, const uint32_t *corners, uint32_t axis)
{
    const int32_t units = 1 << SNAP_BITS;
    int32_t columns = 1;
    for (uint32_t k = 1; k < 3; ++k) {
        int32_t low = INT32_MAX;
        int32_t high = INT32_MIN;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t q = c->plan->vertices[(size_t)corners[corner] * 3 + (axis + k) % 3];
            low = q < low ? q : low;
            high = q > high ? q : high;
        }
        low = (low < 0 ? 0 : low) >> c->plan->voxel_log2;
        columns *= ((high < units ? high : units - 1) >> c->plan->voxel_log2) - low + 1;
    }
    return columns > SVO_TILE_COLUMNS ? SVO_SIZE_LARGE
           : columns < SVO_SIZE_COUNT ? (uint32_t)columns
                                      : SVO_SIZE_COUNT - 1;
}

/* The fate of a triangle that is not kept. */
static uint16_t fate_of_other(const svo_i_proof_mesh *c, size_t t)
{
    bool outside = false;
    for (unsigned axis = 0; axis < 3 && is_accepted(c, t); ++axis) {
        int32_t low = INT32_MAX;
        int32_t high = INT32_MIN;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const int32_t q = c->vertices[(size_t)c->indices[3 * t + corner] * 3 + axis];
            low = q < low ? q : low;
            high = q > high ? q : high;
        }
        outside = outside || high < 0 || low >= 1 << SNAP_BITS;
    }
    return (uint16_t)(!is_accepted(c, t) ? SVO_FATE_REFUSED : outside ? SVO_FATE_OUTSIDE : SVO_FATE_FAR);
}

/* The fates, from the draw items of the host's plan. */
static void expect_fates(svo_i_proof_mesh *c)
{
    const svo_plan *plan = c->plan;
    for (size_t t = 0; t < TRIANGLES; ++t) {
        c->fates[t] = fate_of_other(c, t);
        c->fragments[t] = 1.0F;
    }
    for (unsigned class_id = 0; class_id < SVO_I_CLASS_COUNT; ++class_id) {
        for (uint32_t slot = plan->class_begin[class_id]; slot < plan->class_begin[class_id + 1]; ++slot) {
            const svo_draw_item *const item = &plan->items[slot];
            const uint32_t t = plan->triangle_ids[item->triangle];
            const uint32_t size =
                size_of(c, plan->indices + (size_t)item->triangle * 3, item->flags & SVO_DRAW_AXIS_MASK);
            c->fates[t] = (uint16_t)(class_id | item->flags << SVO_FATE_DRAW_LOG2 | size << SVO_FATE_SIZE_LOG2);
            c->fragments[t] = plan->item_fragments[slot];
        }
    }
}

/* The sums of the groups: of 16 triangles at a time, as a work-item adds them up. */
static void expect_rows(svo_i_proof_mesh *c)
{
    svo_plan *plan = c->plan;
    const svo_i_sums before = plan->sums;
    uint32_t kept = 0;
    for (uint32_t begin = 0; begin < TRIANGLES; begin += RUN) {
        uint64_t *const row = c->rows[begin / SVO_SCAN_TILE];
        plan->sums = (svo_i_sums){0, 0, 0};
        for (uint32_t t = begin; t < begin + RUN && t < TRIANGLES; ++t) {
            const uint32_t fate = c->fates[t] & SVO_FATE_MASK;
            ++row[fate];
            if (fate < SVO_I_CLASS_COUNT) {
                row[SVO_PLAN_SUM_LARGE] += c->fates[t] >> SVO_FATE_SIZE_LOG2 == SVO_SIZE_LARGE ? 1 : 0;
                (void)svo_i_estimate_add(plan, plan->indices + (size_t)kept++ * 3);
            }
        }
        const uint64_t areas = (plan->sums.areas_high << 32) + plan->sums.areas_low;
        row[SVO_PLAN_SUM_WIDTHS] += plan->sums.widths;
        row[SVO_PLAN_SUM_AREAS_LOW] += areas & UINT32_MAX;
        row[SVO_PLAN_SUM_AREAS_HIGH] += areas >> 32;
    }
    plan->sums = before;
    memcpy(c->before[1], c->rows[0], sizeof c->before[1]);
}

svo_status svo_i_proof_mesh_make(svo_i_proof *proof, bool is_open, svo_i_proof_mesh *out)
{
    memset(out, 0, sizeof *out);
    fill_mesh(out, is_open);
    SVO_I_TRY(plan_on_host(proof, out));
    mark_vertices(out);
    expect_vertices(out);
    expect_fates(out);
    expect_rows(out);
    return SVO_OK;
}
