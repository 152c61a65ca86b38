/* SPDX-License-Identifier: MIT */
/* Steps of edits: what differs of each list between two looks. */
#include "view/history.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "view/edit.h"

typedef enum part {
    PART_SOURCES = 0,
    PART_SKY,
    PART_INSTANCES,
    PART_MOVERS,
    PART_SCENE_LIGHTS,
    PART_STROKES, /* the position alone: the brush's edit holds the voxels of each */
    PARTS
} part;

static const char *const part_names[PARTS] = {"lights", "the sky", "instances", "motions", "lights", "a stroke"};
static const view_document part_documents[PARTS] = {VIEW_LIGHTS, VIEW_LIGHTS, VIEW_SCENE,
                                                    VIEW_SCENE,  VIEW_SCENE,  VIEW_VOXELS};

/* A list of the state, or a copy of one. */
typedef struct list {
    unsigned char *elements;
    size_t count, element_bytes;
} list;

/* Elements in the middle of a list that others took the place of. */
typedef struct change {
    size_t first, removed, added; /* elements */
    unsigned char *elements; /* those that were removed, then those that were added; NULL: nothing differs */
} change;

typedef struct step {
    change changes[PARTS];
    size_t bytes;
    bool was_scene, is_scene; /* before it and after it */
    unsigned versions[VIEW_DOCUMENTS]; /* after it */
} step;

struct view_history {
    list copies[PARTS]; /* as of the last look */
    step *steps;
    size_t count, capacity;
    size_t done; /* of the steps; the others were undone */
    size_t bytes; /* of the steps */
    unsigned first[VIEW_DOCUMENTS]; /* versions before the first step */
    unsigned saved[VIEW_DOCUMENTS]; /* versions that files have */
    unsigned last; /* version that was given */
    view_revisions seen;
    bool is_scene; /* as of the last look */
    bool failed; /* memory ran out: there are neither copies nor steps */
};

/* ---- lists ---- */

static list list_of(view_state *state, part which)
{
    switch (which) {
    case PART_SOURCES:
        return (list){(unsigned char *)state->sources, state->source_count, sizeof *state->sources};
    case PART_SKY:
        return (list){(unsigned char *)state->sky, 3, sizeof state->sky[0]};
    case PART_INSTANCES:
        return (list){(unsigned char *)state->instances, state->instance_count, sizeof *state->instances};
    case PART_MOVERS:
        return (list){(unsigned char *)state->movers, state->mover_count, sizeof *state->movers};
    case PART_STROKES:
        return (list){(unsigned char *)&state->brush.position, 1, sizeof state->brush.position};
    case PART_SCENE_LIGHTS:
    case PARTS:
        break;
    }
    return (list){(unsigned char *)state->scene_lights, state->scene_light_count, sizeof state->scene_lights[0]};
}

/* Movers have bytes between and behind their fields. */
static bool is_same(part which, const unsigned char *a, const unsigned char *b, size_t bytes)
{
    const size_t place = offsetof(view_mover, first);
    const size_t motion = offsetof(view_mover, motion);
    if (which != PART_MOVERS) {
        return memcmp(a, b, bytes) == 0;
    }
    const size_t pointer_bytes = sizeof(void *);
    return memcmp(a, b, sizeof(size_t)) == 0 && memcmp(a + motion, b + motion, pointer_bytes) == 0 &&
           memcmp(a + place, b + place, sizeof(scene_place)) == 0;
}

_Static_assert(offsetof(view_mover, instance) == 0, "movers begin with the instance");

/* Makes room in a list of the state, whose count becomes this. Those of the sky and of strokes are fixed, and so is the
   room of scene_lights. */
static bool resize(view_state *state, part which, size_t count)
{
    const list now = list_of(state, which);
    if (which == PART_SKY || which == PART_STROKES) {
        return true;
    }
    if (which == PART_SCENE_LIGHTS) {
        state->scene_light_count = count;
        return true;
    }
    size_t *const counts[] = {[PART_SOURCES] = &state->source_count,
                              [PART_INSTANCES] = &state->instance_count,
                              [PART_MOVERS] = &state->mover_count};
    size_t *const capacities[] = {[PART_SOURCES] = &state->source_capacity,
                                  [PART_INSTANCES] = &state->instance_capacity,
                                  [PART_MOVERS] = &state->mover_capacity};
    if (count > *capacities[which]) {
        void *larger = realloc(now.elements, count * now.element_bytes);
        if (larger == NULL) {
            return false;
        }
        *capacities[which] = count;
        if (which == PART_SOURCES) {
            state->sources = larger;
        } else if (which == PART_INSTANCES) {
            state->instances = larger;
        } else {
            state->movers = larger;
        }
    }
    *counts[which] = count;
    return true;
}

/* ---- memory ---- */

static void free_step(view_history *of, step *gone)
{
    for (int i = 0; i < PARTS; ++i) {
        free(gone->changes[i].elements);
    }
    of->bytes -= gone->bytes;
}

static void forget_undone(view_history *which)
{
    while (which->count > which->done) {
        free_step(which, &which->steps[--which->count]);
    }
}

static void forget_oldest(view_history *which)
{
    memcpy(which->first, which->steps[0].versions, sizeof which->first);
    free_step(which, &which->steps[0]);
    memmove(which->steps, which->steps + 1, --which->count * sizeof *which->steps);
    --which->done;
}

static void forget_all(view_history *which)
{
    which->done = 0;
    forget_undone(which);
    free(which->steps);
    which->steps = NULL;
    which->capacity = 0;
    for (int i = 0; i < PARTS; ++i) {
        free(which->copies[i].elements);
        which->copies[i] = (list){.elements = NULL};
    }
}

/* All documents are other than they were. */
static void begin_versions(view_history *which)
{
    ++which->last;
    for (int i = 0; i < VIEW_DOCUMENTS; ++i) {
        which->first[i] = which->last;
    }
}

static void fail(view_state *state)
{
    view_history *which = state->history;
    forget_all(which);
    which->failed = true;
    which->seen = state->revisions;
    begin_versions(which);
    view_log(state, "out of memory: what was edited so far cannot be undone");
}

static bool copy_list(list *to, const list *from)
{
    const size_t bytes = from->count * from->element_bytes;
    unsigned char *copy = realloc(to->elements, bytes > 0 ? bytes : 1);
    if (copy == NULL) {
        return false;
    }
    if (bytes > 0) {
        memcpy(copy, from->elements, bytes);
    }
    to->elements = copy;
    to->count = from->count;
    to->element_bytes = from->element_bytes;
    return true;
}

static bool copy_all(view_state *state)
{
    for (int i = 0; i < PARTS; ++i) {
        const list now = list_of(state, (part)i);
        if (!copy_list(&state->history->copies[i], &now)) {
            return false;
        }
    }
    state->history->is_scene = state->is_scene;
    state->history->seen = state->revisions;
    return true;
}

/* ---- versions ---- */

static const unsigned *versions_of(const view_history *which)
{
    return which->done > 0 ? which->steps[which->done - 1].versions : which->first;
}

static void tell_unsaved(view_state *state)
{
    for (int i = 0; i < VIEW_DOCUMENTS; ++i) {
        state->unsaved[i] = versions_of(state->history)[i] != state->history->saved[i];
    }
    state->looked = state->history->seen;
}

void history_end(view_state *state)
{
    if (state->history != NULL) {
        forget_all(state->history);
        free(state->history);
        state->history = NULL;
    }
    memset(state->unsaved, 0, sizeof state->unsaved);
}

void history_begin(view_state *state)
{
    history_end(state);
    state->history = calloc(1, sizeof *state->history);
    if (state->history == NULL) {
        view_log(state, "out of memory: edits cannot be undone");
    } else if (!copy_all(state)) {
        fail(state);
        memcpy(state->history->saved, state->history->first, sizeof state->history->saved);
    }
    if (state->history != NULL) {
        tell_unsaved(state);
    }
}

/* ---- steps ---- */

/* Leaves out what two lists have alike at their begins and ends. */
static bool find_change(part which, const list *had, const list *now, change *out)
{
    const size_t bytes = now->element_bytes;
    const size_t least = had->count < now->count ? had->count : now->count;
    size_t begin = 0;
    size_t end = 0;
    while (begin < least && is_same(which, had->elements + begin * bytes, now->elements + begin * bytes, bytes)) {
        ++begin;
    }
    while (end < least - begin && is_same(which, had->elements + (had->count - 1 - end) * bytes,
                                          now->elements + (now->count - 1 - end) * bytes, bytes)) {
        ++end;
    }
    *out = (change){.first = begin, .removed = had->count - begin - end, .added = now->count - begin - end};
    if (out->removed + out->added == 0) {
        return true;
    }
    out->elements = malloc((out->removed + out->added) * bytes);
    if (out->elements == NULL) {
        return false;
    }
    if (out->removed > 0) {
        memcpy(out->elements, had->elements + begin * bytes, out->removed * bytes);
    }
    if (out->added > 0) {
        memcpy(out->elements + out->removed * bytes, now->elements + begin * bytes, out->added * bytes);
    }
    return true;
}

/* False without memory; what was found is in out all the same. */
static bool find_step(view_state *state, step *out)
{
    view_history *which = state->history;
    *out = (step){.was_scene = which->is_scene, .is_scene = state->is_scene};
    memcpy(out->versions, versions_of(which), sizeof out->versions);
    for (int i = 0; i < PARTS; ++i) {
        const list now = list_of(state, (part)i);
        change *found = &out->changes[i];
        /* The first instance of a scene is the tree as it was. */
        if (i == PART_INSTANCES && which->copies[i].count == 0 && !which->is_scene) {
            continue;
        }
        if (!find_change((part)i, &which->copies[i], &now, found)) {
            return false;
        }
        if (found->elements != NULL) {
            out->bytes += sizeof *out + (found->removed + found->added) * now.element_bytes;
            out->versions[part_documents[i]] = which->last + 1;
        }
    }
    return true;
}

static bool append(view_history *which, const step *made)
{
    if (which->count == which->capacity) {
        const size_t wanted = which->capacity > 0 ? 2 * which->capacity : 64;
        step *larger = realloc(which->steps, wanted * sizeof *larger);
        if (larger == NULL) {
            return false;
        }
        which->steps = larger;
        which->capacity = wanted;
    }
    which->steps[which->count++] = *made;
    which->done = which->count;
    ++which->last;
    return true;
}

static void look(view_state *state)
{
    view_history *which = state->history;
    step made;
    bool is_kept = find_step(state, &made);
    which->bytes += made.bytes;
    if (is_kept && made.bytes > 0) {
        forget_undone(which);
        is_kept = append(which, &made);
    }
    if (!is_kept) {
        free_step(which, &made);
    }
    if (!is_kept || !copy_all(state)) {
        fail(state);
    }
    while (which->bytes > HISTORY_BYTES_MAX && which->count > 1) {
        forget_oldest(which);
    }
}

void history_look(view_state *state, bool is_held)
{
    view_history *which = state->history;
    const bool is_at_work = is_held || state->seconds < state->wheel_rests;
    if (which == NULL) {
        return;
    }
    const bool is_changed = which->seen.lights != state->revisions.lights ||
                            which->seen.instances != state->revisions.instances ||
                            which->seen.strokes != state->revisions.strokes;
    if (is_changed && which->failed) {
        begin_versions(which);
        which->seen = state->revisions;
    } else if (is_changed && !is_at_work) {
        look(state);
    }
    which->is_scene = is_changed && is_at_work ? which->is_scene : state->is_scene;
    tell_unsaved(state);
}

/* Whatever is at work. */
static void look_now(view_state *state)
{
    state->wheel_rests = 0;
    history_look(state, false);
}

void history_settle(view_state *state)
{
    if (state->seconds < state->wheel_rests) {
        look_now(state);
    }
}

void history_saved(view_state *state, view_document document)
{
    if (state->history != NULL) {
        look_now(state);
        state->history->saved[document] = versions_of(state->history)[document];
        tell_unsaved(state);
    }
}

/* ---- back and on ---- */

/* Puts the elements of a change where the others are. */
static bool apply(view_state *state, part which, const change *made, bool is_back)
{
    const size_t bytes = list_of(state, which).element_bytes;
    const size_t gone = is_back ? made->added : made->removed;
    const size_t come = is_back ? made->removed : made->added;
    const unsigned char *from = made->elements + (is_back ? 0 : made->removed * bytes);
    const size_t count = list_of(state, which).count;
    const size_t behind = count - made->first - gone;
    if (come > gone && !resize(state, which, count + come - gone)) {
        return false;
    }
    const list to = list_of(state, which);
    unsigned char *place = to.elements + made->first * bytes;
    if (behind > 0) {
        memmove(place + come * bytes, place + gone * bytes, behind * bytes);
    }
    if (come > 0) {
        memcpy(place, from, come * bytes);
    }
    return come > gone || resize(state, which, count + come - gone);
}

static size_t chosen(size_t index, size_t count)
{
    return index < count ? index : count > 0 ? count - 1 : 0;
}

/* Chooses what came back, and tells the drawing. */
static void choose(view_state *state, const step *made)
{
    const change *changes = made->changes;
    const bool is_scene = changes[PART_INSTANCES].elements != NULL || changes[PART_MOVERS].elements != NULL;
    if (changes[PART_INSTANCES].elements != NULL) {
        state->instance = changes[PART_INSTANCES].first;
    }
    if (changes[PART_SOURCES].elements != NULL) {
        state->source = changes[PART_SOURCES].first;
    }
    if (changes[PART_SCENE_LIGHTS].elements != NULL) {
        state->scene_light = changes[PART_SCENE_LIGHTS].first;
    }
    state->instance = chosen(state->instance, state->instance_count);
    state->source = chosen(state->source, state->source_count);
    state->scene_light = chosen(state->scene_light, state->scene_light_count);
    if (is_scene) {
        view_instances_changed(state);
    }
    if (changes[PART_SOURCES].elements != NULL || changes[PART_SKY].elements != NULL ||
        changes[PART_SCENE_LIGHTS].elements != NULL) {
        view_lights_changed(state);
    }
    if (changes[PART_STROKES].elements != NULL) {
        ++state->revisions.strokes;
    }
}

static void go(view_state *state, const step *made, bool is_back)
{
    const bool is_scene = is_back ? made->was_scene : made->is_scene;
    const char *name = "";
    bool is_done = true;
    for (int i = PARTS; i-- > 0;) {
        if (is_done && made->changes[i].elements != NULL) {
            name = part_names[i];
            is_done = apply(state, (part)i, &made->changes[i], is_back);
        }
    }
    choose(state, made);
    if (!is_done || !copy_all(state)) {
        fail(state);
        return;
    }
    if (state->is_scene != is_scene) {
        view_choose_scene(state, is_scene);
    }
    if (made->changes[PART_STROKES].elements != NULL && !state->brush.is_on) {
        view_choose_brush(state, true);
    }
    state->history->is_scene = state->is_scene;
    view_log(state, "%s: %s; %zu to undo, %zu to redo", is_back ? "undone" : "redone", name, state->history->done,
             state->history->count - state->history->done);
    tell_unsaved(state);
}

/* Whether the brush can no longer go back to where it was before a step. */
static bool is_forgotten(const view_state *state, const step *made)
{
    const change *strokes = &made->changes[PART_STROKES];
    uint64_t before = 0;
    if (strokes->elements == NULL) {
        return false;
    }
    memcpy(&before, strokes->elements, sizeof before);
    return before < state->brush.oldest;
}

void history_undo(view_state *state)
{
    view_history *which = state->history;
    look_now(state);
    if (which == NULL || which->done == 0) {
        view_log(state, "nothing to undo");
    } else if (is_forgotten(state, &which->steps[which->done - 1])) {
        view_log(state, "nothing to undo: older strokes were forgotten");
    } else {
        go(state, &which->steps[--which->done], true);
    }
}

void history_redo(view_state *state)
{
    view_history *which = state->history;
    look_now(state);
    if (which == NULL || which->done == which->count) {
        view_log(state, "nothing to redo");
    } else {
        go(state, &which->steps[which->done++], false);
    }
}
