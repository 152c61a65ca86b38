/* SPDX-License-Identifier: MIT */
/*
 * svocl devices: the OpenCL devices and OpenGL renderers of this machine, and what svocl can do with each pair.
 *
 * Everything is collected in one JSON document; the tables for people are printed from it.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/devices.h"
#include "support/info_of.h"
#include "support/opengl_devices.h"
#include "support/table.h"
#include "svocl/commands.h"

#define PLATFORMS_MAX 16
#define DEVICES_MAX   32 /* per platform and in total */

/* Working OpenCL devices, open until their pairs with renderers are probed. */
typedef struct opened_devices {
    svo_device *devices[DEVICES_MAX];
    cl_context contexts[DEVICES_MAX];
    size_t device_count;
} opened_devices;

/* A text of a device, or without one of a platform. */
static void add_text(cJSON *object, const char *name, cl_device_id device, cl_platform_id platform, cl_uint what)
{
    char *text = devices_text(device, platform, what);
    if (text != NULL) {
        json_add_text(object, name, text);
    }
    free(text);
}

static const char *device_type_name(cl_device_id device)
{
    cl_device_type type = 0;
    clGetDeviceInfo(device, CL_DEVICE_TYPE, sizeof type, &type, NULL);
    return (type & CL_DEVICE_TYPE_GPU) != 0           ? "gpu"
           : (type & CL_DEVICE_TYPE_CPU) != 0         ? "cpu"
           : (type & CL_DEVICE_TYPE_ACCELERATOR) != 0 ? "accelerator"
                                                      : "other";
}

/* What works without OpenGL. */
static void add_frontends(cJSON *object, svo_device *device)
{
    svo_frontend *frontend = NULL;
    cJSON *frontends = cJSON_AddArrayToObject(object, "frontends");
    const bool made = svo_frontend_create_cl(device, &frontend) == SVO_OK;
    devices_add_method(frontends, "cl", made ? "" : program_words(svo_device_message(device)));
    svo_frontend_destroy(&frontend);
}

/* Opens the device for the pairs and records whether svocl can use it. */
static void open_device(program *state, cJSON *object, cl_device_id device, opened_devices *opened)
{
    svo_message message = {""};
    cl_int error = CL_SUCCESS;
    svo_device *handle = NULL;
    const svo_device_options device_options = {.struct_size = sizeof device_options,
                                               .log = program_log,
                                               .log_user = state,
                                               .path = (svo_path)state->options.path};
    cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, &error);
    if (context == NULL) {
        snprintf(message.text, sizeof message.text, "clCreateContext failed (%d)", error);
    } else if (opened->device_count == DEVICES_MAX) {
        snprintf(message.text, sizeof message.text, "not probed: more than %d devices", DEVICES_MAX);
    } else {
        svo_device_create(context, device, &device_options, &handle, &message);
    }
    cJSON_AddBoolToObject(object, "works", handle != NULL);
    json_add_text(object, "reason", program_words(message.text));
    if (handle != NULL) {
        json_add_text(object, "path", svo_name(SVO_NAME_PATH, info_of_device(handle).path));
        add_frontends(object, handle);
        opened->devices[opened->device_count] = handle;
        opened->contexts[opened->device_count++] = context;
    } else if (context != NULL) {
        clReleaseContext(context);
    }
}

static cJSON *describe_device(cl_device_id device)
{
    cl_uint compute_units = 0;
    cl_ulong memory_bytes = 0;
    cl_ulong max_allocation_bytes = 0;
    clGetDeviceInfo(device, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof compute_units, &compute_units, NULL);
    clGetDeviceInfo(device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof memory_bytes, &memory_bytes, NULL);
    clGetDeviceInfo(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof max_allocation_bytes, &max_allocation_bytes, NULL);
    cJSON *object = cJSON_CreateObject();
    add_text(object, "name", device, NULL, CL_DEVICE_NAME);
    json_add_text(object, "type", device_type_name(device));
    add_text(object, "version", device, NULL, CL_DEVICE_VERSION);
    add_text(object, "driver", device, NULL, CL_DRIVER_VERSION);
    add_text(object, "extensions", device, NULL, CL_DEVICE_EXTENSIONS);
    json_add_count(object, "compute_units", compute_units);
    json_add_count(object, "memory_bytes", memory_bytes);
    json_add_count(object, "max_allocation_bytes", max_allocation_bytes);
    return object;
}

static void gather_platform(program *state, cJSON *platforms, cl_platform_id platform, opened_devices *opened)
{
    cJSON *object = cJSON_CreateObject();
    add_text(object, "name", NULL, platform, CL_PLATFORM_NAME);
    add_text(object, "vendor", NULL, platform, CL_PLATFORM_VENDOR);
    add_text(object, "version", NULL, platform, CL_PLATFORM_VERSION);
    cJSON *devices = cJSON_AddArrayToObject(object, "devices");
    cl_device_id ids[DEVICES_MAX];
    cl_uint count = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, DEVICES_MAX, ids, &count) != CL_SUCCESS) {
        count = 0;
    }
    for (cl_uint i = 0; i < count && i < DEVICES_MAX; ++i) {
        cJSON *device = describe_device(ids[i]);
        open_device(state, device, ids[i], opened);
        cJSON_AddItemToArray(devices, device);
    }
    cJSON_AddItemToArray(platforms, object);
}

static void gather_platforms(program *state, cJSON *document, opened_devices *opened)
{
    cJSON *platforms = cJSON_AddArrayToObject(document, "platforms");
    cl_platform_id ids[PLATFORMS_MAX];
    cl_uint count = 0;
    if (clGetPlatformIDs(PLATFORMS_MAX, ids, &count) != CL_SUCCESS) {
        return;
    }
    for (cl_uint i = 0; i < count && i < PLATFORMS_MAX; ++i) {
        gather_platform(state, platforms, ids[i], opened);
    }
}

static void close_all(opened_devices *opened)
{
    for (size_t i = 0; i < opened->device_count; ++i) {
        svo_device_destroy(&opened->devices[i]);
        clReleaseContext(opened->contexts[i]);
    }
}

static const char *text_of(const cJSON *object, const char *name)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItem(object, name));
    return text != NULL ? text : "";
}

static uint64_t count_of(const cJSON *object, const char *name)
{
    const cJSON *item = cJSON_GetObjectItem(object, name);
    return cJSON_IsNumber(item) ? (uint64_t)item->valuedouble : 0;
}

static bool works(const cJSON *object)
{
    return cJSON_IsTrue(cJSON_GetObjectItem(object, "works"));
}

static void print_methods(table *rows, const cJSON *methods)
{
    const cJSON *method = NULL;
    cJSON_ArrayForEach(method, methods)
    {
        table_cell(rows, "%s", text_of(method, "name"));
        table_cell(rows, "%s%s", works(method) ? "works" : "no: ", text_of(method, "reason"));
    }
}

/* Front ends and builders share some names. */
static void print_builders(table *rows, const cJSON *builders)
{
    const cJSON *builder = NULL;
    cJSON_ArrayForEach(builder, builders)
    {
        table_cell(rows, "builder %s", text_of(builder, "name"));
        table_cell(rows, "%s%s", works(builder) ? "works" : "no: ", text_of(builder, "reason"));
    }
}

static void print_devices(const cJSON *platform, int platform_index)
{
    const cJSON *device = NULL;
    int device_index = 0;
    table *rows = table_create("ll");
    table_cell(rows, "%d", platform_index);
    table_cell(rows, "%s", text_of(platform, "version"));
    cJSON_ArrayForEach(device, cJSON_GetObjectItem(platform, "devices"))
    {
        table_cell(rows, "%d.%d", platform_index, device_index++);
        table_cell(rows, "%s", text_of(device, "name"));
        table_cell(rows, "%s", "");
        table_cell(rows, "%s, %u compute units, %s memory, %s per buffer", text_of(device, "type"),
                   (unsigned)count_of(device, "compute_units"), figure_bytes(count_of(device, "memory_bytes")).text,
                   figure_bytes(count_of(device, "max_allocation_bytes")).text);
        if (works(device)) {
            table_cell(rows, "%s", "");
            table_cell(rows, "path %s", text_of(device, "path"));
            print_methods(rows, cJSON_GetObjectItem(device, "frontends"));
        } else {
            table_cell(rows, "%s", "");
            table_cell(rows, "cannot be used: %s", text_of(device, "reason"));
        }
    }
    table_print(rows);
}

static void print_platforms(const cJSON *document)
{
    const cJSON *platform = NULL;
    int platform_index = 0;
    cJSON_ArrayForEach(platform, cJSON_GetObjectItem(document, "platforms"))
    {
        table_heading("OpenCL platform %d: %s", platform_index, text_of(platform, "name"));
        print_devices(platform, platform_index++);
        table_gap();
    }
}

static void print_renderers(const cJSON *document)
{
    const cJSON *renderer = NULL;
    table_heading(cJSON_GetArraySize(cJSON_GetObjectItem(document, "renderers")) > 0 ? "OpenGL renderers"
                                                                                     : "No OpenGL in this svocl");
    table *rows = table_create("ll");
    cJSON_ArrayForEach(renderer, cJSON_GetObjectItem(document, "renderers"))
    {
        if (strcmp(text_of(renderer, "context"), "egl-device") == 0) {
            table_cell(rows, "%s %u", text_of(renderer, "context"), (unsigned)count_of(renderer, "device_index"));
        } else {
            table_cell(rows, "%s", text_of(renderer, "context"));
        }
        if (works(renderer)) {
            table_cell(rows, "%s", text_of(renderer, "renderer"));
            table_cell(rows, "%s", "");
            table_cell(rows, "OpenGL %s", text_of(renderer, "version"));
        } else {
            table_cell(rows, "none: %s", text_of(renderer, "reason"));
        }
    }
    table_print(rows);
}

/* Whether two pairs have the same device and the same methods work, for the same reasons. */
static bool is_alike(const cJSON *a, const cJSON *b)
{
    static const char *const compared[] = {"device", "frontends", "shares", "builders"};
    for (size_t i = 0; i < sizeof compared / sizeof compared[0]; ++i) {
        if (!cJSON_Compare(cJSON_GetObjectItem(a, compared[i]), cJSON_GetObjectItem(b, compared[i]), 1)) {
            return false;
        }
    }
    return true;
}

/* One table for equal neighbors: contexts of one renderer usually differ in nothing else. */
static void print_pairs(const cJSON *document)
{
    const cJSON *first = cJSON_GetArrayItem(cJSON_GetObjectItem(document, "pairs"), 0);
    while (first != NULL) {
        table_gap();
        table_heading("%s", text_of(first, "device"));
        table *rows = table_create("ll");
        const cJSON *pair = first;
        for (; pair != NULL && is_alike(first, pair); pair = pair->next) {
            table_cell(rows, "%s", pair == first ? "with" : "and");
            table_cell(rows, "%s %u: %s", text_of(pair, "context"), (unsigned)count_of(pair, "device_index"),
                       text_of(pair, "renderer"));
        }
        print_methods(rows, cJSON_GetObjectItem(first, "frontends"));
        print_methods(rows, cJSON_GetObjectItem(first, "shares"));
        print_builders(rows, cJSON_GetObjectItem(first, "builders"));
        table_print(rows);
        first = pair;
    }
}

int command_devices(program *state)
{
    opened_devices opened = {0};
    cJSON *document = json_document();
    gather_platforms(state, document, &opened);
    opengl_describe(document, opened.devices, opened.device_count);
    const bool has_device = opened.device_count > 0;
    close_all(&opened);
    int exit_code = PROGRAM_DONE;
    if (state->options.json) {
        exit_code = json_print(state, document);
    } else {
        print_platforms(document);
        print_renderers(document);
        print_pairs(document);
        cJSON_Delete(document);
    }
    if (exit_code == PROGRAM_DONE && !has_device) {
        exit_code = program_fail(state, PROGRAM_FAILED, "no OpenCL device was found that svocl can use");
    }
    return exit_code;
}
