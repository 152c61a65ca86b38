/* SPDX-License-Identifier: MIT */
/* Arrays of a surface that grow, and what all steps may say. */
#include "surface/work.h"

#include <math.h>

/* Elements of an array at first. */
#define FIRST_CAPACITY 256

static const char create_name[] = "svo_surface_create";

svo_status svo_i_surface_grow(svo_i_surface_work *work, void **array, size_t needed, size_t *capacity,
                              size_t element_bytes)
{
    size_t bytes = 0;
    if (needed <= *capacity) {
        return SVO_OK;
    }
    const size_t wanted = *capacity == 0 ? FIRST_CAPACITY : 2 * *capacity;
    void *grown =
        svo_i_mul_size(wanted, element_bytes, &bytes) ? svo_i_grow(&work->surface->memory, *array, bytes) : NULL;
    if (grown == NULL) {
        return svo_i_fail(work->message, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %zu elements of %zu bytes",
                          create_name, wanted, element_bytes);
    }
    *array = grown;
    *capacity = wanted;
    return SVO_OK;
}

svo_status svo_i_surface_fail_open(const svo_i_surface_work *work, const int32_t place[3])
{
    const svo_surface_field *field = &work->reader.field;
    return svo_i_fail(
        work->message, SVO_INVALID_ARGUMENT,
        "%s: the surface at level %g passes voxel %d, %d, %d, whose neighbors the band does not hold; that "
        "of a closed mesh needs a band of %g voxels",
        create_name, (double)work->reader.level, place[0], place[1], place[2],
        fabs((double)work->reader.level) / field->spacing + 2.5);
}
