/* SPDX-License-Identifier: MIT */
/* Bytes of pictures: PNG and Radiance HDR through stb, OpenEXR through its core library, PPM and YUV4MPEG2 here. */
#include "support/picture_files.h"

#include <stb/stb_image_write.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#ifdef SVOCL_EXR
#include <openexr.h>
#endif

static int fail_memory(program *state, const output_file *file)
{
    return program_fail(state, PROGRAM_FAILED, "%s: out of memory for the picture", output_name(file->path));
}

/* ---- stb ---- */

static void write_bytes(void *user, void *bytes, int byte_count)
{
    output_write(user, bytes, (size_t)byte_count);
}

static int write_png(program *state, output_file *file, const picture_pixels *pixels)
{
    return stbi_write_png_to_func(write_bytes, file, (int)pixels->width, (int)pixels->height, 4, pixels->bytes,
                                  (int)pixels->width * 4) != 0
               ? PROGRAM_DONE
               : fail_memory(state, file);
}

/* Shared exponents, which stb makes of the red, green and blue of each pixel. */
static int write_hdr(program *state, output_file *file, const picture_pixels *pixels)
{
    return stbi_write_hdr_to_func(write_bytes, file, (int)pixels->width, (int)pixels->height, 4, pixels->floats) != 0
               ? PROGRAM_DONE
               : fail_memory(state, file);
}

/* ---- OpenEXR ---- */

#ifdef SVOCL_EXR

#define EXR_CHANNELS 4

/* A file in memory: its head is written last. */
typedef struct exr_file {
    uint8_t *bytes;
    uint64_t byte_count, capacity;
} exr_file;

static int64_t keep_bytes(exr_const_context_t context, void *user, const void *bytes, uint64_t byte_count,
                          uint64_t offset, exr_stream_error_func_ptr_t fail)
{
    exr_file *file = user;
    const uint64_t end = offset + byte_count;
    if (end > file->capacity) {
        const uint64_t capacity = end + end / 2;
        uint8_t *grown = realloc(file->bytes, capacity);
        if (grown == NULL) {
            (void)fail(context, EXR_ERR_OUT_OF_MEMORY, "out of memory");
            return -1;
        }
        memset(grown + file->capacity, 0, capacity - file->capacity);
        file->bytes = grown;
        file->capacity = capacity;
    }
    memcpy(file->bytes + offset, bytes, byte_count);
    file->byte_count = end > file->byte_count ? end : file->byte_count;
    return (int64_t)byte_count;
}

/* The caller says what failed. */
static void say_nothing(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)context;
    (void)code;
    (void)message;
}

static bool write_exr_head(exr_context_t exr, const picture_pixels *pixels)
{
    static const char *const names[EXR_CHANNELS] = {"R", "G", "B", "A"};
    int part = 0;
    bool good = exr_add_part(exr, "picture", EXR_STORAGE_SCANLINE, &part) == EXR_ERR_SUCCESS &&
                exr_initialize_required_attr_simple(exr, part, (int32_t)pixels->width, (int32_t)pixels->height,
                                                    EXR_COMPRESSION_ZIP) == EXR_ERR_SUCCESS;
    for (int channel = 0; channel < (pixels->has_alpha ? 4 : 3) && good; ++channel) {
        good = exr_add_channel(exr, part, names[channel], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1) ==
               EXR_ERR_SUCCESS;
    }
    return good && exr_write_header(exr) == EXR_ERR_SUCCESS;
}

/* Where the encoder finds a chunk's rows: channels go by their names, in their alphabetical order. */
static void place_channels(const picture_pixels *pixels, int32_t row, exr_encode_pipeline_t *encoder)
{
    for (int channel = 0; channel < encoder->channel_count; ++channel) {
        exr_coding_channel_info_t *to = &encoder->channels[channel];
        const size_t place = (size_t)(strchr("RGBA", to->channel_name[0]) - "RGBA");
        const float *from = pixels->floats + EXR_CHANNELS * (size_t)pixels->width * (size_t)row + place;
        to->user_bytes_per_element = sizeof *from;
        to->user_data_type = EXR_PIXEL_FLOAT;
        to->user_pixel_stride = EXR_CHANNELS * (int32_t)sizeof *from;
        to->user_line_stride = (int32_t)pixels->width * to->user_pixel_stride;
        to->encode_from_ptr = (const uint8_t *)from;
    }
}

static bool write_exr_chunks(exr_context_t exr, const picture_pixels *pixels)
{
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t rows = 0;
    bool good = exr_get_scanlines_per_chunk(exr, 0, &rows) == EXR_ERR_SUCCESS;
    for (int32_t row = 0; row < (int32_t)pixels->height && good; row += rows) {
        exr_chunk_info_t chunk;
        good = exr_write_scanline_chunk_info(exr, 0, row, &chunk) == EXR_ERR_SUCCESS &&
               (row == 0 ? exr_encoding_initialize(exr, 0, &chunk, &encoder)
                         : exr_encoding_update(exr, 0, &chunk, &encoder)) == EXR_ERR_SUCCESS;
        if (good) {
            place_channels(pixels, row, &encoder);
        }
        good = good && (row > 0 || exr_encoding_choose_default_routines(exr, 0, &encoder) == EXR_ERR_SUCCESS) &&
               exr_encoding_run(exr, 0, &encoder) == EXR_ERR_SUCCESS;
    }
    (void)exr_encoding_destroy(exr, &encoder);
    return good;
}

static int write_exr(program *state, output_file *file, const picture_pixels *pixels)
{
    exr_file kept = {.bytes = NULL};
    exr_context_t exr = NULL;
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.user_data = &kept;
    how.write_fn = keep_bytes;
    how.error_handler_fn = say_nothing;
    bool good = exr_start_write(&exr, "picture", EXR_WRITE_FILE_DIRECTLY, &how) == EXR_ERR_SUCCESS &&
                write_exr_head(exr, pixels) && write_exr_chunks(exr, pixels);
    good = (exr == NULL || exr_finish(&exr) == EXR_ERR_SUCCESS) && good;
    if (good) {
        output_write(file, kept.bytes, kept.byte_count);
    }
    free(kept.bytes);
    return good ? PROGRAM_DONE
                : program_fail(state, PROGRAM_FAILED, "%s: OpenEXR could not write the picture, or is out of memory",
                               output_name(file->path));
}

#else

static int write_exr(program *state, output_file *file, const picture_pixels *pixels)
{
    (void)pixels;
    return picture_format_check(state, &(picture_format){.value = OPTION_FORMAT_EXR}, file->path);
}

#endif

/* ---- PPM ---- */

static int write_ppm(program *state, output_file *file, const picture_pixels *pixels)
{
    char head[64];
    uint8_t *row = malloc(3 * (size_t)pixels->width);
    if (row == NULL) {
        return fail_memory(state, file);
    }
    output_write(file, head,
                 (size_t)snprintf(head, sizeof head, "P6\n%lu %lu\n255\n", (unsigned long)pixels->width,
                                  (unsigned long)pixels->height));
    for (uint32_t y = 0; y < pixels->height; ++y) {
        for (uint32_t x = 0; x < pixels->width; ++x) {
            memcpy(row + 3 * (size_t)x, pixels->bytes + 4 * ((size_t)y * pixels->width + x), 3);
        }
        output_write(file, row, 3 * (size_t)pixels->width);
    }
    free(row);
    return PROGRAM_DONE;
}

/* ---- YUV4MPEG2 ---- */

/* Rows of the matrix of ITU-R BT.601 for bytes of limited range, 2^16 = 1, and what is added. */
typedef struct film_plane {
    int32_t red, green, blue, offset;
} film_plane;

void picture_film_begin(output_file *file, uint32_t width, uint32_t height, unsigned frames_per_second)
{
    char head[128];
    output_write(file, head,
                 (size_t)snprintf(head, sizeof head, "YUV4MPEG2 W%lu H%lu F%u:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n",
                                  (unsigned long)width, (unsigned long)height, frames_per_second));
}

static int write_frame(program *state, output_file *file, const picture_pixels *pixels)
{
    static const film_plane planes[3] = {
        {16829, 33039, 6416, 16}, {-9714, -19070, 28784, 128}, {28784, -24103, -4681, 128}};
    const size_t count = (size_t)pixels->width * pixels->height;
    uint8_t *plane = malloc(count);
    if (plane == NULL) {
        return fail_memory(state, file);
    }
    output_write(file, "FRAME\n", 6);
    for (int k = 0; k < 3; ++k) {
        const film_plane *to = &planes[k];
        for (size_t i = 0; i < count; ++i) {
            const uint8_t *from = pixels->bytes + 4 * i;
            const int32_t sum = to->red * from[0] + to->green * from[1] + to->blue * from[2];
            plane[i] = (uint8_t)((sum + to->offset * 65536 + 32768) / 65536);
        }
        output_write(file, plane, count);
    }
    free(plane);
    return PROGRAM_DONE;
}

/* ---- the table ---- */

static const picture_format formats[] = {
    {.suffix = ".png", .value = OPTION_FORMAT_PNG, .has_alpha = true, .write = write_png},
    {.suffix = ".exr",
     .value = OPTION_FORMAT_EXR,
     .is_linear = true,
     .has_alpha = true,
     .has_negative = true,
     .write = write_exr},
    {.suffix = ".hdr", .value = OPTION_FORMAT_HDR, .is_linear = true, .write = write_hdr},
    {.suffix = ".ppm", .value = OPTION_FORMAT_PPM, .write = write_ppm},
    {.suffix = ".y4m", .value = OPTION_FORMAT_Y4M, .is_film = true, .write = write_frame},
};

#define FORMATS (sizeof formats / sizeof formats[0])

const char *picture_format_suffixes(void)
{
    return ".png, .exr, .hdr, .ppm, .y4m";
}

static const picture_format *format_of_suffix(const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash != NULL ? slash + 1 : path;
    const char *suffix = name[0] != '\0' ? strrchr(name + 1, '.') : NULL; /* a leading dot hides a file */
    for (size_t i = 0; i < FORMATS && suffix != NULL; ++i) {
        if (strcasecmp(formats[i].suffix, suffix) == 0) {
            return &formats[i];
        }
    }
    return suffix != NULL ? NULL : &formats[0];
}

const picture_format *picture_format_of(const options *given)
{
    if (given->format == OPTION_FORMAT_BY_NAME) {
        return format_of_suffix(given->output_path);
    }
    size_t i = 0;
    while (formats[i].value != given->format) {
        ++i;
    }
    return &formats[i];
}

int picture_format_check(program *state, const picture_format *format, const char *path)
{
#ifdef SVOCL_EXR
    (void)state;
    (void)format;
    (void)path;
    return PROGRAM_DONE;
#else
    return format->value != OPTION_FORMAT_EXR
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_FAILED, "-o %s: this program was built without OpenEXR (libopenexr-dev)",
                              path);
#endif
}
