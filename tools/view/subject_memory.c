/* SPDX-License-Identifier: MIT */
/* Buffers of trees, lights, scenes and probes, beside what plans say of them. */
#include "view/subject_memory.h"

#include <stdio.h>
#include <string.h>

#include "support/info_of.h"

/* ---- bytes on the device, by OpenCL, beside plans by the library ---- */

/* prefix: "" or what the buffer is part of, with a space. */
static void add_memory(view_state *state, const char *prefix, const char *name, uint64_t planned_bytes, uint64_t bytes)
{
    if (state->memory_count < VIEW_MEMORY_MAX && (bytes > 0 || planned_bytes > 0)) {
        view_memory *added = &state->memory[state->memory_count++];
        *added = (view_memory){.planned_bytes = planned_bytes, .bytes = bytes};
        (void)snprintf(added->name, sizeof added->name, "%s%s", prefix, name);
    }
}

static uint64_t bytes_of(cl_mem buffer)
{
    size_t bytes = 0;
    return buffer != NULL && clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL) == CL_SUCCESS ? bytes
                                                                                                               : 0;
}

/* ---- bytes of a tree ---- */

/* plan: NULL: the tree was loaded. */
static uint64_t planned_bytes(const svo_plan *plan, const char *name)
{
    const size_t count = plan != NULL ? info_of_plan(plan).buffer_count : 0;
    for (size_t i = 0; i < count; ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        if (svo_plan_get_buffer(plan, i, &buffer) == SVO_OK && strcmp(buffer.name, name) == 0) {
            return buffer.bytes;
        }
    }
    return 0;
}

static void list_arrays(const svo_tree *tree, const char *prefix, const svo_plan *plan, view_state *state)
{
    for (int i = 0; i < SVO_TREE_BUFFER_COUNT; ++i) {
        const char *name = svo_name(SVO_NAME_TREE_BUFFER, (svo_tree_buffer)i);
        const uint64_t bytes = bytes_of(svo_tree_get_buffer(tree, (svo_tree_buffer)i));
        add_memory(state, prefix, name, bytes > 0 ? planned_bytes(plan, name) : 0, bytes);
    }
}

static int list_tree(const subject *which, view_state *state)
{
    const job *done = &which->done;
    svo_plan *plan = NULL;
    if (done->source.mesh != NULL) {
        const uint32_t need = lighting_need(&which->running->options, &which->lit, &done->source);
        const int exit_code = job_plan(which->running, done->opened.device, &done->source, need, &plan);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    list_arrays(done->result.tree, "", plan, state);
    add_memory(state, "", "BVH", 0, info_of_tree(done->result.tree).ray_bytes);
    svo_plan_destroy(&plan);
    return PROGRAM_DONE;
}

/* ---- bytes of light ---- */

static void list_light(const subject *which, view_state *state)
{
    const svo_light_options asked = {.struct_size = sizeof asked, .form = which->form};
    svo_light_info planned = SVO_LIGHT_INFO_INIT;
    svo_light_info held = SVO_LIGHT_INFO_INIT;
    if (svo_light_plan(which->done.result.tree, &asked, &planned) != SVO_OK ||
        svo_light_get_info(which->lit.light, &held) != SVO_OK) {
        return;
    }
    for (int i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        add_memory(state, "light ", svo_name(SVO_NAME_LIGHT_BUFFER, (svo_light_buffer)i), planned.bytes[i],
                   held.bytes[i]);
    }
}

/* ---- bytes of a scene ---- */

static void list_scene(const subject *which, view_state *state)
{
    svo_scene_info held = SVO_SCENE_INFO_INIT;
    svo_scene_info planned = SVO_SCENE_INFO_INIT;
    if (svo_scene_get_info(placed_scene(which->placed), &held) == SVO_OK &&
        placed_plan(which->placed, state, &planned) == SVO_OK) {
        add_memory(state, "scene ", "trees", planned.tree_bytes, held.tree_bytes);
        add_memory(state, "scene ", "instances", planned.instance_bytes, held.instance_bytes);
        add_memory(state, "scene ", "hierarchy", planned.hierarchy_bytes, held.hierarchy_bytes);
        add_memory(state, "scene ", "sort", planned.sort_bytes, held.sort_bytes);
    }
}

/* ---- bytes of what moves ---- */

static void list_film(const subject *which, view_state *state)
{
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    if (svo_moving_get_info(which->film.moving.moving, &info) == SVO_OK) {
        list_arrays(film_tree(&which->film), "moving ", NULL, state);
        add_memory(state, "moving ", "lists", 0, info.list_bytes);
    }
}

/* ---- bytes of the brush, of probes, and of all ---- */

static void list_probes(const subject *which, view_state *state)
{
    const svo_probe_info *planned = &which->probes.plan;
    const svo_probe_info *made = &state->probes.made;
    for (int i = 0; i < SVO_PROBES_BUFFER_COUNT && made->probe_count > 0; ++i) {
        add_memory(state, "probes ", svo_name(SVO_NAME_PROBES_BUFFER, (svo_probes_buffer)i), planned->bytes[i],
                   made->bytes[i]);
    }
}

int subject_list_memory(const subject *which, view_state *state)
{
    state->memory_count = 0;
    const int exit_code = which->has_tree ? list_tree(which, state) : PROGRAM_DONE;
    if (which->has_tree && which->is_lit) {
        list_light(which, state);
    }
    if (which->has_tree && which->brush.mirror != NULL) {
        add_memory(state, "brush ", "nodes", 0, which->brush.mirrored.device_bytes);
    }
    if (placed_scene(which->placed) != NULL) {
        list_scene(which, state);
    }
    if (film_tree(&which->film) != NULL) {
        list_film(which, state);
    }
    list_probes(which, state);
    return exit_code;
}
