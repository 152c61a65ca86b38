/* SPDX-License-Identifier: MIT */
/* The files that `svocl render` writes: formats, backgrounds, samples, turntables and films, sides to look from. */
#include "program_picture.h"
#include "run_program.h"
#include "support/suite.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define KNOT "$SVOCL build scene:knot -d 6 -o a.svo -q"

/* ---- formats ---- */

/* The byte of a shaded picture that light becomes: the tone curve, then a square root. */
static double byte_of_light(double light)
{
    return 255 * sqrt(light > 0.5 ? 1 - 0.5 * exp(1 - 2 * light) : light);
}

/* step: by how much the largest channel's share a channel may be too dark. */
static void compare_light(const char *path, const program_picture *shown, double step)
{
    int width = 0;
    int height = 0;
    float *light = read_light(path, &width, &height);
    assert_int_equal(width, shown->width);
    assert_int_equal(height, shown->height);
    for (size_t at = 0; at < 4 * (size_t)width * (size_t)height; at += 4) {
        const double largest =
            fmax((double)light[at], fmax((double)light[at + 1], (double)light[at + 2])) * (shown->rgba[at + 3] > 0);
        for (size_t i = at; i < at + 3 && largest > 0; ++i) {
            const double low = byte_of_light((double)light[i]) - 0.51;
            const double high = byte_of_light((double)light[i] + step * largest) + 0.51;
            if (shown->rgba[i] < low || shown->rgba[i] > high) {
                fail_msg("%s: channel %zu is %g, byte %g .. %g, and %u in the PNG", path, i, (double)light[i], low,
                         high, shown->rgba[i]);
            }
        }
    }
    free(light);
}

static void formats_hold_one_picture(void **state)
{
    (void)state;
    need_builds();
#define RENDER "$SVOCL render a.svo -q --size 40x37 --samples 1 "
    run_well(KNOT);
    run_well(RENDER "-o a.png --background transparent && " RENDER "-o a.hdr && " RENDER "-o a.ppm");
    program_picture shown = read_picture("a.png");
    compare_light("a.hdr", &shown, 1.0 / 128); /* one exponent for three channels, cut off to 8 bits */
#ifdef SVOCL_EXR
    run_well(RENDER "-o a.exr --background transparent && " RENDER "-o b.exr --background transparent");
    run_well("cmp a.exr b.exr && " RENDER "--format exr -o - --background transparent | cmp - a.exr");
    compare_light("a.exr", &shown, 0);
    int width = 0;
    int height = 0;
    float *light = read_light("a.exr", &width, &height);
    assert_true(light[3] == 0 && shown.rgba[3] == 0);
    assert_true(light[4 * (18 * 40 + 20) + 3] <= 1);
    free(light);
    run_well("rm a.exr b.exr");
#else
    run_badly(RENDER "-o a.exr", 1, "-o a.exr: this program was built without OpenEXR (libopenexr-dev)");
#endif
    free_picture(&shown);
    /* The bytes of PPM are those of PNG. */
    run_well(RENDER "-o a.png");
    shown = read_picture("a.png");
    static char ppm[TEXT_BYTES];
    FILE *file = fopen("a.ppm", "rb");
    assert_non_null(file);
    const size_t bytes = fread(ppm, 1, sizeof ppm, file);
    (void)fclose(file);
    assert_int_equal(bytes, 13 + 3 * 40 * 37);
    assert_memory_equal(ppm, "P6\n40 37\n255\n", 13);
    for (size_t i = 0; i < 40 * 37; ++i) {
        assert_memory_equal(ppm + 13 + 3 * i, shown.rgba + 4 * i, 3);
    }
    free_picture(&shown);
    run_well(RENDER "-o - | cmp - a.png");
    run_well("rm a.png a.hdr a.ppm a.svo");
#undef RENDER
}

/* A suffix that no picture has is refused before any work, and so is what a format does not hold. */
static void a_wrong_file_is_one_line(void **state)
{
    (void)state;
#define RENDER "$SVOCL render missing.obj "
    run_badly(RENDER "-o a.jpg", 2, "output a.jpg does not end in .png, .exr, .hdr, .ppm or .y4m");
    run_badly("$SVOCL render missing.json --animate -o film.gif", 2, "output film.gif does not end in .png");
    run_badly(RENDER "-o a.png --format gif", 2, "--format 'gif' is none of png, exr, hdr, ppm, y4m");
    run_badly(RENDER "-o a.ppm --background transparent", 2, ".ppm has no alpha; --background transparent takes .png");
    run_badly(RENDER "-o a.hdr --background transparent", 2, ".hdr has no alpha; --background transparent takes .exr");
    run_badly(RENDER "-o a.png --background 1,2", 2, "--background '1,2' is neither transparent nor R,G,B");
    run_badly(RENDER "-o a.png --background 1,2,256", 2, "each 0 to 255");
    run_badly(RENDER "-o a.hdr --view normal", 2, ".hdr has no negative numbers; --view normal takes .exr");
    run_badly(RENDER "-o a.hdr --view depth --background 1,2,3", 2, "this view is numbers");
    run_badly(RENDER "-o a.hdr --view triangles --samples 4", 2, "triangles are numbers");
    run_badly(RENDER "-o a.png --samples 0", 2, "samples 0 is below 1");
    run_badly(RENDER "-o a.png --samples 4097", 2, "is above 4096");
    run_badly(RENDER "-o a.png --fps 24", 2, "--fps applies to .y4m alone");
    run_badly(RENDER "-o - --turntable 4 > a.bin", 2, "--turntable writes several files, not to standard output");
    run_badly(RENDER "-o a.png --from north", 2, "--from 'north' is none of front, left, right");
    run_well("rm a.bin");
    expect_files(NULL, 0);
#undef RENDER
}

/* Every way to draw takes samples, a background and a linear file. */
static void every_picture_has_them(void **state)
{
    (void)state;
    need_builds();
    run_well(KNOT " && $SVOCL build scene:knot:500 -d 4 --need none --solid winding -o a.svc -q");
    write_text("scene.json", "{\"trees\": {\"k\": {\"path\": \"a.svo\"}}, \"instances\": [{\"tree\": \"k\"}]}");
    static const char *const ways[] = {"a.svo",
                                       "a.svc",
                                       "scene:knot:500 -d 4",
                                       "scene.json",
                                       "a.svo --view normal",
                                       "a.svo --paged 1G",
                                       "a.svo --view full --cones 1",
                                       "scene.json --view ao --cones 1 -d 4",
                                       "a.svo --through probes --probes 2,2,2 --probe-resolution 64",
                                       "scene.json --through probes --view depth --probes 2,2,2 --probe-resolution 64"};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; ++i) {
        char line[512];
        snprintf(line, sizeof line,
                 "$SVOCL render %s -q --size 32x24 -o a.png --background transparent --samples 6 --from left", ways[i]);
        run_well(line);
        program_picture clear = read_picture("a.png");
        snprintf(line, sizeof line,
                 "$SVOCL render %s -q --size 32x24 -o a.png --background 9,90,200 --samples 6 --from left", ways[i]);
        run_well(line);
        program_picture blue = read_picture("a.png");
        size_t empty = 0;
        size_t partly = 0;
        for (size_t at = 0; at < 4 * 32 * 24; at += 4) {
            const uint8_t alpha = clear.rgba[at + 3];
            empty += alpha == 0;
            partly += alpha > 0 && alpha < 255;
            assert_int_equal(blue.rgba[at + 3], 255);
            assert_true(alpha > 0 || memcmp(blue.rgba + at, (const uint8_t[]){9, 90, 200}, 3) == 0);
            assert_true(alpha < 255 || memcmp(blue.rgba + at, clear.rgba + at, 3) == 0);
        }
        if (empty < 32 || partly < 16) {
            fail_msg("%s: of %d pixels %zu are empty, %zu partly covered", ways[i], 32 * 24, empty, partly);
        }
        free_picture(&clear);
        free_picture(&blue);
#ifdef SVOCL_EXR
        int width = 0;
        int height = 0;
        snprintf(line, sizeof line, "$SVOCL render %s -q --size 32x24 -o a.exr --from left", ways[i]);
        run_well(line);
        free(read_light("a.exr", &width, &height));
        assert_int_equal(width * height, 32 * 24);
        run_well("rm a.exr");
#endif
        run_well("rm a.png");
    }
    run_well("rm a.svo a.svc scene.json");
}

/* ---- sides ---- */

static void expect_side(const char *more, double x, double y, double z)
{
    char line[512];
    double away[3];
    snprintf(line, sizeof line, "$SVOCL render --json --size 24x16 -o a.png %s", more);
    cJSON *document = run_json(line);
    double length = 0;
    for (int axis = 0; axis < 3; ++axis) {
        away[axis] = cJSON_GetArrayItem(array_of(document, "eye"), axis)->valuedouble -
                     cJSON_GetArrayItem(array_of(document, "target"), axis)->valuedouble;
        length = hypot(length, away[axis]);
    }
    const double expected = (x * away[0] + y * away[1] + z * away[2]) / (length * sqrt(x * x + y * y + z * z));
    if (!(expected > 1 - 1e-5)) {
        fail_msg("%s: the eye is at %g, %g, %g of the target", line, away[0], away[1], away[2]);
    }
    cJSON_Delete(document);
}

static void sides_are_those_of_what_is_up(void **state)
{
    (void)state;
    need_builds();
    run_well(KNOT);
    write_text("scene.json", "{\"trees\": {\"k\": {\"path\": \"a.svo\"}}, \"instances\": [{\"tree\": \"k\"}],"
                             " \"camera\": {\"eye\": [0, 0, 50], \"target\": [0, 0, 0]}}");
    expect_side("a.svo --from front", 0, 0, 1);
    expect_side("a.svo --from left", -1, 0, 0);
    expect_side("a.svo --from right", 1, 0, 0);
    expect_side("a.svo --from back", 0, 0, -1);
    expect_side("a.svo --from top", 0, 1, 0);
    expect_side("a.svo --from bottom", 0, -1, 0);
    expect_side("a.svo --from iso", 1, 1, 1);
    expect_side("a.svo --from front --up 0,0,1", 0, -1, 0);
    expect_side("a.svo --from right --up 0,0,1", 1, 0, 0);
    expect_side("a.svo --from top --up 0,0,3", 0, 0, 1);
    expect_side("a.svo --from left --up 0,-1,0", 1, 0, 0);
    expect_side("a.svo --from left --paged 1G", -1, 0, 0);
    expect_side("scene.json --from back", 0, 0, -1);
    expect_side("scene.json", 0, 0, 1);
    run_badly("$SVOCL render a.svo -o a.png --from front --eye 1,2,3", 2, "--from frames all of INPUT, which --eye");
    run_badly("$SVOCL render a.svo -o a.png --from front --at 1,2,3", 2, "which --at does not");
    run_well("rm a.png a.svo scene.json");
}

/* ---- turntables and films ---- */

/* The border of each frame is empty: all of the input is in view from everywhere, and not from far away. */
static void expect_inside(const char *path)
{
    program_picture shown = read_picture(path);
    size_t covered = 0;
    for (int y = 0; y < shown.height; ++y) {
        for (int x = 0; x < shown.width; ++x) {
            const bool border = x == 0 || y == 0 || x == shown.width - 1 || y == shown.height - 1;
            covered += pixel_of(&shown, x, y)[3] > 0;
            if (border && pixel_of(&shown, x, y)[3] > 0) {
                fail_msg("%s: something is at %d, %d", path, x, y);
            }
        }
    }
    assert_true(10 * covered > (size_t)shown.width * (size_t)shown.height);
    free_picture(&shown);
}

static void expect_alike(const char *one, const char *other)
{
    program_picture first = read_picture(one);
    program_picture second = read_picture(other);
    double sum = 0;
    for (size_t i = 0; i < 4 * (size_t)first.width * (size_t)first.height; ++i) {
        sum += abs(first.rgba[i] - second.rgba[i]);
    }
    free_picture(&first);
    free_picture(&second);
    if (sum > 200) {
        fail_msg("%s and %s: %g", one, other, sum);
    }
}

static void turntables_go_round(void **state)
{
    (void)state;
    need_builds();
#define RENDER "$SVOCL render a.svo -q --size 40x32 --background transparent "
    run_well(KNOT);
    run_well(RENDER "--turntable 7 -o t.png && " RENDER "--turntable 7 -o u.png && cmp t-0007.png u-0007.png");
    static const char *const names[] = {"a.svo",      "t-0001.png", "t-0002.png", "t-0003.png",
                                        "t-0004.png", "t-0005.png", "t-0006.png", "t-0007.png"};
    run_well("rm u-*.png");
    expect_files(names, 8);
    for (size_t i = 1; i < 8; ++i) {
        expect_inside(names[i]);
    }
    run_well("! cmp -s t-0001.png t-0002.png && rm t-*.png");
    /* A camera that stands somewhere goes round what it looks at: halfway it is opposite. */
    run_well(RENDER "--turntable 4 -o t.png --eye 3,2.5,1 --at 0,0.5,0");
    run_well(RENDER "-o a.png --eye 3,2.5,1 --at 0,0.5,0 && cmp a.png t-0001.png");
    run_well(RENDER "-o a.png --eye=-3,2.5,-1 --at 0,0.5,0");
    expect_alike("a.png", "t-0003.png");
    run_well(RENDER "-o a.png --eye=1,2.5,-3 --at 0,0.5,0");
    expect_alike("a.png", "t-0002.png");
    run_well("rm a.png t-*.png");
    cJSON *document = run_json("$SVOCL render a.svo --json --turntable 2 --size 8x8 -o t.png");
    assert_int_equal((int)number_of(document, "frames"), 2);
    cJSON_Delete(document);
    run_well("$SVOCL render a.svo --turntable 2 --size 8x8 -o t.png");
    assert_non_null(strstr(last.output, "t.png: 2 frames of 8x8 pixels of a.svo"));
    run_well("rm a.svo t-*.png");
#undef RENDER
}

/* Limited range, ITU-R BT.601. */
static void expect_frame(const uint8_t *planes, const char *path)
{
    program_picture shown = read_picture(path);
    const size_t count = (size_t)shown.width * (size_t)shown.height;
    for (size_t i = 0; i < count; ++i) {
        const double luma = (planes[i] - 16) / 219.0;
        const double blue = (planes[count + i] - 128) / 224.0;
        const double red = (planes[2 * count + i] - 128) / 224.0;
        const double rgb[3] = {luma + 1.402 * red, luma - 0.344136 * blue - 0.714136 * red, luma + 1.772 * blue};
        for (int channel = 0; channel < 3; ++channel) {
            if (fabs(255 * rgb[channel] - shown.rgba[4 * i + (size_t)channel]) > 2.5) {
                fail_msg("%s: channel %d of pixel %zu is %g, %u in the PNG", path, channel, i, 255 * rgb[channel],
                         shown.rgba[4 * i + (size_t)channel]);
            }
        }
    }
    free_picture(&shown);
}

/* The frames of a film are those of the pictures. */
static void expect_film(const char *path, const char *head, const char *names, int first, int count)
{
    static uint8_t bytes[TEXT_BYTES];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t byte_count = fread(bytes, 1, sizeof bytes, file);
    (void)fclose(file);
    const size_t head_bytes = strlen(head);
    const size_t frame_bytes = 6 + 3 * 24 * 16;
    assert_int_equal(byte_count, head_bytes + (size_t)count * frame_bytes);
    assert_memory_equal(bytes, head, head_bytes);
    for (int i = 0; i < count; ++i) {
        char name[64];
        const uint8_t *frame = bytes + head_bytes + (size_t)i * frame_bytes;
        snprintf(name, sizeof name, names, first + i); // NOLINT: the names are this file's
        assert_memory_equal(frame, "FRAME\n", 6);
        expect_frame(frame + 6, name);
    }
}

static void films_have_the_frames_of_pictures(void **state)
{
    (void)state;
    need_builds();
#define TURN "$SVOCL render a.svo -q --size 24x16 --view normal --turntable 3 "
#define MOVE "$SVOCL render m.json -q --size 24x16 -d 5 --animate --frames 3 "
    run_well(KNOT);
    run_well(TURN "-o t.png && " TURN "-o t.y4m && " TURN "--format y4m -o - | cmp - t.y4m");
    expect_film("t.y4m", "YUV4MPEG2 W24 H16 F30:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n", "t-%04d.png", 1, 3);
    write_text("m.json", "{\"trees\": {\"k\": {\"path\": \"scene:knot:500\"}}, \"instances\": [{\"tree\": \"k\"},"
                         " {\"tree\": \"k\", \"motion\": [{\"time\": 0}, {\"time\": 1, \"translate\": [1, 0, 0]}]}]}");
    run_well(MOVE "-o m.png && " MOVE "--fps 24 -o m.y4m && " MOVE "--fps 24 --format y4m -o - | cmp - m.y4m");
    expect_film("m.y4m", "YUV4MPEG2 W24 H16 F24:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n", "m_%03d.png", 0, 3);
    run_badly(MOVE "-o - > a.bin", 2, "--animate writes several files, not to standard output; --format y4m is one");
    run_badly(MOVE "--turntable 3 -o a.png", 2, "--turntable and --animate exclude each other");
    /* A film that cannot be written leaves nothing, and an old one as it was. */
    run_badly(TURN "-o missing/t.y4m", 1, "missing/t.y4m");
    run_well("rm t.y4m t-*.png m.json m.y4m m_*.png a.svo a.bin");
#undef TURN
#undef MOVE
}

TEST_GROUP(picture_files)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(formats_hold_one_picture), IN_FOLDER(a_wrong_file_is_one_line),
        IN_FOLDER(every_picture_has_them),   IN_FOLDER(sides_are_those_of_what_is_up),
        IN_FOLDER(turntables_go_round),      IN_FOLDER(films_have_the_frames_of_pictures)};
    return cmocka_run_group_tests_name("picture_files", tests, NULL, NULL);
}
