/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as a part file. They are refused with a one-line message, or they are stitched to a .svo
 * file, whose reader refuses it in turn or loads it.
 */
#define _GNU_SOURCE /* memfd_create */
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "fuzz.h"
#include "part_header.h"
#include "svocl/io.h"
#include "svocl/parts.h"

#define PATH_BYTES 64

/* A file in memory with these bytes. */
static int make_input(const uint8_t *data, size_t byte_count, char path[PATH_BYTES])
{
    const int file = memfd_create("part", 0);
    REQUIRE(file >= 0);
    REQUIRE(byte_count == 0 || write(file, data, byte_count) == (ssize_t)byte_count);
    (void)snprintf(path, PATH_BYTES, "/proc/self/fd/%d", file);
    return file;
}

static void check_message(const svo_message *message, const char *path)
{
    REQUIRE(strncmp(message->text, path, strlen(path)) == 0);
    REQUIRE(strchr(message->text, '\n') == NULL);
}

static void stitch(const svo_part_header *header, const char *path)
{
    char out[] = "/tmp/svocl-fuzz-part-XXXXXX";
    svo_message message = {""};
    svo_tree *tree = NULL;
    const int file = mkstemp(out);
    REQUIRE(file >= 0);
    (void)close(file);
    const svo_status status = svo_parts_stitch(header, &path, 1, NULL, out, &message);
    REQUIRE(status == SVO_OK || status == SVO_FILE_DAMAGED || status == SVO_CAPACITY_EXCEEDED);
    REQUIRE(status == SVO_OK || strchr(message.text, '\n') == NULL);
    if (status == SVO_OK) {
        const svo_status loaded = svo_tree_load(svo_from_path(out), NULL, &tree, &message);
        REQUIRE(loaded == SVO_OK || loaded == SVO_FILE_DAMAGED);
        svo_tree_destroy(&tree);
    }
    (void)unlink(out);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    char path[PATH_BYTES];
    svo_message message = {""};
    svo_part_info info = SVO_PART_INFO_INIT;
    const svo_part_header header = part_header();
    const int file = make_input(data, byte_count, path);
    const svo_status status = svo_part_check(&header, path, &info, &message);
    REQUIRE(status == SVO_OK || status == SVO_FILE_DAMAGED);
    if (status == SVO_OK) {
        REQUIRE(info.level < header.depth && info.code >> (3 * info.level) == 0 && info.file_bytes == byte_count);
        REQUIRE(info.leaf_count <= info.node_count);
        stitch(&header, path);
    } else {
        check_message(&message, path);
    }
    (void)close(file);
    return 0;
}
