/* SPDX-License-Identifier: MIT */
/*
 * Compiled kernels of a device. Sources are embedded in the library. A program is compiled once per device handle and
 * set of -D options; even a program in the driver's cache takes time to load.
 */
#ifndef SVO_LIB_CORE_PROGRAM_H
#define SVO_LIB_CORE_PROGRAM_H

#include "core/device.h"

typedef enum svo_i_program_kind {
    /* Those of the builder's stages. A program holds what depends on the same defines, so that a plan with other needs
       compiles little anew. */
    SVO_I_PROGRAM_SUBDIVIDE, /* subdivide */
    SVO_I_PROGRAM_SORT, /* scan, sort, bottom_up */
    SVO_I_PROGRAM_PACK, /* scan, pack */
    SVO_I_PROGRAM_FILTER, /* link, material, filter */
    SVO_I_PROGRAM_STAGE_KINDS,

    SVO_I_PROGRAM_VOXELIZE = SVO_I_PROGRAM_STAGE_KINDS, /* voxelize */
    SVO_I_PROGRAM_PLAN, /* those of kernels/plan */
    SVO_I_PROGRAM_CAST, /* render */
    SVO_I_PROGRAM_BVH, /* scan, and those of kernels/bvh */
    SVO_I_PROGRAM_TRACE, /* trace, nearest */
    SVO_I_PROGRAM_VIEW, /* view */
    SVO_I_PROGRAM_TRACE_VOXELS, /* trace_voxels */
    SVO_I_PROGRAM_MINIMIZE, /* scan, minimize, gather */
    SVO_I_PROGRAM_COMPACT, /* scan, and those of kernels/compact that make compact trees */
    SVO_I_PROGRAM_EXPAND, /* scan, expand */
    SVO_I_PROGRAM_SCENE_BUILD, /* scan, sort; codes, link, refit of scenes */
    SVO_I_PROGRAM_SCENE_BOUNDS, /* bounds of the trees of scenes */
    SVO_I_PROGRAM_SCENE_TRACE, /* trace of scenes */
    SVO_I_PROGRAM_SCENE_CAST, /* render of scenes */
    SVO_I_PROGRAM_SOLID, /* those of kernels/solid */
    SVO_I_PROGRAM_GATHER, /* gather of light */
    SVO_I_PROGRAM_KEPT_PHOTONS, /* kept_photons of light */
    SVO_I_PROGRAM_PHOTONS, /* scan; light_view, photons, exchange of kernels/light */
    SVO_I_PROGRAM_LIGHT_PICTURE, /* picture of light */
    SVO_I_PROGRAM_LIGHT_SHADE, /* shade of light */
    SVO_I_PROGRAM_PROBES, /* texels, least, field of probes */
    SVO_I_PROGRAM_PROBE_FILTER, /* filter of probes */
    SVO_I_PROGRAM_PROBE_TRACE, /* trace of probes */
    SVO_I_PROGRAM_PROBE_GATHER, /* gather of probes */
    SVO_I_PROGRAM_LIGHT, /* scan, and those of kernels/light that make and filter light */
    SVO_I_PROGRAM_MOVING, /* scan, and those of kernels/moving */
    SVO_I_PROGRAM_KINDS
} svo_i_program_kind;

/*
 * The program with these defines, compiled on first use and owned by the device.
 *
 * function: for the message. defines: " -DSVO_COLOR -DSVO_NORMAL", a space before each; the same text for the same
 * program. fresh: receives whether this call compiled it; NULL allowed.
 * Returns SVO_COMPILE_FAILED with device, options and the first error in the message; the log callback receives the
 * whole build log.
 */
svo_status svo_i_program_get(svo_device *device, const char *function, svo_i_program_kind kind, const char *defines,
                             cl_program *out, bool *fresh);

/* Names a kind: "subdivide", "filter", ...; static string. */
const char *svo_i_program_kind_name(svo_i_program_kind kind);

/* What a program is compiled from. */
const char *svo_i_program_source(svo_i_program_kind kind);

/* The options that a program is compiled with. */
#define SVO_I_PROGRAM_DEFINES_BYTES 512
#define SVO_I_PROGRAM_OPTIONS_BYTES (SVO_I_PROGRAM_DEFINES_BYTES + 32)
void svo_i_program_options(const char *defines, char options[SVO_I_PROGRAM_OPTIONS_BYTES]);

/* A program that a device has. */
typedef struct svo_i_program_entry {
    svo_i_program_kind kind;
    const char *defines;
    cl_program program; /* owned by the device */
} svo_i_program_entry;

/* The device's programs by their index; false beyond the last. */
bool svo_i_program_at(const svo_device *device, size_t index, svo_i_program_entry *entry);
/* Whether the device has the program. */
bool svo_i_program_known(const svo_device *device, svo_i_program_kind kind, const char *defines);
/* Gives a device a program that was loaded, which it owns from then on. svo_i_program_get says once that it is fresh,
   since its kernels were not launched yet. */
svo_status svo_i_program_add(svo_device *device, const char *function, const svo_i_program_entry *loaded);

/* A new kernel, which the caller releases. */
svo_status svo_i_kernel_create(svo_device *device, const char *function, cl_program program, const char *name,
                               cl_kernel *out);

/* A kernel argument as clSetKernelArg takes it; a buffer is the address of its cl_mem, which may be NULL. */
typedef struct svo_i_argument {
    size_t bytes;
    const void *value; /* NULL: local memory */
    bool is_buffer;
} svo_i_argument;
#define SVO_I_ARGUMENT(variable) \
    ((svo_i_argument){sizeof(variable), &(variable), _Generic((variable), cl_mem : true, default : false)})
/* Local memory for a work-group. */
#define SVO_I_LOCAL(local_bytes) ((svo_i_argument){(local_bytes), NULL, false})

/* An array of arguments and their number, for the two parameters of that kind. */
#define SVO_I_ARGUMENTS(array) (array), ((cl_uint)(sizeof(array) / sizeof((array)[0])))

/* Sets all arguments, in order. */
svo_status svo_i_kernel_set(svo_device *device, const char *function, cl_kernel kernel, const svo_i_argument *arguments,
                            cl_uint argument_count);
SVO_I_SHARED_BEGIN
/* Sets arguments from first_index on. */
svo_status svo_i_kernel_set_from(svo_device *device, const char *function, cl_kernel kernel, cl_uint first_index,
                                 const svo_i_argument *arguments, cl_uint argument_count);
SVO_I_SHARED_END

#endif
