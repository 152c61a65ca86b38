/* SPDX-License-Identifier: MIT */
/* Plans, workspaces and their trees, for tests of enqueued builds. A failure fails the test with its words. */
#ifndef SVOCL_TESTS_ENQUEUED_H
#define SVOCL_TESTS_ENQUEUED_H

#include "fixture.h"

void succeed(const fixture *opened, svo_status status);
/* struct_size of options need not be set. */
svo_plan *make_plan(const fixture *opened, const svo_mesh *mesh, unsigned depth, svo_plan_options options);
svo_workspace *make_workspace(const fixture *opened, svo_plan *plan);
svo_tree *make_tree(const fixture *opened, svo_workspace *workspace);

#endif
