/* SPDX-License-Identifier: MIT */
/* Pins of voxels, files and trees in parts. */
#define _POSIX_C_SOURCE 200809L
#include "pins.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/work_folder.h"
#include "svocl/compact.h"
#include "svocl/edit.h"
#include "svocl/io.h"
#include "svocl/parts.h"
#include "svocl/voxel_files.h"

#define PATH_BYTES  512
#define PARTS_BYTES 3000000 /* memory for a part: makes several of each scene */
#define VOXELS      1500 /* that are given; some are in one place */
#define ALL_NEEDS                                                                                                   \
    ((uint32_t)SVO_NEED_COLOR | (uint32_t)SVO_NEED_NORMAL | (uint32_t)SVO_NEED_RAYS | (uint32_t)SVO_NEED_MATERIAL | \
     (uint32_t)SVO_NEED_FILL | (uint32_t)SVO_NEED_PROJECTED_AREA)

/* Of calls without a handle. */
static void told(svo_status status, const svo_message *message)
{
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), message->text);
    }
}

/* The path of a file that is removed at the end; stays valid. */
static void file_named(const char *name, char path[PATH_BYTES])
{
    work_folder_remember(name);
    const int length = snprintf(path, PATH_BYTES, "%s", path_of(name));
    assert_true(length > 0 && length < PATH_BYTES);
}

/* ---- voxels ---- */

/* Around the origin, with 13 materials that have a color each. */
static void scattered(size_t index, const float random[4], svo_voxel *out)
{
    (void)index;
    int32_t *const axes[3] = {&out->x, &out->y, &out->z};
    for (int axis = 0; axis < 3; ++axis) {
        *axes[axis] = (int32_t)(random[axis] * 24) - 12;
    }
    out->material = (uint16_t)(1 + (int)(random[3] * 13));
    for (int i = 0; i < 3; ++i) {
        out->rgba[i] = (uint8_t)(out->material * (7 + 5 * i));
    }
    out->rgba[3] = 255;
}

/* Far apart, which takes several models, with more colors than a palette has. */
static void colorful(size_t index, const float random[4], svo_voxel *out)
{
    out->x = (int32_t)(index % 100) * 7 - 150;
    out->y = (int32_t)(index / 100) * 5;
    out->z = (int32_t)(random[3] * 300);
    for (int i = 0; i < 3; ++i) {
        out->rgba[i] = (uint8_t)(random[i] * 256);
    }
    out->rgba[3] = (uint8_t)(255 - index % 2 * 100);
}

/* A whole block of two colors. */
static void block(size_t index, const float random[4], svo_voxel *out)
{
    (void)random;
    out->x = (int32_t)(index % 12);
    out->y = (int32_t)(index / 12 % 12);
    out->z = (int32_t)(index / 144);
    memset(out->rgba, out->x < 5 ? 255 : 90, sizeof out->rgba);
}

static const struct {
    const char *name;
    void (*make)(size_t index, const float random[4], svo_voxel *out);
    double origin[3], edge; /* edge 0: 1 */
} lists[] = {{"scattered", scattered, {0}, 0}, {"colorful", colorful, {0}, 0}, {"block", block, {0.5, -3, 100}, 0.125}};
#define LIST_COUNT (sizeof lists / sizeof lists[0])

static svo_voxels *make_list(size_t which)
{
    static const svo_voxel_property properties[] = {
        {1, "_type", "_metal"}, {1, "_rough", "0.25"}, {7, "_type", "_glass"}, {1, "_rough", "0.5"}};
    static svo_voxel given[VOXELS];
    uint64_t state = which + 1;
    svo_voxels *list = NULL;
    svo_message message = {""};
    svo_voxels_source source = {.struct_size = sizeof source,
                                .voxels = given,
                                .voxel_count = VOXELS,
                                .properties = properties,
                                .property_count = sizeof properties / sizeof properties[0],
                                .voxel_edge = lists[which].edge};
    memcpy(source.origin, lists[which].origin, sizeof source.origin);
    memset(given, 0, sizeof given);
    for (size_t k = 0; k < VOXELS; ++k) {
        float random[4];
        for (int i = 0; i < 4; ++i) {
            random[i] = pin_random(&state);
        }
        lists[which].make(k, random, &given[k]);
    }
    told(svo_voxels_create(&source, &list, &message), &message);
    return list;
}

static void pin_list(pins *all, const char *name, const svo_voxels *list)
{
    svo_voxels_info info = SVO_VOXELS_INFO_INIT;
    char part[PIN_NAME_BYTES];
    char text[1024] = "";
    size_t used = 0;
    told(svo_voxels_get_info(list, &info), &(svo_message){"no info"});
    pin_text(all, name, "%" PRIu64 " of %" PRIu64 " low %d %d %d high %d %d %d depth %u materials %u at %a %a %a by %a",
             info.voxel_count, info.given_count, info.low[0], info.low[1], info.low[2], info.high[0], info.high[1],
             info.high[2], (unsigned)info.depth, (unsigned)info.material_count, info.origin[0], info.origin[1],
             info.origin[2], info.voxel_edge);
    (void)snprintf(part, sizeof part, "%s, in order", name);
    pin_digest(all, part, svo_voxels_get(list), (size_t)info.voxel_count * sizeof(svo_voxel));
    if (svo_voxels_get_normals(list) != NULL) {
        (void)snprintf(part, sizeof part, "%s, normals", name);
        pin_digest(all, part, svo_voxels_get_normals(list), (size_t)info.voxel_count * 3 * sizeof(int16_t));
    }
    const svo_voxel_property *properties = svo_voxels_get_properties(list);
    for (size_t i = 0; i < info.property_count; ++i) {
        used += (size_t)snprintf(text + used, sizeof text - used, "%u %s %s, ", (unsigned)properties[i].material,
                                 properties[i].key, properties[i].value);
    }
    (void)snprintf(part, sizeof part, "%s, properties", name);
    pin_text(all, part, "%s", text);
}

static svo_tree *build_list(const pins *all, const svo_voxels *list)
{
    svo_tree *tree = NULL;
    pin_succeed(all, svo_voxels_build(all->opened.device, list, 0, NULL, all->opened.queue, &tree, NULL));
    pin_succeed(all, svo_tree_download(tree, all->opened.queue));
    return tree;
}

/* What a few steps make of the leaves, with one of them undone. */
static void pin_edit(pins *all, const svo_voxels *leaves)
{
    static const svo_edit_step steps[] = {
        {.verb = SVO_EDIT_SET,
         .shape = SVO_EDIT_SPHERE,
         .rgba = {200, 30, 9, 255},
         .begin = {9.5, 3.25, 4},
         .radius = 3.5},
        {.verb = SVO_EDIT_CLEAR, .shape = SVO_EDIT_BOX, .begin = {4, 0, 0}, .end = {7, 16, 16}},
        {.verb = SVO_EDIT_ADD,
         .shape = SVO_EDIT_CAPSULE,
         .material = 3,
         .begin = {1, 2, 3},
         .end = {14, 9, 12},
         .radius = 2},
        {.verb = SVO_EDIT_PAINT, .shape = SVO_EDIT_SPHERE, .rgba = {9, 9, 9, 255}, .begin = {8, 8, 8}, .radius = 6},
        {.verb = SVO_EDIT_SET, .shape = SVO_EDIT_BOX, .begin = {2, 11, 2}, .end = {9, 14, 5}}};
    const int32_t offset[3] = {3, 5, -2};
    svo_edit *edit = NULL;
    svo_tree *tree = NULL;
    svo_voxels *edited = NULL;
    svo_message message = {""};
    told(svo_edit_create(leaves, NULL, &edit, &message), &message);
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; ++i) {
        svo_edit_step step = steps[i];
        step.struct_size = sizeof step;
        told(svo_edit_apply(edit, &step, &message), &message);
    }
    told(svo_edit_undo(edit), &(svo_message){"nothing to undo"});
    svo_edit_step region = steps[0]; /* the sphere and what is in it */
    region.struct_size = sizeof region;
    told(svo_edit_copy(edit, &region, offset, &message), &message);
    told(svo_edit_get_voxels(edit, &edited, &message), &message);
    pin_list(all, "edited", edited);
    pin_succeed(all, svo_edit_commit(edit, all->opened.device, 0, NULL, all->opened.queue, &tree, NULL));
    pin_succeed(all, svo_tree_download(tree, all->opened.queue));
    pin_tree(all, "edited tree", tree);
    svo_tree_destroy(&tree);
    svo_voxels_destroy(&edited);
    svo_edit_destroy(&edit);
}

void pin_voxels(pins *all)
{
    for (size_t i = 0; i < LIST_COUNT; ++i) {
        svo_voxels *list = make_list(i);
        svo_voxels *leaves = NULL;
        svo_message message = {""};
        svo_tree *tree = build_list(all, list);
        pin_begin(all, "%s", lists[i].name);
        pin_list(all, "given", list);
        pin_tree(all, "tree", tree);
        told(svo_tree_get_voxels(tree, &leaves, &message), &message);
        pin_list(all, "leaves", leaves);
        svo_voxels_destroy(&leaves);
        svo_tree_destroy(&tree);
        svo_voxels_destroy(&list);
    }
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        svo_tree *tree = pin_build(all, all->scenes[s].mesh, 4, &(svo_plan_options){.need = ALL_NEEDS});
        svo_voxels *leaves = NULL;
        svo_message message = {""};
        pin_begin(all, "%s", all->scenes[s].name);
        told(svo_tree_get_voxels(tree, &leaves, &message), &message);
        pin_list(all, "leaves", leaves);
        pin_edit(all, leaves);
        svo_voxels_destroy(&leaves);
        svo_tree_destroy(&tree);
    }
}

/* ---- files of trees ---- */

static void pin_loaded(pins *all, const char *path)
{
    svo_tree *loaded = NULL;
    svo_message message = {""};
    const svo_load_options levels = {.struct_size = sizeof levels, .last_level = 3};
    told(svo_tree_load(svo_from_path(path), NULL, &loaded, &message), &message);
    pin_tree(all, "loaded", loaded);
    svo_tree_destroy(&loaded);
    told(svo_tree_load(svo_from_path(path), &levels, &loaded, &message), &message);
    pin_tree(all, "loaded to level 3", loaded);
    svo_tree_destroy(&loaded);
}

/* Bytes of compressed chunks depend on the version of zstd; what they hold does not. */
static void pin_tree_files(pins *all, const svo_tree *tree)
{
    const svo_save_options compressed = {.struct_size = sizeof compressed, .compress = 1};
    char path[PATH_BYTES];
    svo_message message = {""};
    svo_tree *loaded = NULL;
    file_named("tree.svo", path);
    told(svo_tree_save(tree, svo_to_path(path), &compressed, &message), &message);
    told(svo_tree_load(svo_from_path(path), NULL, &loaded, &message), &message);
    pin_tree(all, "loaded, compressed", loaded);
    svo_tree_destroy(&loaded);
    told(svo_tree_save(tree, svo_to_path(path), NULL, &message), &message);
    pin_file(all, "tree.svo", path);
    pin_loaded(all, path);
}

static void pin_compact_file(pins *all, const svo_tree *tree, svo_form form)
{
    const svo_compact_options options = {.struct_size = sizeof options, .form = form};
    char path[PATH_BYTES], name[64];
    char hash[SVO_HASH_TEXT_BYTES];
    svo_message message = {""};
    svo_compact *compact = NULL;
    file_named("compact.svo", path);
    pin_succeed(all, svo_compact_create(all->opened.device, tree, &options, all->opened.queue, &compact));
    pin_succeed(all, svo_compact_download(compact, all->opened.queue));
    told(svo_compact_save(compact, svo_to_path(path), NULL, &message), &message);
    svo_compact_destroy(&compact);
    (void)snprintf(name, sizeof name, "%s.svo", svo_name(SVO_NAME_FORM, form));
    pin_file(all, name, path);
    told(svo_compact_load(svo_from_path(path), NULL, &compact, &message), &message);
    told(svo_compact_hash(compact, hash), &(svo_message){"no hash"});
    (void)snprintf(name, sizeof name, "%s, loaded", svo_name(SVO_NAME_FORM, form));
    pin_text(all, name, "%s", hash);
    svo_compact_destroy(&compact);
}

/* ---- files of voxels ---- */

/* .svx files depend on the version of libzip. */
static void pin_voxel_files(pins *all, const svo_voxels *list)
{
    static const svo_voxel_format formats[] = {SVO_VOXEL_FORMAT_VOX, SVO_VOXEL_FORMAT_BINVOX, SVO_VOXEL_FORMAT_PLY,
                                               SVO_VOXEL_FORMAT_OBJ};
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; ++i) {
        const char *suffix = svo_name(SVO_NAME_VOXEL_FORMAT, formats[i]);
        char path[PATH_BYTES], name[64];
        svo_voxels_save_info saved = SVO_VOXELS_SAVE_INFO_INIT;
        svo_voxels *loaded = NULL;
        svo_message message = {""};
        (void)snprintf(name, sizeof name, "list.%s", suffix);
        file_named(name, path);
        told(svo_voxels_save(list, svo_to_path(path), formats[i], &saved, &message), &message);
        pin_file(all, name, path);
        (void)snprintf(name, sizeof name, "%s, saved", suffix);
        pin_text(all, name, "color error %u models %" PRIu64 " colors %" PRIu64 " faces %" PRIu64 " bytes %" PRIu64,
                 (unsigned)saved.color_error, saved.models, saved.colors, saved.faces, saved.bytes);
        if (formats[i] == SVO_VOXEL_FORMAT_VOX || formats[i] == SVO_VOXEL_FORMAT_BINVOX) {
            told(svo_voxels_load(svo_from_path(path), NULL, &loaded, NULL, &message), &message);
            (void)snprintf(name, sizeof name, "%s, loaded", suffix);
            pin_list(all, name, loaded);
            svo_voxels_destroy(&loaded);
        }
    }
}

/* ---- files of meshes ---- */

static const char obj_text[] = "mtllib mesh.mtl\n"
                               "v 0 0 0 1 0 0\nv 1.5 0 0 0 1 0\nv 1 1e-1 0.125 0 0 1\nv -0.5 2 1 1 1 1\nv 3 3 3\n"
                               "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nvn 0 1 0\n"
                               "usemtl red\nf 1/1/1 2/2/1 3/3/1 4/1/1\n"
                               "usemtl glow\nf -5//2 -3//2 -2//2\nf 1 2 4 3\n";
static const char mtl_text[] =
    "newmtl red\nKd 0.8 0.1 0.05\nd 0.25\nnewmtl glow\nKd 0.2 0.4 0.6\nKe 2 1 0\nKs 0 0.5 0\n"
    "Ns 30\n";
static const char ply_text[] = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                               "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
                               "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                               "0 0 0 255 0 0\n1 0 0 0 255 0\n1 1 0.333333333 0 0 255\n0 1 -2e-3 9 8 7\n"
                               "4 0 1 2 3\n3 0 3 1\n";
static const char stl_text[] = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0.1\n"
                               "endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0.7\n"
                               "vertex 0 1 0.1\nendloop\nendfacet\nendsolid a\n";
static const char off_text[] = "OFF\n4 2 0\n0 0 0\n1 0 0.3\n1 1 0\n0 1 1e-2\n4 0 1 2 3\n3 0 2 1\n";

static void pin_mesh(pins *all, const char *name, const svo_mesh *mesh)
{
    const size_t vertices = mesh->vertex_count, triangles = mesh->triangle_count;
    const struct {
        const char *name;
        const void *bytes;
        size_t byte_count;
    } arrays[] = {
        {"positions", mesh->positions, vertices * 12},
        {"doubles", mesh->positions_double, vertices * 24},
        {"indices", mesh->indices, triangles * 12},
        {"normals", mesh->normals, vertices * 12},
        {"colors", mesh->colors, vertices * 4},
        {"uvs", mesh->uvs, vertices * 8},
        {"triangle materials", mesh->triangle_materials, triangles * 2},
        {"materials", mesh->materials, mesh->material_count * sizeof *mesh->materials},
        {"finishes", mesh->finishes, mesh->finishes != NULL ? mesh->material_count * sizeof *mesh->finishes : 0},
    };
    pin_begin(all, "%s", name);
    pin_text(all, "counts", "%zu vertices %zu triangles %zu materials %zu textures", vertices, triangles,
             mesh->material_count, mesh->texture_count);
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; ++i) {
        if (arrays[i].bytes != NULL) {
            pin_digest(all, arrays[i].name, arrays[i].bytes, arrays[i].byte_count);
        }
    }
}

static void pin_imports(pins *all)
{
    static const struct {
        const char *name, *text;
    } files[] = {{"mesh.obj", obj_text}, {"mesh.ply", ply_text}, {"mesh.stl", stl_text}, {"mesh.off", off_text}};
    write_text("mesh.mtl", mtl_text);
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i) {
        svo_import *import = NULL;
        svo_message message = {""};
        write_text(files[i].name, files[i].text);
        told(svo_import_file(path_of(files[i].name), NULL, NULL, NULL, &import, &message), &message);
        pin_mesh(all, files[i].name, svo_import_mesh(import));
        svo_import_destroy(&import);
    }
}

void pin_io(pins *all)
{
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        svo_tree *tree = pin_build(all, all->scenes[s].mesh, 5, &(svo_plan_options){.need = ALL_NEEDS});
        pin_begin(all, "%s", all->scenes[s].name);
        pin_tree_files(all, tree);
        for (int form = 0; form < SVO_FORM_COUNT; ++form) {
            pin_compact_file(all, tree, (svo_form)form);
        }
        svo_tree_destroy(&tree);
    }
    for (size_t i = 0; i < LIST_COUNT; ++i) {
        svo_voxels *list = make_list(i);
        pin_begin(all, "%s", lists[i].name);
        pin_voxel_files(all, list);
        svo_voxels_destroy(&list);
    }
    pin_imports(all);
}

/* ---- parts ---- */

static void pin_header(pins *all, const svo_part_header *header)
{
    pin_text(all, "header",
             "need %x constant %x weight_log2 %u flags %x kept %" PRIu64 " of %" PRIu64 " fragments %a nodes %a",
             (unsigned)header->need, (unsigned)header->constant, (unsigned)header->weight_log2, (unsigned)header->flags,
             header->kept_triangles, header->triangles, header->expected_fragments, header->expected_nodes);
}

static void build_part(pins *all, const svo_mesh *mesh, const svo_part_header *header, uint64_t code, const char *path)
{
    const svo_plan_options options = {
        .struct_size = sizeof options, .need = header->need, .part_header = header, .part_level = 1, .part_code = code};
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_message message = {""};
    pin_succeed(all, svo_plan_create(all->opened.device, mesh, header->depth, &options, &plan));
    pin_succeed(all, svo_build(plan, all->opened.frontend, all->opened.queue, &tree, NULL));
    pin_succeed(all, svo_tree_download(tree, all->opened.queue));
    told(svo_part_save(tree, path, &message), &message);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
}

/* The eight parts below the root, stitched. */
static void pin_octants(pins *all, const svo_mesh *mesh)
{
    enum { OCTANTS = 8 };
    const svo_plan_options options = {.struct_size = sizeof options, .need = ALL_NEEDS};
    char paths[OCTANTS][PATH_BYTES], of_mesh[PATH_BYTES], stitched[PATH_BYTES];
    const char *listed[OCTANTS];
    svo_part_header header = SVO_PART_HEADER_INIT;
    svo_plan *plan = NULL;
    svo_message message = {""};
    pin_succeed(all, svo_plan_create(all->opened.device, mesh, 6, &options, &plan));
    pin_succeed(all, svo_plan_get_part_header(plan, &header));
    pin_header(all, &header);
    file_named("mesh.part", of_mesh);
    told(svo_part_save_mesh(plan, of_mesh, &message), &message);
    pin_file(all, "mesh.part", of_mesh);
    for (uint64_t code = 0; code < OCTANTS; ++code) {
        char name[32];
        (void)snprintf(name, sizeof name, "%u.part", (unsigned)code);
        file_named(name, paths[code]);
        build_part(all, mesh, &header, code, paths[code]);
        pin_file(all, name, paths[code]);
        listed[code] = paths[code];
    }
    file_named("stitched.svo", stitched);
    told(svo_parts_stitch(&header, listed, OCTANTS, of_mesh, stitched, &message), &message);
    pin_file(all, "stitched.svo", stitched);
    svo_plan_destroy(&plan);
}

/* A folder of parts, as many as memory asks for, which depends on the kernels. */
static void pin_folder(pins *all, const svo_mesh *mesh)
{
    const svo_plan_options options = {.struct_size = sizeof options, .need = ALL_NEEDS};
    char folder[PATH_BYTES], path[PATH_BYTES];
    svo_part_header header = SVO_PART_HEADER_INIT;
    svo_parts *parts = NULL;
    svo_message message = {""};
    (void)snprintf(folder, sizeof folder, "%s", path_of("parts"));
    file_named("whole.svo", path);
    told(svo_parts_create(all->opened.device, mesh, 7, &options, PARTS_BYTES, folder, &message), &message);
    told(svo_parts_open(folder, &parts, &message), &message);
    assert_true(svo_parts_count(parts) > 1);
    told(svo_parts_get_header(parts, &header, &message), &message);
    pin_text(all, "input of a folder", "%016" PRIx64, header.input_hash);
    for (size_t i = 0; i < svo_parts_count(parts); ++i) {
        told(svo_parts_build(parts, i, all->opened.device, all->opened.frontend, all->opened.queue, &message),
             &message);
    }
    told(svo_parts_finish(parts, path, &message), &message);
    pin_file(all, "stitched by a folder", path);
    svo_parts_close(&parts);
    told(svo_parts_remove(folder, &message), &message);
}

void pin_parts(pins *all)
{
    for (size_t s = 0; s < PIN_SCENES; ++s) {
        pin_begin(all, "%s", all->scenes[s].name);
        pin_octants(all, all->scenes[s].mesh);
        pin_folder(all, all->scenes[s].mesh);
    }
}
