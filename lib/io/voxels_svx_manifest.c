/* SPDX-License-Identifier: MIT */
/* Reads the manifest of a .svx file with expat. A document type ends the reading, so that no entity is expanded. */
#include "io/voxels_svx_manifest.h"

#include <expat.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "io/import_number.h"

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

svo_status svo_i_svx_read_manifest(const voxel_reader *reader, const char *text, size_t byte_count,
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
