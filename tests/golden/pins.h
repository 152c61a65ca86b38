/* SPDX-License-Identifier: MIT */
/*
 * Pinned results: for each room of the library a table ROOM.tsv of lines NAME<TAB>VALUE, a digest or the exact text, of
 * what the room makes of three small scenes. The test golden_pins compares; `golden_pins --write` makes the tables
 * anew.
 *
 * What is stored is integers that are the same on every device. Names that begin with "PoCL" are of what the documents
 * call per device, and are compared on PoCL alone: digests where the arithmetic rounds the same on every processor,
 * means of four digits where it calls exp and its like.
 *
 * Functions here are called inside a running cmocka test and fail it.
 */
#ifndef SVOCL_TESTS_GOLDEN_PINS_H
#define SVOCL_TESTS_GOLDEN_PINS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "support/attributed_mesh.h"
#include "support/fixture.h"

#define PIN_NAME_BYTES  128
#define PIN_VALUE_BYTES 480
#define PIN_LINE_BYTES  (PIN_NAME_BYTES + PIN_VALUE_BYTES + 2)
#define PIN_SCENES      3

typedef struct pin {
    char name[PIN_NAME_BYTES];
    char value[PIN_VALUE_BYTES];
} pin;

/* One of the three scenes, as a mesh. */
typedef struct pinned_scene {
    const char *name;
    const svo_mesh *mesh;
    struct scene *made; /* owns the mesh of a procedural scene; else NULL */
    attributed_mesh random; /* owns that of the other one */
} pinned_scene;

/* The results of one room. */
typedef struct pins {
    fixture opened;
    bool is_pocl; /* values of one device are made and compared */
    const char *room; /* that is made now */
    pinned_scene scenes[PIN_SCENES];
    pin *list;
    size_t count, capacity;
    char prefix[PIN_NAME_BYTES]; /* begins each name, with ": "; may be empty */
} pins;

/* The name that the following ones begin with. */
void pin_begin(pins *all, const char *format, ...) __attribute__((format(printf, 2, 3)));
void pin_text(pins *all, const char *name, const char *format, ...) __attribute__((format(printf, 3, 4)));
void pin_digest(pins *all, const char *name, const void *bytes, size_t byte_count);
void pin_file(pins *all, const char *name, const char *path);
/* The mean of numbers that lie stride_bytes apart, of which those that are not finite are counted instead. */
void pin_mean(pins *all, const char *name, const float *first, size_t count, size_t stride_bytes);
/* The hash and the counts of a tree, which is downloaded. */
void pin_tree(pins *all, const char *name, svo_tree *tree);
/* The bytes of a device buffer. */
void pin_buffer(pins *all, const char *name, cl_mem buffer);

/* Fails with the device's message. */
void pin_succeed(const pins *all, svo_status status);
/* A tree of a scene, downloaded. options: NULL means all defaults. Released by svo_tree_destroy. */
svo_tree *pin_build(const pins *all, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options);
/* Rays from around a tree's grid to points in it, the same everywhere. */
void pin_make_rays(const svo_tree *tree, uint64_t seed, svo_ray *rays, size_t count);
/* Numbers in [0, 1) with 24 bits. */
float pin_random(uint64_t *state);

/* The rooms. */
void pin_plan(pins *all);
void pin_stages(pins *all);
void pin_pipeline(pins *all);
void pin_rays(pins *all);
void pin_compact(pins *all);
void pin_solid(pins *all);
void pin_scene(pins *all);
void pin_light(pins *all);
void pin_probes(pins *all);
void pin_moving(pins *all);
void pin_voxels(pins *all);
void pin_io(pins *all);
void pin_parts(pins *all);
void pin_paged(pins *all);

#endif
