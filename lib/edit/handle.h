/* SPDX-License-Identifier: MIT */
/*
 * The fields of an edit. Files of the room, each after those that it uses: store, shape, combine, list, tree, steps,
 * edit, commit, mirror.
 */
#ifndef SVO_LIB_EDIT_HANDLE_H
#define SVO_LIB_EDIT_HANDLE_H

#include "edit/store.h"
#include "svocl/edit.h"

struct svo_edit {
    svo_edit_info info; /* what the store and the versions say is filled in when it is asked for */
    svo_i_edit_store store;
    svo_voxels *frame; /* without voxels: the place, the width and the properties of the lists; owned */
    int64_t corner[3]; /* of the cube; low of the info, or below where coordinates end */
    svo_i_edit_ref *versions; /* version_room, the oldest first; owned */
    uint32_t version_count; /* at least 1 */
    uint32_t version_room; /* one more than steps that can be undone */
    uint32_t current; /* of the versions */
    svo_edit_progress_callback progress;
    void *progress_user;
};

#endif
