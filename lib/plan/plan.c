/* SPDX-License-Identifier: MIT */
/*
 * Creates plans: checks the request, has its mesh taken in by the host (grid.c, attributes.c) or by kernels
 * (device_plan.c), with the same bytes, and configures the build. A measuring build predicts the sizes later
 * (pipeline/run.c). All later steps of the pipeline follow the plan.
 */
#include "plan/plan.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/mesh.h"
#include "core/opencl.h"
#include "core/struct_size.h"
#include "plan/accounts.h"
#include "plan/arrays.h"
#include "plan/attributes.h"
#include "plan/configuration.h"
#include "plan/device_plan.h"
#include "plan/estimate.h"
#include "plan/grid.h"
#include "plan/programs.h"
#include "plan/update.h"
#include "svocl/nodes.h"

/* ---- positions ---- */

/*
 * Keeps the mesh's own vertices beside the snapped ones: voxels that these leave undecided are decided by the former,
 * and rays meet the mesh as it was given.
 */

/* Copies the elements of a vertex for each corner; vertices without a triangle stay 0, since they may not be finite. */
static void copy_used(const svo_plan *plan, const void *from, void *to, size_t vertex_bytes)
{
    for (size_t i = 0; i < (size_t)plan->triangle_count * 3; ++i) {
        const size_t at = plan->indices[i] * vertex_bytes;
        memcpy((char *)to + at, (const char *)from + at, vertex_bytes);
    }
}

/* Copies the positions of the vertices that kept triangles use, as floats or doubles like the mesh's. */
static svo_status keep_positions(svo_plan *plan, const svo_mesh *mesh)
{
    const bool is_double = mesh->positions_double != NULL;
    const size_t vertex_bytes = is_double ? 3 * sizeof(double) : 3 * sizeof(float);
    void *copy = svo_i_alloc_zeroed(&plan->device->memory, (size_t)plan->vertex_count + 1, vertex_bytes);
    if (copy == NULL) {
        return svo_i_device_fail(plan->device, SVO_OUT_OF_HOST_MEMORY,
                                 "svo_plan_create: no memory for the positions of %u vertices", plan->vertex_count);
    }
    if (is_double) {
        plan->positions_double = copy;
        copy_used(plan, mesh->positions_double, copy, vertex_bytes);
    } else {
        plan->positions = copy;
        copy_used(plan, mesh->positions, copy, vertex_bytes);
    }
    return SVO_OK;
}

/* ---- where a plan is made ---- */

/* Whether the device's doubles are those of the host: with denormals, rounded to nearest; floats with denormals. */
static svo_status find_doubles(svo_device *device, const char *function, bool *has_doubles)
{
    const cl_device_fp_config needed = CL_FP_DENORM | CL_FP_INF_NAN | CL_FP_ROUND_TO_NEAREST;
    cl_device_fp_config doubles = 0;
    cl_device_fp_config floats = 0;
    SVO_I_TRY(svo_i_device_property(device->device, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof doubles, &doubles, function,
                                    &device->message));
    SVO_I_TRY(svo_i_device_property(device->device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof floats, &floats, function,
                                    &device->message));
    *has_doubles = (doubles & needed) == needed && (floats & needed) == needed;
    return SVO_OK;
}

/* Whether kernels are likely quicker. A handle with max_device_bytes has its memory for builds. */
static bool prefers_kernels(svo_device *device, const char *function, uint64_t triangles)
{
    bool has_doubles = false;
    if (device->saves_memory || triangles < SVO_I_KERNEL_TRIANGLES_MIN) {
        return false;
    }
    device->planned_triangles += triangles;
    return (svo_i_program_known(device, &svo_i_program_plan, "") ||
            device->planned_triangles >= SVO_I_LOAD_TRIANGLES) &&
           !svo_i_program_wrong(device, &svo_i_program_plan, "") &&
           find_doubles(device, function, &has_doubles) == SVO_OK && has_doubles;
}

/* Names the kept triangles of a part by their positions among those of the whole. */
static void name_triangles(svo_plan *plan)
{
    if (svo_i_plan_is_part(plan)) {
        svo_i_free(plan->triangle_ids);
        plan->triangle_ids = plan->part.positions;
        plan->part.positions = NULL;
    }
}

static svo_status take_on_host(svo_plan *plan, const svo_i_plan_input *input)
{
    plan->info.place = SVO_PLACE_HOST;
    SVO_I_TRY(svo_i_plan_grid(plan, &input->mesh));
    SVO_I_TRY(svo_i_plan_attributes(plan, &input->mesh));
    name_triangles(plan);
    return keep_positions(plan, &input->mesh);
}

static svo_status take_on_device(svo_plan *plan, const svo_i_plan_input *input)
{
    svo_i_device_work work;
    svo_i_device_mesh mesh = {0};
    bool has_doubles = false;
    plan->info.place = SVO_PLACE_DEVICE;
    SVO_I_TRY(find_doubles(plan->device, plan->progress.function, &has_doubles));
    if (!has_doubles) {
        return svo_i_device_fail(plan->device, SVO_UNSUPPORTED,
                                 "%s: %s has no doubles with denormals, which a plan's kernels need",
                                 plan->progress.function, plan->device->name);
    }
    SVO_I_TRY(svo_i_work_begin(plan->device, plan->progress.function, input->queue, &work));
    work.wait_count = input->wait_count;
    work.wait = input->wait;
    const svo_status status = plan->options.updatable != 0 ? svo_i_update_create(plan, &work, input, &mesh)
                                                           : svo_i_device_take_mesh(plan, &work, input, &mesh);
    svo_i_work_end(&work);
    svo_i_device_mesh_free(&mesh);
    return status;
}

/* Frees what an attempt has left, and restores the plan from before it. */
static void start_over(svo_plan *plan, const svo_plan *before)
{
    const svo_i_progress progress = plan->progress;
    svo_i_plan_memory_free(&plan->memory);
    svo_i_free(plan->large);
    svo_i_free(plan->materials);
    svo_i_free(plan->texels);
    *plan = *before;
    plan->progress = progress;
}

/* Says that the plan's kernels are not used on the device from now on, and why. */
static void warn_unreliable(const svo_device *device)
{
    char text[SVO_MESSAGE_BYTES + 64];
    (void)snprintf(text, sizeof text, "%s; plans are made on the host", device->message.text);
    svo_i_device_log(device, SVO_LOG_WARNING, text);
}

/* Takes the mesh into a plan: the grid, the draw items, the payload inputs. The bytes are the same in both places. */
static svo_status take_mesh(svo_plan *plan, const svo_i_plan_input *input)
{
    const svo_plan before = *plan;
    if (plan->options.place == SVO_PLACE_DEVICE || plan->options.updatable != 0 || input->buffers != NULL) {
        return take_on_device(plan, input);
    }
    if (plan->options.place == SVO_PLACE_HOST || svo_i_plan_is_part(plan) ||
        !prefers_kernels(plan->device, plan->progress.function, input->mesh.triangle_count)) {
        return take_on_host(plan, input);
    }
    const svo_status status = take_on_device(plan, input);
    if (status == SVO_DEVICE_UNRELIABLE) {
        warn_unreliable(plan->device);
    } else if (status != SVO_OUT_OF_DEVICE_MEMORY && status != SVO_COMPILE_FAILED) {
        return status;
    }
    start_over(plan, &before);
    return take_on_host(plan, input);
}

#define ALPHA_ONE 255.0

/* ---- parts: what the header of the whole decides ---- */

/* The same units for all depths up to 12, so that their trees nest. Above, a voxel has 2^8 units. */
#define SNAP_BITS           20u
#define SNAP_BITS_DEPTH_MAX 12u
#define DEEP_VOXEL_LOG2     8u

/* Limits on the unit of weights in a header; those of attributes.c lie inside. */
#define WEIGHT_LOG2_MAX 48u

uint32_t svo_i_plan_snap_bits(uint32_t depth)
{
    return depth <= SNAP_BITS_DEPTH_MAX ? SNAP_BITS : depth + DEEP_VOXEL_LOG2;
}

/* Trees deeper than SVO_DEPTH_MAX are there in parts alone, and are never loaded as a whole, as lists require. */
static svo_status check_depth(svo_device *device, const char *function, uint32_t depth, bool is_of_parts,
                              const svo_plan_options *options)
{
    const bool is_part = options->part_header != NULL;
    const uint32_t most = is_part || is_of_parts ? SVO_PARTS_DEPTH_MAX : SVO_DEPTH_MAX;
    if (depth < SVO_DEPTH_MIN || depth > most) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: depth %u is not in %d .. %u", function, depth,
                                 SVO_DEPTH_MIN, most);
    }
    if (is_part && options->part_level < depth && depth - options->part_level > SVO_DEPTH_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: a part of options.part_level %u has %u levels, above %d", function,
                                 options->part_level, depth - options->part_level, SVO_DEPTH_MAX);
    }
    return depth <= SVO_DEPTH_MAX || (options->need & SVO_NEED_RAYS) == 0
               ? SVO_OK
               : svo_i_device_fail(device, SVO_UNSUPPORTED, "%s: options.need has rays, and depth %u is above %d",
                                   function, depth, SVO_DEPTH_MAX);
}

/* Why a header cannot be that of a tree of that depth, or NULL. */
static const char *wrong_header(const svo_part_header *header, uint32_t depth)
{
    if (header->depth != depth) {
        return "is of a tree of another depth";
    }
    if (header->snap_bits != svo_i_plan_snap_bits(depth) || header->coverage > SVO_COVERAGE_THIN ||
        header->weights > SVO_WEIGHTS_CENTER || header->payload_level > depth ||
        (header->need & ~(uint32_t)SVO_NEED_ALL) != 0 || (header->constant & ~header->need) != 0 ||
        header->weight_log2 > WEIGHT_LOG2_MAX || header->least_alpha > UINT8_MAX ||
        (depth > SVO_DEPTH_MAX && (header->need & SVO_NEED_RAYS) != 0)) {
        return "has values that no plan has";
    }
    const bool has_grid = isfinite(header->origin[0]) && isfinite(header->origin[1]) && isfinite(header->origin[2]) &&
                          isfinite(header->edge) && isfinite(header->scale) && header->scale > 0.0;
    return has_grid ? NULL : "has a grid that is not finite";
}

static svo_status check_place(svo_device *device, const char *function, uint32_t depth, const svo_plan_options *options)
{
    if (options->part_level >= depth) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.part_level %u is not below depth %u",
                                 function, options->part_level, depth);
    }
    if (options->part_code >> (3 * options->part_level) != 0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.part_code %llu is not below 8^%u", function,
                                 (unsigned long long)options->part_code, options->part_level);
    }
    return options->place != SVO_PLACE_DEVICE
               ? SVO_OK
               : svo_i_device_fail(device, SVO_UNSUPPORTED,
                                   "%s: options.place is device; parts are planned on the host", function);
}

/* The whole's request, as far as it concerns the part. */
static void take_request(const svo_part_header *header, svo_plan_options *options)
{
    const uint32_t level = options->part_level;
    options->need = header->need != 0 ? header->need : (uint32_t)SVO_NEED_NONE;
    options->coverage = (svo_coverage)header->coverage;
    options->weights = (svo_weights)header->weights;
    options->payload_level = header->payload_level > level ? header->payload_level - level : 0;
    options->edge = 0.0;
    options->drop_alpha = header->least_alpha / ALPHA_ONE;
    memset(options->origin, 0, sizeof options->origin);
}

/* Checks the options of a part and replaces those that the header decides. Leaves *part as it is where there is no
   header. */
static svo_status read_part(svo_device *device, const char *function, uint32_t depth, svo_plan_options *options,
                            svo_i_plan_part *part)
{
    svo_part_header header;
    if (options->part_header == NULL) {
        return SVO_OK;
    }
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "options.part_header", options->part_header, &header,
                                SVO_I_STRUCT_SIZES(svo_part_header, expected_nodes)));
    const char *wrong = wrong_header(&header, depth);
    if (wrong != NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.part_header %s", function, wrong);
    }
    SVO_I_TRY(check_place(device, function, depth, options));
    take_request(&header, options);
    *part = (svo_i_plan_part){.header = header, .level = options->part_level, .code = options->part_code};
    uint32_t cell[3];
    svo_code_to_cell(part->code, cell);
    for (unsigned axis = 0; axis < 3; ++axis) {
        part->corner[axis] = (int32_t)(cell[axis] << (header.snap_bits - part->level));
    }
    return SVO_OK;
}

/* ---- the handle ---- */

/* Far above the fragments of one column of one triangle, which a chunk must hold. */
#define CHUNK_BYTES_MIN 16384

/* The fields of plans whose mesh moves. */
static svo_status check_updatable(svo_device *device, const char *function, const svo_plan_options *options)
{
    if (!isfinite(options->max_area) || options->max_area < 0.0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.max_area %g is not finite and at least 0",
                                 function, options->max_area);
    }
    if (options->weight_log2 != 0 && options->weight_log2 < SVO_I_WEIGHT_LOG2_MIN) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.weight_log2 %u is below %u", function,
                                 options->weight_log2, SVO_I_WEIGHT_LOG2_MIN);
    }
    if (options->updatable != 0 && options->place == SVO_PLACE_HOST) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: options.place is host; updatable plans are made on the device", function);
    }
    if (options->updatable != 0 && options->part_header != NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: options has part_header and updatable; parts cannot be updated", function);
    }
    return SVO_OK;
}

static svo_status check_options(svo_device *device, const char *function, const svo_plan_options *options)
{
    SVO_I_TRY(check_updatable(device, function, options));
    if ((options->need & ~((uint32_t)SVO_NEED_ALL | (uint32_t)SVO_NEED_NONE)) != 0 ||
        ((options->need & SVO_NEED_NONE) != 0 && options->need != SVO_NEED_NONE)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.need 0x%x is not a combination of svo_need",
                                 function, options->need);
    }
    if ((unsigned)options->coverage > SVO_COVERAGE_THIN) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.coverage %d is not in 0 .. %d", function,
                                 (int)options->coverage, (int)SVO_COVERAGE_THIN);
    }
    if ((unsigned)options->builder > SVO_BUILDER_SORTED) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.builder %d is not in 0 .. %d", function,
                                 (int)options->builder, (int)SVO_BUILDER_SORTED);
    }
    if ((unsigned)options->weights > SVO_WEIGHTS_CENTER) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.weights %d is not in 0 .. %d", function,
                                 (int)options->weights, (int)SVO_WEIGHTS_CENTER);
    }
    if ((unsigned)options->place > SVO_PLACE_DEVICE) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.place %d is not in 0 .. %d", function,
                                 (int)options->place, (int)SVO_PLACE_DEVICE);
    }
    if ((options->need & SVO_NEED_FILL) != 0 && options->weights != SVO_WEIGHTS_AREA) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT,
                                 "%s: options.need has fill, which requires weights area, and "
                                 "options.weights is %s",
                                 function, svo_name(SVO_NAME_WEIGHTS, options->weights));
    }
    if (!(options->drop_alpha >= 0.0 && options->drop_alpha <= 1.0)) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.drop_alpha %g is not in 0 .. 1", function,
                                 options->drop_alpha);
    }
    if (!isfinite(options->edge) || options->edge < 0.0) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.edge %g is not finite and at least 0",
                                 function, options->edge);
    }
    if (options->fragment_capacity > SVO_I_FRAGMENTS_MAX) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.fragment_capacity %llu is above %u",
                                 function, (unsigned long long)options->fragment_capacity, SVO_I_FRAGMENTS_MAX);
    }
    if (options->chunk_bytes != 0 && options->chunk_bytes < CHUNK_BYTES_MIN) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.chunk_bytes %llu is below %d", function,
                                 (unsigned long long)options->chunk_bytes, CHUNK_BYTES_MIN);
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
        if (!isfinite(options->origin[axis])) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.origin[%u] %g is not finite", function,
                                     axis, options->origin[axis]);
        }
    }
    return SVO_OK;
}

static svo_status check_input(svo_device *device, const char *function, const svo_i_plan_input *input,
                              const svo_plan_options *options)
{
    SVO_I_TRY(check_options(device, function, options));
    if (input->buffers == NULL) {
        return svo_i_mesh_check_host(device, function, &input->mesh);
    }
    if (options->place == SVO_PLACE_HOST || options->part_header != NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s; the mesh is on the device", function,
                                 options->place == SVO_PLACE_HOST ? "options.place is host"
                                                                  : "options.part_header needs a plan on the host");
    }
    SVO_I_TRY(svo_i_mesh_check(function, device->context, input->buffers, &device->message));
    SVO_I_TRY(svo_i_device_check_wait(device, function, input->wait_count, input->wait));
    return svo_i_mesh_check_counts(device, function, &input->mesh);
}

/* Fills a plan whose device, options, depth and stages are set. */
static svo_status make_plan(svo_plan *plan, const char *function, const svo_i_plan_input *input)
{
    const svo_mesh *mesh = &input->mesh;
    const double start_ms = svo_i_now_ms();
    const double compiled_ms = plan->device->compile_ms;
    const uint32_t depth = plan->info.depth;
    plan->info.snap_bits = svo_i_plan_snap_bits(depth + plan->part.level) - plan->part.level;
    plan->info.coverage = plan->options.coverage;
    plan->voxel_log2 = plan->info.snap_bits - depth;
    plan->progress.expected_ns[SVO_STAGE_GRID] = SVO_I_SNAP_NS * (double)mesh->vertex_count +
                                                 (SVO_I_KEEP_NS + SVO_I_ATTRIBUTES_NS) * (double)mesh->triangle_count;
    SVO_I_TRY(svo_i_progress_begin(plan, function, SVO_I_STAGE_BIT(SVO_STAGE_GRID)));
    SVO_I_TRY(take_mesh(plan, input));
    plan->info.expected_fragments = svo_i_plan_expected(plan, depth);
    plan->info.area = plan->estimate[2] / (plan->info.scale * plan->info.scale * sqrt(3.0));
    SVO_I_TRY(svo_i_plan_configure(plan));
    plan->info.grid_ms = svo_i_now_ms() - start_ms - (plan->device->compile_ms - compiled_ms);
    return SVO_OK;
}

svo_status svo_i_plan_new(svo_device *device, const char *function, const svo_i_plan_input *input, unsigned depth,
                          const svo_plan_options *options, const svo_i_stage_list *stages, svo_plan **out)
{
    svo_plan_options asked;
    SVO_I_TRY(svo_i_struct_read(&device->message, function, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_plan_options, coverage)));
    SVO_I_TRY(check_depth(device, function, depth, input->is_of_parts, &asked));
    svo_i_plan_part part = {.level = 0};
    SVO_I_TRY(read_part(device, function, depth, &asked, &part));
    SVO_I_TRY(check_input(device, function, input, &asked));
    depth -= part.level;
    if (asked.payload_level > depth) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: options.payload_level %u is above depth %u",
                                 function, asked.payload_level, depth);
    }
    svo_plan *plan = svo_i_alloc_zeroed(&device->memory, 1, sizeof *plan);
    if (plan == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for the handle", function);
    }
    plan->device = device;
    plan->options = asked;
    plan->part = part;
    plan->least_alpha =
        svo_i_plan_is_part(plan) ? part.header.least_alpha : (uint32_t)ceil(asked.drop_alpha * ALPHA_ONE);
    svo_plan_set_progress(plan, asked.progress, asked.progress_user);
    plan->info.depth = depth;
    plan->stages = stages->rows;
    plan->stage_count = stages->count;
    plan->exact_normals = input->exact_normals;
    const svo_status status = make_plan(plan, function, input);
    plan->exact_normals = NULL;
    if (status != SVO_OK) {
        svo_plan_destroy(&plan);
        return status;
    }
    *out = plan;
    return SVO_OK;
}

void svo_plan_destroy(svo_plan **plan)
{
    if (plan == NULL || *plan == NULL) {
        return;
    }
    svo_plan *p = *plan;
    svo_i_update_destroy(p->update);
    svo_i_plan_memory_free(&p->memory);
    svo_i_free(p->vertices);
    svo_i_free(p->remainders);
    svo_i_free(p->indices);
    svo_i_free(p->triangle_ids);
    svo_i_free(p->part.positions);
    svo_i_free(p->positions);
    svo_i_free(p->positions_double);
    svo_i_free(p->items);
    svo_i_free(p->item_fragments);
    svo_i_free(p->large);
    svo_i_free(p->records);
    svo_i_free(p->colors);
    svo_i_free(p->normals);
    svo_i_free(p->uvs);
    svo_i_free(p->materials);
    svo_i_free(p->texels);
    svo_i_free(p);
    *plan = NULL;
}

svo_status svo_plan_get_info(const svo_plan *plan, svo_plan_info *info)
{
    svo_plan_info found = plan->info;
    found.ray_depth = svo_i_plan_ray_depth(plan);
    found.buffer_count = (uint32_t)plan->buffer_count;
    found.peak_bytes = plan->peak_bytes;
    found.tree_bytes = svo_i_plan_tree_bytes(plan);
    found.kernels_count = (uint32_t)plan->work.kernels_count;
    found.left_out_count = (uint32_t)plan->work.left_out_count;
    found.drops_pairs = plan->work.drop ? 1 : 0;
    return svo_i_struct_write(&plan->device->message, "svo_plan_get_info", "info", &found, info,
                              SVO_I_STRUCT_SIZES(svo_plan_info, coverage));
}

svo_status svo_plan_get_buffer(const svo_plan *plan, size_t index, svo_buffer_info *info)
{
    static const char function[] = "svo_plan_get_buffer";
    if (index >= plan->buffer_count) {
        return svo_i_device_fail(plan->device, SVO_INVALID_ARGUMENT, "%s: index %zu is not below %zu", function, index,
                                 plan->buffer_count);
    }
    return svo_i_struct_write(&plan->device->message, function, "info", &plan->buffers[index], info,
                              SVO_I_STRUCT_SIZES(svo_buffer_info, count));
}
