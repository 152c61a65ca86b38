/* SPDX-License-Identifier: MIT */
/* Steps of filling a folder that meshes in memory and in files share. */
#ifndef SVO_LIB_PARTS_CREATE_H
#define SVO_LIB_PARTS_CREATE_H

#include "parts/folder.h"

/* Refuses a tree of more nodes than a file can have, as far as the header tells. */
svo_status svo_i_parts_check_nodes(const svo_parts *parts, svo_message *message);
/* Divides the part 0-0, whose triangles are in the folder, until all parts fit, and writes the list. */
svo_status svo_i_parts_divide(svo_parts *parts, svo_device *device, svo_message *message);

#endif
