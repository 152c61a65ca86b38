/* SPDX-License-Identifier: MIT */
/** \file
 * svocl: exact sparse voxel octrees of triangle meshes with OpenCL. This header includes all of svocl::svocl, which
 * needs OpenCL alone; gl.h (svocl::gl) and io.h (svocl::io) are separate.
 *
 *     svo_device  a context and a device           device.h
 *     svo_mesh    arrays of triangles              mesh.h
 *     svo_plan    what a build will do             plan.h
 *     svo_build   plan + front end + queue -> tree build.h
 *     svo_tree    the result: buffers, hash        tree.h
 *     nodes       as places: boxes, codes, points  nodes.h
 *     rays        triangles, voxels, pictures      trace.h
 *     svo_compact smaller forms of a tree          compact.h
 *     svo_sdf     signed distance fields           sdf.h
 *     svo_surface closed meshes out of fields      surface.h
 *     svo_moving  one tree of objects that move    moving.h
 *     svo_scene   many placed trees                scene.h
 *     svo_light   light in a tree, cones           light.h
 *     svo_probes  light field probes               probes.h
 *     svo_voxels  given voxels -> tree, and back   voxels.h
 *     svo_edit    edits of voxels, undo and redo   edit.h
 */
#ifndef SVOCL_SVOCL_H
#define SVOCL_SVOCL_H

#include "svocl/build.h"
#include "svocl/compact.h"
#include "svocl/device.h"
#include "svocl/edit.h"
#include "svocl/export.h"
#include "svocl/light.h"
#include "svocl/memory.h"
#include "svocl/mesh.h"
#include "svocl/moving.h"
#include "svocl/names.h"
#include "svocl/nodes.h"
#include "svocl/plan.h"
#include "svocl/probes.h"
#include "svocl/scene.h"
#include "svocl/sdf.h"
#include "svocl/solid.h"
#include "svocl/status.h"
#include "svocl/submit.h"
#include "svocl/surface.h"
#include "svocl/trace.h"
#include "svocl/tree.h"
#include "svocl/version.h"
#include "svocl/voxels.h"

#endif
