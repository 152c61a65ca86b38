/* SPDX-License-Identifier: MIT */
/*
 * The device handle: what it asks of an OpenCL device, its limits, messages, buffers, their budget, and its own queue.
 * Buffers count by their destructor callbacks, which a driver may call on any thread.
 */
#include "core/device.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/opencl.h"
#include "core/struct_size.h"
#include "shared/layout.h"

/* ---- the budget ---- */

/* Waits for buffers that the driver is about to destroy, in milliseconds. */
#define DESTROY_WAITS 100

/* What a compiler of the process, such as PoCL's LLVM, takes beside buffers: to begin, and from then on. One that gets
   no memory ends the process. Measured with PoCL 3.1: 125 MB for the first program, cold, and 15 MB for five others. */
#define COMPILER_FIRST_BYTES (UINT64_C(192) << 20)
#define COMPILER_LATER_BYTES (UINT64_C(96) << 20)
/* For smaller buffers the process is not asked what it has: that takes some microseconds. */
#define ASKED_BYTES_MIN (UINT64_C(1) << 20)

struct svo_i_budget {
    svo_i_memory memory; /* of the counted buffers */
    uint64_t max_bytes; /* the caller's; UINT64_MAX: none */
    svo_i_limit limits[SVO_I_LIMIT_KINDS]; /* of the process, when the handle was made */
    atomic_uint_least64_t held_bytes;
    atomic_uint_least64_t users; /* the handle and the buffers */
};

/* A buffer that counts. */
typedef struct counted_buffer {
    svo_i_budget *budget;
    uint64_t bytes;
} counted_buffer;

/* max_bytes: the caller's; 0: none. with_process: the process's memory is the device's. *out becomes NULL where neither
   limits it. False when out of memory. */
static bool budget_create(const svo_i_memory *memory, uint64_t max_bytes, bool with_process, svo_i_budget **out)
{
    svo_i_budget made = {.memory = *memory, .max_bytes = max_bytes != 0 ? max_bytes : UINT64_MAX};
    bool is_limited = max_bytes != 0;
    for (unsigned kind = 0; kind < SVO_I_LIMIT_KINDS; ++kind) {
        made.limits[kind] = (svo_i_limit){.bytes = UINT64_MAX};
        if (with_process) {
            made.limits[kind] = svo_i_limit_read((svo_i_limit_kind)kind);
        }
        is_limited = is_limited || made.limits[kind].bytes != UINT64_MAX;
    }
    *out = is_limited ? svo_i_alloc_zeroed(memory, 1, sizeof **out) : NULL;
    if (*out != NULL) {
        **out = made;
        atomic_init(&(*out)->held_bytes, 0);
        atomic_init(&(*out)->users, 1);
    }
    return *out != NULL || !is_limited;
}

/* Gives up the handle's part; NULL allowed. */
static void budget_release(svo_i_budget *budget)
{
    if (budget != NULL && atomic_fetch_sub(&budget->users, 1) == 1) {
        svo_i_free(budget);
    }
}

static uint64_t held_bytes(const svo_i_budget *budget)
{
    return budget != NULL ? atomic_load(&budget->held_bytes) : 0;
}

/* What a compiler may still take. */
static uint64_t compiler_bytes(const svo_device *device)
{
    return device->has_compiled ? COMPILER_LATER_BYTES : COMPILER_FIRST_BYTES;
}

/* What a limit of the process leaves beside a compiler: by what the process has now, and by what it had when the handle
   was made and the buffers since, for which some drivers get memory when they are first used. */
static svo_i_limit left_of(const svo_device *device, svo_i_limit_kind kind, uint64_t bytes)
{
    svo_i_limit counted = device->budget->limits[kind];
    svo_i_limit now = bytes >= ASKED_BYTES_MIN && counted.bytes != UINT64_MAX ? svo_i_limit_read(kind) : counted;
    now.used_bytes += compiler_bytes(device);
    counted.bytes = now.bytes;
    counted.used_bytes += COMPILER_FIRST_BYTES + held_bytes(device->budget);
    return svo_i_limit_left(&counted) < svo_i_limit_left(&now) ? counted : now;
}

static svo_i_budget_answer ask_budget(const svo_device *device, uint64_t bytes)
{
    const svo_i_budget *budget = device->budget;
    svo_i_budget_answer answer = {
        .fits = true, .status = SVO_OUT_OF_DEVICE_MEMORY, .held_bytes = held_bytes(budget), .max_bytes = UINT64_MAX};
    if (budget == NULL) {
        return answer;
    }
    answer.max_bytes = budget->max_bytes;
    answer.fits = answer.held_bytes <= budget->max_bytes && bytes <= budget->max_bytes - answer.held_bytes;
    for (unsigned kind = 0; answer.fits && kind < SVO_I_LIMIT_KINDS; ++kind) {
        const svo_i_limit limit = left_of(device, (svo_i_limit_kind)kind, bytes);
        if (bytes > svo_i_limit_left(&limit)) {
            answer.fits = false;
            answer.limit = limit;
            answer.status = svo_i_limit_left(&limit) == 0 ? SVO_OUT_OF_HOST_MEMORY : SVO_OUT_OF_DEVICE_MEMORY;
        }
    }
    return answer;
}

svo_i_budget_answer svo_i_device_budget(const svo_device *device, uint64_t bytes)
{
    svo_i_budget_answer answer = ask_budget(device, bytes);
    const bool may_fit = answer.held_bytes > 0 && bytes <= answer.max_bytes;
    for (unsigned i = 0; !answer.fits && i < DESTROY_WAITS && may_fit; ++i) {
        svo_i_system_sleep_ms(1);
        answer = ask_budget(device, bytes);
    }
    return answer;
}

svo_i_budget_text svo_i_budget_words(const svo_i_budget_answer *answer)
{
    svo_i_budget_text words;
    if (answer->limit.name == NULL) {
        (void)snprintf(words.text, sizeof words.text, "beside the %s in use, above max_device_bytes, %s",
                       svo_i_bytes(answer->held_bytes).text, svo_i_bytes(answer->max_bytes).text);
    } else {
        (void)snprintf(
            words.text, sizeof words.text,
            "beside the %s in use, and is out of memory: %s is %s, which leaves %s beside the process and its "
            "compiler",
            svo_i_bytes(answer->held_bytes).text, answer->limit.name, svo_i_bytes(answer->limit.bytes).text,
            svo_i_bytes(svo_i_limit_left(&answer->limit)).text);
    }
    return words;
}

svo_status svo_i_device_check_compiler(svo_device *device, const char *function)
{
    for (unsigned kind = 0; device->budget != NULL && kind < SVO_I_LIMIT_KINDS; ++kind) {
        svo_i_limit limit = device->budget->limits[kind];
        limit = limit.bytes != UINT64_MAX ? svo_i_limit_read((svo_i_limit_kind)kind) : limit;
        if (svo_i_limit_left(&limit) < compiler_bytes(device)) {
            return svo_i_device_fail(
                device, SVO_OUT_OF_HOST_MEMORY,
                "%s: out of memory: compiling kernels needs about %s, and %s is %s, which leaves %s", function,
                svo_i_bytes(compiler_bytes(device)).text, limit.name, svo_i_bytes(limit.bytes).text,
                svo_i_bytes(svo_i_limit_left(&limit)).text);
        }
    }
    return SVO_OK;
}

static void CL_CALLBACK forget(cl_mem buffer, void *user)
{
    counted_buffer *counted = user;
    (void)buffer;
    atomic_fetch_sub(&counted->budget->held_bytes, counted->bytes);
    budget_release(counted->budget);
    svo_i_free(counted);
}

/* Counts a new buffer until it is destroyed. Returns an error of OpenCL, and then counts nothing. */
static cl_int budget_count(svo_i_budget *budget, cl_mem buffer, uint64_t bytes)
{
    if (budget == NULL) {
        return CL_SUCCESS;
    }
    counted_buffer *counted = svo_i_alloc(&budget->memory, sizeof *counted);
    if (counted == NULL) {
        return CL_OUT_OF_HOST_MEMORY;
    }
    *counted = (counted_buffer){budget, bytes};
    atomic_fetch_add(&budget->held_bytes, bytes);
    atomic_fetch_add(&budget->users, 1);
    const cl_int error = clSetMemObjectDestructorCallback(buffer, forget, counted);
    if (error != CL_SUCCESS) {
        forget(buffer, counted);
    }
    return error;
}

/* ---- the handle ---- */

#define SETTLE_ATTEMPTS 3
/* A quarter of a million pixels. */
#define BAND_TILES 4096u
/* Halves that hide the time to begin a write; smaller arrays are their driver's. */
#define STAGING_BYTES    (UINT32_C(4) << 20)
#define STAGED_BYTES_MIN (UINT32_C(64) << 10)
/* The first band may leave a large GPU half idle, but a slow one ends it in time. */
#define BAND_MS           50.0
#define BAND_FIRST_GROUPS 256u
#define BAND_LEAST_GROUPS 64u

svo_message *svo_i_device_message(svo_device *device)
{
    return device != NULL ? &device->message : NULL;
}

svo_status svo_i_device_fail(svo_device *device, svo_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    svo_i_fail_v(svo_i_device_message(device), status, format, arguments);
    va_end(arguments);
    return status;
}

svo_status svo_i_device_fail_cl(svo_device *device, const char *function, const char *call, cl_int error)
{
    return svo_i_fail_cl(svo_i_device_message(device), function, call, error);
}

/* content: of the buffer, with CL_MEM_COPY_HOST_PTR; else NULL. */
static svo_status make_buffer(svo_device *device, const char *function, const char *name, cl_mem_flags flags,
                              void *content, size_t bytes, cl_mem *out)
{
    if (bytes > device->max_allocation_bytes) {
        return svo_i_device_fail(device, SVO_OUT_OF_DEVICE_MEMORY,
                                 "%s: buffer %s needs %s, above the device's limit of %s", function, name,
                                 svo_i_bytes(bytes).text, svo_i_bytes(device->max_allocation_bytes).text);
    }
    const size_t made_bytes = bytes > 0 ? bytes : 1;
    const svo_i_budget_answer room = svo_i_device_budget(device, made_bytes);
    if (!room.fits) {
        return svo_i_device_fail(device, room.status, "%s: buffer %s needs %s %s", function, name,
                                 svo_i_bytes(bytes).text, svo_i_budget_words(&room).text);
    }
    cl_int error = CL_SUCCESS;
    cl_mem buffer = clCreateBuffer(device->context, flags, made_bytes, content, &error);
    if (error == CL_SUCCESS) {
        error = budget_count(device->budget, buffer, made_bytes);
        if (error != CL_SUCCESS) {
            clReleaseMemObject(buffer);
        }
    }
    if (error != CL_SUCCESS) {
        const svo_status status = error == CL_OUT_OF_HOST_MEMORY ? SVO_OUT_OF_HOST_MEMORY : SVO_OUT_OF_DEVICE_MEMORY;
        (void)svo_i_device_fail(device, status, "%s: buffer %s of %s: %s (%d)", function, name, svo_i_bytes(bytes).text,
                                svo_i_cl_error_name(error), error);
        svo_i_limit_explain(&device->message);
        return status;
    }
    *out = buffer;
    return SVO_OK;
}

svo_status svo_i_device_buffer(svo_device *device, const char *function, const char *name, cl_mem_flags flags,
                               size_t bytes, cl_mem *out)
{
    return make_buffer(device, function, name, flags, NULL, bytes, out);
}

uint64_t svo_i_device_slots(const svo_device *device, uint64_t bytes)
{
    const uint64_t slots = bytes / device->slot_bytes + (bytes % device->slot_bytes != 0 || bytes == 0 ? 1 : 0);
    return slots * device->slot_bytes;
}

static svo_status make_separately(svo_device *device, const char *function, const svo_i_request *requests, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        SVO_I_TRY(make_buffer(device, function, requests[i].name, CL_MEM_READ_WRITE, NULL,
                              (size_t)svo_i_device_slots(device, requests[i].bytes), requests[i].out));
    }
    return SVO_OK;
}

/* Cuts a buffer, in the order of the requests. */
static svo_status cut_buffer(svo_device *device, const char *function, cl_mem whole, const svo_i_request *requests,
                             size_t count)
{
    cl_buffer_region region = {0, 0};
    for (size_t i = 0; i < count; ++i) {
        cl_int error = CL_SUCCESS;
        region.size = (size_t)svo_i_device_slots(device, requests[i].bytes);
        *requests[i].out = clCreateSubBuffer(whole, 0, CL_BUFFER_CREATE_TYPE_REGION, &region, &error);
        if (error != CL_SUCCESS) {
            *requests[i].out = NULL;
            return svo_i_device_fail_cl(device, function, "clCreateSubBuffer", error);
        }
        region.origin += region.size;
    }
    return SVO_OK;
}

svo_status svo_i_device_buffers(svo_device *device, const char *function, const svo_i_request *requests, size_t count)
{
    cl_mem whole = NULL;
    uint64_t bytes = 0;
    svo_status status = SVO_OK;
    for (size_t i = 0; i < count; ++i) {
        *requests[i].out = NULL;
        bytes += svo_i_device_slots(device, requests[i].bytes);
    }
    if (count < 2 || bytes > device->max_allocation_bytes) {
        SVO_I_TRY_CLEANUP(make_separately(device, function, requests, count));
        return SVO_OK;
    }
    SVO_I_TRY_CLEANUP(make_buffer(device, function, requests[0].name, CL_MEM_READ_WRITE, NULL, (size_t)bytes, &whole));
    SVO_I_TRY_CLEANUP(cut_buffer(device, function, whole, requests, count));
cleanup:
    svo_i_buffer_release(&whole);
    for (size_t i = 0; i < (status == SVO_OK ? 0 : count); ++i) {
        svo_i_buffer_release(requests[i].out);
    }
    return status;
}

svo_status svo_i_device_constants(svo_device *device, const char *function, const char *name, const void *content,
                                  size_t bytes, cl_mem *out)
{
    void *copied = NULL; /* OpenCL's parameter is not const, though the memory is only read */
    memcpy(&copied, &content, sizeof copied);
    return make_buffer(device, function, name, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, copied, bytes, out);
}

void svo_i_buffer_release(cl_mem *buffer)
{
    if (*buffer != NULL) {
        clReleaseMemObject(*buffer);
        *buffer = NULL;
    }
}

svo_status svo_i_device_check_wait(svo_device *device, const char *function, cl_uint num_wait, const cl_event *wait)
{
    const char *wrong = svo_i_wrong_wait(device->context, num_wait, wait);
    return wrong == NULL ? SVO_OK : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s", function, wrong);
}

svo_status svo_i_device_check_memory(svo_device *device, const char *function, const char *name, cl_mem memory,
                                     size_t bytes)
{
    const char *wrong = svo_i_wrong_memory(device->context, memory);
    size_t held = 0;
    if (wrong != NULL) {
        return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s %s", function, name, wrong);
    }
    const cl_int error = clGetMemObjectInfo(memory, CL_MEM_SIZE, sizeof held, &held, NULL);
    if (error != CL_SUCCESS) {
        return svo_i_device_fail_cl(device, function, "clGetMemObjectInfo", error);
    }
    return held >= bytes ? SVO_OK
                         : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s holds %zu bytes, below %zu",
                                             function, name, held, bytes);
}

svo_status svo_i_device_check_output(svo_device *device, const char *function, const char *name, cl_mem memory,
                                     size_t bytes)
{
    const char *wrong = svo_i_wrong_output(device->context, memory);
    return wrong == NULL ? svo_i_device_check_memory(device, function, name, memory, bytes)
                         : svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s %s", function, name, wrong);
}

/* The device's own queue, attached to it. */
typedef struct own_queue {
    svo_i_attachment attachment;
    cl_command_queue queue;
} own_queue;

static void release_queue(svo_i_attachment *attachment)
{
    clReleaseCommandQueue(((own_queue *)attachment)->queue);
    svo_i_free(attachment);
}

svo_status svo_i_device_queue(svo_device *device, const char *function, cl_command_queue given, cl_command_queue *out)
{
    const svo_i_attachment *known = svo_i_attachment_find(device->attachments, release_queue);
    if (given != NULL) {
        const char *wrong = svo_i_wrong_queue(device->context, device->device, given);
        if (wrong != NULL) {
            return svo_i_device_fail(device, SVO_INVALID_ARGUMENT, "%s: %s", function, wrong);
        }
        *out = given;
        return SVO_OK;
    }
    if (known != NULL) {
        *out = ((const own_queue *)known)->queue;
        return SVO_OK;
    }
    own_queue *own = svo_i_alloc_zeroed(&device->memory, 1, sizeof *own);
    if (own == NULL) {
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for a queue", function);
    }
    cl_int error = CL_SUCCESS;
    own->queue = clCreateCommandQueue(device->context, device->device, 0, &error);
    if (error != CL_SUCCESS) {
        svo_i_free(own);
        return svo_i_device_fail_cl(device, function, "clCreateCommandQueue", error);
    }
    own->attachment.destroy = release_queue;
    svo_i_attachment_add(&device->attachments, &own->attachment);
    *out = own->queue;
    return SVO_OK;
}

bool svo_i_event_settle(cl_event event)
{
    cl_int status = CL_QUEUED;
    for (unsigned i = 0; i < SETTLE_ATTEMPTS && status > CL_COMPLETE; ++i) {
        if (clWaitForEvents(1, &event) == CL_SUCCESS) {
            return true;
        }
        /* A command that failed has ended too: its status is negative. */
        if (clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, NULL) != CL_SUCCESS) {
            status = CL_QUEUED;
        }
    }
    return status <= CL_COMPLETE;
}

void svo_i_device_log(const svo_device *device, svo_log_level level, const char *text)
{
    if (device->log != NULL) {
        device->log(device->log_user, level, text);
    }
}

/* The public function, for its messages. */
#define CREATE "svo_device_create"

/* Whether the device can run the kernels: OpenCL 1.2, little-endian, work-groups of SVO_GROUP_ITEMS. */
static svo_status check_device(cl_device_id device, const char *name, const svo_i_memory *memory, svo_message *message)
{
    cl_bool little = CL_FALSE;
    size_t group_items = 0;
    unsigned major = 0;
    unsigned minor = 0;
    char *version = NULL;
    SVO_I_TRY(svo_i_device_text(device, CL_DEVICE_VERSION, CREATE, memory, &version, message));
    const bool known = sscanf(version, "OpenCL %u.%u", &major, &minor) == 2;
    svo_i_free(version);
    if (!known || major * 10 + minor < 12) {
        return svo_i_fail(message, SVO_UNSUPPORTED, CREATE ": %s has OpenCL %u.%u, below 1.2", name, major, minor);
    }
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_ENDIAN_LITTLE, sizeof little, &little, CREATE, message));
    if (!little) {
        return svo_i_fail(message, SVO_UNSUPPORTED, CREATE ": %s is big-endian", name);
    }
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_MAX_WORK_GROUP_SIZE, sizeof group_items, &group_items, CREATE,
                                    message));
    if (group_items < SVO_GROUP_ITEMS) {
        return svo_i_fail(message, SVO_UNSUPPORTED, CREATE ": %s has work-groups of %zu items, below %d", name,
                          group_items, SVO_GROUP_ITEMS);
    }
    return SVO_OK;
}

/* Whether the device is the other one, or a part of it. */
static cl_int find_whole(cl_device_id device, cl_device_id other, bool *found)
{
    cl_int error = CL_SUCCESS;
    while (error == CL_SUCCESS && device != NULL && device != other) {
        cl_device_id parent = NULL;
        error = clGetDeviceInfo(device, CL_DEVICE_PARENT_DEVICE, sizeof parent, &parent, NULL);
        device = parent;
    }
    *found = device == other;
    return error;
}

/* Whether the context has the device. PoCL lists the whole device for a context that was made for a part of it. */
static svo_status check_context(cl_context context, cl_device_id device, const svo_i_memory *memory,
                                svo_message *message)
{
    size_t bytes = 0;
    cl_int error = clGetContextInfo(context, CL_CONTEXT_DEVICES, 0, NULL, &bytes);
    cl_device_id *devices = error == CL_SUCCESS ? svo_i_alloc_zeroed(memory, 1, bytes + 1) : NULL;
    if (error == CL_SUCCESS && devices == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, CREATE ": no memory for the context's devices");
    }
    error = error == CL_SUCCESS ? clGetContextInfo(context, CL_CONTEXT_DEVICES, bytes, devices, NULL) : error;
    bool found = false;
    for (size_t i = 0; error == CL_SUCCESS && !found && i < bytes / sizeof *devices; ++i) {
        error = find_whole(device, devices[i], &found);
    }
    svo_i_free(devices);
    if (error != CL_SUCCESS) {
        return svo_i_fail_cl(message, CREATE, "clGetContextInfo or clGetDeviceInfo", error);
    }
    return found ? SVO_OK : svo_i_fail(message, SVO_INVALID_ARGUMENT, CREATE ": device does not belong to context");
}

/* Whether the device lists an extension. */
static svo_status find_extension(const svo_device *handle, cl_device_id device, const char *extension, bool *found,
                                 svo_message *message)
{
    char *list = NULL;
    SVO_I_TRY(svo_i_device_text(device, CL_DEVICE_EXTENSIONS, CREATE, &handle->memory, &list, message));
    const size_t length = strlen(extension);
    *found = false;
    for (const char *at = list; (at = strstr(at, extension)) != NULL && !*found; at += length) {
        *found = (at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0');
    }
    svo_i_free(list);
    return SVO_OK;
}

static svo_status choose_path(svo_device *handle, svo_path path, svo_message *message)
{
    if ((unsigned)path > SVO_PATH_GPU) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, CREATE ": options.path %d is not in %d .. %d", (int)path,
                          (int)SVO_PATH_AUTO, (int)SVO_PATH_GPU);
    }
    handle->cpu_path = path == SVO_PATH_CPU || (path == SVO_PATH_AUTO && handle->is_cpu);
    return SVO_OK;
}

static uint32_t between(uint32_t least, uint64_t number, uint32_t most)
{
    return number < least ? least : number > most ? most : (uint32_t)number;
}

/* How many groups share the work of a scan or a sort. Results do not depend on it. */
static svo_status choose_widths(svo_device *handle, cl_device_id device, svo_message *message)
{
    cl_uint units = 0;
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, CREATE, message));
    handle->scan_groups = handle->cpu_path ? SVO_SCAN_GROUPS : between(64, UINT64_C(8) * units, 2048);
    handle->stream_items = between(64, UINT64_C(32) * units, 4096);
    handle->sort_groups = handle->cpu_path ? SVO_SORT_BLOCKS : between(16, UINT64_C(4) * units, 512);
    return SVO_OK;
}

/* The properties that builds and rays depend on. */
static svo_status query_properties(svo_device *handle, cl_device_id device, svo_message *message)
{
    cl_device_type type = 0;
    cl_uint alignment_bits = 0;
    cl_bool shares_memory = CL_TRUE; /* with the host, where the driver does not say */
    cl_device_fp_config floats = 0;
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_TYPE, sizeof type, &type, CREATE, message));
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof(cl_ulong),
                                    &handle->max_allocation_bytes, CREATE, message));
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof(cl_ulong), &handle->global_bytes, CREATE,
                                    message));
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_MEM_BASE_ADDR_ALIGN, sizeof alignment_bits, &alignment_bits,
                                    CREATE, message));
    handle->slot_bytes = alignment_bits >= 1024 ? alignment_bits / 8 : 128;
    SVO_I_TRY(svo_i_device_property(device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof floats, &floats, CREATE, message));
    (void)clGetDeviceInfo(device, CL_DEVICE_HOST_UNIFIED_MEMORY, sizeof shares_memory, &shares_memory, NULL);
    handle->staging_bytes = shares_memory == CL_FALSE ? STAGING_BYTES : 0;
    handle->staged_bytes_min = STAGED_BYTES_MIN;
    handle->is_cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
    handle->has_own_memory = shares_memory == CL_FALSE && !handle->is_cpu;
    handle->rounds_quotients = (floats & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    return find_extension(handle, device, "cl_khr_fp64", &handle->has_fp64, message);
}

/* Takes both references of a handle, or none. */
static svo_status retain(cl_context context, cl_device_id device, svo_message *message)
{
    cl_int error = clRetainContext(context);
    if (error != CL_SUCCESS) {
        return svo_i_fail_cl(message, CREATE, "clRetainContext", error);
    }
    error = clRetainDevice(device);
    if (error != CL_SUCCESS) {
        clReleaseContext(context);
        return svo_i_fail_cl(message, CREATE, "clRetainDevice", error);
    }
    return SVO_OK;
}

svo_status svo_device_create(cl_context context, cl_device_id device, const svo_device_options *options,
                             svo_device **out, svo_message *message)
{
    if (context == NULL || device == NULL || out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, CREATE ": context, device or out is NULL");
    }
    svo_device_options asked;
    SVO_I_TRY(svo_i_struct_read(message, CREATE, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_device_options, log_user)));
    if (asked.max_threads != 0) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          CREATE ": options.max_threads %u is for svo_device_create_default; pass a part of the device "
                                 "instead",
                          asked.max_threads);
    }
    svo_i_memory memory;
    SVO_I_TRY(svo_i_memory_read(message, CREATE, "options.memory", asked.memory, &memory));
    svo_status status = SVO_OK;
    char *name = NULL;
    svo_device *handle = svo_i_alloc_zeroed(&memory, 1, sizeof *handle);
    svo_i_budget *budget = NULL;
    if (handle == NULL) {
        return svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, CREATE ": no memory for the handle");
    }
    handle->memory = memory;
    SVO_I_TRY_CLEANUP(svo_i_device_full_name(device, CREATE, &memory, &name, message));
    SVO_I_TRY_CLEANUP(check_device(device, name, &memory, message));
    SVO_I_TRY_CLEANUP(check_context(context, device, &memory, message));
    SVO_I_TRY_CLEANUP(query_properties(handle, device, message));
    SVO_I_TRY_CLEANUP(choose_path(handle, asked.path, message));
    SVO_I_TRY_CLEANUP(choose_widths(handle, device, message));
    if (!budget_create(&memory, asked.max_device_bytes, !handle->has_own_memory, &budget)) {
        status = svo_i_fail(message, SVO_OUT_OF_HOST_MEMORY, CREATE ": no memory for the handle's budget");
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(retain(context, device, message));
    handle->name = name;
    handle->budget = budget;
    handle->saves_memory = asked.max_device_bytes != 0;
    handle->staging_bytes = handle->saves_memory ? 0 : handle->staging_bytes;
    handle->log = asked.log;
    handle->log_user = asked.log_user;
    handle->context = context;
    handle->device = device;
    handle->tests_programs = asked.trust_driver == 0;
    handle->bands = (svo_i_bands){BAND_MS, BAND_FIRST_GROUPS, BAND_LEAST_GROUPS};
    handle->band_tiles = handle->cpu_path ? UINT32_MAX : BAND_TILES;
    *out = handle;
    return SVO_OK;

cleanup:
    budget_release(budget);
    svo_i_free(handle);
    svo_i_free(name);
    return status;
}

void svo_device_destroy(svo_device **device)
{
    if (device == NULL || *device == NULL) {
        return;
    }
    svo_i_attachments_clear(&(*device)->attachments);
    clReleaseContext((*device)->context);
    clReleaseDevice((*device)->device);
    budget_release((*device)->budget);
    svo_i_free((*device)->name);
    svo_i_free(*device);
    *device = NULL;
}

svo_status svo_device_get_info(const svo_device *device, svo_device_info *info)
{
    const svo_device_info found = {.context = device->context,
                                   .device = device->device,
                                   .name = device->name,
                                   .path = device->cpu_path ? SVO_PATH_CPU : SVO_PATH_GPU,
                                   .compile_ms = device->compile_ms};
    return svo_i_struct_write(NULL, "svo_device_get_info", "info", &found, info,
                              SVO_I_STRUCT_SIZES(svo_device_info, compile_ms));
}

const char *svo_device_message(const svo_device *device)
{
    return device->message.text;
}
