/* SPDX-License-Identifier: MIT */
/* What a handle is, as a value: for commands and tests that want one field of it. Only a mistake in the program makes
   these calls fail, so that ends it; tests ask on threads too. */
#ifndef SVOCL_TOOLS_SUPPORT_INFO_OF_H
#define SVOCL_TOOLS_SUPPORT_INFO_OF_H

#include <stdlib.h>

#include "svocl/svocl.h"

static inline svo_device_info info_of_device(const svo_device *device)
{
    svo_device_info info = SVO_DEVICE_INFO_INIT;
    if (svo_device_get_info(device, &info) != SVO_OK) {
        abort();
    }
    return info;
}

static inline svo_plan_info info_of_plan(const svo_plan *plan)
{
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    if (svo_plan_get_info(plan, &info) != SVO_OK) {
        abort();
    }
    return info;
}

static inline svo_tree_info info_of_tree(const svo_tree *tree)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    if (svo_tree_get_info(tree, &info) != SVO_OK) {
        abort();
    }
    return info;
}

#endif
