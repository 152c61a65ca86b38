/* SPDX-License-Identifier: MIT */
/* svo_device_create_default: finds a device by name or index on all platforms, and makes a context for it. */
#define _POSIX_C_SOURCE 200809L
#include <CL/cl_ext.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/device.h"
#include "core/opencl.h"
#include "core/struct_size.h"

#define CREATE_DEFAULT "svo_device_create_default"
/* Address space that a driver with its compiler needs to be loaded. PoCL 3.1 with LLVM 14 and two threads takes 380
   MiB. */
#define DRIVER_BYTES (UINT64_C(448) << 20)
/* Beside that, a driver for CPUs starts threads, each with a stack; PoCL ends the process where one does not start. */
#define OPENING_BYTES (UINT64_C(128) << 20)
#define STACK_BYTES   (UINT64_C(8) << 20)

/* Whether part occurs in text, ignoring the case of letters. */
static bool contains(const char *text, const char *part)
{
    const size_t length = strlen(part);
    for (; *text != '\0'; ++text) {
        if (strncasecmp(text, part, length) == 0) {
            return true;
        }
    }
    return length == 0;
}

/* What decides between devices that match a request. */
typedef struct device_facts {
    cl_bool available;
    cl_bool shares_memory; /* with the host, as CPUs and integrated GPUs do */
    cl_device_type type;
    cl_uint compute_units;
} device_facts;

static bool is_gpu(const device_facts *facts)
{
    return (facts->type & CL_DEVICE_TYPE_GPU) != 0;
}

/* Devices that work come first, then GPUs, then those with memory of their own, then those of more compute units. Of
   equals the first stays. */
static bool is_better(const device_facts *facts, const device_facts *best)
{
    if (facts->available != best->available) {
        return facts->available != CL_FALSE;
    }
    if (is_gpu(facts) != is_gpu(best)) {
        return is_gpu(facts);
    }
    if (facts->shares_memory != best->shares_memory) {
        return facts->shares_memory == CL_FALSE;
    }
    return facts->compute_units > best->compute_units;
}

/* A search of svo_device_create_default: the request, and the best device so far. */
typedef struct device_search {
    const svo_i_memory *memory;
    const char *wanted; /* part of the name; NULL: any device */
    bool by_index;
    unsigned platform_index, device_index;
    cl_device_id found;
    device_facts best; /* of the device found */
    char bare[SVO_MESSAGE_BYTES]; /* names and errors of platforms without a device, for the message */
} device_search;

/* Adds a platform without a device to the text for the message. */
static void note_bare_platform(device_search *search, cl_platform_id platform, cl_int error)
{
    char *name = NULL;
    (void)svo_i_platform_text(platform, CL_PLATFORM_NAME, CREATE_DEFAULT, search->memory, &name, NULL);
    const size_t length = strlen(search->bare);
    (void)snprintf(search->bare + length, sizeof search->bare - length, "%s\"%s\"%s%s%s", length > 0 ? ", " : "",
                   name != NULL ? name : "", error != CL_SUCCESS ? " (" : "",
                   error != CL_SUCCESS ? svo_i_cl_error_name(error) : "", error != CL_SUCCESS ? ")" : "");
    svo_i_free(name);
}

static svo_status read_facts(cl_device_id device, device_facts *out, svo_message *message)
{
    *out = (device_facts){0};
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_TYPE, sizeof out->type, &out->type, CREATE_DEFAULT, message));
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_AVAILABLE, sizeof out->available, &out->available, CREATE_DEFAULT,
                                    message));
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof out->compute_units, &out->compute_units,
                                    CREATE_DEFAULT, message));
    /* OpenCL 2.0 has deprecated it; where a driver does not answer, it decides nothing. */
    (void)clGetDeviceInfo(device, CL_DEVICE_HOST_UNIFIED_MEMORY, sizeof out->shares_memory, &out->shares_memory, NULL);
    return SVO_OK;
}

/* Compares a device with the best one so far. */
static svo_status search_device(device_search *search, cl_device_id device, svo_message *message)
{
    char *name = NULL;
    device_facts facts;
    SVO_I_TRY(read_facts(device, &facts, message));
    SVO_I_TRY(svo_i_device_full_name(device, CREATE_DEFAULT, search->memory, &name, message));
    const bool matches = search->wanted == NULL || contains(name, search->wanted);
    svo_i_free(name);
    if (matches && (search->found == NULL || is_better(&facts, &search->best))) {
        search->found = device;
        search->best = facts;
    }
    return SVO_OK;
}

/* For searches that go on after a failure. */
static void keep_first(svo_status status, svo_status *first)
{
    if (*first == SVO_OK) {
        *first = status;
    }
}

/* Fails on the platform's first device that cannot be examined; those after it are examined nevertheless. */
static svo_status search_devices(device_search *search, const cl_device_id *devices, cl_uint count,
                                 unsigned platform_index, svo_message *message)
{
    svo_status status = SVO_OK;
    for (unsigned i = 0; i < count; ++i) {
        if (!search->by_index) {
            keep_first(search_device(search, devices[i], status == SVO_OK ? message : NULL), &status);
        } else if (platform_index == search->platform_index && i == search->device_index) {
            search->found = devices[i];
        }
    }
    return status;
}

static svo_status search_platform(device_search *search, cl_platform_id platform, unsigned platform_index,
                                  svo_message *message)
{
    cl_uint count = 0;
    cl_int error = clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, NULL, &count);
    if (error == CL_DEVICE_NOT_FOUND || (error == CL_SUCCESS && count == 0)) {
        note_bare_platform(search, platform, error);
        return SVO_OK;
    }
    cl_device_id *devices =
        error == CL_SUCCESS ? svo_i_alloc_zeroed(search->memory, count, sizeof(cl_device_id)) : NULL;
    if (error == CL_SUCCESS && devices == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, CREATE_DEFAULT ": no memory for %u devices", count);
    }
    error = error == CL_SUCCESS ? clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, devices, NULL) : error;
    const svo_status status = error == CL_SUCCESS ? search_devices(search, devices, count, platform_index, message)
                                                  : svo_i_fail_cl(message, CREATE_DEFAULT, "clGetDeviceIDs", error);
    svo_i_free(devices);
    return status;
}

/* The loader does not say whether there is no driver, or no memory to load it. */
static svo_status fail_without_platforms(svo_message *message)
{
    const svo_i_limit limit = svo_i_limit_read(SVO_I_LIMIT_SPACE);
    return svo_i_limit_left(&limit) >= DRIVER_BYTES
               ? svo_i_fail(message, SVO_NO_DEVICE, CREATE_DEFAULT ": no OpenCL platform is installed")
               : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY,
                            CREATE_DEFAULT ": out of memory: no OpenCL platform could be loaded; %s is %s, which "
                                           "leaves %s, and drivers need about %s",
                            limit.name, svo_i_bytes(limit.bytes).text, svo_i_bytes(svo_i_limit_left(&limit)).text,
                            svo_i_bytes(DRIVER_BYTES).text);
}

/* Refuses to open devices where address space is too short for the threads of CPUs. */
static svo_status check_opening(svo_message *message)
{
    const uint64_t needed_bytes = OPENING_BYTES + svo_i_system_processors() * STACK_BYTES;
    const svo_i_limit limit = svo_i_limit_read(SVO_I_LIMIT_SPACE);
    return svo_i_limit_left(&limit) >= needed_bytes
               ? SVO_OK
               : svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY,
                            CREATE_DEFAULT ": out of memory: opening devices needs about %s, and %s is %s, which "
                                           "leaves %s",
                            svo_i_bytes(needed_bytes).text, limit.name, svo_i_bytes(limit.bytes).text,
                            svo_i_bytes(svo_i_limit_left(&limit)).text);
}

/* All platforms; the caller frees the list. CL_PLATFORM_NOT_FOUND_KHR: the loader found none. */
static svo_status list_platforms(const svo_i_memory *memory, cl_platform_id **out, cl_uint *count, svo_message *message)
{
    cl_int error = clGetPlatformIDs(0, NULL, count);
    if (error == CL_PLATFORM_NOT_FOUND_KHR || (error == CL_SUCCESS && *count == 0)) {
        return fail_without_platforms(message);
    }
    cl_platform_id *platforms = error == CL_SUCCESS ? svo_i_alloc_zeroed(memory, *count, sizeof(cl_platform_id)) : NULL;
    if (error == CL_SUCCESS && platforms == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, CREATE_DEFAULT ": no memory for %u platforms", *count);
    }
    error = error == CL_SUCCESS ? clGetPlatformIDs(*count, platforms, NULL) : error;
    if (error != CL_SUCCESS) {
        svo_i_free(platforms);
        return svo_i_fail_cl(message, CREATE_DEFAULT, "clGetPlatformIDs", error);
    }
    *out = platforms;
    return SVO_OK;
}

/* Says what was searched for, and which platforms had nothing to search. */
static svo_status fail_search(const device_search *search, svo_message *message)
{
    char asked[256] = "";
    if (search->wanted != NULL) {
        (void)snprintf(asked, sizeof asked, " matches \"%.200s\"", search->wanted);
    }
    return search->bare[0] == '\0'
               ? svo_i_fail(message, SVO_NO_DEVICE, CREATE_DEFAULT ": no OpenCL device%s", asked)
               : svo_i_fail(message, SVO_NO_DEVICE,
                            CREATE_DEFAULT ": no OpenCL device%s; without any device: platform %s, perhaps "
                                           "because its cache folder cannot be written (PoCL: POCL_CACHE_DIR, else "
                                           "XDG_CACHE_HOME/pocl or HOME/.cache/pocl)",
                            asked, search->bare);
}

static svo_status find_device(const char *wanted, const svo_i_memory *memory, cl_device_id *out, svo_message *message)
{
    cl_uint count = 0;
    cl_platform_id *platforms = NULL;
    const svo_status listed = list_platforms(memory, &platforms, &count, message);
    if (platforms == NULL) {
        return listed;
    }
    const svo_status checked = check_opening(message);
    if (checked != SVO_OK) {
        svo_i_free(platforms);
        return checked;
    }
    device_search search = {.memory = memory, .wanted = wanted};
    char rest = '\0';
    search.by_index =
        wanted != NULL && sscanf(wanted, "%u.%u%c", &search.platform_index, &search.device_index, &rest) == 2;
    /* A platform or a device that does not work is no reason to refuse another, but the reason where none is found. */
    svo_status status = SVO_OK;
    for (unsigned i = 0; i < count; ++i) {
        keep_first(search_platform(&search, platforms[i], i, status == SVO_OK ? message : NULL), &status);
    }
    svo_i_free(platforms);
    if (search.found == NULL) {
        return status != SVO_OK ? status : fail_search(&search, message);
    }
    *out = search.found;
    return SVO_OK;
}

/* A device divided by a limit of threads. Such a part is kept until the process ends: PoCL 3.1's contexts and queues do
   not retain it, while its threads still release the last events of a queue that the host has finished. */
typedef struct device_part {
    cl_device_id whole;
    uint32_t threads;
    cl_device_id part;
    const struct device_part *next;
} device_part;

static _Atomic(const device_part *) kept_parts;

static cl_device_id find_part(cl_device_id whole, uint32_t threads)
{
    const device_part *kept = atomic_load(&kept_parts);
    while (kept != NULL && (kept->whole != whole || kept->threads != threads)) {
        kept = kept->next;
    }
    return kept != NULL ? kept->part : NULL;
}

/* Two threads at once may keep two parts for the same limit, which is harmless. The memory is malloc's, since a
   caller's functions may not last as long. */
static svo_status keep_part(cl_device_id whole, uint32_t threads, cl_device_id part, svo_message *message)
{
    device_part *kept = svo_i_alloc(NULL, sizeof *kept);
    if (kept == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, CREATE_DEFAULT ": no memory for a part of the device");
    }
    *kept = (device_part){.whole = whole, .threads = threads, .part = part, .next = atomic_load(&kept_parts)};
    while (!atomic_compare_exchange_weak(&kept_parts, &kept->next, kept)) {
    }
    return SVO_OK;
}

/* Replaces a device that has more compute units than threads by a part that has as many. threads: 0: all. */
static svo_status limit_threads(uint32_t threads, cl_device_id *device, svo_message *message)
{
    cl_uint units = 0;
    if (threads == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(
        svo_i_device_property(*device, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, CREATE_DEFAULT, message));
    if (threads >= units) {
        return SVO_OK;
    }
    cl_device_id part = find_part(*device, threads);
    if (part == NULL) {
        const cl_device_partition_property parts[] = {CL_DEVICE_PARTITION_BY_COUNTS,
                                                      (cl_device_partition_property)threads,
                                                      CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
        const cl_int error = clCreateSubDevices(*device, parts, 1, &part, NULL);
        if (error != CL_SUCCESS) {
            return svo_i_fail(message, SVO_UNSUPPORTED,
                              CREATE_DEFAULT ": the device has %u compute units, and does not give away %u for "
                                             "options.max_threads: clCreateSubDevices failed with %s (%d)",
                              units, threads, svo_i_cl_error_name(error), error);
        }
        const svo_status status = keep_part(*device, threads, part, message);
        if (status != SVO_OK) {
            clReleaseDevice(part);
            return status;
        }
    }
    *device = part;
    return SVO_OK;
}

svo_status svo_device_create_default(const svo_device_options *options, svo_device **out, svo_message *message)
{
    cl_device_id device = NULL;
    svo_device_options asked;
    SVO_I_TRY(svo_i_struct_read(message, CREATE_DEFAULT, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_device_options, log_user)));
    svo_i_memory memory;
    SVO_I_TRY(svo_i_memory_read(message, CREATE_DEFAULT, "options.memory", asked.memory, &memory));
    SVO_I_TRY(find_device(asked.device_name, &memory, &device, message));
    SVO_I_TRY(limit_threads(asked.max_threads, &device, message));
    asked.max_threads = 0;
    cl_int error = CL_SUCCESS;
    cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, &error);
    if (error != CL_SUCCESS) {
        return svo_i_fail_cl(message, CREATE_DEFAULT, "clCreateContext", error);
    }
    const svo_status created = svo_device_create(context, device, &asked, out, message);
    clReleaseContext(context); /* the handle has retained it */
    return created;
}
