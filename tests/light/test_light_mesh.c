/* SPDX-License-Identifier: MIT */
/*
 * Lights that have the mesh of their tree: pictures beside the texels, normals and materials at their pixels, far away
 * beside the leaves; shadows and views through what the texture leaves out; light between surfaces; normal maps; what
 * is refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "light_fixture.h"
#include "support/suite.h"

#define PI     3.14159265F
#define DEPTH  3u
#define EDGE   8 /* of a card, world units */
#define TEXELS 16u

/* ---- cards: quads at z above the origin, which face +z; u goes with x, v with y ---- */

#define CARDS 3

typedef struct cards {
    svo_mesh mesh;
    float positions[18 * CARDS], uvs[12 * CARDS], normals[18 * CARDS];
    uint16_t materials[2 * CARDS];
    svo_material material[CARDS];
    svo_finish finishes[CARDS];
    svo_normal_map maps[CARDS];
    svo_texture texture;
    uint8_t texels[4 * 64 * 64];
    fixture opened;
    svo_tree *tree;
    svo_light *light;
} cards;

static cards *cards_new(void **state, uint32_t texels)
{
    cards *made = calloc(1, sizeof *made);
    assert_non_null(made);
    made->opened = fixture_cl_of_group(state);
    made->texture = (svo_texture){.rgba = made->texels, .width = texels, .height = texels};
    for (size_t i = 0; i < CARDS; ++i) {
        made->material[i] = (svo_material){.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE};
        made->maps[i] = (svo_normal_map){.texture_index = SVO_NO_TEXTURE, .scale = 1};
    }
    made->mesh = (svo_mesh){.struct_size = sizeof made->mesh,
                            .positions = made->positions,
                            .uvs = made->uvs,
                            .triangle_materials = made->materials,
                            .materials = made->material,
                            .material_count = CARDS,
                            .textures = &made->texture,
                            .texture_count = 1,
                            .finishes = made->finishes};
    return made;
}

/* Adds a card of the next material, with so many repetitions of the texture. */
static void add_card(cards *to, float z, float repeats)
{
    static const float corners[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    const size_t card = to->mesh.triangle_count / 2;
    for (size_t i = 0; i < 6; ++i) {
        const size_t vertex = 6 * card + i;
        for (size_t axis = 0; axis < 2; ++axis) {
            to->positions[3 * vertex + axis] = EDGE * corners[i][axis];
            to->uvs[2 * vertex + axis] = repeats * corners[i][axis];
        }
        to->positions[3 * vertex + 2] = z;
    }
    to->materials[2 * card] = to->materials[2 * card + 1] = (uint16_t)card;
    to->mesh.triangle_count += 2;
    to->mesh.vertex_count += 6;
}

/* Builds the tree of the cards; its light has a sun along -z of irradiance pi, so that surfaces that face it send their
   albedo. */
static void light_cards(cards *of)
{
    static const svo_light_source sun = {SVO_SOURCE_DIRECTIONAL, .direction = {0, 0, -1}, .value = {PI, PI, PI}};
    const svo_plan_options options = {.need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_MATERIAL};
    const svo_light_options without_cones = {.struct_size = sizeof without_cones, .no_cones = 1};
    const svo_light_setup setup = {.struct_size = sizeof setup,
                                   .sources = &sun,
                                   .source_count = 1,
                                   .finishes = of->finishes,
                                   .finish_count = CARDS};
    built finished;
    fixture_build(&of->opened, &of->mesh, DEPTH, &options, &finished);
    of->tree = finished.tree;
    finished.tree = NULL;
    built_destroy(&finished);
    light_succeed(&of->opened, svo_light_create(of->tree, &without_cones, of->opened.queue, &of->light));
    light_succeed(&of->opened, svo_light_set_sources(of->light, &setup, of->opened.queue));
}

static void give_mesh(cards *of)
{
    light_succeed(&of->opened, svo_light_set_mesh(of->light, &of->mesh, of->opened.queue));
}

static void cards_free(cards *of)
{
    svo_light_destroy(&of->light);
    svo_tree_destroy(&of->tree);
    free(of);
}

/* What a pixel of so many world units sees of a card at z 0, straight from above. */
static void look(const cards *at, svo_render_view view, float x, float y, float width, float out[4])
{
    svo_render_options options = {.struct_size = sizeof options, .width = 1, .height = 1, .view = view};
    const float away = 64;
    options.output.format = SVO_PIXELS_LINEAR;
    options.output.samples = 1;
    options.camera = (svo_camera){.eye = {x, y, away}, .target = {x, y, 0}, .up = {0, 1, 0}};
    options.camera.vertical_fov = 2 * atanf(width / 2 / away);
    light_succeed(&at->opened, svo_render(svo_light_target(at->light), &options, svo_in_host(out),
                                          &(svo_submit){.queue = at->opened.queue}));
}

static void check_near(const char *what, float found, float wanted, float tolerance)
{
    if (!(fabsf(found - wanted) <= tolerance)) {
        fail_msg("%s is %g, not %g", what, (double)found, (double)wanted);
    }
}

static float linear_of(uint8_t byte)
{
    const float share = byte / 255.0F;
    return share <= 0.04045F ? share / 12.92F : powf((share + 0.055F) / 1.055F, 2.4F);
}

static void fill_random(cards *of)
{
    uint32_t state = 1;
    for (size_t i = 0; i < sizeof of->texels; ++i) {
        state = state * 1664525u + 1013904223u;
        of->texels[i] = i % 4 == 3 ? 255 : (uint8_t)(state >> 24);
    }
}

/* ---- tests ---- */

/* The texture lies on the card twice: repeated along x, mirrored along y. Of the texels, of which a leaf has 4 x 4,
   each pixel shows its own. */
static void pixels_show_their_texels(void **state)
{
    cards *on = cards_new(state, TEXELS);
    fill_random(on);
    on->texture.wrap_v = SVO_WRAP_MIRROR;
    on->material[0].texture_index = 0;
    on->material[0].rgba[1] = 100;
    add_card(on, 0, 2);
    light_cards(on);
    give_mesh(on);
    assert_true(light_info_of(on->light).mesh_bytes > sizeof(uint32_t) * TEXELS * TEXELS);
    for (uint32_t row = 1; row < 2 * TEXELS; row += 5) {
        for (uint32_t column = 0; column < 2 * TEXELS; column += 3) {
            const uint32_t from_row = row < TEXELS ? row : 2 * TEXELS - 1 - row;
            const uint8_t *texel = on->texels + 4 * (size_t)(from_row * TEXELS + column % TEXELS);
            const float texel_edge = EDGE / (2.0F * TEXELS);
            float pixel[4];
            look(on, SVO_VIEW_DIRECT, ((float)column + 0.5F) * texel_edge, ((float)row + 0.5F) * texel_edge, 1e-4F,
                 pixel);
            check_near("red", pixel[0], linear_of(texel[0]), 0.002F);
            check_near("green", pixel[1], linear_of((uint8_t)((2 * 100 * texel[1] + 255) / 510)), 0.006F);
            check_near("blue", pixel[2], linear_of(texel[2]), 0.002F);
        }
    }
    cards_free(on);
}

/* Rays that are as wide as a leaf see the leaf, as without a mesh; and so they do without one again. */
static void wide_rays_see_leaves(void **state)
{
    cards *on = cards_new(state, TEXELS);
    float bare[4];
    float pixel[4];
    fill_random(on);
    on->material[0].texture_index = 0;
    add_card(on, 0, 1);
    light_cards(on);
    look(on, SVO_VIEW_DIRECT, 2.3F, 5.1F, 1.1F, bare);
    give_mesh(on);
    look(on, SVO_VIEW_DIRECT, 2.3F, 5.1F, 1.1F, pixel);
    assert_memory_equal(bare, pixel, sizeof bare);
    look(on, SVO_VIEW_DIRECT, 2.3F, 5.1F, 0.01F, pixel);
    assert_memory_not_equal(bare, pixel, sizeof bare);
    light_succeed(&on->opened, svo_light_set_mesh(on->light, NULL, on->opened.queue));
    assert_int_equal(light_info_of(on->light).mesh_bytes, 0);
    look(on, SVO_VIEW_DIRECT, 2.3F, 5.1F, 0.01F, pixel);
    assert_memory_equal(bare, pixel, sizeof bare);
    cards_free(on);
}

/* A board of 63 x 63 texels of black and white, of which wide pixels have the mean wherever they look. */
static void wide_rays_see_means(void **state)
{
    cards *on = cards_new(state, 63);
    for (uint32_t i = 0; i < 63 * 63; ++i) {
        const uint8_t byte = (i / 63 + i % 63) % 2 == 0 ? 255 : 0;
        memset(on->texels + 4 * (size_t)i, byte, 3);
        on->texels[4 * (size_t)i + 3] = 255;
    }
    on->material[0].texture_index = 0;
    add_card(on, 0, 1);
    light_cards(on);
    give_mesh(on);
    for (int i = 0; i < 20; ++i) {
        float pixel[4];
        look(on, SVO_VIEW_DIRECT, 1 + 0.31F * (float)i, 1.5F + 0.21F * (float)i, 0.45F, pixel);
        check_near("the mean", pixel[0], linear_of(128), 0.012F);
    }
    cards_free(on);
}

/* Levels weigh by alpha: red around holes of green. */
static void means_weigh_by_alpha(void **state)
{
    cards *on = cards_new(state, 64);
    for (uint32_t i = 0; i < 64 * 64; ++i) {
        const bool is_hole = (i / 64 + i % 64) % 2 != 0;
        const uint8_t texel[4] = {is_hole ? 0 : 200, is_hole ? 255 : 0, 0, is_hole ? 1 : 255};
        memcpy(on->texels + 4 * (size_t)i, texel, 4);
    }
    on->material[0].texture_index = 0;
    add_card(on, 0, 1);
    add_card(on, -1, 1);
    light_cards(on);
    give_mesh(on);
    float pixel[4];
    look(on, SVO_VIEW_DIRECT, 3.3F, 4.2F, 0.45F, pixel);
    check_near("red", pixel[0], linear_of(199), 0.01F);
    check_near("green", pixel[1], linear_of(1), 0.001F);
    cards_free(on);
}

/* A card above another one, of which the texture leaves out a half: its shadow and the view through it end between the
   texels, inside of leaves. */
static void cut_outs_end_at_their_texels(void **state)
{
    enum { POINTS = 14 };
    cards *on = cards_new(state, TEXELS);
    svo_gather_point points[POINTS];
    svo_gather_result results[POINTS];
    for (uint32_t i = 0; i < TEXELS * TEXELS; ++i) {
        const uint8_t texel[4] = {255, 0, 0, i % TEXELS < 7 ? 0 : 255};
        memcpy(on->texels + 4 * (size_t)i, texel, 4);
    }
    on->material[0].rgba[0] = 0;
    on->material[1].texture_index = 0;
    add_card(on, -3, 1);
    add_card(on, 0, 1);
    light_cards(on);
    give_mesh(on);
    for (int i = 0; i < POINTS; ++i) {
        const int beyond = i - POINTS / 2;
        const float x = beyond < 0 ? 3.2F - 0.4F * (float)i : 3.8F + 0.5F * (float)beyond;
        const svo_gather_point point = {.position = {x, 3.1F, -3}, .normal = {0, 0, 1}};
        points[i] = point;
    }
    const svo_gather_options options = {.struct_size = sizeof options, .paths = 16};
    light_succeed(&on->opened, svo_gather(on->light, svo_in_host(points), svo_in_host(results), POINTS, &options,
                                          &(svo_submit){.queue = on->opened.queue}));
    for (int i = 0; i < POINTS; ++i) {
        const bool is_open = i < POINTS / 2;
        float pixel[4];
        check_near("direct light", results[i].direct[0], is_open ? PI : 0, 1e-5F);
        look(on, SVO_VIEW_DIRECT, points[i].position[0], 3.1F, 1e-3F, pixel);
        check_near("red of the view", pixel[0], is_open ? 0 : 1, 1e-3F);
        check_near("green of the view", pixel[1], is_open ? 1 : 0, 1e-3F);
    }
    cards_free(on);
}

/* Two panes, one by the alpha of its material and one by that of its vertices, let their shares of the sun through. */
static void panes_multiply(void **state)
{
    cards *on = cards_new(state, TEXELS);
    uint8_t colors[4 * 6 * CARDS];
    memset(colors, 255, sizeof colors);
    for (size_t i = 12; i < 18; ++i) {
        colors[4 * i + 3] = 51;
    }
    on->mesh.colors = colors;
    on->material[1].rgba[3] = 102;
    add_card(on, -3, 1);
    add_card(on, -1, 1);
    add_card(on, 0, 1);
    light_cards(on);
    give_mesh(on);
    const svo_gather_point point = {.position = {3, 4, -2}, .normal = {0, 0, 1}};
    svo_gather_result result;
    light_succeed(&on->opened, svo_gather(on->light, svo_in_host(&point), svo_in_host(&result), 1, NULL,
                                          &(svo_submit){.queue = on->opened.queue}));
    check_near("direct light", result.direct[1], PI * 0.6F * 0.8F, 1e-4F);
    cards_free(on);
}

/* Vertex normals, one of which is missing, lean: the middle of a triangle has their mean. */
static void normals_are_those_of_vertices(void **state)
{
    cards *on = cards_new(state, TEXELS);
    const float leaning[3] = {0.6F, 0, 0.8F};
    add_card(on, 0, 1);
    for (size_t i = 0; i < 5; ++i) {
        memcpy(on->normals + 3 * i, leaning, sizeof leaning);
    }
    on->mesh.normals = on->normals;
    light_cards(on);
    give_mesh(on);
    float pixel[4];
    look(on, SVO_VIEW_DIRECT, 7, 1, 1e-4F, pixel);
    check_near("of three normals", pixel[0], 0.8F, 1e-3F);
    look(on, SVO_VIEW_DIRECT, EDGE / 3.0F, 2 * EDGE / 3.0F, 1e-4F, pixel);
    check_near("of two and its own", pixel[0], 2.6F / sqrtf(1.2F * 1.2F + 2.6F * 2.6F), 1e-3F);
    cards_free(on);
}

/* ---- normal maps ---- */

/* A card whose texture is a normal map. Its red, green and blue are given; lit by a sun along a unit direction. */
static cards *map_card(void **state, uint32_t texels, float repeats, const float sun[3])
{
    cards *on = cards_new(state, texels);
    const svo_light_source source = {SVO_SOURCE_DIRECTIONAL, .direction = {sun[0], sun[1], sun[2]},
                                     .value = {PI, PI, PI}};
    const svo_light_setup setup = {.struct_size = sizeof setup, .sources = &source, .source_count = 1};
    on->maps[0].texture_index = 0;
    on->mesh.normal_maps = on->maps;
    add_card(on, 0, repeats);
    light_cards(on);
    light_succeed(&on->opened, svo_light_set_sources(on->light, &setup, on->opened.queue));
    return on;
}

static void put_texel(cards *on, size_t index, uint8_t red, uint8_t green, uint8_t blue)
{
    const uint8_t texel[4] = {red, green, blue, 0}; /* alpha is not read */
    memcpy(on->texels + 4 * index, texel, 4);
}

/* Of a bent normal, the cosine to a sun that shines along -to. flips: of x and y. */
static float bent_cosine(const uint8_t *texel, float scale, const float flips[2], const float to[3])
{
    const float x = flips[0] * scale * (2 * texel[0] / 255.0F - 1);
    const float y = flips[1] * scale * (2 * texel[1] / 255.0F - 1);
    const float z = 2 * texel[2] / 255.0F - 1;
    return (x * to[0] + y * to[1] + z * to[2]) / sqrtf(x * x + y * y + z * z);
}

/* A card has one bent normal everywhere: it sends its albedo times the cosine. v runs up the card here and down an
   image, so that y of the map points down the card. Turned and mirrored coordinates turn and mirror the map. */
static void tilted_maps_tilt(void **state)
{
    static const float sun[3] = {-0.6F, 0, -0.8F};
    static const float steep[3] = {0, -0.6F, -0.8F};
    static const struct {
        float u_scale, v_scale, map_scale;
        const float *sun;
    } cases[] = {{1, 1, 1, sun},     {-1, 1, 1, sun},  {1, -1, 1, sun},   {-1, -1, 1, sun},
                 {1, 1, 0.5F, sun},  {1, 1, 1, steep}, {1, -1, 1, steep}, {1, 1, 2, steep},
                 {-1, 1, -1, steep}, {1, 1, -1, sun},  {1, 1, 0, steep}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const float to[3] = {-cases[i].sun[0], -cases[i].sun[1], -cases[i].sun[2]};
        const float flips[2] = {cases[i].u_scale, -cases[i].v_scale};
        float pixel[4];
        cards *on = map_card(state, 1, 1, cases[i].sun);
        put_texel(on, 0, 178, 204, 210);
        on->maps[0].scale = cases[i].map_scale;
        on->material[0].rgba[1] = 100;
        for (size_t k = 0; k < 6; ++k) {
            on->uvs[2 * k] *= cases[i].u_scale;
            on->uvs[2 * k + 1] *= cases[i].v_scale;
        }
        give_mesh(on);
        look(on, SVO_VIEW_DIRECT, 3.1F, 2.6F, 1e-4F, pixel);
        const float wanted = fmaxf(bent_cosine(on->texels, cases[i].map_scale, flips, to), 0);
        check_near("red", pixel[0], wanted, 1e-3F);
        check_near("green", pixel[1], wanted * linear_of(100), 1e-3F);
        cards_free(on);
    }
}

/* Two texels, the left one bent to the left and the right one to the right; between their middles the mean. */
static void each_texel_bends(void **state)
{
    static const float sun[3] = {-0.6F, 0, -0.8F};
    static const float to[3] = {0.6F, 0, 0.8F};
    static const float flips[2] = {1, -1};
    cards *on = map_card(state, 2, 1, sun);
    float pixel[4];
    put_texel(on, 0, 51, 128, 230);
    put_texel(on, 1, 204, 128, 230);
    on->texture.height = 1;
    on->texture.wrap_u = SVO_WRAP_CLAMP;
    give_mesh(on);
    look(on, SVO_VIEW_DIRECT, 1, 4, 1e-4F, pixel);
    check_near("left", pixel[0], bent_cosine(on->texels, 1, flips, to), 1e-3F);
    look(on, SVO_VIEW_DIRECT, 7, 4, 1e-4F, pixel);
    check_near("right", pixel[0], bent_cosine(on->texels + 4, 1, flips, to), 1e-3F);
    look(on, SVO_VIEW_DIRECT, 4, 4, 1e-4F, pixel);
    check_near("between", pixel[0], bent_cosine((const uint8_t[]){128, 128, 230}, 1, flips, to), 1e-3F);
    cards_free(on);
}

/* Light of the sky is gathered along the bent normal too: of a sky of 1, (1 + cosine of the tilt) / 2 of its irradiance
   arrives; the rest is the card itself, which is black. */
static void skies_light_bent_normals(void **state)
{
    static const float sun[3] = {0, 0, -1};
    static const svo_light_setup setup = {.struct_size = sizeof setup, .sky = {1, 1, 1}};
    static const svo_gather_options gather = {.struct_size = sizeof gather, .paths = 1024, .bounces = 1};
    svo_render_options options = {.struct_size = sizeof options, .width = 4, .height = 4, .view = SVO_VIEW_INDIRECT};
    cards *on = map_card(state, 1, 1, sun);
    float pixels[4 * 16];
    put_texel(on, 0, 229, 128, 204);
    light_succeed(&on->opened, svo_light_set_sources(on->light, &setup, on->opened.queue));
    give_mesh(on);
    options.output.format = SVO_PIXELS_LINEAR;
    options.gather = &gather;
    options.camera = (svo_camera){.eye = {4, 4, 64}, .target = {4, 4, 0}, .up = {0, 1, 0}, .vertical_fov = 0.01F};
    light_succeed(&on->opened, svo_render(svo_light_target(on->light), &options, svo_in_host(pixels),
                                          &(svo_submit){.queue = on->opened.queue}));
    const float tilt = bent_cosine(on->texels, 1, (const float[2]){1, -1}, (const float[3]){0, 0, 1});
    for (size_t i = 0; i < 16; ++i) {
        check_near("the sky's light", pixels[4 * i], (1 + tilt) / 2, 4e-3F);
    }
    cards_free(on);
}

/* From behind all of the normal is mirrored; vertex normals say which side is the front. */
static void backs_are_mirrored(void **state)
{
    static const float sun[3] = {-0.6F, 0, 0.8F};
    static const float toward_front[3] = {0.6F, 0, -0.8F};
    static const float flips[2] = {1, -1};
    cards *on = map_card(state, 1, 1, sun);
    svo_render_options options = {.struct_size = sizeof options, .width = 1, .height = 1, .view = SVO_VIEW_DIRECT};
    float pixel[4];
    put_texel(on, 0, 178, 128, 230);
    options.output.format = SVO_PIXELS_LINEAR;
    options.output.samples = 1;
    options.camera = (svo_camera){.eye = {3, 3, -64}, .target = {3, 3, 0}, .up = {0, 1, 0}, .vertical_fov = 1e-5F};
    for (int side = 0; side < 2; ++side) {
        if (side == 1) {
            for (size_t i = 0; i < 6; ++i) {
                on->normals[3 * i + 2] = -1;
            }
            on->mesh.normals = on->normals;
        }
        give_mesh(on);
        light_succeed(&on->opened, svo_render(svo_light_target(on->light), &options, svo_in_host(pixel),
                                              &(svo_submit){.queue = on->opened.queue}));
        /* The back sees the negative of the front's normal; with normals that say so it is the front, bent along u. */
        const float behind = -bent_cosine(on->texels, 1, flips, toward_front);
        const float front = bent_cosine(on->texels, 1, flips, (const float[3]){0.6F, 0, 0.8F});
        check_near(side == 0 ? "the back" : "the front", pixel[0], side == 0 ? behind : front, 2e-3F);
    }
    cards_free(on);
}

/* Without an area of coordinates, or coordinates at all, there is no map; nor where no material has one. */
static void maps_need_coordinates(void **state)
{
    static const float sun[3] = {-0.6F, 0, -0.8F};
    cards *on = map_card(state, 1, 0, sun);
    float pixel[4];
    put_texel(on, 0, 178, 204, 210);
    give_mesh(on);
    const uint64_t with_maps = light_info_of(on->light).mesh_bytes;
    look(on, SVO_VIEW_DIRECT, 3, 3, 1e-4F, pixel);
    check_near("without an area", pixel[0], 0.8F, 1e-4F);
    on->mesh.uvs = NULL;
    give_mesh(on);
    look(on, SVO_VIEW_DIRECT, 3, 3, 1e-4F, pixel);
    check_near("without coordinates", pixel[0], 0.8F, 1e-4F);
    on->mesh.uvs = on->uvs;
    on->maps[0].texture_index = 1;
    give_mesh(on);
    /* Two triangles of 16 bytes, records of 32 for three materials, and a texel are left out. */
    assert_int_equal(with_maps - light_info_of(on->light).mesh_bytes, 2 * 16 + 3 * 32 + 4);
    cards_free(on);
}

/* The two triangles of a card, of which one emits: on either side of their edge, in the same leaf. */
static void materials_are_those_of_triangles(void **state)
{
    cards *on = cards_new(state, TEXELS);
    float pixel[4];
    on->finishes[0].emission[0] = 2;
    add_card(on, 0, 1);
    on->materials[1] = 1;
    light_cards(on);
    give_mesh(on);
    look(on, SVO_VIEW_SHADED, 4.6F, 4.4F, 1e-4F, pixel);
    check_near("red that emits", pixel[0], 3, 1e-3F);
    check_near("green that does not", pixel[1], 1, 1e-3F);
    look(on, SVO_VIEW_SHADED, 4.4F, 4.6F, 1e-4F, pixel);
    check_near("red that does not emit", pixel[0], 1, 1e-3F);
    cards_free(on);
}

/* A red card close above a blue one that emits; the sun shines on the red one, whose light a point above gathers. */
static void gather_above(void **state, size_t card_count, bool with_mesh, float out[3])
{
    static const svo_gather_options by_rays = {.struct_size = sizeof by_rays, .paths = 256};
    const svo_gather_point above = {.position = {4, 4, 3}, .normal = {0, 0, -1}};
    svo_gather_result result;
    cards *on = cards_new(state, TEXELS);
    on->material[0].rgba[1] = on->material[0].rgba[2] = 0;
    on->material[1].rgba[0] = on->material[1].rgba[1] = 0;
    on->finishes[1].emission[2] = 5;
    add_card(on, 0.4F, 1);
    for (size_t i = 1; i < card_count; ++i) {
        add_card(on, 0.4F - 0.3F * (float)i, 1);
    }
    light_cards(on);
    if (with_mesh) {
        give_mesh(on);
    }
    light_succeed(&on->opened, svo_gather(on->light, svo_in_host(&above), svo_in_host(&result), 1, &by_rays,
                                          &(svo_submit){.queue = on->opened.queue}));
    memcpy(out, result.irradiance, sizeof result.irradiance);
    cards_free(on);
}

/* What is hidden behind a surface in the same leaf does not color its light, nor does it shine through. */
static void light_between_surfaces_has_their_own_colors(void **state)
{
    float alone[3];
    float of_leaves[3];
    float own[3];
    gather_above(state, 1, true, alone);
    gather_above(state, 2, false, of_leaves);
    gather_above(state, 2, true, own);
    assert_true(alone[0] > 0.5F && of_leaves[2] > 0.1F * alone[0]);
    check_near("red", own[0], alone[0], 1e-3F * alone[0]);
    check_near("green", own[1], 0, 0);
    check_near("blue of what is hidden", own[2], 0, 0);
}

/* Indices and doubles are as good as floats in a row. */
static void all_kinds_of_arrays_are_read(void **state)
{
    cards *on = cards_new(state, TEXELS);
    double positions[18 * CARDS];
    uint32_t indices[6];
    float first[4];
    float second[4];
    fill_random(on);
    on->material[0].texture_index = 0;
    add_card(on, 0, 3);
    light_cards(on);
    give_mesh(on);
    look(on, SVO_VIEW_DIRECT, 3.3F, 4.1F, 0.2F, first);
    for (size_t i = 0; i < 18; ++i) {
        positions[i] = (double)on->positions[i];
    }
    for (uint32_t i = 0; i < 6; ++i) {
        indices[i] = i;
    }
    on->mesh.positions_double = positions;
    on->mesh.positions = NULL;
    on->mesh.indices = indices;
    give_mesh(on);
    look(on, SVO_VIEW_DIRECT, 3.3F, 4.1F, 0.2F, second);
    assert_memory_equal(first, second, sizeof first);
    cards_free(on);
}

static void check_refused(const cards *on, const char *text)
{
    assert_int_equal(svo_light_set_mesh(on->light, &on->mesh, on->opened.queue), SVO_INVALID_ARGUMENT);
    if (strstr(svo_device_message(on->opened.device), text) == NULL) {
        fail_msg("'%s' is not in '%s'", text, svo_device_message(on->opened.device));
    }
    assert_int_equal(light_info_of(on->light).mesh_bytes, 0);
}

static void other_meshes_are_refused(void **state)
{
    cards *on = cards_new(state, TEXELS);
    static const svo_plan_options no_rays = {.need = SVO_NEED_COLOR};
    const svo_light_options without_cones = {.struct_size = sizeof without_cones, .no_cones = 1};
    built finished;
    add_card(on, 0, 1);
    light_cards(on);
    give_mesh(on);
    on->mesh.triangle_count = 1;
    check_refused(on, "svo_light_set_mesh: mesh has 1 triangles; that of the tree has 2");
    on->mesh.triangle_count = 2;
    on->texture.width = 0;
    check_refused(on, "svo_light_set_mesh: texture 0 is 0 x 16 texels, not 1 .. 16384 each, or has none");
    on->texture.width = TEXELS;
    on->mesh.normal_maps = on->maps;
    on->maps[2].scale = NAN;
    check_refused(on, "svo_light_set_mesh: normal map 2 has a scale of nan, not finite");
    on->mesh.normal_maps = NULL;
    on->mesh.positions = NULL;
    check_refused(on, "mesh has 6 vertices but not exactly one array of positions");
    on->mesh.positions = on->positions;
    give_mesh(on);
    const svo_box all = {{-1, -1, -1}, {EDGE + 1, EDGE + 1, 1}};
    light_succeed(&on->opened, svo_light_update(on->light, on->tree, &all, 1, on->opened.queue));
    assert_int_equal(light_info_of(on->light).mesh_bytes, 0);
    svo_light_destroy(&on->light);
    fixture_build(&on->opened, &on->mesh, DEPTH, &no_rays, &finished);
    light_succeed(&on->opened, svo_light_create(finished.tree, &without_cones, on->opened.queue, &on->light));
    check_refused(on, "svo_light_set_mesh: the tree has no triangles for rays");
    svo_light_destroy(&on->light);
    built_destroy(&finished);
    assert_int_equal(svo_light_set_mesh(NULL, &on->mesh, on->opened.queue), SVO_INVALID_ARGUMENT);
    cards_free(on);
}

/* Materials, vertices and textures that do not exist are none, as builds have it. */
static void bad_names_are_harmless(void **state)
{
    cards *on = cards_new(state, TEXELS);
    uint32_t indices[6] = {0, 1, 2, 3, 4, 77};
    float pixel[4];
    add_card(on, 0, 1);
    on->materials[0] = 900;
    on->material[0].texture_index = 5;
    on->material[0].rgba[0] = 0;
    on->uvs[0] = NAN;
    on->mesh.indices = indices;
    light_cards(on);
    give_mesh(on);
    look(on, SVO_VIEW_DIRECT, 6, 2, 1e-4F, pixel);
    check_near("red", pixel[0], 0, 1e-4F);
    check_near("green", pixel[1], 1, 1e-4F);
    cards_free(on);
}

TEST_GROUP(light_mesh)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_show_their_texels),
        cmocka_unit_test(wide_rays_see_leaves),
        cmocka_unit_test(wide_rays_see_means),
        cmocka_unit_test(means_weigh_by_alpha),
        cmocka_unit_test(cut_outs_end_at_their_texels),
        cmocka_unit_test(panes_multiply),
        cmocka_unit_test(normals_are_those_of_vertices),
        cmocka_unit_test(materials_are_those_of_triangles),
        cmocka_unit_test(all_kinds_of_arrays_are_read),
        cmocka_unit_test(other_meshes_are_refused),
        cmocka_unit_test(bad_names_are_harmless),
        cmocka_unit_test(light_between_surfaces_has_their_own_colors),
        cmocka_unit_test(tilted_maps_tilt),
        cmocka_unit_test(each_texel_bends),
        cmocka_unit_test(skies_light_bent_normals),
        cmocka_unit_test(backs_are_mirrored),
        cmocka_unit_test(maps_need_coordinates),
    };
    return cmocka_run_group_tests_name("light_mesh", tests, fixture_group_setup, fixture_group_teardown);
}
