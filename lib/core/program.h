/* SPDX-License-Identifier: MIT */
/*
 * Compiled kernels of a device. The rooms own the programs: each exports those of its kernels. A program is compiled
 * once per device handle and set of -D options; even a program in the driver's cache takes time to load.
 */
#ifndef SVO_LIB_CORE_PROGRAM_H
#define SVO_LIB_CORE_PROGRAM_H

#include "core/device.h"
#include "core/kernel_text.h"

#define SVO_I_PROGRAM_FILES_MAX 11

/* Most bytes of a program's defines, of its name, and of a hash as text. */
#define SVO_I_PROGRAM_DEFINES_BYTES 512
#define SVO_I_PROGRAM_NAME_BYTES    64
#define SVO_I_HASH_BYTES            33

/* A program that a device has, or that was saved: it is known by its name and the hash of its source. */
typedef struct svo_i_program_entry {
    char name[SVO_I_PROGRAM_NAME_BYTES];
    char source[SVO_I_HASH_BYTES];
    char defines[SVO_I_PROGRAM_DEFINES_BYTES];
    cl_program program; /* owned by the device */
} svo_i_program_entry;

/*
 * Runs kernels of a program on inputs whose results the host knows (core/proof.h).
 *
 * function: for the message. wrong: receives the name of a kernel that gave another result, a static string; it has no
 * message then.
 * Returns SVO_DEVICE_UNRELIABLE with such a kernel.
 */
typedef svo_status svo_i_prover(svo_device *device, const char *function, const svo_i_program_entry *made,
                                const char **wrong);

/* A program: kernels that are compiled together. Its room defines svo_i_program_NAME in programs.c. */
typedef struct svo_i_program {
    const char *name; /* in plans, and in the keys of saved kernels */
    const svo_i_kernel_text *files[SVO_I_PROGRAM_FILES_MAX + 1]; /* those with its kernels; the rest is NULL */
    svo_i_prover *prove; /* NULL: nothing stored rests on it */
} svo_i_program;

/*
 * The program with these defines, compiled and tested on first use and owned by the device.
 *
 * function: for the message. defines: " -DSVO_COLOR -DSVO_NORMAL", a space before each; the same text for the same
 * program. fresh: receives whether this call compiled it; NULL allowed.
 * Returns SVO_COMPILE_FAILED with device, options and the first error in the message; the log callback receives the
 * whole build log. SVO_DEVICE_UNRELIABLE, with kernel, device and driver, at every call for a program that failed its
 * test.
 */
svo_status svo_i_program_get(svo_device *device, const char *function, const svo_i_program *program,
                             const char *defines, cl_program *out, bool *fresh);
/* Whether the device has the program, and whether it has failed its test. */
bool svo_i_program_known(const svo_device *device, const svo_i_program *program, const char *defines);
bool svo_i_program_wrong(const svo_device *device, const svo_i_program *program, const char *defines);

/* The options that a program is compiled with on a device. */
#define SVO_I_PROGRAM_OPTIONS_BYTES (SVO_I_PROGRAM_DEFINES_BYTES + 64)
void svo_i_program_options(const svo_device *device, const char *defines, char options[SVO_I_PROGRAM_OPTIONS_BYTES]);

/* The device's programs by their index; NULL beyond the last. */
const svo_i_program_entry *svo_i_program_at(const svo_device *device, size_t index);
/* Gives a device a program that was loaded, which it owns from then on. svo_i_program_get finds it if the source is
   that of this library, and says once that it is fresh, since its kernels were not launched yet. */
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
