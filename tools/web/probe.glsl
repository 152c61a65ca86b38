/* SPDX-License-Identifier: MIT */
/* What a ray finds, in numbers: for a click, and for whoever compares the page with the library. */

uniform vec2 first; /* the pixel of the first probe */
uniform vec2 stride; /* pixels from one probe to the next */
uniform vec3 eye;
uniform vec3 corner;
uniform vec3 across;
uniform vec3 down;
uniform float footprint;

layout(location = 0) out uvec4 found; /* node, level, steps, whether there is one */
layout(location = 1) out uvec4 along; /* bits of floats: the ray's direction, the distance in cells */

void main()
{
    vec2 place = first + stride * (gl_FragCoord.xy - 0.5) + 0.5;
    vec3 direction = normalize(corner + place.x * across + place.y * down);
    Hit hit;
    bool met = castRay(Ray(eye, direction, footprint, FAR, uvec2(0)), hit);
    found = uvec4(hit.node, hit.level, hit.steps, met);
    along = uvec4(floatBitsToUint(direction), floatBitsToUint(hit.distance));
}
