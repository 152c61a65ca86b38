/* SPDX-License-Identifier: MIT */
/*
 * The reader of .svx files (https://abfab3d.com/svx-format/): a zip archive with a manifest and, for each channel, a
 * PNG image for each slice of the grid. Reads the manifest and goes through the slices.
 */
#include <expat.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <zip.h>

#include "core/memory.h"
#include "io/import_text.h"
#include "io/voxels_files.h"
#include "io/voxels_formats.h"

#define SVX_MANIFEST_BYTES ((uint64_t)1 << 20) /* most bytes of a manifest */
#define SVX_NAME_BYTES     256 /* of a type or of the names of slices, with the terminator */
#define SVX_CHANNELS_MAX   16

/* Static: a program that links the library may have its own stb_image. */
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_NO_GIF /* ONLY_PNG still declares its function */
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS SVX_SIDE_MAX
/* The name by which 2.27 defines what it declares by the other. NOLINTNEXTLINE(readability-identifier-naming) */
#define stbi_set_unpremultiply_on_load_thread stbi__unpremultiply_on_load_thread
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wconversion"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

#define SIGNATURE_BYTES 8u
#define CHUNK_BYTES     12u /* length, kind and checksum */
#define HEADER_BYTES    13u
#define OTHER_BYTES     ((uint64_t)1 << 16) /* room for chunks besides the pixels */
#define PIXEL_BYTES_MAX 8u

typedef struct svx_channel {
    char type[SVX_NAME_BYTES];
    char slices[SVX_NAME_BYTES]; /* "density/slice%04d.png" */
    uint32_t bits; /* 1 .. 16, or 24 for colors */
} svx_channel;

typedef struct svx_manifest {
    uint32_t size[3]; /* of the grid: x, y, z */
    double voxel_size; /* 0: not said */
    double origin[3];
    int slice_axis; /* that the slices follow: 0 x, 1 y, 2 z */
    int column_axis, row_axis;
    svx_channel channels[SVX_CHANNELS_MAX];
    uint32_t channel_count;
} svx_manifest;

/*
 * ---- the manifest ----
 *
 * By expat. A document type ends the reading, so that no entity is expanded.
 */

typedef struct parse {
    const voxel_reader *reader;
    XML_Parser parser;
    svx_manifest *manifest;
    bool has_grid;
    svo_status status; /* the first failure */
} parse;

/* Keeps the first failure and ends the parsing. */
static void stop(parse *p, const char *what, const char *value)
{
    if (p->status == SVO_OK) {
        p->status = svo_i_voxels_damaged(p->reader, "entry %s: %s '%.64s', at its byte %lld", SVX_MANIFEST, what, value,
                                         (long long)XML_GetCurrentByteIndex(p->parser));
        (void)XML_StopParser(p->parser, XML_FALSE);
    }
}

/* The value of an attribute; NULL: none. */
static const char *find(const XML_Char **attributes, const char *name)
{
    for (size_t i = 0; attributes[i] != NULL; i += 2) {
        if (strcmp(attributes[i], name) == 0) {
            return attributes[i + 1];
        }
    }
    return NULL;
}

/* Reads a finite number; leaves *value where there is none. */
static void read_number(parse *p, const XML_Char **attributes, const char *name, double *value)
{
    const char *text = find(attributes, name);
    if (text == NULL) {
        return;
    }
    const char *end = text + strlen(text);
    if (svo_i_number_double(text, end, value) != end || !isfinite(*value)) {
        stop(p, name, text);
    }
}

static void read_axes(parse *p, const XML_Char **attributes)
{
    const char *axis = find(attributes, "slicesOrientation");
    static const char *const names[] = {"X", "Y", "Z"};
    p->manifest->slice_axis = 1;
    for (int i = 0; axis != NULL && i < 4; ++i) {
        if (i == 3) {
            stop(p, "slicesOrientation", axis);
        } else if (strcmp(axis, names[i]) == 0) {
            p->manifest->slice_axis = i;
            break;
        }
    }
    p->manifest->column_axis = p->manifest->slice_axis == 0 ? 1 : 0;
    p->manifest->row_axis = p->manifest->slice_axis == 2 ? 1 : 2;
}

static void read_grid(parse *p, const XML_Char **attributes)
{
    static const char *const sizes[] = {"gridSizeX", "gridSizeY", "gridSizeZ"};
    static const char *const origins[] = {"originX", "originY", "originZ"};
    if (p->has_grid) {
        stop(p, "a second", "grid");
        return;
    }
    p->has_grid = true;
    for (int axis = 0; axis < 3; ++axis) {
        double size = 0.0;
        read_number(p, attributes, sizes[axis], &size);
        if (!(size >= 1.0 && size <= SVO_VOXELS_EXTENT_MAX) || rint(size) != size) {
            const char *text = find(attributes, sizes[axis]);
            stop(p, sizes[axis], text != NULL ? text : "");
            return;
        }
        p->manifest->size[axis] = (uint32_t)size;
        read_number(p, attributes, origins[axis], &p->manifest->origin[axis]);
    }
    read_number(p, attributes, "voxelSize", &p->manifest->voxel_size);
    if (find(attributes, "voxelSize") != NULL && !(p->manifest->voxel_size > 0.0)) {
        stop(p, "voxelSize", find(attributes, "voxelSize"));
    }
    read_axes(p, attributes);
}

/* Copies a text that fits. */
static void copy_text(parse *p, const char *name, const char *text, char *to)
{
    const size_t length = text != NULL ? strlen(text) : 0;
    if (length == 0 || length >= SVX_NAME_BYTES) {
        stop(p, name, text != NULL ? text : "");
        return;
    }
    memcpy(to, text, length + 1);
}

static void read_channel(parse *p, const XML_Char **attributes)
{
    double bits = 8.0;
    svx_manifest *manifest = p->manifest;
    if (manifest->channel_count == SVX_CHANNELS_MAX) {
        stop(p, "too many channels, the next is", find(attributes, "type") != NULL ? find(attributes, "type") : "");
        return;
    }
    svx_channel *channel = &manifest->channels[manifest->channel_count++];
    copy_text(p, "type", find(attributes, "type"), channel->type);
    copy_text(p, "slices", find(attributes, "slices"), channel->slices);
    read_number(p, attributes, "bits", &bits);
    if (!(bits >= 1.0 && bits <= 32.0) || rint(bits) != bits) {
        stop(p, "bits", find(attributes, "bits"));
        return;
    }
    channel->bits = (uint32_t)bits;
}

static void begin_element(void *user, const XML_Char *name, const XML_Char **attributes)
{
    parse *p = user;
    if (strcmp(name, "grid") == 0) {
        read_grid(p, attributes);
    } else if (strcmp(name, "channel") == 0) {
        read_channel(p, attributes);
    }
}

static void begin_doctype(void *user, const XML_Char *name, const XML_Char *system_id, const XML_Char *public_id,
                          int has_internal_subset)
{
    (void)system_id;
    (void)public_id;
    (void)has_internal_subset;
    stop(user, "a document type", name);
}

/* Reads the text of a manifest and checks its numbers. */
static svo_status read_manifest_text(const voxel_reader *reader, const char *text, size_t byte_count,
                                     svx_manifest *manifest)
{
    parse p = {.reader = reader, .manifest = manifest, .status = SVO_OK};
    p.parser = XML_ParserCreate(NULL);
    if (p.parser == NULL) {
        return svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %s", SVX_MANIFEST);
    }
    XML_SetUserData(p.parser, &p);
    XML_SetStartElementHandler(p.parser, begin_element);
    XML_SetStartDoctypeDeclHandler(p.parser, begin_doctype);
    const bool parsed = XML_Parse(p.parser, text, (int)byte_count, 1) == XML_STATUS_OK;
    const enum XML_Error error = XML_GetErrorCode(p.parser);
    if (p.status == SVO_OK && !parsed && error == XML_ERROR_NO_MEMORY) {
        p.status = svo_i_voxels_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %s", SVX_MANIFEST);
    } else if (p.status == SVO_OK && !parsed) {
        stop(&p, XML_ErrorString(error), "");
    } else if (p.status == SVO_OK && !p.has_grid) {
        stop(&p, "no element", "grid");
    }
    XML_ParserFree(p.parser);
    return p.status;
}

/*
 * ---- images ----
 *
 * PNG of a known size (https://www.w3.org/TR/png/). stb_image decodes them; before it does, their chunks are walked
 * through and their data unpacked into memory that is just large enough, since stb_image would unpack without bounds.
 */

/* A file in memory, and the size that its image must have. */
typedef struct svx_png {
    const uint8_t *bytes;
    size_t byte_count;
    uint32_t width, height;
} svx_png;

/* The pixels of an image, which are stb_image's: by malloc. */
typedef struct svx_image {
    void *gray; /* a uint8_t or, with 16 bits, a uint16_t per pixel; NULL for a color image */
    uint32_t bits; /* of a gray pixel: 8 or 16 */
    uint8_t *rgba; /* four bytes per pixel; NULL for a gray image */
} svx_image;

static const char no_memory[] = "out of memory";

static uint32_t u32_at(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Bytes of the unpacked rows, each with its filter; interlaced images have less than four more a row. */
static uint64_t unpacked_bytes_max(uint32_t width, uint32_t height)
{
    return (uint64_t)height * ((uint64_t)width * PIXEL_BYTES_MAX + 4) + 64;
}

/* The most bytes that an image of that size may have as a file. */
static uint64_t png_bytes_max(uint32_t width, uint32_t height)
{
    const uint64_t unpacked = unpacked_bytes_max(width, height);
    return unpacked + unpacked / 1000 + OTHER_BYTES; /* zlib makes what it cannot pack hardly longer */
}

/* Walks through the chunks; copies the packed pixels to packed, which may be NULL, and counts them. */
static const char *walk_chunks(const uint8_t *bytes, size_t byte_count, uint8_t *packed, size_t *packed_bytes,
                               size_t *offset)
{
    size_t at = SIGNATURE_BYTES;
    *packed_bytes = 0;
    for (;;) {
        *offset = at;
        if (byte_count - at < CHUNK_BYTES || u32_at(bytes + at) > byte_count - at - CHUNK_BYTES) {
            return "a chunk is cut off";
        }
        const size_t length = u32_at(bytes + at);
        const uint8_t *kind = bytes + at + 4;
        if (memcmp(kind, "IDAT", 4) == 0) {
            if (packed != NULL) {
                memcpy(packed + *packed_bytes, kind + 4, length);
            }
            *packed_bytes += length;
        }
        /* stb_image would unpack its pixels in another way than check_unpacked. */
        if (memcmp(kind, "CgBI", 4) == 0) {
            return "a chunk CgBI, of a variant that is not read";
        }
        if (memcmp(kind, "IEND", 4) == 0) {
            return NULL;
        }
        at += CHUNK_BYTES + length;
    }
}

/* Unpacks the pixels into bounded memory, which is then given up. */
static const char *check_unpacked(const svo_i_memory *memory, const svx_png *png, size_t *offset)
{
    size_t packed_bytes = 0;
    const uint64_t bound = unpacked_bytes_max(png->width, png->height);
    const char *wrong = walk_chunks(png->bytes, png->byte_count, NULL, &packed_bytes, offset);
    if (wrong != NULL) {
        return wrong;
    }
    uint8_t *packed = svo_i_alloc(memory, packed_bytes + 1);
    char *unpacked = svo_i_alloc(memory, (size_t)bound);
    if (packed == NULL || unpacked == NULL) {
        wrong = no_memory;
    } else {
        (void)walk_chunks(png->bytes, png->byte_count, packed, &packed_bytes, offset);
        const int got = stbi_zlib_decode_buffer(unpacked, (int)bound, (const char *)packed, (int)packed_bytes);
        wrong = got < 0 ? "its pixels cannot be unpacked, or are more than its size says" : NULL;
        *offset = SIGNATURE_BYTES;
    }
    svo_i_free(packed);
    svo_i_free(unpacked);
    return wrong;
}

/* Why stb_image gave no pixels. Not each of its allocations that fails has a reason, and the one before it stays: other
   is one that images do not have. */
static const char *decode_failure(const char *other)
{
    const char *reason = stbi_failure_reason();
    return reason == other || strcmp(reason, "outofmem") == 0 ? no_memory : "it cannot be decoded";
}

/* Decodes pixels as deep as the file has them: where stb_image converts them and runs out of memory, it loses the
   others. Deep colors keep their high bytes. */
static const char *decode(const uint8_t *bytes, int byte_count, bool deep, bool color, svx_image *image)
{
    int width = 0;
    int height = 0;
    int channels = 0;
    const int wanted = color ? 4 : 1;
    (void)stbi_info_from_memory(bytes, 0, &width, &height, &channels); /* "unknown image type" */
    const char *other = stbi_failure_reason();
    void *pixels = deep ? (void *)stbi_load_16_from_memory(bytes, byte_count, &width, &height, &channels, wanted)
                        : (void *)stbi_load_from_memory(bytes, byte_count, &width, &height, &channels, wanted);
    if (pixels == NULL) {
        return decode_failure(other);
    }
    for (size_t i = 0; deep && color && i < 4 * (size_t)width * (size_t)height; ++i) {
        uint16_t value = 0;
        memcpy(&value, (const uint8_t *)pixels + 2 * i, sizeof value);
        ((uint8_t *)pixels)[i] = (uint8_t)(value >> 8);
    }
    image->gray = color ? NULL : pixels;
    image->rgba = color ? pixels : NULL;
    image->bits = deep ? 16 : 8;
    return NULL;
}

/*
 * Decodes an image of exactly its size, as color or as gray. Memory is bounded by the size, whatever the file says.
 *
 * memory: for what the check needs while it runs.
 * Returns NULL, or why not; "out of memory" is that very text. *offset: the byte of the file that it is about.
 */
static const char *read_png(const svo_i_memory *memory, const svx_png *png, int color, svx_image *image, size_t *offset)
{
    static const uint8_t signature[SIGNATURE_BYTES] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    *image = (svx_image){.gray = NULL};
    *offset = 0;
    if (png->byte_count < SIGNATURE_BYTES + CHUNK_BYTES + HEADER_BYTES ||
        memcmp(png->bytes, signature, SIGNATURE_BYTES) != 0) {
        return "not a PNG image";
    }
    const uint8_t *header = png->bytes + SIGNATURE_BYTES + 8;
    *offset = SIGNATURE_BYTES + 8;
    if (memcmp(header - 4, "IHDR", 4) != 0 || u32_at(header) != png->width || u32_at(header + 4) != png->height) {
        return "its size is not that of a slice";
    }
    const char *wrong = check_unpacked(memory, png, offset);
    if (wrong != NULL) {
        return wrong;
    }
    return decode(png->bytes, (int)png->byte_count, header[8] == 16, color != 0, image);
}

/* A pixel of a gray image. */
static uint32_t gray_pixel(const svx_image *image, size_t pixel)
{
    return image->bits == 16 ? ((const uint16_t *)image->gray)[pixel] : ((const uint8_t *)image->gray)[pixel];
}

static void free_image(svx_image *image)
{
    stbi_image_free(image->gray);
    stbi_image_free(image->rgba);
    *image = (svx_image){.gray = NULL};
}

/* ---- the archive ---- */

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
        status = read_manifest_text(r->reader, (const char *)text, byte_count, &r->manifest);
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
    svo_status status = read_entry(r, name, png_bytes_max(r->width, r->height), &bytes, &byte_count);
    if (status == SVO_OK) {
        const svx_png png = {.bytes = bytes, .byte_count = byte_count, .width = r->width, .height = r->height};
        const char *wrong = read_png(&r->reader->memory, &png, kind == SVX_COLOR, image, &offset);
        if (wrong == no_memory) {
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
        if (gray_pixel(&images[SVX_DENSITY], pixel) < half) {
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
            voxel.material = (uint16_t)gray_pixel(&images[SVX_MATERIAL], pixel);
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
        free_image(&images[kind]);
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
