/* SPDX-License-Identifier: MIT */
/* Windows has neither a limit of address space nor control groups; those of job objects are not read. */
#include "core/limits.h"

svo_i_limit svo_i_limit_read(svo_i_limit_kind kind)
{
    return (svo_i_limit){kind == SVO_I_LIMIT_SPACE ? "address space" : "control groups", UINT64_MAX, 0};
}
