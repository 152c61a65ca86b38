/* SPDX-License-Identifier: MIT */
/* Numbers as text, the same in every locale. */
#include "io/voxels_text.h"

#include <stdio.h>
#include <string.h>

const char *svo_i_voxel_number(char text[VOXEL_NUMBER_BYTES], double value, int digits)
{
    char local[VOXEL_NUMBER_BYTES];
    size_t used = 0;
    (void)snprintf(local, sizeof local, "%.*g", digits, value);
    for (size_t i = 0; local[i] != '\0'; ++i) {
        if (strchr("0123456789+-e", local[i]) != NULL) {
            text[used++] = local[i];
        } else if (used == 0 || text[used - 1] != '.') { /* the locale's decimal point may have several bytes */
            text[used++] = '.';
        }
    }
    text[used] = '\0';
    return text;
}
