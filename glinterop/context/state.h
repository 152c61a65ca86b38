/* SPDX-License-Identifier: MIT */
/*
 * The OpenGL state that svocl's calls change: saved when a caller's own context is taken over and put back when it is
 * given up (context.c), and set to what drawing expects (raster.c). One list of each thing, so that nothing is changed
 * which is not restored.
 */
#ifndef SVO_GLINTEROP_CONTEXT_STATE_H
#define SVO_GLINTEROP_CONTEXT_STATE_H

#include "context/functions.h"

/* Storage blocks at bindings 0 .. 15 are svocl's to use, as far as the context has so many: the shaders that rasterize
   keep to 0 .. 7, the fewest that OpenGL 4.3 has. */
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
    GLfloat viewport[4]; /* of viewport 0, as the scissor box */
    GLint scissor[4];
    GLboolean scissor_test;
    GLboolean capabilities[SVO_I_GL_STATE_CAPABILITIES_MAX]; /* by the list in state.c */
    GLint polygon_mode[2]; /* front, back: the same in a core profile */
    GLfloat point_size;
    GLint clip_origin, clip_depth;
    GLint conservative_mode; /* GL_NV_conservative_raster_pre_snap_triangles */
} svo_i_gl_state;

/* All expect the context current. Saving and restoring leave no error of their own. */
void svo_i_gl_state_save(const svo_i_gl_functions *gl, svo_i_gl_state *out);
void svo_i_gl_state_restore(const svo_i_gl_functions *gl, const svo_i_gl_state *state);

/* What drawing expects besides viewport, framebuffer and vertex array: every fragment of every triangle, filled, at the
   pixel where it belongs. */
void svo_i_gl_state_set_plain(const svo_i_gl_functions *gl);

#endif
