/* SPDX-License-Identifier: MIT */
/*
 * OBJ in the import child, after its statements are read as tables: MTL files, whose materials get a finish, and the
 * faces in the order of the file, cut into triangles. A vertex of the mesh is a position with texture coordinates and a
 * normal; each combination is made once.
 */
#define _POSIX_C_SOURCE 200809L
#include "io/import_obj_mesh.h"

#include <inttypes.h>
#include <math.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/message.h"
#include "io/import_faces.h"
#include "io/import_text.h"

/* ---- materials ---- */

#define DEFAULT_GRAY  0.6f /* of a material that is used or named, but has no color */
#define DEFAULT_NAME  "DefaultMaterial" /* as some programs call the absence of a material: white */
#define MATERIALS_MAX UINT16_MAX

typedef struct mtl_reader {
    mtl_library *library;
    const mesh_reader *reader;
    text_cursor cursor;
    uint32_t current;
    uint64_t bad_count, first_bad_line;
    text_word first_bad;
} mtl_reader;

/* The library */

mtl_material *svo_i_mtl_get(const mtl_library *library, uint32_t number)
{
    return (mtl_material *)library->materials.items + number;
}

static size_t find_slot(const mtl_library *library, const char *name, size_t length)
{
    size_t slot = (size_t)XXH3_64bits(name, length) & (library->slot_count - 1);
    while (library->slots[slot] != MTL_NO_MATERIAL) {
        const char *other = svo_i_mtl_get(library, library->slots[slot])->name;
        if (strlen(other) == length && memcmp(other, name, length) == 0) {
            break;
        }
        slot = (slot + 1) & (library->slot_count - 1);
    }
    return slot;
}

/* Keeps the table at most half full. */
static bool grow_slots(mtl_library *library)
{
    if (2 * (library->materials.count + 1) <= library->slot_count) {
        return true;
    }
    const size_t slot_count = library->slot_count == 0 ? 64 : 2 * library->slot_count;
    uint32_t *slots = malloc(slot_count * sizeof *slots);
    if (slots == NULL) {
        return false;
    }
    memset(slots, 0xff, slot_count * sizeof *slots);
    free(library->slots);
    library->slots = slots;
    library->slot_count = slot_count;
    for (uint32_t i = 0; i < library->materials.count; ++i) {
        const char *name = svo_i_mtl_get(library, i)->name;
        slots[find_slot(library, name, strlen(name))] = i;
    }
    return true;
}

uint32_t svo_i_mtl_find(mtl_library *library, const char *name, size_t length)
{
    if (memchr(name, '\0', length) != NULL) {
        length = strlen(name);
    }
    if (!grow_slots(library)) {
        return MTL_NO_MATERIAL;
    }
    const size_t slot = find_slot(library, name, length);
    if (library->slots[slot] != MTL_NO_MATERIAL) {
        return library->slots[slot];
    }
    char *copy = text_copy(name, length);
    mtl_material *material = copy != NULL ? list_add(&library->materials, sizeof *material) : NULL;
    if (material == NULL) {
        free(copy);
        return MTL_NO_MATERIAL;
    }
    *material = (mtl_material){.name = copy,
                               .diffuse = {DEFAULT_GRAY, DEFAULT_GRAY, DEFAULT_GRAY},
                               .opacity = 1,
                               .index = {MTL_NO_MATERIAL, MTL_NO_MATERIAL}};
    library->slots[slot] = (uint32_t)library->materials.count - 1;
    return library->slots[slot];
}

void svo_i_mtl_free(mtl_library *library)
{
    for (uint32_t i = 0; i < library->materials.count; ++i) {
        free(svo_i_mtl_get(library, i)->name);
        free(svo_i_mtl_get(library, i)->color.name);
        free(svo_i_mtl_get(library, i)->bump.name);
    }
    free(library->materials.items);
    free(library->slots);
    *library = (mtl_library){.slot_count = 0};
}

/* Statements */

static bool take_number(text_cursor *cursor, float *value)
{
    (void)text_skip_blanks(cursor);
    const char *behind = svo_i_number_float(cursor->at, cursor->end, value);
    if (behind != NULL) {
        cursor->at = behind;
        text_skip_word(cursor);
    }
    return behind != NULL;
}

static void note_bad(mtl_reader *mtl)
{
    if (mtl->bad_count++ == 0) {
        mtl->first_bad = text_copy_word(&mtl->cursor);
        mtl->first_bad_line = mtl->cursor.line;
    }
}

/* "Kd r [g b]"; one number is for all three. Spectral curves and CIE coordinates are not read. */
static void read_color(mtl_reader *mtl, float color[3])
{
    float rgb[3];
    if (!take_number(&mtl->cursor, &rgb[0])) {
        note_bad(mtl);
        return;
    }
    if (!take_number(&mtl->cursor, &rgb[1]) || !take_number(&mtl->cursor, &rgb[2])) {
        rgb[1] = rgb[2] = rgb[0];
    }
    memcpy(color, rgb, sizeof rgb);
}

static void read_exponent(mtl_reader *mtl, mtl_material *material)
{
    if (!take_number(&mtl->cursor, &material->finish.exponent)) {
        note_bad(mtl);
    }
}

static void read_opacity(mtl_reader *mtl, mtl_material *material, bool is_transparency)
{
    float value = 1;
    (void)text_skip_blanks(&mtl->cursor);
    (void)text_take_keyword(&mtl->cursor, "-halo");
    if (take_number(&mtl->cursor, &value)) {
        material->opacity = is_transparency ? 1 - value : value;
    } else {
        note_bad(mtl);
    }
}

/* Up to three numbers behind "-o", "-s" or "-t", the first two of which are kept. */
static void read_pair(text_cursor *cursor, float pair[2])
{
    float value = 0;
    for (int i = 0; i < 3; ++i) {
        text_cursor at = *cursor;
        if (!take_number(&at, &value)) {
            return;
        }
        *cursor = at;
        if (i < 2) {
            pair[i] = value;
        }
    }
}

/* One option of a texture statement and its values. */
static void read_texture_option(mtl_reader *mtl, mtl_texture *texture)
{
    text_cursor *cursor = &mtl->cursor;
    float ignored[2];
    if (text_take_keyword(cursor, "-clamp")) {
        (void)text_skip_blanks(cursor);
        texture->clamps = text_take_keyword(cursor, "on");
        text_skip_word(cursor);
    } else if (text_take_keyword(cursor, "-o")) {
        read_pair(cursor, texture->uv_offset);
    } else if (text_take_keyword(cursor, "-s")) {
        read_pair(cursor, texture->uv_scale);
    } else if (text_take_keyword(cursor, "-t") || text_take_keyword(cursor, "-mm")) {
        read_pair(cursor, ignored);
    } else if (text_take_keyword(cursor, "-bm")) {
        (void)take_number(cursor, &texture->bump);
    } else {
        text_skip_word(cursor);
        (void)text_skip_blanks(cursor);
        text_skip_word(cursor);
    }
}

static svo_status read_texture(mtl_reader *mtl, mtl_texture *texture)
{
    size_t length = 0;
    free(texture->name);
    *texture = (mtl_texture){.uv_scale = {1, 1}, .bump = 1};
    while (text_skip_blanks(&mtl->cursor) && *mtl->cursor.at == '-') {
        read_texture_option(mtl, texture);
    }
    const char *path = text_rest_of_line(&mtl->cursor, &length);
    texture->name = text_copy(path, length);
    return texture->name != NULL ? SVO_OK : svo_i_read_out_of_memory(mtl->reader);
}

static svo_status read_name(mtl_reader *mtl)
{
    size_t length = 0;
    const char *name = text_rest_of_line(&mtl->cursor, &length);
    mtl->current = svo_i_mtl_find(mtl->library, name, length);
    if (mtl->current == MTL_NO_MATERIAL) {
        return svo_i_read_out_of_memory(mtl->reader);
    }
    svo_i_mtl_get(mtl->library, mtl->current)->is_defined = true;
    return SVO_OK;
}

static svo_status read_statement(mtl_reader *mtl)
{
    text_cursor *cursor = &mtl->cursor;
    if (text_take_keyword(cursor, "newmtl")) {
        return read_name(mtl);
    }
    if (mtl->current == MTL_NO_MATERIAL) {
        return SVO_OK;
    }
    mtl_material *material = svo_i_mtl_get(mtl->library, mtl->current);
    if (text_take_keyword(cursor, "Kd")) {
        read_color(mtl, material->diffuse);
    } else if (text_take_keyword(cursor, "Ke")) {
        read_color(mtl, material->finish.emission);
    } else if (text_take_keyword(cursor, "Ks")) {
        read_color(mtl, material->finish.specular);
    } else if (text_take_keyword(cursor, "Ns")) {
        read_exponent(mtl, material);
    } else if (text_take_keyword(cursor, "map_Kd")) {
        return read_texture(mtl, &material->color);
    } else if (text_take_keyword(cursor, "norm")) {
        material->has_norm = true;
        return read_texture(mtl, &material->bump);
    } else if (!material->has_norm && (text_take_keyword(cursor, "map_Bump") || text_take_keyword(cursor, "map_bump") ||
                                       text_take_keyword(cursor, "bump"))) {
        return read_texture(mtl, &material->bump);
    } else if (text_take_keyword(cursor, "d")) {
        read_opacity(mtl, material, false);
    } else if (text_take_keyword(cursor, "Tr")) {
        read_opacity(mtl, material, true);
    }
    return SVO_OK;
}

svo_status svo_i_mtl_read(mtl_library *library, const mesh_reader *reader, const char *name, const char *bytes,
                          size_t byte_count)
{
    mtl_reader mtl = {.library = library,
                      .reader = reader,
                      .cursor = {.at = bytes, .end = bytes + byte_count, .line = 1},
                      .current = MTL_NO_MATERIAL};
    for (; mtl.cursor.at != mtl.cursor.end; text_skip_line(&mtl.cursor)) {
        if (text_skip_blanks(&mtl.cursor)) {
            SVO_I_TRY(read_statement(&mtl));
        }
    }
    if (mtl.bad_count > 0) {
        svo_i_read_warn(reader, "%s: %" PRIu64 " values are not read; the first is '%s' in line %" PRIu64, name,
                        mtl.bad_count, mtl.first_bad.text, mtl.first_bad_line);
    }
    return SVO_OK;
}

/* Gathering */

static svo_material base_of(const mtl_material *source)
{
    svo_material material = svo_i_gather_plain_material().base;
    const bool is_gray =
        source->diffuse[0] == DEFAULT_GRAY && source->diffuse[1] == DEFAULT_GRAY && source->diffuse[2] == DEFAULT_GRAY;
    if (is_gray && (source->name[0] == '\0' || strcmp(source->name, DEFAULT_NAME) == 0)) {
        return material;
    }
    for (int i = 0; i < 3; ++i) {
        material.rgba[i] = svo_i_import_color_byte(source->diffuse[i]);
    }
    material.rgba[3] = svo_i_import_color_byte(source->opacity);
    return material;
}

static bool is_named(const mtl_texture *texture)
{
    return texture->name != NULL && texture->name[0] != '\0';
}

/* The texture whose transform coordinates get. */
static const mtl_texture *placing_texture(const mtl_material *material)
{
    return is_named(&material->color) ? &material->color : &material->bump;
}

static bool placed_alike(const mtl_texture *a, const mtl_texture *b)
{
    return a->uv_scale[0] == b->uv_scale[0] && a->uv_scale[1] == b->uv_scale[1] && a->uv_offset[0] == b->uv_offset[0] &&
           a->uv_offset[1] == b->uv_offset[1];
}

static svo_status load_texture(const mesh_reader *reader, texture_list *textures, const mtl_texture *texture,
                               bool is_bump, uint32_t *index)
{
    const svo_wrap wrap = texture->clamps ? SVO_WRAP_CLAMP : SVO_WRAP_REPEAT;
    const texture_source image = {
        .name = texture->name, .wrap_u = wrap, .wrap_v = wrap, .alpha_from = TEXTURE_KEEP_ALPHA, .is_bump = is_bump};
    return svo_i_import_texture(textures, &image, index) ? SVO_OK : svo_i_read_out_of_memory(reader);
}

/* Loads and sends the textures of a material. */
static svo_status load_textures(const mesh_reader *reader, texture_list *textures, const mtl_material *source,
                                gather_material *material)
{
    if (is_named(&source->color)) {
        SVO_I_TRY(load_texture(reader, textures, &source->color, false, &material->base.texture_index));
    }
    if (!reader->normal_maps || !is_named(&source->bump)) {
        return SVO_OK;
    }
    if (!placed_alike(&source->bump, placing_texture(source))) {
        svo_i_read_warn(reader, "material %s: the normal map %s lies otherwise than the color and is left out",
                        source->name, source->bump.name);
        return SVO_OK;
    }
    material->normal_map.scale = isfinite(source->bump.bump) ? source->bump.bump : 1;
    return load_texture(reader, textures, &source->bump, !source->has_norm, &material->normal_map.texture_index);
}

/*
 * The index of a material in the gathered mesh. number: MTL_NO_MATERIAL for faces before any "usemtl", which are white.
 * textured: the faces have texture coordinates; textures are then loaded and sent.
 */
static svo_status find_material(mtl_library *library, const mesh_reader *reader, texture_list *textures,
                                uint32_t number, bool textured, uint32_t *default_index, uint16_t *index)
{
    mtl_material *source = number != MTL_NO_MATERIAL ? svo_i_mtl_get(library, number) : NULL;
    uint32_t *known = source != NULL ? &source->index[textured] : default_index;
    if (*known == MTL_NO_MATERIAL) {
        gather_material material = svo_i_gather_plain_material();
        if (reader->mesh->material_count == MATERIALS_MAX) {
            return svo_i_fail(reader->message, SVO_IMPORT_FAILED, "it has more than %d materials", MATERIALS_MAX);
        }
        if (source != NULL) {
            material.base = base_of(source);
            material.finish = source->finish;
            svo_i_import_tame_finish(&material.finish);
        }
        if (source != NULL && textured && reader->path != NULL) {
            SVO_I_TRY(load_textures(reader, textures, source, &material));
        }
        if (!svo_i_gather_material(reader->mesh, &material)) {
            return svo_i_read_out_of_memory(reader);
        }
        *known = (uint32_t)reader->mesh->material_count - 1;
    }
    *index = (uint16_t)*known;
    return SVO_OK;
}

/* ---- faces ---- */

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
        const mtl_texture *placing = placing_texture(mesh->material);
        const float *scale = placing->uv_scale, *offset = placing->uv_offset;
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
    return a == NULL || b == NULL || placed_alike(placing_texture(a), placing_texture(b));
}

static svo_status begin_run(obj_mesh *mesh, const obj_run *run, uint32_t *default_index, uint16_t *material)
{
    const mesh_reader *reader = mesh->reader;
    const bool has_uvs = run->has_uvs && mesh->file->uvs.count > 0;
    SVO_I_TRY(
        find_material(&mesh->file->library, reader, &mesh->textures, run->material, has_uvs, default_index, material));
    mesh->textured = svo_i_gather_is_textured(&reader->mesh->materials[*material]);
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

/* Which of the mesh's vertices each position became; the last one gathered, where there are several. */
static svo_status keep_file_vertices(const obj_mesh *mesh)
{
    const size_t count = mesh->file->positions.count;
    uint32_t *vertices = malloc((count + 1) * sizeof *vertices);
    if (vertices == NULL) {
        return svo_i_read_out_of_memory(mesh->reader);
    }
    for (size_t i = 0; i < count; ++i) {
        const uint32_t first = mesh->first[i];
        const bool is_index = first == OBJ_NONE || mesh->plain != NULL;
        vertices[i] = is_index ? first : ((const known_vertex *)mesh->known.items)[first].index;
    }
    mesh->reader->mesh->file_vertices = vertices;
    mesh->reader->mesh->file_vertex_count = count;
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
    obj_mesh mesh = {.reader = reader,
                     .file = file,
                     .textures = {.mesh_path = reader->path, .stream = reader->stream, .work = reader->work}};
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
    SVO_I_TRY_CLEANUP(keep_file_vertices(&mesh));
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
