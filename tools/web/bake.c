/* SPDX-License-Identifier: MIT */
/*
 * Bakes indirect light for pages, whose shaders trace no cones. Irradiance changes slowly from place to place, but not
 * from direction to direction: so it is kept for few places and six directions, of which a surface blends the three
 * that it faces by the squares of its normal (McTaggart, "Half-Life 2 / Valve Source Shading", 2004). Pages interpolate
 * between the places.
 */
#include "web/bake.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/nodes.h"

#define NODES_MAX ((uint64_t)1 << 16)
/* Points that are gathered at once. */
#define POINTS_AT_ONCE ((size_t)1 << 15)
/* Nodes whose leaves face a direction less than this, as a mean of squared cosines, have no light from there. */
#define FACING_MIN 0.02F
/* Leaves that face away count so little: where others face the direction, their side of a wall has the point. */
#define AWAY_WEIGHT 1e-4F
/* Squared cosine of leaves without a normal. */
#define ANY_FACING 0.33F
/* Points inside of solids are as closed, and as dark beside the brightest. */
#define CLOSED     0.02F
#define DARK_SHARE 1e-3F

/* Where the leaves of a node lie that face a direction. */
typedef struct facing {
    float weight, place[3]; /* sums; places in voxels */
    float mass; /* sum of squared cosines of both sides */
} facing;

typedef struct baking {
    const web_tree *tree;
    uint32_t level;
    uint64_t first, count; /* nodes of the level, and leaves above it */
    uint64_t *codes; /* of all nodes of the tree */
    facing (*faces)[WEB_LIGHT_FACES]; /* count */
    uint32_t *leaf_counts; /* count */
    svo_gather_point *points;
    svo_gather_result *results;
    uint32_t *slots; /* of the points: node * 6 + direction */
    size_t point_count;
} baking;

/* ---- where the leaves are ---- */

/* The deepest level of few nodes. */
static uint32_t find_level(const web_tree *tree)
{
    uint32_t level = tree->info.depth;
    while (level > 1 && web_cut_at(tree, level).node_count - web_cut_at(tree, level - 1).node_count > NODES_MAX) {
        --level;
    }
    return level;
}

/* The unit normal of a node; false: it has none. */
static bool read_normal(const web_tree *tree, const web_payload *normals, uint64_t node, float out[3])
{
    if (normals->count == 0 || node < normals->first) {
        return false;
    }
    const int16_t *stored = tree->arrays.normals + 3 * (node - normals->first) * normals->stride;
    const float x = stored[0];
    const float y = stored[1];
    const float z = stored[2];
    const float length = sqrtf(x * x + y * y + z * z);
    for (int axis = 0; axis < 3 && length > 0.0F; ++axis) {
        out[axis] = (float)stored[axis] / length;
    }
    return length > 0.2F * 32767.0F;
}

/* cell: of the leaf, width voxels wide. Leaves without a normal count the more, the farther out they are. */
static void add_leaf(facing faces[WEB_LIGHT_FACES], const uint32_t cell[3], uint32_t width, const float *normal,
                     uint32_t node_width)
{
    for (unsigned face = 0; face < WEB_LIGHT_FACES; ++face) {
        const unsigned axis = face >> 1;
        const float inside = (float)(cell[axis] * width % node_width);
        const float beyond = (face & 1u) == 0 ? (float)node_width - inside : inside + (float)width;
        const float cosine = normal != NULL ? ((face & 1u) == 0 ? normal[axis] : -normal[axis]) : 0.0F;
        const float square = normal != NULL ? cosine * cosine : ANY_FACING;
        const float outer = exp2f(-fminf(2.0F * beyond / (float)width, 60.0F));
        const float share = normal == NULL ? outer : cosine > 0.0F ? 1.0F : AWAY_WEIGHT;
        faces[face].mass += square;
        faces[face].weight += share * square;
        for (int k = 0; k < 3; ++k) {
            faces[face].place[k] += share * square * ((float)cell[k] + 0.5F) * (float)width;
        }
    }
}

/* Adds each leaf to its node, the ancestor on the level, or to itself where it is above that. */
static void add_leaves(baking *work)
{
    const web_tree *tree = work->tree;
    const uint32_t depth = tree->info.depth;
    const uint8_t *masks = tree->arrays.nodes;
    const web_payload normals = web_cut_at(tree, depth).normals;
    uint64_t node = 0;
    for (uint32_t level = 0; level <= depth; ++level) {
        const uint64_t end = web_cut_at(tree, level).node_count;
        uint64_t above = level > work->level ? web_cut_at(tree, work->level - 1).node_count : 0;
        for (; node < end; ++node) {
            if (level < depth && masks[node] != 0) {
                continue;
            }
            uint32_t cell[3];
            float normal[3];
            const bool has_normal = read_normal(tree, &normals, node, normal);
            svo_code_to_cell(work->codes[node], cell);
            while (level > work->level && work->codes[above] != work->codes[node] >> 3 * (level - work->level)) {
                ++above;
            }
            const uint64_t at = level > work->level ? above : node;
            add_leaf(work->faces[at], cell, 1u << (depth - level), has_normal ? normal : NULL,
                     1u << (depth - (level < work->level ? level : work->level)));
            ++work->leaf_counts[at];
        }
    }
}

/* ---- light ---- */

static void add_points(baking *work)
{
    const svo_compact_info *info = &work->tree->info;
    const double edge = web_tree_edge(work->tree, info->depth);
    for (uint64_t node = 0; node < work->count; ++node) {
        for (unsigned face = 0; face < WEB_LIGHT_FACES; ++face) {
            const facing *seen = &work->faces[node][face];
            if (!(seen->weight > 0.0F) || seen->mass < FACING_MIN * (float)work->leaf_counts[node]) {
                continue;
            }
            svo_gather_point *point = &work->points[work->point_count];
            *point = (svo_gather_point){.exponent = 0.0F};
            point->normal[face >> 1] = (face & 1u) == 0 ? 1.0F : -1.0F;
            for (int axis = 0; axis < 3; ++axis) {
                const double voxels = (double)seen->place[axis] / (double)seen->weight;
                point->position[axis] = (float)(info->origin[axis] + edge * voxels);
            }
            work->slots[work->point_count++] = (uint32_t)(node * WEB_LIGHT_FACES + face);
        }
    }
}

static int gather(program *state, const lighting *lit, const session *opened, baking *work)
{
    svo_gather_options cones = lighting_gather(&state->options);
    /* The places are means of leaves, which rays would begin below the surface. */
    cones.method = cones.method == SVO_GATHER_AUTO ? SVO_GATHER_CONES : cones.method;
    for (size_t at = 0; at < work->point_count; at += POINTS_AT_ONCE) {
        const size_t left = work->point_count - at;
        if (svo_gather(lit->light, svo_in_host(work->points + at), svo_in_host(work->results + at),
                       left < POINTS_AT_ONCE ? left : POINTS_AT_ONCE, &cones,
                       &(svo_submit){.queue = opened->queue}) != SVO_OK) {
            return program_fail_library(state, svo_device_message(opened->device));
        }
    }
    return PROGRAM_DONE;
}

static float brightness(const float light[3])
{
    return fmaxf(light[0], fmaxf(light[1], light[2]));
}

/* What is closed and dark is inside of a solid, whose surfaces would look darker beside it. */
static void take_results(const baking *work, float (*light)[WEB_LIGHT_FACES][3], bool (*lit)[WEB_LIGHT_FACES])
{
    float most = 0.0F;
    for (size_t i = 0; i < work->point_count; ++i) {
        most = fmaxf(most, brightness(work->results[i].irradiance));
    }
    for (size_t i = 0; i < work->point_count; ++i) {
        const svo_gather_result *result = &work->results[i];
        const uint32_t node = work->slots[i] / WEB_LIGHT_FACES;
        const uint32_t face = work->slots[i] % WEB_LIGHT_FACES;
        lit[node][face] = result->openness > CLOSED || brightness(result->irradiance) > DARK_SHARE * most;
        memcpy(light[node][face], result->irradiance, sizeof result->irradiance);
    }
}

/* The means of children, from the level upwards. */
static void fill_upwards(const baking *work, float (*light)[WEB_LIGHT_FACES][3], bool (*lit)[WEB_LIGHT_FACES])
{
    const uint8_t *masks = work->tree->arrays.nodes;
    uint64_t child = work->count;
    for (uint64_t node = work->first; node-- > 0;) {
        const unsigned mask = masks[node];
        for (unsigned octant = 0; octant < 8 && mask != 0; ++octant) {
            if ((mask >> octant & 1u) == 0) {
                continue;
            }
            --child;
            for (unsigned face = 0; face < WEB_LIGHT_FACES; ++face) {
                if (lit[child][face]) {
                    /* The mean of an unknown number: the share of this child is 1 / (those before it + 1). */
                    const float share = 1.0F / (work->faces[node][face].mass += 1.0F);
                    for (int channel = 0; channel < 3; ++channel) {
                        float *mean = &light[node][face][channel];
                        *mean += share * (light[child][face][channel] - *mean);
                    }
                    lit[node][face] = true;
                }
            }
        }
    }
}

static int pack(program *state, const baking *work, web_light *out)
{
    float(*light)[WEB_LIGHT_FACES][3] = calloc((size_t)work->count, sizeof *light);
    bool(*lit)[WEB_LIGHT_FACES] = calloc((size_t)work->count, sizeof *lit);
    out->texels = calloc((size_t)work->count, sizeof *out->texels);
    const bool has_room = light != NULL && lit != NULL && out->texels != NULL;
    if (has_room) {
        take_results(work, light, lit);
        fill_upwards(work, light, lit);
        for (uint64_t node = 0; node < work->count; ++node) {
            for (unsigned face = 0; face < WEB_LIGHT_FACES; ++face) {
                if (lit[node][face]) {
                    web_pack_light(light[node][face], out->texels[node][face]);
                }
            }
        }
        out->level = work->level;
        out->node_count = work->count;
    }
    free(light);
    free(lit);
    return has_room ? PROGRAM_DONE : program_fail(state, PROGRAM_FAILED, "out of memory for the baked light");
}

/* ---- all of it ---- */

static bool allocate(baking *work)
{
    const size_t count = (size_t)work->count;
    work->codes = web_tree_codes(work->tree, work->tree->info.depth);
    work->faces = calloc(count, sizeof *work->faces);
    work->leaf_counts = calloc(count, sizeof *work->leaf_counts);
    work->points = malloc(count * WEB_LIGHT_FACES * sizeof *work->points);
    work->results = malloc(count * WEB_LIGHT_FACES * sizeof *work->results);
    work->slots = malloc(count * WEB_LIGHT_FACES * sizeof *work->slots);
    return work->codes != NULL && work->faces != NULL && work->leaf_counts != NULL && work->points != NULL &&
           work->results != NULL && work->slots != NULL;
}

static void release(baking *work)
{
    free(work->codes);
    free(work->faces);
    free(work->leaf_counts);
    free(work->points);
    free(work->results);
    free(work->slots);
}

int web_bake(program *state, const web_tree *tree, const lighting *lit, const session *opened, web_light *out)
{
    baking work = {.tree = tree, .level = find_level(tree)};
    work.first = web_cut_at(tree, work.level - 1).node_count;
    work.count = web_cut_at(tree, work.level).node_count;
    progress_step(state->progress, "gathering light");
    int exit_code = allocate(&work) ? PROGRAM_DONE
                                    : program_fail(state, PROGRAM_FAILED, "out of memory for the light of %llu nodes",
                                                   (unsigned long long)work.count);
    if (exit_code == PROGRAM_DONE) {
        add_leaves(&work);
        add_points(&work);
        exit_code = gather(state, lit, opened, &work);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = pack(state, &work, out);
    }
    release(&work);
    return exit_code;
}
