/* SPDX-License-Identifier: MIT */
/* Lists of voxels to nodes and back, both in the order of Morton codes: the children of a node are runs of the list. */
#include "edit/list.h"

#include <string.h>

#include "edit/combine.h"
#include "shared/nodes.clh"

/* ---- from a list ---- */

typedef struct reading {
    svo_i_edit_store *store;
    const svo_voxel *voxels;
    const int16_t *normals; /* NULL: none */
    const int64_t *corner;
} reading;

static uint64_t code_of(const reading *r, uint64_t index)
{
    const svo_voxel *voxel = &r->voxels[index];
    const uint32_t cell[3] = {(uint32_t)(voxel->x - r->corner[0]), (uint32_t)(voxel->y - r->corner[1]),
                              (uint32_t)(voxel->z - r->corner[2])};
    return svo_interleave(cell);
}

/* The first of the voxels begin .. end - 1 whose octant on a level is not below that; end: there is none. */
static uint64_t find_octant(const reading *r, uint64_t begin, uint64_t end, uint32_t level, uint32_t octant)
{
    uint64_t low = begin;
    uint64_t high = end;
    while (low < high) {
        const uint64_t middle = low + (high - low) / 2;
        if ((code_of(r, middle) >> 3u * (level - 1u) & 7u) < octant) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

static bool read_block(const reading *r, uint64_t begin, uint64_t end, svo_i_edit_ref *out)
{
    svo_i_edit_cells cells = {.mask = 0};
    for (uint64_t i = begin; i < end; ++i) {
        const uint32_t cell = (uint32_t)(code_of(r, i) & (SVO_I_EDIT_CELLS - 1u));
        cells.mask |= (uint64_t)1 << cell;
        memcpy(&cells.color[cell], r->voxels[i].rgba, sizeof cells.color[cell]);
        cells.material[cell] = r->voxels[i].material;
        cells.normal[cell] = r->normals != NULL ? svo_i_edit_pack_normal(r->normals + 3 * i) : 0;
    }
    return svo_i_edit_pack(r->store, &cells, out);
}

/* The node of a run of voxels that it holds all. */
static bool read_node(const reading *r, uint64_t begin, uint64_t end, uint32_t level, svo_i_edit_ref *out)
{
    svo_i_edit_ref children[8] = {0};
    if (begin == end) {
        *out = SVO_I_EDIT_EMPTY;
        return true;
    }
    if (level == SVO_I_EDIT_BLOCK_LEVEL) {
        return read_block(r, begin, end, out);
    }
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint64_t next = octant < 7 ? find_octant(r, begin, end, level, octant + 1) : end;
        if (!read_node(r, begin, next, level - 1, &children[octant])) {
            return false;
        }
        begin = next;
    }
    return svo_i_edit_join(r->store, children, level, out);
}

bool svo_i_edit_read_list(svo_i_edit_store *store, const svo_voxel *voxels, const int16_t *normals,
                          uint64_t voxel_count, const int64_t corner[3], svo_i_edit_ref *out)
{
    const reading r = {.store = store, .voxels = voxels, .normals = normals, .corner = corner};
    return read_node(&r, 0, voxel_count, SVO_I_EDIT_ROOT_LEVEL, out);
}

/* ---- to a list ---- */

typedef struct writing {
    const svo_i_edit_store *store;
    const int64_t *corner;
    svo_voxel *next;
    int16_t *next_normal; /* NULL: normals are not asked for */
} writing;

static void write_block(writing *w, svo_i_edit_ref ref, const uint32_t cell[3])
{
    svo_i_edit_cells cells;
    svo_i_edit_unpack(w->store, ref, &cells);
    for (uint64_t left = cells.mask; left != 0; left &= left - 1) {
        const uint32_t code = svo_i_edit_lowest(left);
        const uint32_t inner[3] = {(code & 1u) + (code >> 2 & 2u), (code >> 1 & 1u) + (code >> 3 & 2u),
                                   (code >> 2 & 1u) + (code >> 4 & 2u)};
        *w->next = (svo_voxel){.x = (int32_t)(w->corner[0] + cell[0] + inner[0]),
                               .y = (int32_t)(w->corner[1] + cell[1] + inner[1]),
                               .z = (int32_t)(w->corner[2] + cell[2] + inner[2]),
                               .material = cells.material[code]};
        memcpy(w->next->rgba, &cells.color[code], sizeof w->next->rgba);
        ++w->next;
        if (w->next_normal != NULL) {
            svo_i_edit_unpack_normal(cells.normal[code], w->next_normal);
            w->next_normal += 3;
        }
    }
}

static void write_node(writing *w, svo_i_edit_ref ref, uint32_t level, const uint32_t cell[3])
{
    svo_i_edit_ref children[8];
    if (level == SVO_I_EDIT_BLOCK_LEVEL) {
        write_block(w, ref, cell);
        return;
    }
    svo_i_edit_children_of(w->store, ref, children);
    for (uint32_t octant = 0; octant < 8; ++octant) {
        const uint32_t half = 1u << (level - 1u);
        const uint32_t below[3] = {cell[0] + (octant & 1u) * half, cell[1] + (octant >> 1 & 1u) * half,
                                   cell[2] + (octant >> 2 & 1u) * half};
        if (children[octant] != SVO_I_EDIT_EMPTY) {
            write_node(w, children[octant], level - 1, below);
        }
    }
}

void svo_i_edit_write_list(const svo_i_edit_store *store, svo_i_edit_ref root, const int64_t corner[3],
                           svo_voxel *voxels, int16_t *normals)
{
    const uint32_t cell[3] = {0, 0, 0};
    writing w = {.store = store, .corner = corner, .next = voxels};
    w.next_normal = normals;
    if (root != SVO_I_EDIT_EMPTY) {
        write_node(&w, root, SVO_I_EDIT_ROOT_LEVEL, cell);
    }
}

/* ---- one place ---- */

bool svo_i_edit_find_cell(const svo_i_edit_store *store, svo_i_edit_ref root, const uint32_t cell[3],
                          svo_i_edit_payload *out)
{
    svo_i_edit_cells cells;
    const uint64_t code = svo_interleave(cell);
    svo_i_edit_ref ref = root;
    for (uint32_t level = SVO_I_EDIT_ROOT_LEVEL; level > SVO_I_EDIT_BLOCK_LEVEL && ref != SVO_I_EDIT_EMPTY; --level) {
        svo_i_edit_ref children[8];
        svo_i_edit_children_of(store, ref, children);
        ref = children[code >> 3u * (level - 1u) & 7u];
    }
    const uint32_t place = (uint32_t)(code & (SVO_I_EDIT_CELLS - 1u));
    svo_i_edit_unpack(store, ref, &cells);
    if ((cells.mask >> place & 1u) == 0) {
        return false;
    }
    *out = (svo_i_edit_payload){.color = cells.color[place], .material = cells.material[place]};
    return true;
}
