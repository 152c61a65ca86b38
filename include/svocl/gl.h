/* SPDX-License-Identifier: MIT */
/** \file
 * The OpenGL front end (svocl::gl): the rasterizer proposes voxels, and an exact integer test in the fragment shader
 * accepts or rejects them.
 *
 * Needs desktop OpenGL 4.3 (shader storage buffers, framebuffers without attachments); the share path "host" also needs
 * 4.4 or ARB_buffer_storage. Vertices (12 bytes each) and triangles (12 bytes each) must each fit one shader storage
 * block of the context: 128 MiB on llvmpipe, 11 million of them.
 *
 * Thread-safety: a handle belongs to one thread at a time, on which its context is or can be made current. Handles are
 * independent of each other. Calls make the contexts that svocl made current and restore what was current before. The
 * caller's contexts (SVO_GL_WRAPPED) are never made current by svocl.
 *
 * A lost context, exhausted memory and nonsense from a driver end in a status. A lost context cannot be used again.
 */
#ifndef SVOCL_GL_H
#define SVOCL_GL_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/build.h"
#include "svocl/light.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Where an OpenGL context comes from. */
typedef enum svo_gl_context_kind {
    SVO_GL_SURFACELESS = 0, /**< "surfaceless": EGL_MESA_platform_surfaceless */
    SVO_GL_EGL_DEVICE, /**< "egl-device": EGL_EXT_platform_device */
    SVO_GL_OSMESA, /**< "osmesa": off-screen Mesa, loaded at run time */
    SVO_GL_CONTEXT_KINDS, /**< number of kinds that svocl makes */
    SVO_GL_WRAPPED = 100 /**< "wrapped": the caller's; a number that new kinds do not move */
} svo_gl_context_kind;

/** An OpenGL context. */
typedef struct svo_gl_context svo_gl_context;

/** What a context is. */
typedef struct svo_gl_context_info {
    size_t struct_size; /**< sizeof(svo_gl_context_info) */
    svo_gl_context_kind kind; /**< where it comes from */
    uint32_t device_index; /**< of the EGL device; 0 for other kinds */
    const char *vendor; /**< lives as long as the context */
    const char *renderer; /**< lives as long as the context */
    const char *version; /**< lives as long as the context */
    uint32_t is_software; /**< not 0: a CPU renders (llvmpipe and its like) */
} svo_gl_context_info;

/** An empty output. */
#define SVO_GL_CONTEXT_INFO_INIT SVO_STRUCT_INIT(svo_gl_context_info)

/** Any OpenGL function. */
typedef void (*svo_gl_function)(void);

/** A context's loader: returns the function of a name ("glClear"), or NULL if there is none. */
typedef svo_gl_function (*svo_gl_get_proc_address)(void *user, const char *name);

/** Options of a context: its kind, or what it should be on. */
typedef struct svo_gl_context_options {
    size_t struct_size; /**< sizeof(svo_gl_context_options) */
    const svo_memory_callbacks *memory; /**< host memory of the handle; NULL: malloc and free. OpenGL has its own */
    svo_gl_context_kind kind; /**< 0: SVO_GL_SURFACELESS, unless device_name or device choose */
    uint32_t device_index; /**< which EGL device; with SVO_GL_EGL_DEVICE */
    /** An EGL device by name: an index ("1"), "gpu" for the first device with a hardware renderer, or a part of the
     *  renderer's name in letters of either case ("nvidia"). Contexts are tried on one device after the other. NULL: no
     *  name. Not with device, device_index, or another kind. */
    const char *device_name;
    /** The OpenCL device that the context should suit best: on the GPU that clGetGLContextInfoKHR says is the device,
     *  else on a GPU of its name, else on any GPU, else in software. EGL devices are tried first, then Mesa's
     *  surfaceless platform, and OSMesa last. No further context is made when none can suit better. NULL: none. Not
     *  with any of the others. The device need not outlive the context. */
    const svo_device *device;
    svo_gl_get_proc_address get_proc_address; /**< for SVO_GL_WRAPPED, during the call only; NULL for other kinds */
    void *user; /**< passed to get_proc_address */
} svo_gl_context_options;

/** All defaults. */
#define SVO_GL_CONTEXT_OPTIONS_INIT SVO_STRUCT_INIT(svo_gl_context_options)

/** Number of EGL devices.
 *
 * \returns 0 without EGL or EGL_EXT_device_enumeration. */
SVO_API uint32_t svo_gl_egl_device_count(void);

/** Whether EGL has nothing but software renderers, by the extensions of its devices. No context is made and no display
 *  initialized, so a program can decide against OpenGL in a tenth of the time that a context takes.
 *
 * \returns 1 if EGL lists devices and each draws on the CPU; 0 otherwise, and where EGL cannot say. */
SVO_API int svo_gl_egl_is_software(void);

/** Makes an off-screen context, or takes one of the caller's. An EGL device that is a GPU is never served by a software
 *  renderer; that is an error.
 *
 * SVO_GL_WRAPPED is the caller's context, OpenGL 4.3 or later of either profile. It must be current on this thread now
 * and whenever svocl uses it: in svo_gl_create, svo_build, svo_gl_build, svo_gl_light_set_sources, svo_gl_mesh_read,
 * calls of buffers, and when what was made with it is destroyed. svo_gl_context_destroy releases the handle alone.
 *
 * Each call restores that context's state: bindings of buffers, storage blocks, program, vertex array and framebuffers,
 * viewport, scissor, capabilities, polygon mode, point size and clip control. The caller makes sure that no transform
 * feedback, query or conditional rendering is active, that the current program is not deleted, and that errors of
 * earlier OpenGL calls were read, since svocl discards those that it finds.
 *
 * \param options NULL means all defaults
 * \param out receives the context
 * \param message receives the step that failed, the devices there are when no name matches, what failed for each
 *        candidate, or the missing function or version; NULL allowed
 * \returns SVO_NO_GL, SVO_INVALID_ARGUMENT (also for options that contradict each other) or SVO_OUT_OF_HOST_MEMORY on
 *          failure. */
SVO_API svo_status svo_gl_context_create(const svo_gl_context_options *options, svo_gl_context **out,
                                         svo_message *message);

/** Destroys a context that svocl made, or the handle of a wrapped one.
 *
 * \param context set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_gl_context_destroy(svo_gl_context **context);

/** Describes a context.
 *
 * \param context not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_gl_context_get_info(const svo_gl_context *context, svo_gl_context_info *info);

/** svo_mesh_read for OpenGL buffers. Writes by earlier OpenGL commands are visible, whatever kind they were.
 *
 * \param buffers where the arrays are
 * \param context owns the buffers
 * \param num_wait number of events in wait
 * \param wait OpenCL events that the host waits for first, of work that writes to shared buffers for example; NULL when
 *        num_wait is 0
 * \param out receives the mesh
 * \param message receives the reason for a failure; NULL allowed
 * \returns SVO_INVALID_ARGUMENT (also for a name that is no buffer), SVO_NO_GL, SVO_GL_ERROR, SVO_CL_ERROR or
 *          SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_gl_mesh_read(const svo_mesh_buffers *buffers, svo_gl_context *context, cl_uint num_wait,
                                    const cl_event *wait, svo_mesh_copy **out, svo_message *message);

/** Makes a device handle whose OpenCL context was made against the OpenGL context, where the device can share with it
 *  (cl_khr_gl_sharing), else a plain one. svo_gl_share_reason says which and why. An OpenCL context of the caller's
 *  that was made against OpenGL serves as well, through svo_device_create.
 *
 * \param context its OpenGL context must outlive the OpenCL context
 * \param device NULL: chosen by the options as in svo_device_create_default
 * \param options NULL means all defaults
 * \param out receives the handle
 * \param message receives the reason for a failure; NULL allowed
 * \returns what svo_device_create_default returns. */
SVO_API svo_status svo_gl_device_create(svo_gl_context *context, cl_device_id device, const svo_device_options *options,
                                        svo_device **out, svo_message *message);

/** Whether svo_gl_device_create may succeed in sharing. Starts no OpenGL.
 *
 * \param device not NULL
 * \returns not 0 if the device lists cl_khr_gl_sharing. */
SVO_API int svo_gl_device_may_share(const svo_device *device);

/** How triangles are rasterized conservatively. */
typedef enum svo_gl_raster {
    SVO_GL_RASTER_AUTO = 0, /**< "auto": hardware where it works, else expansion */
    SVO_GL_RASTER_EXPAND, /**< "gl-expand": the vertex shader moves each triangle's edges outwards */
    SVO_GL_RASTER_HW, /**< "gl-hw": GL_NV_conservative_raster with pre-snap, or GL_INTEL_conservative_rasterization */
    /** "gl-hybrid": triangles of many columns of voxels are rasterized, by hardware where it works and else by
     *  expansion, and the kernels of svo_frontend_create_cl add the others to the same list. The tree is the same.
     *  svo_build_enqueue and updatable plans, which do not wait, use the kernels alone. */
    SVO_GL_RASTER_HYBRID
} svo_gl_raster;

/** How the fragment list gets from OpenGL to OpenCL. */
typedef enum svo_gl_share {
    SVO_GL_SHARE_AUTO = 0, /**< "auto": the first of the following that works */
    SVO_GL_SHARE_INTEROP, /**< "interop": cl_khr_gl_sharing */
    SVO_GL_SHARE_HOST, /**< "host": OpenCL reads the persistently mapped OpenGL buffer in place; CPU devices */
    SVO_GL_SHARE_COPY /**< "copy": through host memory */
} svo_gl_share;

/** Options of a pair of device and context. */
typedef struct svo_gl_options {
    size_t struct_size; /**< sizeof(svo_gl_options) */
    svo_gl_raster raster; /**< a forced choice that does not work is an error, never a fallback */
    svo_gl_share share; /**< a forced choice that does not work is an error, never a fallback */
    uint32_t no_int64; /**< not 0: two-word integers in shaders even with ARB_gpu_shader_int64. For tests */
    /** SVO_GL_RASTER_HYBRID: triangles whose projection along their main axis has a bounding box of more columns of
     *  voxels are rasterized. UINT32_MAX: none are. 0: 64, and UINT32_MAX for renderers in software. Refused with
     *  another raster */
    uint32_t hybrid_columns;
} svo_gl_options;

/** All defaults. */
#define SVO_GL_OPTIONS_INIT SVO_STRUCT_INIT(svo_gl_options)

/** The OpenGL side of a pair of device and context. */
typedef struct svo_gl svo_gl;

/** Probes front ends and share paths of a pair of device and context.
 *
 * \param device must outlive the result
 * \param context must outlive the result
 * \param options NULL means all defaults
 * \param out receives the pair
 * \returns SVO_UNSUPPORTED, with the reason in svo_device_message, when a forced choice does not work or a limit of the
 *          context is too low; SVO_NO_GL, SVO_GL_ERROR, SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY. */
SVO_API svo_status svo_gl_create(svo_device *device, svo_gl_context *context, const svo_gl_options *options,
                                 svo_gl **out);

/** Destroys a pair. Device and context live on.
 *
 * \param gl set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_gl_destroy(svo_gl **gl);

/** The front end of a pair, for svo_build. svo_frontend_name is that of the svo_gl_raster that the pair has chosen, and
 *  svo_frontend_share that of the svo_gl_share.
 *
 * \param gl not NULL
 * \returns the front end, owned by gl. */
SVO_API svo_frontend *svo_gl_frontend(svo_gl *gl);

/** The faster front end of a pair, by a rule of thumb: software renderers are slower than OpenCL alone, and so is a
 *  list that goes through the host to a GPU. Nothing is run. See also svo_frontend_cl_suffices.
 *
 * \param gl not NULL
 * \param cl front end of svo_frontend_create_cl on the same device
 * \param reason receives one line; NULL allowed
 * \returns that of gl, or cl. */
SVO_API svo_frontend *svo_gl_prefer(svo_gl *gl, svo_frontend *cl, svo_message *reason);

/** Why a kind of rasterization does not work on a pair.
 *
 * \param gl not NULL
 * \param raster not AUTO
 * \returns "" if it works. Static or owned by gl. */
SVO_API const char *svo_gl_raster_reason(const svo_gl *gl, svo_gl_raster raster);

/** Why a share path does not work on a pair.
 *
 * \param gl not NULL
 * \param share not AUTO
 * \returns "" if it works. Static or owned by gl. */
SVO_API const char *svo_gl_share_reason(const svo_gl *gl, svo_gl_share share);

/** A buffer that OpenCL writes and OpenGL reads: a picture of svo_render, hits, whatever kernels make. Or one that
 *  OpenGL writes and svo_gl_plan_update reads.
 *
 *     svo_gl_buffer_to_cl(buffer, queue);
 *     svo_submit submit = {.queue = queue, .event = &drawn};
 *     svo_render(svo_tree_target(tree), &options, svo_in_buffer(info.memory), &submit);
 *     svo_gl_buffer_to_gl(buffer, width * height * 4, queue, 1, &drawn);
 *     glBindBuffer(GL_PIXEL_UNPACK_BUFFER, info.name);
 *     glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, (void *)info.offset_bytes);
 */
typedef struct svo_gl_buffer svo_gl_buffer;

/** What a buffer is; nothing of it changes. */
typedef struct svo_gl_buffer_info {
    size_t struct_size; /**< sizeof(svo_gl_buffer_info) */
    svo_gl_share share; /**< the way its bytes take, never AUTO */
    uint32_t name; /**< of the OpenGL buffer, which the caller neither maps, resizes nor deletes */
    size_t offset_bytes; /**< where the bytes begin in it: 0, but for "host" where OpenCL aligns memory more coarsely */
    size_t bytes; /**< as asked for */
    cl_mem memory; /**< the OpenCL buffer, owned by the handle: use it between svo_gl_buffer_to_cl and _to_gl alone */
} svo_gl_buffer_info;

/** An empty output. */
#define SVO_GL_BUFFER_INFO_INIT SVO_STRUCT_INIT(svo_gl_buffer_info)

/** Makes a buffer. Which ways work is tried first, in both directions, as by svo_gl_create. With "interop" it is one
 *  buffer of both APIs, with "host" OpenCL uses memory that OpenGL has mapped, with "copy" the device writes its bytes
 *  into mapped OpenGL memory once they are finished.
 *
 * \param device must outlive the result
 * \param context must outlive the result
 * \param bytes not 0, at most what both APIs allocate and a storage block of the context holds
 * \param share AUTO: the first way that works; a forced choice that does not work is an error, never a fallback
 * \param out receives the buffer, of undefined content, OpenGL's at first, which the caller destroys
 * \returns SVO_UNSUPPORTED with the reason in svo_device_message, SVO_OUT_OF_DEVICE_MEMORY, SVO_NO_GL, SVO_GL_ERROR,
 *          SVO_CL_ERROR, SVO_INVALID_ARGUMENT or SVO_OUT_OF_HOST_MEMORY on failure. */
SVO_API svo_status svo_gl_buffer_create(svo_device *device, svo_gl_context *context, size_t bytes, svo_gl_share share,
                                        svo_gl_buffer **out);

/** Destroys a buffer. No command in flight may use it.
 *
 * \param buffer set to NULL; NULL and a pointer to NULL are allowed */
SVO_API void svo_gl_buffer_destroy(svo_gl_buffer **buffer);

/** Describes a buffer.
 *
 * \param buffer not NULL
 * \param info receives the description
 * \returns SVO_INVALID_ARGUMENT when info is NULL or its struct_size is too small. */
SVO_API svo_status svo_gl_buffer_get_info(const svo_gl_buffer *buffer, svo_gl_buffer_info *info);

/** Why a way does not work for a buffer.
 *
 * \param buffer not NULL
 * \param share not AUTO
 * \returns "" if it works. Owned by buffer. */
SVO_API const char *svo_gl_buffer_share_reason(const svo_gl_buffer *buffer, svo_gl_share share);

/** Gives a buffer to OpenCL, after what OpenGL reads of it by earlier commands. Bytes that were there stay.
 *
 * \param buffer not NULL
 * \param queue on the device's context; NULL: the device's own
 * \returns SVO_INVALID_ARGUMENT, SVO_NO_GL, SVO_GL_ERROR or SVO_CL_ERROR on failure. */
SVO_API svo_status svo_gl_buffer_to_cl(svo_gl_buffer *buffer, cl_command_queue queue);

/** Gives a buffer to OpenGL: waits for OpenCL, then every later OpenGL command sees the bytes.
 *
 * \param buffer after svo_gl_buffer_to_cl
 * \param used_bytes how many of its first bytes OpenGL will read, at most all
 * \param queue on the device's context; NULL: the device's own. Commands of this queue are waited for if it is in-order
 * \param num_wait number of events in wait
 * \param wait events of that context to wait for; NULL when num_wait is 0
 * \returns SVO_INVALID_ARGUMENT, SVO_NO_GL, SVO_GL_ERROR or SVO_CL_ERROR on failure; the buffer then stays OpenCL's. */
SVO_API svo_status svo_gl_buffer_to_gl(svo_gl_buffer *buffer, size_t used_bytes, cl_command_queue queue,
                                       cl_uint num_wait, const cl_event *wait);

/** svo_plan_update for vertices that OpenGL has written: by a compute shader, transform feedback or an upload, in
 *  commands before the call. The buffers are OpenGL's before and after.
 *
 *     const svo_submit submit = {.queue = queue};
 *     svo_gl_plan_update(plan, positions, NULL, &submit);
 *     svo_build_enqueue(workspace, tree, &submit);
 *
 * With submit and "interop" nothing is waited for where the device has cl_khr_gl_event: OpenGL's later commands on this
 * thread wait for the update. Elsewhere, and with "host" and "copy", the call waits for OpenGL and until the update has
 * ended.
 *
 * \param plan with options.updatable, of floats; of the buffers' device
 * \param positions not NULL: 3 floats per vertex, packed, from the buffer's offset_bytes on
 * \param normals the same, where the plan reads normals; else NULL. Of the context and share of positions
 * \param submit NULL: the device's own queue, and the call waits
 * \returns what svo_plan_update returns, and SVO_NO_GL or SVO_GL_ERROR. */
SVO_API svo_status svo_gl_plan_update(svo_plan *plan, svo_gl_buffer *positions, svo_gl_buffer *normals,
                                      const svo_submit *submit);

/** svo_build by compute shaders. The list is drawn by gl's front end and stays in OpenGL, where nodes, lists and
 *  payload are made; only the finished arrays go to OpenCL. The tree is the same, bit for bit. It serves to compare the
 *  two APIs of a device stage by stage, and is not made to be faster than svo_build.
 *
 * Parameters and guarantees are those of svo_build. The report's builder is "gl-compute" and its share "none". Stages
 * between voxelize and the last transfer are timed by timer queries ("gl-timer"), on llvmpipe by the wall clock up to
 * glFinish.
 *
 * \param gl not NULL
 * \param plan with SVO_BUILDER_CL, of gl's device
 * \param queue as for svo_build
 * \param out receives the tree
 * \param report NULL allowed
 * \returns what svo_build returns. Arrays may exceed a shader storage block of the context. SVO_UNSUPPORTED when the
 *          inner nodes exceed its bytes, texels seven blocks or the triangles of a node's children an eighth of its
 *          bytes where there are materials; or when a voxel has more triangles than the driver allows loop iterations
 *          (some two million on llvmpipe for SVO_NEED_RAYS). The message says by how much. */
SVO_API svo_status svo_gl_build(svo_gl *gl, svo_plan *plan, cl_command_queue queue, svo_tree **out,
                                svo_build_report *report);

/** Why svo_gl_build cannot make trees with these needs on a pair. It requires 16 bindings of storage blocks; payload
 *  requires 16 blocks per compute shader and GL_ARB_gpu_shader_int64.
 *
 * \param gl not NULL
 * \param need svo_need bits; 0: nodes alone
 * \returns "" if it can. Owned by gl, valid until the next call. */
SVO_API const char *svo_gl_build_reason(svo_gl *gl, uint32_t need);

/** svo_light_set_sources whose light views are rasterized. Each pixel of a view takes the nearest triangle at its
 *  center and the point where the pixel's ray meets it; from there on, photons are those of svo_light_set_sources. Flux
 *  is summed as exactly, but which triangle has a pixel on an edge depends on the driver, so the light's hash does too.
 *
 * Views of more columns than a framebuffer of the context has are refused.
 *
 * \param gl not NULL
 * \param light of gl's device; its tree has SVO_NEED_RAYS and is not of coverage thin
 * \param setup as for svo_light_set_sources
 * \param queue as for svo_light_set_sources
 * \returns what svo_light_set_sources returns; SVO_NO_GL, SVO_GL_ERROR; SVO_UNSUPPORTED when the tree has no triangles
 *          or a limit of the context is too low. */
SVO_API svo_status svo_gl_light_set_sources(svo_gl *gl, svo_light *light, const svo_light_setup *setup,
                                            cl_command_queue queue);

#ifdef __cplusplus
}
#endif

#endif
