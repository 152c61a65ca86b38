/* SPDX-License-Identifier: MIT */
/*
 * Pictures of lights against closed forms: direct light of each kind of source, shadows, openness, sky, emission and
 * specular light of finishes; trees without triangles; what is refused.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "light_fixture.h"
#include "support/suite.h"

#define PI    3.14159265358979323846
#define DEPTH 5
/* No multiple of a tile's edge. */
#define WIDTH  37
#define HEIGHT 21
#define CLAY   0.6

static const svo_plan_options everything = {.need = SVO_NEED_NORMAL | SVO_NEED_RAYS | SVO_NEED_MATERIAL |
                                                    SVO_NEED_PROJECTED_AREA,
                                            .edge = 2.0,
                                            .origin = {-1.0, -1.0, -1.0}};

/* ---- scenes ---- */

/* A floor at y = 0 over the whole grid, and behind it, at high, a small roof above the middle. */
static const float floor_and_roof[8 * 3] = {-1,    0,    -1,    1,    0,    -1,    1,    0,    1,    -1,    0,    1,
                                            -0.3F, 0.6F, -0.3F, 0.3F, 0.6F, -0.3F, 0.3F, 0.6F, 0.3F, -0.3F, 0.6F, 0.3F};
static const uint32_t squares[4 * 3] = {0, 2, 1, 0, 3, 2, 4, 6, 5, 4, 7, 6};
static const uint16_t materials_of[4] = {0, 0, 1, 1};
static const svo_material materials[2] = {{.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE},
                                          {.rgba = {255, 255, 255, 255}, .texture_index = SVO_NO_TEXTURE}};

typedef struct lit_floor {
    built made;
    svo_light *light;
} lit_floor;

static void open_floor(const fixture *opened, bool with_roof, lit_floor *out)
{
    svo_mesh mesh = SVO_MESH_INIT;
    mesh.positions = floor_and_roof;
    mesh.vertex_count = 8;
    mesh.indices = squares;
    mesh.triangle_count = with_roof ? 4 : 2;
    mesh.triangle_materials = materials_of;
    mesh.materials = materials;
    mesh.material_count = 2;
    fixture_build(opened, &mesh, DEPTH, &everything, &out->made);
    out->light = light_of(opened, out->made.tree, SVO_LIGHT_FACES);
}

/* A scene of one clay, of 12 corners. */
static void open_clay(const fixture *opened, const float *positions, const uint32_t *indices, size_t triangle_count,
                      lit_floor *out)
{
    svo_mesh mesh = SVO_MESH_INIT;
    mesh.positions = positions;
    mesh.vertex_count = 12;
    mesh.indices = indices;
    mesh.triangle_count = triangle_count;
    fixture_build(opened, &mesh, DEPTH, &everything, &out->made);
    out->light = light_of(opened, out->made.tree, SVO_LIGHT_FACES);
}

static void close_floor(lit_floor *scene)
{
    svo_light_destroy(&scene->light);
    built_destroy(&scene->made);
}

static void shine(const fixture *opened, svo_light *light, const svo_light_source *source, float sky)
{
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    setup.sources = source;
    setup.source_count = source != NULL;
    setup.sky[0] = setup.sky[1] = setup.sky[2] = sky;
    light_succeed(opened, svo_light_set_sources(light, &setup, opened->queue));
}

/* ---- pictures ---- */

/* Looks down at the floor's middle, from far away: a pixel is a seventieth of a unit wide. */
static svo_render_options picture_of(svo_render_view view)
{
    svo_render_options picture = SVO_RENDER_OPTIONS_INIT;
    picture.width = WIDTH;
    picture.height = HEIGHT;
    picture.camera = (svo_camera){{0, 20, 0}, {0, 0, 0}, {0, 0, -1}, 0.015F};
    picture.view = view;
    return picture;
}

static const uint8_t *pixel_at(const uint8_t *rgba, int x, int y)
{
    return rgba + 4 * ((size_t)y * WIDTH + (size_t)x);
}

/* The byte that a radiance is shown as: the tone curve, then sRGB. */
static double byte_of(double radiance)
{
    const double share = radiance > 0.5 ? 1 - exp(1 - 2 * radiance) / 2 : radiance;
    return 255 * (share <= 0.0031308 ? 12.92 * share : 1.055 * pow(share, 1 / 2.4) - 0.055);
}

static void expect_byte(const char *what, const uint8_t *pixel, double radiance, double tolerance)
{
    const double expected = byte_of(radiance);
    if (!(fabs(pixel[0] - expected) <= tolerance) || pixel[3] != 255) {
        fail_msg("%s: byte %d instead of %g, of radiance %g", what, pixel[0], expected, radiance);
    }
}

static void draw(const fixture *opened, svo_light *light, const svo_render_options *picture, uint8_t *rgba)
{
    memset(rgba, 0x5a, (size_t)WIDTH * HEIGHT * 4);
    light_succeed(
        opened, svo_render(svo_light_target(light), picture, svo_in_host(rgba), &(svo_submit){.queue = opened->queue}));
}

/* ---- direct light ---- */

/* E times the cosine; I over the squared distance; I inside a spot's inner angle, 0 outside its outer one. */
static void sources_light_directly(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_render_options picture = picture_of(SVO_VIEW_DIRECT);
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    lit_floor scene;
    open_floor(&opened, false, &scene);
    const svo_light_source sun = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {30, -40, 0}, .value = {1.5F, 1.5F, 1.5F}};
    shine(&opened, scene.light, &sun, 0);
    draw(&opened, scene.light, &picture, rgba);
    for (int y = 0; y < HEIGHT; ++y) {
        for (int x = 0; x < WIDTH; ++x) {
            expect_byte("sun", pixel_at(rgba, x, y), CLAY / PI * 1.5 * 0.8, 1);
        }
    }
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {0, 0.8F, 0}, .value = {0.5F, 0.5F, 0.5F}};
    shine(&opened, scene.light, &lamp, 0);
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("lamp", pixel_at(rgba, WIDTH / 2, HEIGHT / 2), CLAY / PI * 0.5 / 0.64, 1);
    svo_light_source spot = lamp;
    spot.kind = SVO_SOURCE_SPOT;
    spot.direction[1] = -3;
    spot.inner_angle = 0.05F;
    spot.outer_angle = 0.1F;
    shine(&opened, scene.light, &spot, 0);
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("spot", pixel_at(rgba, WIDTH / 2, HEIGHT / 2), CLAY / PI * 0.5 / 0.64, 1);
    expect_byte("beside the spot", pixel_at(rgba, 2, HEIGHT / 2), 0, 0);
    close_floor(&scene);
}

/* Under the roof, seen from the side: dark where the sun is above it, as bright as ever beside it. */
static void shadows_are_those_of_triangles(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    svo_render_options picture = picture_of(SVO_VIEW_DIRECT);
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, -1, 0}, .value = {1, 1, 1}};
    lit_floor scene;
    open_floor(&opened, true, &scene);
    shine(&opened, scene.light, &sun, 0);
    picture.camera = (svo_camera){{0, 0.3F, 0.95F}, {0, 0, 0}, {0, 1, 0}, 0.05F};
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("under the roof", pixel_at(rgba, WIDTH / 2, HEIGHT / 2), 0, 0);
    picture.camera.target[0] = 0.35F;
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("beside the roof", pixel_at(rgba, WIDTH / 2, HEIGHT / 2), CLAY / PI, 1);
    close_floor(&scene);
}

/* Below an edge of the roof a pixel shows the share of the sun's disk that the edge leaves over, by the default of 16
   rays. */
static void suns_with_a_size_have_soft_shadows(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static float pixels[WIDTH * HEIGHT * 4];
    const double radius = 0.1;
    const double edge = 0.3;
    const svo_light_source sun = {
        .kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, -1, 0}, .value = {1, 1, 1}, .radius = (float)radius};
    double mean = 0;
    double variance = 0;
    svo_render_options picture = picture_of(SVO_VIEW_DIRECT);
    lit_floor scene;
    open_floor(&opened, true, &scene);
    shine(&opened, scene.light, &sun, 0);
    picture.camera = (svo_camera){{(float)edge, 0.3F, 0.95F}, {(float)edge, 0, 0}, {0, 1, 0}, 0.05F};
    picture.output.format = SVO_PIXELS_LINEAR;
    light_succeed(&opened, svo_render(svo_light_target(scene.light), &picture, svo_in_host(pixels),
                                      &(svo_submit){.queue = opened.queue}));
    for (int y = 0; y < HEIGHT; ++y) {
        for (int x = 0; x < WIDTH; ++x) {
            const double aside = (x + 0.5 - WIDTH / 2.0) * 2 * tan(0.025) / HEIGHT * hypot(0.3, 0.95);
            const double height = aside / (0.6 * sin(radius));
            const double expected = 0.5 + (height * sqrt(1 - height * height) + asin(height)) / PI;
            const double share = (double)pixels[4 * (y * WIDTH + x)] * PI / CLAY;
            mean += (share - expected) / (WIDTH * HEIGHT);
            variance += (share - expected) * (share - expected) / (WIDTH * HEIGHT);
        }
    }
    /* 16 rays at random would err by .13 where half of the disk is covered */
    if (fabs(mean) > 0.003 || variance > 0.06 * 0.06) {
        fail_msg("shares are off by %g in the mean, %g as a rule", mean, sqrt(variance));
    }
    close_floor(&scene);
}

/* ---- cones ---- */

/* An open floor is white, reflects all of the sky, and the sky is what it is; a roof darkens the floor. */
static void floors_are_open_to_the_sky(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    svo_render_options picture = picture_of(SVO_VIEW_AO);
    lit_floor scene;
    open_floor(&opened, false, &scene);
    shine(&opened, scene.light, NULL, 0.25F);
    draw(&opened, scene.light, &picture, rgba);
    const int open = pixel_at(rgba, WIDTH / 2, HEIGHT / 2)[0];
    assert_true(open >= 245);
    picture.view = SVO_VIEW_INDIRECT;
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("floor under the sky", pixel_at(rgba, WIDTH / 2, HEIGHT / 2), CLAY * 0.25, 5);
    picture.camera = (svo_camera){{0, 0.5F, 0}, {0, 5, 0}, {0, 0, -1}, 0.5F};
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("sky", pixel_at(rgba, 0, 0), 0.25, 1);
    picture.exposure = 2;
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("sky exposed twice", pixel_at(rgba, 0, 0), 0.5, 1);
    close_floor(&scene);
    open_floor(&opened, true, &scene);
    shine(&opened, scene.light, NULL, 0);
    picture = picture_of(SVO_VIEW_AO);
    picture.camera = (svo_camera){{0, 0.3F, 0.95F}, {0, 0, 0}, {0, 1, 0}, 0.05F};
    draw(&opened, scene.light, &picture, rgba);
    assert_true(pixel_at(rgba, WIDTH / 2, HEIGHT / 2)[0] < open - 20);
    close_floor(&scene);
}

static double linear_of(int byte)
{
    const double coded = byte / 255.0;
    return coded <= 0.04045 ? coded / 12.92 : pow((coded + 0.055) / 1.055, 2.4);
}

/* What is full is direct and indirect light together; photons and what is gathered can be left out. */
static void full_is_direct_and_indirect(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static uint8_t rgba[3][WIDTH * HEIGHT * 4];
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {1, -1, 0}, .value = {1, 1, 1}};
    static const svo_render_view views[3] = {SVO_VIEW_DIRECT, SVO_VIEW_INDIRECT, SVO_VIEW_SHADED};
    lit_floor scene;
    open_floor(&opened, true, &scene);
    shine(&opened, scene.light, &sun, 0.2F);
    for (int i = 0; i < 3; ++i) {
        svo_render_options picture = picture_of(views[i]);
        picture.camera = (svo_camera){{0, 0.5F, 0.5F}, {0, 0, 0.1F}, {0, 1, 0}, 0.5F};
        draw(&opened, scene.light, &picture, rgba[i]);
    }
    for (size_t at = 0; at < (size_t)WIDTH * HEIGHT; ++at) {
        const double direct = linear_of(rgba[0][4 * at]);
        const double indirect = linear_of(rgba[1][4 * at]);
        const double full = linear_of(rgba[2][4 * at]);
        if (fabs(direct + indirect - full) > 0.01) {
            fail_msg("pixel %zu: direct %g, indirect %g, full %g", at, direct, indirect, full);
            return;
        }
    }
    const svo_gather_options no_light = {.struct_size = sizeof no_light, .no_light = 1};
    svo_render_options without = picture_of(SVO_VIEW_SHADED);
    without.camera = (svo_camera){{0, 0.5F, 0.5F}, {0, 0, 0.1F}, {0, 1, 0}, 0.5F};
    without.gather = &no_light;
    draw(&opened, scene.light, &without, rgba[2]);
    const size_t last = (size_t)WIDTH * HEIGHT - WIDTH / 2;
    assert_int_equal(rgba[2][4 * last], rgba[0][4 * last]);
    svo_light_setup dark = SVO_LIGHT_SETUP_INIT;
    dark.sources = &sun;
    dark.source_count = 1;
    dark.no_photons = 1;
    light_succeed(&opened, svo_light_set_sources(scene.light, &dark, opened.queue));
    assert_int_equal(light_info_of(scene.light).photons, 0);
    const svo_gather_options cones = {.struct_size = sizeof cones, .method = SVO_GATHER_CONES};
    without.gather = &cones;
    draw(&opened, scene.light, &without, rgba[2]);
    assert_int_equal(rgba[2][4 * last], rgba[0][4 * last]);
    /* Rays need no photons. */
    without.gather = NULL;
    draw(&opened, scene.light, &without, rgba[0]);
    shine(&opened, scene.light, &sun, 0);
    draw(&opened, scene.light, &without, rgba[2]);
    assert_memory_equal(rgba[2], rgba[0], sizeof rgba[0]);
    assert_true(rgba[2][4 * last] > 0);
    close_floor(&scene);
}

/* The roof emits; the floor is a mirror of a wide lobe, in which it shows. */
static void finishes_emit_and_reflect(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    const svo_finish finishes[2] = {{.specular = {0.5F, 0.5F, 0.5F}, .exponent = 40}, {.emission = {0.4F, 0.4F, 0.4F}}};
    svo_light_setup setup = SVO_LIGHT_SETUP_INIT;
    lit_floor scene;
    open_floor(&opened, true, &scene);
    setup.finishes = finishes;
    setup.finish_count = 2;
    light_succeed(&opened, svo_light_set_sources(scene.light, &setup, opened.queue));
    svo_render_options picture = picture_of(SVO_VIEW_SHADED);
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("roof", pixel_at(rgba, WIDTH / 2, HEIGHT / 2), 0.4, 12);
    picture.view = SVO_VIEW_SPECULAR;
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("roof without specular color", pixel_at(rgba, WIDTH / 2, HEIGHT / 2), 0, 0);
    picture.camera = (svo_camera){{0, 0.3F, 0.15F}, {0, 0, 0}, {0, 1, 0}, 0.05F};
    draw(&opened, scene.light, &picture, rgba);
    expect_byte("floor that mirrors the roof", pixel_at(rgba, WIDTH / 2, HEIGHT / 2), 0.2, 40);
    assert_true(pixel_at(rgba, WIDTH / 2, HEIGHT / 2)[0] > 60);
    close_floor(&scene);
}

/* ---- voxels ---- */

/* A floor of given voxels, which has no triangles: rays meet its faces. */
static void trees_without_triangles_are_drawn(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    uint8_t *alphas = calloc((size_t)32 * 32 * 32, 1);
    assert_non_null(alphas);
    for (int z = 0; z < 32; ++z) {
        for (int x = 0; x < 32; ++x) {
            alphas[(size_t)z * 1024 + (size_t)x] = 255;
        }
    }
    svo_tree *tree = light_tree_of(&opened, DEPTH, alphas);
    svo_tree_info info = SVO_TREE_INFO_INIT;
    (void)svo_tree_get_info(tree, &info);
    svo_light *light = light_of(&opened, tree, SVO_LIGHT_BRICKS);
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0, -1, 0}, .value = {1, 1, 1}};
    shine(&opened, light, &sun, 0);
    svo_render_options picture = picture_of(SVO_VIEW_DIRECT);
    const float edge = (float)info.edge;
    const float middle[3] = {(float)info.origin[0] + 0.5F * edge, (float)info.origin[1],
                             (float)info.origin[2] + 0.5F * edge};
    picture.camera = (svo_camera){
        {middle[0], middle[1] + 5 * edge, middle[2]}, {middle[0], middle[1], middle[2]}, {0, 0, -1}, 0.05F};
    draw(&opened, light, &picture, rgba);
    const uint8_t *pixel = pixel_at(rgba, WIDTH / 2, HEIGHT / 2);
    const double albedo = svo_tree_get_buffer(tree, SVO_TREE_COLORS) != NULL ? -1 : CLAY;
    if (albedo > 0) {
        expect_byte("floor of voxels", pixel, albedo / PI, 1);
    } else {
        assert_true(pixel[0] > 0 || pixel[1] > 0 || pixel[2] > 0);
    }
    svo_light_destroy(&light);
    svo_tree_destroy(&tree);
    free(alphas);
}

/* ---- clipping ---- */

/* A plane above the floor leaves the sky of it, or all of it, for each view. */
static void a_plane_cuts_the_floor_away(void **state)
{
    static const svo_render_view views[] = {SVO_VIEW_SHADED, SVO_VIEW_AO, SVO_VIEW_DIRECT, SVO_VIEW_INDIRECT,
                                            SVO_VIEW_SPECULAR};
    const fixture opened = fixture_cl_of_group(state);
    static uint8_t pictures[3][WIDTH * HEIGHT * 4];
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {1, -1, 0}, .value = {1, 1, 1}};
    lit_floor scene;
    open_floor(&opened, false, &scene);
    shine(&opened, scene.light, &sun, 0.2F);
    for (size_t view = 0; view < sizeof views / sizeof views[0]; ++view) {
        svo_render_options picture = picture_of(views[view]);
        draw(&opened, scene.light, &picture, pictures[0]);
        picture.clip[1] = -1; /* the eye is on the side that is cut away */
        picture.clip[3] = 5;
        draw(&opened, scene.light, &picture, pictures[1]);
        assert_memory_equal(pictures[0], pictures[1], sizeof pictures[0]);
        picture.clip[1] = 1; /* the floor is */
        picture.clip[3] = -5;
        draw(&opened, scene.light, &picture, pictures[1]);
        picture.camera.target[1] = 40; /* away from it */
        draw(&opened, scene.light, &picture, pictures[2]);
        assert_memory_equal(pictures[1], pictures[2], sizeof pictures[0]);
    }
    close_floor(&scene);
}

/* ---- bands ---- */

/* Rows that are drawn by themselves are those of the whole picture; what is beside them stays. */
static void bands_are_rows_of_the_picture(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static uint8_t whole[WIDTH * HEIGHT * 4];
    static uint8_t bands[WIDTH * HEIGHT * 4];
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {1, -1, 0}, .value = {1, 1, 1}};
    const size_t above = (size_t)WIDTH * SVO_LIGHT_BAND_ROWS * 4;
    svo_render_options picture = picture_of(SVO_VIEW_SHADED);
    lit_floor scene;
    open_floor(&opened, true, &scene);
    shine(&opened, scene.light, &sun, 0.2F);
    picture.camera = (svo_camera){{0, 0.5F, 0.5F}, {0, 0, 0.1F}, {0, 1, 0}, 0.5F};
    draw(&opened, scene.light, &picture, whole);
    picture.row_count = SVO_LIGHT_BAND_ROWS;
    draw(&opened, scene.light, &picture, bands);
    assert_int_equal(bands[above], 0x5a);
    picture.first_row = SVO_LIGHT_BAND_ROWS;
    picture.row_count = 0;
    light_succeed(&opened, svo_render(svo_light_target(scene.light), &picture, svo_in_host(bands + above),
                                      &(svo_submit){.queue = opened.queue}));
    assert_memory_equal(bands, whole, sizeof whole);
    picture.row_count = 2 * SVO_LIGHT_BAND_ROWS;
    light_succeed(&opened, svo_render(svo_light_target(scene.light), &picture, svo_in_host(bands + above),
                                      &(svo_submit){.queue = opened.queue}));
    assert_memory_equal(bands, whole, sizeof whole);
    close_floor(&scene);
}

enum { TALL = 208 };

/* So are those whose light is smoothed across the rows of others: bands gather beyond their own. */
static void bands_have_the_light_beside_them(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static uint8_t whole[WIDTH * TALL * 4];
    static uint8_t bands[WIDTH * TALL * 4];
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {1, -1, 0}, .value = {1, 1, 1}};
    svo_render_options picture = picture_of(SVO_VIEW_INDIRECT);
    lit_floor scene;
    open_floor(&opened, true, &scene);
    shine(&opened, scene.light, &sun, 0.2F);
    picture.height = TALL;
    picture.camera = (svo_camera){{0, 0.5F, 0.5F}, {0, 0, 0.1F}, {0, 1, 0}, 0.5F};
    light_succeed(&opened, svo_render(svo_light_target(scene.light), &picture, svo_in_host(whole),
                                      &(svo_submit){.queue = opened.queue}));
    picture.row_count = 3 * SVO_LIGHT_BAND_ROWS;
    for (picture.first_row = 0; picture.first_row < TALL; picture.first_row += picture.row_count) {
        light_succeed(&opened, svo_render(svo_light_target(scene.light), &picture,
                                          svo_in_host(bands + (size_t)picture.first_row * WIDTH * 4),
                                          &(svo_submit){.queue = opened.queue}));
    }
    assert_memory_equal(bands, whole, sizeof whole);
    close_floor(&scene);
}

/* 16 paths of 2 x 2 pixels, smoothed, beside 4,096; the roof's shadow keeps its edge. */
static void few_rays_look_like_many(void **state)
{
    static const svo_render_view views[3] = {SVO_VIEW_AO, SVO_VIEW_INDIRECT, SVO_VIEW_SHADED};
    const fixture opened = fixture_cl_of_group(state);
    const svo_gather_options many = {.struct_size = sizeof many, .method = SVO_GATHER_RAYS, .paths = 4096};
    const svo_light_source sun = {.kind = SVO_SOURCE_DIRECTIONAL, .direction = {0.2F, -1, 0}, .value = {1, 1, 1}};
    static uint8_t rgba[2][WIDTH * HEIGHT * 4];
    lit_floor scene;
    open_floor(&opened, true, &scene);
    shine(&opened, scene.light, &sun, 0.3F);
    for (int i = 0; i < 3; ++i) {
        svo_render_options picture = picture_of(views[i]);
        double squares_sum = 0;
        picture.camera = (svo_camera){{0, 0.5F, 0.5F}, {0, 0, 0.1F}, {0, 1, 0}, 0.5F};
        draw(&opened, scene.light, &picture, rgba[0]);
        picture.gather = &many;
        draw(&opened, scene.light, &picture, rgba[1]);
        for (size_t at = 0; at < sizeof rgba[0]; ++at) {
            const double off = (double)rgba[0][at] - rgba[1][at];
            squares_sum += off * off;
        }
        const double rmse = sqrt(squares_sum / (double)sizeof rgba[0]);
        print_message("view %d: RMSE %.2f of 255\n", (int)views[i], rmse);
        assert_true(rmse < 2.5); /* 3.7 of openness without the filter */
    }
    close_floor(&scene);
}

/* A closed room of 1.8 x 0.5 x 1.8 with a hole of 0.3 x 0.3 in its ceiling. */
static const float dark_room[12 * 3] = {-0.9F, 0,    -0.9F,  0.9F,  0,    -0.9F, 0.9F,   0,    0.9F,
                                        -0.9F, 0,    0.9F,   -0.9F, 0.5F, -0.9F, 0.9F,   0.5F, -0.9F,
                                        0.9F,  0.5F, 0.9F,   -0.9F, 0.5F, 0.9F,  -0.15F, 0.5F, -0.15F,
                                        0.15F, 0.5F, -0.15F, 0.15F, 0.5F, 0.15F, -0.15F, 0.5F, 0.15F};
static const uint32_t room_faces[18 * 3] = {0, 2, 1,  0, 3,  2, 0, 1, 5,  0, 5,  4,  1, 2, 6, 1, 6, 5,
                                            2, 3, 7,  2, 7,  6, 3, 0, 4,  3, 4,  7,  4, 5, 9, 4, 9, 8,
                                            5, 6, 10, 5, 10, 9, 6, 7, 11, 6, 11, 10, 7, 4, 8, 7, 8, 11};

/* Where one path in forty finds the sky, most cells of a picture find none: what the others find is theirs, too. */
static void smoothing_keeps_rare_light(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_gather_options many = {.struct_size = sizeof many, .method = SVO_GATHER_RAYS, .paths = 512};
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    svo_render_options picture = picture_of(SVO_VIEW_INDIRECT);
    double sums[2] = {0, 0};
    lit_floor scene;
    open_clay(&opened, dark_room, room_faces, 18, &scene);
    shine(&opened, scene.light, NULL, 10.0F);
    for (int from = 0; from < 8; ++from) { /* from each corner to one of two places */
        const float x = (from & 1) != 0 ? 1.0F : -1.0F;
        const float z = (from & 2) != 0 ? 1.0F : -1.0F;
        const float near = (from & 4) != 0 ? 0.5F : 0.4F;
        picture.camera = (svo_camera){{0.8F * x, 0.4F, 0.8F * z}, {near * x, 0, near * z}, {0, 1, 0}, 0.5F};
        for (int i = 0; i < 2; ++i) {
            picture.gather = i == 1 ? &many : NULL;
            draw(&opened, scene.light, &picture, rgba);
            for (size_t at = 0; at < sizeof rgba; at += 4) {
                sums[i] += linear_of(rgba[at]) / (8 * WIDTH * HEIGHT);
            }
        }
    }
    print_message("mean of %.4f instead of %.4f\n", sums[0], sums[1]);
    assert_true(fabs(sums[0] / sums[1] - 1) < 0.03); /* 0.13 where cells are compared by their own light */
    close_floor(&scene);
}

/* A canyon, seen from above, and on the left a lid on it: what rays bring is noisy in the canyon, and steady on the
   lid. */
static const float canyon_and_lid[12 * 3] = {-1, 0,    -0.3F, 1, 0,    -0.3F, 1, 0,    0.3F, -1, 0,    0.3F,
                                             -1, 0.5F, -0.3F, 1, 0.5F, -0.3F, 1, 0.5F, 0.3F, -1, 0.5F, 0.3F,
                                             -1, 0.5F, -0.3F, 0, 0.5F, -0.3F, 0, 0.5F, 0.3F, -1, 0.5F, 0.3F};
static const uint32_t canyon_faces[8 * 3] = {0, 2, 1, 0, 3, 2, 0, 1, 5, 0, 5, 4, 3, 7, 6, 3, 6, 2, 8, 10, 9, 8, 11, 10};

/* The mean openness of a picture's column, linear. */
static double mean_of_column(const uint8_t *rgba, int x)
{
    double sum = 0;
    for (int y = 0; y < HEIGHT; ++y) {
        sum += linear_of(pixel_at(rgba, x, y)[0]);
    }
    return sum / HEIGHT;
}

/* Smoothing ends at edges, though what lies behind them differs by little more than the noise. */
static void edges_of_surfaces_are_kept(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    const svo_render_options picture = picture_of(SVO_VIEW_AO);
    lit_floor scene;
    open_clay(&opened, canyon_and_lid, canyon_faces, 8, &scene);
    draw(&opened, scene.light, &picture, rgba);
    const double beside_lid = mean_of_column(rgba, WIDTH / 2 + 2);
    print_message("openness of the canyon: %.3f\n", beside_lid);
    assert_true(beside_lid > 0.2 && beside_lid < 0.5);
    for (int x = WIDTH / 2 - 3; x < WIDTH / 2; ++x) {
        assert_true(mean_of_column(rgba, x) > 0.999);
    }
    close_floor(&scene);
}

static void expect_refused(const fixture *opened, svo_light *light, const svo_render_options *picture,
                           const char *words)
{
    static uint8_t rgba[WIDTH * HEIGHT * 4];
    assert_int_equal(
        svo_render(svo_light_target(light), picture, svo_in_host(rgba), &(svo_submit){.queue = opened->queue}),
        SVO_INVALID_ARGUMENT);
    if (strstr(svo_device_message(opened->device), words) == NULL) {
        fail_msg("'%s' is not in '%s'", words, svo_device_message(opened->device));
    }
}

static void wrong_pictures_are_refused(void **state)
{
    const fixture opened = fixture_cl_of_group(state);
    const svo_render_options good = picture_of(SVO_VIEW_SHADED);
    const svo_gather_options three = {.struct_size = sizeof three, .cones = 3};
    lit_floor scene;
    open_floor(&opened, false, &scene);
#define REFUSED(change, words)                               \
    do {                                                     \
        svo_render_options wrong = good;                     \
        change;                                              \
        expect_refused(&opened, scene.light, &wrong, words); \
    } while (0)
    REFUSED(wrong.width = 0, "svo_render: 0 x 21 pixels are not within 1 .. 16384");
    REFUSED(wrong.camera.vertical_fov = 4, "svo_render: camera.vertical_fov 4 is not between 0 and pi");
    REFUSED(wrong.camera.up[2] = NAN, "svo_render: camera.eye, target and up are not finite");
    REFUSED(wrong.camera.target[1] = 20, "camera.eye, target and up are not finite, or up is along");
    REFUSED(wrong.view = (svo_render_view)10,
            "svo_render: options.view 10 is none of a light, which has SVO_VIEW_SHADED, AO, DIRECT");
    REFUSED(wrong.first_row = 8, "svo_render: options.first_row 8 is not a multiple of 16 below height");
    REFUSED(wrong.first_row = 16 * wrong.height, "is not a multiple of 16 below height");
    REFUSED(wrong.row_count = 17, "svo_render: options.row_count 17 is not a multiple of 16");
    REFUSED(wrong.clip[0] = INFINITY, "svo_render: clip inf, 0, 0, 0 is not finite");
    REFUSED(wrong.exposure = -1, "svo_render: options.exposure -1 is negative or not finite");
    REFUSED(wrong.gather = &three, "svo_render: options.gather.cones 3 is not 1, 5, 6, 16 or 64");
#undef REFUSED
    assert_int_equal(svo_render(svo_light_target(NULL), &good, svo_in_host(NULL), NULL), SVO_INVALID_ARGUMENT);
    expect_refused(&opened, scene.light, NULL, "svo_render: options is NULL");
    assert_int_equal(svo_render(svo_light_target(scene.light), &good, svo_in_host(NULL), NULL), SVO_INVALID_ARGUMENT);
    assert_string_equal(svo_device_message(opened.device), "svo_render: pixels is NULL");
    close_floor(&scene);
}

TEST_GROUP(light_picture)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(sources_light_directly),
                                       cmocka_unit_test(shadows_are_those_of_triangles),
                                       cmocka_unit_test(suns_with_a_size_have_soft_shadows),
                                       cmocka_unit_test(floors_are_open_to_the_sky),
                                       cmocka_unit_test(full_is_direct_and_indirect),
                                       cmocka_unit_test(finishes_emit_and_reflect),
                                       cmocka_unit_test(trees_without_triangles_are_drawn),
                                       cmocka_unit_test(bands_are_rows_of_the_picture),
                                       cmocka_unit_test(bands_have_the_light_beside_them),
                                       cmocka_unit_test(few_rays_look_like_many),
                                       cmocka_unit_test(smoothing_keeps_rare_light),
                                       cmocka_unit_test(edges_of_surfaces_are_kept),
                                       cmocka_unit_test(a_plane_cuts_the_floor_away),
                                       cmocka_unit_test(wrong_pictures_are_refused)};
    return cmocka_run_group_tests_name("light_picture", tests, fixture_group_setup, fixture_group_teardown);
}
