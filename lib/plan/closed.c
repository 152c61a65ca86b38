/* SPDX-License-Identifier: MIT */
/*
 * Whether a mesh is closed, exactly and in linear time: the edges of its accepted triangles cancel. An edge belongs to
 * the lesser of its two vertices; each vertex's edges are listed, those in one direction before those in the other, and
 * counted per other vertex. Vertices are one where their given coordinates are equal, and nowhere else.
 */
#include "plan/closed.h"

#include <string.h>

/* The edges of the accepted triangles. */
typedef struct edges {
    const svo_plan *plan;
    const svo_mesh *mesh;
    uint32_t *first; /* vertex_count: the first vertex with the position of each */
    size_t *begin; /* vertex_count + 1: where each vertex's edges begin in ends */
    size_t *middle; /* vertex_count: where its edges towards it begin, behind those away from it */
    uint32_t *ends; /* the other vertices of the edges */
    uint32_t *balance; /* vertex_count: edges away from a vertex less those towards it, modulo 2^32; else 0 */
} edges;

/* Called with the two different vertices of an edge. */
typedef void (*edge_visitor)(edges *e, uint32_t from, uint32_t to);

static void visit_triangles(edges *e, size_t begin, size_t end, edge_visitor visit)
{
    for (size_t i = begin * 3; i < end * 3; i += 3) {
        const uint32_t *corners = e->plan->indices + i;
        for (unsigned corner = 0; corner < 3; ++corner) {
            const uint32_t from = e->first[corners[corner]];
            const uint32_t to = e->first[corners[(corner + 1) % 3]];
            if (from != to) {
                visit(e, from, to);
            }
        }
    }
}

static void visit_edges(edges *e, edge_visitor visit)
{
    const svo_plan_info *info = &e->plan->info;
    visit_triangles(e, 0, e->plan->triangle_count, visit);
    visit_triangles(e, (size_t)(info->triangles - info->outside_triangles), (size_t)info->triangles, visit);
}

/* ---- equal positions ---- */

/* A vertex's coordinates as bits; + 0.0 turns -0 into 0, which equals it. */
typedef struct position {
    uint64_t bits[3];
} position;

static position position_of(const svo_mesh *mesh, size_t vertex)
{
    position p;
    for (unsigned axis = 0; axis < 3; ++axis) {
        const double unsigned_zero = svo_i_mesh_coordinate(mesh, vertex, axis) + 0.0;
        memcpy(&p.bits[axis], &unsigned_zero, sizeof unsigned_zero);
    }
    return p;
}

static bool is_same(const position *a, const position *b)
{
    return a->bits[0] == b->bits[0] && a->bits[1] == b->bits[1] && a->bits[2] == b->bits[2];
}

static size_t hash_position(const position *p)
{
    uint64_t hash = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
        hash = (hash ^ p->bits[axis]) * UINT64_C(0x9e3779b97f4a7c15);
        hash ^= hash >> 29;
    }
    return (size_t)hash;
}

/* The slot of a position, or the free one where it belongs: open addressing. slots: vertices plus one, 0: free; a power
   of two of them, more than there are vertices. */
static size_t find_slot(const svo_mesh *mesh, const position *p, const uint32_t *slots, size_t slot_count)
{
    size_t slot = hash_position(p) & (slot_count - 1);
    while (slots[slot] != 0) {
        const position other = position_of(mesh, slots[slot] - 1);
        if (is_same(p, &other)) {
            break;
        }
        slot = (slot + 1) & (slot_count - 1);
    }
    return slot;
}

/* Finds the first vertex of each position. */
static void merge_positions(edges *e, uint32_t *slots, size_t slot_count)
{
    for (uint32_t v = 0; v < e->plan->vertex_count; ++v) {
        const position p = position_of(e->mesh, v);
        const size_t slot = find_slot(e->mesh, &p, slots, slot_count);
        slots[slot] = slots[slot] != 0 ? slots[slot] : v + 1;
        e->first[v] = slots[slot] - 1;
    }
}

static svo_status find_first_vertices(edges *e)
{
    size_t slot_count = 2;
    while (slot_count < 2 * (size_t)e->plan->vertex_count) {
        slot_count *= 2;
    }
    uint32_t *slots = svo_i_alloc_zeroed(&e->plan->device->memory, slot_count, sizeof *slots);
    if (slots == NULL) {
        return SVO_OUT_OF_HOST_MEMORY;
    }
    merge_positions(e, slots, slot_count);
    svo_i_free(slots);
    return SVO_OK;
}

/* ---- edges by vertex ---- */

static void count_edge(edges *e, uint32_t from, uint32_t to)
{
    ++e->begin[(from < to ? from : to) + 1];
}

static void list_away(edges *e, uint32_t from, uint32_t to)
{
    if (from < to) {
        e->ends[e->middle[from]++] = to;
    }
}

static void list_towards(edges *e, uint32_t from, uint32_t to)
{
    if (to < from) {
        e->ends[e->middle[to]++] = from;
    }
}

/* Whether a vertex's edges cancel: half of them lead away from it, and to the same vertices as the others. */
static bool edges_cancel(edges *e, uint32_t vertex)
{
    const size_t begin = e->begin[vertex];
    const size_t end = e->begin[vertex + 1];
    const size_t middle = begin + (end - begin) / 2;
    bool cancel = true;
    for (size_t i = begin; i < end; ++i) {
        e->balance[e->ends[i]] += i < middle ? 1u : UINT32_MAX;
    }
    for (size_t i = begin; i < end; ++i) {
        cancel = cancel && e->balance[e->ends[i]] == 0;
    }
    return cancel;
}

/* Whether each vertex has as many edges that lead away from it as towards it. Lists the former. */
static bool half_lead_away(edges *e)
{
    const uint32_t vertex_count = e->plan->vertex_count;
    bool half = true;
    visit_edges(e, count_edge);
    for (uint32_t v = 0; v < vertex_count; ++v) {
        e->begin[v + 1] += e->begin[v];
    }
    memcpy(e->middle, e->begin, vertex_count * sizeof *e->middle);
    visit_edges(e, list_away);
    for (uint32_t v = 0; v < vertex_count && half; ++v) {
        half = e->middle[v] - e->begin[v] == e->begin[v + 1] - e->middle[v];
    }
    return half;
}

static bool all_cancel(edges *e)
{
    if (!half_lead_away(e)) {
        return false;
    }
    visit_edges(e, list_towards);
    for (uint32_t v = 0; v < e->plan->vertex_count; ++v) {
        if (!edges_cancel(e, v)) {
            return false;
        }
    }
    return true;
}

static svo_status find(edges *e, bool *closed)
{
    const svo_i_memory *memory = &e->plan->device->memory;
    const size_t vertices = e->plan->vertex_count;
    e->first = svo_i_alloc(memory, (vertices + 1) * sizeof *e->first);
    e->begin = svo_i_alloc_zeroed(memory, vertices + 1, sizeof *e->begin);
    e->middle = svo_i_alloc(memory, (vertices + 1) * sizeof *e->middle);
    e->ends = svo_i_alloc(memory, ((size_t)e->plan->info.triangles * 3 + 1) * sizeof *e->ends);
    e->balance = svo_i_alloc_zeroed(memory, vertices + 1, sizeof *e->balance);
    if (e->first == NULL || e->begin == NULL || e->middle == NULL || e->ends == NULL || e->balance == NULL ||
        find_first_vertices(e) != SVO_OK) {
        return svo_i_device_fail(e->plan->device, SVO_OUT_OF_HOST_MEMORY,
                                 "svo_plan_create: no memory for the edges of %llu triangles",
                                 (unsigned long long)e->plan->info.triangles);
    }
    *closed = all_cancel(e);
    return SVO_OK;
}

svo_status svo_i_plan_is_closed(const svo_plan *plan, const svo_mesh *mesh, bool *closed)
{
    edges e = {.plan = plan, .mesh = mesh};
    const svo_status status = find(&e, closed);
    svo_i_free(e.first);
    svo_i_free(e.begin);
    svo_i_free(e.middle);
    svo_i_free(e.ends);
    svo_i_free(e.balance);
    return status;
}
