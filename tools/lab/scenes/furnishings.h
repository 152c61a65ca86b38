/* SPDX-License-Identifier: MIT */
/* The furnishings of the atrium; the building itself is in atrium.c. */
#ifndef SVOCL_TOOLS_SCENES_FURNISHINGS_H
#define SVOCL_TOOLS_SCENES_FURNISHINGS_H

#include "parts.h"

/* Materials of the atrium, in the order in which they are added. */
typedef enum atrium_material {
    ATRIUM_STONE = 0,
    ATRIUM_PAINT,
    ATRIUM_TERRACOTTA,
    ATRIUM_CLOTH,
    ATRIUM_LEAF,
    ATRIUM_WATER
} atrium_material;

typedef struct atrium {
    scene_builder *builder;
    double detail;
    uint32_t seed;
    random_stream random;
} atrium;

/* A number of segments at this scene's detail. */
static inline uint32_t atrium_segments(const atrium *scene, double base, uint32_t least)
{
    return detail_segments(base, scene->detail, least);
}

/* A cloth hanging from the middle of its upper edge, facing outwards; kind picks its colors. */
void furnish_banner(atrium *scene, vector3 top, vector3 outwards, uint32_t kind);
/* A clay pot with long curved leaves. */
void furnish_plant(atrium *scene, vector3 base, double scale);
/* A clipped orange tree in a pot. */
void furnish_tree(atrium *scene, vector3 base);
void furnish_vase(atrium *scene, vector3 base, double scale, vector3 color);
/* A round basin with water, a stem and an upper bowl. */
void furnish_fountain(atrium *scene, vector3 base);

#endif
