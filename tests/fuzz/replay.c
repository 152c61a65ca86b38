/* SPDX-License-Identifier: MIT */
/* Feeds every file of the given folders to a fuzz target: runs seeds and past findings as an ordinary test. */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <sys/stat.h>

#include "fuzz.h"

#define PATH_BYTES      4096
#define INPUT_BYTES_MAX ((size_t)1 << 20)

/* Runs an input from an allocation of exactly its size, so that a sanitizer detects a read past its end. */
static int replay_file(const char *path)
{
    static uint8_t buffer[INPUT_BYTES_MAX];
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        (void)fprintf(stderr, "%s: cannot be read\n", path);
        return 1;
    }
    const size_t byte_count = fread(buffer, 1, sizeof buffer, file);
    (void)fclose(file);
    uint8_t *data = malloc(byte_count > 0 ? byte_count : 1);
    REQUIRE(data != NULL);
    for (size_t i = 0; i < byte_count; ++i) {
        data[i] = buffer[i];
    }
    printf("%s: %zu bytes\n", path, byte_count);
    (void)fflush(stdout); /* the last line before a crash names the input */
    (void)LLVMFuzzerTestOneInput(data, byte_count);
    free(data);
    return 0;
}

/* Returns how many inputs could not be read; adds the number of all inputs to *count. */
static int replay_folder(const char *folder, int *count)
{
    DIR *directory = opendir(folder);
    if (directory == NULL) {
        (void)fprintf(stderr, "%s: cannot be read\n", folder);
        return 1;
    }
    int failed = 0;
    for (const struct dirent *entry = readdir(directory); entry != NULL; entry = readdir(directory)) {
        char path[PATH_BYTES];
        struct stat status;
        (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (stat(path, &status) == 0 && S_ISREG(status.st_mode)) {
            failed += replay_file(path);
            ++*count;
        }
    }
    (void)closedir(directory);
    return failed;
}

int main(int argc, char **argv)
{
    int failed = 0;
    int count = 0;
    for (int i = 1; i < argc; ++i) {
        failed += replay_folder(argv[i], &count);
    }
    printf("%d inputs\n", count);
    return failed == 0 && count > 0 ? 0 : 1;
}
