/* SPDX-License-Identifier: MIT */
/* The front end of a build whose caller passes NULL: one "cl" per device handle. */
#include "pipeline/default_frontend.h"

/* Attaches the front end to its device. */
typedef struct own_frontend {
    svo_i_attachment attachment;
    svo_frontend *frontend;
} own_frontend;

static void release_frontend(svo_i_attachment *attachment)
{
    svo_frontend_destroy(&((own_frontend *)attachment)->frontend);
    svo_i_free(attachment);
}

svo_status svo_i_default_frontend(svo_device *device, svo_frontend *given, svo_frontend **out)
{
    const svo_i_attachment *known = svo_i_attachment_find(device->attachments, release_frontend);
    if (given != NULL || known != NULL) {
        *out = given != NULL ? given : ((const own_frontend *)known)->frontend;
        return SVO_OK;
    }
    svo_frontend *frontend = NULL;
    SVO_I_TRY(svo_frontend_create_cl(device, &frontend));
    own_frontend *own = svo_i_alloc_zeroed(&device->memory, 1, sizeof *own);
    if (own == NULL) {
        svo_frontend_destroy(&frontend);
        return svo_i_device_fail(device, SVO_OUT_OF_HOST_MEMORY, "svo_frontend_create_cl: no memory for the handle");
    }
    *own = (own_frontend){.attachment.destroy = release_frontend, .frontend = frontend};
    svo_i_attachment_add(&device->attachments, &own->attachment);
    *out = frontend;
    return SVO_OK;
}
