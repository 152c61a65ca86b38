/* SPDX-License-Identifier: MIT */
/*
 * The OpenGL state that svocl's calls change. context.c saves the state of a wrapped context and restores it; raster.c
 * sets the state for drawing. Both use the same lists, so everything that is changed is also restored.
 */
#ifndef SVO_GLINTEROP_CONTEXT_STATE_H
#define SVO_GLINTEROP_CONTEXT_STATE_H

#include "context/functions.h"

/* svocl uses storage block bindings 0 .. 15, or fewer if the context has fewer. Rasterization uses only 0 .. 7, the
   minimum of OpenGL 4.3. */
#define SVO_I_GL_STATE_STORAGE_BINDINGS 16
#define SVO_I_GL_STATE_CAPABILITIES_MAX 24
#define SVO_I_GL_STATE_BUFFERS          4

typedef struct svo_i_gl_state {
    GLint buffers[SVO_I_GL_STATE_BUFFERS]; /* generic bindings */
    struct {
        GLint name;
        GLint64 offset, bytes; /* bytes 0: all of the buffer */
    } storage[SVO_I_GL_STATE_STORAGE_BINDINGS];
    GLint program, vertex_array, draw_framebuffer, read_framebuffer;
    GLfloat viewport[4]; /* of viewport 0, like the scissor box */
    GLint scissor[4];
    GLboolean scissor_test;
    GLboolean capabilities[SVO_I_GL_STATE_CAPABILITIES_MAX]; /* in the order of the list in state.c */
    GLint polygon_mode[2]; /* front and back; equal in a core profile */
    GLfloat point_size;
    GLint clip_origin, clip_depth;
    GLint conservative_mode; /* GL_NV_conservative_raster_pre_snap_triangles */
} svo_i_gl_state;

/* All expect the context current. Saving and restoring leave no OpenGL error. */
void svo_i_gl_state_save(const svo_i_gl_functions *gl, svo_i_gl_state *out);
void svo_i_gl_state_restore(const svo_i_gl_functions *gl, const svo_i_gl_state *state);

/* Sets the state for drawing, except viewport, framebuffer and vertex array: filled triangles, no fragment dropped or
   moved. */
void svo_i_gl_state_set_plain(const svo_i_gl_functions *gl);

#endif
