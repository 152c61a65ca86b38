/* SPDX-License-Identifier: MIT */
/* Buffers of the tree, its BVH, its light, and of scenes. */
#include "view/memory.h"

#include <stdio.h>
#include <string.h>

static void add(view_state *state, const char *group, const char *name, uint64_t planned_bytes, uint64_t bytes)
{
    if (state->memory_count < VIEW_MEMORY_MAX && (bytes > 0 || planned_bytes > 0)) {
        view_memory *made = &state->memory[state->memory_count++];
        (void)snprintf(made->name, sizeof made->name, "%s%s", group, name);
        made->planned_bytes = planned_bytes;
        made->bytes = bytes;
    }
}

static uint64_t bytes_of(cl_mem buffer)
{
    size_t bytes = 0;
    return buffer != NULL && clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL) == CL_SUCCESS ? bytes
                                                                                                               : 0;
}

/* What the plan of a build said of a buffer that stays; 0 for a tree that was loaded. */
static uint64_t planned_of(const build_result *built, const char *name)
{
    for (size_t i = 0; i < built->buffer_count; ++i) {
        if (built->buffers[i].persistent != 0 && strcmp(built->buffers[i].name, name) == 0) {
            return built->buffers[i].bytes;
        }
    }
    return 0;
}

static void list_tree(const build_result *built, view_state *state)
{
    for (int i = 0; i < (int)SVO_TREE_BUFFER_COUNT; ++i) {
        const char *name = svo_tree_buffer_name((svo_tree_buffer)i);
        add(state, "", name, planned_of(built, name), bytes_of(svo_tree_get_buffer(built->tree, (svo_tree_buffer)i)));
    }
    add(state, "", "BVH", 0, svo_tree_ray_bytes(built->tree));
}

/* Buffers of sources are planned as 0: their sizes follow from the photons. */
static void list_light(const subject *which, view_state *state)
{
    const svo_light_options asked = {.struct_size = sizeof asked, .form = which->form};
    svo_light_info planned = SVO_LIGHT_INFO_INIT;
    svo_light_info held = SVO_LIGHT_INFO_INIT;
    if (which->lit.light == NULL || svo_light_get_info(which->lit.light, &held) != SVO_OK ||
        svo_light_plan(which->done.result.tree, &asked, &planned) != SVO_OK) {
        return;
    }
    for (int i = 0; i < (int)SVO_LIGHT_BUFFER_COUNT; ++i) {
        add(state, "light: ", svo_light_buffer_name((svo_light_buffer)i), planned.bytes[i], held.bytes[i]);
    }
}

static void list_scene(const subject *which, view_state *state)
{
    svo_scene_info held = SVO_SCENE_INFO_INIT;
    if (placed_scene(which->placed) != NULL && svo_scene_get_info(placed_scene(which->placed), &held) == SVO_OK) {
        add(state, "scene: ", "trees", 0, held.tree_bytes);
        add(state, "scene: ", "instances", 0, held.instance_bytes);
        add(state, "scene: ", "hierarchy", 0, held.hierarchy_bytes);
        add(state, "scene: ", "sorting", 0, held.sort_bytes);
    }
}

void memory_list(const subject *which, view_state *state)
{
    state->memory_count = 0;
    if (which->has_tree) {
        list_tree(&which->done.result, state);
        list_light(which, state);
    }
    list_scene(which, state);
}
