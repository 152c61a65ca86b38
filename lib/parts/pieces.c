/* SPDX-License-Identifier: MIT */
/*
 * The parts that a tree is put together from, and the nodes above them: sums of these in 64-bit integers, rounded as
 * the kernels round.
 *
 * On a level, nodes under parts and nodes above deeper parts alternate in Morton order; parts of different levels do
 * not overlap, so the order of their first leaves is that of all their nodes.
 */
#include "parts/pieces.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "plan/plan_data.h"
#include "svocl/plan.h"

/* ---- sums: the host's twin of kernels/stages/sums.clh and material.cl ---- */

#define RUN_SHIFT  48
#define RUN_WEIGHT ((UINT64_C(1) << RUN_SHIFT) - 1)

/* Merges two ascending lists of materials, and adds up the weights of those in both. Returns how many there are. */
static uint32_t merge_runs(const svo_i_part_root *a, const svo_i_part_root *b, uint64_t *out)
{
    uint32_t count = 0;
    uint32_t i = 0;
    uint32_t k = 0;
    while (i < a->run_count || k < b->run_count) {
        const uint64_t first = i < a->run_count ? a->runs[i] >> RUN_SHIFT : UINT64_MAX;
        const uint64_t second = k < b->run_count ? b->runs[k] >> RUN_SHIFT : UINT64_MAX;
        const uint64_t weights =
            (first <= second ? a->runs[i] & RUN_WEIGHT : 0) + (second <= first ? b->runs[k] & RUN_WEIGHT : 0);
        out[count++] = (first <= second ? first : second) << RUN_SHIFT | weights;
        i += first <= second ? 1u : 0u;
        k += second <= first ? 1u : 0u;
    }
    return count;
}

/* Adds a child's sums to its parent's. Returns false when out of memory. */
static bool join(svo_i_part_root *to, const svo_i_part_root *from)
{
    to->sums.weight += from->sums.weight;
    for (unsigned i = 0; i < 4; ++i) {
        to->sums.color[i] += from->sums.color[i];
    }
    for (unsigned i = 0; i < 3; ++i) {
        to->sums.normal[i] += from->sums.normal[i];
    }
    if (from->run_count == 0) {
        return true;
    }
    uint64_t *merged = svo_i_alloc(NULL, ((size_t)to->run_count + from->run_count) * sizeof *merged);
    if (merged == NULL) {
        return false;
    }
    const uint32_t count = merge_runs(to, from, merged);
    svo_i_free(to->runs);
    to->runs = merged;
    to->run_count = count;
    return true;
}

/* Equal weights: the smaller material. */
static uint16_t heaviest(const svo_i_part_root *root)
{
    uint64_t most = 0;
    uint64_t material = 0;
    for (uint32_t i = 0; i < root->run_count; ++i) {
        const uint64_t weight = root->runs[i] & RUN_WEIGHT;
        material = weight > most ? root->runs[i] >> RUN_SHIFT : material;
        most = weight > most ? weight : most;
    }
    return (uint16_t)material;
}

/* Surface in 4096ths of a node's face, rounded half up, 65535 at most. */
static uint16_t fill_of(uint64_t weight, uint32_t shift)
{
    const uint64_t fill = shift > 62 ? 0 : ((weight >> (shift - 1)) + 1) >> 1;
    return (uint16_t)(fill < UINT16_MAX ? fill : UINT16_MAX);
}

/* Rounds the sums of a node once; all zero for a node without weight. face_log2: the weight of its face, as a power of
   two. */
static svo_i_part_payload round_sums(const svo_i_part_root *root, uint32_t face_log2)
{
    const uint64_t weight = root->sums.weight;
    svo_i_part_payload payload = {.material = heaviest(root)};
    if (weight == 0) {
        return payload;
    }
    const uint64_t alpha = root->sums.color[3];
    for (unsigned i = 0; i < 4; ++i) {
        const uint64_t by = i == 3 || alpha == 0 ? weight : alpha;
        payload.color[i] = (uint8_t)((2 * root->sums.color[i] + by) / (2 * by));
    }
    /* 0 and 255 are the alphas of nothing and all. */
    const uint8_t least = alpha != 0 ? 1 : 0;
    const uint8_t most = alpha == 255 * weight ? 255 : 254;
    payload.color[3] = payload.color[3] < least ? least : payload.color[3] > most ? most : payload.color[3];
    /* The offset makes the dividend positive, since a sum is at most 32768 times the weight. */
    for (unsigned i = 0; i < 3; ++i) {
        const uint64_t shifted = 2 * (uint64_t)root->sums.normal[i] + weight + (weight << 16);
        payload.normal[i] = (int16_t)((int64_t)(shifted / (2 * weight)) - 32768);
    }
    payload.fill = face_log2 > SVO_I_FILL_LOG2 ? fill_of(weight, face_log2 - SVO_I_FILL_LOG2) : 0;
    return payload;
}

/* ---- pieces ---- */

static svo_status no_memory(const svo_i_pieces *all)
{
    return svo_i_fail(all->message, SVO_OUT_OF_HOST_MEMORY, "svo_parts_stitch: no memory for %zu parts",
                      all->piece_count);
}

/* ---- the parts ---- */

/* A visitor that appends the bytes of a segment to the runs. */
static svo_status append_runs(void *user, const void *bytes, size_t byte_count)
{
    svo_i_part_root *root = user;
    memcpy(root->runs + root->run_count, bytes, byte_count);
    root->run_count += (uint32_t)(byte_count / sizeof *root->runs);
    return SVO_OK;
}

static svo_status read_runs(const svo_i_part_reader *reader, svo_i_part_root *root)
{
    const part_segment *segment = svo_i_part_find(reader, PART_RUNS, 0);
    if (segment == NULL) {
        return SVO_OK;
    }
    if (segment->bytes % sizeof *root->runs != 0 || segment->bytes > UINT16_MAX * sizeof *root->runs) {
        return svo_i_part_damaged(reader, "its materials are too many");
    }
    root->runs = svo_i_alloc(NULL, (size_t)segment->bytes + 1);
    return root->runs != NULL ? svo_i_part_stream(reader, segment, append_runs, root)
                              : svo_i_fail(reader->message, SVO_OUT_OF_HOST_MEMORY,
                                           "svo_parts_stitch: no memory for the materials of a part");
}

/* Reads the head of a part file. *piece stays as it is for a part without nodes. */
static svo_status read_piece(const svo_i_pieces *all, const char *path, svo_i_piece *piece)
{
    svo_i_part_reader reader = {.file = -1};
    svo_status status = SVO_OK;
    const part_head *head = &reader.content.head;
    SVO_I_TRY_CLEANUP(svo_i_part_open(&all->header, path, false, all->message, &reader));
    if (head->level_begin[1] == 0) {
        goto cleanup;
    }
    const part_segment *list = svo_i_part_find(&reader, SVO_TREE_LIST, all->header.depth - head->level);
    *piece = (svo_i_piece){.path = path,
                           .level = head->level,
                           .code = head->code,
                           .head_hash = head->head_hash,
                           .fragments = head->fragments,
                           .list_count = list != NULL ? list->bytes / sizeof(uint32_t) : 0,
                           .file_bytes = head->file_bytes,
                           .root.sums = head->root};
    memcpy(piece->level_begin, head->level_begin, sizeof piece->level_begin);
    status = read_runs(&reader, &piece->root);
cleanup:
    svo_i_part_close(&reader);
    return status;
}

/* The code of a part's first leaf on a grid of SVO_PARTS_DEPTH_MAX. */
static uint64_t first_leaf(const svo_i_piece *piece)
{
    return piece->code << (3 * (SVO_PARTS_DEPTH_MAX - piece->level));
}

static int compare_pieces(const void *a, const void *b)
{
    const uint64_t first = first_leaf(a);
    const uint64_t second = first_leaf(b);
    return (first > second) - (first < second);
}

static svo_status check_overlap(const svo_i_pieces *all)
{
    for (size_t i = 1; i < all->piece_count; ++i) {
        const svo_i_piece *before = &all->pieces[i - 1];
        if (first_leaf(&all->pieces[i]) - first_leaf(before) < UINT64_C(1)
                                                                   << (3 * (SVO_PARTS_DEPTH_MAX - before->level))) {
            return svo_i_fail(all->message, SVO_FILE_DAMAGED, "%s: overlaps %s", all->pieces[i].path, before->path);
        }
    }
    return SVO_OK;
}

/* ---- the nodes above them ---- */

/* The code of the node above a part, or of the part, on a level. */
static uint64_t code_on(const svo_i_piece *piece, uint32_t level)
{
    return piece->code >> (3 * (piece->level - level));
}

bool svo_i_pieces_begins_upper(const svo_i_pieces *all, size_t i, uint32_t level)
{
    const svo_i_piece *piece = &all->pieces[i];
    const bool above = piece->level > level;
    return above && (i == 0 || all->pieces[i - 1].level <= level ||
                     code_on(&all->pieces[i - 1], level) != code_on(piece, level));
}

/* Lists the nodes above the parts; the root is there even without parts. */
static svo_status list_uppers(svo_i_pieces *all)
{
    const uint32_t depth = all->header.depth;
    size_t count = all->piece_count == 0 ? 1 : 0;
    for (uint32_t level = 0; level < depth; ++level) {
        for (size_t i = 0; i < all->piece_count; ++i) {
            count += svo_i_pieces_begins_upper(all, i, level) ? 1u : 0u;
        }
        all->upper_begin[level + 1] = count;
    }
    all->uppers = svo_i_alloc_zeroed(NULL, count + 1, sizeof *all->uppers);
    if (all->uppers == NULL) {
        return no_memory(all);
    }
    size_t next = 0;
    for (uint32_t level = 0; level < depth; ++level) {
        for (size_t i = 0; i < all->piece_count; ++i) {
            if (svo_i_pieces_begins_upper(all, i, level)) {
                all->uppers[next++].code = code_on(&all->pieces[i], level);
            }
        }
    }
    return SVO_OK;
}

/* Calls for the nodes of a level in their order. */
static svo_status visit_level(const svo_i_pieces *all, uint32_t level, svo_i_piece_visitor visit, void *user)
{
    const svo_i_upper_node *upper = all->uppers + all->upper_begin[level];
    for (size_t i = 0; i < all->piece_count; ++i) {
        if (all->pieces[i].level <= level) {
            SVO_I_TRY(visit(user, level, NULL, &all->pieces[i]));
        } else if (svo_i_pieces_begins_upper(all, i, level)) {
            SVO_I_TRY(visit(user, level, upper++, NULL));
        }
    }
    return SVO_OK;
}

/* Sums of the level below go to a level's nodes. user: the next node to receive children. */
typedef struct joining {
    const svo_i_pieces *all;
    svo_i_upper_node *parent;
} joining;

static svo_status join_child(void *user, uint32_t level, const svo_i_upper_node *upper, const svo_i_piece *piece)
{
    joining *job = user;
    if (piece != NULL && piece->level < level) {
        return SVO_OK; /* the parent is in the part */
    }
    const uint64_t code = piece != NULL ? piece->code : upper->code;
    while (job->parent->code != code >> 3) {
        ++job->parent;
    }
    job->parent->mask |= (uint8_t)(1u << (code & 7));
    return join(&job->parent->root, piece != NULL ? &piece->root : &upper->root) ? SVO_OK : no_memory(job->all);
}

static svo_status sum_up(svo_i_pieces *all)
{
    const svo_part_header *header = &all->header;
    for (uint32_t level = header->depth - 1; level-- > 0;) {
        joining job = {.all = all, .parent = all->uppers + all->upper_begin[level]};
        if (all->upper_begin[level + 1] > all->upper_begin[level]) {
            SVO_I_TRY(visit_level(all, level + 1, join_child, &job));
        }
        for (size_t i = all->upper_begin[level]; i < all->upper_begin[level + 1]; ++i) {
            all->uppers[i].payload =
                round_sums(&all->uppers[i].root, header->weight_log2 + 2 * (header->depth - level));
        }
    }
    return SVO_OK;
}

/* ---- all together ---- */

svo_status svo_i_pieces_read(svo_i_pieces *all, const char *const *paths, size_t count)
{
    all->pieces = svo_i_alloc_zeroed(NULL, count + 1, sizeof *all->pieces);
    if (all->pieces == NULL) {
        return no_memory(all);
    }
    for (size_t i = 0; i < count; ++i) {
        svo_i_piece *piece = &all->pieces[all->piece_count];
        const svo_status status = read_piece(all, paths[i], piece);
        all->piece_count += piece->path != NULL ? 1u : 0u;
        SVO_I_TRY(status);
    }
    qsort(all->pieces, all->piece_count, sizeof *all->pieces, compare_pieces);
    SVO_I_TRY(check_overlap(all));
    SVO_I_TRY(list_uppers(all));
    return sum_up(all);
}

void svo_i_pieces_free(svo_i_pieces *all)
{
    for (size_t i = 0; i < all->piece_count; ++i) {
        svo_i_free(all->pieces[i].root.runs);
    }
    for (size_t i = 0; all->uppers != NULL && i < all->upper_begin[all->header.depth]; ++i) {
        svo_i_free(all->uppers[i].root.runs);
    }
    svo_i_free(all->pieces);
    svo_i_free(all->uppers);
}

uint64_t svo_i_pieces_count_level(const svo_i_pieces *all, uint32_t level)
{
    uint64_t nodes = level < all->header.depth ? all->upper_begin[level + 1] - all->upper_begin[level] : 0;
    for (size_t i = 0; i < all->piece_count; ++i) {
        const svo_i_piece *piece = &all->pieces[i];
        if (piece->level <= level) {
            nodes += piece->level_begin[level - piece->level + 1] - piece->level_begin[level - piece->level];
        }
    }
    return nodes;
}

svo_status svo_i_pieces_count(const svo_i_pieces *all, svo_tree_info *info)
{
    uint64_t begin[SVO_PARTS_LEVELS_MAX] = {0};
    const uint32_t depth = all->header.depth;
    for (uint32_t level = 0; level <= depth; ++level) {
        begin[level + 1] = begin[level] + svo_i_pieces_count_level(all, level);
    }
    for (size_t i = 0; i < all->piece_count; ++i) {
        info->fragments += all->pieces[i].fragments;
        info->list_count += all->pieces[i].list_count;
    }
    if (depth > SVO_DEPTH_MAX) {
        return svo_i_fail(all->message, SVO_CAPACITY_EXCEEDED,
                          "svo_parts_stitch: depth %" PRIu32 " is above the %d of a .svo file; the folder of parts is "
                          "a tree in itself (svocl info, hash, render --paged, convert --levels or --region)",
                          depth, SVO_DEPTH_MAX);
    }
    if (begin[depth + 1] > PIECES_NODES_MAX || info->list_count > PIECES_NODES_MAX) {
        return svo_i_fail(all->message, SVO_CAPACITY_EXCEEDED,
                          "svo_parts_stitch: the tree has %" PRIu64 " nodes and %" PRIu64
                          " list entries, above the 2^32 - 2 of a .svo file; the folder of parts is a tree in itself "
                          "(svocl info, hash, render --paged, convert --levels), or lower the depth",
                          begin[depth + 1], info->list_count);
    }
    for (uint32_t level = 0; level <= depth + 1; ++level) {
        info->level_begin[level] = (uint32_t)begin[level];
    }
    info->inner_count = begin[depth];
    info->node_count = begin[depth + 1];
    info->leaf_count = info->node_count - info->inner_count;
    return SVO_OK;
}

svo_status svo_i_pieces_visit_all(const svo_i_pieces *all, svo_i_piece_visitor visit, void *user)
{
    size_t next[SVO_PARTS_LEVELS_MAX];
    memcpy(next, all->upper_begin, sizeof next);
    if (all->piece_count == 0) {
        return visit(user, 0, all->uppers, NULL);
    }
    for (size_t i = 0; i < all->piece_count; ++i) {
        const svo_i_piece *piece = &all->pieces[i];
        for (uint32_t level = 0; level < piece->level; ++level) {
            if (svo_i_pieces_begins_upper(all, i, level)) {
                SVO_I_TRY(visit(user, level, &all->uppers[next[level]++], NULL));
            }
        }
        SVO_I_TRY(visit(user, piece->level, NULL, piece));
    }
    return SVO_OK;
}
