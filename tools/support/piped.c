/* SPDX-License-Identifier: MIT */
/* Reads a pipe to its end and tells mesh formats apart. */
#include "support/piped.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "output/output.h"

#define FIRST_BYTES      ((size_t)1 << 20)
#define STL_HEADER_BYTES 84 /* 80 of text, 4 of the count */
#define STL_RECORD_BYTES 50

bool piped_is_standard_input(const char *path)
{
    return strcmp(path, "-") == 0 || svo_i_output_descriptor_of(path) == STDIN_FILENO;
}

/* ---- formats ---- */

static bool begins_with(const piped_input *piped, const char *text)
{
    const size_t length = strlen(text);
    return piped->byte_count >= length && memcmp(piped->bytes, text, length) == 0;
}

/* "OFF" after the letters for texture coordinates, colors, normals and dimensions. */
static bool is_off(const piped_input *piped)
{
    size_t at = begins_with(piped, "ST") ? 2 : 0;
    static const char letters[] = "CN4n";
    for (size_t i = 0; i < sizeof letters - 1 && at < piped->byte_count; ++i) {
        at += piped->bytes[at] == letters[i];
    }
    return piped->byte_count >= at + 3 && memcmp(piped->bytes + at, "OFF", 3) == 0;
}

/* A binary STL file is as long as its count says; a text one begins with "solid". */
static bool is_stl(const piped_input *piped)
{
    uint32_t count = 0;
    if (piped->byte_count >= STL_HEADER_BYTES) {
        const unsigned char *bytes = (const unsigned char *)piped->bytes + STL_HEADER_BYTES - 4;
        count = (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
        if (piped->byte_count == STL_HEADER_BYTES + (uint64_t)count * STL_RECORD_BYTES) {
            return true;
        }
    }
    return begins_with(piped, "solid");
}

static const char *next_line(const char *line, const char *end)
{
    const char *newline = memchr(line, '\n', (size_t)(end - line));
    return newline != NULL ? newline + 1 : end;
}

static bool line_has_word(const char *line, const char *end, const char *word)
{
    const size_t length = strlen(word);
    return (size_t)(end - line) > length && memcmp(line, word, length) == 0 && isspace((unsigned char)line[length]);
}

/* The first line that is neither empty nor a comment begins with a keyword of OBJ. */
static bool is_obj(const piped_input *piped)
{
    static const char *const words[] = {"v", "vn", "vt", "f", "o", "g", "s", "usemtl", "mtllib"};
    const char *end = piped->bytes + piped->byte_count;
    const char *line = piped->bytes;
    while (line < end && (isspace((unsigned char)*line) || *line == '#')) {
        line = *line == '#' ? next_line(line, end) : line + 1;
    }
    for (size_t i = 0; i < sizeof words / sizeof words[0]; ++i) {
        if (line_has_word(line, end, words[i])) {
            return true;
        }
    }
    return false;
}

static bool has_material_library(const piped_input *piped)
{
    const char *end = piped->bytes + piped->byte_count;
    for (const char *line = piped->bytes; line < end; line = next_line(line, end)) {
        if (line_has_word(line, end, "mtllib")) {
            return true;
        }
    }
    return false;
}

static bool is_gltf_text(const piped_input *piped)
{
    size_t at = 0;
    while (at < piped->byte_count && isspace((unsigned char)piped->bytes[at])) {
        ++at;
    }
    return at < piped->byte_count && piped->bytes[at] == '{';
}

const char *piped_judge(piped_input *piped)
{
    piped->suffix = begins_with(piped, "\x89SVO")                                ? ".svo"
                    : begins_with(piped, "\x89SVC")                              ? ".svc"
                    : begins_with(piped, "ply\n") || begins_with(piped, "ply\r") ? ".ply"
                    : begins_with(piped, "glTF")                                 ? ".glb"
                    : begins_with(piped, "VOX ")                                 ? ".vox"
                    : begins_with(piped, "#binvox")                              ? ".binvox"
                    : begins_with(piped, "PK\3\4")                               ? ".svx"
                    : begins_with(piped, "NanoVDB")                              ? ".nvdb"
                    : begins_with(piped, " BDV")                                 ? ".vdb"
                    : begins_with(piped, "# Octomap OcTree binary file")         ? ".bt"
                    : begins_with(piped, "LASF")                                 ? ".las"
                    : is_off(piped)                                              ? ".off"
                    : is_stl(piped)                                              ? ".stl"
                    : is_obj(piped)                                              ? ".obj"
                                                                                 : NULL;
    if (piped->byte_count == 0) {
        return "nothing came in";
    }
    if (piped->suffix == NULL) {
        return is_gltf_text(piped) ? "glTF in several files cannot come through a pipe, binary glTF can"
                                   : "this format cannot come through a pipe; .svo, PLY, STL, OFF, binary glTF, OBJ "
                                     "without materials and voxel files can";
    }
    if (strcmp(piped->suffix, ".obj") == 0 && has_material_library(piped)) {
        return "OBJ with a file of materials (mtllib) beside it cannot come through a pipe";
    }
    return NULL;
}

/* ---- reading ---- */

/* Returns 0 or the errno. */
static int read_all(int descriptor, piped_input *piped)
{
    size_t capacity = 0;
    for (;;) {
        if (piped->byte_count == capacity) {
            const size_t larger = capacity == 0 ? FIRST_BYTES : 2 * capacity;
            char *bytes = larger > capacity ? realloc(piped->bytes, larger) : NULL;
            if (bytes == NULL) {
                return ENOMEM;
            }
            piped->bytes = bytes;
            capacity = larger;
        }
        const ssize_t got = read(descriptor, piped->bytes + piped->byte_count, capacity - piped->byte_count);
        if (got == 0) {
            return 0;
        }
        if (got < 0 && errno != EINTR) {
            return errno;
        }
        piped->byte_count += got > 0 ? (size_t)got : 0;
    }
}

bool piped_is_stream(const char *path)
{
    struct stat status;
    return strcmp(path, "-") == 0 || svo_i_output_descriptor_of(path) >= 0 ||
           (stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode));
}

int piped_read(const char *path, piped_input *piped)
{
    const bool standard = piped_is_standard_input(path);
    piped->name = standard ? "standard input" : path;
    const int descriptor = standard ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (descriptor < 0) {
        return errno;
    }
    const int error = read_all(descriptor, piped);
    if (!standard) {
        (void)close(descriptor);
    }
    return error;
}

bool piped_is(const piped_input *piped, const char *path)
{
    return piped->name != NULL && path == piped->name;
}

svo_source piped_source(const piped_input *piped, const char *path)
{
    return piped_is(piped, path) ? svo_from_memory(piped->bytes, piped->byte_count, path) : svo_from_path(path);
}

void piped_release_bytes(piped_input *piped)
{
    free(piped->bytes);
    piped->bytes = NULL;
}

void piped_free(piped_input *piped)
{
    piped_release_bytes(piped);
    *piped = (piped_input){0};
}
