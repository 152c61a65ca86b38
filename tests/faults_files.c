/* SPDX-License-Identifier: MIT */
/* Scenarios of test_faults: .svo files, imported meshes, saved kernels. */
#define _POSIX_C_SOURCE 200809L
#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "faults_scenario.h"

/*
 * Scenarios: files.
 */

void prepare_host_tree(subject *of)
{
    prepare_tree(of);
    if (svo_tree_download(of->tree, world.queue) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
}

static void digest_file(subject *of, const char *path)
{
    static char bytes[1 << 20];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t count = fread(bytes, 1, sizeof bytes, file);
    assert_int_equal(fclose(file), 0);
    digest(of, bytes, count);
}

svo_status run_save(subject *of)
{
    const svo_save_options packed = {.struct_size = sizeof packed, .compress = 1};
    SVO_I_TRY(svo_tree_save(of->tree, world.tree_path, NULL, &of->message));
    return svo_tree_save(of->tree, world.packed_path, &packed, &of->message);
}

/* After the run, when no call fails. */
static void digest_saved(subject *of)
{
    digest_file(of, world.tree_path);
    digest_file(of, world.packed_path);
}

static svo_status run_load(subject *of)
{
    const char *const paths[] = {world.tree_path, world.packed_path};
    for (size_t i = 0; i < 2; ++i) {
        svo_tree *tree = NULL;
        char hash[SVO_HASH_TEXT_BYTES] = "";
        svo_status status = svo_tree_load(paths[i], &tree, &of->message);
        if (status == SVO_OK) {
            status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
        }
        digest(of, hash, sizeof hash);
        svo_tree_destroy(&tree);
        SVO_I_TRY(status);
    }
    return SVO_OK;
}

static void prepare_loaded(subject *of)
{
    if (svo_tree_load(world.tree_path, &of->tree, &of->message) != SVO_OK) {
        fail_msg("%s", of->message.text);
    }
}

static svo_status run_upload(subject *of)
{
    TRY_TOLD(svo_tree_upload(of->tree, world.device, world.queue));
    return run_rays(of);
}

typedef struct byte_list {
    unsigned char bytes[1 << 18];
    size_t count;
} byte_list;

static int append_bytes(void *user, const void *bytes, size_t byte_count)
{
    byte_list *list = user;
    if (byte_count > sizeof list->bytes - list->count) {
        return 1;
    }
    memcpy(list->bytes + list->count, bytes, byte_count);
    list->count += byte_count;
    return 0;
}

/* Into memory and out of it. */
static svo_status run_memory(subject *of)
{
    static byte_list written;
    svo_tree *tree = NULL;
    char hash[SVO_HASH_TEXT_BYTES] = "";
    written.count = 0;
    SVO_I_TRY(svo_tree_write(of->tree, append_bytes, &written, NULL, &of->message));
    SVO_I_TRY(svo_tree_load_memory(written.bytes, written.count, world.tree_path, &tree, &of->message));
    const svo_status status = svo_tree_hash(tree, SVO_HASH_ALL, hash);
    digest(of, hash, sizeof hash);
    svo_tree_destroy(&tree);
    return status;
}

static void prepare_gltf(subject *of)
{
    of->mesh_path = world.gltf_path;
}

static void prepare_obj(subject *of)
{
    of->mesh_path = world.obj_path;
}

static void prepare_ply(subject *of)
{
    of->mesh_path = world.ply_path;
}

static void prepare_stl(subject *of)
{
    of->mesh_path = world.stl_path;
}

static void prepare_off(subject *of)
{
    of->mesh_path = world.off_path;
}

/* A texture that cannot be read is left out, with a warning. */
static void keep_warning(void *user, svo_log_level level, const char *text)
{
    subject *of = user;
    (void)level;
    (void)snprintf(of->warning, sizeof of->warning, "%s", text);
}

static svo_status run_import(subject *of)
{
    svo_import *import = NULL;
    const svo_import_options options = {.struct_size = sizeof options, .child_program = "/proc/self/exe"};
    const svo_status status = svo_import_file(of->mesh_path, &options, keep_warning, of, &import, &of->message);
    if (status == SVO_OK) {
        const svo_mesh *mesh = svo_import_mesh(import);
        digest(of, mesh->positions, mesh->vertex_count * 3 * sizeof(float));
        digest(of, mesh->indices, mesh->triangle_count * 3 * sizeof(uint32_t));
        digest(of, &mesh->material_count, sizeof mesh->material_count);
    }
    svo_import_destroy(&import);
    return status;
}

/*
 * Scenarios: saved kernels.
 */

void remove_kernels(void)
{
    DIR *entries = opendir(world.kernels_folder);
    for (const struct dirent *entry; entries != NULL && (entry = readdir(entries)) != NULL;) {
        char path[512];
        (void)snprintf(path, sizeof path, "%s/%.255s", world.kernels_folder, entry->d_name);
        if (entry->d_name[0] != '.') {
            (void)unlink(path);
        }
    }
    if (entries != NULL) {
        (void)closedir(entries);
    }
}

static svo_status run_save_kernels(subject *of)
{
    size_t saved = 0;
    faults_spare(true);
    remove_kernels();
    faults_spare(false);
    const svo_status status = svo_device_save_kernels(world.saver, world.kernels_folder, &saved);
    digest(of, &saved, sizeof saved);
    return told(of, world.saver, status);
}

/* A file that cannot be used is a warning. */
static svo_status run_load_kernels(subject *of)
{
    const svo_device_options options = {.struct_size = sizeof options, .log = keep_warning, .log_user = of};
    svo_device *device = NULL;
    size_t loaded = 0;
    SVO_I_TRY(svo_device_create(svo_device_cl_context(world.device), svo_device_cl_device(world.device), &options,
                                &device, &of->message));
    const svo_status status = svo_device_load_kernels(device, world.kernels_folder, &loaded);
    digest(of, &loaded, sizeof loaded);
    (void)told(of, device, status);
    svo_device_destroy(&device);
    return status;
}

static const scenario rows[] = {
    {"save", false, false, prepare_host_tree, run_save, digest_saved, destroy_all},
    {"load", false, false, prepare_nothing, run_load, NULL, destroy_all},
    {"upload", false, false, prepare_loaded, run_upload, NULL, destroy_all},
    {"import", false, false, prepare_obj, run_import, NULL, destroy_all},
    {"memory", false, false, prepare_host_tree, run_memory, NULL, destroy_all},
    {"import_gltf", false, true, prepare_gltf, run_import, NULL, destroy_all},
    {"import_obj", false, true, prepare_obj, run_import, NULL, destroy_all},
    {"import_ply", false, true, prepare_ply, run_import, NULL, destroy_all},
    {"import_stl", false, true, prepare_stl, run_import, NULL, destroy_all},
    {"import_off", false, true, prepare_off, run_import, NULL, destroy_all},
    {"save_kernels", false, false, prepare_nothing, run_save_kernels, NULL, destroy_all},
    {"load_kernels", false, false, prepare_nothing, run_load_kernels, NULL, destroy_all},
};
const scenario_list file_scenarios = {rows, sizeof rows / sizeof rows[0]};
