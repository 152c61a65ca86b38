/* SPDX-License-Identifier: MIT */
/*
 * The payload inputs: the mesh's colors, normals, texture coordinates and materials as integers, so that payload
 * kernels need no floats. Only attributes that the request reads and the mesh has are copied.
 */
#include "plan/attributes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/arrays.h"
#include "plan/grid.h"
#include "shared/fine.clh"

/* ---- constant payload ---- */

/*
 * Payload that is the same in the whole scene. It is stored once instead of per node, and no kernel computes it. The
 * mean of equal values, rounded half up, is that value, so every node would have had the stored one.
 */

/* a * b / 255 per channel, rounded half up, as in kernels/stages/attribute.clh. */
static uint32_t modulate(uint32_t a, uint32_t b)
{
    uint32_t product = 0;
    for (unsigned shift = 0; shift < 32; shift += 8) {
        product |= (2u * (a >> shift & 255u) * (b >> shift & 255u) + 255u) / 510u << shift;
    }
    return product;
}

static void drop(void *host, cl_mem *memory)
{
    svo_i_free(host);
    svo_i_buffer_release(memory);
}

static void fold_colors(svo_plan *plan, const svo_i_findings *found)
{
    if (!svo_i_plan_has(plan->colors, plan->memory.colors) || found->colors_vary) {
        return;
    }
    for (uint32_t i = 0; i < plan->material_count && plan->triangle_count > 0; ++i) {
        plan->materials[i].rgba = modulate(plan->materials[i].rgba, found->first_color);
    }
    drop(plan->colors, &plan->memory.colors);
    plan->colors = NULL;
}

static void fold_normals(svo_plan *plan, const svo_i_findings *found)
{
    static const int16_t none[4] = {0};
    if (!svo_i_plan_has(plan->normals, plan->memory.normals) || found->normals_vary) {
        return;
    }
    if (plan->triangle_count > 0) {
        /* zero normals stand for the triangle's own */
        plan->one_normal = memcmp(found->first_normal, none, sizeof none) != 0;
        memcpy(plan->work.constant_normal, found->first_normal, sizeof plan->work.constant_normal);
    }
    drop(plan->normals, &plan->memory.normals);
    plan->normals = NULL;
}

static bool has_one_color(const svo_plan *plan, const svo_i_findings *found)
{
    if (plan->materials == NULL || svo_i_plan_has(plan->colors, plan->memory.colors) || plan->texels != NULL) {
        return false;
    }
    const uint32_t color = plan->materials[found->first_record.material].rgba;
    for (uint32_t i = 0; i < plan->material_count; ++i) {
        if (found->material_used[i] != 0 && plan->materials[i].rgba != color) {
            return false;
        }
    }
    return true;
}

/* Whether the mesh has no vertex normals and all triangles have the same normal. */
static bool has_one_own_normal(const svo_plan *plan, const svo_i_findings *found)
{
    return !svo_i_plan_has(plan->normals, plan->memory.normals) && !found->own_normals_vary;
}

static void free_colors(svo_plan *plan)
{
    svo_i_free(plan->materials);
    drop(plan->uvs, &plan->memory.uvs);
    plan->materials = NULL;
    plan->uvs = NULL;
}

static bool materials_vary(const svo_plan *plan, const svo_i_findings *found)
{
    uint32_t used = 0;
    for (uint32_t i = 0; i < plan->material_count; ++i) {
        used += found->material_used[i] != 0 ? 1u : 0u;
    }
    return used > 1;
}

/* ---- alpha that is too little ---- */

/* The least alpha of all points of a material: means of texels are no less than these, and products are rounded alike.
   Until now it is that of the texels. */
static uint32_t least_of(const svo_material_record *material)
{
    return modulate(material->rgba, material->least_alpha << 24) >> 24;
}

/* Frees what was taken for its alpha alone. */
static void free_unasked_colors(svo_plan *plan)
{
    if ((plan->info.need & ~plan->work.constant & SVO_NEED_COLOR) == 0) {
        drop(plan->colors, &plan->memory.colors);
        svo_i_free(plan->texels);
        plan->colors = NULL;
        plan->texels = NULL;
        plan->texel_count = 0;
        free_colors(plan);
    }
}

void svo_i_plan_find_dropped(svo_plan *plan, const uint8_t *material_used)
{
    bool some = svo_i_plan_has(plan->colors, plan->memory.colors); /* of several values, which only kernels see */
    if (plan->least_alpha == 0) {
        return;
    }
    for (uint32_t i = 0; i < plan->material_count; ++i) {
        svo_material_record *material = &plan->materials[i];
        material->least_alpha = least_of(material);
        some = some || ((plan->update != NULL || material_used[i] != 0) && material->least_alpha < plan->least_alpha);
    }
    plan->work.drop = some && plan->triangle_count > 0;
    if (!plan->work.drop && plan->update == NULL) { /* objects of a scene that moves share them */
        free_unasked_colors(plan);
    }
}

/* ---- all that is constant ---- */

/* Moves vertex colors that are all equal into the materials, and vertex normals into the plan's constant normal. Finds
   the payload that is the same in every node. Frees the inputs that are not needed for it. */
static void find_constants(svo_plan *plan, const svo_i_findings *found)
{
    svo_i_work *work = &plan->work;
    const svo_triangle_record *first = &found->first_record; /* all zero without triangles, like the payload */
    fold_colors(plan, found);
    fold_normals(plan, found);
    plan->materials_vary = materials_vary(plan, found);
    svo_i_plan_find_dropped(plan, found->material_used);
    if ((plan->info.need & SVO_NEED_COLOR) != 0 && has_one_color(plan, found)) {
        work->constant |= SVO_NEED_COLOR;
        const uint32_t color = plan->triangle_count > 0 ? plan->materials[first->material].rgba : 0;
        work->constant_color = color >> 24 != 0 ? color : 0; /* as where colors differ: of what shows */
        if (!work->drop) {
            free_colors(plan);
        }
    }
    if ((plan->info.need & SVO_NEED_NORMAL) != 0 && !plan->one_normal && has_one_own_normal(plan, found)) {
        plan->one_normal = true;
        work->constant_normal[0] = (int16_t)(first->normal_xy & 0xffffu);
        work->constant_normal[1] = (int16_t)(first->normal_xy >> 16);
        work->constant_normal[2] = (int16_t)(first->normal_z_flags & 0xffffu);
    }
    work->constant |= plan->one_normal ? (uint32_t)SVO_NEED_NORMAL : 0u;
    if ((plan->info.need & SVO_NEED_MATERIAL) != 0 && !plan->materials_vary) {
        work->constant |= SVO_NEED_MATERIAL;
        work->constant_material = (uint16_t)first->material;
    }
    plan->info.constant = work->constant;
}

/* ---- inputs ---- */

#define UV_ONE     65536.0
#define UV_LIMIT   32767.0
#define NORMAL_ONE 32767.0

#define STRETCH_ONE 1073741824.0 /* 1 in svo_triangle_record.stretch: 2^30 */

/* Limits on weights, as powers of two: the largest weight of a pair, where rounding may double a tiny area; the largest
   sum of all weights, where closed voxels count some area twice. */
#define PAIR_LOG2_MAX  31
#define TOTAL_LOG2_MAX 44
/* Above sqrt(2), the largest area of a plane inside a voxel, in faces. */
#define CUT_FACES_MAX 1.5

static svo_status no_memory(svo_plan *plan)
{
    return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the attributes of %u vertices",
                             plan->progress.function, plan->vertex_count);
}

/* A kept triangle's material; 0 if it is out of range. */
static uint32_t material_of(const svo_plan *plan, const svo_mesh *mesh, uint32_t triangle)
{
    const uint32_t material =
        mesh->triangle_materials != NULL ? mesh->triangle_materials[plan->triangle_ids[triangle]] : 0;
    return material < plan->material_count ? material : 0;
}

bool svo_i_material_is_textured(const svo_mesh *mesh, bool has_uvs, size_t material)
{
    return has_uvs && material < mesh->material_count && mesh->materials[material].texture_index < mesh->texture_count;
}

/* Marks the textures of used materials, one byte each, and counts them. */
static void find_textures(svo_plan *plan, const svo_mesh *mesh, bool has_uvs, const uint8_t *material_used,
                          uint8_t *used)
{
    plan->textures_given = mesh->texture_count;
    for (size_t i = 0; i < plan->material_count; ++i) {
        if (material_used[i] != 0 && svo_i_material_is_textured(mesh, has_uvs, i) &&
            used[mesh->materials[i].texture_index] == 0) {
            used[mesh->materials[i].texture_index] = 1;
            ++plan->textures_used;
        }
    }
}

void svo_i_plan_resolve_need(svo_plan *plan, const svo_mesh *mesh, bool has_colors)
{
    const uint32_t need = plan->options.need;
    plan->info.need = need & ~(uint32_t)SVO_NEED_NONE;
    if (need == SVO_NEED_DEFAULT) {
        plan->info.need =
            (has_colors || mesh->material_count > 0 ? (uint32_t)SVO_NEED_COLOR : 0u) | (uint32_t)SVO_NEED_NORMAL;
    }
    plan->material_count = mesh->material_count > 0 ? (uint32_t)mesh->material_count : 1;
}

static void unit_normal(double x, double y, double z, int16_t out[3])
{
    const double length = sqrt(x * x + y * y + z * z);
    const bool usable = isfinite(length) && length > 0.0;
    out[0] = usable ? (int16_t)rint(x / length * NORMAL_ONE) : 0;
    out[1] = usable ? (int16_t)rint(y / length * NORMAL_ONE) : 0;
    out[2] = usable ? (int16_t)rint(z / length * NORMAL_ONE) : 0;
}

static svo_status copy_normals(svo_plan *plan, const svo_mesh *mesh)
{
    plan->normals = svo_i_alloc_zeroed(&plan->device->memory, (size_t)plan->vertex_count * 4 + 1, sizeof(int16_t));
    if (plan->normals == NULL) {
        return no_memory(plan);
    }
    if (plan->exact_normals != NULL) {
        memcpy(plan->normals, plan->exact_normals, (size_t)plan->vertex_count * 4 * sizeof *plan->normals);
        return SVO_OK;
    }
    for (size_t v = 0; v < plan->vertex_count; ++v) {
        const float *n = mesh->normals + v * 3;
        unit_normal((double)n[0], (double)n[1], (double)n[2], plan->normals + v * 4);
    }
    return SVO_OK;
}

static svo_status copy_colors(svo_plan *plan, const svo_mesh *mesh)
{
    plan->colors = svo_i_alloc(&plan->device->memory, ((size_t)plan->vertex_count + 1) * sizeof(uint32_t));
    if (plan->colors == NULL) {
        return no_memory(plan);
    }
    memcpy(plan->colors, mesh->colors, (size_t)plan->vertex_count * sizeof(uint32_t));
    return SVO_OK;
}

static int32_t fixed_uv(float x)
{
    if (!isfinite(x)) {
        return 0;
    }
    const double limited = fmin(fmax((double)x, -UV_LIMIT), UV_LIMIT);
    return (int32_t)rint(limited * UV_ONE);
}

static svo_status copy_uvs(svo_plan *plan, const svo_mesh *mesh)
{
    plan->uvs = svo_i_alloc(&plan->device->memory, ((size_t)plan->vertex_count * 2 + 1) * sizeof(int32_t));
    if (plan->uvs == NULL) {
        return no_memory(plan);
    }
    for (size_t i = 0; i < (size_t)plan->vertex_count * 2; ++i) {
        plan->uvs[i] = fixed_uv(mesh->uvs[i]);
    }
    return SVO_OK;
}

/* Concatenates the used textures. *offsets, owned by the caller, receives where each begins, in texels. */
static svo_status copy_texels(svo_plan *plan, const svo_mesh *mesh, const uint8_t *used, uint32_t **offsets)
{
    uint64_t total = 0;
    *offsets = svo_i_alloc(&plan->device->memory, (mesh->texture_count + 1) * sizeof(uint32_t));
    if (*offsets == NULL) {
        return no_memory(plan);
    }
    for (size_t i = 0; i < mesh->texture_count; ++i) {
        (*offsets)[i] = (uint32_t)total;
        total += used[i] != 0 ? (uint64_t)mesh->textures[i].width * mesh->textures[i].height : 0;
    }
    if (total > UINT32_MAX) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "%s: textures have %llu texels, above 2^32 - 1", plan->progress.function,
                                 (unsigned long long)total);
    }
    plan->texels = svo_i_alloc(&plan->device->memory, (size_t)(total + 1) * sizeof(uint32_t));
    if (plan->texels == NULL) {
        return no_memory(plan);
    }
    plan->texel_count = total;
    for (size_t i = 0; i < mesh->texture_count; ++i) {
        const svo_texture *texture = &mesh->textures[i];
        if (used[i] != 0) {
            memcpy(plan->texels + (*offsets)[i], texture->rgba, (size_t)texture->width * texture->height * 4);
        }
    }
    return SVO_OK;
}

static uint32_t least_alpha_of(const svo_texture *texture)
{
    const size_t texels = (size_t)texture->width * texture->height;
    uint8_t least = UINT8_MAX;
    for (size_t i = 0; i < texels && least > 0; ++i) {
        const uint8_t alpha = texture->rgba[4 * i + 3];
        least = alpha < least ? alpha : least;
    }
    return least;
}

/* Sets the least alpha of the texels of each material, 255 without a texture. used: as below. */
static svo_status find_least_texels(svo_plan *plan, const svo_mesh *mesh, const uint8_t *used)
{
    uint32_t *least = svo_i_alloc_zeroed(&plan->device->memory, mesh->texture_count + 1, sizeof *least);
    if (least == NULL) {
        return no_memory(plan);
    }
    for (size_t i = 0; i < mesh->texture_count && used != NULL; ++i) {
        least[i] = used[i] != 0 ? least_alpha_of(&mesh->textures[i]) : UINT8_MAX;
    }
    for (uint32_t i = 0; i < plan->material_count; ++i) {
        svo_material_record *material = &plan->materials[i];
        material->least_alpha = material->width != 0 ? least[mesh->materials[i].texture_index] : UINT8_MAX;
    }
    svo_i_free(least);
    return SVO_OK;
}

/* used: one byte per texture; NULL: none is used. */
static svo_status copy_records(svo_plan *plan, const svo_mesh *mesh, const uint8_t *used)
{
    uint32_t *offsets = NULL;
    if (used != NULL) {
        const svo_status status = copy_texels(plan, mesh, used, &offsets);
        if (status != SVO_OK) {
            svo_i_free(offsets);
            return status;
        }
    }
    plan->materials = svo_i_alloc_zeroed(&plan->device->memory, plan->material_count, sizeof(svo_material_record));
    if (plan->materials == NULL) {
        svo_i_free(offsets);
        return no_memory(plan);
    }
    plan->materials[0].rgba = UINT32_MAX; /* white, for a mesh without materials */
    for (size_t i = 0; i < mesh->material_count; ++i) {
        const svo_material *from = &mesh->materials[i];
        svo_material_record *to = &plan->materials[i];
        memcpy(&to->rgba, from->rgba, sizeof to->rgba);
        if (used != NULL && from->texture_index < mesh->texture_count && used[from->texture_index] != 0) {
            const svo_texture *texture = &mesh->textures[from->texture_index];
            to->texel_offset = offsets[from->texture_index];
            to->width = texture->width;
            to->height = texture->height;
            to->wrap_u = texture->wrap_u;
            to->wrap_v = texture->wrap_v;
        }
    }
    svo_i_free(offsets);
    return plan->least_alpha != 0 ? find_least_texels(plan, mesh, used) : SVO_OK;
}

svo_status svo_i_plan_copy_materials(svo_plan *plan, const svo_mesh *mesh, bool has_uvs, const uint8_t *material_used)
{
    uint8_t *used = svo_i_alloc_zeroed(&plan->device->memory, mesh->texture_count + 1, 1);
    if (used == NULL) {
        return no_memory(plan);
    }
    find_textures(plan, mesh, has_uvs, material_used, used);
    const svo_status status = copy_records(plan, mesh, plan->textures_used > 0 ? used : NULL);
    svo_i_free(used);
    return status;
}

/* Whether an attribute of some bytes per vertex is the same at the three corners. */
static bool same(const void *attribute, size_t bytes, const uint32_t corners[3])
{
    const uint8_t *a = attribute;
    return memcmp(a + corners[0] * bytes, a + corners[1] * bytes, bytes) == 0 &&
           memcmp(a + corners[0] * bytes, a + corners[2] * bytes, bytes) == 0;
}

/* A triangle's shape. Components of the normal that it is made of are at most 2^61; their conversion to double is the
   same on every host. */
typedef struct shape {
    int16_t unit[3]; /* unit normal */
    uint32_t axis; /* of the normal's largest component */
    double area; /* square grid units */
    double stretch; /* ratio of the area to that of the projection along the axis; 1 for degenerate triangles */
} shape;

/* A coordinate in sub-units. */
static int64_t fine_coordinate(const svo_plan *plan, uint32_t vertex, int32_t axis)
{
    return svo_fine_coordinate(plan->vertices[(size_t)vertex * 3 + (size_t)axis], plan->remainders[vertex], axis,
                               (int32_t)(SVO_SUB_LOG2 - plan->voxel_log2));
}

static shape shape_of(const svo_plan *plan, const uint32_t corners[3])
{
    int64_t edges[6];
    shape s;
    const int32_t bits = (int32_t)(SVO_SUB_LOG2 - plan->voxel_log2);
    for (int32_t i = 0; i < 6; ++i) {
        const int32_t axis = i % 3;
        edges[i] = fine_coordinate(plan, corners[1 + i / 3], axis) - fine_coordinate(plan, corners[0], axis);
    }
    const svo_fine_normal normal = svo_make_fine_normal(edges);
    const int64_t n[3] = {normal.x, normal.y, normal.z};
    const double x = (double)n[0];
    const double y = (double)n[1];
    const double z = (double)n[2];
    unit_normal(x, y, z, s.unit);
    s.axis = llabs(n[1]) > llabs(n[0]) ? 1 : 0;
    s.axis = llabs(n[2]) > llabs(n[s.axis]) ? 2 : s.axis;
    const double doubled_area = sqrt(x * x + y * y + z * z);
    s.area = ldexp(doubled_area, 2 * (normal.dropped - bits) - 1);
    s.stretch = n[s.axis] != 0 ? doubled_area / fabs((double)n[s.axis]) : 1.0;
    return s;
}

/* Whether the triangle's attributes are constant. */
static bool is_flat(const svo_plan *plan, const uint32_t corners[3], uint32_t material)
{
    const bool textured = plan->uvs != NULL && plan->materials[material].width != 0;
    return !textured && (plan->colors == NULL || same(plan->colors, sizeof(uint32_t), corners)) &&
           (plan->normals == NULL || same(plan->normals, 4 * sizeof(int16_t), corners));
}

/* One component of a record's normal, in 16 bits. */
static uint32_t half_word(int16_t value)
{
    return (uint16_t)value;
}

static svo_status make_records(svo_plan *plan, const svo_mesh *mesh, svo_i_findings *found)
{
    plan->records =
        svo_i_alloc_zeroed(&plan->device->memory, (size_t)plan->triangle_count + 1, sizeof(svo_triangle_record));
    if (plan->records == NULL) {
        return no_memory(plan);
    }
    for (uint32_t t = 0; t < plan->triangle_count; ++t) {
        const uint32_t *corners = plan->indices + (size_t)t * 3;
        svo_triangle_record *record = &plan->records[t];
        record->material = material_of(plan, mesh, t);
        const shape s = shape_of(plan, corners);
        record->normal_xy = half_word(s.unit[0]) | half_word(s.unit[1]) << 16;
        record->normal_z_flags = half_word(s.unit[2]) | s.axis << SVO_TRIANGLE_AXIS_SHIFT |
                                 (is_flat(plan, corners, record->material) ? SVO_TRIANGLE_FLAT : 0u);
        record->stretch = (uint32_t)rint(s.stretch * STRETCH_ONE);
        found->largest_area = fmax(found->largest_area, s.area);
        found->own_normals_vary = found->own_normals_vary || !svo_i_same_own_normal(record, &plan->records[0]);
    }
    found->first_record = plan->records[0];
    return SVO_OK;
}

/* Compares the vertex attributes at the corners of the kept triangles with those at the first corner. */
static void compare_corners(const svo_plan *plan, svo_i_findings *found)
{
    const size_t corners = (size_t)plan->triangle_count * 3;
    const size_t normal_bytes = sizeof found->first_normal;
    if (corners > 0 && plan->colors != NULL) {
        found->first_color = plan->colors[plan->indices[0]];
    }
    if (corners > 0 && plan->normals != NULL) {
        memcpy(found->first_normal, plan->normals + (size_t)plan->indices[0] * 4, normal_bytes);
    }
    for (size_t i = 0; i < corners && plan->colors != NULL && !found->colors_vary; ++i) {
        found->colors_vary = plan->colors[plan->indices[i]] != found->first_color;
    }
    for (size_t i = 0; i < corners && plan->normals != NULL && !found->normals_vary; ++i) {
        const int16_t *normal = plan->normals + (size_t)plan->indices[i] * 4;
        found->normals_vary = memcmp(normal, found->first_normal, normal_bytes) != 0;
    }
}

/* The exponent of the least power of two above x; 0 for 0. */
static int power_above(double x)
{
    int power = 0;
    (void)frexp(x, &power);
    return power;
}

/* Neither a pair nor the whole tree can overflow. Areas are in voxel faces. */
uint32_t svo_i_plan_choose_weight_log2(const svo_plan *plan, double largest_area, double total_area)
{
    const double face = ldexp(1.0, 2 * (int)plan->voxel_log2);
    const double pair = fmin(largest_area / face, CUT_FACES_MAX);
    const double total = total_area / face;
    const int by_pair = PAIR_LOG2_MAX - power_above(pair);
    const int by_total = TOTAL_LOG2_MAX - power_above(total);
    const int log2 = by_pair < by_total ? by_pair : by_total;
    return log2 > (int)SVO_I_WEIGHT_LOG2_MIN ? (uint32_t)log2 : SVO_I_WEIGHT_LOG2_MIN;
}

/* Takes constant payload and the unit of weights from the header of the whole. */
static void take_constants(svo_plan *plan)
{
    const svo_part_header *header = &plan->part.header;
    svo_i_work *work = &plan->work;
    work->constant = header->constant;
    memcpy(&work->constant_color, header->constant_color, sizeof work->constant_color);
    memcpy(work->constant_normal, header->constant_normal, sizeof work->constant_normal);
    work->constant_material = header->constant_material;
    plan->info.constant = header->constant;
    plan->weight_log2 = header->weight_log2;
}

svo_status svo_i_plan_conclude(svo_plan *plan, const svo_i_findings *found)
{
    const uint32_t asked = plan->options.weight_log2;
    if (svo_i_plan_is_part(plan)) {
        take_constants(plan);
        svo_i_plan_find_dropped(plan, found->material_used);
        plan->info.weight_log2 = plan->weight_log2;
        return SVO_OK;
    }
    find_constants(plan, found);
    /* The areas of three projections are no less than the area. */
    const uint32_t finest = svo_i_plan_choose_weight_log2(plan, found->largest_area, plan->estimate[2]);
    plan->weight_log2 = asked != 0 ? asked : finest;
    plan->info.weight_log2 = (plan->info.need & SVO_I_NEED_PAYLOAD) != 0 ? plan->weight_log2 : 0;
    return asked <= finest ? SVO_OK
                           : svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT,
                                               "%s: options.weight_log2 %u is above %u, the most that the mesh's area "
                                               "allows",
                                               plan->progress.function, asked, finest);
}

/* Copies the inputs of colors. */
static svo_status copy_color_inputs(svo_plan *plan, const svo_mesh *mesh, const uint8_t *material_used)
{
    SVO_I_TRY(svo_i_plan_copy_materials(plan, mesh, mesh->uvs != NULL, material_used));
    if (plan->textures_used > 0) {
        SVO_I_TRY(copy_uvs(plan, mesh));
    }
    return mesh->colors != NULL ? copy_colors(plan, mesh) : SVO_OK;
}

svo_status svo_i_plan_find(svo_plan *plan, const svo_mesh *mesh, svo_i_findings *found)
{
    for (uint32_t t = 0; t < plan->triangle_count; ++t) {
        found->material_used[material_of(plan, mesh, t)] = 1;
    }
    const uint32_t varying = plan->info.need & ~plan->part.header.constant; /* of a part the whole knows this */
    if ((varying & SVO_NEED_COLOR) != 0 || plan->least_alpha != 0) {
        SVO_I_TRY(copy_color_inputs(plan, mesh, found->material_used));
    }
    if ((varying & SVO_NEED_NORMAL) != 0 && (mesh->normals != NULL || plan->exact_normals != NULL)) {
        SVO_I_TRY(copy_normals(plan, mesh));
    }
    SVO_I_TRY(make_records(plan, mesh, found));
    compare_corners(plan, found);
    return SVO_OK;
}

svo_status svo_i_plan_attributes(svo_plan *plan, const svo_mesh *mesh)
{
    svo_i_plan_resolve_need(plan, mesh, mesh->colors != NULL);
    if (svo_i_plan_reads(plan) == 0) {
        return SVO_OK;
    }
    svo_i_findings found = {.material_used = svo_i_alloc_zeroed(&plan->device->memory, plan->material_count, 1)};
    svo_status status = SVO_OK;
    if (found.material_used == NULL) {
        return no_memory(plan);
    }
    SVO_I_TRY_CLEANUP(svo_i_plan_find(plan, mesh, &found));
    SVO_I_TRY_CLEANUP(svo_i_plan_conclude(plan, &found));
cleanup:
    svo_i_free(found.material_used);
    return status;
}
