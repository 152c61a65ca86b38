/* SPDX-License-Identifier: MIT */
/* The payload of a compact tree, in its form's order: kernels/compact/payload.cl. */
#ifndef SVO_LIB_COMPACT_PAYLOAD_H
#define SVO_LIB_COMPACT_PAYLOAD_H

#include "compact/source.h"

/* Makes bases beside the words of the nodes buffer. places: u32 per inner node of the source, the index of its word.
   *targets: u32 per inner node, where its children's payload goes; scratch. Does nothing where there are no places.
   compact->info: complete. */
svo_status svo_i_payload_bases(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem places,
                               svo_compact *compact, cl_mem *targets);
/* Makes all payload arrays. */
svo_status svo_i_payload_make(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem targets,
                              svo_compact *compact);

/* The same for any order. origins: u32 per payload of the compact tree, its index among those of the source; NULL where
   there are no places. */
svo_status svo_i_payload_gather(svo_i_device_work *work, const svo_i_compact_source *source, cl_mem origins,
                                svo_compact *compact);

#endif
