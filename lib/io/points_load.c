/* SPDX-License-Identifier: MIT */
/*
 * Point clouds to lists of voxels, in two readings: the first finds the bounds of the points and what their colors can
 * be, from which the grid follows; the second sums the points up by voxel (points_cells.c). points_las.c and
 * points_ply.c read files.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "core/limits.h"
#include "core/struct_size.h"
#include "core/voxel_list.h"
#include "io/points_cells.h"
#include "io/points_read.h"
#include "shared/nodes.clh"

#define COORDINATE_MAX 0x1p30 /* of a voxel of a list */
#define BLOCK_MAX      ((size_t)1 << 20) /* points that are sorted at a time */
#define BLOCK_MIN      ((size_t)1 << 12)
#define BLOCK_SHARE    4 /* the part of memory that blocks take, and no more */
#define MATERIAL_MAX   65534u
/* What a voxel takes while its tree is built: 20 bytes in the list, 140 in the plan (voxels.h), and buffers. */
#define BUILT_VOXEL_BYTES 200

/* One call. */
typedef struct cloud {
    const char *function;
    points_reader reader;
    svo_points_options options;
    svo_i_memory memory;
    svo_points_info info;
    svo_point *points; /* POINTS_AT_A_TIME; owned */
    bool is_turned;
    double far[3]; /* with options.edge: voxels of the cube along each axis */
    uint32_t rgb_greatest;
    double low_place[3]; /* the least voxel of the grid with a point */
    uint32_t bits; /* the others are below 2^bits along each axis, from there */
    uint64_t voxels_max;
    size_t block_points;
} point_cloud;

/* ---- the grid ---- */

/* The definition in svocl/points.h. */
static double place_of(const svo_points_info *info, size_t axis, double at)
{
    return floor((at - info->origin[axis]) / info->voxel_edge);
}

/* 2^depth voxels along the longest axis of the bounds. */
static void fit_grid(point_cloud *cloud)
{
    svo_points_info *info = &cloud->info;
    const double places = ldexp(1.0, (int)cloud->options.depth);
    double widest = 0.0;
    for (size_t axis = 0; axis < 3; ++axis) {
        info->origin[axis] = info->low[axis] + 0.0;
        widest = fmax(widest, info->high[axis] - info->low[axis]);
    }
    info->voxel_edge = widest > 0.0 ? widest / places : 1.0;
    for (size_t axis = 0; axis < 3; ++axis) {
        while (isfinite(info->voxel_edge) && place_of(info, axis, info->high[axis]) >= places) {
            info->voxel_edge = nextafter(info->voxel_edge, INFINITY);
        }
    }
}

/* The cube of the options, which is known before the points are. */
static void take_cube(point_cloud *cloud)
{
    cloud->info.voxel_edge = ldexp(cloud->options.edge, -(int)cloud->options.depth);
    for (size_t axis = 0; axis < 3; ++axis) {
        cloud->info.origin[axis] = cloud->options.origin[axis] + 0.0;
        cloud->far[axis] = ldexp(1.0, (int)cloud->options.depth);
    }
}

/* Makes the grid, after the first reading, and finds which part of it has points. */
static svo_status make_grid(point_cloud *cloud)
{
    svo_points_info *info = &cloud->info;
    int32_t low[3] = {0, 0, 0};
    int32_t high[3] = {0, 0, 0};
    if (cloud->options.voxel_edge > 0.0) {
        info->voxel_edge = cloud->options.voxel_edge;
        for (size_t axis = 0; axis < 3; ++axis) {
            info->origin[axis] = svo_i_voxel_plane(info->low[axis], info->voxel_edge);
        }
    } else if (cloud->options.edge <= 0.0) {
        fit_grid(cloud);
    }
    for (size_t axis = 0; axis < 3 && info->taken_count > 0; ++axis) {
        const double least = place_of(info, axis, info->low[axis]);
        const double greatest = place_of(info, axis, info->high[axis]);
        const char letter = "xyz"[axis];
        if (!(least >= -COORDINATE_MAX && greatest - least < SVO_VOXELS_EXTENT_MAX && greatest <= COORDINATE_MAX)) {
            return svo_i_points_fail(&cloud->reader, SVO_INVALID_ARGUMENT,
                                     "%c coordinates %g .. %g are more than %d voxels of width %g, or too far out for "
                                     "doubles",
                                     letter, info->low[axis], info->high[axis], SVO_VOXELS_EXTENT_MAX,
                                     info->voxel_edge);
        }
        cloud->low_place[axis] = least;
        high[axis] = (int32_t)(greatest - least) + 1;
    }
    cloud->bits = svo_i_voxel_bits(low, high);
    return SVO_OK;
}

/* ---- readings ---- */

static bool is_finite_point(const svo_point *point)
{
    return isfinite(point->at[0]) && isfinite(point->at[1]) && isfinite(point->at[2]);
}

static bool is_outside(const point_cloud *cloud, const svo_point *point)
{
    for (size_t axis = 0; axis < 3 && cloud->options.edge > 0.0; ++axis) {
        const double place = place_of(&cloud->info, axis, point->at[axis]);
        if (!(place >= 0.0 && place < cloud->far[axis])) {
            return true;
        }
    }
    return false;
}

/* What is done with a point that is taken. */
typedef svo_status (*take_point)(point_cloud *cloud, cell_set *cells, const svo_point *point);

static svo_status fail_cells(const point_cloud *cloud, const cell_set *cells)
{
    if (!cells->too_many) {
        return svo_i_points_fail(&cloud->reader, SVO_OUT_OF_HOST_MEMORY, "no memory for the voxels");
    }
    return cloud->options.voxels_max != 0 && cloud->voxels_max == cloud->options.voxels_max
               ? svo_i_points_fail(&cloud->reader, SVO_INVALID_ARGUMENT,
                                   "more than %" PRIu64 " voxels, the limit (voxels_max)", cloud->voxels_max)
               : svo_i_points_fail(&cloud->reader, SVO_OUT_OF_HOST_MEMORY,
                                   "more than %" PRIu64 " voxels, for which the limit of %s of memory has room "
                                   "(memory_bytes); a lower depth or wider voxels need less",
                                   cloud->voxels_max, svo_i_bytes(cloud->options.memory_bytes).text);
}

static svo_status fail_changed(const point_cloud *cloud)
{
    return svo_i_points_fail(&cloud->reader, SVO_FILE_ERROR, "its points changed while they were read");
}

/* Reads all points and gives those that are taken to a function. */
static svo_status read_points(point_cloud *cloud, take_point take, cell_set *cells)
{
    size_t count = 0;
    svo_points_info *info = &cloud->info;
    svo_i_points_begin(&cloud->reader);
    info->not_finite_count = info->outside_count = info->taken_count = 0;
    do {
        SVO_I_TRY(cloud->reader.next(&cloud->reader, cloud->points, &count));
        for (size_t i = 0; i < count; ++i) {
            svo_point *point = &cloud->points[i];
            const double y = point->at[1];
            point->at[1] = cloud->is_turned ? point->at[2] : y;
            point->at[2] = cloud->is_turned ? 0.0 - y : point->at[2];
            if (!is_finite_point(point)) {
                ++info->not_finite_count;
            } else if (is_outside(cloud, point)) {
                ++info->outside_count;
            } else {
                ++info->taken_count;
                SVO_I_TRY(take(cloud, cells, point));
            }
        }
    } while (count > 0);
    return SVO_OK;
}

/* The first reading: bounds, and the greatest of colors and intensities. */
static svo_status survey_point(point_cloud *cloud, cell_set *cells, const svo_point *point)
{
    (void)cells;
    svo_points_info *info = &cloud->info;
    for (size_t i = 0; i < 3; ++i) {
        const bool is_first = info->taken_count == 1;
        info->low[i] = is_first || point->at[i] < info->low[i] ? point->at[i] : info->low[i];
        info->high[i] = is_first || point->at[i] > info->high[i] ? point->at[i] : info->high[i];
        cloud->rgb_greatest = point->rgb[i] > cloud->rgb_greatest ? point->rgb[i] : cloud->rgb_greatest;
    }
    info->intensity_max = point->intensity > info->intensity_max ? point->intensity : info->intensity_max;
    return SVO_OK;
}

/* The second one: the voxel of a point and its channels. */
static svo_status place_point(point_cloud *cloud, cell_set *cells, const svo_point *point)
{
    uint32_t cell[3];
    placed_point placed = {.unused = 0};
    for (size_t axis = 0; axis < 3; ++axis) {
        const double place = place_of(&cloud->info, axis, point->at[axis]) - cloud->low_place[axis];
        if (!(place >= 0.0 && place < ldexp(1.0, (int)cloud->bits))) {
            return fail_changed(cloud);
        }
        cell[axis] = (uint32_t)place;
    }
    placed.code = svo_interleave(cell);
    for (size_t i = 0; i < 3; ++i) {
        placed.channels[i] = cloud->info.color == SVO_POINTS_RGB ? point->rgb[i] : point->intensity;
    }
    return svo_i_point_cells_add(cells, &placed) ? SVO_OK : fail_cells(cloud, cells);
}

/* What the colors of voxels are made of. */
static void choose_color(point_cloud *cloud)
{
    svo_points_info *info = &cloud->info;
    info->color = cloud->rgb_greatest > 0   ? SVO_POINTS_RGB
                  : info->intensity_max > 0 ? SVO_POINTS_INTENSITY
                                            : SVO_POINTS_WHITE;
    if (info->color == SVO_POINTS_RGB) {
        info->rgb_max = cloud->reader.rgb_max != 0        ? cloud->reader.rgb_max
                        : cloud->rgb_greatest > UINT8_MAX ? UINT16_MAX
                                                          : UINT8_MAX;
    }
}

static void warn(const point_cloud *cloud, uint64_t count, const char *what)
{
    svo_message line;
    if (count > 0 && cloud->options.log != NULL) {
        svo_i_message_set(&line, "%s: %" PRIu64 " of %" PRIu64 " points are left out: %s", cloud->reader.name, count,
                          cloud->info.point_count, what);
        cloud->options.log(cloud->options.log_user, SVO_LOG_WARNING, line.text);
    }
}

static svo_status survey(point_cloud *cloud)
{
    svo_points_info *info = &cloud->info;
    if (cloud->options.edge > 0.0) {
        take_cube(cloud);
    }
    SVO_I_TRY(read_points(cloud, survey_point, NULL));
    if (cloud->reader.rgb_max != 0 && cloud->rgb_greatest > cloud->reader.rgb_max) {
        return svo_i_points_fail(&cloud->reader, SVO_INVALID_ARGUMENT, "a color channel of %u is above rgb_max %u",
                                 cloud->rgb_greatest, cloud->reader.rgb_max);
    }
    choose_color(cloud);
    warn(cloud, info->not_finite_count, "a coordinate is not finite");
    warn(cloud, info->outside_count, "they are outside of the grid");
    warn(cloud, info->withheld_count, "they are marked as withheld");
    return make_grid(cloud);
}

/* ---- the list ---- */

/* 255 sum / (count most), rounded half up. It is exact: count is below 2^48, and a channel at most 2^16. */
static uint8_t mean_of(uint64_t sum, uint64_t count, uint32_t most)
{
    const uint64_t whole = sum / count;
    const uint64_t rest = sum % count;
    /* 255 sum may need more than 64 bits, so that the whole part of the mean is divided first. */
    const uint64_t scaled = 255 * whole;
    const uint64_t quotient = scaled / most;
    const uint64_t left = scaled % most * count + 255 * rest; /* of count most; below 2^16 2^48 */
    const uint64_t total = count * most;
    return (uint8_t)(quotient + left / total + (left % total >= total - left % total ? 1 : 0));
}

static svo_voxel voxel_of(const point_cloud *cloud, const point_cell *cell)
{
    const svo_points_info *info = &cloud->info;
    const uint32_t most = info->color == SVO_POINTS_RGB ? info->rgb_max : info->intensity_max;
    uint32_t place[3];
    svo_deinterleave(cell->code, place);
    svo_voxel voxel = {.x = (int32_t)(cloud->low_place[0] + place[0]),
                       .y = (int32_t)(cloud->low_place[1] + place[1]),
                       .z = (int32_t)(cloud->low_place[2] + place[2]),
                       .rgba = {255, 255, 255, 255}};
    for (size_t i = 0; i < 3 && info->color != SVO_POINTS_WHITE; ++i) {
        voxel.rgba[i] = mean_of(cell->sums[i], cell->count, most);
    }
    if (cloud->options.counts != 0) {
        voxel.material = (uint16_t)(cell->count < MATERIAL_MAX ? cell->count : MATERIAL_MAX);
    }
    return voxel;
}

/* Turns the cells, which are released meanwhile, to a list with counts. */
static svo_status make_list(point_cloud *cloud, cell_set *cells, svo_voxels **out)
{
    svo_status status = SVO_OK;
    const size_t count = cells->run_count > 0 ? cells->runs[0].count : 0;
    svo_voxel *voxels = svo_i_alloc(&cloud->memory, count * sizeof *voxels + 1);
    uint64_t *counts = svo_i_alloc(&cloud->memory, count * sizeof *counts + 1);
    svo_voxels_source source = {.struct_size = sizeof source,
                                .voxels = voxels,
                                .voxel_count = count,
                                .voxel_edge = cloud->info.voxel_edge,
                                .memory = cloud->options.memory};
    if (voxels == NULL || counts == NULL) {
        status = svo_i_points_fail(&cloud->reader, SVO_OUT_OF_HOST_MEMORY, "no memory for %zu voxels", count);
        goto cleanup;
    }
    for (size_t i = 0; i < count; ++i) {
        const point_cell *cell = &cells->runs[0].cells[i];
        voxels[i] = voxel_of(cloud, cell);
        counts[i] = cell->count;
        cloud->info.count_max = cell->count > cloud->info.count_max ? cell->count : cloud->info.count_max;
    }
    svo_i_point_cells_end(cells);
    memcpy(source.origin, cloud->info.origin, sizeof source.origin);
    status = svo_voxels_create(&source, out, cloud->reader.message);
    if (status != SVO_OK) {
        svo_i_message_rename(cloud->reader.message, cloud->reader.name);
        goto cleanup;
    }
    cloud->info.voxel_count = count;
    (void)svo_voxels_set_axes(*out, (svo_axes)cloud->options.axes);
    (*out)->counts = counts; /* the list's order is that of the cells: codes count from its least corner */
    counts = NULL;
cleanup:
    svo_i_free(voxels);
    svo_i_free(counts);
    return status;
}

/* How memory is divided: blocks of points, and what is left for voxels. */
static void divide_memory(point_cloud *cloud)
{
    const uint64_t memory = cloud->options.memory_bytes;
    const uint64_t fixed = POINTS_WINDOW_BYTES + POINTS_AT_A_TIME * sizeof(svo_point);
    const uint64_t most = memory / BLOCK_SHARE / BLOCK_POINT_BYTES;
    const uint64_t needed = cloud->info.point_count < most ? cloud->info.point_count : most;
    cloud->block_points = needed > BLOCK_MAX ? BLOCK_MAX : needed < BLOCK_MIN ? BLOCK_MIN : (size_t)needed;
    cloud->voxels_max = (memory - fixed - cloud->block_points * BLOCK_POINT_BYTES) / BUILT_VOXEL_BYTES;
    if (cloud->options.voxels_max != 0 && cloud->options.voxels_max < cloud->voxels_max) {
        cloud->voxels_max = cloud->options.voxels_max;
    }
    cloud->voxels_max = cloud->voxels_max < SVO_VOXELS_MAX ? cloud->voxels_max : SVO_VOXELS_MAX;
}

static svo_status collect_list(point_cloud *cloud, svo_voxels **out)
{
    svo_status status = SVO_OK;
    divide_memory(cloud);
    cell_set cells = {.memory = &cloud->memory,
                      .bits = 3 * cloud->bits,
                      .cells_max = (size_t)cloud->voxels_max,
                      .block_points = cloud->block_points};
    if (!svo_i_point_cells_begin(&cells)) {
        SVO_I_TRY_CLEANUP(fail_cells(cloud, &cells));
    }
    const uint64_t taken = cloud->info.taken_count;
    SVO_I_TRY_CLEANUP(read_points(cloud, place_point, &cells));
    if (taken != cloud->info.taken_count) {
        SVO_I_TRY_CLEANUP(fail_changed(cloud));
    }
    if (!svo_i_point_cells_finish(&cells)) {
        SVO_I_TRY_CLEANUP(fail_cells(cloud, &cells));
    }
    SVO_I_TRY_CLEANUP(make_list(cloud, &cells, out));
cleanup:
    svo_i_point_cells_end(&cells);
    return status;
}

/* ---- calls ---- */

static svo_status refuse(const point_cloud *cloud, const char *what, double value, const char *limit)
{
    return svo_i_fail(cloud->reader.message, SVO_INVALID_ARGUMENT, "%s: options.%s %g is not %s", cloud->function, what,
                      value, limit);
}

static svo_status check_grid_options(const point_cloud *cloud)
{
    const svo_points_options *asked = &cloud->options;
    if (!(asked->voxel_edge >= 0.0) || !isfinite(asked->voxel_edge)) {
        return refuse(cloud, "voxel_edge", asked->voxel_edge, "0 or a finite number above");
    }
    if (!(asked->edge >= 0.0) || !isfinite(asked->edge)) {
        return refuse(cloud, "edge", asked->edge, "0 or a finite number above");
    }
    if (asked->edge > 0.0 && (asked->voxel_edge > 0.0 || !(ldexp(asked->edge, -(int)asked->depth) > 0.0))) {
        return refuse(cloud, "edge", asked->edge,
                      asked->voxel_edge > 0.0 ? "0, as it must be with voxel_edge" : "wide enough");
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (!isfinite(asked->origin[axis]) || (asked->edge <= 0.0 && asked->origin[axis] != 0.0)) {
            return refuse(cloud, "origin", asked->origin[axis],
                          asked->edge > 0.0 ? "finite" : "0, as it must be without edge");
        }
    }
    return SVO_OK;
}

/* Checks what a function takes, and fills in defaults. */
static svo_status start(point_cloud *cloud, const svo_points_options *options, const svo_points_info *info)
{
    svo_points_options *asked = &cloud->options;
    svo_message *message = cloud->reader.message;
    SVO_I_TRY(svo_i_struct_read(message, cloud->function, "options", options, asked,
                                SVO_I_STRUCT_SIZES(svo_points_options, memory)));
    SVO_I_TRY(svo_i_memory_read(message, cloud->function, "options.memory", asked->memory, &cloud->memory));
    SVO_I_TRY(info == NULL ? SVO_OK
                           : svo_i_struct_check(message, cloud->function, "info", info,
                                                SVO_I_STRUCT_SIZES(svo_points_info, count_max)));
    if (asked->depth > SVO_DEPTH_MAX) {
        return refuse(cloud, "depth", asked->depth, "in 0 .. 16");
    }
    if (asked->axes > SVO_AXES_Z_UP) {
        return refuse(cloud, "axes", asked->axes, "in 0 .. 2");
    }
    if (asked->memory_bytes != 0 && asked->memory_bytes < SVO_POINTS_MEMORY_MIN) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: options.memory_bytes %" PRIu64 " is below %" PRIu64,
                          cloud->function, asked->memory_bytes, SVO_POINTS_MEMORY_MIN);
    }
    if (asked->voxels_max > SVO_VOXELS_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: options.voxels_max %" PRIu64 " is above %u",
                          cloud->function, asked->voxels_max, SVO_VOXELS_MAX);
    }
    asked->depth = asked->depth == 0 ? SVO_POINTS_DEPTH_DEFAULT : asked->depth;
    asked->memory_bytes = asked->memory_bytes == 0 ? svo_i_host_memory_bytes() : asked->memory_bytes;
    asked->memory_bytes = asked->memory_bytes < SVO_POINTS_MEMORY_MIN ? SVO_POINTS_MEMORY_MIN : asked->memory_bytes;
    cloud->reader.memory = &cloud->memory;
    cloud->reader.info = &cloud->info;
    cloud->info.struct_size = sizeof cloud->info;
    return check_grid_options(cloud);
}

/* Both readings, of a reader that is open. */
static svo_status collect(point_cloud *cloud, svo_voxels **out, svo_points_info *info)
{
    cloud->points = svo_i_alloc(&cloud->memory, POINTS_AT_A_TIME * sizeof *cloud->points);
    if (cloud->points == NULL) {
        return svo_i_points_fail(&cloud->reader, SVO_OUT_OF_HOST_MEMORY, "no memory for a block of points");
    }
    const svo_axes axes = (svo_axes)cloud->options.axes;
    cloud->is_turned = axes == SVO_AXES_Z_UP || (axes == SVO_AXES_AUTO && cloud->reader.is_z_up);
    SVO_I_TRY(survey(cloud));
    SVO_I_TRY(out != NULL ? collect_list(cloud, out) : SVO_OK);
    return info == NULL ? SVO_OK
                        : svo_i_struct_write(NULL, "", "info", &cloud->info, info,
                                             SVO_I_STRUCT_SIZES(svo_points_info, count_max));
}

/* No more than the file has: one that is read too far is then found. */
static size_t window_bytes(const svo_i_source *file)
{
    return file->byte_count < POINTS_WINDOW_BYTES ? (size_t)file->byte_count + 1 : POINTS_WINDOW_BYTES;
}

/* Finds the reader of a file by its first bytes. */
static svo_status open_format(point_cloud *cloud)
{
    points_reader *reader = &cloud->reader;
    reader->window = svo_i_alloc(&cloud->memory, window_bytes(&reader->file));
    if (reader->window == NULL) {
        return svo_i_points_fail(reader, SVO_OUT_OF_HOST_MEMORY, "no memory for a part of the file");
    }
    SVO_I_TRY(svo_i_points_need(reader, POINTS_WINDOW_BYTES));
    const char *bytes = (const char *)reader->window;
    if (text_begins_with(bytes, reader->window_count, LAS_MAGIC)) {
        return svo_i_points_open_las(reader);
    }
    return text_begins_with(bytes, reader->window_count, "ply") || text_begins_with(bytes, reader->window_count, "PLY")
               ? svo_i_points_open_ply(reader)
               : svo_i_points_damaged(reader, "byte 0: neither a .ply nor a .las file");
}

svo_status svo_points_load(svo_source source, const svo_points_options *options, svo_voxels **out,
                           svo_points_info *info, svo_message *message)
{
    svo_status status = SVO_OK;
    point_cloud cloud = {.function = "svo_points_load", .reader = {.message = message}};
    SVO_I_TRY(start(&cloud, options, info));
    SVO_I_TRY(svo_i_source_open(cloud.function, source, message, &cloud.reader.file));
    cloud.reader.name = cloud.reader.file.name;
    SVO_I_TRY_CLEANUP(open_format(&cloud));
    SVO_I_TRY_CLEANUP(collect(&cloud, out, info));
cleanup:
    svo_i_source_close(&cloud.reader.file);
    svo_i_free(cloud.reader.window);
    svo_i_free(cloud.points);
    return status;
}

/* ---- a caller's points ---- */

static svo_status next_given(points_reader *reader, svo_point *points, size_t *count)
{
    const svo_points_source *given = reader->given;
    const uint64_t left = given->point_count - reader->at;
    *count = left < POINTS_AT_A_TIME ? (size_t)left : POINTS_AT_A_TIME;
    if (*count > 0 && given->points != NULL) {
        memcpy(points, given->points + reader->at, *count * sizeof *points);
    } else if (*count > 0 && given->read(given->user, reader->at, points, *count) != 0) {
        return svo_i_points_fail(reader, SVO_FILE_ERROR, "source.read failed at point %" PRIu64, reader->at);
    }
    reader->at += *count;
    return SVO_OK;
}

static svo_status check_source(const point_cloud *cloud, const svo_points_source *source)
{
    svo_message *message = cloud->reader.message;
    if (source->point_count > SVO_POINTS_MAX) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source.point_count %" PRIu64 " is above %" PRIu64,
                          cloud->function, source->point_count, SVO_POINTS_MAX);
    }
    if (source->points == NULL && source->read == NULL && source->point_count > 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source.points and source.read are NULL", cloud->function);
    }
    return source->rgb_max == 0 || source->rgb_max == UINT8_MAX || source->rgb_max == UINT16_MAX
               ? SVO_OK
               : svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source.rgb_max %u is not 0, 255 or 65535",
                            cloud->function, source->rgb_max);
}

svo_status svo_points_collect(const svo_points_source *source, const svo_points_options *options, svo_voxels **out,
                              svo_points_info *info, svo_message *message)
{
    svo_points_source given;
    point_cloud cloud = {.function = "svo_points_collect", .reader = {.message = message}};
    cloud.reader.file.file = -1;
    if (source == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, "%s: source is NULL", cloud.function);
    }
    SVO_I_TRY(svo_i_struct_read(message, cloud.function, "source", source, &given,
                                SVO_I_STRUCT_SIZES(svo_points_source, reserved)));
    SVO_I_TRY(start(&cloud, options, info));
    SVO_I_TRY(check_source(&cloud, &given));
    cloud.reader.name = cloud.function;
    cloud.reader.given = &given;
    cloud.reader.rgb_max = given.rgb_max;
    cloud.reader.next = next_given;
    cloud.info.point_count = given.point_count;
    const svo_status status = collect(&cloud, out, info);
    svo_i_free(cloud.points);
    return status;
}

/* ---- what a file is ---- */

/* Whether a header declares vertices, and neither faces nor strips. */
static bool declares_points(const ply_header *header)
{
    bool has_vertices = false;
    for (size_t i = 0; i < header->element_count; ++i) {
        const ply_element *element = &header->elements[i];
        has_vertices = has_vertices || strcmp(element->name, "vertex") == 0;
        if (element->count > 0 && (strcmp(element->name, "face") == 0 || strcmp(element->name, "tristrips") == 0)) {
            return false;
        }
    }
    return has_vertices;
}

static svo_voxel_format format_of(points_reader *reader)
{
    ply_header header = {.element_count = 0};
    text_cursor cursor;
    if (svo_i_points_need(reader, POINTS_WINDOW_BYTES) != SVO_OK) {
        return SVO_VOXEL_FORMAT_AUTO;
    }
    const mesh_reader text = {.bytes = (const char *)reader->window, .byte_count = reader->window_count};
    if (text_begins_with(text.bytes, text.byte_count, LAS_MAGIC)) {
        return svo_i_las_is_packed(reader) ? SVO_VOXEL_FORMAT_LAZ : SVO_VOXEL_FORMAT_LAS;
    }
    const bool is_points = svo_i_ply_read_header(&text, &cursor, &header) == SVO_OK && declares_points(&header);
    svo_i_ply_header_free(&header);
    return is_points ? SVO_VOXEL_FORMAT_PLY : SVO_VOXEL_FORMAT_AUTO;
}

svo_voxel_format svo_points_format(svo_source source)
{
    points_reader reader = {.message = NULL};
    svo_voxel_format format = SVO_VOXEL_FORMAT_AUTO;
    if (svo_i_source_open("svo_points_format", source, NULL, &reader.file) != SVO_OK) {
        return format;
    }
    reader.name = reader.file.name;
    reader.window = svo_i_alloc(NULL, window_bytes(&reader.file));
    format = reader.window != NULL ? format_of(&reader) : format;
    svo_i_free(reader.window);
    svo_i_source_close(&reader.file);
    return format;
}
