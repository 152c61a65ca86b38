/* SPDX-License-Identifier: MIT */
/* A light as files hold it (lib/light_file): a record, what lights it, and its arrays. */
#ifndef SVO_LIB_LIGHT_RECORD_H
#define SVO_LIB_LIGHT_RECORD_H

#include "core/memory.h"
#include "light/handle.h"

/* What a file says of a light. io.h has it byte by byte. */
typedef struct svo_i_light_record {
    char tree_hash[32]; /* svo_tree_hash of all, without the zero */
    uint32_t form, opacity, one_side;
    uint32_t has_setup; /* 0 or 1 */
    float unit, sky[3];
    uint32_t view_resolution, diagnose, no_photons, updatable;
    uint64_t source_count, finish_count;
    uint64_t photons, photon_hits, lit_leaves, lit_nodes, missed_leaves;
    double flux[3], lost_flux;
} svo_i_light_record;

/* What later versions say of its photons. All 0: nothing. */
typedef struct svo_i_photon_record {
    uint32_t emission_photons, bounces, photon_alpha, reserved;
} svo_i_photon_record;

/* The same in memory. Arrays are borrowed. */
typedef struct svo_i_stored_light {
    svo_i_light_record record;
    svo_i_photon_record photons;
    const svo_light_source *sources; /* record.source_count */
    const svo_finish *finishes; /* record.finish_count */
    const float *sky_map; /* sky_width x sky_height texels of three values; NULL: none */
    uint32_t sky_width, sky_height;
    const void *arrays[SVO_LIGHT_BUFFER_COUNT]; /* of svo_i_light_count_arrays bytes; NULL where that is 0 */
} svo_i_stored_light;

SVO_I_SHARED_BEGIN

/* Describes a light, without the tree's hash, the map of the sky and arrays. Lists stay those of the light. */
void svo_i_light_describe(const svo_light *light, svo_i_stored_light *stored);
/* Reads a buffer of the light, all info.bytes of it, and waits. */
svo_status svo_i_light_read_array(const svo_light *light, const char *function, cl_command_queue queue,
                                  svo_light_buffer buffer, void *array);
/* Reads the map of the sky, without its means: svo_i_light_sky_bytes, 0 where there is none. */
uint64_t svo_i_light_sky_bytes(const svo_light *light);
svo_status svo_i_light_read_sky(const svo_light *light, const char *function, cl_command_queue queue, float *map);

/* The bytes of each array that a record's light has. Returns false where its values are out of their range or do not
   fit the tree. */
bool svo_i_light_count_arrays(const svo_tree *tree, const svo_i_light_record *record,
                              uint64_t bytes[SVO_LIGHT_BUFFER_COUNT]);
/* Makes a light of a tree on a device. The record was counted; lists and arrays need not make sense, and are refused
   with SVO_FILE_DAMAGED. */
svo_status svo_i_light_restore(svo_tree *tree, const char *function, const svo_i_stored_light *stored,
                               cl_command_queue queue, svo_light **out);

SVO_I_SHARED_END

#endif
