/* SPDX-License-Identifier: MIT */
/* Sizes of buffers by OpenCL, plans by the library. */
#include "view/memory.h"

#include <stdio.h>
#include <string.h>

/* prefix: "" or what the buffer is part of, with a space. */
static void add(view_state *state, const char *prefix, const char *name, uint64_t planned_bytes, uint64_t bytes)
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

/* ---- trees ---- */

/* plan: NULL: the tree was loaded. */
static uint64_t planned_bytes(const svo_plan *plan, const char *name)
{
    const size_t count = plan != NULL ? svo_plan_buffer_count(plan) : 0;
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
        const char *name = svo_tree_buffer_name((svo_tree_buffer)i);
        const uint64_t bytes = bytes_of(svo_tree_get_buffer(tree, (svo_tree_buffer)i));
        add(state, prefix, name, bytes > 0 ? planned_bytes(plan, name) : 0, bytes);
    }
}

static int list_tree(const subject *which, view_state *state)
{
    const job *done = &which->done;
    svo_plan *plan = NULL;
    if (done->source.mesh != NULL) {
        const uint32_t need = lighting_need(&which->running->options, &done->source);
        const int exit_code = job_plan(which->running, done->opened.device, &done->source, need, &plan);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
    }
    list_arrays(done->result.tree, "", plan, state);
    add(state, "", "BVH", 0, svo_tree_ray_bytes(done->result.tree));
    svo_plan_destroy(&plan);
    return PROGRAM_DONE;
}

/* ---- lights ---- */

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
        add(state, "light ", svo_light_buffer_name((svo_light_buffer)i), planned.bytes[i], held.bytes[i]);
    }
}

/* ---- scenes ---- */

static void list_scene(const subject *which, view_state *state)
{
    svo_scene_info held = SVO_SCENE_INFO_INIT;
    svo_scene_info planned = SVO_SCENE_INFO_INIT;
    if (svo_scene_get_info(placed_scene(which->placed), &held) == SVO_OK &&
        placed_plan(which->placed, state, &planned) == SVO_OK) {
        add(state, "scene ", "trees", planned.tree_bytes, held.tree_bytes);
        add(state, "scene ", "instances", planned.instance_bytes, held.instance_bytes);
        add(state, "scene ", "hierarchy", planned.hierarchy_bytes, held.hierarchy_bytes);
        add(state, "scene ", "sort", planned.sort_bytes, held.sort_bytes);
    }
}

/* ---- what moves ---- */

static void list_film(const subject *which, view_state *state)
{
    svo_moving_info info = SVO_MOVING_INFO_INIT;
    if (svo_moving_get_info(which->film.moving.moving, &info) == SVO_OK) {
        list_arrays(film_tree(&which->film), "moving ", NULL, state);
        add(state, "moving ", "lists", 0, info.list_bytes);
    }
}

/* ---- probes ---- */

static void list_probes(const subject *which, view_state *state)
{
    const svo_probe_info *planned = &which->probes.plan;
    const svo_probe_info *made = &state->probes.made;
    for (int i = 0; i < SVO_PROBES_BUFFER_COUNT && made->probe_count > 0; ++i) {
        add(state, "probes ", svo_probes_buffer_name((svo_probes_buffer)i), planned->bytes[i], made->bytes[i]);
    }
}

int memory_list(const subject *which, view_state *state)
{
    state->memory_count = 0;
    const int exit_code = which->has_tree ? list_tree(which, state) : PROGRAM_DONE;
    if (which->has_tree && which->is_lit) {
        list_light(which, state);
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
