/* SPDX-License-Identifier: MIT */
/* CIELAB as CIE 15 and the matrix as IEC 61966-2-1 have them. Angles are in degrees, as in the paper. */
#include "tune/delta_e.h"

#include <math.h>

#define DEGREES (3.14159265358979323846 / 180)

static double curve(double t)
{
    const double knee = 6.0 / 29;
    return t > knee * knee * knee ? cbrt(t) : t / (3 * knee * knee) + 4.0 / 29;
}

void delta_e_lab(const double linear[3], double lab[3])
{
    static const double to_xyz[3][3] = {{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};
    double shaped[3];
    for (int i = 0; i < 3; ++i) {
        const double white = to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2];
        shaped[i] = curve((to_xyz[i][0] * linear[0] + to_xyz[i][1] * linear[1] + to_xyz[i][2] * linear[2]) / white);
    }
    lab[0] = 116 * shaped[1] - 16;
    lab[1] = 500 * (shaped[0] - shaped[1]);
    lab[2] = 200 * (shaped[1] - shaped[2]);
}

/* ---- CIEDE2000 ---- */

static double power7(double base)
{
    return base * base * base * base * base * base * base;
}

/* sqrt(c^7 / (c^7 + 25^7)) */
static double saturation(double chroma)
{
    const double own = power7(chroma);
    return sqrt(own / (own + power7(25)));
}

/* 0 .. 360; 0 without a hue. */
static double hue_of(double a, double b)
{
    const double angle = a == 0 && b == 0 ? 0 : atan2(b, a) / DEGREES;
    return angle < 0 ? angle + 360 : angle;
}

/* From the first to the second, the short way round; 0 where one has no hue. */
static double hue_step(const double hues[2], double product)
{
    const double step = hues[1] - hues[0];
    if (product == 0) {
        return 0;
    }
    return step > 180 ? step - 360 : step < -180 ? step + 360 : step;
}

static double hue_middle(const double hues[2], double product)
{
    const double sum = hues[0] + hues[1];
    if (product == 0) {
        return sum;
    }
    if (fabs(hues[0] - hues[1]) <= 180) {
        return sum / 2;
    }
    return sum < 360 ? (sum + 360) / 2 : (sum - 360) / 2;
}

double delta_e_2000(const double a[3], const double b[3])
{
    const double mean_chroma = (hypot(a[1], a[2]) + hypot(b[1], b[2])) / 2;
    const double stretch = 1.5 - 0.5 * saturation(mean_chroma);
    const double reds[2] = {a[1] * stretch, b[1] * stretch};
    const double chromas[2] = {hypot(reds[0], a[2]), hypot(reds[1], b[2])};
    const double hues[2] = {hue_of(reds[0], a[2]), hue_of(reds[1], b[2])};
    const double product = chromas[0] * chromas[1];
    const double hue = 2 * sqrt(product) * sin(hue_step(hues, product) / 2 * DEGREES);
    const double lightness_from = (a[0] + b[0]) / 2 - 50;
    const double chroma = (chromas[0] + chromas[1]) / 2;
    const double middle = hue_middle(hues, product);
    const double weight = 1 - 0.17 * cos((middle - 30) * DEGREES) + 0.24 * cos(2 * middle * DEGREES) +
                          0.32 * cos((3 * middle + 6) * DEGREES) - 0.20 * cos((4 * middle - 63) * DEGREES);
    const double square = lightness_from * lightness_from;
    const double by_lightness = (b[0] - a[0]) / (1 + 0.015 * square / sqrt(20 + square));
    const double by_chroma = (chromas[1] - chromas[0]) / (1 + 0.045 * chroma);
    const double by_hue = hue / (1 + 0.015 * chroma * weight);
    const double turn = (middle - 275) / 25;
    const double rotation = -2 * saturation(chroma) * sin(60 * exp(-turn * turn) * DEGREES);
    return sqrt(by_lightness * by_lightness + by_chroma * by_chroma + by_hue * by_hue + rotation * by_chroma * by_hue);
}
