/* SPDX-License-Identifier: MIT */
/* The color of a pixel: shaded as kernels/rays/render.cl does it, lit as kernels/light/picture.cl does, or what
   kernels/rays/view.cl shows of a ray. */

#define VIEW_SHADED 0
#define VIEW_NORMAL 1
#define VIEW_DEPTH  2
#define VIEW_STEPS  3
#define VIEW_LEVEL  4
#define VIEW_OPEN   5
#define VIEW_FULL   6

/* The step count that the last color stands for. */
#define STEPS_HOT 64.0

uniform int view;
uniform int samples; /* rays along each side of a pixel */
uniform float pictureHeight; /* in pixels */
uniform float block; /* pixels along each side of what is drawn as one */
uniform vec3 eye; /* in cells */
uniform vec3 corner; /* the directions of pixels: corner + column * across + row * down */
uniform vec3 across;
uniform vec3 down;
uniform float footprint;
uniform vec3 skyAbove; /* the background of shaded pictures, shares of white */
uniform vec3 skyBelow;
uniform vec3 blank; /* that of other views */

out vec4 color;

/* From dark blue over green and yellow to red. */
vec3 heat(float value)
{
    vec3 away = (clamp(value, 0.0, 1.0) - vec3(0.90, 0.55, 0.15)) / vec3(0.55, 0.45, 0.35);
    return max(1.0 - away * away, vec3(0.05, 0.03, 0.20));
}

/* A color for each number, by a multiplicative hash (Knuth, "The Art of Computer Programming", volume 3, 6.4). */
vec3 mixedColor(uint number)
{
    uint mixed = (number + 1u) * 2654435769u;
    mixed = (mixed ^ mixed >> 15) * 2246822519u;
    mixed ^= mixed >> 13;
    return 0.25 + vec3(uvec3(mixed, mixed >> 8, mixed >> 16) & 255u) * (0.75 / 255.0);
}

/* The hit's distance relative to the grid's bounding sphere: near hits are bright. */
float nearness(vec3 origin, float distance, float cells)
{
    float middle = length(origin - 0.5 * cells);
    float reach = 0.87 * cells;
    float first = max(middle - reach, 0.0);
    return 1.0 - 0.9 * (distance - first) / (middle + reach - first);
}

vec3 shownNormal(Hit hit, vec3 direction)
{
    vec3 normal;
    return 0.5 + 0.5 * (readNormal(hit.node, normal) ? normal : faceNormal(hit, direction));
}

vec3 lookAlong(Ray ray, float row, inout Lit lit)
{
    Hit hit;
    bool met = castRay(ray, hit);
    if (view == VIEW_STEPS) {
        return heat(float(hit.steps) / STEPS_HOT);
    }
    if (view == VIEW_SHADED || view == VIEW_FULL) {
        vec3 behind = view == VIEW_FULL ? toneOf(exposure * skyAlong(ray.direction))
                                        : mix(skyAbove, skyBelow, row / pictureHeight);
        return met ? shade(ray, hit, view == VIEW_FULL, lit) : behind;
    }
    if (view == VIEW_OPEN) {
        return met ? showOpenness(ray, hit) : vec3(1.0);
    }
    if (!met) {
        return blank;
    }
    if (view == VIEW_NORMAL) {
        return shownNormal(hit, ray.direction);
    }
    if (view == VIEW_DEPTH) {
        return vec3(nearness(ray.origin, hit.distance, float(1 << depth)));
    }
    return mixedColor(uint(hit.level) * 7u) * (hit.axis == 0 ? 0.8 : hit.axis == 1 ? 1.0 : 0.65);
}

void main()
{
    vec3 sum = vec3(0.0);
    Lit lit = Lit(vec3(0.0), vec3(0.0), vec3(0.0));
    vec2 pixel = vec2(gl_FragCoord.x - 0.5, pictureHeight / block - gl_FragCoord.y - 0.5);
    bool byAlpha = view == VIEW_SHADED || view >= VIEW_OPEN; /* other views show what there is */
    for (int k = 0; k < samples * samples; ++k) {
        vec2 inside = (vec2(k % samples, k / samples) + 0.5) / float(samples);
        vec2 place = block * (pixel + inside);
        vec3 direction = normalize(corner + place.x * across + place.y * down);
        uvec2 set = byAlpha ? uvec2(k, samples * samples) : uvec2(0);
        sum += lookAlong(Ray(eye, direction, footprint / float(samples), FAR, set), place.y, lit);
    }
    sum /= float(samples * samples);
    color = vec4(view == VIEW_SHADED ? encodeSquares(sum) : view >= VIEW_OPEN ? encodeLight(sum) : sum, 1.0);
}
