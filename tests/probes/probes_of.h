/* SPDX-License-Identifier: MIT */
/* Probes of a tree by options that name none. */
#ifndef SVOCL_TESTS_PROBES_PROBES_OF_H
#define SVOCL_TESTS_PROBES_PROBES_OF_H

#include "svocl/probes.h"

static inline svo_status probes_of_tree(svo_tree *tree, const svo_probe_options *options, cl_command_queue queue,
                                        svo_probes **out)
{
    svo_probe_options asked = *options;
    asked.tree = tree;
    return svo_probes_create(&asked, queue, out);
}

static inline svo_status plan_of_tree(svo_tree *tree, const svo_probe_options *options, svo_probe_info *info)
{
    svo_probe_options asked = *options;
    asked.tree = tree;
    return svo_probes_plan(&asked, info);
}

#endif
