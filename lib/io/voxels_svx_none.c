/* SPDX-License-Identifier: MIT */
/* In place of the .svx reader and writer, where the library is built without what they need. */
#include "io/voxels_formats.h"

#define REASON ".svx needs libzip and expat, which svocl was built without"

svo_status svo_i_voxels_read_svx(voxel_reader *reader)
{
    return svo_i_voxels_fail(reader, SVO_UNSUPPORTED, "%s", REASON);
}

svo_status svo_i_voxels_write_svx(voxel_writer *writer)
{
    return svo_i_voxels_write_fail(writer, SVO_UNSUPPORTED, "%s", REASON);
}
