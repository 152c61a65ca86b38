/* SPDX-License-Identifier: MIT */
/* svo_gl as the GL compute builder sees it: a front end whose list stays in OpenGL and whose trees are made there. */
#ifndef SVO_GLINTEROP_FRONTEND_LIST_H
#define SVO_GLINTEROP_FRONTEND_LIST_H

#include "build/frontend.h"
#include "context/context.h"

svo_gl_context *svo_i_gl_context_of(svo_gl *gl);
/* Made on first use, owned by gl. The owner of a chunk of its list is an svo_i_share_buffer without memory of OpenCL.
   SVO_GL_ERROR, SVO_NO_GL, SVO_OUT_OF_HOST_MEMORY. */
svo_status svo_i_gl_list_frontend(svo_gl *gl, svo_frontend **out);

#endif
