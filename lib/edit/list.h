/* SPDX-License-Identifier: MIT */
/* Lists of voxels to nodes and back. */
#ifndef SVO_LIB_EDIT_LIST_H
#define SVO_LIB_EDIT_LIST_H

#include "edit/store.h"
#include "svocl/voxels.h"

/*
 * The root of a list. normals: x, y, z of each voxel, or NULL. corner: of the edit's cube; the list's least corner less
 * 2^20, so that the list's order is that of the nodes. Returns false where there is no memory (store->failure).
 */
bool svo_i_edit_read_list(svo_i_edit_store *store, const svo_voxel *voxels, const int16_t *normals,
                          uint64_t voxel_count, const int64_t corner[3], svo_i_edit_ref *out);

/* Writes the voxels of a root, as many as svo_i_edit_voxels_of says, in the order of their Morton codes; their normals
   too, unless normals is NULL. */
void svo_i_edit_write_list(const svo_i_edit_store *store, svo_i_edit_ref root, const int64_t corner[3],
                           svo_voxel *voxels, int16_t *normals);

/* The voxel at a place from the corner on; false: there is none. */
bool svo_i_edit_find_cell(const svo_i_edit_store *store, svo_i_edit_ref root, const uint32_t cell[3],
                          svo_i_edit_payload *out);

#endif
