/* SPDX-License-Identifier: MIT */
/*
 * The tables of an OBJ file as a mesh: faces in the order of the file, cut into triangles. A vertex of the mesh is a
 * position with texture coordinates and a normal; each combination is made once.
 */
#include "io/import_obj_mesh.h"

#include <inttypes.h>

#include "core/message.h"
#include "io/import_polygon.h"

/* A combination that was gathered, in a chain of those with the same position. */
typedef struct known_vertex {
    uint32_t uv, normal;
    uint32_t index; /* in the mesh */
    uint32_t next; /* OBJ_NONE: the last */
} known_vertex;

typedef struct obj_mesh {
    const mesh_reader *reader;
    obj_file *file;
    uint32_t *first; /* per position its chain, or its index where all are plain; OBJ_NONE: not used so far */
    item_list known; /* of known_vertex */
    gather_vertex *plain; /* per position its vertex, where the file has nothing else; else NULL */
    uint32_t *equal; /* then per position the first that is equal */
    texture_list textures;
    polygon shape;
    bool textured; /* the run that is gathered */
    const mtl_material *material; /* the same; NULL: none */
    uint64_t bad_uv_count, bad_normal_count; /* corners that name what does not exist */
} obj_mesh;

static gather_vertex make_vertex(const obj_mesh *mesh, const obj_corner *corner)
{
    const obj_file *file = mesh->file;
    gather_vertex vertex = {.color = {255, 255, 255, 255}};
    memcpy(vertex.position, (const float *)file->positions.items + 3 * (size_t)corner->position,
           sizeof vertex.position);
    if (corner->normal != OBJ_NONE) {
        memcpy(vertex.normal, (const float *)file->normals.items + 3 * (size_t)corner->normal, sizeof vertex.normal);
    }
    if (corner->position < file->colors.count) {
        memcpy(vertex.color, (const uint8_t *)file->colors.items + 4 * (size_t)corner->position, sizeof vertex.color);
    }
    if (mesh->textured) {
        static const float none[2] = {0, 0};
        const float *uv = corner->uv != OBJ_NONE ? (const float *)file->uvs.items + 2 * (size_t)corner->uv : none;
        const float *scale = mesh->material->uv_scale, *offset = mesh->material->uv_offset;
        vertex.uv[0] = uv[0] * scale[0] + offset[0];
        vertex.uv[1] = 1 - (uv[1] * scale[1] + offset[1]); /* v = 0 is OBJ's last row and svo_texture's first */
    }
    return vertex;
}

/* The corner without what does not exist and what its run does not use. */
static obj_corner check_corner(obj_mesh *mesh, const obj_corner *source)
{
    obj_corner corner = *source;
    if (corner.uv != OBJ_NONE && corner.uv >= mesh->file->uvs.count) {
        ++mesh->bad_uv_count;
        corner.uv = OBJ_NONE;
    }
    if (corner.normal != OBJ_NONE && corner.normal >= mesh->file->normals.count) {
        ++mesh->bad_normal_count;
        corner.normal = OBJ_NONE;
    }
    mesh->reader->mesh->has_normals = mesh->reader->mesh->has_normals || corner.normal != OBJ_NONE;
    return corner;
}

static svo_status plain_index(obj_mesh *mesh, uint32_t position, uint32_t *index)
{
    uint32_t *known = &mesh->first[mesh->equal[position]];
    if (*known == OBJ_NONE && !svo_i_gather_append(mesh->reader->mesh, &mesh->plain[mesh->equal[position]], known)) {
        return svo_i_read_out_of_memory(mesh->reader);
    }
    *index = *known;
    mesh->first[position] = *known;
    return SVO_OK;
}

static svo_status corner_index(obj_mesh *mesh, const obj_corner *source, uint32_t *index)
{
    const obj_corner corner = check_corner(mesh, source);
    if (mesh->plain != NULL) {
        return plain_index(mesh, corner.position, index);
    }
    /* Texture coordinates that are not used would only make equal vertices different. Those of another run's material
       are transformed differently, and compared when the vertex is gathered. */
    const uint32_t uv = mesh->textured ? corner.uv : OBJ_NONE - 1;
    for (uint32_t i = mesh->first[corner.position]; i != OBJ_NONE;) {
        const known_vertex *known = (const known_vertex *)mesh->known.items + i;
        if (known->uv == uv && known->normal == corner.normal) {
            *index = known->index;
            return SVO_OK;
        }
        i = known->next;
    }
    const gather_vertex vertex = make_vertex(mesh, &corner);
    known_vertex *known = list_add(&mesh->known, sizeof *known);
    if (known == NULL || mesh->known.count >= OBJ_NONE || !svo_i_gather_vertex(mesh->reader->mesh, &vertex, index)) {
        return svo_i_read_out_of_memory(mesh->reader);
    }
    *known = (known_vertex){.uv = uv, .normal = corner.normal, .index = *index, .next = mesh->first[corner.position]};
    mesh->first[corner.position] = (uint32_t)mesh->known.count - 1;
    return SVO_OK;
}

static svo_status gather_triangle(obj_mesh *mesh, const obj_corner *corners, const uint32_t cut[3], uint16_t material)
{
    uint32_t indices[3];
    for (int i = 0; i < 3; ++i) {
        SVO_I_TRY(corner_index(mesh, &corners[cut[i]], &indices[i]));
    }
    return svo_i_gather_triangle(mesh->reader->mesh, indices, material) ? SVO_OK
                                                                        : svo_i_read_out_of_memory(mesh->reader);
}

static svo_status gather_face(obj_mesh *mesh, const obj_corner *corners, uint32_t corner_count, uint16_t material)
{
    static const uint32_t whole[3] = {0, 1, 2};
    if (corner_count == 3) {
        return gather_triangle(mesh, corners, whole, material);
    }
    if (!svo_i_polygon_reserve(&mesh->shape, corner_count)) {
        return svo_i_read_out_of_memory(mesh->reader);
    }
    const float *positions = mesh->file->positions.items;
    for (uint32_t i = 0; i < corner_count; ++i) {
        memcpy(mesh->shape.corners[i], positions + 3 * (size_t)corners[i].position, sizeof mesh->shape.corners[i]);
    }
    svo_i_polygon_cut(&mesh->shape, corner_count);
    for (uint32_t i = 0; i < corner_count - 2; ++i) {
        SVO_I_TRY(gather_triangle(mesh, corners, mesh->shape.triangles + 3 * (size_t)i, material));
    }
    return SVO_OK;
}

/* Vertices of a run whose texture coordinates are transformed otherwise than those before are other vertices. */
static void forget_known(obj_mesh *mesh)
{
    for (size_t i = 0; i < mesh->known.count; ++i) {
        known_vertex *known = (known_vertex *)mesh->known.items + i;
        known->uv = known->uv < OBJ_NONE - 1 ? OBJ_NONE - 2 : known->uv;
    }
}

static bool transforms_alike(const mtl_material *a, const mtl_material *b)
{
    return a == NULL || b == NULL ||
           (a->uv_scale[0] == b->uv_scale[0] && a->uv_scale[1] == b->uv_scale[1] &&
            a->uv_offset[0] == b->uv_offset[0] && a->uv_offset[1] == b->uv_offset[1]);
}

static svo_status begin_run(obj_mesh *mesh, const obj_run *run, uint32_t *default_index, uint16_t *material)
{
    const mesh_reader *reader = mesh->reader;
    const bool has_uvs = run->has_uvs && mesh->file->uvs.count > 0;
    SVO_I_TRY(svo_i_mtl_gather(&mesh->file->library, reader, &mesh->textures, run->material, has_uvs, default_index,
                               material));
    mesh->textured = reader->mesh->materials[*material].texture_index != SVO_NO_TEXTURE;
    if (mesh->textured) {
        const mtl_material *source = svo_i_mtl_get(&mesh->file->library, run->material);
        if (!transforms_alike(mesh->material, source)) {
            forget_known(mesh);
        }
        mesh->material = source;
        reader->mesh->has_uvs = true;
    }
    return SVO_OK;
}

static svo_status gather_runs(obj_mesh *mesh)
{
    const obj_file *file = mesh->file;
    const obj_corner *corners = file->corners.items;
    const uint32_t *corner_count = file->faces.items;
    uint32_t default_index = MTL_NO_MATERIAL;
    uint16_t material = 0;
    for (size_t i = 0; i < file->runs.count; ++i) {
        const obj_run *run = (const obj_run *)file->runs.items + i;
        SVO_I_TRY(begin_run(mesh, run, &default_index, &material));
        for (uint64_t k = 0; k < run->face_count; ++k) {
            SVO_I_TRY(gather_face(mesh, corners, *corner_count, material));
            corners += *corner_count++;
        }
    }
    return SVO_OK;
}

static void warn(const obj_mesh *mesh)
{
    const mesh_reader *reader = mesh->reader;
    uint64_t used_count = 0;
    for (size_t i = 0; i < mesh->file->positions.count; ++i) {
        used_count += mesh->first[i] != OBJ_NONE ? 1 : 0;
    }
    svo_i_read_count_vertices(reader, used_count, mesh->file->positions.count);
    if (mesh->bad_uv_count > 0) {
        svo_i_read_warn(reader, "%" PRIu64 " corners name texture coordinates that do not exist; the file has %zu",
                        mesh->bad_uv_count, mesh->file->uvs.count);
    }
    if (mesh->bad_normal_count > 0) {
        svo_i_read_warn(reader, "%" PRIu64 " corners name normals that do not exist; the file has %zu",
                        mesh->bad_normal_count, mesh->file->normals.count);
    }
    if (mesh->shape.crossed_count > 0) {
        svo_i_read_warn(reader, "%" PRIu64 " polygons cross themselves; their triangles overlap",
                        mesh->shape.crossed_count);
    }
}

/* The vertices of a file without texture coordinates and normals, and which of them are equal. */
static svo_status match_plain(obj_mesh *mesh)
{
    const size_t count = mesh->file->positions.count;
    mesh->plain = malloc((count + 1) * sizeof *mesh->plain);
    mesh->equal = malloc((count + 1) * sizeof *mesh->equal);
    if (mesh->plain == NULL || mesh->equal == NULL) {
        return svo_i_read_out_of_memory(mesh->reader);
    }
    for (size_t i = 0; i < count; ++i) {
        const obj_corner corner = {.position = (uint32_t)i, .uv = OBJ_NONE, .normal = OBJ_NONE};
        mesh->plain[i] = make_vertex(mesh, &corner);
    }
    return svo_i_gather_match(mesh->plain, count, mesh->equal) ? SVO_OK : svo_i_read_out_of_memory(mesh->reader);
}

svo_status svo_i_obj_gather(const mesh_reader *reader, obj_file *file)
{
    svo_status status = SVO_OK;
    obj_mesh mesh = {.reader = reader, .file = file, .textures = {.mesh_path = reader->path, .stream = reader->stream}};
    const size_t position_count = file->positions.count;
    const bool is_plain = file->uvs.count == 0 && file->normals.count == 0;
    mesh.first = malloc((position_count + 1) * sizeof *mesh.first);
    if (mesh.first == NULL || !svo_i_gather_reserve(reader->mesh, position_count, file->faces.count, !is_plain)) {
        free(mesh.first);
        return svo_i_read_out_of_memory(reader);
    }
    memset(mesh.first, 0xff, position_count * sizeof *mesh.first);
    SVO_I_TRY_CLEANUP(is_plain ? match_plain(&mesh) : SVO_OK);
    reader->mesh->has_colors = file->colors.count > 0;
    SVO_I_TRY_CLEANUP(gather_runs(&mesh));
    svo_i_gather_drop_plain_materials(reader->mesh);
    warn(&mesh);
cleanup:
    free(mesh.first);
    free(mesh.plain);
    free(mesh.equal);
    free(mesh.known.items);
    svo_i_texture_list_free(&mesh.textures);
    svo_i_polygon_free(&mesh.shape);
    return status;
}
