/* SPDX-License-Identifier: MIT */
/* The public functions that all front ends share. */
#include "commands/frontend.h"

void svo_frontend_destroy(svo_frontend **frontend)
{
    if (frontend == NULL || *frontend == NULL) {
        return;
    }
    if ((*frontend)->destroy != NULL) {
        (*frontend)->destroy((*frontend)->self);
    }
    *frontend = NULL;
}

const char *svo_frontend_name(const svo_frontend *frontend)
{
    return frontend->name;
}

const char *svo_frontend_share(const svo_frontend *frontend)
{
    return frontend->share;
}
