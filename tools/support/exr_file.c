/* SPDX-License-Identifier: MIT */
#include "support/exr_file.h"

#include <stdlib.h>
#include <string.h>

#ifdef SVOCL_EXR

#include <openexr.h>

#define CHANNELS 3

typedef struct exr_reader {
    exr_context_t file;
    exr_decode_pipeline_t decoder;
    bool is_decoding;
    exr_attr_box2i_t window;
    int32_t rows_at_once;
    const char *names; /* of the channels that are read */
    hdr_picture *out;
} exr_reader;

static bool fail(const exr_reader *from, const char *words)
{
    (void)snprintf(from->out->words, HDR_WORDS_BYTES, "%.*s", HDR_WORDS_BYTES - 1, words);
    return false;
}

static bool check(const exr_reader *from, exr_result_t result)
{
    return result == EXR_ERR_SUCCESS || fail(from, exr_get_default_error_message(result));
}

/* The words are kept, not printed. */
static void ignore_error(exr_const_context_t context, exr_result_t result, const char *words)
{
    (void)context;
    (void)result;
    (void)words;
}

/* Red, green and blue, or luminance, of floats, each as wide and high as the picture. */
static bool find_channels(exr_reader *from)
{
    const exr_attr_chlist_t *list = NULL;
    int colors = 0;
    int luminances = 0;
    if (!check(from, exr_get_channels(from->file, 0, &list))) {
        return false;
    }
    for (int i = 0; i < list->num_channels; ++i) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        const bool is_whole = entry->x_sampling == 1 && entry->y_sampling == 1 && entry->pixel_type != EXR_PIXEL_UINT;
        const bool is_one = entry->name.length == 1 && is_whole;
        colors += is_one && strchr("RGB", entry->name.str[0]) != NULL ? 1 : 0;
        luminances += is_one && entry->name.str[0] == 'Y' ? 1 : 0;
    }
    from->names = colors == CHANNELS ? "RGB" : "Y";
    return colors == CHANNELS || luminances == 1 || fail(from, "it has neither channels R, G and B nor Y, of floats");
}

static bool read_head(exr_reader *from, uint32_t width_max, uint32_t height_max)
{
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    if (!check(from, exr_get_storage(from->file, 0, &storage)) ||
        !check(from, exr_get_data_window(from->file, 0, &from->window))) {
        return false;
    }
    if (storage != EXR_STORAGE_SCANLINE) {
        return fail(from, "it has tiles or depths, where scan lines are read");
    }
    const int64_t width = (int64_t)from->window.max.x - from->window.min.x + 1;
    const int64_t height = (int64_t)from->window.max.y - from->window.min.y + 1;
    if (width < 1 || width > width_max || height < 1 || height > height_max) {
        (void)snprintf(from->out->words, HDR_WORDS_BYTES, "%lld x %lld texels are not within 1 x 1 .. %u x %u",
                       (long long)width, (long long)height, width_max, height_max);
        return false;
    }
    from->out->width = (uint32_t)width;
    from->out->height = (uint32_t)height;
    return find_channels(from) && check(from, exr_get_scanlines_per_chunk(from->file, 0, &from->rows_at_once));
}

/* Where the decoder puts the rows of a chunk; other channels go nowhere. */
static void aim(exr_reader *from, int32_t row)
{
    const uint32_t width = from->out->width;
    for (int k = 0; k < from->decoder.channel_count; ++k) {
        exr_coding_channel_info_t *to = &from->decoder.channels[k];
        const char *name = to->channel_name;
        const char *place = name[0] != '\0' && name[1] == '\0' ? strchr(from->names, name[0]) : NULL;
        float *texels = from->out->texels + (size_t)CHANNELS * width * (size_t)row;
        to->decode_to_ptr = place != NULL ? (uint8_t *)(texels + (place - from->names)) : NULL;
        to->user_bytes_per_element = sizeof(float);
        to->user_data_type = EXR_PIXEL_FLOAT;
        to->user_pixel_stride = CHANNELS * (int32_t)sizeof(float);
        to->user_line_stride = (int32_t)width * to->user_pixel_stride;
    }
}

static bool read_chunk(exr_reader *from, int32_t row)
{
    exr_chunk_info_t chunk;
    if (!check(from, exr_read_scanline_chunk_info(from->file, 0, from->window.min.y + row, &chunk)) ||
        !check(from, from->is_decoding ? exr_decoding_update(from->file, 0, &chunk, &from->decoder)
                                       : exr_decoding_initialize(from->file, 0, &chunk, &from->decoder))) {
        return false;
    }
    const bool is_first = !from->is_decoding;
    from->is_decoding = true;
    aim(from, row);
    return (!is_first || check(from, exr_decoding_choose_default_routines(from->file, 0, &from->decoder))) &&
           check(from, exr_decoding_run(from->file, 0, &from->decoder));
}

static bool read_rows(exr_reader *from)
{
    hdr_picture *out = from->out;
    const size_t count = (size_t)out->width * out->height;
    out->texels = calloc(count, CHANNELS * sizeof *out->texels);
    if (out->texels == NULL) {
        return fail(from, "out of memory");
    }
    for (int32_t row = 0; row < (int32_t)out->height; row += from->rows_at_once) {
        if (!read_chunk(from, row)) {
            return false;
        }
    }
    for (size_t i = 0; i < count; ++i) {
        float *texel = out->texels + CHANNELS * i;
        for (int channel = 0; channel < CHANNELS; ++channel) {
            const float value = texel[from->names[0] == 'Y' ? 0 : channel];
            texel[channel] = value < 0.0F ? 0.0F : value;
        }
    }
    return true;
}

bool exr_file_read(const char *path, uint32_t width_max, uint32_t height_max, hdr_picture *out)
{
    exr_reader from = {.decoder = EXR_DECODE_PIPELINE_INITIALIZER, .out = out};
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.error_handler_fn = ignore_error;
    *out = (hdr_picture){.texels = NULL};
    const bool is_read = check(&from, exr_start_read(&from.file, path, &how)) &&
                         read_head(&from, width_max, height_max) && read_rows(&from);
    if (from.is_decoding) {
        (void)exr_decoding_destroy(from.file, &from.decoder);
    }
    if (from.file != NULL) {
        (void)exr_finish(&from.file);
    }
    if (!is_read) {
        free(out->texels);
        out->texels = NULL;
    }
    return is_read;
}

#else

bool exr_file_read(const char *path, uint32_t width_max, uint32_t height_max, hdr_picture *out)
{
    (void)path;
    (void)width_max;
    (void)height_max;
    *out = (hdr_picture){.words = "this program was built without OpenEXR (libopenexr-dev)"};
    return false;
}

#endif
