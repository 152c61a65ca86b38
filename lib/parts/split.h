/* SPDX-License-Identifier: MIT */
/* Parts that are divided into their eight children, while they are planned or when a build of one is too large. */
#ifndef SVO_LIB_PARTS_SPLIT_H
#define SVO_LIB_PARTS_SPLIT_H

#include "parts/folder.h"

/* Divides a part's triangles among files of its children. counts: receives how many each child has. */
svo_status svo_i_part_divide(const svo_parts *parts, uint32_t level, uint64_t code, uint64_t counts[8],
                             svo_message *message);

/* Notes in a .split file that the children of a part stand for it. */
svo_status svo_i_split_save(const svo_parts *parts, uint32_t level, uint64_t code, const uint64_t counts[8],
                            svo_message *message);
/* Whether there is such a file. A damaged one, or one of another plan or part, counts as none, since the part can be
   divided again. */
svo_status svo_i_split_find(const svo_parts *parts, uint32_t level, uint64_t code, bool *is_split, uint64_t counts[8],
                            svo_message *message);

#endif
