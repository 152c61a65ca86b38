/* SPDX-License-Identifier: MIT */
/* Places the models of a .vox file. */
#ifndef SVO_LIB_IO_VOXELS_VOX_SCENE_H
#define SVO_LIB_IO_VOXELS_VOX_SCENE_H

#include "io/voxels_vox_file.h"

/* Places the models as the scene says, or one of them where there is no scene. */
svo_status svo_i_vox_place(vox_file *file);

#endif
