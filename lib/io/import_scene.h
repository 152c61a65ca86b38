/* SPDX-License-Identifier: MIT */
/* assimp's scene to a gathered mesh, in the import child. */
#ifndef SVO_LIB_IO_IMPORT_SCENE_H
#define SVO_LIB_IO_IMPORT_SCENE_H

#include <assimp/scene.h>

#include "io/import_gather.h"

/*
 * Gathers every triangle of the scene in node order, textures and warnings going to the stream on the way.
 * path: the mesh file, whose folder textures are relative to.
 * Returns NULL, or why there is no mesh: a static string.
 */
const char *svo_i_import_gather_scene(const struct aiScene *scene, const char *path, int stream, gather *mesh);

#endif
