/* SPDX-License-Identifier: MIT */
/* svocl's own ways are blue wherever they appear. */
#include "report/palette.h"

#include <string.h>

static const struct {
    const char *method;
    method_style style;
} known[] = {
    {"exact integers, cl", {PALETTE_BLUE, MARKER_CIRCLE}},
    {"exact integers, gl-expand", {PALETTE_SKY, MARKER_CIRCLE}},
    {"exact integers, gl-hw", {PALETTE_SKY, MARKER_DIAMOND}},
    {"float32 test, box-centered", {PALETTE_GREEN, MARKER_SQUARE}},
    {"float32 test, world coordinates", {PALETTE_ORANGE, MARKER_DIAMOND}},
    {"expansion alone", {PALETTE_PURPLE, MARKER_UP}},
    {"4x multisampling", {PALETTE_VERMILLION, MARKER_DOWN}},
    {"plain rasterization", {PALETTE_GREY, MARKER_SQUARE}},
    {"svocl", {PALETTE_BLUE, MARKER_CIRCLE}},
    {"Möller-Trumbore, float32", {PALETTE_VERMILLION, MARKER_DOWN}},
    {"watertight, float32", {PALETTE_GREEN, MARKER_SQUARE}},
    {"Embree, fast", {PALETTE_ORANGE, MARKER_DIAMOND}},
    {"Embree, robust", {PALETTE_PURPLE, MARKER_UP}},
    {"voxels alone, coarse", {PALETTE_GREY, MARKER_CIRCLE}},
    {"voxels alone, middle", {PALETTE_GREY, MARKER_DIAMOND}},
    {"voxels alone, fine", {PALETTE_GREY, MARKER_SQUARE}},
    {"RGBA8 running average", {PALETTE_VERMILLION, MARKER_DOWN}},
    {"float atomics", {PALETTE_ORANGE, MARKER_DIAMOND}},
    {"integers, uniform", {PALETTE_SKY, MARKER_SQUARE}},
    {"integers, at the center", {PALETTE_GREEN, MARKER_UP}},
    {"integers, by area", {PALETTE_BLUE, MARKER_CIRCLE}},
    {"distance of centers", {PALETTE_VERMILLION, MARKER_DOWN}},
    {"area by fill, error", {PALETTE_BLUE, MARKER_CIRCLE}},
    {"area by faces, error", {PALETTE_ORANGE, MARKER_DIAMOND}},
    {"volume, error", {PALETTE_GREEN, MARKER_SQUARE}},
    {"cl", {PALETTE_BLUE, MARKER_CIRCLE}},
    {"sorted", {PALETTE_GREEN, MARKER_SQUARE}},
    {"gl-compute", {PALETTE_ORANGE, MARKER_DIAMOND}},
};

method_style palette_of(const char *method, size_t position)
{
    static const palette_marker markers[] = {MARKER_CIRCLE, MARKER_SQUARE, MARKER_UP, MARKER_DIAMOND, MARKER_DOWN};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        if (strcmp(known[i].method, method) == 0) {
            return known[i].style;
        }
    }
    return (method_style){(palette_color)(position % PALETTE_COLOR_COUNT),
                          markers[position % (sizeof markers / sizeof markers[0])]};
}

uint32_t palette_rgb(palette_color color)
{
    static const uint32_t colors[PALETTE_COLOR_COUNT] = {0x0072b2, 0x56b4e9, 0x009e73, 0xe69f00,
                                                         0xd55e00, 0xcc79a7, 0xf0e442, 0x767676};
    return colors[color];
}

const char *palette_marker_path(palette_marker marker)
{
    switch (marker) {
    case MARKER_SQUARE:
        return "M-.9-.9h1.8v1.8h-1.8z";
    case MARKER_UP:
        return "M0-1.2L1.1.8H-1.1z";
    case MARKER_DOWN:
        return "M0 1.2L1.1-.8H-1.1z";
    case MARKER_DIAMOND:
        return "M0-1.3L1.3 0 0 1.3-1.3 0z";
    default:
        return "M-1 0a1 1 0 1 0 2 0a1 1 0 1 0-2 0z";
    }
}
