/* SPDX-License-Identifier: MIT */
/* Welding of an imported mesh. */
#ifndef SVO_LIB_IO_IMPORT_WELD_H
#define SVO_LIB_IO_IMPORT_WELD_H

#include "svocl/io.h"

/* Moves vertices that lie no farther than the tolerance from an earlier one to its position, as svo_import_options.weld
   says, and counts them in the import's info. path: for the message. Returns SVO_OUT_OF_HOST_MEMORY on failure. */
svo_status svo_i_import_weld(svo_import *import, double tolerance, const char *path, svo_message *message);

#endif
