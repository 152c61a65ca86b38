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
#include "support/info_of.h"
#include "svocl/paged.h"
#include "svocl/parts.h"
#include "svocl/parts_tree.h"

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
    SVO_I_TRY(svo_tree_save(of->tree, svo_to_path(world.tree_path), NULL, &of->message));
    return svo_tree_save(of->tree, svo_to_path(world.packed_path), &packed, &of->message);
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
        svo_status status = svo_tree_load(svo_from_path(paths[i]), NULL, &tree, &of->message);
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
    if (svo_tree_load(svo_from_path(world.tree_path), NULL, &of->tree, &of->message) != SVO_OK) {
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
    SVO_I_TRY(svo_tree_save(of->tree, svo_to_callback(append_bytes, &written), NULL, &of->message));
    SVO_I_TRY(svo_tree_load(svo_from_memory(written.bytes, written.count, world.tree_path), NULL, &tree, &of->message));
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
    const svo_import_options options = {.struct_size = sizeof options, .child_program = "/proc/self/exe", .weld = 1e-9};
    const svo_status status = svo_import_file(of->mesh_path, &options, keep_warning, of, &import, &of->message);
    if (status == SVO_OK) {
        const svo_mesh *mesh = svo_import_mesh(import);
        digest(of, mesh->positions, mesh->vertex_count * 3 * sizeof(float));
        digest(of, mesh->indices, mesh->triangle_count * 3 * sizeof(uint32_t));
        digest(of, &mesh->material_count, sizeof mesh->material_count);
        size_t file_vertex_count = 0;
        const uint32_t *file_vertices = svo_import_file_vertices(import, &file_vertex_count);
        digest(of, file_vertices, file_vertex_count * sizeof *file_vertices);
        for (size_t i = 0; svo_import_file_path(import, i) != NULL; ++i) {
            digest(of, &i, sizeof i);
        }
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
    SVO_I_TRY(svo_device_create(info_of_device(world.device).context, info_of_device(world.device).device, &options,
                                &device, &of->message));
    const svo_status status = svo_device_load_kernels(device, world.kernels_folder, &loaded);
    digest(of, &loaded, sizeof loaded);
    (void)told(of, device, status);
    svo_device_destroy(&device);
    return status;
}

/*
 * Voxels: lists, their trees and files.
 */

/* A file in memory. */
typedef struct voxel_bytes {
    uint8_t bytes[1 << 18];
    size_t count;
} voxel_bytes;

static int put_voxel_bytes(void *user, const void *bytes, size_t byte_count)
{
    voxel_bytes *to = user;
    if (byte_count > sizeof to->bytes - to->count) {
        return 1;
    }
    memcpy(to->bytes + to->count, bytes, byte_count);
    to->count += byte_count;
    return 0;
}

/* Writes a list in one format, and reads it again. */
static svo_status write_and_read(subject *of, const svo_voxels *voxels, svo_voxel_format format)
{
    static voxel_bytes file;
    svo_voxels *again = NULL;
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    file.count = 0;
    SVO_I_TRY(svo_voxels_save(voxels, svo_to_callback(put_voxel_bytes, &file), format, NULL, &of->message));
    digest(of, file.bytes, file.count);
    SVO_I_TRY(
        svo_voxels_load(svo_from_memory(file.bytes, file.count, world.vox_path), NULL, &again, NULL, &of->message));
    (void)svo_voxels_get_info(again, &info);
    digest(of, svo_voxels_get(again), info.voxel_count * sizeof(svo_voxel));
    svo_voxels_destroy(&again);
    return SVO_OK;
}

static svo_status take_part(void *user, const svo_voxel_part *part)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    (void)svo_voxels_get_info(part->voxels, &info);
    digest(user, svo_voxels_get(part->voxels), info.voxel_count * sizeof(svo_voxel));
    digest(user, part->transforms, part->transform_count * 12 * sizeof *part->transforms);
    return SVO_OK;
}

static svo_status use_voxels(subject *of, const svo_voxels *voxels)
{
    svo_voxels *again = NULL;
    SVO_I_TRY(write_and_read(of, voxels, SVO_VOXEL_FORMAT_VOX));
    SVO_I_TRY(write_and_read(of, voxels, SVO_VOXEL_FORMAT_BINVOX));
    for (int i = 0; i < 2; ++i) { /* what builds may leave out */
        const svo_status status = write_and_read(of, voxels, i == 0 ? SVO_VOXEL_FORMAT_SVX : SVO_VOXEL_FORMAT_VDB);
        if (status != SVO_OK && status != SVO_UNSUPPORTED) {
            return status;
        }
    }
    SVO_I_TRY(svo_voxels_save(voxels, svo_to_path(world.vox_path), SVO_VOXEL_FORMAT_AUTO, NULL, &of->message));
    SVO_I_TRY(svo_voxels_load(svo_from_path(world.vox_path), NULL, &again, NULL, &of->message));
    svo_voxels_destroy(&again);
    SVO_I_TRY(svo_voxels_load_parts(svo_from_path(world.vox_path), NULL, take_part, of, NULL, &of->message));
    return svo_voxels_copy_vox(svo_from_path(world.vox_path), svo_to_path(world.vox_path), NULL, NULL, &of->message);
}

/* A list, its tree and files. */
static svo_status run_voxels(subject *of)
{
    static const svo_voxel_property property = {9, "_type", "_glass"};
    svo_voxel given[TRIANGLES];
    svo_voxels *voxels = NULL, *again = NULL;
    svo_tree *tree = NULL;
    for (int i = 0; i < TRIANGLES; ++i) {
        given[i] = (svo_voxel){.x = i % 4, .y = i * 7 % 5, .z = i % 3, .rgba = {(uint8_t)i, 1, 2, 255}, .material = 9};
    }
    const svo_voxels_source source = {.struct_size = sizeof source,
                                      .voxels = given,
                                      .voxel_count = TRIANGLES,
                                      .properties = &property,
                                      .property_count = 1};
    svo_status status = svo_voxels_create(&source, &voxels, &of->message);
    if (status == SVO_OK) {
        status = use_voxels(of, voxels);
    }
    if (status == SVO_OK) {
        status = told(of, world.device, svo_voxels_build(world.device, voxels, 0, NULL, world.queue, &tree, NULL));
    }
    if (status == SVO_OK) {
        status = told(of, world.device, digest_tree(of, tree));
    }
    if (status == SVO_OK) {
        status = svo_tree_get_voxels(tree, &again, &of->message);
    }
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&again);
    svo_voxels_destroy(&voxels);
    return status;
}

/* ---- surfaces ---- */

/* A ball with the colors of the tree, as a mesh file. */
static svo_status run_surface(subject *of)
{
    enum { SIDE = 7 };
    float distances[SIDE * SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE * SIDE; ++i) {
        const int x = i % SIDE - 3, y = i / SIDE % SIDE - 3, z = i / SIDE / SIDE - 3;
        distances[i] = (float)(x * x + y * y + z * z) - 6.5F;
    }
    const svo_surface_field field = {.struct_size = sizeof field,
                                     .distances = distances,
                                     .voxel_count = SIDE * SIDE * SIDE,
                                     .size = {SIDE, SIDE, SIDE},
                                     .spacing = 0.1};
    const svo_surface_options options = {
        .struct_size = sizeof options, .parts = SVO_SURFACE_NORMALS | SVO_SURFACE_COLORS, .tree = of->tree};
    svo_surface *surface = NULL;
    SVO_I_TRY(svo_surface_create(&field, &options, &surface, &of->message));
    const svo_status status =
        svo_mesh_save(svo_surface_get_mesh(surface), svo_to_path(world.vox_path), SVO_MESH_FORMAT_GLB, &of->message);
    svo_surface_destroy(&surface);
    return status;
}

static void digest_surface(subject *of)
{
    digest_file(of, world.vox_path);
}

/* ---- parts ---- */

#define PART_BYTES 500000

/* The folder as a tree: hash and check of the whole, levels above the leaves to a tree and to a file. */
static svo_status read_parts_tree(subject *of, const char *path)
{
    char folder[128], hash[SVO_HASH_TEXT_BYTES];
    svo_parts_tree *tree = NULL;
    svo_parts_tree_info info = SVO_PARTS_TREE_INFO_INIT;
    svo_parts_region region = SVO_PARTS_REGION_INIT;
    svo_tree *upper = NULL;
    svo_status status = SVO_OK;
    region.last_level = DEPTH - 1;
    (void)snprintf(folder, sizeof folder, "%s/parts", world.folder);
    SVO_I_TRY_CLEANUP(svo_parts_tree_open(folder, &tree, &of->message));
    SVO_I_TRY_CLEANUP(svo_parts_tree_get_info(tree, &info, &of->message));
    SVO_I_TRY_CLEANUP(svo_parts_tree_hash(tree, SVO_HASH_ALL, hash, &of->message));
    SVO_I_TRY_CLEANUP(svo_parts_tree_check(tree, 1, 0, NULL, &of->message));
    SVO_I_TRY_CLEANUP(svo_parts_tree_load(tree, &region, &upper, &of->message));
    SVO_I_TRY_CLEANUP(svo_parts_tree_save(tree, &region, svo_to_path(path), NULL, &of->message));
    faults_spare(true);
    assert_int_equal(unlink(path), 0);
    faults_spare(false);
cleanup:
    svo_tree_destroy(&upper);
    svo_parts_tree_close(&tree);
    return status;
}

static svo_status build_parts(subject *of, const svo_parts *parts)
{
    char path[128];
    (void)snprintf(path, sizeof path, "%s/parts.svo", world.folder);
    for (size_t i = 0; i < svo_parts_count(parts); ++i) {
        SVO_I_TRY(svo_parts_build(parts, i, world.device, world.cl, world.queue, &of->message));
    }
    SVO_I_TRY(svo_parts_finish(parts, path, &of->message));
    faults_spare(true);
    assert_int_equal(unlink(path), 0);
    faults_spare(false);
    SVO_I_TRY(read_parts_tree(of, path));
    SVO_I_TRY(svo_parts_shares_begin(parts, 2, &of->message));
    SVO_I_TRY(svo_parts_shares_write(parts, 1, 2, &of->message));
    SVO_I_TRY(svo_parts_shares_write(parts, 0, 2, &of->message));
    return svo_parts_shares_finish(parts, 2, path, &of->message);
}

/* Adds the stitched file to the digest and removes it; no call fails meanwhile. */
static void digest_parts(subject *of)
{
    char path[128];
    (void)snprintf(path, sizeof path, "%s/parts.svo", world.folder);
    faults_spare(true);
    digest_file(of, path);
    assert_int_equal(unlink(path), 0);
    faults_spare(false);
}

/* Does a task of a planning, and gives its result back. */
static svo_status plan_range(subject *of, svo_parts_planning *planning, size_t index)
{
    const void *task = NULL;
    void *result = NULL;
    size_t task_bytes = 0;
    size_t result_bytes = 0;
    SVO_I_TRY(svo_parts_planning_task(planning, index, &task, &task_bytes, &of->message));
    SVO_I_TRY(svo_parts_planning_work(world.device, task, task_bytes, &result, &result_bytes, &of->message));
    const svo_status status = svo_parts_planning_take(planning, index, result, result_bytes, &of->message);
    svo_parts_planning_free(result);
    return status;
}

/* Plans a file in two ranges. */
static svo_status plan_ranges(subject *of, const svo_plan_options *options, const char *folder, uint64_t max_bytes)
{
    svo_parts_planning *planning = NULL;
    size_t count = 0;
    svo_status status = SVO_OK;
    SVO_I_TRY(svo_parts_planning_begin(world.device, of->mesh_path, DEPTH, options, max_bytes, folder, 2, &planning,
                                       &of->message));
    do {
        SVO_I_TRY_CLEANUP(svo_parts_planning_tasks(planning, &count, &of->message));
        for (size_t i = 0; i < count; ++i) {
            SVO_I_TRY_CLEANUP(plan_range(of, planning, i));
        }
    } while (count > 0);
    status = svo_parts_planning_finish(planning, &of->message);
cleanup:
    svo_parts_planning_end(&planning);
    return status;
}

/* Fills the folder from the mesh in memory, with rays and all else, or from its file where there is one: with all that
   blocks of a file can have, by ranges where they are facets. */
static svo_status create_parts(subject *of, const char *folder, uint64_t max_bytes)
{
    static const svo_plan_options of_blocks = {.struct_size = sizeof of_blocks,
                                               .need = (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_MATERIAL |
                                                       (uint32_t)SVO_NEED_FILL};
    if (of->mesh_path != NULL && strstr(of->mesh_path, ".stl") != NULL) {
        return plan_ranges(of, &of_blocks, folder, max_bytes);
    }
    return of->mesh_path == NULL
               ? svo_parts_create(world.device, &world.mesh.mesh, DEPTH, &everything, max_bytes, folder, &of->message)
               : svo_parts_create_from_file(world.device, of->mesh_path, DEPTH, &of_blocks, max_bytes, folder,
                                            &of->message);
}

static svo_status run_parts_of(subject *of, uint64_t max_bytes)
{
    char folder[128];
    char identity[SVO_PARTS_IDENTITY_BYTES];
    svo_parts *parts = NULL;
    svo_parts_lease *lease = NULL;
    svo_status status = SVO_OK;
    (void)snprintf(folder, sizeof folder, "%s/parts", world.folder);
    SVO_I_TRY_CLEANUP(svo_parts_lease_take(folder, &lease, &of->message));
    SVO_I_TRY_CLEANUP(create_parts(of, folder, max_bytes));
    SVO_I_TRY_CLEANUP(svo_parts_lease_renew(lease, &of->message));
    SVO_I_TRY_CLEANUP(svo_parts_open(folder, &parts, &of->message));
    SVO_I_TRY_CLEANUP(svo_parts_get_identity(parts, identity, &of->message));
    SVO_I_TRY_CLEANUP(build_parts(of, parts));
    digest_parts(of);
    status = svo_parts_remove(folder, &of->message);
cleanup:
    svo_parts_close(&parts);
    svo_parts_lease_release(&lease);
    return status;
}

/* Plans, builds and stitches the tree in parts, and removes their folder. */
static svo_status run_parts(subject *of)
{
    return run_parts_of(of, PART_BYTES);
}

/* A part is split when memory runs out; the handle keeps the kernels that smaller parts need. */
static void prepare_parts(subject *of)
{
    static bool is_done = false;
    uint64_t max_bytes = PART_BYTES;
    while (!is_done && run_parts_of(of, max_bytes) == SVO_OK) {
        max_bytes /= 2;
    }
    is_done = true;
}

/* The same kernels, for a file of the folder. */
static void prepare_parts_of_file(subject *of, const char *name)
{
    static char path[128];
    uint64_t max_bytes = PART_BYTES;
    (void)snprintf(path, sizeof path, "%s/%s", world.folder, name);
    of->mesh_path = path;
    while (run_parts_of(of, max_bytes) == SVO_OK) {
        max_bytes /= 2;
    }
}

static void prepare_parts_of_ply(subject *of)
{
    prepare_parts_of_file(of, "b.ply");
}

static void prepare_parts_of_stl(subject *of)
{
    prepare_parts_of_file(of, "b.stl");
}

/* ---- pages ---- */

#define PAGED_PICTURES 4

static uint64_t paged_bytes; /* not enough for all pages */

static svo_status open_paged(uint64_t budget_bytes, svo_paged **out)
{
    const svo_paged_options options = {.struct_size = sizeof options, .page_levels = 2};
    return svo_paged_open(world.device, world.tree_path, budget_bytes, &options, out);
}

static void prepare_paged(subject *of)
{
    svo_paged_info info = SVO_PAGED_INFO_INIT;
    svo_paged *paged = NULL;
    (void)of;
    assert_int_equal(open_paged(UINT64_MAX, &paged), SVO_OK);
    assert_int_equal(svo_paged_get_info(paged, &info), SVO_OK);
    svo_paged_close(&paged);
    paged_bytes = info.whole_bytes * 3 / 4;
}

/* Draws and updates from several sides. An update that fails may be repeated. */
static svo_status fly_paged(subject *of, svo_paged *paged)
{
    static uint8_t rgba[PICTURE_SIDE * PICTURE_SIDE * 4];
    svo_render_options options = {.struct_size = sizeof options,
                                  .width = PICTURE_SIDE,
                                  .height = PICTURE_SIDE,
                                  .camera = {{0, 0, 0}, {0.5F, 0.5F, 0.5F}, {0, 1, 0}, 0.7F}};
    svo_paged_counts counts = SVO_PAGED_COUNTS_INIT;
    for (int i = 0; i < PAGED_PICTURES; ++i) {
        options.camera.eye[0] = i % 2 == 0 ? -1.5F : 2.5F;
        options.camera.eye[2] = i < 2 ? 3.0F : -2.0F;
        TRY_TOLD(svo_paged_render(paged, &options, rgba));
        digest(of, rgba, sizeof rgba);
        const svo_status status = told(of, world.device, svo_paged_update(paged));
        if (status != SVO_OK) {
            faults_spare(true);
            assert_int_equal(svo_paged_update(paged), SVO_OK);
            assert_int_equal(svo_paged_render(paged, &options, rgba), SVO_OK);
            faults_spare(false);
            return status;
        }
    }
    (void)svo_paged_get_counts(paged, &counts);
    digest(of, &counts, sizeof counts);
    return counts.all_read_pages > 0 ? SVO_OK : SVO_INTERNAL;
}

static svo_status run_paged(subject *of)
{
    svo_paged *paged = NULL;
    TRY_TOLD(open_paged(paged_bytes, &paged));
    const svo_status status = fly_paged(of, paged);
    svo_paged_close(&paged);
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
    {"voxels", false, false, prepare_nothing, run_voxels, NULL, destroy_all},
    {"surface", false, false, prepare_host_tree, run_surface, digest_surface, destroy_all},
    {"parts", false, false, prepare_parts, run_parts, NULL, destroy_all},
    {"parts_of_ply", false, false, prepare_parts_of_ply, run_parts, NULL, destroy_all},
    {"parts_of_stl", false, false, prepare_parts_of_stl, run_parts, NULL, destroy_all},
    {"paged", false, false, prepare_paged, run_paged, NULL, destroy_all},
    {"save_kernels", false, false, prepare_nothing, run_save_kernels, NULL, destroy_all},
    {"load_kernels", false, false, prepare_nothing, run_load_kernels, NULL, destroy_all},
};
const scenario_list file_scenarios = {rows, sizeof rows / sizeof rows[0]};
