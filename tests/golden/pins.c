/* SPDX-License-Identifier: MIT */
/*
 * golden_pins [--write | --first] [ROOM...]: compares what rooms make with their tables, or writes the tables. Without
 * rooms: all of them. --first: ends a room with its first difference, without making the rest.
 */
#define _POSIX_C_SOURCE 200809L
#include "pins.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "scenes.h"
#include "support/info_of.h"
#include "support/work_folder.h"

#define PATH_BYTES 512

typedef struct room {
    const char *name;
    void (*collect)(pins *all);
} room;

static room rooms[] = {
    {"plan", pin_plan},       {"stages", pin_stages}, {"pipeline", pin_pipeline}, {"rays", pin_rays},
    {"compact", pin_compact}, {"solid", pin_solid},   {"scene", pin_scene},       {"light", pin_light},
    {"probes", pin_probes},   {"moving", pin_moving}, {"voxels", pin_voxels},     {"io", pin_io},
    {"parts", pin_parts},     {"paged", pin_paged},
};
#define ROOM_COUNT (sizeof rooms / sizeof rooms[0])

/* Of the whole run. */
static pins shared;
static bool is_writing, is_hasty;

/* ---- tables ---- */

static const char *table_path(const char *name)
{
    static char path[PATH_BYTES];
    const int length = snprintf(path, sizeof path, "%s/%s.tsv", SVOCL_GOLDEN_FOLDER, name);
    assert_true(length > 0 && (size_t)length < sizeof path);
    return path;
}

/* Whether a line of a table is a value that is compared here. */
static bool is_compared(const pins *all, const char *line)
{
    return line[0] != '#' && (all->is_pocl || strncmp(line, "PoCL", 4) != 0);
}

/* Cuts a line at its tab, and returns the value. */
static char *cut_line(char *line)
{
    char *value = strchr(line, '\t');
    if (value == NULL) {
        fail_msg("a line without a value: %s", line);
        return line;
    }
    *value++ = '\0';
    value[strcspn(value, "\n")] = '\0';
    return value;
}

static void tell(const char *name, const char *pinned, const char *made)
{
    print_error("%s\n  pinned  %s\n  made    %s\n", name, pinned, made);
}

static FILE *open_table(const char *name)
{
    FILE *file = fopen(table_path(name), "r");
    if (file == NULL) {
        fail_msg("%s cannot be read", table_path(name));
    }
    return file;
}

/* The pins so far, of which the newest is compared with the table at once. */
static void compare_newest(const pins *all)
{
    char line[PIN_LINE_BYTES];
    const pin *made = &all->list[all->count - 1];
    FILE *file = open_table(all->room);
    bool is_same = false;
    while (!is_same && fgets(line, sizeof line, file) != NULL) {
        const char *value = line[0] != '#' ? cut_line(line) : "";
        if (strcmp(line, made->name) == 0) {
            is_same = strcmp(value, made->value) == 0;
            if (!is_same) {
                tell(line, value, made->value);
                break;
            }
        }
    }
    (void)fclose(file);
    if (!is_same) {
        fail_msg("%s differs from tests/golden/%s.tsv", made->name, all->room);
    }
}

/* ---- values ---- */

static void settle(const pins *all)
{
    if (is_hasty) {
        compare_newest(all);
    }
}

void pin_begin(pins *all, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(all->prefix, sizeof all->prefix, format, arguments);
    va_end(arguments);
    assert_true(length >= 0 && (size_t)length < sizeof all->prefix);
}

/* A new pin with its name. */
static pin *add(pins *all, const char *name)
{
    if (all->count == all->capacity) {
        all->capacity = all->capacity > 0 ? 2 * all->capacity : 64;
        all->list = realloc(all->list, all->capacity * sizeof *all->list);
        assert_non_null(all->list);
    }
    pin *made = &all->list[all->count++];
    const int length =
        snprintf(made->name, sizeof made->name, "%s%s%s", all->prefix, all->prefix[0] != '\0' ? ": " : "", name);
    assert_true(length > 0 && (size_t)length < sizeof made->name);
    for (size_t i = 0; i + 1 < all->count; ++i) {
        if (strcmp(all->list[i].name, made->name) == 0) {
            fail_msg("two values are named '%s'", made->name);
        }
    }
    return made;
}

void pin_text(pins *all, const char *name, const char *format, ...)
{
    pin *made = add(all, name);
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(made->value, sizeof made->value, format, arguments);
    va_end(arguments);
    if (length < 0 || (size_t)length >= sizeof made->value || strpbrk(made->value, "\t\n") != NULL) {
        fail_msg("%s: '%s' does not fit a line", made->name, made->value);
    }
    settle(all);
}

static void set_hash(pin *made, XXH128_hash_t hash)
{
    (void)snprintf(made->value, sizeof made->value, "%016" PRIx64 "%016" PRIx64, (uint64_t)hash.high64,
                   (uint64_t)hash.low64);
}

void pin_digest(pins *all, const char *name, const void *bytes, size_t byte_count)
{
    set_hash(add(all, name), XXH3_128bits(bytes, byte_count));
    settle(all);
}

void pin_file(pins *all, const char *name, const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) {
        fail_msg("%s: %s cannot be read", name, path);
        return;
    }
    const size_t byte_count = (size_t)ftell(file);
    unsigned char *bytes = malloc(byte_count + 1);
    rewind(file);
    assert_true(bytes != NULL && fread(bytes, 1, byte_count, file) == byte_count);
    (void)fclose(file);
    pin_digest(all, name, bytes, byte_count);
    free(bytes);
}

void pin_mean(pins *all, const char *name, const float *first, size_t count, size_t stride_bytes)
{
    double sum = 0;
    size_t odd = 0;
    for (size_t i = 0; i < count; ++i) {
        float number;
        memcpy(&number, (const char *)first + i * stride_bytes, sizeof number);
        odd += isfinite(number) ? 0 : 1;
        sum += isfinite(number) ? (double)number : 0;
    }
    pin_text(all, name, "%.4g, %zu not finite", count > odd ? sum / (double)(count - odd) : 0.0, odd);
}

void pin_tree(pins *all, const char *name, svo_tree *tree)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    char hash[SVO_HASH_TEXT_BYTES];
    pin_succeed(all, svo_tree_download(tree, all->opened.queue));
    pin_succeed(all, svo_tree_hash(tree, SVO_HASH_ALL, hash));
    pin_succeed(all, svo_tree_get_info(tree, &info));
    pin_text(all, name,
             "%s need %x constant %x weights %u nodes %" PRIu64 " leaves %" PRIu64 " lists %" PRIu64
             " fragments %" PRIu64,
             hash, (unsigned)info.need, (unsigned)info.constant, (unsigned)info.weights, info.node_count,
             info.leaf_count, info.list_count, info.fragments);
}

void pin_buffer(pins *all, const char *name, cl_mem buffer)
{
    size_t byte_count = 0;
    if (buffer == NULL) {
        pin_text(all, name, "none");
        return;
    }
    assert_int_equal(clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof byte_count, &byte_count, NULL), CL_SUCCESS);
    void *bytes = malloc(byte_count);
    assert_non_null(bytes);
    assert_int_equal(clEnqueueReadBuffer(all->opened.queue, buffer, CL_TRUE, 0, byte_count, bytes, 0, NULL, NULL),
                     CL_SUCCESS);
    pin_digest(all, name, bytes, byte_count);
    free(bytes);
}

/* ---- what rooms share ---- */

void pin_succeed(const pins *all, svo_status status)
{
    if (status != SVO_OK) {
        fail_msg("%s%s%s: %s", all->prefix, all->prefix[0] != '\0' ? ": " : "", svo_name(SVO_NAME_STATUS, status),
                 svo_device_message(all->opened.device));
    }
}

svo_tree *pin_build(const pins *all, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options)
{
    svo_plan_options sized = options != NULL ? *options : (svo_plan_options){.need = SVO_NEED_DEFAULT};
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    sized.struct_size = sizeof sized;
    pin_succeed(all, svo_plan_create(all->opened.device, mesh, depth, &sized, &plan));
    pin_succeed(all, svo_build(plan, all->opened.frontend, all->opened.queue, &tree, NULL));
    pin_succeed(all, svo_tree_download(tree, all->opened.queue));
    svo_plan_destroy(&plan);
    return tree;
}

/* By a 64-bit linear congruential generator (Knuth, MMIX). */
float pin_random(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (float)(*state >> 40) * 0x1p-24F;
}

void pin_make_rays(const svo_tree *tree, uint64_t seed, svo_ray *rays, size_t count)
{
    svo_tree_info info = SVO_TREE_INFO_INIT;
    uint64_t state = seed;
    assert_int_equal(svo_tree_get_info(tree, &info), SVO_OK);
    for (size_t i = 0; i < count; ++i) {
        for (size_t axis = 0; axis < 3; ++axis) {
            const double outside = axis == i % 3 ? 2 : 0;
            const double from = info.origin[axis] + info.edge * ((double)pin_random(&state) + outside);
            const double to = info.origin[axis] + info.edge * (double)pin_random(&state);
            rays[i].origin[axis] = (float)from;
            rays[i].direction[axis] = (float)(to - from);
        }
        rays[i].t_min = 0;
        rays[i].t_max = i % 16 == 15 ? 0.9F : INFINITY;
    }
}

/* Closed with colors and normals; with materials and holes; random with everything, in doubles and partly outside. */
static void make_scenes(pins *all)
{
    all->scenes[0] = (pinned_scene){.name = "knot", .made = fixture_scene("knot:400")};
    all->scenes[1] = (pinned_scene){.name = "cornell", .made = fixture_scene("cornell:200")};
    all->scenes[2] = (pinned_scene){.name = "random"};
    all->scenes[0].mesh = scene_mesh(all->scenes[0].made);
    all->scenes[1].mesh = scene_mesh(all->scenes[1].made);
    attributed_mesh_create(11, 150, 0, &all->scenes[2].random);
    all->scenes[2].mesh = &all->scenes[2].random.mesh;
}

static void release_scenes(pins *all)
{
    scene_destroy(&all->scenes[0].made);
    scene_destroy(&all->scenes[1].made);
    attributed_mesh_destroy(&all->scenes[2].random);
}

/* ---- whole tables ---- */

static void write_table(const pins *all, const char *name)
{
    if (!all->is_pocl) {
        fail_msg("tables are written on PoCL, which has all of the values");
    }
    FILE *file = fopen(table_path(name), "w");
    if (file == NULL) {
        fail_msg("%s cannot be written", table_path(name));
        return;
    }
    (void)fprintf(file, "# What lib/%s makes of three small scenes; written by golden_pins --write %s\n", name, name);
    for (size_t i = 0; i < all->count; ++i) {
        (void)fprintf(file, "%s\t%s\n", all->list[i].name, all->list[i].value);
    }
    if (fclose(file) != 0) {
        fail_msg("%s cannot be written", table_path(name));
    }
}

static const pin *find(const pins *all, const char *name)
{
    for (size_t i = 0; i < all->count; ++i) {
        if (strcmp(all->list[i].name, name) == 0) {
            return &all->list[i];
        }
    }
    return NULL;
}

static void compare_table(const pins *all, const char *name)
{
    char line[PIN_LINE_BYTES];
    size_t compared = 0;
    size_t differences = 0;
    size_t skipped = 0;
    FILE *file = open_table(name);
    while (fgets(line, sizeof line, file) != NULL) {
        if (!is_compared(all, line)) {
            skipped += line[0] != '#' ? 1 : 0;
            continue;
        }
        const char *value = cut_line(line);
        const pin *made = find(all, line);
        ++compared;
        if (made == NULL || strcmp(made->value, value) != 0) {
            tell(line, value, made != NULL ? made->value : "nothing");
            ++differences;
        }
    }
    (void)fclose(file);
    if (skipped > 0) {
        print_message("skipped: %zu values of %s, which are pinned for PoCL alone\n", skipped, name);
    }
    if (compared != all->count) {
        print_error("%s: %zu values are pinned, %zu are made\n", table_path(name), compared, all->count);
        ++differences;
    }
    if (differences > 0) {
        fail_msg("%zu values of %s differ from tests/golden/%s.tsv", differences, name, name);
    }
}

/* ---- the run ---- */

static void check_room(void **state)
{
    const room *asked = *state;
    shared.count = 0;
    shared.room = asked->name;
    shared.prefix[0] = '\0';
    if (shared.opened.device == NULL) {
        fixture_open_cl(&(fixture_options){.path = SVO_PATH_AUTO}, &shared.opened);
        char version[256] = "";
        (void)clGetDeviceInfo(info_of_device(shared.opened.device).device, CL_DEVICE_VERSION, sizeof version, version,
                              NULL);
        shared.is_pocl = strstr(version, "PoCL") != NULL || strstr(version, "pocl") != NULL;
        make_scenes(&shared);
    }
    asked->collect(&shared);
    if (is_writing) {
        write_table(&shared, asked->name);
    } else {
        compare_table(&shared, asked->name);
    }
}

static int release_all(void **state)
{
    if (shared.opened.device != NULL) {
        release_scenes(&shared);
    }
    fixture_close(&shared.opened);
    free(shared.list);
    return work_folder_remove(state);
}

int main(int argc, char **argv)
{
    struct CMUnitTest tests[ROOM_COUNT];
    size_t test_count = 0;
    int first = 1;
    is_writing = argc > 1 && strcmp(argv[1], "--write") == 0;
    is_hasty = argc > 1 && strcmp(argv[1], "--first") == 0;
    first += is_writing || is_hasty ? 1 : 0;
    for (size_t r = 0; r < ROOM_COUNT; ++r) {
        bool is_asked = argc == first;
        for (int i = first; i < argc; ++i) {
            is_asked = is_asked || strcmp(argv[i], rooms[r].name) == 0;
        }
        if (is_asked) {
            tests[test_count++] =
                (struct CMUnitTest){.name = rooms[r].name, .test_func = check_room, .initial_state = &rooms[r]};
        }
    }
    if (test_count < (size_t)(argc - first)) {
        (void)fprintf(stderr, "golden_pins: a room is not known\n");
        return EXIT_FAILURE;
    }
    if (is_writing || is_hasty) { /* No value depends on how kernels are compiled, and this is quicker. */
        (void)setenv("POCL_EXTRA_BUILD_FLAGS", "-cl-opt-disable", 0);
    }
    return _cmocka_run_group_tests("golden_pins", tests, test_count, work_folder_make, release_all);
}
