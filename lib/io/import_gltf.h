/* SPDX-License-Identifier: MIT */
#ifndef SVO_LIB_IO_IMPORT_GLTF_H
#define SVO_LIB_IO_IMPORT_GLTF_H

#include "io/import_reader.h"

/* Reads a mesh from glTF 2.0, text or binary. A file of glTF 1.0 fails and names assimp as its reader in the counts. */
svo_status svo_i_read_gltf(const mesh_reader *reader);

#endif
