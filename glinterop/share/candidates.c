/* SPDX-License-Identifier: MIT */
/*
 * Chooses contexts: the one that suits an OpenCL device best, tried in an order until a better one can no longer come,
 * and the one on the EGL device of a name.
 */
#define _POSIX_C_SOURCE 200809L
#include "share/candidates.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "context/context.h"
#include "context/egl.h"
#include "core/device.h"
#include "core/message.h"
#include "core/struct_size.h"
#include "share/interop.h"

#define FUNCTION "svo_gl_context_create"

/* ---- candidates ---- */

static size_t add(svo_i_candidate *out, size_t count, svo_gl_context_kind kind, uint32_t device_index, bool is_software)
{
    out[count] = (svo_i_candidate){.kind = kind, .device_index = device_index, .is_software = is_software};
    return count + 1;
}

static size_t add_egl_devices(svo_i_candidate *out, size_t count, const bool *software, uint32_t egl_device_count,
                              bool wanted)
{
    for (uint32_t i = 0; i < egl_device_count; ++i) {
        if (software[i] == wanted) {
            count = add(out, count, SVO_GL_EGL_DEVICE, i, wanted);
        }
    }
    return count;
}

size_t svo_i_candidates_list(const bool *software, uint32_t egl_device_count, svo_i_candidate *out)
{
    const uint32_t looked_at = egl_device_count < SVO_I_EGL_DEVICES_MAX ? egl_device_count : SVO_I_EGL_DEVICES_MAX;
    size_t count = add_egl_devices(out, 0, software, looked_at, false);
    /* Where each device is software, so is the platform that chooses among them. */
    count = add(out, count, SVO_GL_SURFACELESS, 0, looked_at > 0 && count == 0);
    count = add_egl_devices(out, count, software, looked_at, true);
    return add(out, count, SVO_GL_OSMESA, 0, true);
}

size_t svo_i_candidates_choose(const svo_i_candidate *candidates, size_t count, svo_i_fit most,
                               svo_i_fit (*fit)(void *user, size_t index), void *user)
{
    size_t best = count;
    svo_i_fit best_fit = SVO_I_FIT_NONE;
    for (size_t i = 0; i < count; ++i) {
        const svo_i_fit limit = candidates[i].is_software ? SVO_I_FIT_SOFTWARE : most;
        const svo_i_fit found = limit > best_fit ? fit(user, i) : SVO_I_FIT_NONE;
        if (found > best_fit) {
            best = i;
            best_fit = found;
        }
    }
    return best;
}

/* ---- the context for a device ---- */

typedef struct search {
    const svo_device *device;
    const svo_i_memory *memory;
    svo_i_candidate candidates[SVO_I_CANDIDATES_MAX];
    svo_gl_context *contexts[SVO_I_CANDIDATES_MAX]; /* NULL: not tried, or none */
    svo_status failed; /* the first failure that is no fault of the candidate */
    svo_message failure; /* its words */
    svo_message list; /* of all failures */
} search;

/* Appends "; osmesa: words" to the list, cut when it is full. */
static void note_failure(search *s, const svo_i_candidate *tried, svo_status status, const svo_message *reason)
{
    const size_t used = strlen(s->list.text);
    const char *words = strstr(reason->text, ": ");
    (void)snprintf(s->list.text + used, sizeof s->list.text - used, "%s%s: %s", used > 0 ? "; " : "",
                   svo_name(SVO_NAME_GL_CONTEXT_KIND, tried->kind), words != NULL ? words + 2 : reason->text);
    if (status != SVO_NO_GL && s->failed == SVO_OK) {
        s->failed = status;
        s->failure = *reason;
    }
}

/* The device's name without its platform's. */
static const char *own_name(const svo_device *device)
{
    const char *after = strstr(device->name, ": ");
    return after != NULL ? after + 2 : device->name;
}

static bool shares(const svo_device *device, svo_gl_context *context)
{
    svo_i_interop found;
    if (svo_i_gl_context_make_current(context, NULL) != SVO_OK) {
        return false;
    }
    const bool is_listed = svo_i_interop_find(device, context, &found, NULL) == SVO_OK;
    svo_i_gl_context_release_current(context);
    return is_listed;
}

static svo_i_fit fit_of(const svo_device *device, svo_gl_context *context)
{
    return svo_i_gl_is_software(&context->functions)                            ? SVO_I_FIT_SOFTWARE
           : shares(device, context)                                            ? SVO_I_FIT_SHARING
           : svo_i_text_contains(context->functions.renderer, own_name(device)) ? SVO_I_FIT_NAMED
                                                                                : SVO_I_FIT_HARDWARE;
}

static svo_i_fit try_candidate(void *user, size_t index)
{
    search *s = user;
    const svo_i_candidate *tried = &s->candidates[index];
    svo_message reason = {""};
    const svo_status status =
        svo_i_gl_context_open(tried->kind, tried->device_index, s->memory, &s->contexts[index], &reason);
    if (status != SVO_OK) {
        note_failure(s, tried, status, &reason);
        return SVO_I_FIT_NONE;
    }
    return fit_of(s->device, s->contexts[index]);
}

/* The most that a context can suit the device: a CPU is no renderer's GPU. */
static svo_i_fit most_of(const svo_device *device)
{
    return svo_gl_device_may_share(device) ? SVO_I_FIT_SHARING : device->is_cpu ? SVO_I_FIT_HARDWARE : SVO_I_FIT_NAMED;
}

static svo_status open_for(const svo_device *device, const svo_i_memory *memory, svo_gl_context **out,
                           svo_message *message)
{
    search s = {.device = device, .memory = memory};
    bool software[SVO_I_EGL_DEVICES_MAX] = {false};
    uint32_t egl_devices = 0;
    (void)svo_i_egl_find_software(software, SVO_I_EGL_DEVICES_MAX, &egl_devices, NULL); /* else there are none */
    const size_t count = svo_i_candidates_list(software, egl_devices, s.candidates);
    const size_t best = svo_i_candidates_choose(s.candidates, count, most_of(device), try_candidate, &s);
    for (size_t i = 0; i < count; ++i) {
        if (i != best) {
            svo_gl_context_destroy(&s.contexts[i]);
        }
    }
    if (best < count) {
        *out = s.contexts[best];
        return SVO_OK;
    }
    return s.failed != SVO_OK ? svo_i_fail(message, s.failed, "%s", s.failure.text)
                              : svo_i_fail(message, SVO_NO_GL, FUNCTION ": no OpenGL context: %.900s", s.list.text);
}

/* ---- contexts by name ---- */

/*
 * Chooses an EGL device by name. EGL names a device by its driver, if at all; only a context knows the renderer. So
 * this creates a context on each device and compares its renderer.
 */

#define GPU "gpu"

static bool matches(const svo_gl_context *context, const char *device_name)
{
    if (strcasecmp(device_name, GPU) == 0) {
        return !svo_i_gl_is_software(&context->functions);
    }
    return svo_i_text_contains(context->functions.renderer, device_name);
}

/* Whether the name is an index, and which. */
static bool is_index(const char *device_name, uint32_t *index)
{
    unsigned value = 0;
    char rest = '\0';
    const bool found = strspn(device_name, "0123456789") == strlen(device_name) && strlen(device_name) <= 9 &&
                       sscanf(device_name, "%u%c", &value, &rest) == 1;
    *index = value;
    return found;
}

/* Appends "; 1: words" to a list, cut when it is full. */
static void add_line(svo_message *list, uint32_t index, const char *words)
{
    const size_t used = strlen(list->text);
    (void)snprintf(list->text + used, sizeof list->text - used, "%s%u: %s", used > 0 ? "; " : "", index, words);
}

/* *out: the device's context if it matches. Otherwise NULL, and a line of the list names its renderer or the failure.
   Fails where a next device would fail too; the list has the reason then. */
static svo_status try_device(uint32_t index, const char *device_name, const svo_i_memory *memory, svo_gl_context **out,
                             svo_message *list)
{
    svo_message reason = {""};
    svo_gl_context *context = NULL;
    const svo_status status = svo_i_gl_context_open(SVO_GL_EGL_DEVICE, index, memory, &context, &reason);
    if (status == SVO_OUT_OF_HOST_MEMORY) {
        *list = reason;
        return status;
    }
    if (status != SVO_OK) {
        const char *words = strstr(reason.text, ": ");
        add_line(list, index, words != NULL ? words + 2 : reason.text);
    } else if (!matches(context, device_name)) {
        add_line(list, index, context->functions.renderer);
        svo_gl_context_destroy(&context);
    }
    *out = context;
    return SVO_OK;
}

static svo_status open_named(const char *device_name, const svo_i_memory *memory, svo_gl_context **out,
                             svo_message *message)
{
    uint32_t index = 0;
    if (is_index(device_name, &index)) {
        return svo_i_gl_context_open(SVO_GL_EGL_DEVICE, index, memory, out, message);
    }
    svo_message list = {""};
    uint32_t count = 0;
    SVO_I_TRY(svo_i_egl_count_devices(&count, message));
    for (index = 0; index < count; ++index) {
        svo_gl_context *context = NULL;
        const svo_status status = try_device(index, device_name, memory, &context, &list);
        if (status != SVO_OK) {
            return svo_i_fail(message, status, "%s", list.text);
        }
        if (context != NULL) {
            *out = context;
            return SVO_OK;
        }
    }
    return svo_i_fail(message, SVO_NO_GL, FUNCTION ": no EGL device matches \"%.200s\"; found: %.700s", device_name,
                      count > 0 ? list.text : "none");
}

/* ---- contexts by options ---- */

/* device_name and device choose by themselves. NULL: nothing contradicts, else the two fields that do. */
static const char *find_contradiction(const svo_gl_context_options *asked)
{
    if (asked->device != NULL) {
        return asked->device_name != NULL          ? "device and options.device_name"
               : asked->device_index != 0          ? "device and options.device_index"
               : asked->kind != SVO_GL_SURFACELESS ? "device and options.kind"
                                                   : NULL;
    }
    if (asked->device_name != NULL) {
        return asked->device_index != 0 ? "device_name and options.device_index"
               : asked->kind != SVO_GL_SURFACELESS && asked->kind != SVO_GL_EGL_DEVICE ? "device_name and options.kind"
                                                                                       : NULL;
    }
    return asked->device_index != 0 && asked->kind != SVO_GL_EGL_DEVICE ? "device_index and options.kind" : NULL;
}

static svo_status check_options(const svo_gl_context_options *asked, svo_message *message)
{
    const char *contradiction = find_contradiction(asked);
    if ((unsigned)asked->kind >= SVO_GL_CONTEXT_KINDS && asked->kind != SVO_GL_WRAPPED) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, FUNCTION ": options.kind %d is not below %d, nor %d",
                          (int)asked->kind, SVO_GL_CONTEXT_KINDS, SVO_GL_WRAPPED);
    }
    if (contradiction != NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT,
                          FUNCTION
                          ": options.%s contradict each other (kind \"%s\", device_index %u, device_name %.200s)",
                          contradiction, svo_name(SVO_NAME_GL_CONTEXT_KIND, asked->kind), asked->device_index,
                          asked->device_name != NULL ? asked->device_name : "NULL");
    }
    if (asked->device_name != NULL && asked->device_name[0] == '\0') {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, FUNCTION ": options.device_name is empty");
    }
    if ((asked->get_proc_address != NULL) != (asked->kind == SVO_GL_WRAPPED)) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, FUNCTION ": options.get_proc_address is %s with kind \"%s\"",
                          asked->get_proc_address != NULL ? "given" : "NULL",
                          svo_name(SVO_NAME_GL_CONTEXT_KIND, asked->kind));
    }
    return SVO_OK;
}

svo_status svo_gl_context_create(const svo_gl_context_options *options, svo_gl_context **out, svo_message *message)
{
    svo_gl_context_options asked;
    svo_i_memory memory;
    if (out == NULL) {
        return svo_i_fail(message, SVO_INVALID_ARGUMENT, FUNCTION ": out is NULL");
    }
    SVO_I_TRY(svo_i_struct_read(message, FUNCTION, "options", options, &asked,
                                SVO_I_STRUCT_SIZES(svo_gl_context_options, memory)));
    SVO_I_TRY(svo_i_memory_read(message, FUNCTION, "options.memory", asked.memory, &memory));
    SVO_I_TRY(check_options(&asked, message));
    if (asked.device != NULL) {
        return open_for(asked.device, &memory, out, message);
    }
    if (asked.device_name != NULL) {
        return open_named(asked.device_name, &memory, out, message);
    }
    return asked.kind == SVO_GL_WRAPPED
               ? svo_i_gl_context_wrap(asked.get_proc_address, asked.user, &memory, out, message)
               : svo_i_gl_context_open(asked.kind, asked.device_index, &memory, out, message);
}
