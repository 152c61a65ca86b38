/* SPDX-License-Identifier: MIT */
/*
 * Reader for glTF 2.0 (Khronos, "glTF 2.0 Specification"), in the import child: the triangles of the file's scene, with
 * the transforms of nodes and instances. Read besides the core: KHR_mesh_quantization, EXT_mesh_gpu_instancing,
 * KHR_texture_transform, KHR_materials_emissive_strength, KHR_materials_pbrSpecularGlossiness. Meshes with bones and
 * morph targets are as they are without these.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/message.h"
#include "io/import_formats.h"
#include "io/import_gather.h"
#include "io/import_gltf.h"
#include "io/srgb.h"

#define NODE_DEPTH_MAX 1000 /* bounds the recursion; deeper files are damaged */
#define MATERIALS_MAX  UINT16_MAX

/* The looks made from one of the file's materials, without and with its texture. */
typedef struct material_entry {
    bool is_made[2];
    uint16_t index[2];
    gltf_look look[2];
} material_entry;

typedef struct gltf_scene {
    gltf_file file;
    gather *mesh;
    texture_list textures;
    material_entry *materials; /* and one more: the default */
    uint8_t *is_planned; /* per node: its meshes' materials are gathered */
    uint8_t *is_drawn; /* per node */
    uint64_t small_count; /* points and lines */
    uint64_t over_count; /* corners after the last whole triangle */
    uint64_t bad_count; /* triangles that name a vertex that does not exist */
} gltf_scene;

static svo_status fail_index(const gltf_scene *scene, const char *what, uint32_t index, const char *why)
{
    return svo_i_fail(scene->file.reader->message, SVO_IMPORT_FAILED, "%s %" PRIu32 " %s", what, index, why);
}

/* ---- extensions ---- */

static bool is_in(const char *name, const char *const *list)
{
    while (*list != NULL && strcmp(name, *list) != 0) {
        ++list;
    }
    return *list != NULL;
}

static svo_status check_extensions(const gltf_scene *scene)
{
    static const char *const read[] = {
        "EXT_mesh_gpu_instancing", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness",
        "KHR_materials_unlit", /* a tree has the color itself */
        "KHR_mesh_quantization",   "KHR_texture_transform",           NULL};
    /* Where they are not required, a tree is the same without them: highlights; lights, which are no part of a mesh;
       other codings of what the file also has plainly; names and data. docs/program.md lists them. */
    static const char *const silent[] = {"EXT_lights_ies",
                                         "EXT_lights_image_based",
                                         "EXT_mesh_features",
                                         "EXT_meshopt_compression",
                                         "EXT_structural_metadata",
                                         "EXT_texture_avif",
                                         "EXT_texture_webp",
                                         "FB_ngon_encoding",
                                         "KHR_animation_pointer",
                                         "KHR_audio_emitter",
                                         "KHR_draco_mesh_compression",
                                         "KHR_lights_punctual",
                                         "KHR_materials_anisotropy",
                                         "KHR_materials_clearcoat",
                                         "KHR_materials_dispersion",
                                         "KHR_materials_ior",
                                         "KHR_materials_iridescence",
                                         "KHR_materials_sheen",
                                         "KHR_materials_specular",
                                         "KHR_materials_variants",
                                         "KHR_meshopt_compression",
                                         "KHR_texture_basisu",
                                         "KHR_xmp",
                                         "KHR_xmp_json_ld",
                                         "MSFT_texture_dds",
                                         NULL};
    const mesh_reader *reader = scene->file.reader;
    const cJSON *item = NULL;
    cJSON_ArrayForEach(item, svo_i_gltf_get(scene->file.root, "extensionsRequired"))
    {
        if (!cJSON_IsString(item) || !is_in(item->valuestring, read)) {
            return svo_i_fail(reader->message, SVO_IMPORT_FAILED,
                              "the file needs the glTF extension %.60s, which is not read",
                              cJSON_IsString(item) ? item->valuestring : "?");
        }
    }
    cJSON_ArrayForEach(item, svo_i_gltf_get(scene->file.root, "extensionsUsed"))
    {
        if (!cJSON_IsString(item) || (!is_in(item->valuestring, read) && !is_in(item->valuestring, silent))) {
            svo_i_read_warn(reader, "the glTF extension %.60s is not read, what it changes is not seen",
                            cJSON_IsString(item) ? item->valuestring : "?");
        }
    }
    return SVO_OK;
}

/* ---- primitives ---- */

/* The arrays of a primitive while it is gathered. */
typedef struct primitive {
    gltf_accessor positions, normals, colors, uvs, indices; /* of count 0 where there is none */
    const gltf_look *look;
    uint16_t material;
    uint32_t mode;
    uint32_t corner_count;
} primitive;

static void close_primitive(primitive *p)
{
    svo_i_gltf_accessor_free(&p->positions);
    svo_i_gltf_accessor_free(&p->normals);
    svo_i_gltf_accessor_free(&p->colors);
    svo_i_gltf_accessor_free(&p->uvs);
    svo_i_gltf_accessor_free(&p->indices);
}

/* Opens an array that has an element for each vertex, of least to most components; none: it stays closed. */
static svo_status open_attribute(gltf_scene *scene, const cJSON *owner, const char *name, uint32_t least, uint32_t most,
                                 const primitive *p, gltf_accessor *accessor)
{
    uint32_t index = GLTF_NONE;
    SVO_I_TRY(svo_i_gltf_index(&scene->file, owner, name, GLTF_ACCESSOR, &index));
    if (index == GLTF_NONE) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_gltf_accessor(&scene->file, index, accessor));
    if (accessor->width < least || accessor->width > most) {
        return fail_index(scene, "accessor", index, "has another number of components than its use wants");
    }
    if (accessor != &p->positions && accessor->count != p->positions.count) {
        return svo_i_fail(scene->file.reader->message, SVO_IMPORT_FAILED,
                          "%s, accessor %" PRIu32 ", has %" PRIu32 " elements for %" PRIu32 " vertices", name, index,
                          accessor->count, p->positions.count);
    }
    return SVO_OK;
}

static svo_status open_indices(gltf_scene *scene, const cJSON *item, primitive *p)
{
    uint32_t index = GLTF_NONE;
    p->corner_count = p->positions.count;
    SVO_I_TRY(svo_i_gltf_index(&scene->file, item, "indices", GLTF_ACCESSOR, &index));
    if (index == GLTF_NONE) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_gltf_accessor(&scene->file, index, &p->indices));
    const uint32_t component = p->indices.component;
    if (p->indices.width != 1 || (component != 5121 && component != 5123 && component != 5125)) {
        return fail_index(scene, "accessor", index, "is used as indices and has no unsigned integers");
    }
    p->corner_count = p->indices.count;
    return SVO_OK;
}

static bool has_uvs(const cJSON *attributes)
{
    const cJSON *item = NULL;
    cJSON_ArrayForEach(item, attributes)
    {
        if (strncmp(item->string, "TEXCOORD_", 9) == 0) {
            return true;
        }
    }
    return false;
}

/* The material of a primitive, gathered at its first use. */
static svo_status find_material(gltf_scene *scene, const cJSON *item, primitive *p)
{
    gather *mesh = scene->mesh;
    uint32_t index = GLTF_NONE;
    SVO_I_TRY(svo_i_gltf_index(&scene->file, item, "material", GLTF_MATERIAL, &index));
    const bool textured = has_uvs(svo_i_gltf_get(item, "attributes"));
    material_entry *entry = &scene->materials[index != GLTF_NONE ? index : scene->file.tables[GLTF_MATERIAL].count];
    gltf_look *look = &entry->look[textured];
    if (!entry->is_made[textured]) {
        if (mesh->material_count == MATERIALS_MAX) {
            return svo_i_fail(scene->file.reader->message, SVO_IMPORT_FAILED, "it has more than %d materials",
                              MATERIALS_MAX);
        }
        SVO_I_TRY(svo_i_gltf_material(&scene->file, &scene->textures, index, textured, look));
        if (!svo_i_gather_material(mesh, &look->material)) {
            return svo_i_read_out_of_memory(scene->file.reader);
        }
        entry->index[textured] = (uint16_t)(mesh->material_count - 1);
        entry->is_made[textured] = true;
    }
    p->look = look;
    p->material = entry->index[textured];
    return SVO_OK;
}

/* Opens what a primitive is made of. One without positions has no corners. */
static svo_status open_primitive(gltf_scene *scene, const cJSON *item, primitive *p)
{
    const cJSON *attributes = svo_i_gltf_get(item, "attributes");
    double mode = 4;
    char set[24];
    SVO_I_TRY(svo_i_gltf_numbers(&scene->file, item, "mode", &mode, 1));
    if (!(mode >= 0 && mode <= 6)) {
        return svo_i_fail(scene->file.reader->message, SVO_IMPORT_FAILED, "mode %g of a primitive is not in 0 .. 6",
                          mode);
    }
    p->mode = (uint32_t)mode;
    SVO_I_TRY(find_material(scene, item, p));
    SVO_I_TRY(open_attribute(scene, attributes, "POSITION", 3, 3, p, &p->positions));
    SVO_I_TRY(open_attribute(scene, attributes, "NORMAL", 3, 3, p, &p->normals));
    SVO_I_TRY(open_attribute(scene, attributes, "COLOR_0", 3, 4, p, &p->colors));
    if (svo_i_gather_is_textured(&p->look->material)) {
        (void)snprintf(set, sizeof set, "TEXCOORD_%" PRIu32, p->look->uvs.set);
        const char *name = svo_i_gltf_get(attributes, set) != NULL ? set : "TEXCOORD_0";
        SVO_I_TRY(open_attribute(scene, attributes, name, 2, 2, p, &p->uvs));
    }
    return open_indices(scene, item, p);
}

/* ---- vertices and triangles ---- */

static void get_vector(const gltf_accessor *accessor, uint32_t element, double *vector)
{
    for (uint32_t i = 0; i < accessor->width; ++i) {
        vector[i] = svo_i_gltf_component(accessor, element, i);
    }
}

static gather_vertex make_vertex(const primitive *p, const transform *t, uint32_t number)
{
    gather_vertex vertex = {.color = {255, 255, 255, 255}};
    double vector[4] = {0, 0, 0, 1};
    get_vector(&p->positions, number, vector);
    transform_point(t, vector, vertex.position);
    if (p->normals.bytes != NULL) {
        get_vector(&p->normals, number, vector);
        transform_normal(t, vector, vertex.normal);
    }
    if (p->colors.bytes != NULL) {
        vector[3] = 1;
        get_vector(&p->colors, number, vector);
        for (int i = 0; i < 3; ++i) {
            vertex.color[i] = svo_i_srgb_byte(vector[i]);
        }
        vertex.color[3] = svo_i_gltf_alpha_byte(&p->look->alpha, vector[3]);
    }
    if (p->uvs.bytes != NULL) {
        const gltf_uvs *uvs = &p->look->uvs;
        get_vector(&p->uvs, number, vector);
        for (int i = 0; i < 2; ++i) {
            const double *row = uvs->matrix[i];
            vertex.uv[i] = (float)(uvs->is_identity ? vector[i] : row[0] * vector[0] + row[1] * vector[1] + row[2]);
        }
    }
    return vertex;
}

/* The vertex of a corner, GATHER_NO_VERTEX where there is none. known: per vertex of the primitive its index. */
static bool gather_corner(gltf_scene *scene, const primitive *p, const transform *t, uint32_t corner, uint32_t *known,
                          uint32_t *index)
{
    const uint32_t number = p->indices.bytes != NULL ? svo_i_gltf_vertex(&p->indices, corner) : corner;
    *index = GATHER_NO_VERTEX;
    if (number >= p->positions.count) {
        return true;
    }
    if (known[number] == GATHER_NO_VERTEX) {
        const gather_vertex vertex = make_vertex(p, t, number);
        if (!svo_i_gather_vertex(scene->mesh, &vertex, &known[number])) {
            return false;
        }
    }
    *index = known[number];
    return true;
}

/* The corners of a triangle of a list, a strip or a fan, in the order that faces the same side. */
static void find_corners(const primitive *p, uint32_t triangle, bool mirrors, uint32_t corners[3])
{
    const uint32_t odd = triangle & 1u;
    const uint32_t orders[3][3] = {{3 * triangle, 3 * triangle + 1, 3 * triangle + 2},
                                   {triangle + odd, triangle + 1 - odd, triangle + 2},
                                   {0, triangle + 1, triangle + 2}};
    const uint32_t *order = orders[p->mode - 4];
    for (uint32_t i = 0; i < 3; ++i) {
        corners[i] = order[mirrors && i > 0 ? 3 - i : i];
    }
}

static bool gather_triangle(gltf_scene *scene, const primitive *p, const transform *t, uint32_t triangle,
                            uint32_t *known)
{
    uint32_t corners[3];
    uint32_t indices[3];
    bool done = true;
    bool bad = false;
    find_corners(p, triangle, t->mirrors, corners);
    for (uint32_t i = 0; i < 3 && done; ++i) {
        done = gather_corner(scene, p, t, corners[i], known, &indices[i]);
        bad = bad || (done && indices[i] == GATHER_NO_VERTEX);
    }
    scene->bad_count += bad ? 1u : 0u;
    return done && svo_i_gather_triangle(scene->mesh, indices, p->material);
}

static uint32_t count_triangles(const primitive *p)
{
    if (p->mode == 4) {
        return p->corner_count / 3;
    }
    return p->mode > 4 && p->corner_count > 2 ? p->corner_count - 2 : 0;
}

/* What of a primitive is no triangle. */
static void count_rest(gltf_scene *scene, const primitive *p)
{
    const uint32_t corners = p->corner_count;
    if (p->mode == 4) {
        scene->over_count += corners % 3;
    } else if (p->mode > 4) {
        scene->over_count += corners < 3 ? corners : 0;
    } else {
        scene->small_count += p->mode == 1 ? corners / 2 : p->mode == 3 && corners > 0 ? corners - 1 : corners;
    }
}

static svo_status gather_primitive(gltf_scene *scene, const primitive *p, const transform *t)
{
    const uint32_t triangle_count = count_triangles(p);
    count_rest(scene, p);
    if (triangle_count == 0) {
        return SVO_OK;
    }
    uint32_t *known = malloc(((size_t)p->positions.count + 1) * sizeof *known);
    bool done = known != NULL;
    if (done) {
        memset(known, 0xff, ((size_t)p->positions.count + 1) * sizeof *known);
    }
    for (uint32_t i = 0; i < triangle_count && done; ++i) {
        done = gather_triangle(scene, p, t, i, known);
    }
    free(known);
    return done ? SVO_OK : svo_i_read_out_of_memory(scene->file.reader);
}

/* ---- transforms ---- */

static svo_status read_transform(const gltf_scene *scene, const cJSON *node, const transform *parent, transform *out)
{
    double matrix[16], move[3] = {0, 0, 0}, turn[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    double local[3][4];
    SVO_I_TRY(svo_i_gltf_numbers(&scene->file, node, "matrix", matrix, 16));
    SVO_I_TRY(svo_i_gltf_numbers(&scene->file, node, "translation", move, 3));
    SVO_I_TRY(svo_i_gltf_numbers(&scene->file, node, "rotation", turn, 4));
    SVO_I_TRY(svo_i_gltf_numbers(&scene->file, node, "scale", scale, 3));
    transform_compose(move, turn, scale, local);
    for (int i = 0; i < 12 && svo_i_gltf_get(node, "matrix") != NULL; ++i) {
        local[i / 4][i % 4] = (double)(float)matrix[i % 4 * 4 + i / 4]; /* by columns */
    }
    *out = transform_combine(parent, local);
    return SVO_OK;
}

/* EXT_mesh_gpu_instancing: transforms of instances, applied before the node's own. */
typedef struct instances {
    gltf_accessor moves, turns, scales;
    uint32_t count;
} instances;

static void close_instances(instances *all)
{
    svo_i_gltf_accessor_free(&all->moves);
    svo_i_gltf_accessor_free(&all->turns);
    svo_i_gltf_accessor_free(&all->scales);
}

static svo_status open_instances(gltf_scene *scene, const cJSON *extension, instances *all)
{
    static const char *const names[] = {"TRANSLATION", "ROTATION", "SCALE"};
    gltf_accessor *const accessors[] = {&all->moves, &all->turns, &all->scales};
    const cJSON *attributes = svo_i_gltf_get(extension, "attributes");
    for (int i = 0; i < 3; ++i) {
        uint32_t index = GLTF_NONE;
        SVO_I_TRY(svo_i_gltf_index(&scene->file, attributes, names[i], GLTF_ACCESSOR, &index));
        if (index == GLTF_NONE) {
            continue;
        }
        SVO_I_TRY(svo_i_gltf_accessor(&scene->file, index, accessors[i]));
        if (accessors[i]->width != (i == 1 ? 4 : 3) || (all->count > 0 && accessors[i]->count != all->count)) {
            return fail_index(scene, "accessor", index, "does not fit the other attributes of the instances");
        }
        all->count = accessors[i]->count;
    }
    return SVO_OK;
}

static transform place_instance(const instances *all, uint32_t number, const transform *node)
{
    double move[3] = {0, 0, 0}, turn[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    double local[3][4];
    get_vector(&all->moves, number, move);
    get_vector(&all->turns, number, turn);
    get_vector(&all->scales, number, scale);
    transform_compose(move, turn, scale, local);
    return transform_combine(node, local);
}

/* ---- nodes ---- */

static svo_status draw_primitive(gltf_scene *scene, const cJSON *item, const transform *t, const instances *all)
{
    primitive p = {.mode = 4};
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(open_primitive(scene, item, &p));
    scene->mesh->has_normals = scene->mesh->has_normals || p.normals.bytes != NULL;
    scene->mesh->has_colors = scene->mesh->has_colors || p.colors.bytes != NULL;
    scene->mesh->has_uvs = scene->mesh->has_uvs || p.uvs.bytes != NULL;
    if (all == NULL) {
        status = gather_primitive(scene, &p, t);
        goto cleanup;
    }
    svo_i_stream_work(scene->file.reader->stream, scene->file.reader->work,
                      (stream_work){0, (uint64_t)all->count * p.corner_count});
    for (uint32_t i = 0; i < all->count; ++i) {
        const transform placed = place_instance(all, i, t);
        SVO_I_TRY_CLEANUP(gather_primitive(scene, &p, &placed));
    }
cleanup:
    close_primitive(&p);
    return status;
}

static svo_status draw_mesh(gltf_scene *scene, const cJSON *node, uint32_t mesh, const transform *t)
{
    const cJSON *extension = svo_i_gltf_extension(node, "EXT_mesh_gpu_instancing");
    instances all = {.count = 0};
    const cJSON *item = NULL;
    svo_status status = SVO_OK;
    if (extension != NULL) {
        SVO_I_TRY_CLEANUP(open_instances(scene, extension, &all));
    }
    cJSON_ArrayForEach(item, svo_i_gltf_get(scene->file.tables[GLTF_MESH].items[mesh], "primitives"))
    {
        SVO_I_TRY_CLEANUP(draw_primitive(scene, item, t, extension != NULL ? &all : NULL));
    }
cleanup:
    close_instances(&all);
    return status;
}

/* Whether a node is met for the first time; nodes are a forest. */
static svo_status meet(const gltf_scene *scene, uint8_t *met, uint32_t node, int depth)
{
    if (depth > NODE_DEPTH_MAX) {
        return svo_i_fail(scene->file.reader->message, SVO_IMPORT_FAILED, "its nodes are nested more than %d deep",
                          NODE_DEPTH_MAX);
    }
    if (met[node] != 0) {
        return fail_index(scene, "node", node, "has two parents, or is below itself");
    }
    met[node] = 1;
    return SVO_OK;
}

/* Gathers the materials of a node, those of its children first. Their order is that of older versions' trees. */
static svo_status plan_node(gltf_scene *scene, uint32_t index, int depth)
{
    const cJSON *node = scene->file.tables[GLTF_NODE].items[index];
    const cJSON *item = NULL;
    uint32_t mesh = GLTF_NONE;
    SVO_I_TRY(meet(scene, scene->is_planned, index, depth));
    cJSON_ArrayForEach(item, svo_i_gltf_get(node, "children"))
    {
        uint32_t child = 0;
        SVO_I_TRY(svo_i_gltf_element(&scene->file, item, "child", GLTF_NODE, &child));
        SVO_I_TRY(plan_node(scene, child, depth + 1));
    }
    SVO_I_TRY(svo_i_gltf_index(&scene->file, node, "mesh", GLTF_MESH, &mesh));
    if (mesh != GLTF_NONE) {
        cJSON_ArrayForEach(item, svo_i_gltf_get(scene->file.tables[GLTF_MESH].items[mesh], "primitives"))
        {
            primitive p = {.mode = 4};
            SVO_I_TRY(find_material(scene, item, &p));
        }
    }
    return SVO_OK;
}

static svo_status draw_node(gltf_scene *scene, uint32_t index, const transform *parent, int depth)
{
    const cJSON *node = scene->file.tables[GLTF_NODE].items[index];
    const cJSON *item = NULL;
    uint32_t mesh = GLTF_NONE;
    transform t;
    SVO_I_TRY(meet(scene, scene->is_drawn, index, depth));
    SVO_I_TRY(read_transform(scene, node, parent, &t));
    SVO_I_TRY(svo_i_gltf_index(&scene->file, node, "mesh", GLTF_MESH, &mesh));
    if (mesh != GLTF_NONE) {
        SVO_I_TRY(draw_mesh(scene, node, mesh, &t));
    }
    cJSON_ArrayForEach(item, svo_i_gltf_get(node, "children"))
    {
        uint32_t child = 0;
        SVO_I_TRY(svo_i_gltf_element(&scene->file, item, "child", GLTF_NODE, &child));
        SVO_I_TRY(draw_node(scene, child, &t, depth + 1));
    }
    return SVO_OK;
}

/* The nodes of the file's scene, the first one where it names none. */
static svo_status draw_scene(gltf_scene *scene)
{
    const transform world = transform_identity();
    const gltf_table *scenes = &scene->file.tables[GLTF_SCENE];
    const cJSON *item = NULL;
    uint32_t index = GLTF_NONE;
    uint32_t node = 0;
    SVO_I_TRY(svo_i_gltf_index(&scene->file, scene->file.root, "scene", GLTF_SCENE, &index));
    if (index == GLTF_NONE && scenes->count == 0) {
        return svo_i_fail(scene->file.reader->message, SVO_IMPORT_FAILED, "it has no scene");
    }
    const cJSON *roots = svo_i_gltf_get(scenes->items[index != GLTF_NONE ? index : 0], "nodes");
    cJSON_ArrayForEach(item, roots)
    {
        SVO_I_TRY(svo_i_gltf_element(&scene->file, item, "node", GLTF_NODE, &node));
        SVO_I_TRY(plan_node(scene, node, 0));
    }
    cJSON_ArrayForEach(item, roots)
    {
        SVO_I_TRY(svo_i_gltf_element(&scene->file, item, "node", GLTF_NODE, &node));
        SVO_I_TRY(draw_node(scene, node, &world, 0));
    }
    return SVO_OK;
}

/* ---- all together ---- */

static void warn_of_rest(const gltf_scene *scene)
{
    if (scene->small_count > 0) {
        svo_i_read_warn(scene->file.reader, "%" PRIu64 " points and lines are left out", scene->small_count);
    }
    if (scene->over_count > 0) {
        svo_i_read_warn(scene->file.reader, "%" PRIu64 " corners are too few for a triangle and are left out",
                        scene->over_count);
    }
    if (scene->bad_count > 0) {
        svo_i_read_warn(scene->file.reader, "%" PRIu64 " triangles name a vertex that does not exist",
                        scene->bad_count);
    }
}

static svo_status read_scene(gltf_scene *scene)
{
    const gltf_file *file = &scene->file;
    scene->materials = calloc((size_t)file->tables[GLTF_MATERIAL].count + 1, sizeof *scene->materials);
    scene->is_planned = calloc((size_t)file->tables[GLTF_NODE].count + 1, 1);
    scene->is_drawn = calloc((size_t)file->tables[GLTF_NODE].count + 1, 1);
    if (scene->materials == NULL || scene->is_planned == NULL || scene->is_drawn == NULL) {
        return svo_i_read_out_of_memory(file->reader);
    }
    SVO_I_TRY(check_extensions(scene));
    SVO_I_TRY(draw_scene(scene));
    warn_of_rest(scene);
    svo_i_gather_drop_plain_materials(scene->mesh);
    return SVO_OK;
}

svo_status svo_i_read_gltf(const mesh_reader *reader)
{
    gltf_scene scene = {.mesh = reader->mesh,
                        .textures = {.mesh_path = reader->path, .stream = reader->stream, .work = reader->work}};
    svo_status status = SVO_OK;
    bool is_older = false;
    SVO_I_TRY_CLEANUP(svo_i_gltf_open(reader, &scene.file, &is_older));
    status = read_scene(&scene);
cleanup:
    if (is_older) {
        reader->counts->reader = STREAM_READER_ASSIMP;
    }
    svo_i_texture_list_free(&scene.textures);
    free(scene.materials);
    free(scene.is_planned);
    free(scene.is_drawn);
    svo_i_gltf_close(&scene.file);
    return status;
}
