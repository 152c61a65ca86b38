/* SPDX-License-Identifier: MIT */
/*
 * Judges the places of probes by rays, and looks for better ones nearby.
 *
 * A place is bad where more than half of its directions see surfaces from behind, or where one is nearer than a leaf's
 * edge. Candidates are the centers of the cells of a level of the grid, within half a step on each axis and inside the
 * box, nearest first. Those that a probe behind a surface sees from there are behind it too and need no rays.
 *
 * Rays are aimed and judged on the host: there are few, and the order of candidates is that of a list.
 */
#include "probes/place.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/device.h"
#include "probes/encoding.h"
#include "probes/plan.h"

/* Rays that go to the device and back at once. */
#define TRIP_RAYS ((size_t)1 << 16)

/* A cell's center near a probe. */
typedef struct candidate {
    double squared; /* of its distance from the probe */
    uint32_t order; /* among those of one distance */
    float position[3];
} candidate;

typedef struct search {
    const svo_i_probe_bands *bands;
    svo_ray *rays; /* trip_rays, like the hits */
    uint32_t *hits;
    size_t trip_rays;
    float *reach; /* how far each of them went, world units, for the probes that are judged */
    candidate *candidates; /* svo_i_place_candidates */
    uint64_t traced;
} search;

/* What a place is like. */
typedef struct verdict {
    bool behind, close;
} verdict;

static bool is_good(verdict of)
{
    return !of.behind && !of.close;
}

/* ---- rays ---- */

/* Rays from a place in the directions of a map. */
static void aim(const float position[3], uint32_t resolution, svo_ray *rays)
{
    for (uint32_t i = 0; i < resolution * resolution; ++i) {
        int32_t vector[3];
        svo_i_probe_texel_vector(resolution, i % resolution, i / resolution, vector);
        for (int axis = 0; axis < 3; ++axis) {
            rays[i].origin[axis] = position[axis];
            rays[i].direction[axis] = (float)vector[axis];
        }
        rays[i].t_min = 0.0F;
        rays[i].t_max = INFINITY;
    }
}

static svo_status trace(search *of, size_t ray_count)
{
    const svo_i_probe_bands *bands = of->bands;
    svo_i_device_work *work = bands->work;
    of->traced += ray_count;
    SVO_I_TRY(svo_i_work_write(work, bands->rays, of->rays, ray_count * sizeof *of->rays));
    SVO_I_TRY(svo_i_sight_trace(bands->probes, work, bands->rays, bands->hits, ray_count));
    return svo_i_work_read(work, bands->hits, 0, of->hits, ray_count * bands->hit_words * sizeof *of->hits);
}

/* The distance of a hit, world units, and whether it is seen from behind. */
static double read_hit(const uint32_t *hit, const int32_t vector[3], bool *behind)
{
    float t = 0.0F;
    float normal[3];
    double along = 0;
    double squared = 0;
    memcpy(&t, hit, sizeof t);
    memcpy(normal, hit + 4, sizeof normal);
    for (int axis = 0; axis < 3; ++axis) {
        along += (double)normal[axis] * vector[axis];
        squared += (double)vector[axis] * vector[axis];
    }
    *behind = t < INFINITY && along > 0;
    return (double)t * sqrt(squared);
}

/* reach: receives the distances; NULL allowed. */
static verdict judge(const search *of, const uint32_t *hits, uint32_t resolution, float *reach)
{
    const svo_i_probe_bands *bands = of->bands;
    const uint32_t texels = resolution * resolution;
    uint32_t behind_count = 0;
    verdict out = {.close = false};
    for (uint32_t i = 0; i < texels; ++i) {
        int32_t vector[3];
        bool behind = false;
        svo_i_probe_texel_vector(resolution, i % resolution, i / resolution, vector);
        const double distance = read_hit(hits + (size_t)i * bands->hit_words, vector, &behind);
        behind_count += behind ? 1 : 0;
        out.close = out.close || distance < (double)bands->probes->info.leaf_edge;
        if (reach != NULL) {
            reach[i] = (float)distance;
        }
    }
    out.behind = 2 * behind_count > texels;
    return out;
}

/* ---- candidates ---- */

static int compare(const void *a, const void *b)
{
    const candidate *first = a;
    const candidate *second = b;
    if (first->squared != second->squared) {
        return first->squared < second->squared ? -1 : 1;
    }
    return first->order < second->order ? -1 : first->order > second->order;
}

/* A probe that is moved. */
typedef struct bad_probe {
    svo_probe *probe;
    const float *reach; /* how far it sees; NULL: it is too close, but not behind a surface */
} bad_probe;

/* Whether the probe sees a place, which is then on its side of all surfaces. */
static bool sees(const search *of, const bad_probe *bad, const float position[3])
{
    const double leaf_edge = (double)of->bands->probes->info.leaf_edge;
    float way[3];
    double squared = 0;
    uint32_t column = 0;
    uint32_t row = 0;
    for (int axis = 0; axis < 3; ++axis) {
        way[axis] = position[axis] - bad->probe->position[axis];
        squared += (double)way[axis] * (double)way[axis];
    }
    if (!(squared > 0)) {
        return true;
    }
    svo_probe_texel(SVO_I_PLACE_RESOLUTION, way, &column, &row);
    return sqrt(squared) + leaf_edge < (double)bad->reach[row * SVO_I_PLACE_RESOLUTION + column];
}

/* The first and last cell on an axis whose centers are within half a step of a coordinate and inside the box. */
static void find_cells(const svo_probe_info *info, int axis, float coordinate, double edge, int64_t range[2])
{
    const double half = 0.5 * (double)info->step[axis];
    const double low = fmax((double)coordinate - half, (double)info->low[axis]) - (double)info->low[axis];
    const double high = fmin((double)coordinate + half, (double)info->high[axis]) - (double)info->low[axis];
    range[0] = (int64_t)ceil(low / edge - 0.5);
    range[1] = low <= high ? (int64_t)floor(high / edge - 0.5) : range[0] - 1;
}

static candidate candidate_of(const svo_probe_info *info, const float position[3], const int64_t cell[3], double edge)
{
    candidate out = {.squared = 0};
    for (int axis = 0; axis < 3; ++axis) {
        const double center = (double)info->low[axis] + ((double)cell[axis] + 0.5) * edge;
        const double way = center - (double)position[axis];
        out.position[axis] = (float)center;
        out.squared += way * way;
    }
    return out;
}

/* Lists the candidates of a probe in their order. */
static uint32_t list_candidates(search *of, const bad_probe *bad)
{
    const float *position = bad->probe->position;
    const svo_probe_info *info = &of->bands->probes->info;
    const double edge = svo_i_place_cell_edge(info);
    int64_t ranges[3][2];
    int64_t cell[3];
    uint32_t count = 0;
    uint32_t order = 0;
    for (int axis = 0; axis < 3; ++axis) {
        find_cells(info, axis, position[axis], edge, ranges[axis]);
    }
    for (cell[2] = ranges[2][0]; cell[2] <= ranges[2][1]; ++cell[2]) {
        for (cell[1] = ranges[1][0]; cell[1] <= ranges[1][1]; ++cell[1]) {
            for (cell[0] = ranges[0][0]; cell[0] <= ranges[0][1]; ++cell[0]) {
                candidate *next = &of->candidates[count];
                *next = candidate_of(info, position, cell, edge);
                next->order = order++;
                count += bad->reach != NULL && sees(of, bad, next->position) ? 0 : 1;
            }
        }
    }
    qsort(of->candidates, count, sizeof *of->candidates, compare);
    return count;
}

/* Judges one candidate fully. */
static svo_status judge_candidate(search *of, const candidate *tried, bool *good)
{
    aim(tried->position, SVO_I_PLACE_RESOLUTION, of->rays);
    SVO_I_TRY(trace(of, SVO_I_PLACE_TEXELS));
    *good = is_good(judge(of, of->hits, SVO_I_PLACE_RESOLUTION, NULL));
    return SVO_OK;
}

/* Tries some candidates by a few rays each. passed: receives a flag for each. */
static svo_status try_first(search *of, const candidate *tried, uint32_t count, bool *passed)
{
    const size_t texels = SVO_I_PLACE_FIRST_TEXELS;
    for (uint32_t i = 0; i < count; ++i) {
        aim(tried[i].position, SVO_I_PLACE_FIRST, of->rays + i * texels);
    }
    SVO_I_TRY(trace(of, count * texels));
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t *hits = of->hits + i * texels * of->bands->hit_words;
        passed[i] = is_good(judge(of, hits, SVO_I_PLACE_FIRST, NULL));
    }
    return SVO_OK;
}

/* Candidates that are tried at once. */
#define TRIED_AT_ONCE 16u

/* Moves a probe to its first good candidate, or switches it off. */
static svo_status move(search *of, const bad_probe *bad)
{
    svo_probe *probe = bad->probe;
    const uint32_t count = list_candidates(of, bad);
    for (uint32_t first = 0; first < count; first += TRIED_AT_ONCE) {
        const uint32_t tried = count - first < TRIED_AT_ONCE ? count - first : TRIED_AT_ONCE;
        bool passed[TRIED_AT_ONCE] = {false};
        SVO_I_TRY(try_first(of, of->candidates + first, tried, passed));
        for (uint32_t i = 0; i < tried; ++i) {
            bool good = false;
            if (passed[i]) {
                SVO_I_TRY(judge_candidate(of, &of->candidates[first + i], &good));
            }
            if (good) {
                memcpy(probe->position, of->candidates[first + i].position, sizeof probe->position);
                probe->state = SVO_PROBE_MOVED;
                return SVO_OK;
            }
        }
    }
    probe->state = SVO_PROBE_OFF;
    return SVO_OK;
}

/* ---- all probes ---- */

/* Judges some probes at once, then moves the bad ones one by one. */
static svo_status settle_some(search *of, svo_probe *probes, uint32_t count, verdict *verdicts)
{
    for (uint32_t i = 0; i < count; ++i) {
        aim(probes[i].position, SVO_I_PLACE_RESOLUTION, of->rays + i * SVO_I_PLACE_TEXELS);
    }
    SVO_I_TRY(trace(of, count * SVO_I_PLACE_TEXELS));
    for (uint32_t i = 0; i < count; ++i) {
        const size_t first = i * SVO_I_PLACE_TEXELS;
        verdicts[i] = judge(of, of->hits + first * of->bands->hit_words, SVO_I_PLACE_RESOLUTION, of->reach + first);
    }
    for (uint32_t i = 0; i < count; ++i) {
        const bad_probe bad = {&probes[i], verdicts[i].behind ? of->reach + i * SVO_I_PLACE_TEXELS : NULL};
        if (!is_good(verdicts[i])) {
            SVO_I_TRY(move(of, &bad));
        }
    }
    return SVO_OK;
}

static svo_status settle(search *of, svo_probe *probes)
{
    verdict verdicts[TRIP_RAYS / SVO_I_PLACE_TEXELS];
    const uint32_t count = of->bands->probes->info.probe_count;
    const uint32_t at_once = (uint32_t)(of->trip_rays / SVO_I_PLACE_TEXELS);
    for (uint32_t first = 0; first < count; first += at_once) {
        SVO_I_TRY(settle_some(of, probes + first, count - first < at_once ? count - first : at_once, verdicts));
    }
    return SVO_OK;
}

static svo_status begin(const svo_i_probe_bands *bands, search *out)
{
    const svo_i_memory *memory = &bands->work->device->memory;
    const size_t rays = bands->most_rays < TRIP_RAYS ? bands->most_rays : TRIP_RAYS;
    *out = (search){.bands = bands, .trip_rays = rays / SVO_I_PLACE_TEXELS * SVO_I_PLACE_TEXELS};
    out->rays = svo_i_alloc_zeroed(memory, rays, sizeof *out->rays);
    out->hits = svo_i_alloc_zeroed(memory, rays * bands->hit_words, sizeof *out->hits);
    out->reach = svo_i_alloc_zeroed(memory, rays, sizeof *out->reach);
    out->candidates =
        svo_i_alloc_zeroed(memory, (size_t)svo_i_place_candidates(&bands->probes->info), sizeof *out->candidates);
    return out->rays != NULL && out->hits != NULL && out->reach != NULL && out->candidates != NULL
               ? SVO_OK
               : svo_i_device_fail(bands->work->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu rays",
                                   bands->work->function, rays);
}

static void end(search *of)
{
    svo_i_free(of->rays);
    svo_i_free(of->hits);
    svo_i_free(of->reach);
    svo_i_free(of->candidates);
}

/* Where the grid has the probes. */
static void put_in_place(const svo_probe_info *info, svo_probe *probes)
{
    for (uint32_t i = 0; i < info->probe_count; ++i) {
        const uint32_t at[3] = {i % info->counts[0], i / info->counts[0] % info->counts[1],
                                i / info->counts[0] / info->counts[1]};
        for (int axis = 0; axis < 3; ++axis) {
            probes[i].position[axis] = (float)((double)info->start[axis] + at[axis] * (double)info->step[axis]);
        }
        probes[i].state = SVO_PROBE_IN_PLACE;
    }
}

static void count_states(const svo_probe *probes, svo_probe_info *info)
{
    info->moved = info->off = 0;
    for (uint32_t i = 0; i < info->probe_count; ++i) {
        info->moved += probes[i].state == SVO_PROBE_MOVED ? 1 : 0;
        info->off += probes[i].state == SVO_PROBE_OFF ? 1 : 0;
    }
    info->rays = (uint64_t)(info->probe_count - info->off) * info->resolution * info->resolution;
}

svo_status svo_i_probes_place(svo_i_probe_bands *bands, bool keep)
{
    svo_i_device_work *work = bands->work;
    svo_probe_info *info = &bands->probes->info;
    search of = {.rays = NULL};
    svo_status status = SVO_OK;
    svo_probe *probes = svo_i_alloc_zeroed(&work->device->memory, info->probe_count, sizeof *probes);
    if (probes == NULL) {
        return svo_i_device_fail(work->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u probes", work->function,
                                 info->probe_count);
    }
    put_in_place(info, probes);
    if (!keep) {
        SVO_I_TRY_CLEANUP(begin(bands, &of));
        SVO_I_TRY_CLEANUP(settle(&of, probes));
    }
    info->place_rays = of.traced;
    count_states(probes, info);
    SVO_I_TRY_CLEANUP(
        svo_i_work_write(work, bands->probes->buffers[SVO_PROBES_PLACES], probes, info->bytes[SVO_PROBES_PLACES]));

cleanup:
    end(&of);
    svo_i_free(probes);
    return status;
}
