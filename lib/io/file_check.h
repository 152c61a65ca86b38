/* SPDX-License-Identifier: MIT */
/* Whether the arrays of a file make a tree. */
#ifndef SVO_LIB_IO_FILE_CHECK_H
#define SVO_LIB_IO_FILE_CHECK_H

#include "svocl/tree.h"

/*
 * Checks the arrays of a tree whose counts already agree with its header: node links, lists and geometry.
 * name: the file's, for the message. Returns SVO_FILE_DAMAGED with what is wrong and where.
 */
svo_status svo_i_file_check_structure(const svo_tree *tree, const char *name, svo_message *message);

#endif
