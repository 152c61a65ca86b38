/* SPDX-License-Identifier: MIT */
/* .svx archives byte by byte, with the right checksums: manifests and images that no writer makes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "support/suite.h"
#include "svocl/voxel_files.h"
#include "vox_bytes.h"

#define GRID     "<grid gridSizeX=\"1\" gridSizeY=\"1\" gridSizeZ=\"1\">"
#define CHANNEL  "<channel type=\"DENSITY\" slices=\"d%d.png\" bits=\"8\"/></grid>"
#define MANIFEST GRID CHANNEL

/* ---- archives ---- */

static uint32_t crc32_of(const byte_list *content)
{
    uint32_t sum = UINT32_MAX;
    for (size_t i = 0; i < content->count; ++i) {
        sum ^= content->bytes[i];
        for (int bit = 0; bit < 8; ++bit) {
            sum = (sum & 1u) != 0 ? sum >> 1 ^ 0xedb88320u : sum >> 1;
        }
    }
    return ~sum;
}

static void put_u16(byte_list *list, uint32_t value)
{
    bytes_put_u8(list, (uint8_t)value);
    bytes_put_u8(list, (uint8_t)(value >> 8));
}

/* What the local and the central head of an entry share. */
static void put_head(byte_list *list, const char *name, const byte_list *content)
{
    put_u16(list, 10); /* version */
    put_u16(list, 0); /* flags */
    put_u16(list, 0); /* stored */
    bytes_put_i32(list, 0x210000); /* time */
    bytes_put_i32(list, (int32_t)crc32_of(content));
    bytes_put_i32(list, (int32_t)content->count);
    bytes_put_i32(list, (int32_t)content->count);
    put_u16(list, (uint32_t)strlen(name));
    put_u16(list, 0); /* extra */
}

/* An archive of the manifest and d0.png. */
static byte_list make_archive(const char *manifest, const byte_list *image)
{
    byte_list archive = {0};
    byte_list central = {0};
    byte_list text = {0};
    static const char *const names[] = {"manifest.xml", "d0.png"};
    bytes_put_text(&text, manifest);
    const byte_list *const contents[] = {&text, image};
    for (int i = 0; i < 2; ++i) {
        const size_t begin = archive.count;
        bytes_put(&archive, "PK\3\4", 4);
        put_head(&archive, names[i], contents[i]);
        bytes_put_text(&archive, names[i]);
        bytes_put(&archive, contents[i]->bytes, contents[i]->count);
        bytes_put(&central, "PK\1\2\12\0", 6);
        put_head(&central, names[i], contents[i]);
        bytes_put(&central, "\0\0\0\0\0\0\0\0\0\0", 10); /* comment, disk, attributes */
        bytes_put_i32(&central, (int32_t)begin);
        bytes_put_text(&central, names[i]);
    }
    const size_t begin = archive.count;
    bytes_put(&archive, central.bytes, central.count);
    bytes_put(&archive, "PK\5\6\0\0\0\0\2\0\2\0", 12);
    bytes_put_i32(&archive, (int32_t)central.count);
    bytes_put_i32(&archive, (int32_t)begin);
    put_u16(&archive, 0);
    bytes_free(&text);
    bytes_free(&central);
    return archive;
}

/* ---- images ---- */

static void put_chunk(byte_list *image, const char *kind, const void *content, size_t count)
{
    const uint8_t length[4] = {(uint8_t)(count >> 24), (uint8_t)(count >> 16), (uint8_t)(count >> 8), (uint8_t)count};
    bytes_put(image, length, 4);
    bytes_put_text(image, kind);
    if (count > 0) {
        bytes_put(image, content, count);
    }
    bytes_put_i32(image, 0); /* checksum, which no reader of the library looks at */
}

/* A gray image of 1 x 1 pixels that says it is so wide; other: a chunk after the head, or NULL. */
static byte_list make_image(uint8_t width, const char *other, const void *packed, size_t packed_bytes)
{
    byte_list image = {0};
    const uint8_t head[13] = {0, 0, 0, width, 0, 0, 0, 1, 8};
    bytes_put(&image, "\x89PNG\r\n\x1a\n", 8);
    put_chunk(&image, "IHDR", head, sizeof head);
    if (other != NULL) {
        put_chunk(&image, other, NULL, 0);
    }
    put_chunk(&image, "IDAT", packed, packed_bytes);
    put_chunk(&image, "IEND", NULL, 0);
    return image;
}

/* ---- tests ---- */

static svo_status load(const char *manifest, byte_list image, uint64_t *voxel_count, svo_message *message)
{
    svo_voxels *voxels = NULL;
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    byte_list archive = make_archive(manifest, &image);
    const svo_status status =
        svo_voxels_load(svo_from_memory(archive.bytes, archive.count, "file"), NULL, &voxels, NULL, message);
    if (status == SVO_OK) {
        assert_int_equal(svo_voxels_get_info(voxels, &info), SVO_OK);
        *voxel_count = info.voxel_count;
    }
    svo_voxels_destroy(&voxels);
    bytes_free(&archive);
    bytes_free(&image);
    return status;
}

static void refuse(const char *manifest, byte_list image, const char *words)
{
    uint64_t voxel_count = 0;
    svo_message message = {""};
    const svo_status status = load(manifest, image, &voxel_count, &message);
    if (status != SVO_FILE_DAMAGED || strstr(message.text, words) == NULL) {
        fail_msg("%s '%s', expected '%s'", svo_name(SVO_NAME_STATUS, status), message.text, words);
    }
}

/* A row of 1 pixel: its filter, and 255. Not packed. */
static const uint8_t row[] = {0x78, 1, 1, 2, 0, 0xfd, 0xff, 0, 255, 1, 0, 1, 0};

static void test_images(void **state)
{
    (void)state;
    uint64_t voxel_count = 0;
    svo_message message = {""};
    if (load(MANIFEST, make_image(1, NULL, row, sizeof row), &voxel_count, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    assert_int_equal(voxel_count, 1);
    assert_int_equal(load(MANIFEST, make_image(1, "otHr", row, sizeof row), &voxel_count, &message), SVO_OK);
    refuse(MANIFEST, make_image(2, NULL, row, sizeof row), "entry d0.png: its size is not that of a slice");
    refuse(MANIFEST, make_image(1, NULL, row, 8), "entry d0.png: its pixels cannot be unpacked");
    refuse(MANIFEST, make_image(1, "IHDR", row, sizeof row), "entry d0.png: it cannot be decoded");
}

/* Pixels that unpack to more than the image's size says: 400 bytes. */
static void test_images_that_unpack_to_too_much(void **state)
{
    (void)state;
    uint8_t packed[411] = {0x78, 1, 1, 0x90, 1, 0x6f, 0xfe};
    refuse(MANIFEST, make_image(1, NULL, packed, sizeof packed), "or are more than its size says");
    /* Nothing with the two bytes of zlib's head, and 839 bytes without: CgBI means without. */
    uint8_t twofold[5 + 839 + 5] = {0x58, 0x47, 3, 0xb8, 0xfc};
    twofold[5 + 839] = 1;
    twofold[5 + 839 + 3] = 0xff;
    twofold[5 + 839 + 4] = 0xff;
    refuse(MANIFEST, make_image(1, "CgBI", twofold, sizeof twofold), "entry d0.png: a chunk CgBI");
}

static void test_manifests(void **state)
{
    (void)state;
    static const struct {
        const char *manifest, *words;
    } cases[] = {{"<!DOCTYPE grid [<!ENTITY a \"b\">]>" MANIFEST, "a document type 'grid'"},
                 {GRID "</grid>", "no channel DENSITY"},
                 {GRID "<channel type=\"DENSITY\" slices=\"d%s.png\"/></grid>", "has no single %d"},
                 {GRID "<channel type=\"DENSITY\" slices=\"d%d%d.png\"/></grid>", "has no single %d"},
                 {GRID "<channel type=\"DENSITY\" slices=\"e%d.png\"/></grid>", "entry e0.png: it is missing"},
                 {"<grid gridSizeX=\"16385\" gridSizeY=\"1\" gridSizeZ=\"1\">" CHANNEL, "16385 x 1 x 1 is above"},
                 {"<grid gridSizeX=\"1\" gridSizeY=\"nan\" gridSizeZ=\"1\">" CHANNEL, "gridSizeY 'nan'"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        refuse(cases[i].manifest, make_image(1, NULL, row, sizeof row), cases[i].words);
    }
}

TEST_GROUP(svx)
{
    svo_voxels *voxels = NULL;
    svo_message message = {""};
    if (svo_voxels_load(svo_from_memory("PK\3\4", 4, "file"), NULL, &voxels, NULL, &message) == SVO_UNSUPPORTED) {
        print_message("skipped: svocl was built without libzip or expat\n");
        return 0;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_images),
        cmocka_unit_test(test_images_that_unpack_to_too_much),
        cmocka_unit_test(test_manifests),
    };
    return cmocka_run_group_tests_name("svx", tests, NULL, NULL);
}
