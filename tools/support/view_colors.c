/* SPDX-License-Identifier: MIT */
/* Colors of numbers, on the host. */
#include "support/view_colors.h"

#include <math.h>

void view_colors_steps(float share, float rgb[3])
{
    static const float peaks[3] = {0.90F, 0.55F, 0.15F};
    static const float widths[3] = {0.55F, 0.45F, 0.35F};
    static const float least[3] = {0.05F, 0.03F, 0.20F};
    for (int channel = 0; channel < 3; ++channel) {
        const float away = (share - peaks[channel]) / widths[channel];
        rgb[channel] = fmaxf(1.0F - away * away, least[channel]);
    }
}
