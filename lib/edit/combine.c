/* SPDX-License-Identifier: MIT */
/*
 * Combines octrees from the root down. Where a verb's result is one of its operands, or empty, it is taken as a whole;
 * else the eight children are combined. A shape is an operand whose nodes are decided when they are met: outside is an
 * empty node, inside a uniform one. So the work follows the surfaces of both.
 */
#include "edit/combine.h"

#define TOLD_LEVEL 6u /* progress is told between cubes of 2^6 and larger ones */

/* ---- progress ---- */

bool svo_i_edit_tell(svo_i_edit_run *run, double fraction)
{
    if (run->progress == NULL || fraction <= run->fraction) {
        return true;
    }
    run->fraction = fraction;
    run->canceled = run->progress(run->progress_user, fraction) != 0;
    return !run->canceled;
}

/* What a level has of the progress: the children that are left to do share it evenly. */
typedef struct part {
    double begin;
    double share;
    uint32_t left;
    uint32_t all;
} part;

static part part_begin(const svo_i_edit_run *run, uint32_t count)
{
    return (part){.begin = run->begin, .share = run->share, .left = count, .all = count > 0 ? count : 1};
}

/* Before each of them. */
static void part_next(svo_i_edit_run *run, part *p)
{
    run->share = p->share / p->all;
    run->begin = p->begin + run->share * (p->all - p->left);
    --p->left;
}

static bool part_end(svo_i_edit_run *run, const part *p, uint32_t level)
{
    run->begin = p->begin;
    run->share = p->share;
    return level < TOLD_LEVEL || svo_i_edit_tell(run, p->begin + p->share);
}

/* ---- blocks ---- */

static bool is_uniform(const svo_i_edit_store *store, svo_i_edit_ref ref)
{
    return ref != SVO_I_EDIT_EMPTY && ref != SVO_I_EDIT_SHAPE && svo_i_edit_kind_of(store, ref) == SVO_I_EDIT_UNIFORM;
}

/* Gives the voxels of places, which both have, color and material of b. Returns whether that changes one. */
static bool take_paint(svo_i_edit_cells *a, const svo_i_edit_cells *b, uint64_t places)
{
    bool changes = false;
    for (uint64_t left = places; left != 0; left &= left - 1) {
        const uint32_t cell = svo_i_edit_lowest(left);
        changes = changes || a->color[cell] != b->color[cell] || a->material[cell] != b->material[cell];
        a->color[cell] = b->color[cell];
        a->material[cell] = b->material[cell];
    }
    return changes;
}

/* The same with its normal. */
static bool take_payload(svo_i_edit_cells *a, const svo_i_edit_cells *b, uint64_t places)
{
    bool changes = take_paint(a, b, places);
    for (uint64_t left = places; left != 0; left &= left - 1) {
        const uint32_t cell = svo_i_edit_lowest(left);
        changes = changes || a->normal[cell] != b->normal[cell];
        a->normal[cell] = b->normal[cell];
    }
    return changes;
}

/* Puts the result in a. Returns whether it differs from a. */
static bool combine_cells(const svo_i_edit_run *run, svo_i_edit_cells *a, const svo_i_edit_cells *b)
{
    bool (*const take)(svo_i_edit_cells *, const svo_i_edit_cells *, uint64_t) =
        run->store->has_normals ? take_payload : take_paint;
    const uint64_t before = a->mask;
    switch (run->verb) {
    case SVO_EDIT_SET:
    case SVO_EDIT_ADD:
        a->mask |= b->mask;
        (void)take(a, b, b->mask & ~before);
        return (run->verb == SVO_EDIT_SET && take(a, b, b->mask & before)) || a->mask != before;
    case SVO_EDIT_CLEAR:
        a->mask &= ~b->mask;
        return a->mask != before;
    case SVO_EDIT_KEEP:
        a->mask &= b->mask;
        return a->mask != before;
    default:
        return take_paint(a, b, a->mask & b->mask);
    }
}

/* Whether the shape's voxels at its surface get normals, so that a cube within it is not one of a kind. */
static bool gives_normals(const svo_i_edit_run *run)
{
    return run->store->has_normals && (run->verb == SVO_EDIT_SET || run->verb == SVO_EDIT_ADD);
}

static bool combine_blocks(svo_i_edit_run *run, svo_i_edit_ref a, svo_i_edit_ref b, const uint32_t cell[3],
                           svo_i_edit_ref *out)
{
    svo_i_edit_cells left;
    svo_i_edit_cells right;
    if (b == SVO_I_EDIT_SHAPE) {
        svo_i_edit_unpack(run->store, run->fill, &right);
        right.mask = svo_i_edit_solid_mask(&run->solid, cell);
        if (gives_normals(run)) {
            svo_i_edit_solid_normals(&run->solid, cell, right.mask, right.normal);
        }
    } else {
        svo_i_edit_unpack(run->store, b, &right);
    }
    svo_i_edit_unpack(run->store, a, &left);
    if (!combine_cells(run, &left, &right)) {
        *out = a;
        return true;
    }
    return svo_i_edit_pack(run->store, &left, out);
}

/* ---- nodes ---- */

/* Finds the result where it is one of the operands, or empty. b is not the shape's surface. */
static bool is_settled(const svo_i_edit_run *run, svo_i_edit_ref a, svo_i_edit_ref b, svo_i_edit_ref *out)
{
    const bool a_is_full = is_uniform(run->store, a);
    const bool b_is_full = is_uniform(run->store, b);
    *out = a;
    switch (run->verb) {
    case SVO_EDIT_SET:
        *out = b == SVO_I_EDIT_EMPTY ? a : b;
        return b == SVO_I_EDIT_EMPTY || b_is_full || a == SVO_I_EDIT_EMPTY || a == b;
    case SVO_EDIT_ADD:
        *out = a == SVO_I_EDIT_EMPTY ? b : a;
        return a == SVO_I_EDIT_EMPTY || a_is_full || b == SVO_I_EDIT_EMPTY || a == b;
    case SVO_EDIT_CLEAR:
        *out = b_is_full || a == b ? SVO_I_EDIT_EMPTY : a;
        return a == SVO_I_EDIT_EMPTY || b == SVO_I_EDIT_EMPTY || b_is_full || a == b;
    case SVO_EDIT_KEEP:
        *out = b == SVO_I_EDIT_EMPTY ? SVO_I_EDIT_EMPTY : a;
        return a == SVO_I_EDIT_EMPTY || b == SVO_I_EDIT_EMPTY || b_is_full || a == b;
    default:
        *out = a_is_full && b_is_full ? b : a;
        return a == SVO_I_EDIT_EMPTY || b == SVO_I_EDIT_EMPTY || a == b || (a_is_full && b_is_full);
    }
}

/* a where both are full with one payload, else made. */
static svo_i_edit_ref same_or(const svo_i_edit_store *store, svo_i_edit_ref a, svo_i_edit_ref made)
{
    if (a == made || !is_uniform(store, a) || !is_uniform(store, made)) {
        return made;
    }
    const svo_i_edit_payload left = svo_i_edit_payload_of(store, a);
    const svo_i_edit_payload right = svo_i_edit_payload_of(store, made);
    return left.color == right.color && left.material == right.material ? a : made;
}

/* Decides about the shape in a cube; b as it is for other operands. */
static svo_i_edit_ref decide(const svo_i_edit_run *run, svo_i_edit_ref b, const uint32_t cell[3], uint32_t level)
{
    if (b != SVO_I_EDIT_SHAPE) {
        return b;
    }
    const svo_i_edit_side side = svo_i_edit_solid_side(&run->solid, cell, level, gives_normals(run) ? 1 : 0);
    return side == SVO_I_EDIT_OUTSIDE ? SVO_I_EDIT_EMPTY : side == SVO_I_EDIT_INSIDE ? run->fill : SVO_I_EDIT_SHAPE;
}

/* Where the surface of a shape changes nothing. */
static bool is_beside(const svo_i_edit_run *run, svo_i_edit_ref a)
{
    return run->verb == SVO_EDIT_SET   ? a == run->fill && !run->store->has_normals
           : run->verb == SVO_EDIT_ADD ? is_uniform(run->store, a)
                                       : a == SVO_I_EDIT_EMPTY || (run->verb == SVO_EDIT_PAINT && a == run->fill);
}

static void child_cell(const uint32_t cell[3], uint32_t octant, uint32_t level, uint32_t out[3])
{
    for (uint32_t axis = 0; axis < 3; ++axis) {
        out[axis] = cell[axis] + ((octant >> axis & 1u) << (level - 1u));
    }
}

/* Of a node that is not settled. */
static bool combine(svo_i_edit_run *run, svo_i_edit_ref a, svo_i_edit_ref b, uint32_t level, const uint32_t cell[3],
                    svo_i_edit_ref *out)
{
    if (level == SVO_I_EDIT_BLOCK_LEVEL) {
        return combine_blocks(run, a, b, cell, out);
    }
    svo_i_edit_ref left[8];
    svo_i_edit_ref right[8] = {0};
    svo_i_edit_ref made[8];
    uint32_t open = 0;
    uint32_t open_count = 0;
    svo_i_edit_children_of(run->store, a, left);
    if (b != SVO_I_EDIT_SHAPE) {
        svo_i_edit_children_of(run->store, b, right);
    }
    for (uint32_t octant = 0; octant < 8; ++octant) {
        uint32_t below[3];
        child_cell(cell, octant, level, below);
        right[octant] = decide(run, b == SVO_I_EDIT_SHAPE ? b : right[octant], below, level - 1);
        made[octant] = left[octant];
        const bool settled = right[octant] == SVO_I_EDIT_SHAPE
                                 ? is_beside(run, left[octant])
                                 : is_settled(run, left[octant], right[octant], &made[octant]);
        made[octant] = settled ? same_or(run->store, left[octant], made[octant]) : made[octant];
        open |= settled ? 0u : 1u << octant;
        open_count += settled ? 0u : 1u;
    }
    run->node_count += 8;
    part p = part_begin(run, open_count);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        uint32_t below[3];
        child_cell(cell, octant, level, below);
        if ((open >> octant & 1u) != 0) {
            part_next(run, &p);
            if (!combine(run, left[octant], right[octant], level - 1, below, &made[octant])) {
                return false;
            }
        }
    }
    if (!part_end(run, &p, level)) {
        return false;
    }
    bool same = true;
    for (uint32_t octant = 0; octant < 8; ++octant) {
        same = same && made[octant] == left[octant];
    }
    if (same) {
        *out = a;
        return true;
    }
    if (!svo_i_edit_join(run->store, made, level, out)) {
        return false;
    }
    *out = same_or(run->store, a, *out);
    return true;
}

bool svo_i_edit_combine(svo_i_edit_run *run, svo_i_edit_ref a, svo_i_edit_ref b, svo_i_edit_ref *out)
{
    const uint32_t cell[3] = {0, 0, 0};
    const svo_i_edit_ref operand = decide(run, b, cell, SVO_I_EDIT_ROOT_LEVEL);
    const bool settled = operand == SVO_I_EDIT_SHAPE ? is_beside(run, a) : is_settled(run, a, operand, out);
    if (settled) {
        *out = operand == SVO_I_EDIT_SHAPE ? a : same_or(run->store, a, *out);
        return true;
    }
    return combine(run, a, operand, SVO_I_EDIT_ROOT_LEVEL, cell, out);
}

/*
 * ---- moves ----
 *
 * A cube of the result lies over up to eight neighbors of its level, at an offset into the first of them. Each of its
 * children lies over up to eight of their children. Axes without an offset have the same neighbor twice.
 */

/* What a cube of the result lies over. */
typedef struct window {
    svo_i_edit_ref cubes[8]; /* by octant, from the one that holds its least corner on */
    uint32_t offset[3]; /* voxels into it, below the cube's edge */
} window;

static bool is_aligned(const window *w)
{
    return (w->offset[0] | w->offset[1] | w->offset[2]) == 0;
}

/* Whether all are empty, one node, or full with one payload. */
static bool are_same(const svo_i_edit_store *from, const window *w)
{
    bool same = true;
    for (uint32_t i = 1; i < 8 && same; ++i) {
        same = same_or(from, w->cubes[0], w->cubes[i]) == w->cubes[0];
    }
    return same;
}

static void child_window(const svo_i_edit_ref children[8][8], const window *w, uint32_t octant, uint32_t level,
                         window *out)
{
    const uint32_t half = 1u << (level - 1u);
    uint32_t begin[3]; /* in halves, from the first cube on */
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const uint32_t place = w->offset[axis] + (octant >> axis & 1u) * half;
        begin[axis] = place >> (level - 1u);
        out->offset[axis] = place & (half - 1u);
    }
    for (uint32_t i = 0; i < 8; ++i) {
        uint32_t cube = 0;
        uint32_t child = 0;
        for (uint32_t axis = 0; axis < 3; ++axis) {
            const uint32_t at = begin[axis] + (out->offset[axis] != 0 ? i >> axis & 1u : 0u);
            cube |= (at >> 1) << axis;
            child |= (at & 1u) << axis;
        }
        out->cubes[i] = children[cube][child];
    }
}

static bool move_block(svo_i_edit_run *run, const svo_i_edit_store *from, const window *w, svo_i_edit_ref *out)
{
    svo_i_edit_cells sources[8];
    svo_i_edit_cells made = {.mask = 0};
    for (uint32_t i = 0; i < 8; ++i) {
        svo_i_edit_unpack(from, w->cubes[i], &sources[i]);
    }
    for (uint32_t code = 0; code < SVO_I_EDIT_CELLS; ++code) {
        uint32_t cube = 0;
        uint32_t source = 0;
        for (uint32_t axis = 0; axis < 3; ++axis) {
            const uint32_t at = w->offset[axis] + (code >> axis & 1u) + 2u * (code >> (3u + axis) & 1u);
            cube |= (at >> 2) << axis;
            source |= (at & 1u) << axis | (at >> 1 & 1u) << (3u + axis);
        }
        if ((sources[cube].mask >> source & 1u) != 0) {
            made.mask |= (uint64_t)1 << code;
            made.color[code] = sources[cube].color[source];
            made.material[code] = sources[cube].material[source];
            made.normal[code] = sources[cube].normal[source];
        }
    }
    return svo_i_edit_pack(run->store, &made, out);
}

static bool move(svo_i_edit_run *run, const svo_i_edit_store *from, const window *w, uint32_t level,
                 svo_i_edit_ref *out)
{
    svo_i_edit_ref children[8][8];
    svo_i_edit_ref made[8];
    const bool same = are_same(from, w);
    ++run->node_count;
    if (same && w->cubes[0] == SVO_I_EDIT_EMPTY) {
        *out = SVO_I_EDIT_EMPTY;
        return true;
    }
    if (from == run->store && same && (is_aligned(w) || is_uniform(from, w->cubes[0]))) {
        *out = w->cubes[0];
        return true;
    }
    if (same && is_uniform(from, w->cubes[0])) {
        return svo_i_edit_fill(run->store, svo_i_edit_payload_of(from, w->cubes[0]), out);
    }
    if (level == SVO_I_EDIT_BLOCK_LEVEL) {
        return move_block(run, from, w, out);
    }
    for (uint32_t i = 0; i < 8; ++i) {
        svo_i_edit_children_of(from, w->cubes[i], children[i]);
    }
    part p = part_begin(run, 8);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        window below;
        child_window((const svo_i_edit_ref(*)[8])children, w, octant, level, &below);
        part_next(run, &p);
        if (!move(run, from, &below, level - 1, &made[octant])) {
            return false;
        }
    }
    return part_end(run, &p, level) && svo_i_edit_join(run->store, made, level, out);
}

bool svo_i_edit_move(svo_i_edit_run *run, const svo_i_edit_store *from, svo_i_edit_ref root, const int64_t offset[3],
                     svo_i_edit_ref *out)
{
    window w = {.cubes = {0}};
    bool reaches[2][3]; /* whether the first cube along an axis, or the one behind it, is the root */
    for (uint32_t axis = 0; axis < 3; ++axis) {
        /* The result's least corner is at -offset in the source. */
        if (offset[axis] <= -SVO_EDIT_EXTENT || offset[axis] >= SVO_EDIT_EXTENT) {
            *out = SVO_I_EDIT_EMPTY;
            return true;
        }
        w.offset[axis] = (uint32_t)(-offset[axis] & (SVO_EDIT_EXTENT - 1));
        reaches[0][axis] = offset[axis] <= 0;
        reaches[1][axis] = offset[axis] >= 0; /* at 0 both are the root */
    }
    for (uint32_t i = 0; i < 8; ++i) {
        w.cubes[i] = reaches[i & 1u][0] && reaches[i >> 1 & 1u][1] && reaches[i >> 2][2] ? root : SVO_I_EDIT_EMPTY;
    }
    return move(run, from, &w, SVO_I_EDIT_ROOT_LEVEL, out);
}
