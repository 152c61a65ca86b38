/* SPDX-License-Identifier: MIT */
/*
 * What assimp reads, in the import child: how it opens files, its materials, and its scene. The scene is traversed:
 * node transforms are applied, attributes that only some meshes have are filled in, and every triangle is gathered.
 * Degenerate triangles are kept, since they touch voxels as well.
 */
#define _POSIX_C_SOURCE 200809L
#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "core/message.h"
#include "io/import_formats.h"

#define DEFAULT_GRAY   0.6f /* of assimp's default material */
#define NODE_DEPTH_MAX 1000 /* bounds the recursion; deeper files are damaged */
#define MATERIALS_MAX  UINT16_MAX

static const char out_of_memory[] = "out of memory";

/* ---- files of assimp ---- */

/* How assimp opens files, so that the parent is told of each but path, the mesh file. */
typedef struct scene_files {
    struct aiFileIO io;
    int stream;
    const char *path;
    int result; /* -1: the parent is gone */
    const char *trouble; /* why path itself could not be opened; NULL: it could */
} scene_files;

typedef struct scene_file {
    struct aiFile file; /* its UserData is this */
    file_bytes content;
    size_t at;
} scene_file;

static scene_file *scene_file_of(struct aiFile *file)
{
    return (scene_file *)(void *)file->UserData;
}

static size_t read_items(struct aiFile *file, char *out, size_t item_bytes, size_t item_count)
{
    scene_file *one = scene_file_of(file);
    const size_t left = item_bytes > 0 ? (one->content.byte_count - one->at) / item_bytes : 0;
    const size_t count = item_count < left ? item_count : left;
    memcpy(out, one->content.bytes + one->at, count * item_bytes);
    one->at += count * item_bytes;
    return count;
}

static size_t write_nothing(struct aiFile *file, const char *bytes, size_t item_bytes, size_t item_count)
{
    (void)file;
    (void)bytes;
    (void)item_bytes;
    (void)item_count;
    return 0;
}

static size_t tell(struct aiFile *file)
{
    return scene_file_of(file)->at;
}

static size_t measure(struct aiFile *file)
{
    return scene_file_of(file)->content.byte_count;
}

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    scene_file *one = scene_file_of(file);
    const size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? one->at : one->content.byte_count;
    const size_t at = from + offset; /* which may stand for a step back */
    if (at > one->content.byte_count) {
        return aiReturn_FAILURE;
    }
    one->at = at;
    return aiReturn_SUCCESS;
}

static void flush_nothing(struct aiFile *file)
{
    (void)file;
}

static struct aiFile *open_scene_file(struct aiFileIO *io, const char *path, const char *mode)
{
    scene_files *files = (scene_files *)(void *)io->UserData;
    const bool is_mesh = strcmp(path, files->path) == 0;
    scene_file *one = mode[0] == 'r' ? malloc(sizeof *one) : NULL;
    const char *trouble = one != NULL ? svo_i_file_open(path, &one->content) : "out of memory";
    if (trouble != NULL) {
        files->trouble = is_mesh ? trouble : files->trouble;
        free(one);
        return NULL;
    }
    if (!is_mesh) {
        files->result = svo_i_stream_file(files->stream, path) != 0 ? -1 : files->result;
    }
    one->at = 0;
    one->file = (struct aiFile){.ReadProc = read_items,
                                .WriteProc = write_nothing,
                                .TellProc = tell,
                                .FileSizeProc = measure,
                                .SeekProc = seek,
                                .FlushProc = flush_nothing,
                                .UserData = (aiUserData)(void *)one};
    return &one->file;
}

static void close_scene_file(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    scene_file *one = scene_file_of(file);
    svo_i_file_close(&one->content);
    free(one);
}

/* files: filled in, and valid as long as path. */
static void watch_files(int stream, const char *path, scene_files *files)
{
    *files = (scene_files){
        .io = {.OpenProc = open_scene_file, .CloseProc = close_scene_file, .UserData = (aiUserData)(void *)files},
        .stream = stream,
        .path = path};
}

/*
 * ---- materials ----
 *
 * The diffuse or base color, that color's texture, emission, the specular lobe and a normal map. Other properties are
 * ignored.
 */

/* A texture's coordinates: a channel of the mesh, transformed to channel * scale + offset in assimp's orientation,
   where v = 0 is the last row. */
typedef struct texture_use {
    unsigned uv_channel;
    float scale[2], offset[2];
} texture_use;

static svo_wrap wrap_of(enum aiTextureMapMode mode)
{
    switch (mode) {
    case aiTextureMapMode_Clamp:
    case aiTextureMapMode_Decal:
        return SVO_WRAP_CLAMP;
    case aiTextureMapMode_Mirror:
        return SVO_WRAP_MIRROR;
    default:
        return SVO_WRAP_REPEAT;
    }
}

/* Scale and offset from the file. assimp 5.2.5 has a step that applies them, but that step scales about the center. */
static bool read_uv_transform(const texture_list *textures, const struct aiMaterial *source, enum aiTextureType type,
                              texture_use *use)
{
    struct aiUVTransform turned;
    if (aiGetMaterialUVTransform(source, AI_MATKEY_UVTRANSFORM(type, 0), &turned) != aiReturn_SUCCESS) {
        return true;
    }
    use->scale[0] = turned.mScaling.x;
    use->scale[1] = turned.mScaling.y;
    use->offset[0] = turned.mTranslation.x;
    use->offset[1] = turned.mTranslation.y;
    return turned.mRotation == 0 || svo_i_stream_text(textures->stream, STREAM_WARNING,
                                                      "a material rotates its texture; the rotation is ignored") == 0;
}

/* A texture of a material. */
typedef struct found_texture {
    struct aiString path; /* empty: none */
    svo_wrap wrap_u, wrap_v;
    texture_use use;
} found_texture;

/* The first texture of two types. Returns false when the parent has closed the pipe. */
static bool find_texture(const texture_list *textures, const struct aiMaterial *source,
                         const enum aiTextureType types[2], found_texture *found)
{
    enum aiTextureMapMode modes[3] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
    *found = (found_texture){.use = {.scale = {1, 1}}};
    for (size_t i = 0; i < 2; ++i) {
        if (aiGetMaterialTextureCount(source, types[i]) > 0 &&
            aiGetMaterialTexture(source, types[i], 0, &found->path, NULL, &found->use.uv_channel, NULL, NULL, modes,
                                 NULL) == aiReturn_SUCCESS &&
            found->path.length > 0) {
            found->wrap_u = wrap_of(modes[0]);
            found->wrap_v = wrap_of(modes[1]);
            return read_uv_transform(textures, source, types[i], &found->use);
        }
    }
    found->path.length = 0;
    return true;
}

static bool send_found(texture_list *textures, const found_texture *found, bool is_bump, uint32_t *index)
{
    const texture_source image = {.name = found->path.data,
                                  .wrap_u = found->wrap_u,
                                  .wrap_v = found->wrap_v,
                                  .alpha_from = TEXTURE_KEEP_ALPHA,
                                  .is_bump = is_bump};
    return svo_i_import_texture(textures, &image, index);
}

static bool placed_alike(const texture_use *a, const texture_use *b)
{
    return a->uv_channel == b->uv_channel && a->scale[0] == b->scale[0] && a->scale[1] == b->scale[1] &&
           a->offset[0] == b->offset[0] && a->offset[1] == b->offset[1];
}

static bool add_textures(texture_list *textures, const struct aiMaterial *source, bool normal_maps,
                         gather_material *material, texture_use *use)
{
    static const enum aiTextureType colors[2] = {aiTextureType_DIFFUSE, aiTextureType_BASE_COLOR};
    static const enum aiTextureType bumps[2] = {aiTextureType_NORMALS, aiTextureType_HEIGHT};
    found_texture color;
    found_texture bump;
    if (!find_texture(textures, source, colors, &color) ||
        (color.path.length > 0 && !send_found(textures, &color, false, &material->base.texture_index))) {
        return false;
    }
    *use = color.use;
    if (!normal_maps) {
        return true;
    }
    if (!find_texture(textures, source, bumps, &bump)) {
        return false;
    }
    if (bump.path.length == 0) {
        return true;
    }
    if (color.path.length > 0 && !placed_alike(&color.use, &bump.use)) {
        return svo_i_stream_text(textures->stream, STREAM_WARNING,
                                 "the normal map %s lies otherwise than the color and is left out",
                                 bump.path.data) == 0;
    }
    *use = bump.use;
    return send_found(textures, &bump, true, &material->normal_map.texture_index);
}

/* assimp adds a gray material where the file has none; it is no color of the mesh. */
static bool is_assimp_default(const struct aiMaterial *source, const struct aiColor4D *color)
{
    struct aiString name = {0};
    (void)aiGetMaterialString(source, AI_MATKEY_NAME, &name);
    return (name.length == 0 || strcmp(name.data, AI_DEFAULT_MATERIAL_NAME) == 0) && color->r == DEFAULT_GRAY &&
           color->g == DEFAULT_GRAY && color->b == DEFAULT_GRAY;
}

static struct aiColor4D base_color(const struct aiMaterial *source)
{
    const struct aiColor4D white = {1, 1, 1, 1};
    struct aiColor4D base = white, color = white;
    const bool has_base = aiGetMaterialColor(source, AI_MATKEY_BASE_COLOR, &base) == aiReturn_SUCCESS;
    if (aiGetMaterialColor(source, AI_MATKEY_COLOR_DIFFUSE, &color) != aiReturn_SUCCESS) {
        color = base;
    }
    if (is_assimp_default(source, &color)) {
        return white;
    }
    /* Where there is a base color (glTF), its alpha is the opacity already. */
    ai_real opacity = 1;
    if (!has_base && aiGetMaterialFloatArray(source, AI_MATKEY_OPACITY, &opacity, NULL) == aiReturn_SUCCESS) {
        color.a *= opacity;
    }
    return color;
}

/* The base color of a material, without textures. */
static svo_material base_of(const struct aiMaterial *source)
{
    const struct aiColor4D color = base_color(source);
    return (svo_material){.rgba = {svo_i_import_color_byte(color.r), svo_i_import_color_byte(color.g),
                                   svo_i_import_color_byte(color.b), svo_i_import_color_byte(color.a)},
                          .texture_index = SVO_NO_TEXTURE};
}

/* What a material does besides its color: emission, specular color and its exponent. */
static void take_finish(const struct aiMaterial *source, svo_finish *finish)
{
    const struct aiColor4D black = {0, 0, 0, 1};
    struct aiColor4D emission = black, specular = black;
    ai_real exponent = 0;
    /* Where there is none, the values stay. */
    (void)aiGetMaterialColor(source, AI_MATKEY_COLOR_EMISSIVE, &emission);
    (void)aiGetMaterialColor(source, AI_MATKEY_COLOR_SPECULAR, &specular);
    (void)aiGetMaterialFloatArray(source, AI_MATKEY_SHININESS, &exponent, NULL);
    *finish = (svo_finish){.emission = {emission.r, emission.g, emission.b},
                           .specular = {specular.r, specular.g, specular.b},
                           .exponent = exponent};
    svo_i_import_tame_finish(finish);
}

/* ---- the scene ---- */

/* What is known of a mesh of the scene before its triangles are read. */
typedef struct mesh_plan {
    uint16_t material;
    const struct aiVector3D *uvs; /* the channel its texture wants; NULL: untextured */
    texture_use use;
} mesh_plan;

typedef struct scene_reader {
    const struct aiScene *scene;
    const char *path;
    int stream;
    bool normal_maps; /* are read */
    gather *mesh;
    mesh_plan *plans;
    const char *failure;
    size_t polygon_count; /* left over by assimp's triangulation */
    size_t small_count; /* points and lines */
} scene_reader;

/* parent applied after the node's own matrix. */
static transform combine(const transform *parent, const struct aiMatrix4x4 *node)
{
    const double local[3][4] = {{node->a1, node->a2, node->a3, node->a4},
                                {node->b1, node->b2, node->b3, node->b4},
                                {node->c1, node->c2, node->c3, node->c4}};
    return transform_combine(parent, local);
}

/* Vertices and triangles */

static gather_vertex make_vertex(const scene_reader *reader, const transform *t, unsigned mesh_index,
                                 unsigned vertex_index)
{
    const struct aiMesh *source = reader->scene->mMeshes[mesh_index];
    const mesh_plan *plan = &reader->plans[mesh_index];
    gather_vertex vertex = {.color = {255, 255, 255, 255}};
    const struct aiVector3D *position = &source->mVertices[vertex_index];
    transform_point(t, (const double[]){position->x, position->y, position->z}, vertex.position);
    if (source->mNormals != NULL) {
        const struct aiVector3D *normal = &source->mNormals[vertex_index];
        transform_normal(t, (const double[]){normal->x, normal->y, normal->z}, vertex.normal);
    }
    if (source->mColors[0] != NULL) {
        const struct aiColor4D *color = &source->mColors[0][vertex_index];
        const float channels[4] = {color->r, color->g, color->b, color->a};
        for (int i = 0; i < 4; ++i) {
            vertex.color[i] = svo_i_import_color_byte(channels[i]);
        }
    }
    if (plan->uvs != NULL) {
        const struct aiVector3D *uv = &plan->uvs[vertex_index];
        vertex.uv[0] = uv->x * plan->use.scale[0] + plan->use.offset[0];
        /* assimp's v = 0 is the last row, svo_texture's the first */
        vertex.uv[1] = 1 - (uv->y * plan->use.scale[1] + plan->use.offset[1]);
    }
    return vertex;
}

/* Gathers a vertex at its first use. known: per vertex of the mesh its index, GATHER_NO_VERTEX before that. */
static bool corner_index(scene_reader *reader, const transform *t, unsigned mesh_index, unsigned vertex_index,
                         uint32_t *known)
{
    if (known[vertex_index] != GATHER_NO_VERTEX) {
        return true;
    }
    const gather_vertex vertex = make_vertex(reader, t, mesh_index, vertex_index);
    return svo_i_gather_vertex(reader->mesh, &vertex, &known[vertex_index]);
}

static bool gather_face(scene_reader *reader, const transform *t, unsigned mesh_index, const struct aiFace *face,
                        uint32_t *known)
{
    const struct aiMesh *source = reader->scene->mMeshes[mesh_index];
    if (face->mNumIndices != 3) {
        *(face->mNumIndices > 3 ? &reader->polygon_count : &reader->small_count) += 1;
        return true;
    }
    uint32_t corners[3] = {GATHER_NO_VERTEX, GATHER_NO_VERTEX, GATHER_NO_VERTEX};
    for (int i = 0; i < 3; ++i) {
        const unsigned vertex_index = face->mIndices[t->mirrors && i > 0 ? 3 - i : i];
        if (vertex_index < source->mNumVertices) {
            if (!corner_index(reader, t, mesh_index, vertex_index, known)) {
                return false;
            }
            corners[i] = known[vertex_index];
        }
    }
    return svo_i_gather_triangle(reader->mesh, corners, reader->plans[mesh_index].material);
}

static bool gather_mesh(scene_reader *reader, const transform *t, unsigned mesh_index)
{
    if (mesh_index >= reader->scene->mNumMeshes) {
        reader->failure = "a node names a mesh that does not exist";
        return false;
    }
    const struct aiMesh *source = reader->scene->mMeshes[mesh_index];
    uint32_t *known = malloc(((size_t)source->mNumVertices + 1) * sizeof *known);
    bool done = known != NULL;
    for (unsigned i = 0; done && i < source->mNumVertices; ++i) {
        known[i] = GATHER_NO_VERTEX;
    }
    for (unsigned i = 0; done && i < source->mNumFaces; ++i) {
        done = gather_face(reader, t, mesh_index, &source->mFaces[i], known);
    }
    free(known);
    if (!done) {
        reader->failure = out_of_memory;
    }
    return done;
}

static bool gather_node(scene_reader *reader, const struct aiNode *node, const transform *parent, int depth)
{
    if (depth > NODE_DEPTH_MAX) {
        reader->failure = "its nodes are nested more than 1000 deep";
        return false;
    }
    const transform t = combine(parent, &node->mTransformation);
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
        if (!gather_mesh(reader, &t, node->mMeshes[i])) {
            return false;
        }
    }
    for (unsigned i = 0; i < node->mNumChildren; ++i) {
        if (!gather_node(reader, node->mChildren[i], &t, depth + 1)) {
            return false;
        }
    }
    return true;
}

/* Planning */

static bool has_uv_channel(const struct aiMesh *source)
{
    for (unsigned i = 0; i < AI_MAX_NUMBER_OF_TEXTURECOORDS; ++i) {
        if (source->mTextureCoords[i] != NULL) {
            return true;
        }
    }
    return false;
}

/* The gathered materials made from one of assimp's. */
typedef struct material_entry {
    uint32_t index[2]; /* without and with its texture; UINT32_MAX: not made yet */
    texture_use use;
} material_entry;

/* Gathers the material, with or without its textures, unless an earlier mesh did. New textures are sent, or a warning
   where one cannot be read. Returns false when memory runs out or the parent has closed the pipe. */
static bool add_material(scene_reader *reader, texture_list *textures, material_entry *entry, unsigned source_index,
                         bool textured)
{
    const struct aiMaterial *source = reader->scene->mMaterials[source_index];
    gather_material material = svo_i_gather_plain_material();
    if (entry->index[textured] != UINT32_MAX) {
        return true;
    }
    if (reader->mesh->material_count == MATERIALS_MAX) {
        reader->failure = "it has more than 65535 materials";
        return false;
    }
    material.base = base_of(source);
    take_finish(source, &material.finish);
    if ((textured && !add_textures(textures, source, reader->normal_maps, &material, &entry->use)) ||
        !svo_i_gather_material(reader->mesh, &material)) {
        return false;
    }
    entry->index[textured] = (uint32_t)(reader->mesh->material_count - 1);
    return true;
}

static bool plan_mesh(scene_reader *reader, texture_list *textures, material_entry *entries, unsigned mesh_index)
{
    const struct aiMesh *source = reader->scene->mMeshes[mesh_index];
    gather *mesh = reader->mesh;
    mesh_plan *plan = &reader->plans[mesh_index];
    mesh->has_normals = mesh->has_normals || source->mNormals != NULL;
    mesh->has_colors = mesh->has_colors || source->mColors[0] != NULL;
    if (source->mMaterialIndex >= reader->scene->mNumMaterials) {
        reader->failure = "a mesh names a material that does not exist";
        return false;
    }
    material_entry *entry = &entries[source->mMaterialIndex];
    const bool textured = has_uv_channel(source);
    if (!add_material(reader, textures, entry, source->mMaterialIndex, textured)) {
        return false;
    }
    plan->material = (uint16_t)entry->index[textured];
    if (textured && svo_i_gather_is_textured(&mesh->materials[plan->material])) {
        const unsigned channel = entry->use.uv_channel;
        plan->use = entry->use;
        plan->uvs = channel < AI_MAX_NUMBER_OF_TEXTURECOORDS ? source->mTextureCoords[channel] : NULL;
        plan->uvs = plan->uvs != NULL ? plan->uvs : source->mTextureCoords[0];
        mesh->has_uvs = mesh->has_uvs || plan->uvs != NULL;
    }
    return true;
}

static bool plan_meshes(scene_reader *reader, texture_list *textures)
{
    const struct aiScene *scene = reader->scene;
    material_entry *entries = malloc(((size_t)scene->mNumMaterials + 1) * sizeof *entries);
    reader->plans = calloc((size_t)scene->mNumMeshes + 1, sizeof *reader->plans);
    bool done = entries != NULL && reader->plans != NULL;
    for (unsigned i = 0; done && i < scene->mNumMaterials; ++i) {
        entries[i] = (material_entry){.index = {UINT32_MAX, UINT32_MAX}};
    }
    for (unsigned i = 0; done && i < scene->mNumMeshes; ++i) {
        done = plan_mesh(reader, textures, entries, i);
    }
    free(entries);
    return done;
}

/* Gathers every triangle of the scene in node order, textures and warnings going to the stream on the way. Returns
   NULL, or why there is no mesh: a static string. */
static const char *gather_scene(const struct aiScene *scene, const mesh_reader *to)
{
    const int stream = to->stream;
    gather *mesh = to->mesh;
    if (scene->mRootNode == NULL) {
        return "no triangles";
    }
    scene_reader reader = {
        .scene = scene, .path = to->path, .stream = stream, .normal_maps = to->normal_maps, .mesh = mesh};
    texture_list textures = {.scene = scene, .mesh_path = to->path, .stream = stream, .work = to->work};
    const transform world = transform_identity();
    if (plan_meshes(&reader, &textures) && gather_node(&reader, scene->mRootNode, &world, 0)) {
        if (mesh->triangle_count == 0) {
            reader.failure = "no triangles";
        }
        if (reader.polygon_count > 0) {
            (void)svo_i_stream_text(stream, STREAM_WARNING, "%zu polygons could not be triangulated and are left out",
                                    reader.polygon_count);
        }
        if (reader.small_count > 0) {
            (void)svo_i_stream_text(stream, STREAM_WARNING, "%zu points and lines are left out", reader.small_count);
        }
        svo_i_gather_drop_plain_materials(mesh);
    } else if (reader.failure == NULL) {
        reader.failure = out_of_memory;
    }
    svo_i_texture_list_free(&textures);
    free(reader.plans);
    return reader.failure;
}

/* ---- reading ---- */

/* No post-processing that moves, joins or removes geometry: the file's triangles are voxelized as they are. */
static const struct aiScene *read_scene(const char *path, scene_files *files)
{
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    if (properties == NULL) {
        return NULL;
    }
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    const struct aiScene *scene = aiImportFileExWithProperties(path, aiProcess_Triangulate, &files->io, properties);
    aiReleasePropertyStore(properties);
    return scene;
}

svo_status svo_i_read_scene(const mesh_reader *reader)
{
    scene_files files;
    watch_files(reader->stream, reader->path, &files);
    const struct aiScene *scene = read_scene(reader->path, &files);
    if (scene == NULL && files.trouble != NULL) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "cannot be read: %s", files.trouble);
    }
    if (scene == NULL) {
        const char *words = aiGetErrorString();
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "%s",
                          words != NULL && words[0] != '\0' ? words : "not understood");
    }
    const char *failure = gather_scene(scene, reader);
    aiReleaseImport(scene);
    if (failure != NULL) {
        return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "%s", failure);
    }
    return files.result == 0 ? SVO_OK : SVO_FILE_ERROR;
}
