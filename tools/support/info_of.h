/* SPDX-License-Identifier: MIT */
/* What a handle is, as a value: for commands that want one field of it. */
#ifndef SVOCL_TOOLS_SUPPORT_INFO_OF_H
#define SVOCL_TOOLS_SUPPORT_INFO_OF_H

#include "svocl/svocl.h"

static inline svo_device_info info_of_device(const svo_device *device)
{
    svo_device_info info = SVO_DEVICE_INFO_INIT;
    (void)svo_device_get_info(device, &info);
    return info;
}

static inline svo_plan_info info_of_plan(const svo_plan *plan)
{
    svo_plan_info info = SVO_PLAN_INFO_INIT;
    (void)svo_plan_get_info(plan, &info);
    return info;
}

static inline svo_tree_info info_of_tree(const svo_tree *tree)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(tree, &info);
    return info;
}

#endif
