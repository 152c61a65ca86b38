/* SPDX-License-Identifier: MIT */
#include "nvdb_peer.h"

#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/GridValidator.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/Primitives.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace
{

using handles = std::vector<nanovdb::GridHandle<>>;

std::string problem; // of the last file read

void copy_out(const std::vector<nvdb_voxel> &from, nvdb_voxel **voxels, size_t *count)
{
    *count = from.size();
    *voxels = static_cast<nvdb_voxel *>(std::malloc(from.size() * sizeof(nvdb_voxel) + 1));
    std::memcpy(*voxels, from.data(), from.size() * sizeof(nvdb_voxel));
}

nvdb_voxel voxel_at(const nanovdb::Coord &at)
{
    return {{at[0], at[1], at[2]}, {255, 255, 255, 255}, 0, {0.0, 0.0, 0.0}};
}

/* The grid of a name and a type, which is valid; NULL: there is none. */
template <typename Value> const nanovdb::NanoGrid<Value> *find(const handles &of, const char *name)
{
    for (const auto &handle : of) {
        const auto *grid = handle.template grid<Value>();
        if (grid != nullptr && std::strcmp(grid->gridName(), name) == 0) {
            const std::string found = nanovdb::GridValidator<Value>::check(*grid, true);
            problem = found.empty() ? problem : found;
            return grid;
        }
    }
    return nullptr;
}

/* All voxels of a box for which a test on value and state holds. */
template <typename Grid, typename Test> std::vector<nvdb_voxel> search(const Grid &grid, int radius, const Test &test)
{
    std::vector<nvdb_voxel> found;
    auto values = grid.getAccessor();
    for (int x = -radius; x <= radius; ++x) {
        for (int y = -radius; y <= radius; ++y) {
            for (int z = -radius; z <= radius; ++z) {
                const nanovdb::Coord at(x, y, z);
                if (test(values.getValue(at), values.isActive(at))) {
                    found.push_back(voxel_at(at));
                }
            }
        }
    }
    return found;
}

template <typename Real, typename Value> std::vector<nvdb_voxel> write_sphere(const char *path)
{
    constexpr int radius = 21; // so that some leaves lie inside, which become tiles
    auto made = nanovdb::createLevelSetSphere<Real, Value>(Real(radius), nanovdb::Vec3<Real>(Real(0.3)));
    nanovdb::io::writeGrid(path, made);
    return search(*made.template grid<Value>(), radius + 4, [](Real value, bool) { return value < 0; });
}

std::vector<nvdb_voxel> write_fog(const char *path)
{
    auto made = nanovdb::createFogVolumeSphere<float>(21.0f, nanovdb::Vec3<float>(-0.3f));
    nanovdb::io::writeGrid(path, made);
    return search(*made.grid<float>(), 25, [](float, bool active) { return active; });
}

std::vector<nvdb_voxel> write_colors(const char *path)
{
    nanovdb::GridBuilder<float> density(0.0f, nanovdb::GridClass::FogVolume);
    nanovdb::GridBuilder<nanovdb::Vec3f> color(nanovdb::Vec3f(0.0f));
    nanovdb::GridBuilder<float> heat(0.0f);
    std::vector<nvdb_voxel> expected;
    auto densities = density.getAccessor();
    auto colors = color.getAccessor();
    heat.getAccessor().setValue(nanovdb::Coord(1, 2, 3), 4.0f);
    // sRGB 0, 188, 255 and 12 are 0, .503, 1 and .0037 in linear light (IEC 61966-2-1).
    const float linear[4] = {0.0f, 0.50288652f, 1.0f, 0.0036765073f};
    const uint8_t coded[4] = {0, 188, 255, 12};
    for (int i = 0; i < 64; ++i) {
        const nanovdb::Coord at(5000 * (i % 3) - 4097, i - 32, 200 * i);
        nvdb_voxel voxel = voxel_at(at);
        nanovdb::Vec3f value(0.0f);
        for (int c = 0; c < 3; ++c) {
            const int which = i >> 2 * c & 3;
            value[c] = linear[which];
            voxel.rgba[c] = coded[which];
        }
        densities.setValue(at, 0.5f);
        colors.setValue(at, value);
        expected.push_back(voxel);
    }
    handles all;
    all.push_back(density.getHandle<>(0.25, nanovdb::Vec3d(1.0, 2.0, 3.0), "density"));
    all.push_back(color.getHandle<>(0.25, nanovdb::Vec3d(1.0, 2.0, 3.0), "Cd"));
    all.push_back(heat.getHandle<>(0.25, nanovdb::Vec3d(1.0, 2.0, 3.0), "heat"));
    nanovdb::io::writeGrids(path, all);
    return expected;
}

} // namespace

const char *nvdb_peer_read(const char *path, nvdb_voxel **voxels, size_t *count)
{
    std::vector<nvdb_voxel> found;
    problem.clear();
    try {
        const handles all = nanovdb::io::readGrids(path);
        const auto *density = find<nanovdb::Fp4>(all, "density");
        const auto *color = find<nanovdb::Rgba8>(all, "color");
        const auto *material = find<uint32_t>(all, "material");
        for (uint32_t i = 0; density != nullptr && i < density->tree().nodeCount(0); ++i) {
            const auto &leaf = density->tree().getFirstNode<0>()[i];
            for (auto at = leaf.beginValueOn(); at; ++at) {
                nvdb_voxel voxel = voxel_at(at.getCoord());
                const nanovdb::Vec3d center = density->indexToWorld(nanovdb::Vec3d(at.getCoord()));
                if (color != nullptr) {
                    const nanovdb::Rgba8 rgba = color->getAccessor().getValue(at.getCoord());
                    const uint8_t bytes[4] = {rgba.r(), rgba.g(), rgba.b(), rgba.a()};
                    std::memcpy(voxel.rgba, bytes, sizeof bytes);
                }
                voxel.material = material != nullptr ? material->getAccessor().getValue(at.getCoord()) : 0;
                for (int axis = 0; axis < 3; ++axis) {
                    voxel.center[axis] = center[axis];
                }
                problem = density->getAccessor().getValue(at.getCoord()) == 1.0f ? problem : "a density is not 1";
                found.push_back(voxel);
            }
        }
        if (density == nullptr || density->activeVoxelCount() != found.size()) {
            problem = "no density, or another number of voxels";
        }
    } catch (const std::exception &failure) {
        problem = failure.what();
    }
    copy_out(found, voxels, count);
    return problem.empty() ? nullptr : problem.c_str();
}

const char *nvdb_peer_read_surface(const char *path, int side, nvdb_distance *values, double center[3])
{
    problem.clear();
    try {
        const handles all = nanovdb::io::readGrids(path);
        const auto *grid = find<float>(all, "surface");
        if (grid == nullptr || !grid->isLevelSet() || all.size() != 1) {
            return "no level set \"surface\", or other grids";
        }
        auto accessor = grid->getAccessor();
        for (int i = 0; i < side * side * side; ++i) {
            const nanovdb::Coord at(i % side, i / side % side, i / side / side);
            values[i] = {accessor.getValue(at), accessor.isActive(at)};
        }
        const nanovdb::Vec3d first = grid->indexToWorld(nanovdb::Vec3d(0.0));
        for (int axis = 0; axis < 3; ++axis) {
            center[axis] = first[axis];
        }
    } catch (const std::exception &failure) {
        problem = failure.what();
    }
    return problem.empty() ? nullptr : problem.c_str();
}

void nvdb_peer_write(const char *path, nvdb_kind kind, nvdb_voxel **voxels, size_t *count)
{
    copy_out(kind == NVDB_SPHERE_FLOAT    ? write_sphere<float, float>(path)
             : kind == NVDB_SPHERE_DOUBLE ? write_sphere<double, double>(path)
             : kind == NVDB_SPHERE_FP8    ? write_sphere<float, nanovdb::Fp8>(path)
             : kind == NVDB_SPHERE_FP16   ? write_sphere<float, nanovdb::Fp16>(path)
             : kind == NVDB_FOG           ? write_fog(path)
                                          : write_colors(path),
             voxels, count);
}
