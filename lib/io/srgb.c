/* SPDX-License-Identifier: MIT */
/* sRGB's curve there and back. The last bits of the C library's powers differ, so there are none. */
#include "io/srgb.h"

#include <math.h>

#define LINEAR_MAX 0.0031308 /* below, the curve is a line */
#define CODED_MAX  0.04045

/* x^(5/12), the curve's 1 / 2.4: the fifth power of the cube root of the fourth root. IEEE 754 rounds square roots
   correctly. */
static double power_5_12(double x)
{
    const double fourth = sqrt(sqrt(x));
    double root = 1;
    for (int i = 0; i < 8; ++i) {
        root -= (root - fourth / (root * root)) / 3;
    }
    return root * root * root * root * root;
}

uint8_t svo_i_srgb_byte(double linear)
{
    if (!(linear > 0)) {
        return 0;
    }
    const double coded = linear >= 1 ? 1 : linear < LINEAR_MAX ? 12.92 * linear : 1.055 * power_5_12(linear) - 0.055;
    return (uint8_t)(coded * 255 + 0.5);
}

/* The fifth root of x in 0 .. 1, by Newton's method from above. */
static double fifth_root(double x)
{
    double root = 1.0;
    for (int i = 0; i < 40 && x > 0.0; ++i) {
        const double fourth = root * root * root * root;
        root -= (root - x / fourth) / 5.0;
    }
    return root;
}

/* x^2.4 is the fifth root of x to the power of 12. */
double svo_i_srgb_linear(uint8_t byte)
{
    const double coded = byte / 255.0;
    const double root = fifth_root((coded + 0.055) / 1.055);
    const double cube = root * root * root;
    return coded <= CODED_MAX ? coded / 12.92 : cube * cube * cube * cube;
}
