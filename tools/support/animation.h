/* SPDX-License-Identifier: MIT */
/* What moves in a scene, frame by frame: instances without a motion are the static mesh of one tree, each of the others
   is an object in it. Between frames the tree is updated, not built. */
#ifndef SVOCL_TOOLS_SUPPORT_ANIMATION_H
#define SVOCL_TOOLS_SUPPORT_ANIMATION_H

#include "support/scene_input.h"
#include "svocl/moving.h"

/* A part of the scene's mesh: an object, or the static mesh. */
typedef struct animation_actor {
    const scene_motion *motion; /* the file's; NULL: static */
    svo_mesh mesh; /* a view of the scene's arrays, but for its indices */
    uint32_t *indices; /* owned */
    uint32_t object; /* its number */
} animation_actor;

typedef struct animation {
    program *state;
    svo_device *device;
    cl_command_queue queue;
    scene_input opened;
    animation_actor still, *actors; /* what is static, and objects */
    size_t actor_count;
    svo_moving *moving;
    svo_moving_options grid;
    float first_time, last_time;
    uint64_t frame_count;
} animation;

/* Reads the surfaces of a scene that has motions, a step of the progress bar for each tree, and makes a tree by the
   options of the program: what is static, until the first update. The file's motions, the device and the queue stay the
   caller's and outlive it. Returns the exit code; on failure nothing stays open. */
int animation_open(program *state, const scene_file *file, svo_device *device, cl_command_queue queue, animation *out);
void animation_close(animation *film);

/* Of an animation by the options. */
uint64_t animation_frame_count(const program *state);

/* The time of a frame: the first and the last one are those of all motions. */
double animation_time(const animation *film, uint64_t frame);

/* Moves everything to its place in a frame. What fails leaves the tree of the frame before; the device has the words.
   report: NULL: not wanted. */
svo_status animation_update(animation *film, uint64_t frame, svo_moving_report *report);

/* The tree as it is, until the next update. */
svo_tree *animation_tree(const animation *film);

/* The file's camera, or one that frames the tree as it is, moved by the options. Returns the exit code. */
int animation_camera(const animation *film, const scene_file *file, float aspect, svo_camera *camera);

#endif
