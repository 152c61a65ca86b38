/* SPDX-License-Identifier: MIT */
/* The part of svocl bench compact on packed payload: bits, errors, reads of elements, pictures. */
#include "bench/compact_packed.h"

#include <stdlib.h>

#include <zstd.h>

#include "measure/spread.h"
#include "svocl/compact.h"

static const char packed_id[] = "compact-packed";

#define ZSTD_LEVEL     19
#define READS          (1u << 20)
#define PICTURE_WIDTH  640u
#define PICTURE_HEIGHT 400u

/* The first of each array is exact. */
static const struct packing {
    svo_compact_buffer buffer;
    svo_need need;
    const char *change;
    uint32_t color_error, normal_bits;
} packings[] = {
    {SVO_COMPACT_COLORS, SVO_NEED_COLOR, "none", 0, 0},     {SVO_COMPACT_COLORS, SVO_NEED_COLOR, "within 4", 4, 0},
    {SVO_COMPACT_COLORS, SVO_NEED_COLOR, "within 8", 8, 0}, {SVO_COMPACT_NORMALS, SVO_NEED_NORMAL, "none", 0, 0},
    {SVO_COMPACT_NORMALS, SVO_NEED_NORMAL, "7 bits", 0, 7},
};
#define PACKING_COUNT (sizeof packings / sizeof packings[0])

static const char packed_note[] =
    "Form shared, to depth 9. Bits are per leaf, those of inner nodes included. Change: most that colors may change, "
    "or the bits of each of two numbers of a normal. zstd: of the plain array, which gives no element before all of "
    "them. Errors: of 255 for colors, of 32767 for normals. Read: elements at random places, one call of "
    "svo_compact_read_payload each. Picture: 640 x 400 pixels with this array alone packed. Times are of all "
    "processors together; ratios are rates relative to the plain array's within each round.";

enum { PLAIN, PACKED, KIND_COUNT };

/* An array, plain and packed. */
typedef struct packed_bench {
    suite *all;
    const input *source;
    const svo_tree *tree;
    svo_compact *made[KIND_COUNT];
    svo_compact_info info[KIND_COUNT];
    double packing_ms;
    size_t zstd_bytes; /* of the plain array */
    uint8_t *pixels;
    double *read_ms[KIND_COUNT], *picture_ms[KIND_COUNT]; /* by round */
    double *scratch; /* by round */
} packed_bench;

void compact_packed_begin(suite *all)
{
    result_table *table = suite_add_table(all, packed_id, "Packed payload: bits per leaf", packed_note);
    result_add_column(table, "scene", "");
    result_add_column(table, "depth", "");
    result_add_column(table, "leaves", "");
    result_add_column(table, "array", "");
    result_add_column(table, "change", "");
    result_add_column(table, "plain", "bit");
    result_add_column(table, "zstd -19", "bit");
    result_add_column(table, "packed", "bit");
    result_add_column(table, "largest error", "");
    result_add_column(table, "mean error", "");
    result_add_column(table, "packing", "ms");
    result_add_column(table, "read", "M/s");
    spread_add_columns(table, "read ratio", "");
    result_add_column(table, "picture", "ms");
    spread_add_columns(table, "picture ratio", "");
}

/* To the host, with what describes it. */
static svo_status fetch(packed_bench *b, int kind)
{
    b->info[kind] = (svo_compact_info)SVO_COMPACT_INFO_INIT;
    svo_status status = svo_compact_download(b->made[kind], b->all->opened.queue);
    if (status == SVO_OK) {
        status = svo_compact_get_info(b->made[kind], &b->info[kind]);
    }
    return status;
}

static svo_status make_plain(packed_bench *b)
{
    const session *opened = &b->all->opened;
    svo_compact_options asked = SVO_COMPACT_OPTIONS_INIT;
    asked.form = SVO_FORM_SHARED;
    svo_status status = svo_compact_create(opened->device, b->tree, &asked, opened->queue, &b->made[PLAIN]);
    if (status == SVO_OK) {
        status = fetch(b, PLAIN);
    }
    return status;
}

static svo_status pack(packed_bench *b, const struct packing *how)
{
    const svo_pack_options asked = {.struct_size = sizeof asked,
                                    .leave_out = (uint32_t)SVO_NEED_ALL & ~(uint32_t)how->need,
                                    .color_error = how->color_error,
                                    .normal_bits = how->normal_bits};
    svo_compact_destroy(&b->made[PACKED]);
    const double start_ms = input_cpu_ms();
    svo_status status = svo_compact_pack(b->made[PLAIN], &asked, b->all->opened.queue, &b->made[PACKED]);
    b->packing_ms = input_cpu_ms() - start_ms;
    if (status == SVO_OK) {
        status = fetch(b, PACKED);
    }
    return status;
}

/* False: memory runs out. */
static bool press(packed_bench *b, svo_compact_buffer buffer)
{
    svo_compact_arrays arrays = SVO_COMPACT_ARRAYS_INIT;
    (void)svo_compact_get_arrays(b->made[PLAIN], &arrays);
    const void *array = buffer == SVO_COMPACT_COLORS ? (const void *)arrays.colors : (const void *)arrays.normals;
    const size_t bytes = (size_t)b->info[PLAIN].bytes[buffer];
    const size_t room = ZSTD_compressBound(bytes);
    void *pressed = malloc(room);
    b->zstd_bytes = pressed != NULL ? ZSTD_compress(pressed, room, array, bytes, ZSTD_LEVEL) : 0;
    free(pressed);
    return pressed != NULL && ZSTD_isError(b->zstd_bytes) == 0;
}

/* Below 0 on failure. */
static double read_elements(const packed_bench *b, int kind, svo_compact_buffer buffer)
{
    const uint64_t count = b->info[kind].payload_count;
    uint64_t random = 1;
    int16_t element[4];
    bool worked = true;
    const double start_ms = input_cpu_ms();
    for (uint32_t i = 0; i < READS; ++i) {
        random = random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407); /* Knuth's MMIX */
        const uint64_t place = (random >> 32) * count >> 32;
        worked = svo_compact_read_payload(b->made[kind], buffer, place, 1, element) == SVO_OK && worked;
    }
    return worked ? input_cpu_ms() - start_ms : -1.0;
}

static double draw(const packed_bench *b, int kind, const svo_camera *camera)
{
    svo_render_options asked = SVO_RENDER_OPTIONS_INIT;
    asked.width = PICTURE_WIDTH;
    asked.height = PICTURE_HEIGHT;
    asked.camera = *camera;
    const double start_ms = input_cpu_ms();
    const svo_status status = svo_render(svo_compact_target(b->made[kind]), &asked, svo_in_host(b->pixels), NULL);
    return status == SVO_OK ? input_cpu_ms() - start_ms : -1.0;
}

/* The first round warms up and does not count. */
static bool compare(const packed_bench *b, svo_compact_buffer buffer)
{
    svo_camera camera = {.vertical_fov = 0};
    bool worked =
        svo_camera_fit(svo_compact_target(b->made[PLAIN]), (float)PICTURE_WIDTH / PICTURE_HEIGHT, &camera) == SVO_OK;
    for (size_t round = 0; round <= b->all->repeats && worked; ++round) {
        for (int kind = PLAIN; kind < KIND_COUNT && worked; ++kind) {
            const size_t at = round > 0 ? round - 1 : 0;
            b->read_ms[kind][at] = read_elements(b, kind, buffer);
            b->picture_ms[kind][at] = draw(b, kind, &camera);
            worked = b->read_ms[kind][at] >= 0 && b->picture_ms[kind][at] >= 0;
        }
    }
    return worked;
}

static double median(const packed_bench *b, const double *times)
{
    return spread_median(times, b->all->repeats, b->scratch);
}

static void add_ratio(result_table *table, const packed_bench *b, const double *other, const double *times)
{
    spread_add_ratio(table, other, times, b->all->repeats, b->scratch);
}

static void add_packed_row(const packed_bench *b, const struct packing *how)
{
    result_table *table = result_find(b->all->results, packed_id);
    const size_t k = (size_t)how->buffer - SVO_COMPACT_COLORS;
    const double leaves = (double)b->info[PLAIN].leaf_count;
    result_add_text(table, "%s", suite_scene_name(b->source));
    result_add_number(table, b->info[PLAIN].depth);
    result_add_number(table, leaves);
    result_add_text(table, "%s", svo_name(SVO_NAME_COMPACT_BUFFER, how->buffer));
    result_add_text(table, "%s", how->change);
    result_add_number(table, 8.0 * (double)b->info[PLAIN].bytes[how->buffer] / leaves);
    result_add_number(table, 8.0 * (double)b->zstd_bytes / leaves);
    result_add_number(table, 8.0 * (double)b->info[PACKED].bytes[how->buffer] / leaves);
    result_add_number(table, b->info[PACKED].largest_error[k]);
    result_add_number(table, b->info[PACKED].mean_error[k]);
    result_add_number(table, b->packing_ms);
    result_add_number(table, READS / median(b, b->read_ms[PACKED]) * 1e-3);
    add_ratio(table, b, b->read_ms[PLAIN], b->read_ms[PACKED]);
    result_add_number(table, median(b, b->picture_ms[PACKED]));
    add_ratio(table, b, b->picture_ms[PLAIN], b->picture_ms[PACKED]);
}

static bool packed_allocate(packed_bench *b)
{
    bool worked = true;
    b->pixels = malloc((size_t)4 * PICTURE_WIDTH * PICTURE_HEIGHT);
    b->scratch = calloc(b->all->repeats + 1, sizeof(double));
    for (int kind = PLAIN; kind < KIND_COUNT; ++kind) {
        b->read_ms[kind] = calloc(b->all->repeats + 1, sizeof(double));
        b->picture_ms[kind] = calloc(b->all->repeats + 1, sizeof(double));
        worked = worked && b->read_ms[kind] != NULL && b->picture_ms[kind] != NULL;
    }
    return worked && b->pixels != NULL && b->scratch != NULL;
}

static void packed_release(packed_bench *b)
{
    for (int kind = PLAIN; kind < KIND_COUNT; ++kind) {
        svo_compact_destroy(&b->made[kind]);
        free(b->read_ms[kind]);
        free(b->picture_ms[kind]);
    }
    free(b->pixels);
    free(b->scratch);
}

static int fail_library(const packed_bench *b)
{
    return program_fail_library(b->all->state, svo_device_message(b->all->opened.device));
}

/* Whether the tree has the array, not the same in all nodes. */
static bool is_packable(const packed_bench *b, const struct packing *how)
{
    return (b->info[PLAIN].need & (uint32_t)how->need) != 0 && (b->info[PLAIN].constant & (uint32_t)how->need) == 0;
}

static int run_packings(packed_bench *b)
{
    program *state = b->all->state;
    if (!packed_allocate(b)) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    if (make_plain(b) != SVO_OK) {
        return fail_library(b);
    }
    for (size_t i = 0; i < PACKING_COUNT; ++i) {
        const struct packing *how = &packings[i];
        if (!is_packable(b, how)) {
            continue;
        }
        if (how->color_error == 0 && how->normal_bits == 0 && !press(b, how->buffer)) {
            return program_fail(state, PROGRAM_FAILED, "zstd failed, out of memory");
        }
        if (pack(b, how) != SVO_OK || !compare(b, how->buffer)) {
            return fail_library(b);
        }
        add_packed_row(b, how);
    }
    return PROGRAM_DONE;
}

int compact_packed_run(suite *all, const input *source, const svo_tree *tree)
{
    packed_bench packed = {.all = all, .source = source, .tree = tree};
    const int exit_code = run_packings(&packed);
    packed_release(&packed);
    return exit_code;
}
