/* SPDX-License-Identifier: MIT */
/* Reads OpenEXR pictures of light: scan lines of half or single floats, red, green and blue, or luminance alone. */
#ifndef SVOCL_TOOLS_SUPPORT_EXR_FILE_H
#define SVOCL_TOOLS_SUPPORT_EXR_FILE_H

#include "support/hdr_file.h"

/* Reads a picture of at most that size; what is below 0 becomes 0. False: out->words says what is wrong, and there is
   no picture. So it is where the program was built without OpenEXR. hdr_file_free releases the picture. */
bool exr_file_read(const char *path, uint32_t width_max, uint32_t height_max, hdr_picture *out);

#endif
