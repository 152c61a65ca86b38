/* SPDX-License-Identifier: MIT */
/* The public functions that all front ends share. */
#include "commands/frontend.h"

#include "plan/arrays.h"

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

svo_status svo_i_frontend_voxelize(svo_frontend *frontend, svo_i_commands *commands, const svo_i_chunking *chunking,
                                   svo_i_fragment_list *list)
{
    if (!frontend->on_device) {
        SVO_I_TRY(svo_i_plan_copy_to_host(commands->plan));
    }
    return frontend->voxelize(frontend->self, commands, chunking, list);
}
