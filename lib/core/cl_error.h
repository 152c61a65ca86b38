/* SPDX-License-Identifier: MIT */
/* Failed calls of OpenCL, in messages. */
#ifndef SVO_LIB_CORE_CL_ERROR_H
#define SVO_LIB_CORE_CL_ERROR_H

#include "core/message.h"
#include "svocl/device.h"

SVO_I_SHARED_BEGIN

/* "function: clCall failed with CL_NAME (-n)"; out-of-memory errors become SVO_OUT_OF_DEVICE_MEMORY. message: NULL
   allowed. */
svo_status svo_i_fail_cl(svo_message *message, const char *function, const char *call, cl_int error);
/* "CL_OUT_OF_RESOURCES", ...; static string. */
const char *svo_i_cl_error_name(cl_int error);

SVO_I_SHARED_END

#endif
