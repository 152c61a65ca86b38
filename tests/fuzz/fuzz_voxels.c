/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as a voxel file. Either they are refused with a one-line message that names the byte, or
 * the list is well formed: voxels within their bounds, in Morton order, materials below the count; and what is written
 * of it is read as the same list. Its faces are written. A .vox file that is read is copied, byte for byte, with the
 * same info.
 *
 * FUZZ_ARCHIVE: bytes that do not begin as an archive are a manifest, a byte 0, and an image, which are put into one
 * with correct checksums.
 *
 * FUZZ_RUNS: a byte 0 is followed by a byte n, and both stand for 1 + n (n + 1) / 2 bytes of 0: masks of .vdb files are
 * long and nearly empty.
 */
#include <string.h>

#include "fuzz.h"
#include "svocl/nodes.h"
#include "svocl/voxel_files.h"

#define NAME       "input"
#define VOXELS_MAX 20000u

typedef struct bytes {
    uint8_t *data;
    size_t count;
} bytes;

static int append(void *user, const void *from, size_t count)
{
    bytes *to = user;
    uint8_t *larger = realloc(to->data, to->count + count);
    REQUIRE(larger != NULL);
    memcpy(larger + to->count, from, count);
    *to = (bytes){larger, to->count + count};
    return 0;
}

static void check_refusal(svo_status status, const svo_voxels *voxels, const svo_message *message)
{
    REQUIRE(status == SVO_FILE_DAMAGED || status == SVO_OUT_OF_HOST_MEMORY || status == SVO_INVALID_ARGUMENT ||
            status == SVO_UNSUPPORTED);
    REQUIRE(voxels == NULL);
    REQUIRE(strncmp(message->text, NAME ": ", strlen(NAME ": ")) == 0);
    REQUIRE(strchr(message->text, '\n') == NULL);
    REQUIRE(status != SVO_FILE_DAMAGED || strstr(message->text, "byte") != NULL);
}

static void check_list(const svo_voxels *voxels)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    uint64_t before = 0;
    REQUIRE(svo_voxels_get_info(voxels, &info) == SVO_OK);
    REQUIRE(info.voxel_count <= VOXELS_MAX && info.given_count >= info.voxel_count);
    for (uint64_t i = 0; i < info.voxel_count; ++i) {
        const svo_voxel *voxel = &svo_voxels_get(voxels)[i];
        REQUIRE(voxel->x >= info.low[0] && voxel->y >= info.low[1] && voxel->z >= info.low[2]);
        REQUIRE(voxel->x < info.high[0] && voxel->y < info.high[1] && voxel->z < info.high[2]);
        REQUIRE(voxel->material < info.material_count);
        const uint32_t cell[3] = {(uint32_t)(voxel->x - info.low[0]), (uint32_t)(voxel->y - info.low[1]),
                                  (uint32_t)(voxel->z - info.low[2])};
        const uint64_t code = svo_cell_to_code(cell) + 1;
        REQUIRE(code > before);
        before = code;
    }
    for (uint64_t i = 0; i < info.property_count; ++i) {
        const svo_voxel_property *one = &svo_voxels_get_properties(voxels)[i];
        REQUIRE(one->key[0] != '\0' && strlen(one->value) + 1 > 0 && one->material < 65535);
    }
}

/* Writes the list as .vox and reads it: the same places. */
static void check_written(const svo_voxels *voxels)
{
    bytes file = {NULL, 0};
    svo_voxels *again = NULL;
    svo_voxels_info given = SVO_VOXELS_INFO_INIT;
    svo_voxels_info read = SVO_VOXELS_INFO_INIT;
    const svo_status status = svo_voxels_save(voxels, svo_to_callback(append, &file), SVO_VOXEL_FORMAT_VOX, NULL, NULL);
    REQUIRE(status == SVO_OK);
    REQUIRE(svo_voxels_load(svo_from_memory(file.data, file.count, NAME), NULL, &again, NULL, NULL) == SVO_OK);
    REQUIRE(svo_voxels_get_info(voxels, &given) == SVO_OK && svo_voxels_get_info(again, &read) == SVO_OK);
    REQUIRE(given.voxel_count == read.voxel_count);
    for (uint64_t i = 0; i < given.voxel_count; ++i) {
        REQUIRE(memcmp(&svo_voxels_get(voxels)[i], &svo_voxels_get(again)[i], 3 * sizeof(int32_t)) == 0);
    }
    svo_voxels_destroy(&again);
    free(file.data);
}

/* Writes the faces, unless voxels are too far out for floats. A face has a body and eight gaps around it at most. */
static void check_faces(const svo_voxels *voxels)
{
    bytes file = {NULL, 0};
    svo_voxels_save_info info = SVO_VOXELS_SAVE_INFO_INIT;
    const svo_status status =
        svo_voxels_save_faces(voxels, svo_to_callback(append, &file), SVO_VOXEL_FORMAT_PLY, &info, NULL);
    REQUIRE(status == SVO_OK || (status == SVO_INVALID_ARGUMENT && file.count == 0));
    REQUIRE(info.faces <= 9 * info.voxel_faces && info.bytes == file.count);
    REQUIRE(status != SVO_OK || file.count > info.faces * (4 * 16 + 17));
    free(file.data);
}

static void check_copy(const uint8_t *data, size_t byte_count, const svo_voxels_load_options *options,
                       const svo_voxel_file_info *info)
{
    bytes file = {NULL, 0};
    svo_message text = {""};
    svo_voxel_file_info copied = SVO_VOXEL_FILE_INFO_INIT;
    const svo_status status = svo_voxels_copy_vox(svo_from_memory(data, byte_count, NAME),
                                                  svo_to_callback(append, &file), options, &copied, &text);
    if (info == NULL || info->format != SVO_VOXEL_FORMAT_VOX) {
        REQUIRE(status != SVO_OK && file.count == 0 && text.text[0] != '\0');
        return;
    }
    REQUIRE(status == SVO_OK && file.count == byte_count && memcmp(file.data, data, byte_count) == 0);
    REQUIRE(memcmp(&copied, info, sizeof copied) == 0);
    REQUIRE(svo_voxels_left_out(info, &text) == SVO_OK && strchr(text.text, '\n') == NULL);
    free(file.data);
}

static void run(const uint8_t *data, size_t byte_count)
{
    static const uint8_t nothing;
    svo_voxels *voxels = NULL;
    svo_voxel_file_info info = SVO_VOXEL_FILE_INFO_INIT;
    svo_message message = {""};
    const svo_voxels_load_options options = {.struct_size = sizeof options,
                                             .voxels_max = VOXELS_MAX,
                                             .hidden = (uint32_t)(byte_count % 2),
                                             .frame = (uint32_t)(byte_count % 3)};
    const svo_status status = svo_voxels_load(svo_from_memory(data != NULL ? data : &nothing, byte_count, NAME),
                                              &options, &voxels, &info, &message);
    if (status != SVO_OK) {
        check_refusal(status, voxels, &message);
        if (status == SVO_FILE_DAMAGED && data != NULL) {
            check_copy(data, byte_count, &options, NULL);
        }
        return;
    }
    check_list(voxels);
    check_written(voxels);
    check_faces(voxels);
    check_copy(data, byte_count, &options, &info);
    svo_voxels_destroy(&voxels);
}

#ifdef FUZZ_ARCHIVE

static uint32_t checksum(const uint8_t *data, size_t count)
{
    uint32_t sum = 0xffffffffu;
    for (size_t i = 0; i < count; ++i) {
        sum ^= data[i];
        for (int bit = 0; bit < 8; ++bit) {
            sum = sum >> 1 ^ ((sum & 1u) != 0 ? 0xedb88320u : 0u);
        }
    }
    return ~sum;
}

static void put(bytes *to, uint32_t value, size_t count)
{
    append(to, &value, count);
}

/* The fields that the head of an entry and its place in the directory have in common. */
static void put_entry(bytes *to, const char *name, const uint8_t *data, size_t count)
{
    put(to, 20, 2);
    put(to, 0, 4); /* flags, stored */
    put(to, 0x210000, 4); /* time, date */
    put(to, checksum(data, count), 4);
    put(to, (uint32_t)count, 4);
    put(to, (uint32_t)count, 4);
    put(to, (uint32_t)strlen(name), 2);
}

static void run_archive(const uint8_t *data, size_t byte_count)
{
    static const char *const names[] = {"manifest.xml", "d/0.png"};
    const uint8_t *zero = memchr(data, 0, byte_count);
    const size_t manifest_bytes = zero != NULL ? (size_t)(zero - data) : byte_count;
    const uint8_t *parts[] = {data, zero != NULL ? zero + 1 : data};
    const size_t counts[] = {manifest_bytes, zero != NULL ? byte_count - manifest_bytes - 1 : 0};
    size_t offsets[2];
    bytes file = {NULL, 0};
    for (int i = 0; i < 2; ++i) {
        offsets[i] = file.count;
        put(&file, 0x04034b50, 4);
        put_entry(&file, names[i], parts[i], counts[i]);
        put(&file, 0, 2);
        append(&file, names[i], strlen(names[i]));
        if (counts[i] > 0) {
            append(&file, parts[i], counts[i]);
        }
    }
    const size_t directory = file.count;
    for (int i = 0; i < 2; ++i) {
        put(&file, 0x02014b50, 4);
        put(&file, 20, 2);
        put_entry(&file, names[i], parts[i], counts[i]);
        for (int word = 0; word < 3; ++word) {
            put(&file, 0, 4); /* extra, comment, disk, attributes */
        }
        put(&file, (uint32_t)offsets[i], 4);
        append(&file, names[i], strlen(names[i]));
    }
    const size_t directory_bytes = file.count - directory;
    put(&file, 0x06054b50, 4);
    put(&file, 0, 4);
    put(&file, 2, 2);
    put(&file, 2, 2);
    put(&file, (uint32_t)directory_bytes, 4);
    put(&file, (uint32_t)directory, 4);
    put(&file, 0, 2);
    run(file.data, file.count);
    free(file.data);
}

#endif

#ifdef FUZZ_RUNS

#define EXPANDED_MAX ((size_t)1 << 18)

static void run_expanded(const uint8_t *data, size_t byte_count)
{
    uint8_t *expanded = calloc(EXPANDED_MAX, 1);
    size_t used = 0;
    REQUIRE(expanded != NULL);
    for (size_t i = 0; i < byte_count && used < EXPANDED_MAX; ++i) {
        size_t count = 1;
        expanded[used] = data[i];
        if (data[i] == 0 && i + 1 < byte_count) {
            ++i;
            count += (size_t)data[i] * (data[i] + 1u) / 2;
        }
        used += count;
    }
    uint8_t *exact = malloc(used < EXPANDED_MAX ? used + 1 : EXPANDED_MAX + 1); /* a sanitizer sees a read behind it */
    used = used < EXPANDED_MAX ? used : EXPANDED_MAX;
    REQUIRE(exact != NULL);
    memcpy(exact + 1, expanded, used);
    free(expanded);
    run(exact + 1, used);
    free(exact);
}

#endif

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
#ifdef FUZZ_ARCHIVE
    if (byte_count > 0 && data[0] != 'P') {
        run_archive(data, byte_count);
        return 0;
    }
#endif
#ifdef FUZZ_RUNS
    run_expanded(data, byte_count);
#else
    run(data, byte_count);
#endif
    return 0;
}
