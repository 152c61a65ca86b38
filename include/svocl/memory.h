/* SPDX-License-Identifier: MIT */
/** \file
 * Host memory by the caller's functions. Options name them: those of a device handle serve the handle and all that is
 * made from it, and those of a call without a handle what the call makes (a loaded tree, an import, a mesh that is
 * read, an OpenGL context). NULL in their place means malloc and free. docs/integration.md lists what memory goes
 * another way.
 *
 * Each block goes back to the functions that made it, whatever handle it was handed to. So functions and user must
 * stay valid until everything that was made with them is destroyed; with max_device_bytes also until the driver has
 * destroyed the handle's buffers, which may be later.
 *
 * Thread-safety: the library calls them on the threads that call the library, and with max_device_bytes release also
 * on threads of the driver. Functions that serve several threads at once, or such a handle, must be thread-safe. They
 * must return, and must not call the library.
 */
#ifndef SVOCL_MEMORY_H
#define SVOCL_MEMORY_H

#include <stddef.h>

#include "svocl/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Allocates a block.
 *
 * \param user as given
 * \param bytes above 0. Bookkeeping of the library, 32 bytes in each block, is included
 * \param alignment in bytes, a power of two; 16 at present
 * \returns the block, whose contents may be anything; NULL ends the call that needs it in SVO_OUT_OF_HOST_MEMORY, or
 *          in doing without it. */
typedef void *(*svo_allocate_callback)(void *user, size_t bytes, size_t alignment);

/** Releases a block.
 *
 * \param user as given
 * \param block what svo_allocate_callback returned; never NULL
 * \param bytes as it was allocated
 * \param alignment as it was allocated */
typedef void (*svo_release_callback)(void *user, void *block, size_t bytes, size_t alignment);

/** Where host memory comes from. The struct is copied; it need not outlive the call that it is given to. */
typedef struct svo_memory_callbacks {
    size_t struct_size; /**< sizeof(svo_memory_callbacks) */
    svo_allocate_callback allocate; /**< not NULL */
    svo_release_callback release; /**< not NULL */
    void *user; /**< passed to both */
} svo_memory_callbacks;

/** No functions yet: set both. */
#define SVO_MEMORY_CALLBACKS_INIT SVO_STRUCT_INIT(svo_memory_callbacks)

#ifdef __cplusplus
}
#endif

#endif
