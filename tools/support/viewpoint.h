/* SPDX-License-Identifier: MIT */
/* The camera of a picture, as --eye, --at, --up, --fov and --from place it. */
#ifndef SVOCL_TOOLS_SUPPORT_VIEWPOINT_H
#define SVOCL_TOOLS_SUPPORT_VIEWPOINT_H

#include "support/program.h"
#include "svocl/scene.h"

/* What a picture shows. */
typedef struct viewpoint_subject {
    const svo_camera *camera; /* of a file; NULL: it frames the target */
    svo_target target;
    float aspect; /* of the picture */
} viewpoint_subject;

/* Places a camera: what the options leave open is that of the file, or frames the subject, with --turntable from all
   sides. Returns the exit code. */
int viewpoint_place(program *state, const viewpoint_subject *of, svo_camera *camera);

/* Of the picture that the options ask for. */
float viewpoint_aspect(const program *state);

/* The size of a smaller picture of the same shape, whose longer side has so many pixels. */
void viewpoint_shrink(uint32_t longer, uint32_t *width, uint32_t *height);

/* A camera on its way round its target, about its up axis: frame 0 is where it stands, and frame_count would be there
   again. */
void viewpoint_turn(const svo_camera *start, unsigned frame, unsigned frame_count, svo_camera *out);

#endif
