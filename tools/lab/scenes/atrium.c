/* SPDX-License-Identifier: MIT */
/*
 * atrium: an arcaded court of two storeys, cut open at the front and on the right like a doll's house. Metres; the
 * court is bounded by columns at x = -4.5 and 4.5 and z = -7.5, the walls stand at x = -8 and z = -11, and the roof
 * leaves the court open to the sky. The seed moves small things: tiles, cloths and leaves.
 */
#include "furnishings.h"
#include "list.h"

#define BAY         3.0
#define BAYS_LEFT   5
#define BAYS_BACK   3
#define COLUMN_X    4.5
#define COLUMN_Z    (-7.5)
#define WALL_X      8.0
#define WALL_Z      (-11.0)
#define FRONT_Z     8.2
#define SPRING      3.3 /* where the arches start, above their storey's floor */
#define ARCH_RADIUS 1.2
#define STOREY      5.0
#define EAVES       9.7

static const vector3 limestone = {0.93, 0.87, 0.76};
static const vector3 marble_white = {0.97, 0.95, 0.91};

/* ---- floors and walls ---- */

/* A wheel of colored stone around the fountain, a border, and a checkerboard elsewhere. Columns run along z. */
static vector3 floor_color(uint32_t seed, uint32_t column, uint32_t row)
{
    const double x = row + 0.5 - 16;
    const double z = column + 0.5 - 22;

    const double radius = sqrt(x * x + z * z);
    const double shade = 1 + 0.06 * noise(seed, vector(1.7 * column, 0.3, 1.7 * row));
    const bool odd = (column + row) % 2 == 1;
    vector3 color = odd ? vector(0.80, 0.66, 0.52) : vector(0.94, 0.89, 0.80);
    if (radius < 8.2) {
        const bool ring = (uint32_t)(radius / 1.4) % 2 == 1;
        color = ring ? vector(0.45, 0.22, 0.20) : vector(0.92, 0.84, 0.66);
    } else if (row == 7 || row == 24 || column == 6) {
        color = vector(0.30, 0.36, 0.42);
    }
    return vector_scale(color, shade);
}

static vector3 wall_color(uint32_t seed, uint32_t column, uint32_t row)
{
    const double shade = 1 + 0.05 * noise(seed + 3u, vector(1.3 * column, 1.9 * row, 0.5));
    const vector3 plaster = row < 10 ? vector(0.86, 0.60, 0.44) : vector(0.93, 0.80, 0.58);
    const vector3 dado = vector(0.52, 0.20, 0.16);
    const bool band = row == 2 || row == 9 || row == 19;
    return vector_scale(row < 2 ? dado : band ? vector(0.93, 0.86, 0.72) : plaster, shade);
}

static vector3 glass_color(uint32_t seed, uint32_t column, uint32_t row)
{
    static const vector3 glass[5] = {
        {0.20, 0.40, 0.80}, {0.85, 0.25, 0.22}, {0.95, 0.75, 0.25}, {0.25, 0.62, 0.42}, {0.60, 0.35, 0.70}};
    random_stream stream = {.state = seed * 977u + column * 31u + row};
    return glass[random_bits(&stream) % 5];
}

static void add_floor(atrium *scene)
{
    scene_builder *builder = scene->builder;
    builder->material = ATRIUM_STONE;
    const panel ground = {vector(-WALL_X, 0, WALL_Z), vector(0, 0, FRONT_Z - WALL_Z), vector(2 * WALL_X, 0, 0),
                          limestone};

    const tiling tiles = {38, 32, 1.3 * scene->detail, floor_color, scene->seed};
    part_tiles(builder, &ground, &tiles);
    const uint32_t cells = atrium_segments(scene, 4, 1);
    part_box(builder, vector(-8.4, -0.5, -11.4), vector(8.4, -0.04, 8.2), cells, vector(0.70, 0.64, 0.56));
    for (int step = 0; step < 3; ++step) {
        const double reach = 8.2 + 0.35 * (3 - step);
        const double top = -0.04 - 0.15 * (2 - step);
        part_box(builder, vector(-4.5, -0.5, 8.0), vector(4.5, top, reach), cells, limestone);
    }
}

static void add_window(atrium *scene, vector3 center, vector3 across)
{
    scene_builder *builder = scene->builder;
    const vector3 up = vector(0, 1, 0);
    const vector3 outwards = vector_cross(across, up);
    const vector3 middle = vector_add(center, vector_scale(outwards, 0.12));
    const vector3 corner = vector_subtract(vector_subtract(middle, vector_scale(across, 0.6)), vector_scale(up, 0.9));
    const panel pane = {corner, vector_scale(across, 1.2), vector_scale(up, 1.8), marble_white};
    const tiling tiles = {4, 6, scene->detail, glass_color, scene->seed};
    builder->material = ATRIUM_PAINT;
    part_tiles(builder, &pane, &tiles);
    builder->material = ATRIUM_STONE;
    const vector3 half =
        vector(0.75 * fabs(across.x) + 0.1 * fabs(outwards.x), 0.09, 0.75 * fabs(across.z) + 0.1 * fabs(outwards.z));
    const uint32_t cells = atrium_segments(scene, 2, 1);
    part_turned_box(builder, vector_subtract(middle, vector(0, 0.98, 0)), half, 0, cells, marble_white);
    part_turned_box(builder, vector_add(middle, vector(0, 0.98, 0)), half, 0, cells, marble_white);
}

static void add_walls(atrium *scene)
{
    scene_builder *builder = scene->builder;
    const double cells = 1.3 * scene->detail;
    builder->material = ATRIUM_PAINT;
    const panel left = {vector(-WALL_X, 0, FRONT_Z), vector(0, 0, WALL_Z - FRONT_Z), vector(0, 10, 0), limestone};
    const tiling left_tiles = {38, 20, cells, wall_color, scene->seed};
    part_tiles(builder, &left, &left_tiles);
    const panel back = {vector(-WALL_X, 0, WALL_Z), vector(2 * WALL_X, 0, 0), vector(0, 10, 0), limestone};
    const tiling back_tiles = {32, 20, cells, wall_color, scene->seed + 1u};
    part_tiles(builder, &back, &back_tiles);
    builder->material = ATRIUM_STONE;
    const uint32_t block = atrium_segments(scene, 5, 1);
    part_box(builder, vector(-8.4, 0, -11.4), vector(-8.06, 10.6, 8.2), block, limestone);
    part_box(builder, vector(-8.06, 0, -11.4), vector(8.0, 10.6, -11.06), block, limestone);
    for (int bay = 0; bay < BAYS_LEFT; ++bay) {
        for (int storey = 0; storey < 2; ++storey) {
            add_window(scene, vector(-WALL_X, 2.3 + STOREY * storey, -6 + BAY * bay), vector(0, 0, -1));
        }
    }
    for (int bay = 0; bay < BAYS_BACK; ++bay) {
        add_window(scene, vector(-BAY + BAY * bay, 2.3 + STOREY, WALL_Z), vector(1, 0, 0));
    }
}

/* ---- columns and arches ---- */

static void add_column(atrium *scene, vector3 base, double girth)
{
    static const profile_point shaft[] = {{0.40, 0.20}, {0.42, 0.27}, {0.36, 0.33}, {0.36, 0.38}, {0.30, 0.44},
                                          {0.29, 1.2},  {0.27, 2.0},  {0.24, 2.60}, {0.28, 2.64}, {0.28, 2.70},
                                          {0.25, 2.74}, {0.28, 2.88}, {0.42, 3.08}, {0.44, 3.14}};
    scene_builder *builder = scene->builder;
    builder->material = ATRIUM_STONE;
    const uint32_t cells = atrium_segments(scene, 2, 1);
    const double foot = 0.45 * girth;
    const double head = 0.43 * girth;
    part_box(builder, vector_add(base, vector(-foot, 0, -foot)), vector_add(base, vector(foot, 0.2, foot)), cells,
             marble_white);
    profile_point scaled[sizeof shaft / sizeof shaft[0]];
    for (size_t k = 0; k < sizeof shaft / sizeof shaft[0]; ++k) {
        scaled[k] = (profile_point){shaft[k].radius * girth, shaft[k].height};
    }
    const turned_body body = {base, scaled, sizeof shaft / sizeof shaft[0], 1, vector(0.90, 0.85, 0.78), marble_white};
    part_turned_body(builder, &body, atrium_segments(scene, 18, 5), atrium_segments(scene, 30, 8));
    part_box(builder, vector_add(base, vector(-head, 3.14, -head)), vector_add(base, vector(head, SPRING, head)), cells,
             marble_white);
}

/* An arch over one bay: its path runs along the springing, over the semicircle and along the springing again. */
typedef struct arch {
    vector3 start; /* on the springing, above the middle of the first column */
    vector3 along, outwards;
    double top; /* of the wall it carries, above the springing */
    uint32_t arc_segments;
} arch;

typedef struct arch_place {
    double along, height;
    double normal_along, normal_height; /* into the opening */
} arch_place;

static arch_place arch_path(const arch *bow, double u)
{
    const uint32_t last = bow->arc_segments + 2;
    const uint32_t step = (uint32_t)floor(u * last + 0.5);
    if (step == 0 || step == last) {
        return (arch_place){step == 0 ? 0 : BAY, 0, 0, -1};
    }
    const double turns = 0.5 * (1 - (double)(step - 1) / bow->arc_segments);
    const double cosine = cosine_of_turns(turns);
    const double sine = sine_of_turns(turns);
    return (arch_place){0.5 * BAY + ARCH_RADIUS * cosine, ARCH_RADIUS * sine, -cosine, -sine};
}

static vector3 arch_position(const arch *bow, double along, double height, double outwards)
{
    const vector3 flat = vector_add(vector_scale(bow->along, along), vector_scale(bow->outwards, outwards));
    return vector_add(bow->start, vector_add(flat, vector(0, height, 0)));
}

/* Wedge-shaped stones along the curve, plain wall above. */
static vector3 arch_color(const arch_place *place, double v)
{
    const bool dark = (uint32_t)floor((place->normal_along + 1) * 6.5) % 2 == 1;
    if (v > 0.3) {
        return limestone;
    }
    return dark ? vector(0.70, 0.36, 0.28) : marble_white;
}

static surface_point arch_face_point(const void *context, double u, double v)
{
    const arch *bow = context;
    const arch_place place = arch_path(bow, u);
    surface_point point;
    point.position = arch_position(bow, place.along, mix(place.height, bow->top, v), 0.28);
    point.normal = bow->outwards;
    point.color = arch_color(&place, v);
    return point;
}

static surface_point arch_soffit_point(const void *context, double u, double v)
{
    const arch *bow = context;
    const arch_place place = arch_path(bow, u);
    surface_point point;
    point.position = arch_position(bow, place.along, place.height, mix(-0.28, 0.28, v));
    point.normal = vector_add(vector_scale(bow->along, place.normal_along), vector(0, place.normal_height, 0));
    point.color = arch_color(&place, 0);
    return point;
}

/* start: the floor under the middle of the first column. */
static void add_arch(atrium *scene, vector3 start, vector3 along, double top)
{
    arch bow = {.start = vector_add(start, vector(0, SPRING, 0)), .along = along, .top = top};
    bow.arc_segments = atrium_segments(scene, 22, 6);
    bow.outwards = vector_cross(along, vector(0, 1, 0));
    const patch_grid face = {.columns = bow.arc_segments + 2, .rows = atrium_segments(scene, 5, 2)};
    const patch_grid soffit = {.columns = bow.arc_segments + 2, .rows = atrium_segments(scene, 3, 1)};
    scene->builder->material = ATRIUM_STONE;
    part_patch(scene->builder, face, arch_face_point, &bow);
    part_patch(scene->builder, soffit, arch_soffit_point, &bow);
    /* The other face is the same arch walked from its other end. */
    bow.start = vector_add(bow.start, vector_scale(along, BAY));
    bow.along = vector_scale(along, -1);
    bow.outwards = vector_scale(bow.outwards, -1);
    part_patch(scene->builder, face, arch_face_point, &bow);
}

/* ---- vaults, galleries, roof ---- */

typedef struct vault {
    vector3 center; /* on the springing */
    double half_x, half_z;
} vault;

/* A groin vault: the higher of two crossing barrels; its outer side looks down into the room. */
static surface_point vault_point(const void *context, double u, double v)
{
    const vault *bay = context;
    const double x = 2 * u - 1;
    const double z = 2 * v - 1;
    const double barrel_x = sqrt(clamp_to(1 - x * x, 0, 1));
    const double barrel_z = sqrt(clamp_to(1 - z * z, 0, 1));
    const double height = ARCH_RADIUS * (barrel_x > barrel_z ? barrel_x : barrel_z);
    surface_point point;
    point.position = vector_add(bay->center, vector(bay->half_x * x, height, bay->half_z * z));
    point.normal = vector_normalize(barrel_x > barrel_z ? vector(-x, -barrel_x, 0) : vector(0, -barrel_z, -z));
    const double groin = fabs(fabs(x) - fabs(z));
    const bool star = noise(5, vector(23 * x, 0.5, 23 * z)) > 0.6;
    const vector3 gold = vector(0.95, 0.76, 0.34);
    point.color = groin < 0.09 || star ? gold : vector(0.16, 0.28, 0.58);
    return point;
}

static void add_vault(atrium *scene, double x, double z, double half_x, double half_z)
{
    const vault bay = {vector(x, SPRING, z), half_x, half_z};
    const uint32_t cells = atrium_segments(scene, 16, 4);
    const patch_grid grid = {.columns = cells, .rows = cells};
    scene->builder->material = ATRIUM_PAINT;
    part_patch(scene->builder, grid, vault_point, &bay);
}

static void add_balustrade(atrium *scene, vector3 start, vector3 along)
{
    static const profile_point baluster[] = {{0.07, 0.10}, {0.075, 0.16}, {0.04, 0.22}, {0.085, 0.40},
                                             {0.05, 0.62}, {0.04, 0.72},  {0.07, 0.80}};
    scene_builder *builder = scene->builder;
    const vector3 end = vector_add(start, vector_scale(along, BAY));
    const vector3 side = vector_scale(vector(fabs(along.z), 0, fabs(along.x)), 0.13);
    const vector3 low = along.z < 0 ? end : start;
    const vector3 high = along.z < 0 ? start : end;
    const uint32_t cells = atrium_segments(scene, 2, 1);
    builder->material = ATRIUM_STONE;
    part_box(builder, vector_subtract(low, side), vector_add(vector_add(high, side), vector(0, 0.10, 0)), cells,
             marble_white);
    part_box(builder, vector_add(vector_subtract(low, side), vector(0, 0.80, 0)),
             vector_add(vector_add(high, side), vector(0, 0.92, 0)), cells, marble_white);
    for (int k = 0; k < 8; ++k) {
        const vector3 base = vector_add(start, vector_scale(along, BAY * (k + 0.5) / 8));
        const turned_body body = {base, baluster, sizeof baluster / sizeof baluster[0], 1, marble_white, marble_white};
        part_turned_body(builder, &body, atrium_segments(scene, 7, 3), atrium_segments(scene, 8, 3));
    }
}

static void add_galleries(atrium *scene)
{
    scene_builder *builder = scene->builder;
    const uint32_t cells = atrium_segments(scene, 5, 1);
    const vector3 planks = vector(0.84, 0.74, 0.60);
    builder->material = ATRIUM_STONE;
    part_box(builder, vector(-WALL_X, 4.6, COLUMN_Z - 0.35), vector(-COLUMN_X + 0.35, STOREY, FRONT_Z), cells, planks);
    part_box(builder, vector(-WALL_X, 4.6, WALL_Z), vector(WALL_X, STOREY, COLUMN_Z + 0.35), cells, planks);
    for (int bay = 0; bay < BAYS_LEFT; ++bay) {
        add_vault(scene, -6.25, -6 + BAY * bay, 1.75, 0.5 * BAY);
    }
    for (int bay = 0; bay < BAYS_BACK; ++bay) {
        add_vault(scene, -BAY + BAY * bay, -9.25, 0.5 * BAY, 1.75);
    }
    add_vault(scene, -6.25, -9.25, 1.75, 1.75);
    add_vault(scene, 6.25, -9.25, 1.75, 1.75);
}

/* Rows of half-round tiles from the eaves up to the wall. */
typedef struct roof_slope {
    vector3 corner, along, upwards; /* whole extents */
    double ridges;
} roof_slope;

static surface_point roof_point(const void *context, double u, double v)
{
    const roof_slope *slope = context;
    const double wave = fabs(sine_of_turns(0.5 * slope->ridges * u));
    const double lap = v * 7 - floor(v * 7);
    const vector3 flat = vector_add(vector_scale(slope->along, u), vector_scale(slope->upwards, v));
    surface_point point;
    point.position = vector_add(vector_add(slope->corner, flat), vector(0, 0.12 * wave + 0.05 * (1 - lap), 0));
    point.normal = vector_normalize(vector_cross(slope->along, slope->upwards));
    const double shade = 0.80 + 0.15 * wave + 0.12 * noise(11, vector(slope->ridges * u, 7 * v, 0.5));
    point.color = vector_scale(vector(1.0, 0.82, 0.72), shade);
    return point;
}

static void add_roof(atrium *scene)
{
    scene_builder *builder = scene->builder;
    const uint32_t cells = atrium_segments(scene, 4, 1);
    builder->material = ATRIUM_STONE;
    part_box(builder, vector(-4.95, EAVES, -7.95), vector(-4.05, 10.05, FRONT_Z), cells, marble_white);
    part_box(builder, vector(-4.05, EAVES, -7.95), vector(WALL_X, 10.05, -7.05), cells, marble_white);
    builder->material = ATRIUM_TERRACOTTA;
    const roof_slope left = {vector(-3.8, 10.1, FRONT_Z), vector(0, 0, -19.6), vector(-4.6, 1.1, 0), 56};
    const roof_slope back = {vector(-3.8, 10.1, -6.8), vector(11.9, 0, 0), vector(0, 1.1, -4.6), 34};
    const patch_grid left_grid = {.columns = atrium_segments(scene, 112, 28), .rows = atrium_segments(scene, 14, 7)};
    const patch_grid back_grid = {.columns = atrium_segments(scene, 68, 17), .rows = atrium_segments(scene, 14, 7)};
    part_patch(builder, left_grid, roof_point, &left);
    part_patch(builder, back_grid, roof_point, &back);
}

/* ---- the whole ---- */

static void add_storey(atrium *scene, double base, double girth, double wall_top)
{
    const vector3 along_back = vector(1, 0, 0);
    const vector3 along_left = vector(0, 0, -1);
    for (int k = 0; k <= BAYS_LEFT; ++k) {
        add_column(scene, vector(-COLUMN_X, base, COLUMN_Z + BAY * k), girth);
    }
    for (int k = 1; k <= BAYS_BACK; ++k) {
        add_column(scene, vector(-COLUMN_X + BAY * k, base, COLUMN_Z), girth);
    }
    for (int k = 1; k <= BAYS_LEFT; ++k) {
        add_arch(scene, vector(-COLUMN_X, base, COLUMN_Z + BAY * k), along_left, wall_top);
    }
    for (int k = 0; k < BAYS_BACK; ++k) {
        add_arch(scene, vector(-COLUMN_X + BAY * k, base, COLUMN_Z), along_back, wall_top);
    }
}

static void add_furnishings(atrium *scene)
{
    for (int k = 0; k < BAYS_LEFT; ++k) {
        const double z = -6 + BAY * k;
        add_balustrade(scene, vector(-COLUMN_X, STOREY, z + 0.5 * BAY), vector(0, 0, -1));
        furnish_banner(scene, vector(-4.08, 4.9, z), vector(1, 0, 0), (uint32_t)k);
        furnish_vase(scene, vector(-7.3, 0, z), 1.1, k % 2 == 0 ? vector(0.25, 0.42, 0.68) : vector(0.80, 0.45, 0.25));
    }
    for (int k = 0; k < BAYS_BACK; ++k) {
        const double x = -BAY + BAY * k;
        add_balustrade(scene, vector(x - 0.5 * BAY, STOREY, COLUMN_Z), vector(1, 0, 0));
        furnish_banner(scene, vector(x, 4.9, -7.08), vector(0, 0, 1), (uint32_t)k + 1u);
    }
    /* The right row of columns stands free: its gallery is cut away. */
    for (int k = 1; k <= BAYS_LEFT; ++k) {
        const vector3 base = vector(COLUMN_X, 0, COLUMN_Z + BAY * k);
        add_column(scene, base, 1);
        if (k % 2 == 1) {
            furnish_plant(scene, vector_add(base, vector(0, SPRING, 0)), 0.9);
        } else {
            furnish_vase(scene, vector_add(base, vector(0, SPRING, 0)), 1, vector(0.30, 0.45, 0.66));
        }
        furnish_plant(scene, vector(6.9, 0, COLUMN_Z + BAY * k), 1.3);
        furnish_plant(scene, vector(-3.3, 0, COLUMN_Z + BAY * k), 1);
    }
    furnish_tree(scene, vector(-2.6, 0, 5.6));
    furnish_tree(scene, vector(2.6, 0, 5.6));
    furnish_tree(scene, vector(-2.6, 0, -5.6));
    furnish_tree(scene, vector(2.6, 0, -5.6));
    furnish_fountain(scene, vector(0, 0, 0));
}

static void generate_atrium(scene_builder *builder, uint32_t seed, double detail)
{
    atrium scene = {.builder = builder, .detail = detail, .seed = seed, .random = {.state = seed}};
    builder_add_material(builder, vector(0.96, 0.94, 0.90)); /* in the order of atrium_material */
    builder_add_material(builder, vector(1, 1, 1));
    builder_add_material(builder, vector(0.78, 0.43, 0.29));
    builder_add_material(builder, vector(1, 0.96, 0.94));
    builder_add_material(builder, vector(0.95, 1, 0.85));
    builder_add_material(builder, vector(0.55, 0.80, 0.90));
    add_floor(&scene);
    add_walls(&scene);
    add_storey(&scene, 0, 1, 1.3);
    add_storey(&scene, STOREY, 0.8, 0.3 + EAVES - STOREY - SPRING);
    add_galleries(&scene);
    add_roof(&scene);
    add_furnishings(&scene);
}

void scene_atrium(scene_builder *builder, const scene_request *request)
{
    builder_fit(builder, request, generate_atrium);
}
