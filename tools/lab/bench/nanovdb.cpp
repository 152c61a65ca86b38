/* SPDX-License-Identifier: MIT */
/* The only file that uses NanoVDB; compiled where its headers are installed. */
#include "bench/nanovdb.h"

#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/HDDA.h>
#include <nanovdb/util/Ray.h>

#include <exception>
#include <limits>
#include <memory>

#define TEXT_OF(number) #number
#define TEXT(number)    TEXT_OF(number)

struct nanovdb_voxels {
    nanovdb::GridHandle<> handle;
};

bool nanovdb_is_there(void)
{
    return true;
}

const char *nanovdb_version(void)
{
    return TEXT(NANOVDB_MAJOR_VERSION_NUMBER) "." TEXT(NANOVDB_MINOR_VERSION_NUMBER) "." TEXT(
        NANOVDB_PATCH_VERSION_NUMBER);
}

nanovdb_voxels *nanovdb_create(const uint32_t (*cells)[3], size_t cell_count)
{
    try {
        nanovdb::GridBuilder<float, nanovdb::Fp4> builder(0.0f); /* the smallest leaves that it makes */
        auto at = builder.getAccessor();
        for (size_t i = 0; i < cell_count; ++i) {
            const uint32_t *cell = cells[i];
            at.setValue(nanovdb::Coord(int(cell[0]), int(cell[1]), int(cell[2])), 1.0f);
        }
        auto made = std::make_unique<nanovdb_voxels>();
        made->handle = builder.getHandle<>();
        return made->handle.grid<nanovdb::Fp4>() != nullptr ? made.release() : nullptr;
    } catch (const std::exception &) {
        return nullptr;
    }
}

void nanovdb_destroy(nanovdb_voxels **voxels)
{
    delete *voxels;
    *voxels = nullptr;
}

uint64_t nanovdb_bytes(const nanovdb_voxels *voxels)
{
    return voxels->handle.size();
}

BRICKMAP_ALL_ISAS
void nanovdb_trace(const nanovdb_voxels *voxels, const voxel_ray *rays, float *distances, size_t ray_count)
{
    auto at = voxels->handle.grid<nanovdb::Fp4>()->getAccessor();
    for (size_t i = 0; i < ray_count; ++i) {
        const voxel_ray &from = rays[i];
        nanovdb::Ray<float> ray(nanovdb::Vec3f(from.origin[0], from.origin[1], from.origin[2]),
                                nanovdb::Vec3f(from.direction[0], from.direction[1], from.direction[2]), 0.0f,
                                from.range);
        nanovdb::Coord cell;
        float t = 0.0f;
        distances[i] = nanovdb::firstActive(ray, at, cell, t) ? t : std::numeric_limits<float>::infinity();
    }
}
