/* SPDX-License-Identifier: MIT */
/* A list of pairs that grows. */
#include "measure/float_list.h"

#include <stdlib.h>

void float_list_add(float_list *list, const float_triangle *triangle, int x, int y, int z)
{
    if (list->count == list->capacity && !list->failed) {
        const size_t capacity = list->capacity > 0 ? list->capacity * 2 : 4096;
        oracle_pair *grown = realloc(list->pairs, capacity * sizeof *grown);
        if (grown == NULL) {
            list->failed = true;
            return;
        }
        list->pairs = grown;
        list->capacity = capacity;
    }
    if (!list->failed) {
        const uint64_t code = oracle_voxel_code((uint32_t)x, (uint32_t)y, (uint32_t)z, triangle->depth);
        list->pairs[list->count++] = (oracle_pair){code, triangle->id};
    }
}
