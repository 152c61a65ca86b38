/* SPDX-License-Identifier: MIT */
/* What both shaders of a light's view read. Lengths are in grid units, places from the view's base. */
layout(std430, binding = 2) readonly buffer View
{
    vec4 base;    /* grid units; w: world units a grid unit */
    vec4 right;   /* unit; w: half a pixel */
    vec4 up;      /* unit; w: half a pixel */
    vec4 forward; /* direction at x = y = 0; w: not 0: parallel light */
    vec4 axis;    /* of a point source: unit, across right and up */
    uvec4 view;   /* columns, rows, columns of tiles, first photon */
    uvec4 band;   /* first row, rows, photons */
};
