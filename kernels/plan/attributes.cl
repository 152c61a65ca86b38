/* SPDX-License-Identifier: MIT */
/*
 * The payload inputs: vertex normals and texture coordinates as integers, a record per kept triangle, and what tells
 * whether payload varies. lib/plan/attributes.c has the same steps for the host.
 *
 * Launch: svo_k_plan_normals one work-item per vertex and svo_k_plan_uvs one per number, rounded up to whole groups;
 * svo_k_plan_records one per SVO_PLAN_RUN kept triangles. No atomics: the marks of materials are only ever set.
 */
#include "plan/plan.clh"
#include "shared/fine.clh"

#define SVO_UV_ONE      65536.0
#define SVO_UV_LIMIT    32767.0
#define SVO_NORMAL_ONE  32767.0
#define SVO_STRETCH_ONE 1073741824.0

/* The length of a vector; lib/plan/attributes.c adds in the same order. */
static double svo_length(double3 v)
{
    return sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

static short4 svo_unit_normal(double3 v, double length)
{
    if (!isfinite(length) || !(length > 0.0)) {
        return (short4)(0, 0, 0, 0);
    }
    return (short4)(convert_short3(rint(v / length * SVO_NORMAL_ONE)), 0);
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_normals(__global const float *from, __global short *normals, uint vertex_count)
{
    const uint v = (uint)get_global_id(0);
    if (v < vertex_count) {
        const double3 normal = convert_double3(vload3(v, from));
        vstore4(svo_unit_normal(normal, svo_length(normal)), v, normals);
    }
}

__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_uvs(__global const float *from, __global int *uvs, ulong count)
{
    const size_t i = get_global_id(0);
    if (i < count) {
        const double x = isfinite(from[i]) ? (double)from[i] : 0.0;
        uvs[i] = (int)rint(fmin(fmax(x, -SVO_UV_LIMIT), SVO_UV_LIMIT) * SVO_UV_ONE);
    }
}

/* The mesh in sub-units. */
typedef struct svo_fine_mesh {
    __global const int *vertices;
    __global const ulong *remainders;
    int bits; /* of a grid unit */
} svo_fine_mesh;

static long svo_fine_at(const svo_fine_mesh *mesh, uint vertex, int axis)
{
    return svo_fine_coordinate(mesh->vertices[(size_t)vertex * 3 + (size_t)axis], mesh->remainders[vertex], axis,
                               mesh->bits);
}

/* The shape of a triangle: unit normal, axis of the normal's largest component, area in square grid units, and
   the ratio of the area to that of the projection along the axis. */
typedef struct svo_shape {
    short4 unit;
    uint axis;
    double area, stretch;
} svo_shape;

static svo_shape svo_shape_of(const svo_fine_mesh *mesh, const uint corners[3])
{
    long edges[6];
    for (int axis = 0; axis < 3; ++axis) {
        const long first = svo_fine_at(mesh, corners[0], axis);
        edges[axis] = svo_fine_at(mesh, corners[1], axis) - first;
        edges[3 + axis] = svo_fine_at(mesh, corners[2], axis) - first;
    }
    const svo_fine_normal made = svo_make_fine_normal(edges);
    const long3 normal = (long3)(made.x, made.y, made.z);
    const ulong3 sizes = abs(normal);
    const double3 n = convert_double3(normal);
    const double doubled_area = svo_length(n);
    svo_shape s;
    s.unit = svo_unit_normal(n, doubled_area);
    s.axis = svo_largest_axis(sizes);
    s.area = ldexp(doubled_area, 2 * (made.dropped - mesh->bits) - 1);
    const ulong size = svo_component(sizes, s.axis);
    s.stretch = size != 0ul ? doubled_area / (double)size : 1.0;
    return s;
}

/* The vertex attributes that the request reads; NULL where it does not, or the mesh has none. */
typedef struct svo_attributes {
    __global const uint *colors;
    __global const ulong *normals; /* four numbers of 16 bits each */
} svo_attributes;

/* Whether the attributes of two vertices differ; bit 0: the colors, bit 1: the normals. */
static uint svo_differences(svo_attributes from, uint a, uint b)
{
    return (from.colors != 0 && from.colors[a] != from.colors[b] ? 1u : 0u) |
           (from.normals != 0 && from.normals[a] != from.normals[b] ? 2u : 0u);
}

static uint svo_pack_halves(short low, ushort high)
{
    return (uint)(ushort)low | (uint)high << 16;
}

static svo_triangle_record svo_make_record(const svo_shape *s, uint material, bool flat)
{
    svo_triangle_record record;
    record.material = material;
    record.normal_xy = svo_pack_halves(s->unit.x, (ushort)s->unit.y);
    record.normal_z_flags =
        svo_pack_halves(s->unit.z, (ushort)0) | s->axis << SVO_TRIANGLE_AXIS_SHIFT | (flat ? SVO_TRIANGLE_FLAT : 0u);
    record.stretch = (uint)rint(s->stretch * SVO_STRETCH_ONE);
    return record;
}

/* textured: one byte per material, whether it has a texture. materials: receives 1 for those of kept triangles.
   Columns: the bits of the largest area; whether colors and normals vary; the largest of the triangles' own normals as
   numbers, and of their complements: they tell whether all are equal; the color and the normal of the first triangle's
   first corner, and that triangle's record. */
__kernel __attribute__((reqd_work_group_size(SVO_GROUP_ITEMS, 1, 1))) void
svo_k_plan_records(__global const int *vertices, __global const uint *indices, __global const uint *triangle_ids,
                   __global const ushort *triangle_materials, __global const uint *colors,
                   __global const ulong *normals, __global const uchar *textured, __global uchar *materials,
                   __global svo_triangle_record *records, __global ulong *partials, svo_plan_params params,
                   __local ulong *scratch, __global const ulong *remainders)
{
    const uint2 run = svo_own_run(params.triangle_count);
    const svo_fine_mesh mesh = {vertices, remainders, SVO_SUB_LOG2 - (int)params.voxel_log2};
    const svo_attributes from = {colors, normals};
    const uint first = run.x < run.y ? indices[0] : 0u;
    ulong columns[SVO_PLAN_FINDINGS] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    for (uint t = run.x; t < run.y; ++t) {
        const uint corners[3] = {indices[(size_t)t * 3], indices[(size_t)t * 3 + 1], indices[(size_t)t * 3 + 2]};
        const uint given = triangle_materials != 0 ? triangle_materials[triangle_ids[t]] : 0u;
        const uint material = given < params.material_count ? given : 0u;
        const bool is_textured = (params.flags & SVO_PLAN_TEXTURED) != 0u && textured[material] != 0;
        const svo_shape s = svo_shape_of(&mesh, corners);
        const uint inside =
            svo_differences(from, corners[0], corners[1]) | svo_differences(from, corners[0], corners[2]);
        const uint vary = inside | svo_differences(from, corners[0], first);
        const svo_triangle_record record = svo_make_record(&s, material, !is_textured && inside == 0u);
        const ulong own = (ulong)(record.normal_z_flags & 0xffffu) << 32 | record.normal_xy;
        records[t] = record;
        if (materials[material] == 0) { /* most find it set, and leave its cache line shared */
            materials[material] = 1;
        }
        columns[0] = max(columns[0], as_ulong(s.area));
        columns[1] |= vary & 1u;
        columns[2] |= vary >> 1;
        columns[3] = max(columns[3], own);
        columns[4] = max(columns[4], ~own);
        if (t == 0u) {
            columns[5] = colors != 0 ? colors[first] : 0u;
            columns[6] = normals != 0 ? normals[first] : 0ul;
            columns[7] = (ulong)record.normal_xy << 32 | record.material;
            columns[8] = (ulong)record.stretch << 32 | record.normal_z_flags;
        }
    }
    svo_group_columns(columns, SVO_PLAN_FINDINGS, true, scratch, partials);
}
