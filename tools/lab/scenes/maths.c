/* SPDX-License-Identifier: MIT */
/* Sine, random numbers and noise of the scenes, bit-identical on every machine. */
#include "maths.h"

double sine_of_turns(double turns)
{
    /* Fold into [-1/4, 1/4]; the reductions are exact or correctly rounded. */
    double t = turns - floor(turns + 0.5);
    if (t > 0.25) {
        t = 0.5 - t;
    } else if (t < -0.25) {
        t = -0.5 - t;
    }
    const double x = t * 6.283185307179586476925286766559;
    const double xx = x * x;
    /* Taylor's series to the 19th power: the first term left out is below 3e-16 at a quarter turn. */
    double sum = 1;
    for (int power = 18; power >= 2; power -= 2) {
        sum = 1 - sum * xx / (double)(power * (power + 1));
    }
    return x * sum;
}

double cosine_of_turns(double turns)
{
    return sine_of_turns(turns + 0.25);
}

static uint64_t mix_bits(uint64_t bits)
{
    bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9u;
    bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBu;
    return bits ^ (bits >> 31);
}

uint64_t random_bits(random_stream *stream)
{
    stream->state += 0x9E3779B97F4A7C15u;
    return mix_bits(stream->state);
}

static double unit_from_bits(uint64_t bits)
{
    return (double)(bits >> 11) * 0x1p-53;
}

double random_between(random_stream *stream, double low, double high)
{
    return low + (high - low) * unit_from_bits(random_bits(stream));
}

uint32_t random_index(random_stream *stream, uint32_t count)
{
    return (uint32_t)((random_bits(stream) >> 32) * count >> 32);
}

vector3 random_direction(random_stream *stream)
{
    const double y = random_between(stream, -1, 1);
    const double turns = random_between(stream, 0, 1);
    const double radius = sqrt(1 - y * y);
    return vector(radius * cosine_of_turns(turns), y, radius * sine_of_turns(turns));
}

static double lattice_value(uint32_t seed, int64_t x, int64_t y, int64_t z)
{
    uint64_t bits = mix_bits((uint64_t)seed + 0x9E3779B97F4A7C15u);
    bits = mix_bits(bits ^ (uint64_t)x);
    bits = mix_bits(bits ^ (uint64_t)y * 0x9E3779B97F4A7C15u);
    bits = mix_bits(bits ^ (uint64_t)z * 0xD1B54A32D192ED03u);
    return 2 * unit_from_bits(bits) - 1;
}

static double quintic(double t)
{
    return t * t * t * (t * (t * 6 - 15) + 10);
}

double noise(uint32_t seed, vector3 position)
{
    const double floor_x = floor(position.x);
    const double floor_y = floor(position.y);
    const double floor_z = floor(position.z);
    const int64_t x = (int64_t)floor_x;
    const int64_t y = (int64_t)floor_y;
    const int64_t z = (int64_t)floor_z;
    const double blend_x = quintic(position.x - floor_x);
    const double blend_y = quintic(position.y - floor_y);
    const double blend_z = quintic(position.z - floor_z);
    double layers[2];
    for (int layer = 0; layer < 2; ++layer) {
        const int64_t lattice_z = z + layer;
        const double near_edge =
            mix(lattice_value(seed, x, y, lattice_z), lattice_value(seed, x + 1, y, lattice_z), blend_x);
        const double far_edge =
            mix(lattice_value(seed, x, y + 1, lattice_z), lattice_value(seed, x + 1, y + 1, lattice_z), blend_x);
        layers[layer] = mix(near_edge, far_edge, blend_y);
    }
    return mix(layers[0], layers[1], blend_z);
}

double fractal_noise(uint32_t seed, vector3 position, int octaves)
{
    double sum = 0;
    double amplitude = 1;
    for (int octave = 0; octave < octaves; ++octave) {
        sum += amplitude * noise(seed + (uint32_t)octave * 101u, position);
        position = vector_scale(position, 2);
        amplitude *= 0.5;
    }
    return sum;
}
