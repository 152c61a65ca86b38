/* SPDX-License-Identifier: MIT */
/*
 * The device handle's fields, its messages, its buffers and their budget.
 *
 * The files of this room:
 *
 *   system         what the operating system is asked for: the clock, memory, processors, files
 *   message        messages, the two ways to pass a failure on, checked sizes
 *   struct_size    public structs that may grow
 *   limits         what the process may have of memory, and has
 *   memory         host memory, and lists of what handles own
 *   opencl         errors, properties and objects of OpenCL
 *   device         the handle, its buffers and their budget
 *   device_search  svo_device_create_default
 *   program        programs, and launches of their kernels
 *   kernel_files   compiled programs in files
 *   staging        between host memory and buffers
 *   submit         the commands of one call, its arrays, its launches in bands
 *   work           scratch buffers, copies and launches outside builds; chains of commands on any queues
 *   proof          known answers of kernels, before a program is used
 *   mesh           meshes in buffers, read to the host
 *   tree           the tree, its arrays and its hash
 *   compact        the handle of compact trees
 *   nodes          from places to nodes and back
 *   voxel_list     lists of voxels, and their order
 */
#ifndef SVO_LIB_CORE_DEVICE_H
#define SVO_LIB_CORE_DEVICE_H

#include <stdbool.h>
#include <stdint.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/opencl.h"
#include "svocl/device.h"

/*
 * The budget of a device handle: how many bytes the OpenCL buffers may have that live at the same time. That is
 * max_device_bytes, and on devices whose memory is the process's also what its limits leave. A buffer counts until the
 * driver destroys it, whoever holds it last. Handles without a budget count nothing. It is shared by the handle and its
 * buffers, some of which may live longer.
 */
typedef struct svo_i_budget svo_i_budget;

/* Whether so many more bytes fit a budget. */
typedef struct svo_i_budget_answer {
    bool fits;
    svo_status status; /* where they do not: SVO_OUT_OF_HOST_MEMORY where no buffer does, however small */
    uint64_t held_bytes; /* of the buffers that live */
    uint64_t max_bytes; /* max_device_bytes; UINT64_MAX: none */
    svo_i_limit limit; /* of the process, that they do not fit, with what is kept for compilers; else without a name */
} svo_i_budget_answer;

/* Why they do not fit: "beside the 3.0 MiB in use, above max_device_bytes, 4.0 MiB". */
typedef struct svo_i_budget_text {
    char text[256];
} svo_i_budget_text;

/* How long the launches of calls that wait should be, see core/submit.h. */
typedef struct svo_i_bands {
    double target_ms;
    size_t first_groups, least_groups;
} svo_i_bands;

struct svo_device {
    cl_context context;
    cl_device_id device;
    svo_log_callback log;
    void *log_user;
    svo_i_memory memory; /* of the handle and of what is made from it */
    char *name;
    cl_ulong max_allocation_bytes;
    size_t slot_bytes; /* where sub-buffers begin: multiples of it */
    cl_ulong global_bytes;
    bool is_cpu; /* by its type: its memory is the host's */
    bool has_own_memory; /* that is not the process's */
    bool has_compiled; /* a program: what the compiler keeps, it has */
    bool saves_memory; /* max_device_bytes was given: no bytes beside those of plans */
    bool cpu_path; /* kernels and shapes of launches are those for CPUs, see svo_path */
    uint32_t scan_groups; /* the most groups that divide an array among them; on GPUs by its compute units */
    uint32_t sort_groups; /* groups of a sort, likewise */
    uint32_t stream_items; /* work-items that share a batch of rays, for CPUs: some for each compute unit */
    bool has_fp64; /* kernels have cl_khr_fp64 */
    bool rounds_quotients; /* of floats, and roots, correctly: programs are compiled so */
    bool tests_programs; /* before their first use: core/proof.h */
    bool arithmetic_is_tested; /* by one of them, for all */
    size_t staging_bytes; /* of a half (core/staging.h); 0: none */
    size_t staged_bytes_min; /* of what goes through it */
    svo_i_bands bands;
    cl_uint band_tiles; /* tiles of a picture in one launch, so that none takes long enough for a driver to end it */
    svo_i_budget *budget; /* NULL: none */
    svo_i_attachment *attachments; /* compiled programs, and what else is kept until the handle is destroyed */
    double compile_ms;
    uint64_t planned_triangles; /* of the plans until now, see plan/plan.h */
    svo_message message;
};

SVO_I_SHARED_BEGIN

/* Sets the device's message and returns status. device: NULL allowed. */
svo_status svo_i_device_fail(svo_device *device, svo_status status, const char *format, ...) SVO_I_FORMAT(3, 4);
/* svo_i_fail_cl into the device's message. device: NULL allowed. */
svo_status svo_i_device_fail_cl(svo_device *device, const char *function, const char *call, cl_int error);

/* Makes a buffer of at least one byte. SVO_OUT_OF_DEVICE_MEMORY names buffer, bytes and limit. */
svo_status svo_i_device_buffer(svo_device *device, const char *function, const char *name, cl_mem_flags flags,
                               size_t bytes, cl_mem *out);
/* Releases a buffer, which becomes NULL; NULL allowed. */
void svo_i_buffer_release(cl_mem *buffer);

/* One of several buffers that are made together. */
typedef struct svo_i_request {
    const char *name;
    uint64_t bytes;
    cl_mem *out;
} svo_i_request;

#define SVO_I_REQUESTS(array) (array), sizeof(array) / sizeof((array)[0])

/* Bytes of such a buffer: whole slots. */
uint64_t svo_i_device_slots(const svo_device *device, uint64_t bytes);
/* Makes buffers that are released together, each of whole slots: as parts of one allocation, which the driver keeps
   until all are released, or, where it would be larger than the device allows, one by one. */
svo_status svo_i_device_buffers(svo_device *device, const char *function, const svo_i_request *requests, size_t count);

/* The device's message; NULL without a device (a tree from a file has none). */
svo_message *svo_i_device_message(svo_device *device);

/* The queue that is given, or for NULL the device's own in-order queue, made on first use and owned by the device.
   Refuses a queue of another context or device. */
svo_status svo_i_device_queue(svo_device *device, const char *function, cl_command_queue given, cl_command_queue *out);

/* Waits for an event whose command uses memory that is about to be released, also where clWaitForEvents fails without
   having waited. Returns false where the command may still run. */
bool svo_i_event_settle(cl_event event);

void svo_i_device_log(const svo_device *device, svo_log_level level, const char *text);

/* Refuses to compile where the process's limits leave a compiler too little: PoCL's ends the process then. */
svo_status svo_i_device_check_compiler(svo_device *device, const char *function);

/* Refuses a caller's events that are of another context, or NULL. */
svo_status svo_i_device_check_wait(svo_device *device, const char *function, cl_uint num_wait, const cl_event *wait);

SVO_I_SHARED_END

/* A driver may destroy a released buffer a moment after the last command that used it, so this waits up to a tenth of a
   second before it says no. */
svo_i_budget_answer svo_i_device_budget(const svo_device *device, uint64_t bytes);
svo_i_budget_text svo_i_budget_words(const svo_i_budget_answer *answer);

/* svo_i_device_buffer for what kernels only read, with its content. No command is enqueued, so nothing waits. */
svo_status svo_i_device_constants(svo_device *device, const char *function, const char *name, const void *content,
                                  size_t bytes, cl_mem *out);

/* Refuses a caller's memory that is of another context, or no buffer of at least so many bytes; name: of the argument,
   for the message. */
svo_status svo_i_device_check_memory(svo_device *device, const char *function, const char *name, cl_mem memory,
                                     size_t bytes);
/* The same for memory that kernels write: CL_MEM_READ_ONLY is refused too. */
svo_status svo_i_device_check_output(svo_device *device, const char *function, const char *name, cl_mem memory,
                                     size_t bytes);

#endif
