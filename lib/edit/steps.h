/* SPDX-License-Identifier: MIT */
/* Steps of an edit, its versions, and when nodes are collected. */
#ifndef SVO_LIB_EDIT_STEPS_H
#define SVO_LIB_EDIT_STEPS_H

#include "edit/handle.h"

/* The bytes in use from which on a step collects first. */
uint64_t svo_i_edit_collect_bytes(const svo_edit *edit);

#endif
