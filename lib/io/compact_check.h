/* SPDX-License-Identifier: MIT */
/* Whether the arrays of a file make a compact tree. */
#ifndef SVO_LIB_IO_COMPACT_CHECK_H
#define SVO_LIB_IO_COMPACT_CHECK_H

#include "core/compact.h"

/* Checks the arrays of a compact tree whose lengths already agree with its info: every word, mask and place is such as
   svo_compact_create makes it. name: the file's. Returns SVO_FILE_DAMAGED with what is wrong and where. */
svo_status svo_i_compact_check(const svo_compact *compact, const char *name, svo_message *message);

#endif
