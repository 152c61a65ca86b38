/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as the file "plan" of a folder of parts. It is refused with a one-line message, or its
 * parts can be listed, none is built, and the tree without them is refused or written. The first byte says whether
 * lengths, identity and checksum are made right, as they are in a file that somebody has made up.
 */
#define _POSIX_C_SOURCE 200809L
#include <string.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "fuzz.h"
#include "parts/part_file.h"
#include "svocl/parts.h"
#include "svocl/parts_tree.h"

/* Of lib/parts/folder.c: a magic, the hash of what follows it, version, fields, length, ... identity and header. */
#define HASH_AT     8u
#define VERSION_AT  16u
#define LENGTH_AT   24u
#define IDENTITY_AT 64u
#define HEADER_AT   80u
#define HEAD_BYTES  (HEADER_AT + sizeof(svo_part_header))
#define VERSION     4u

static void repair(uint8_t *data, size_t byte_count)
{
    static const uint8_t magic[HASH_AT] = {0x89, 'S', 'V', 'L', '\r', '\n', 0x1a, '\n'};
    const uint64_t length = byte_count;
    const uint32_t version = VERSION;
    svo_part_header header;
    uint64_t identity[2];
    memcpy(&header, data + HEADER_AT, sizeof header);
    svo_i_part_identity(&header, identity);
    memcpy(data, magic, sizeof magic);
    memcpy(data + VERSION_AT, &version, sizeof version);
    memcpy(data + LENGTH_AT, &length, sizeof length);
    memcpy(data + IDENTITY_AT, identity, sizeof identity);
    const uint64_t hash = XXH3_64bits(data + VERSION_AT, byte_count - VERSION_AT);
    memcpy(data + HASH_AT, &hash, sizeof hash);
}

static void check_parts(const svo_parts *parts, const char *out)
{
    char identity[SVO_PARTS_IDENTITY_BYTES];
    svo_part_header header = SVO_PART_HEADER_INIT;
    svo_message message = {""};
    REQUIRE(svo_parts_get_header(parts, &header, &message) == SVO_OK);
    REQUIRE(svo_parts_get_identity(parts, identity, &message) == SVO_OK && strlen(identity) == 32);
    for (size_t i = 0; i < svo_parts_count(parts) && i < 4; ++i) {
        svo_parts_entry entry = SVO_PARTS_ENTRY_INIT;
        int is_built = 1;
        REQUIRE(svo_parts_get(parts, i, &entry, &message) == SVO_OK);
        REQUIRE(svo_parts_is_built(parts, i, &is_built, &message) == SVO_OK && is_built == 0);
    }
    const svo_status status = svo_parts_finish(parts, out, &message);
    REQUIRE(status == SVO_OK || (message.text[0] != '\0' && strchr(message.text, '\n') == NULL));
    (void)unlink(out);
}

/* The folder as a tree: refused, or hashed and loaded, or these are refused. */
static void read_tree(const char *folder)
{
    char hash[SVO_HASH_TEXT_BYTES];
    svo_parts_tree *parts = NULL;
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_tree *tree = NULL;
    svo_message message = {""};
    svo_status status = svo_parts_tree_open(folder, &parts, &message);
    if (status == SVO_OK) {
        REQUIRE(svo_parts_tree_get_info(parts, &info, &message) == SVO_OK && info.part_count == 0);
        REQUIRE(svo_parts_tree_hash(parts, SVO_HASH_ALL, hash, &message) == SVO_OK);
        status = svo_parts_tree_load(parts, NULL, &tree, &message);
    }
    REQUIRE(status == SVO_OK || (message.text[0] != '\0' && strchr(message.text, '\n') == NULL));
    svo_tree_destroy(&tree);
    svo_parts_tree_close(&parts);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    static char folder[] = "/tmp/svocl-fuzz-plan-XXXXXX";
    static char path[64], out[64];
    if (path[0] == '\0') {
        REQUIRE(mkdtemp(folder) != NULL);
        (void)snprintf(path, sizeof path, "%s/plan", folder);
        (void)snprintf(out, sizeof out, "%s.svo", folder);
    }
    svo_parts *parts = NULL;
    svo_message message = {""};
    if (byte_count == 0) {
        return 0;
    }
    uint8_t *copy = malloc(byte_count);
    REQUIRE(copy != NULL);
    memcpy(copy, data, byte_count);
    if (data[0] % 8 != 0 && byte_count >= HEAD_BYTES) {
        repair(copy, byte_count);
    }
    FILE *file = fopen(path, "wb");
    REQUIRE(file != NULL && fwrite(copy, 1, byte_count, file) == byte_count && fclose(file) == 0);
    const svo_status status = svo_parts_open(folder, &parts, &message);
    if (status == SVO_OK) {
        check_parts(parts, out);
        read_tree(folder);
    } else {
        REQUIRE(status == SVO_FILE_DAMAGED || status == SVO_OUT_OF_HOST_MEMORY);
        REQUIRE(strncmp(message.text, folder, strlen(folder)) == 0 && strchr(message.text, '\n') == NULL);
    }
    svo_parts_close(&parts);
    (void)unlink(path);
    (void)rmdir(folder);
    path[0] = '\0';
    memcpy(folder + sizeof folder - 7, "XXXXXX", 6);
    free(copy);
    return 0;
}
