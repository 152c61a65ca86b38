/* SPDX-License-Identifier: MIT */
/*
 * A program for another system than the tests' (`tools/dev cross`): an octree, whose kernels are saved in the folder
 * argv[1], a damaged file of them saved anew, and all of them loaded. Prints the tree's hash. It calls only C11 and
 * what MinGW has of POSIX.
 */
#include <dirent.h>
#include <stdio.h>
#include <string.h>

#include "svocl/svocl.h"

static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const uint32_t indices[] = {0, 1, 2};

static svo_status build(svo_device *device, char hash[SVO_HASH_TEXT_BYTES])
{
    svo_mesh mesh = SVO_MESH_INIT;
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    mesh.positions = positions;
    mesh.vertex_count = 3;
    mesh.indices = indices;
    mesh.triangle_count = 1;
    svo_status status = svo_plan_create(device, &mesh, 5, NULL, &plan);
    if (status == SVO_OK) {
        status = svo_build(plan, NULL, NULL, &tree, NULL);
    }
    if (status == SVO_OK) {
        status = svo_tree_download(tree, NULL);
    }
    if (status == SVO_OK) {
        status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
    }
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return status;
}

/* Writes one byte over a file of the folder. */
static int damage(const char *folder)
{
    char path[512] = "";
    DIR *entries = opendir(folder);
    for (const struct dirent *entry = entries != NULL ? readdir(entries) : NULL; entry != NULL && path[0] == '\0';
         entry = readdir(entries)) {
        if (strstr(entry->d_name, ".kernels") != NULL) {
            (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        }
    }
    if (entries != NULL) {
        closedir(entries);
    }
    FILE *file = path[0] != '\0' ? fopen(path, "r+b") : NULL;
    const int written = file != NULL && fputc('x', file) == 'x';
    return file != NULL && fclose(file) == 0 && written;
}

static int fail(const char *what, svo_device *device)
{
    fprintf(stderr, "saved_kernels: %s: %s\n", what, device != NULL ? svo_device_message(device) : "");
    return 1;
}

int main(int argc, char **argv)
{
    svo_message message = {""};
    svo_device *first = NULL;
    svo_device *second = NULL;
    char hash[SVO_HASH_TEXT_BYTES] = "";
    size_t saved = 0;
    size_t again = 1;
    size_t repaired = 0;
    size_t loaded = 0;
    if (argc != 2 || svo_device_create_default(NULL, &first, &message) != SVO_OK ||
        svo_device_create_default(NULL, &second, &message) != SVO_OK) {
        return fail(argc != 2 ? "the folder is missing" : message.text, NULL);
    }
    if (build(first, hash) != SVO_OK || svo_device_save_kernels(first, argv[1], &saved) != SVO_OK || saved == 0) {
        return fail("nothing was saved", first);
    }
    if (svo_device_save_kernels(first, argv[1], &again) != SVO_OK || again != 0) {
        return fail("what was there was saved again", first);
    }
    if (!damage(argv[1]) || svo_device_save_kernels(first, argv[1], &repaired) != SVO_OK || repaired != 1) {
        return fail("a damaged file was not replaced", first);
    }
    if (svo_device_load_kernels(second, argv[1], &loaded) != SVO_OK || loaded != saved) {
        return fail("not everything was loaded", second);
    }
    svo_device_destroy(&second);
    svo_device_destroy(&first);
    printf("%s\n", hash);
    return 0;
}
