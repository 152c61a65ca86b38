/* SPDX-License-Identifier: MIT */
/*
 * The mesh of a light on its device: what triangles look like, as hits name them, materials, and textures with levels
 * of half the size each, rounded up, down to a single texel. A texel of a level is the mean over its area, weighed by
 * alpha like the colors of a tree; of normal maps all weigh the same. Meshes with normal maps have the frames of these,
 * too, which follow from texture coordinates. All of it is computed on the host, so that each device has the same.
 */
#include "light/mesh.h"

#include <math.h>
#include <string.h>

#include "core/memory.h"
#include "core/mesh.h"
#include "core/struct_size.h"
#include "rays/rays.h"

static const char set_mesh[] = "svo_light_set_mesh";

/* A mesh on its way to a device. */
typedef struct mesh_job {
    svo_light *light;
    const svo_mesh *mesh;
    size_t material_count; /* 1 for a mesh without materials */
    bool has_maps; /* normal maps */
    svo_material_record *materials; /* behind them, of each the normal map, if the mesh has such */
    uint8_t *clear; /* of each material: whether it may show in part */
    uint32_t *texels;
    uint64_t texel_count;
    svo_mesh_triangle *triangles;
    svo_mesh_bend *bends; /* of them; NULL without normal maps */
    uint32_t flags; /* SVO_MESH_* */
} mesh_job;

static svo_status no_memory(const mesh_job *job, const char *what, uint64_t count)
{
    return svo_i_device_fail(job->light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %llu %s", set_mesh,
                             (unsigned long long)count, what);
}

/* ---- textures ---- */

/* The texels of all levels of a texture. */
static uint64_t count_texels(uint32_t width, uint32_t height)
{
    uint64_t count = (uint64_t)width * height;
    while (width > 1 || height > 1) {
        width = (width + 1) / 2;
        height = (height + 1) / 2;
        count += (uint64_t)width * height;
    }
    return count;
}

/* Sums of texels by weight: red, green and blue times alpha, and alpha. */
typedef struct texel_sums {
    uint64_t colors[3], alpha, weight;
} texel_sums;

static void add_texel(texel_sums *sums, uint32_t texel, uint64_t weight)
{
    const uint64_t alpha = weight * (texel >> 24);
    for (unsigned channel = 0; channel < 3; ++channel) {
        sums->colors[channel] += alpha * (texel >> 8 * channel & 255u);
    }
    sums->alpha += alpha;
    sums->weight += weight;
}

/* The mean, rounded half up; 0 of nothing. */
static uint32_t mean_texel(const texel_sums *sums)
{
    uint32_t texel = sums->weight > 0 ? (uint32_t)((2 * sums->alpha + sums->weight) / (2 * sums->weight)) << 24 : 0;
    for (unsigned channel = 0; channel < 3 && sums->alpha > 0; ++channel) {
        texel |= (uint32_t)((2 * sums->colors[channel] + sums->alpha) / (2 * sums->alpha)) << 8 * channel;
    }
    return texel;
}

/* How much of a texel of one axis lies in another one of a coarser level, in 1 / coarse of a texel. */
static uint64_t overlap(uint64_t texel, uint64_t fine, uint64_t coarse_texel, uint64_t coarse)
{
    const uint64_t begin = texel * coarse > coarse_texel * fine ? texel * coarse : coarse_texel * fine;
    const uint64_t end =
        (texel + 1) * coarse < (coarse_texel + 1) * fine ? (texel + 1) * coarse : (coarse_texel + 1) * fine;
    return end > begin ? end - begin : 0;
}

/* The mean of what a texel of the next level covers. */
static uint32_t covered_mean(const uint32_t *texels, const svo_material_record *level, uint32_t x, uint32_t y)
{
    const uint32_t columns = (level->width + 1) / 2;
    const uint32_t rows = (level->height + 1) / 2;
    const uint64_t first_row = (uint64_t)y * level->height / rows;
    const uint64_t first_column = (uint64_t)x * level->width / columns;
    texel_sums sums = {{0, 0, 0}, 0, 0};
    for (uint64_t j = first_row; j < level->height && j * rows < (uint64_t)(y + 1) * level->height; ++j) {
        const uint64_t share = overlap(j, level->height, y, rows);
        for (uint64_t i = first_column; i < level->width && i * columns < (uint64_t)(x + 1) * level->width; ++i) {
            add_texel(&sums, texels[j * level->width + i], share * overlap(i, level->width, x, columns));
        }
    }
    return mean_texel(&sums);
}

/* Makes the levels behind the first one of a texture. */
static void make_levels(uint32_t *texels, svo_material_record level)
{
    while (level.width > 1 || level.height > 1) {
        const uint32_t columns = (level.width + 1) / 2;
        const uint32_t rows = (level.height + 1) / 2;
        uint32_t *next = texels + (size_t)level.width * level.height;
        for (uint32_t y = 0; y < rows; ++y) {
            for (uint32_t x = 0; x < columns; ++x) {
                next[(size_t)y * columns + x] = covered_mean(texels, &level, x, y);
            }
        }
        texels = next;
        level.width = columns;
        level.height = rows;
    }
}

/* Whether some texel of a texture lets light through. */
static bool texture_is_clear(const svo_texture *texture)
{
    const size_t count = (size_t)texture->width * texture->height;
    uint8_t least = 255;
    for (size_t i = 0; i < count; ++i) {
        least = texture->rgba[4 * i + 3] < least ? texture->rgba[4 * i + 3] : least;
    }
    return least < 255;
}

/* Where texels begin of each texture, first as a color, then as a normal map; UINT32_MAX: it is none. */
typedef struct texel_places {
    uint32_t *offsets; /* 2 * texture_count */
    uint8_t *clear; /* texture_count: whether it lets light through */
} texel_places;

#define NO_PLACE SIZE_MAX

/* Which of the places a record of a material or a normal map has; NO_PLACE: it has no texture. */
static size_t place_of(const mesh_job *job, size_t record)
{
    const svo_mesh *mesh = job->mesh;
    const bool is_map = record >= job->material_count;
    const size_t material = is_map ? record - job->material_count : record;
    if (material >= mesh->material_count || mesh->uvs == NULL) {
        return NO_PLACE;
    }
    const uint32_t index = is_map ? mesh->normal_maps[material].texture_index : mesh->materials[material].texture_index;
    return index >= mesh->texture_count ? NO_PLACE : index + (is_map ? mesh->texture_count : 0);
}

static size_t record_count(const mesh_job *job)
{
    return job->has_maps ? 2 * job->material_count : job->material_count;
}

static bool has_normal_maps(const mesh_job *job)
{
    for (size_t i = 0; job->mesh->normal_maps != NULL && i < job->material_count; ++i) {
        if (place_of(job, job->material_count + i) != NO_PLACE) {
            return true;
        }
    }
    return false;
}

/* Places the textures of records, each once. */
static svo_status place_textures(mesh_job *job, texel_places *places)
{
    const svo_mesh *mesh = job->mesh;
    for (size_t i = 0; i < record_count(job); ++i) {
        const size_t place = place_of(job, i);
        if (place != NO_PLACE && places->offsets[place] == UINT32_MAX) {
            const svo_texture *texture = &mesh->textures[place % mesh->texture_count];
            places->offsets[place] = (uint32_t)job->texel_count;
            job->texel_count += count_texels(texture->width, texture->height);
            if (job->texel_count >= UINT32_MAX) {
                return svo_i_device_fail(job->light->device, SVO_OUT_OF_DEVICE_MEMORY,
                                         "%s: textures and their levels have %llu texels, not below 2^32 - 1", set_mesh,
                                         (unsigned long long)job->texel_count);
            }
        }
    }
    job->texels = svo_i_alloc_zeroed(&job->light->device->memory, (size_t)job->texel_count + 1, sizeof *job->texels);
    return job->texels != NULL ? SVO_OK : no_memory(job, "texels", job->texel_count);
}

/* Copies the textures that have a place, and makes their levels. */
static void fill_texels(const mesh_job *job, texel_places *places)
{
    const size_t textures = job->mesh->texture_count;
    for (size_t place = 0; place < 2 * textures; ++place) {
        const svo_texture *texture = &job->mesh->textures[place % textures];
        if (places->offsets[place] == UINT32_MAX) {
            continue;
        }
        const svo_material_record first = {.width = texture->width, .height = texture->height};
        uint32_t *texels = job->texels + places->offsets[place];
        const size_t count = (size_t)texture->width * texture->height;
        memcpy(texels, texture->rgba, 4 * count);
        if (place < textures) {
            places->clear[place] = texture_is_clear(texture);
        } else {
            for (size_t i = 0; i < count; ++i) {
                texels[i] |= 0xff000000u; /* a map's alpha weighs nothing */
            }
        }
        make_levels(texels, first);
    }
}

/* ---- materials ---- */

static void fill_record(mesh_job *job, size_t index, const texel_places *places)
{
    const size_t place = place_of(job, index);
    svo_material_record *to = &job->materials[index];
    if (index < job->mesh->material_count) {
        const svo_material *from = &job->mesh->materials[index];
        memcpy(&to->rgba, from->rgba, sizeof to->rgba);
        job->clear[index] = from->rgba[3] < 255 || (place != NO_PLACE && places->clear[place] != 0);
    }
    if (place != NO_PLACE) {
        const svo_texture *texture = &job->mesh->textures[place % job->mesh->texture_count];
        to->texel_offset = places->offsets[place];
        to->width = texture->width;
        to->height = texture->height;
        to->wrap_u = texture->wrap_u;
        to->wrap_v = texture->wrap_v;
    }
}

static svo_status make_materials(mesh_job *job)
{
    const size_t textures = job->mesh->texture_count;
    const svo_i_memory *memory = &job->light->device->memory;
    texel_places places = {.offsets = svo_i_alloc(memory, (2 * textures + 1) * sizeof *places.offsets),
                           .clear = svo_i_alloc_zeroed(memory, textures + 1, 1)};
    svo_status status = SVO_OK;
    job->materials = svo_i_alloc_zeroed(memory, record_count(job), sizeof *job->materials);
    job->clear = svo_i_alloc_zeroed(memory, job->material_count, 1);
    if (places.offsets == NULL || places.clear == NULL || job->materials == NULL || job->clear == NULL) {
        status = no_memory(job, "materials", record_count(job));
        goto cleanup;
    }
    job->materials[0].rgba = UINT32_MAX; /* white, for a mesh without materials */
    memset(places.offsets, 0xff, 2 * textures * sizeof *places.offsets);
    SVO_I_TRY_CLEANUP(place_textures(job, &places));
    fill_texels(job, &places);
    for (size_t i = 0; i < record_count(job); ++i) {
        fill_record(job, i, &places);
    }

cleanup:
    svo_i_free(places.offsets);
    svo_i_free(places.clear);
    return status;
}

/* ---- triangles ---- */

typedef struct corner {
    double position[3];
    double uv[2];
} corner;

static corner corner_of(const svo_mesh *mesh, size_t vertex)
{
    corner out = {{0, 0, 0}, {0, 0}};
    for (size_t axis = 0; axis < 3; ++axis) {
        out.position[axis] = mesh->positions != NULL ? (double)mesh->positions[3 * vertex + axis]
                                                     : mesh->positions_double[3 * vertex + axis];
    }
    for (size_t i = 0; i < 2 && mesh->uvs != NULL; ++i) {
        const float uv = mesh->uvs[2 * vertex + i];
        out.uv[i] = isfinite(uv) ? (double)uv : 0;
    }
    return out;
}

/* The cross product of a triangle's edges. */
static void cross_of(const corner corners[3], double out[3])
{
    double edges[2][3];
    for (int axis = 0; axis < 3; ++axis) {
        edges[0][axis] = corners[1].position[axis] - corners[0].position[axis];
        edges[1][axis] = corners[2].position[axis] - corners[0].position[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3;
        const int last = (axis + 2) % 3;
        out[axis] = edges[0][next] * edges[1][last] - edges[0][last] * edges[1][next];
    }
}

static double length_of(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* svo_mesh_triangle.level; without texels or area the finest level. */
static float level_of(const corner corners[3], const svo_material_record *material)
{
    double cross[3];
    double uvs[2][2];
    cross_of(corners, cross);
    for (int i = 0; i < 2; ++i) {
        uvs[0][i] = corners[1].uv[i] - corners[0].uv[i];
        uvs[1][i] = corners[2].uv[i] - corners[0].uv[i];
    }
    const double texels = fabs(uvs[0][0] * uvs[1][1] - uvs[0][1] * uvs[1][0]) * material->width * material->height;
    const double area = length_of(cross);
    return texels > 0 && area > 0 ? (float)(log2(texels / area) / 2) : -126.0F;
}

static uint32_t half_word(double value)
{
    return (uint16_t)(int16_t)rint(32767 * value);
}

/* A direction on the octahedral map; any length above 0. */
static uint32_t pack_normal(const double normal[3])
{
    const double sum = fabs(normal[0]) + fabs(normal[1]) + fabs(normal[2]);
    const double x = normal[0] / sum;
    const double y = normal[1] / sum;
    if (normal[2] >= 0) {
        return half_word(x) | half_word(y) << 16;
    }
    return half_word(copysign(1 - fabs(y), x)) | half_word(copysign(1 - fabs(x), y)) << 16;
}

/* A vertex's normal; the triangle's own where it has none. */
static uint32_t normal_of(const svo_mesh *mesh, size_t vertex, const double own[3])
{
    static const float none[3] = {0, 0, 0};
    const float *given = mesh->normals != NULL ? mesh->normals + 3 * vertex : none;
    const double normal[3] = {(double)given[0], (double)given[1], (double)given[2]};
    const double length = length_of(normal);
    const double own_length = length_of(own);
    static const double any[3] = {1, 0, 0};
    return pack_normal(length > 0 && isfinite(length) ? normal : own_length > 0 && isfinite(own_length) ? own : any);
}

/* Which side of a triangle its vertex normals call the front: 1, that of own, or -1. */
static double front_of(const svo_mesh *mesh, const size_t vertices[3], const double own[3])
{
    double facing = 0;
    for (size_t i = 0; i < 3 && mesh->normals != NULL; ++i) {
        const float *normal = mesh->normals + 3 * vertices[i];
        const double cosine = (double)normal[0] * own[0] + (double)normal[1] * own[1] + (double)normal[2] * own[2];
        facing += isfinite(cosine) ? cosine : 0;
    }
    return facing < 0 ? -1 : 1;
}

/* The frame of a triangle's normal map: x along the derivative of the position by u; y against that by v, which seen
   from the front is to its left or to its right. Without such derivatives there is none. */
static void fill_bend(const mesh_job *job, uint32_t map, const corner corners[3], double front, svo_mesh_bend *out)
{
    const size_t material = map - job->material_count;
    double uvs[2][2];
    double along[3];
    for (int i = 0; i < 2; ++i) {
        uvs[0][i] = corners[1].uv[i] - corners[0].uv[i];
        uvs[1][i] = corners[2].uv[i] - corners[0].uv[i];
    }
    const double turn = uvs[0][0] * uvs[1][1] - uvs[0][1] * uvs[1][0];
    const double scale = (double)job->mesh->normal_maps[material].scale;
    for (int axis = 0; axis < 3; ++axis) {
        const double first = corners[1].position[axis] - corners[0].position[axis];
        const double second = corners[2].position[axis] - corners[0].position[axis];
        along[axis] = copysign(1, turn) * copysign(1, scale) * (first * uvs[1][1] - second * uvs[0][1]);
    }
    const double length = length_of(along);
    if (turn != 0 && length > 0 && isfinite(length)) {
        out->scale = (float)(turn * front < 0 ? fabs(scale) : -fabs(scale));
        out->direction = pack_normal(along);
        out->material = map;
        out->level = level_of(corners, &job->materials[map]);
    }
}

static void fill_triangle(mesh_job *job, size_t triangle, const size_t vertices[3])
{
    const svo_mesh *mesh = job->mesh;
    const uint32_t named = mesh->triangle_materials != NULL ? mesh->triangle_materials[triangle] : 0;
    const uint32_t material = named < mesh->material_count ? named : 0;
    const uint32_t map = (uint32_t)job->material_count + material;
    const bool has_map = job->has_maps && job->materials[map].width != 0;
    svo_mesh_triangle *out = &job->triangles[triangle];
    bool is_clear = job->clear[material] != 0;
    corner corners[3];
    double own[3];
    for (size_t i = 0; i < 3; ++i) {
        corners[i] = corner_of(mesh, vertices[i]);
        out->uvs[2 * i] = (float)corners[i].uv[0];
        out->uvs[2 * i + 1] = (float)corners[i].uv[1];
        out->colors[i] = UINT32_MAX;
        if (mesh->colors != NULL) {
            memcpy(&out->colors[i], mesh->colors + 4 * vertices[i], sizeof out->colors[i]);
            is_clear = is_clear || out->colors[i] >> 24 < 255;
        }
    }
    cross_of(corners, own);
    for (int i = 0; i < 3 && (mesh->normals != NULL || has_map); ++i) {
        out->normals[i] = normal_of(mesh, vertices[i], own);
    }
    if (has_map) {
        fill_bend(job, map, corners, front_of(mesh, vertices, own), &job->bends[triangle]);
    }
    out->material = material | (is_clear ? SVO_MESH_TRIANGLE_CLEAR : 0);
    out->level = level_of(corners, &job->materials[material]);
    job->flags |= is_clear ? SVO_MESH_CLEAR : 0;
}

/* Triangles whose indices are out of range are met by no ray. */
static svo_status make_triangles(mesh_job *job)
{
    const svo_mesh *mesh = job->mesh;
    job->triangles = svo_i_alloc_zeroed(&job->light->device->memory, mesh->triangle_count, sizeof *job->triangles);
    if (job->has_maps) {
        job->bends = svo_i_alloc_zeroed(&job->light->device->memory, mesh->triangle_count, sizeof *job->bends);
    }
    if (job->triangles == NULL || (job->has_maps && job->bends == NULL)) {
        return no_memory(job, "triangles", mesh->triangle_count);
    }
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        size_t vertices[3];
        bool is_usable = true;
        for (size_t k = 0; k < 3; ++k) {
            vertices[k] = mesh->indices != NULL ? mesh->indices[3 * i + k] : 3 * i + k;
            is_usable = is_usable && vertices[k] < mesh->vertex_count;
        }
        if (is_usable) {
            fill_triangle(job, i, vertices);
        }
    }
    return SVO_OK;
}

/* ---- all of it ---- */

static svo_status upload(svo_i_device_work *work, const mesh_job *job)
{
    svo_light *light = job->light;
    const uint64_t bytes[] = {job->mesh->triangle_count * sizeof *job->triangles,
                              record_count(job) * sizeof *job->materials, (job->texel_count + 1) * sizeof *job->texels,
                              job->has_maps ? job->mesh->triangle_count * sizeof *job->bends : 0};
    SVO_I_TRY(svo_i_work_result(work, "mesh_triangles", bytes[0], &light->mesh.triangles));
    SVO_I_TRY(svo_i_work_result(work, "mesh_materials", bytes[1], &light->mesh.materials));
    SVO_I_TRY(svo_i_work_result(work, "mesh_texels", bytes[2], &light->mesh.texels));
    SVO_I_TRY(svo_i_work_write(work, light->mesh.triangles, job->triangles, bytes[0]));
    SVO_I_TRY(svo_i_work_write(work, light->mesh.materials, job->materials, bytes[1]));
    SVO_I_TRY(svo_i_work_write(work, light->mesh.texels, job->texels, bytes[2]));
    if (job->has_maps) {
        SVO_I_TRY(svo_i_work_result(work, "mesh_bends", bytes[3], &light->mesh.bends));
        SVO_I_TRY(svo_i_work_write(work, light->mesh.bends, job->bends, bytes[3]));
    }
    light->mesh.flags = job->flags;
    light->info.mesh_bytes = bytes[0] + bytes[1] + bytes[2] + bytes[3];
    return SVO_OK;
}

static svo_status give(svo_light *light, const svo_mesh *mesh, cl_command_queue queue)
{
    mesh_job job = {
        .light = light, .mesh = mesh, .material_count = mesh->material_count > 0 ? mesh->material_count : 1};
    svo_i_device_work work;
    svo_status status = SVO_OK;
    job.flags = (mesh->material_count > 0 || mesh->colors != NULL ? SVO_MESH_COLORS : 0) |
                (mesh->normals != NULL ? SVO_MESH_NORMALS : 0);
    job.has_maps = has_normal_maps(&job);
    SVO_I_TRY(svo_i_work_begin(light->device, set_mesh, queue, &work));
    SVO_I_TRY_CLEANUP(make_materials(&job));
    SVO_I_TRY_CLEANUP(make_triangles(&job));
    SVO_I_TRY_CLEANUP(upload(&work, &job));

cleanup:
    svo_i_work_end(&work);
    svo_i_free(job.materials);
    svo_i_free(job.clear);
    svo_i_free(job.texels);
    svo_i_free(job.triangles);
    svo_i_free(job.bends);
    if (status != SVO_OK) {
        svo_i_light_drop_mesh(light);
    }
    return status;
}

/* The tree's rays meet the triangles of the mesh. */
static svo_status check_mesh(const svo_light *light, const svo_mesh *mesh)
{
    const svo_tree_info *tree = &light->tree->info;
    SVO_I_TRY(svo_i_mesh_check_host(light->device, set_mesh, mesh));
    if (!svo_i_rays_of_triangles(tree)) {
        return svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT, "%s: the tree has no triangles for rays",
                                 set_mesh);
    }
    return mesh->triangle_count == tree->triangles
               ? SVO_OK
               : svo_i_device_fail(light->device, SVO_INVALID_ARGUMENT,
                                   "%s: mesh has %zu triangles; that of the tree has %llu", set_mesh,
                                   mesh->triangle_count, (unsigned long long)tree->triangles);
}

svo_status svo_light_set_mesh(svo_light *light, const svo_mesh *mesh, cl_command_queue queue)
{
    svo_mesh given;
    if (light == NULL) {
        return SVO_INVALID_ARGUMENT;
    }
    svo_i_light_drop_mesh(light);
    if (mesh == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_struct_read(svo_i_device_message(light->device), set_mesh, "mesh", mesh, &given,
                                SVO_I_STRUCT_SIZES(svo_mesh, triangle_count)));
    SVO_I_TRY(svo_i_tree_check(light->tree, set_mesh));
    SVO_I_TRY(check_mesh(light, &given));
    return give(light, &given, queue);
}

void svo_i_light_drop_mesh(svo_light *light)
{
    svo_i_buffer_release(&light->mesh.triangles);
    svo_i_buffer_release(&light->mesh.materials);
    svo_i_buffer_release(&light->mesh.texels);
    svo_i_buffer_release(&light->mesh.bends);
    light->mesh.flags = 0;
    light->info.mesh_bytes = 0;
}
