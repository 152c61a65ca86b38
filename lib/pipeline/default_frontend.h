/* SPDX-License-Identifier: MIT */
/* The front end of a build whose caller passes NULL. */
#ifndef SVO_LIB_PIPELINE_DEFAULT_FRONTEND_H
#define SVO_LIB_PIPELINE_DEFAULT_FRONTEND_H

#include "commands/frontend.h"

/* *out: given, or if that is NULL the device's own front end "cl", which is created on first use and owned by the
   device. */
svo_status svo_i_default_frontend(svo_device *device, svo_frontend *given, svo_frontend **out);

#endif
