/* SPDX-License-Identifier: MIT */
/* The .svx reader: opens the archive, reads its manifest and goes through the slices. */
#include "io/voxels_svx.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <zip.h>

#include "io/voxels_formats.h"
#include "io/voxels_svx_manifest.h"
#include "io/voxels_svx_png.h"

typedef struct svx_reader {
    voxel_reader *reader;
    zip_t *archive;
    svx_manifest manifest;
    const svx_channel *channels[SVX_KINDS]; /* NULL: the file has none of that kind */
    uint32_t width, height, slice_count; /* of the slices */
    bool counts; /* else it adds the voxels */
    uint64_t counted;
} svx_reader;

/* Reads an entry of at most that many bytes into memory of its own. */
static svo_status read_entry(const svx_reader *r, const char *name, uint64_t bytes_max, uint8_t **bytes,
                             size_t *byte_count)
{
    zip_stat_t entry;
    const voxel_reader *reader = r->reader;
    const zip_int64_t index = zip_name_locate(r->archive, name, 0);
    if (index < 0 || zip_stat_index(r->archive, (zip_uint64_t)index, 0, &entry) != 0 ||
        (entry.valid & ZIP_STAT_SIZE) == 0) {
        return svo_i_voxels_damaged(reader, "entry %s: it is missing, at byte 0", name);
    }
    if (entry.size > bytes_max) {
        return svo_i_voxels_damaged(reader,
                                    "entry %s: %" PRIu64 " bytes are above the limit of %" PRIu64 ", at its byte 0",
                                    name, (uint64_t)entry.size, bytes_max);
    }
    zip_file_t *file = zip_fopen_index(r->archive, (zip_uint64_t)index, 0);
    if (file == NULL) {
        return svo_i_voxels_damaged(reader, "entry %s: %s, at its byte 0", name, zip_strerror(r->archive));
    }
    *bytes = svo_i_alloc(&reader->memory, (size_t)entry.size + 1);
    if (*bytes == NULL) {
        zip_fclose(file);
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "entry %s: no memory for %" PRIu64 " bytes", name,
                                 (uint64_t)entry.size);
    }
    zip_int64_t got = 0;
    *byte_count = 0;
    while (*byte_count < entry.size && (got = zip_fread(file, *bytes + *byte_count, entry.size - *byte_count)) > 0) {
        *byte_count += (size_t)got;
    }
    /* The checksum is compared when the end is read. */
    const bool complete = *byte_count == entry.size && zip_fread(file, *bytes + *byte_count, 1) == 0;
    zip_error_t *error = zip_file_get_error(file);
    const char *wrong =
        zip_error_code_zip(error) != ZIP_ER_OK ? zip_error_strerror(error) : "its length is not that of its head";
    const svo_status status =
        complete ? SVO_OK : svo_i_voxels_damaged(reader, "entry %s: %s, at its byte %zu", name, wrong, *byte_count);
    zip_fclose(file);
    return status;
}

static svo_status read_manifest(svx_reader *r)
{
    uint8_t *text = NULL;
    size_t byte_count = 0;
    svo_status status = read_entry(r, SVX_MANIFEST, SVX_MANIFEST_BYTES, &text, &byte_count);
    if (status == SVO_OK) {
        status = svo_i_svx_read_manifest(r->reader, (const char *)text, byte_count, &r->manifest);
    }
    svo_i_free(text);
    return status;
}

/* Finds the channels that are read, and warns of the others. */
static svo_status choose_channels(svx_reader *r)
{
    static const struct {
        const char *type;
        svx_kind kind;
    } known[] = {
        {"DENSITY", SVX_DENSITY}, {"COLOR-RGB", SVX_COLOR}, {"COLOR_RGB", SVX_COLOR}, {"MATERIAL", SVX_MATERIAL}};
    for (uint32_t i = 0; i < r->manifest.channel_count; ++i) {
        const svx_channel *channel = &r->manifest.channels[i];
        bool read = false;
        for (size_t k = 0; k < sizeof known / sizeof known[0]; ++k) {
            if (strcmp(channel->type, known[k].type) == 0 && r->channels[known[k].kind] == NULL) {
                r->channels[known[k].kind] = channel;
                read = true;
            }
        }
        if (!read) {
            svo_i_voxels_warn(r->reader, "channel %.64s is not read", channel->type);
        }
    }
    return r->channels[SVX_DENSITY] != NULL
               ? SVO_OK
               : svo_i_voxels_damaged(r->reader, "entry %s: no channel DENSITY, at its byte 0", SVX_MANIFEST);
}

static svo_status measure_grid(svx_reader *r)
{
    const svx_manifest *m = &r->manifest;
    const uint64_t slice = (uint64_t)m->size[m->column_axis] * m->size[m->row_axis];
    r->slice_count = m->size[m->slice_axis];
    r->width = m->size[m->column_axis];
    r->height = m->size[m->row_axis];
    if (r->width > SVX_SIDE_MAX || r->height > SVX_SIDE_MAX || slice > SVX_PIXELS_MAX ||
        slice * r->slice_count > SVX_CELLS_MAX) {
        return svo_i_voxels_damaged(
            r->reader,
            "entry %s: a grid of %u x %u x %u is above the limits of %d a side of a slice, 2^27 pixels and "
            "2^31 cells, at its byte 0",
            SVX_MANIFEST, m->size[0], m->size[1], m->size[2], SVX_SIDE_MAX);
    }
    return SVO_OK;
}

/* Replaces the one %d or %0Nd in the names of a channel's slices. */
static svo_status slice_name(const svx_reader *r, const svx_channel *channel, uint32_t slice, char *name,
                             size_t name_bytes)
{
    const char *percent = strchr(channel->slices, '%');
    const char *rest = percent;
    int digits = 0;
    if (rest != NULL) {
        ++rest;
        while (*rest >= '0' && *rest <= '9' && digits < 10) {
            digits = 10 * digits + (*rest++ - '0');
        }
    }
    if (rest == NULL || *rest != 'd' || digits > 20 || strchr(rest, '%') != NULL) {
        return svo_i_voxels_damaged(r->reader, "entry %s: slices '%.64s' has no single %%d, at its byte 0",
                                    SVX_MANIFEST, channel->slices);
    }
    (void)snprintf(name, name_bytes, "%.*s%0*u%s", (int)(percent - channel->slices), channel->slices, digits, slice,
                   rest + 1);
    return SVO_OK;
}

static svo_status read_slice(const svx_reader *r, svx_kind kind, uint32_t slice, svx_image *image)
{
    char name[SVX_NAME_BYTES + 32];
    uint8_t *bytes = NULL;
    size_t byte_count = 0;
    size_t offset = 0;
    if (r->channels[kind] == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(slice_name(r, r->channels[kind], slice, name, sizeof name));
    svo_status status = read_entry(r, name, svo_i_svx_png_bytes_max(r->width, r->height), &bytes, &byte_count);
    if (status == SVO_OK) {
        const svx_png png = {.bytes = bytes, .byte_count = byte_count, .width = r->width, .height = r->height};
        const char *wrong = svo_i_svx_png_read(&r->reader->memory, &png, kind == SVX_COLOR, image, &offset);
        if (wrong == svo_i_svx_png_no_memory) {
            status = svo_i_voxels_fail(r->reader, SVO_OUT_OF_HOST_MEMORY, "entry %s: %s", name, wrong);
        } else if (wrong != NULL) {
            status = svo_i_voxels_damaged(r->reader, "entry %s: %s, at its byte %zu", name, wrong, offset);
        }
    }
    svo_i_free(bytes);
    return status;
}

/* Half of what a density can be: of as many bits as the channel says, if the image has so many. */
static uint32_t half_density(const svx_reader *r, const svx_image *image)
{
    const uint32_t bits = r->channels[SVX_DENSITY]->bits;
    return 1u << ((bits < image->bits ? bits : image->bits) - 1);
}

static svo_status add_slice(svx_reader *r, uint32_t slice, const svx_image images[SVX_KINDS])
{
    const svx_manifest *m = &r->manifest;
    const uint32_t half = half_density(r, &images[SVX_DENSITY]);
    for (size_t pixel = 0; pixel < (size_t)r->width * r->height; ++pixel) {
        int32_t place[3];
        if (svo_i_svx_png_gray(&images[SVX_DENSITY], pixel) < half) {
            continue;
        }
        if (r->counts) {
            ++r->counted;
            continue;
        }
        place[m->slice_axis] = (int32_t)slice;
        place[m->column_axis] = (int32_t)(pixel % r->width);
        place[m->row_axis] = (int32_t)(pixel / r->width);
        svo_voxel voxel = {.x = place[0], .y = place[1], .z = place[2], .rgba = {255, 255, 255, 255}};
        if (images[SVX_COLOR].rgba != NULL) {
            memcpy(voxel.rgba, images[SVX_COLOR].rgba + 4 * pixel, 4);
        }
        if (images[SVX_MATERIAL].gray != NULL) {
            voxel.material = (uint16_t)svo_i_svx_png_gray(&images[SVX_MATERIAL], pixel);
        }
        SVO_I_TRY(svo_i_voxels_append(r->reader, voxel));
    }
    return SVO_OK;
}

static svo_status read_slice_images(svx_reader *r, uint32_t slice)
{
    svo_status status = SVO_OK;
    svx_image images[SVX_KINDS] = {{.gray = NULL}};
    for (int kind = 0; kind < (r->counts ? 1 : SVX_KINDS); ++kind) { /* the first is the density */
        SVO_I_TRY_CLEANUP(read_slice(r, (svx_kind)kind, slice, &images[kind]));
    }
    status = add_slice(r, slice, images);
cleanup:
    for (int kind = 0; kind < SVX_KINDS; ++kind) {
        svo_i_svx_png_free(&images[kind]);
    }
    return status;
}

static svo_status read_slices(svx_reader *r)
{
    for (uint32_t slice = 0; slice < r->slice_count; ++slice) {
        SVO_I_TRY(read_slice_images(r, slice));
        SVO_I_TRY(svo_i_voxels_limit(r->reader, r->counted));
    }
    return SVO_OK;
}

/* A grid that may hold more than the limit is counted first: slices pack so well that a small file fills any memory. */
static svo_status count_voxels(svx_reader *r)
{
    r->counts = (uint64_t)r->width * r->height * r->slice_count > r->reader->options.voxels_max;
    SVO_I_TRY(r->counts ? read_slices(r) : SVO_OK);
    r->counts = false;
    return SVO_OK;
}

static svo_status read_archive(svx_reader *r)
{
    SVO_I_TRY(read_manifest(r));
    SVO_I_TRY(choose_channels(r));
    SVO_I_TRY(measure_grid(r));
    SVO_I_TRY(count_voxels(r));
    SVO_I_TRY(read_slices(r));
    voxel_reader *reader = r->reader;
    reader->voxel_edge = r->manifest.voxel_size;
    memcpy(reader->origin, r->manifest.origin, sizeof reader->origin);
    reader->info.instance_voxels = reader->voxel_count;
    return SVO_OK;
}

svo_status svo_i_voxels_read_svx(voxel_reader *reader)
{
    zip_error_t error;
    svx_reader r = {.reader = reader};
    zip_error_init(&error);
    zip_source_t *source = zip_source_buffer_create(reader->bytes, reader->byte_count, 0, &error);
    r.archive = source != NULL ? zip_open_from_source(source, ZIP_RDONLY, &error) : NULL;
    svo_status status = SVO_OK;
    if (r.archive == NULL) {
        zip_source_free(source);
        status = zip_error_code_zip(&error) == ZIP_ER_MEMORY
                     ? svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for the archive")
                     : svo_i_voxels_damaged(reader, "archive: %s, at byte %zu", zip_error_strerror(&error),
                                            reader->byte_count);
    } else {
        status = read_archive(&r);
        zip_discard(r.archive);
    }
    zip_error_fini(&error);
    return status;
}
