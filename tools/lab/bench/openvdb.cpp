/* SPDX-License-Identifier: MIT */
/* The only file that uses OpenVDB; compiled where libopenvdb-dev is installed. */
#include "bench/openvdb.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>

#include <chrono>
#include <cstring>
#include <exception>

namespace
{

/* The mesh adapter of meshToVolume: vertices in units of voxels, without copies. */
class triangles
{
  public:
    triangles(const float *points, size_t point_count, const uint32_t *indices, size_t triangle_count)
        : points_(points), indices_(indices), point_count_(point_count), triangle_count_(triangle_count)
    {
    }
    size_t polygonCount() const
    {
        return triangle_count_;
    }
    size_t pointCount() const
    {
        return point_count_;
    }
    size_t vertexCount(size_t) const
    {
        return 3;
    }
    void getIndexSpacePoint(size_t polygon, size_t corner, openvdb::Vec3d &point) const
    {
        const float *at = points_ + size_t{indices_[polygon * 3 + corner]} * 3;
        point = openvdb::Vec3d(double{at[0]}, double{at[1]}, double{at[2]});
    }

  private:
    const float *points_;
    const uint32_t *indices_;
    size_t point_count_, triangle_count_;
};

} // namespace

bool openvdb_is_there(void)
{
    return true;
}

const char *openvdb_version(void)
{
    return openvdb::getLibraryVersionString();
}

double openvdb_voxelize(const float *points, size_t point_count, const uint32_t *indices, size_t triangle_count,
                        uint64_t *active_voxels, uint64_t *memory_bytes)
{
    try {
        openvdb::initialize();
        const triangles mesh(points, point_count, indices, triangle_count);
        const auto voxels = openvdb::math::Transform::createLinearTransform(1.0);
        const auto start = std::chrono::steady_clock::now();
        const auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(mesh, *voxels, 1.0f, 1.0f,
                                                                           openvdb::tools::UNSIGNED_DISTANCE_FIELD);
        const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
        *active_voxels = grid->activeVoxelCount();
        *memory_bytes = grid->memUsage();
        return taken.count();
    } catch (const std::exception &) {
        return -1.0;
    }
}

double openvdb_fill(const float *points, size_t point_count, const uint32_t *indices, size_t triangle_count,
                    unsigned depth, uint64_t *inside)
{
    try {
        openvdb::initialize();
        const triangles mesh(points, point_count, indices, triangle_count);
        const auto voxels = openvdb::math::Transform::createLinearTransform(1.0);
        const auto start = std::chrono::steady_clock::now();
        const auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(mesh, *voxels, 3.0f, 3.0f);
        const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
        const auto reader = grid->getConstAccessor();
        const int edge = 1 << depth;
        uint64_t index = 0;
        std::memset(inside, 0, ((size_t{1} << 3 * depth) + 63) / 64 * sizeof *inside);
        for (int z = 0; z < edge; ++z) {
            for (int y = 0; y < edge; ++y) {
                for (int x = 0; x < edge; ++x, ++index) {
                    const bool is_inside = reader.getValue(openvdb::Coord(x, y, z)) < 0.0f;
                    inside[index / 64] |= uint64_t{is_inside} << index % 64;
                }
            }
        }
        return taken.count();
    } catch (const std::exception &) {
        return -1.0;
    }
}
