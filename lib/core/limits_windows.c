/* SPDX-License-Identifier: MIT */
/* Windows has neither a limit of address space nor control groups; those of job objects are not read. */
#include "core/limits_system.h"

svo_i_system_limit svo_i_limits_space(void)
{
    return (svo_i_system_limit){"address space", UINT64_MAX, 0};
}

svo_i_system_limit svo_i_limits_group(void)
{
    return (svo_i_system_limit){"control groups", UINT64_MAX, 0};
}
