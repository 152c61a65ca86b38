/* SPDX-License-Identifier: MIT */
/* Binary STL in blocks. Whether any facet has a color of its own shows in the first pass. */
#include <inttypes.h>
#include <string.h>

#include "core/memory.h"
#include "io/blocks_file.h"
#include "io/import_stl.h"

svo_status svo_i_blocks_open_stl(svo_i_blocks *blocks)
{
    if (blocks->window_count < STL_BEGIN_BYTES ||
        svo_i_stl_is_text(blocks->window, blocks->window_count, blocks->file_bytes)) {
        return svo_i_blocks_fail(blocks, SVO_UNSUPPORTED, "an STL file in text");
    }
    blocks->facet_count = svo_i_stl_facet_count(blocks->window);
    const uint64_t needed_bytes = STL_BEGIN_BYTES + blocks->facet_count * STL_FACET_BYTES;
    if (needed_bytes > blocks->file_bytes) {
        return svo_i_fail(blocks->message, SVO_IMPORT_FAILED,
                          "%s: byte 80: %" PRIu64 " facets need %" PRIu64 " bytes, and the file has %" PRIu64,
                          blocks->path, blocks->facet_count, needed_bytes, blocks->file_bytes);
    }
    blocks->is_magics = svo_i_stl_header_color(blocks->window, blocks->no_color);
    blocks->has_normals = true;
    return SVO_OK;
}

svo_status svo_i_blocks_fill_stl(svo_i_blocks *blocks)
{
    for (; blocks->filled < BLOCK_TRIANGLES && blocks->facets_read < blocks->facet_count; ++blocks->facets_read) {
        float facet[12];
        gather_vertex vertex = {.uv = {0.0f, 0.0f}};
        SVO_I_TRY(svo_i_blocks_need(blocks, STL_FACET_BYTES));
        blocks->any_color = svo_i_stl_read_facet(blocks->window + blocks->window_at, blocks->is_magics,
                                                 blocks->no_color, facet, vertex.color) ||
                            blocks->any_color;
        blocks->window_at += STL_FACET_BYTES;
        memcpy(vertex.normal, facet, sizeof vertex.normal);
        for (unsigned corner = 0; corner < 3; ++corner) {
            memcpy(vertex.position, facet + 3 + (size_t)corner * 3, sizeof vertex.position);
            svo_i_blocks_put(blocks, corner, &vertex);
        }
        ++blocks->filled;
    }
    return SVO_OK;
}
