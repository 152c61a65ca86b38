/* SPDX-License-Identifier: MIT */
/* Orders the candidates for a context and chooses among them. */
#include "context/candidates.h"

#include "context/library.h"

bool svo_i_egl_device_is_software(const char *extensions)
{
    return svo_i_list_has_token(extensions, "EGL_MESA_device_software");
}

/* A device with a kernel driver is a GPU. Mesa's software device has none and lists an extension that says so. */
bool svo_i_egl_device_is_gpu(const char *extensions)
{
    return !svo_i_egl_device_is_software(extensions) && (svo_i_list_has_token(extensions, "EGL_EXT_device_drm") ||
                                                         svo_i_list_has_token(extensions, "EGL_NV_device_cuda"));
}

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
