/* SPDX-License-Identifier: MIT */
/*
 * The OpenGL front end (svocl::gl): the rasterizer proposes voxels, an exact integer test in the fragment shader
 * decides.
 *
 * Needs desktop OpenGL 4.3 (compute-era: shader storage buffers, framebuffers without attachments), and 4.4 or
 * ARB_buffer_storage for the host share. Vertices (12 bytes each) and triangles (12 bytes each) must each fit one
 * shader storage block of the context (128 MiB on llvmpipe: 11 million). Entry points are a table per context, filled
 * through the context's own loader.
 *
 * Thread-safety: a handle belongs to one thread at a time, the one on which its context is or can be made current;
 * different handles are independent. Contexts that svocl made are made current by the calls that need them; what was
 * current before is current again afterwards. Contexts of the caller's (svo_gl_context_wrap) are never made current.
 *
 * A context that is lost, memory that runs out and a driver that returns nonsense end in a status; a lost context
 * cannot be used again.
 */
#ifndef SVOCL_GL_H
#define SVOCL_GL_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/build.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum svo_gl_context_kind {
    SVO_GL_SURFACELESS = 0, /* EGL_MESA_platform_surfaceless */
    SVO_GL_EGL_DEVICE, /* EGL_EXT_platform_device */
    SVO_GL_OSMESA, /* off-screen Mesa, loaded at run time */
    SVO_GL_CONTEXT_KINDS, /* how many kinds svo_gl_context_create makes */
    SVO_GL_WRAPPED /* the caller's own: svo_gl_context_wrap */
} svo_gl_context_kind;
SVO_API const char *
svo_gl_context_kind_name(svo_gl_context_kind kind); /* "surfaceless", "egl-device", "osmesa", "wrapped" */

typedef struct svo_gl_context svo_gl_context;

typedef struct svo_gl_context_info {
    size_t struct_size; /* sizeof(svo_gl_context_info) */
    svo_gl_context_kind kind;
    uint32_t device_index; /* EGL device number; 0 otherwise */
    const char *vendor, *renderer, *version; /* live as long as the context */
    uint32_t is_software; /* not 0: a processor renders (llvmpipe and its like) */
} svo_gl_context_info;
#define SVO_GL_CONTEXT_INFO_INIT SVO_STRUCT_INIT(svo_gl_context_info)

/* EGL devices there are; 0 without EGL or EGL_EXT_device_enumeration. */
SVO_API uint32_t svo_gl_egl_device_count(void);

/*
 * Makes an off-screen context. device_index: which EGL device, for SVO_GL_EGL_DEVICE only. An EGL device that is a GPU
 * is never served by a software renderer: that is an error.
 * Returns SVO_NO_GL with the step that failed in the message.
 */
SVO_API svo_status svo_gl_context_create(svo_gl_context_kind kind, uint32_t device_index, svo_gl_context **out,
                                         svo_message *message);
/*
 * The same for an EGL device by name: its index ("1"), "gpu" for the first that renders on no processor, or a part of
 * its renderer's name, in letters of either case ("nvidia"). Contexts are made on the devices in turn until one
 * matches.
 * Returns SVO_NO_GL with what there is in the message, or SVO_INVALID_ARGUMENT.
 */
SVO_API svo_status svo_gl_context_create_named(const char *device_name, svo_gl_context **out, svo_message *message);

typedef void (*svo_gl_function)(void); /* any entry point */
/* A context's loader; name includes the "gl". NULL where there is no such function. */
typedef svo_gl_function (*svo_gl_get_proc_address)(void *user, const char *name);

/*
 * Takes a context of the caller's, OpenGL 4.3 or later of either profile, which must be current on this thread now and
 * whenever svocl uses it: in svo_gl_create, svo_build, svo_gl_build, svo_gl_mesh_read and the destruction of what was
 * made with it. svo_gl_context_destroy releases the handle and leaves the caller's context alone.
 *
 * Each call leaves the context's state as it was: bindings of buffers, storage blocks, program, vertex array and
 * framebuffers, viewport, scissor, capabilities, polygon mode, point size, clip control. Three things are expected of
 * the
 * caller: no transform feedback, query or conditional rendering is active; a program that was deleted is not the
 * current one; OpenGL errors of earlier calls have been read, since svocl throws away what it finds.
 *
 * get_proc_address: called now alone, not NULL; user is handed to it.
 * Returns SVO_NO_GL naming the function or the version that is missing, or SVO_OUT_OF_HOST_MEMORY.
 */
SVO_API svo_status svo_gl_context_wrap(svo_gl_get_proc_address get_proc_address, void *user, svo_gl_context **out,
                                       svo_message *message);

SVO_API void svo_gl_context_destroy(svo_gl_context **context);
SVO_API svo_status svo_gl_context_get_info(const svo_gl_context *context, svo_gl_context_info *info);

/*
 * As svo_mesh_read, for buffers of OpenGL. What OpenGL commands before it write to them is seen, whatever wrote it.
 *
 * num_wait, wait: events that are waited for on the host first, of OpenCL work that writes to shared buffers, say.
 * Returns SVO_INVALID_ARGUMENT (also for a name that is no buffer), SVO_NO_GL, SVO_GL_ERROR, SVO_CL_ERROR or
 * SVO_OUT_OF_HOST_MEMORY.
 */
SVO_API svo_status svo_gl_mesh_read(const svo_mesh_buffers *buffers, svo_gl_context *context, cl_uint num_wait,
                                    const cl_event *wait, svo_mesh_copy **out, svo_message *message);

/*
 * Makes a device handle with an OpenCL context made against the OpenGL context where the device can share with it
 * (cl_khr_gl_sharing); where it cannot, with a plain one. svo_gl_share_reason says which and why. An OpenCL context of
 * your own that was made against yours serves as well: give it to svo_device_create.
 *
 * context: must outlive the device's OpenCL context. device: NULL: as svo_device_create_default chooses it by the
 * options.
 * Returns what svo_device_create_default does.
 */
SVO_API svo_status svo_gl_device_create(svo_gl_context *context, cl_device_id device, const svo_device_options *options,
                                        svo_device **out, svo_message *message);
/* Whether that is worth trying: not 0 if the device lists cl_khr_gl_sharing as a whole word. Starts no OpenGL. */
SVO_API int svo_gl_device_may_share(const svo_device *device);

typedef enum svo_gl_raster {
    SVO_GL_RASTER_AUTO = 0, /* hw where it works, else expand */
    SVO_GL_RASTER_EXPAND, /* "gl-expand": each triangle's edges are moved outwards in the vertex shader */
    SVO_GL_RASTER_HW /* "gl-hw": GL_NV_conservative_raster with pre-snap, or GL_INTEL_conservative_rasterization */
} svo_gl_raster;

typedef enum svo_gl_share {
    SVO_GL_SHARE_AUTO = 0, /* the first of the list below that works */
    SVO_GL_SHARE_INTEROP, /* "sharing": cl_khr_gl_sharing */
    SVO_GL_SHARE_HOST, /* "host": OpenCL reads the persistently mapped GL buffer in place; CPU devices */
    SVO_GL_SHARE_COPY /* "copy": through the host */
} svo_gl_share;

typedef struct svo_gl_options {
    size_t struct_size; /* sizeof(svo_gl_options) */
    svo_gl_raster raster; /* a forced choice that does not work is an error, never a fallback */
    svo_gl_share share;
    uint32_t no_int64; /* not 0: two-word integers in the shaders even where ARB_gpu_shader_int64 exists. For tests. */
} svo_gl_options;
#define SVO_GL_OPTIONS_INIT SVO_STRUCT_INIT(svo_gl_options)

typedef struct svo_gl svo_gl;

/*
 * The GL side of a pair of device and context: probes front ends and share paths.
 *
 * device and context must outlive it. options: NULL means all defaults.
 * Returns SVO_UNSUPPORTED with the reason (in svo_device_message) when the forced choice does not work.
 */
SVO_API svo_status svo_gl_create(svo_device *device, svo_gl_context *context, const svo_gl_options *options,
                                 svo_gl **out);
SVO_API void svo_gl_destroy(svo_gl **gl);

/* The front end to give to svo_build; owned by gl. */
SVO_API svo_frontend *svo_gl_frontend(svo_gl *gl);

/*
 * The faster front end on this pair: that of gl, or cl, which svo_frontend_create_cl made for the same device. A rule
 * of thumb by what the renderer is and how the list would get to OpenCL: software renderers are slower than OpenCL
 * alone, and so is a list that goes through the host to a GPU. Nothing is run. See also svo_frontend_cl_suffices.
 *
 * reason: receives one line that says why; NULL allowed.
 */
SVO_API svo_frontend *svo_gl_prefer(svo_gl *gl, svo_frontend *cl, svo_message *reason);

/* Why a way works or not on this pair: "" if it does. Static or owned by gl. raster, share: not AUTO. */
SVO_API const char *svo_gl_raster_reason(const svo_gl *gl, svo_gl_raster raster);
SVO_API const char *svo_gl_share_reason(const svo_gl *gl, svo_gl_share share);
/*
 * svo_build (build.h) by compute shaders: the list is drawn by gl's front end and stays in OpenGL, where nodes, lists
 * and payload are made of it; only the finished arrays go to OpenCL. The tree is the same, bit for bit: for devices
 * whose two APIs are to be compared, stage by stage, and no faster than svo_build where there is no reason for it to
 * be.
 *
 * The same parameters, guarantees and status codes as svo_build's, of a plan whose builder is SVO_BUILDER_CL; the
 * report's builder is "gl-compute" and its share "none", and stages between voxelize and the last transfer are timed by
 * the context's timer queries ("gl-timer"), on llvmpipe by the wall clock up to glFinish. Every array must fit a shader
 * storage block of the context, else SVO_UNSUPPORTED says which and by how much; so it does where a voxel has more
 * triangles than the driver lets an invocation go through (on llvmpipe some two million for SVO_NEED_RAYS).
 */
SVO_API svo_status svo_gl_build(svo_gl *gl, svo_plan *plan, cl_command_queue queue, svo_tree **out,
                                svo_build_report *report);
/* Why svo_gl_build cannot make trees with these needs (svo_need bits; 0: nodes alone) on this pair: "" if it can.
   Payload needs GL_ARB_gpu_shader_int64. Owned by gl, until the next call. */
SVO_API const char *svo_gl_build_reason(svo_gl *gl, uint32_t need);

/* What was chosen; never AUTO. */
SVO_API svo_gl_raster svo_gl_chosen_raster(const svo_gl *gl);
SVO_API svo_gl_share svo_gl_chosen_share(const svo_gl *gl);
SVO_API const char *svo_gl_raster_name(svo_gl_raster raster); /* "auto", "gl-expand", "gl-hw"; static */
SVO_API const char *svo_gl_share_name(svo_gl_share share); /* "auto", "sharing", "host", "copy"; static */

#ifdef __cplusplus
}
#endif

#endif
