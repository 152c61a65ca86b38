/* SPDX-License-Identifier: MIT */
/*
 * cornell: the box of Goral, Torrance, Greenberg, Battaile (SIGGRAPH 1984) as it is drawn since: red and green walls,
 * two boxes and, here, a sphere. The front is open. Its colors come from materials; the seed turns the boxes.
 */
#include "list.h"
#include "parts.h"

/* A wall. Walls increase their cell counts at different details, so that the triangle count grows smoothly. */
static void add_wall(scene_builder *builder, const panel *wall, double base, double detail)
{
    part_panel(builder, wall, detail_segments(base, detail, 1), detail_segments(base + 0.25, detail, 1));
}

static void add_walls(scene_builder *builder, double detail)
{
    const vector3 white = vector(1, 1, 1);
    const vector3 right = vector(2, 0, 0);
    const vector3 up = vector(0, 2, 0);
    const vector3 front = vector(0, 0, 2);
    const panel floor_panel = {vector(-1, 0, -1), front, right, white};
    const panel ceiling = {vector(-1, 2, -1), right, front, white};
    const panel back = {vector(-1, 0, -1), right, up, white};
    const panel left = {vector(-1, 0, -1), up, front, white};
    const panel right_wall = {vector(1, 0, -1), front, up, white};
    builder_add_material(builder, vector(0.88, 0.86, 0.82));
    add_wall(builder, &floor_panel, 12.0, detail);
    add_wall(builder, &ceiling, 11.9, detail);
    add_wall(builder, &back, 11.8, detail);
    builder_add_material(builder, vector(0.75, 0.16, 0.13));
    add_wall(builder, &left, 11.7, detail);
    builder_add_material(builder, vector(0.22, 0.55, 0.20));
    add_wall(builder, &right_wall, 11.6, detail);
}

static void generate_cornell(scene_builder *builder, uint32_t seed, double detail)
{
    random_stream stream = {.state = seed};
    const double tall_turns = -0.05 + random_between(&stream, -0.02, 0.02);
    const double short_turns = 0.05 + random_between(&stream, -0.02, 0.02);
    add_walls(builder, detail);
    builder_add_material(builder, vector(0.90, 0.88, 0.84));
    const vector3 white = vector(1, 1, 1);
    part_turned_box(builder, vector(-0.35, 0.6, -0.35), vector(0.3, 0.6, 0.3), tall_turns,
                    detail_segments(9.3, detail, 1), white);
    part_turned_box(builder, vector(0.4, 0.3, 0.3), vector(0.3, 0.3, 0.3), short_turns, detail_segments(8.8, detail, 1),
                    white);
    builder_add_material(builder, vector(0.35, 0.50, 0.75));
    const ball sphere = {vector(0.4, 0.88, 0.3), 0.28, white};
    part_ball(builder, &sphere, detail_segments(12, detail, 2));
    builder_add_material(builder, vector(1, 0.95, 0.75));
    part_box(builder, vector(-0.3, 1.95, -0.3), vector(0.3, 1.98, 0.3), detail_segments(3, detail, 1), white);
}

void scene_cornell(scene_builder *builder, const scene_request *request)
{
    builder_fit(builder, request, generate_cornell);
}
