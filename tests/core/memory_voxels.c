/* SPDX-License-Identifier: MIT */
/* Lists of voxels whose memory the ledger has. */
#include "memory_voxels.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "core/message.h"
#include "support/memory_ledger.h"

/* A box of voxels, of a color each. */
enum { WIDTH = 10, HEIGHT = 6, LENGTH = 10, VOXELS = WIDTH * HEIGHT * LENGTH };

/* A file in memory. */
typedef struct voxel_file {
    uint8_t bytes[1 << 20];
    size_t count;
} voxel_file;

static voxel_file files[SVO_VOXEL_FORMAT_NVDB + 1];

static int append(void *user, const void *bytes, size_t byte_count)
{
    voxel_file *to = user;
    if (byte_count > sizeof to->bytes - to->count) {
        return 1;
    }
    memcpy(to->bytes + to->count, bytes, byte_count);
    to->count += byte_count;
    return 0;
}

static svo_voxel voxel_at(int i)
{
    return (svo_voxel){.x = i % WIDTH,
                       .y = i / WIDTH % HEIGHT,
                       .z = i / WIDTH / HEIGHT,
                       .rgba = {(uint8_t)i, (uint8_t)(i >> 8), 7, 255},
                       .material = (uint16_t)(i % 3)};
}

/* The struct of the functions is gone after the call. */
svo_status memory_voxels_make(memory_voxels *of, bool doubled, svo_message *message)
{
    static const svo_voxel_property properties[] = {
        {2, "_type", "_glass"}, {1, "_rough", "0.5"}, {2, "_type", "_emit"}};
    svo_voxel given[2 * VOXELS];
    svo_memory_callbacks passing = ledger_callbacks;
    for (int i = 0; i < 2 * VOXELS; ++i) {
        given[i] = voxel_at(i % VOXELS);
    }
    const svo_voxels_source source = {.struct_size = sizeof source,
                                      .voxels = given,
                                      .voxel_count = doubled ? 2 * VOXELS : VOXELS,
                                      .properties = properties,
                                      .property_count = sizeof properties / sizeof properties[0],
                                      .memory = &passing};
    const svo_status status = svo_voxels_create(&source, &of->list, message);
    memset(&passing, 0, sizeof passing);
    return status;
}

void memory_voxels_destroy(memory_voxels *of)
{
    svo_voxels_destroy(&of->again);
    svo_voxels_destroy(&of->list);
}

svo_status memory_voxels_write(const memory_voxels *of, const char *path, svo_message *message)
{
    for (int format = SVO_VOXEL_FORMAT_VOX; format <= SVO_VOXEL_FORMAT_NVDB; ++format) {
        files[format].count = 0;
        const svo_status status =
            svo_voxels_save(of->list, svo_to_callback(append, &files[format]), (svo_voxel_format)format, NULL, message);
        const bool is_optional = format == SVO_VOXEL_FORMAT_SVX || format == SVO_VOXEL_FORMAT_NVDB;
        if (status != SVO_OK && (!is_optional || status != SVO_UNSUPPORTED)) {
            return status;
        }
    }
    return svo_voxels_save(of->list, svo_to_path(path), SVO_VOXEL_FORMAT_VOX, NULL, message);
}

bool memory_voxels_have(svo_voxel_format format)
{
    return files[format].count > 0;
}

/* The list that was read fills the box again. */
static svo_status check_box(const memory_voxels *of)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    assert_int_equal(svo_voxels_get_info(of->again, &info), SVO_OK);
    assert_int_equal(info.voxel_count, VOXELS);
    assert_int_equal(info.high[0] - info.low[0], WIDTH);
    assert_int_equal(info.high[1] - info.low[1], HEIGHT);
    assert_int_equal(info.high[2] - info.low[2], LENGTH);
    return SVO_OK;
}

svo_status memory_voxels_load_path(memory_voxels *of, const char *path, svo_message *message)
{
    svo_memory_callbacks passing = ledger_callbacks;
    const svo_voxels_load_options options = {.struct_size = sizeof options, .memory = &passing};
    const svo_status status = svo_voxels_load(svo_from_path(path), &options, &of->again, NULL, message);
    memset(&passing, 0, sizeof passing);
    SVO_I_TRY(status);
    return check_box(of);
}

svo_status memory_voxels_load(memory_voxels *of, svo_voxel_format format, svo_message *message)
{
    svo_memory_callbacks passing = ledger_callbacks;
    const svo_voxels_load_options options = {.struct_size = sizeof options, .memory = &passing};
    const svo_status status = svo_voxels_load(svo_from_memory(files[format].bytes, files[format].count, "a"), &options,
                                              &of->again, NULL, message);
    memset(&passing, 0, sizeof passing);
    SVO_I_TRY(status);
    return check_box(of);
}
