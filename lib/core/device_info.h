/* SPDX-License-Identifier: MIT */
/* Properties of OpenCL devices and platforms, for handles and for their choice. function: for the message. */
#ifndef SVO_LIB_CORE_DEVICE_INFO_H
#define SVO_LIB_CORE_DEVICE_INFO_H

#include "core/memory.h"
#include "svocl/device.h"

/* A string property, by malloc. */
svo_status svo_i_device_text(cl_device_id device, cl_device_info property, const char *function,
                             const svo_i_memory *memory, char **out, svo_message *message);
svo_status svo_i_platform_text(cl_platform_id platform, cl_platform_info property, const char *function,
                               const svo_i_memory *memory, char **out, svo_message *message);
/* A property of fixed size. */
svo_status svo_i_device_property(cl_device_id device, cl_device_info property, size_t bytes, void *out,
                                 const char *function, svo_message *message);
/* "platform: device"; the caller frees it. */
svo_status svo_i_device_full_name(cl_device_id device, const char *function, const svo_i_memory *memory, char **out,
                                  svo_message *message);

#endif
