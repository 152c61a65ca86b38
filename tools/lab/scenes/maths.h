/* SPDX-License-Identifier: MIT */
/*
 * Arithmetic of the scenes: vectors, sine and cosine, random numbers and noise, the same bits on every machine.
 *
 * Everything is made of integer operations and of double +, -, *, /, sqrt and floor, which IEEE 754 rounds uniquely;
 * the build keeps the compiler from contracting them. The sin, pow and exp of C libraries differ in the last bit and
 * are not used.
 */
#ifndef SVOCL_TOOLS_SCENES_MATHS_H
#define SVOCL_TOOLS_SCENES_MATHS_H

#include <math.h>
#include <stdint.h>

typedef struct vector3 {
    double x, y, z;
} vector3;

static inline vector3 vector(double x, double y, double z)
{
    const vector3 v = {x, y, z};
    return v;
}

static inline vector3 vector_add(vector3 a, vector3 b)
{
    return vector(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline vector3 vector_subtract(vector3 a, vector3 b)
{
    return vector(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline vector3 vector_scale(vector3 a, double factor)
{
    return vector(a.x * factor, a.y * factor, a.z * factor);
}

/* a at t = 0, b at t = 1. */
static inline vector3 vector_mix(vector3 a, vector3 b, double t)
{
    return vector_add(a, vector_scale(vector_subtract(b, a), t));
}

static inline double vector_dot(vector3 a, vector3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline vector3 vector_cross(vector3 a, vector3 b)
{
    return vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline double vector_length(vector3 a)
{
    return sqrt(vector_dot(a, a));
}

/* Unit length; straight up for the zero vector. */
static inline vector3 vector_normalize(vector3 a)
{
    const double length = vector_length(a);
    return length > 0 ? vector_scale(a, 1 / length) : vector(0, 1, 0);
}

static inline double clamp_to(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

static inline double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}

/* 0 below low, 1 above high, a cubic ramp between them. */
static inline double smooth_ramp(double low, double high, double value)
{
    const double t = clamp_to((value - low) / (high - low), 0, 1);
    return t * t * (3 - 2 * t);
}

/* Sine and cosine of an angle in turns (1 = a full circle); absolute error below 1e-15. */
double sine_of_turns(double turns);
double cosine_of_turns(double turns);

/* SplitMix64: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014. */
typedef struct random_stream {
    uint64_t state;
} random_stream;

uint64_t random_bits(random_stream *stream);
double random_between(random_stream *stream, double low, double high); /* low <= result < high */
uint32_t random_index(random_stream *stream, uint32_t count); /* 0 .. count - 1 */
vector3 random_direction(random_stream *stream); /* uniform on the unit sphere */

/* Value noise in [-1, 1]: random values on the integer lattice, blended by the quintic of Perlin, "Improving noise",
   SIGGRAPH 2002. */
double noise(uint32_t seed, vector3 position);
/* Octaves of noise, each of twice the frequency and half the amplitude; in (-2, 2). */
double fractal_noise(uint32_t seed, vector3 position, int octaves);

#endif
