/* SPDX-License-Identifier: MIT */
/* Scenes that move: creation, destruction, and what is known of them. Objects and updates are in files of their own. */
#include <string.h>

#include "core/struct_size.h"
#include "moving/bvh.h"
#include "moving/objects.h"
#include "moving/pairs.h"

/* ---- creation ---- */

/* Reads what describes the scene, and makes the options of the plans. */
static svo_status read_options(svo_moving *moving, const svo_moving_options *given)
{
    svo_moving_options options;
    svo_device *device = moving->device;
    SVO_I_TRY(svo_i_struct_read(&device->message, "svo_moving_create", "options", given, &options,
                                SVO_I_STRUCT_SIZES(svo_moving_options, weight_log2)));
    if (!(options.edge > 0.0)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "svo_moving_create: options.edge %g is not above 0, and the grid is fixed",
                                 options.edge);
    }
    moving->fragment_limit = options.fragment_capacity != 0 ? options.fragment_capacity : SVO_I_FRAGMENTS_MAX;
    moving->options = (svo_plan_options){.struct_size = sizeof moving->options,
                                         .need = options.need,
                                         .coverage = options.coverage,
                                         .weights = options.weights,
                                         .builder = SVO_BUILDER_SORTED,
                                         .payload_level = options.payload_level,
                                         .edge = options.edge,
                                         .max_area = options.max_area,
                                         .updatable = 1,
                                         .weight_log2 = options.weight_log2,
                                         .drop_alpha = options.drop_alpha};
    memcpy(moving->options.origin, options.origin, sizeof options.origin);
    return SVO_OK;
}

/* Puts the materials and textures on the device. */
static svo_status upload_materials(svo_moving *moving, const svo_plan *plan)
{
    svo_status status = SVO_OK;
    svo_i_device_work work = {.device = NULL};
    const uint64_t material_bytes = plan->material_count * sizeof(svo_material_record);
    SVO_I_TRY(svo_i_work_begin(moving->device, "svo_moving_create", NULL, &work));
    if (plan->materials != NULL) {
        SVO_I_TRY_CLEANUP(svo_i_work_result(&work, "material_records", material_bytes, &moving->materials));
        SVO_I_TRY_CLEANUP(svo_i_work_write(&work, moving->materials, plan->materials, material_bytes));
    }
    if (plan->texels != NULL) {
        SVO_I_TRY_CLEANUP(svo_i_work_result(&work, "texels", plan->texel_count * 4, &moving->texels));
        SVO_I_TRY_CLEANUP(svo_i_work_write(&work, moving->texels, plan->texels, plan->texel_count * 4));
    }
cleanup:
    svo_i_work_end(&work);
    return status;
}

/* Makes the plan of the whole scene from that of the static mesh. */
static svo_status describe_whole(svo_moving *moving)
{
    const svo_plan *plan = moving->objects[0].plan;
    moving->whole = *plan;
    moving->whole.triangle_count = UINT32_MAX; /* the lists number triangles in their objects */
    moving->whole.work.order = true; /* the filter reads the leaves' ranges */
    moving->options.need = plan->info.need != 0 ? plan->info.need : (uint32_t)SVO_NEED_NONE;
    moving->options.weight_log2 = plan->info.weight_log2;
    moving->options.max_area = 0.0;
    return upload_materials(moving, plan);
}

static svo_status create(svo_moving *moving, const svo_mesh *given, const svo_moving_options *options)
{
    static const char function[] = "svo_moving_create";
    svo_mesh mesh;
    if (given == NULL || options == NULL) {
        return svo_i_device_fail(moving->device, SVO_INVALID_ARGUMENT, "%s: %s is NULL", function,
                                 given == NULL ? "mesh" : "options");
    }
    SVO_I_TRY(svo_i_struct_read(&moving->device->message, function, "mesh", given, &mesh,
                                SVO_I_STRUCT_SIZES(svo_mesh, texture_count)));
    SVO_I_TRY(read_options(moving, options));
    moving->objects = svo_i_alloc_zeroed(&moving->device->memory, 4, sizeof *moving->objects);
    if (moving->objects == NULL) {
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for objects", function);
    }
    moving->object_count = 1;
    moving->object_capacity = 4;
    SVO_I_TRY(svo_frontend_create_cl(moving->device, &moving->frontend));
    SVO_I_TRY(svo_i_moving_make_object(moving, function, 0, &mesh, NULL));
    return describe_whole(moving);
}

svo_status svo_moving_create(svo_device *device, const svo_mesh *mesh, unsigned depth,
                             const svo_moving_options *options, cl_command_queue queue, svo_moving **out)
{
    if (device == NULL || out == NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "svo_moving_create: %s is NULL",
                                 device == NULL ? "device" : "out");
    }
    svo_status status = SVO_OK;
    svo_moving_report report = SVO_MOVING_REPORT_INIT;
    svo_moving *moving = svo_i_alloc_zeroed(&device->memory, 1, sizeof *moving);
    if (moving == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_moving_create: no memory for the handle");
    }
    moving->device = device;
    moving->depth = depth;
    SVO_I_TRY_CLEANUP(create(moving, mesh, options));
    SVO_I_TRY_CLEANUP(svo_moving_update(moving, &(svo_submit){.queue = queue}, &report)); /* waits */
    *out = moving;
    return SVO_OK;
cleanup:
    svo_i_message_rename(&device->message, "svo_moving_create");
    svo_moving_destroy(&moving);
    return status;
}

void svo_moving_destroy(svo_moving **moving)
{
    if (moving == NULL || *moving == NULL) {
        return;
    }
    svo_moving *m = *moving;
    if (m->flight != NULL) {
        (void)svo_moving_finish(m, NULL); /* its commands write to the scene */
    }
    svo_tree_destroy(&m->tree);
    svo_i_moving_free_bvhs(m);
    svo_i_kept_list_free(&m->list);
    svo_i_kept_list_free(&m->spare);
    for (uint32_t i = 0; i < m->object_count; ++i) {
        svo_i_moving_release_object(&m->objects[i]);
    }
    svo_i_moving_forget_mesh(m);
    svo_i_buffer_release(&m->materials);
    svo_i_buffer_release(&m->texels);
    svo_frontend_destroy(&m->frontend);
    svo_i_free(m->objects);
    svo_i_free(m);
    *moving = NULL;
}

/* ---- what is known ---- */

svo_tree *svo_moving_tree(const svo_moving *moving)
{
    return moving->tree;
}

static uint64_t bytes_of(cl_mem buffer)
{
    size_t bytes = 0;
    if (buffer != NULL) {
        clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL);
    }
    return bytes;
}

static uint64_t list_bytes(const svo_i_kept_list *list)
{
    return bytes_of(list->fragments) + bytes_of(list->values) + bytes_of(list->materials) + bytes_of(list->areas) +
           bytes_of(list->marks);
}

svo_status svo_moving_get_info(const svo_moving *moving, svo_moving_info *info)
{
    svo_moving_info made = {.need = moving->whole.info.need,
                            .weight_log2 = moving->whole.info.weight_log2,
                            .fragments = moving->list.count,
                            .list_bytes = list_bytes(&moving->list) + list_bytes(&moving->spare),
                            .area = moving->area};
    for (uint32_t i = 1; i < moving->object_count; ++i) {
        made.object_count += moving->objects[i].plan != NULL ? 1 : 0;
    }
    return svo_i_struct_write(&moving->device->message, "svo_moving_get_info", "info", &made, info,
                              SVO_I_STRUCT_SIZES(svo_moving_info, area));
}

/* ---- the scene's mesh ---- */

/* An array of the scene's mesh: those of the objects, one after the other. */
typedef struct joined {
    const svo_moving *moving;
    size_t offset; /* of the array's pointer in svo_mesh */
    size_t element_bytes;
    bool of_triangles;
} joined;

static const void *array_of(const svo_mesh *mesh, size_t offset)
{
    const void *array = NULL;
    memcpy(&array, (const char *)mesh + offset, sizeof array);
    return array;
}

static size_t elements_of(const svo_mesh *mesh, const joined *j)
{
    return j->of_triangles ? mesh->triangle_count : mesh->vertex_count;
}

/* Makes an array of the scene's mesh; elements of objects without one are 0. */
static bool join(const joined *j, bool wanted, svo_mesh *to)
{
    unsigned char *bytes = NULL;
    size_t at = 0;
    if (!wanted) {
        return true;
    }
    bytes = svo_i_alloc_zeroed(&j->moving->device->memory, elements_of(to, j), j->element_bytes);
    memcpy((char *)to + j->offset, &bytes, sizeof bytes);
    for (uint32_t i = 0; i < j->moving->object_count && bytes != NULL; ++i) {
        const svo_i_moving_object *object = &j->moving->objects[i];
        const void *from = array_of(&object->mesh, j->offset);
        const size_t part = svo_i_moving_shows(object) ? elements_of(&object->mesh, j) * j->element_bytes : 0;
        if (part > 0 && from != NULL) {
            memcpy(bytes + at, from, part);
        }
        at += part;
    }
    return bytes != NULL;
}

/* The indices of all objects; those out of range become such in the scene's mesh. */
static bool join_indices(const svo_moving *moving, svo_mesh *to)
{
    uint32_t *indices = svo_i_alloc_zeroed(&moving->device->memory, to->triangle_count, 3 * sizeof *indices);
    uint32_t *at = indices;
    size_t vertex = 0;
    to->indices = indices;
    for (uint32_t i = 0; i < moving->object_count && indices != NULL; ++i) {
        const svo_mesh *mesh = &moving->objects[i].mesh;
        const size_t corners = svo_i_moving_shows(&moving->objects[i]) ? mesh->triangle_count * 3 : 0;
        for (size_t k = 0; k < corners; ++k) {
            const size_t index = mesh->indices != NULL ? mesh->indices[k] : k;
            *at++ = index < mesh->vertex_count ? (uint32_t)(vertex + index) : UINT32_MAX;
        }
        vertex += corners > 0 ? mesh->vertex_count : 0;
    }
    return indices != NULL;
}

static bool join_all(const svo_moving *moving, svo_mesh *to)
{
    const svo_mesh *first = &moving->objects[0].mesh;
    bool materials = false;
    for (uint32_t i = 0; i < moving->object_count; ++i) {
        const svo_i_moving_object *object = &moving->objects[i];
        if (svo_i_moving_shows(object)) {
            to->vertex_count += object->mesh.vertex_count;
            to->triangle_count += object->mesh.triangle_count;
            materials = materials || object->mesh.triangle_materials != NULL;
        }
    }
    const struct {
        joined array;
        bool wanted;
    } all[] = {{{moving, offsetof(svo_mesh, positions), 12, false}, first->positions != NULL},
               {{moving, offsetof(svo_mesh, positions_double), 24, false}, first->positions_double != NULL},
               {{moving, offsetof(svo_mesh, normals), 12, false}, first->normals != NULL},
               {{moving, offsetof(svo_mesh, colors), 4, false}, first->colors != NULL},
               {{moving, offsetof(svo_mesh, uvs), 8, false}, first->uvs != NULL},
               {{moving, offsetof(svo_mesh, triangle_materials), 2, true}, materials}};
    bool fits = join_indices(moving, to);
    for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i) {
        fits = fits && join(&all[i].array, all[i].wanted, to);
    }
    return fits;
}

svo_status svo_moving_get_mesh(svo_moving *moving, svo_mesh *mesh)
{
    if (moving == NULL || mesh == NULL) {
        return svo_i_device_fail(moving != NULL ? moving->device : NULL, SVO_INVALID_ARGUMENT,
                                 "svo_moving_get_mesh: %s is NULL", moving == NULL ? "moving" : "mesh");
    }
    const svo_mesh *first = &moving->objects[0].mesh;
    if (moving->mesh.vertex_count == 0 && !join_all(moving, &moving->mesh)) {
        svo_i_moving_forget_mesh(moving);
        return svo_i_device_fail(moving->device, SVO_OUT_OF_HOST_MEMORY, "svo_moving_get_mesh: no memory for the mesh");
    }
    *mesh = moving->mesh;
    mesh->struct_size = sizeof *mesh;
    mesh->materials = first->materials;
    mesh->material_count = first->material_count;
    mesh->textures = first->textures;
    mesh->texture_count = first->texture_count;
    mesh->finishes = first->finishes;
    return SVO_OK;
}
