/* SPDX-License-Identifier: MIT */
/*
 * Traverses assimp's scene: applies node transforms, fills in attributes that only some meshes have, and gathers every
 * triangle. Degenerate triangles are kept, since they touch voxels as well.
 */
#include "io/import_scene.h"

#include <stdlib.h>

#include "io/import_material.h"
#include "io/import_stream.h"
#include "io/import_transform.h"

#define NODE_DEPTH_MAX 1000 /* bounds the recursion; deeper files are damaged */
#define MATERIALS_MAX  UINT16_MAX

static const char out_of_memory[] = "out of memory";

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

/* Gathers the material, with or without its texture, unless an earlier mesh did. */
static bool add_material(scene_reader *reader, texture_list *textures, material_entry *entry, unsigned source_index,
                         bool textured)
{
    const struct aiMaterial *source = reader->scene->mMaterials[source_index];
    svo_material material;
    svo_finish finish;
    texture_use use;
    if (entry->index[textured] != UINT32_MAX) {
        return true;
    }
    if (reader->mesh->material_count == MATERIALS_MAX) {
        reader->failure = "it has more than 65535 materials";
        return false;
    }
    svo_i_import_finish(source, &finish);
    if (!svo_i_import_material(textures, source, textured, &material, &use) ||
        !svo_i_gather_material(reader->mesh, &material, &finish)) {
        return false;
    }
    entry->index[textured] = (uint32_t)(reader->mesh->material_count - 1);
    if (textured) {
        entry->use = use;
    }
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
    if (textured && mesh->materials[plan->material].texture_index != SVO_NO_TEXTURE) {
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

const char *svo_i_import_gather_scene(const struct aiScene *scene, const char *path, int stream, gather *mesh)
{
    if (scene->mRootNode == NULL) {
        return "no triangles";
    }
    scene_reader reader = {.scene = scene, .path = path, .stream = stream, .mesh = mesh};
    texture_list textures = {.scene = scene, .mesh_path = path, .stream = stream};
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
