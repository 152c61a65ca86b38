/* SPDX-License-Identifier: MIT */
/* The front end of callers who name none. */
#ifndef SVO_LIB_BUILD_DEFAULT_FRONTEND_H
#define SVO_LIB_BUILD_DEFAULT_FRONTEND_H

#include "commands/frontend.h"

/* The front end that is given, or for NULL the device's own of OpenCL alone, made on first use and owned by the
   device. */
svo_status svo_i_default_frontend(svo_device *device, svo_frontend *given, svo_frontend **out);

#endif
