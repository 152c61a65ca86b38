/* SPDX-License-Identifier: MIT */
/* Reads scenes. Whatever is wrong is one line with the place in the file. */
#include "support/scene_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "support/output.h"
#include "support/scene_motion.h"
#include "support/scene_place.h"
#include "support/suggest.h"

#define PI 3.14159265358979323846

bool scene_file_is_input(const program *state)
{
    const char *name = state->options.input;
    const size_t length = name != NULL ? strlen(name) : 0;
    return length >= 5 && strncmp(name, "scene:", 6) != 0 && strcasecmp(name + length - 5, ".json") == 0;
}

static const cJSON *member(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

/* ---- forms ---- */

static const char *form_name(int form)
{
    return form == SCENE_FILE_BUILT ? "built" : svo_name(SVO_NAME_FORM, (svo_form)form);
}

/* 'form' of the scene, or of one of its trees; *out stays where there is none. */
static int read_form(const json_source *source, const cJSON *object, int *out)
{
    const cJSON *value = member(object, "form");
    const char *name = cJSON_IsString(value) ? value->valuestring : "";
    char known[128] = "";
    size_t used = 0;
    suggestion near = suggestion_begin(name, strlen(name));
    if (value == NULL) {
        return PROGRAM_DONE;
    }
    for (int form = SCENE_FILE_BUILT; form < SVO_FORM_COUNT; ++form) {
        if (strcmp(name, form_name(form)) == 0) {
            *out = form;
            return PROGRAM_DONE;
        }
        used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", used > 0 ? ", " : "", form_name(form));
        suggestion_offer(&near, form_name(form));
    }
    return json_source_fail(source, value, "'form' is none of %s%s", known, suggestion_end(&near).text);
}

static int read_scene_form(const json_source *source, scene_file *file)
{
    file->form = SCENE_FILE_BUILT;
    return read_form(source, source->root, &file->form);
}

/* A scene on the device has one form, that of --tree-form, else that of its trees. */
static int unite_forms(const json_source *source, scene_file *file)
{
    const int asked = source->state->options.tree_form;
    const char *packing = options_packing(&source->state->options);
    if (packing != NULL) {
        return program_fail(source->state, PROGRAM_WRONG_USAGE, "--%s: scenes hold payload unpacked", packing);
    }
    for (size_t i = 0; i < file->tree_count; ++i) {
        const scene_file_tree *tree = &file->trees[i];
        if (asked == 0 && tree->form != file->trees[0].form) {
            return json_source_fail(
                source, tree->value, "tree '%s' has form '%s', and '%s' has '%s'; the trees of a scene have one form",
                tree->name, form_name(tree->form), file->trees[0].name, form_name(file->trees[0].form));
        }
    }
    file->form = asked != 0 ? asked - 1 : file->trees[0].form;
    return PROGRAM_DONE;
}

/* ---- trees ---- */

/* Paths are relative to the folder of the scene's file. */
static int find_path(const json_source *source, const cJSON *value, scene_file_tree *out)
{
    if (!cJSON_IsString(value) || value->valuestring[0] == '\0') {
        return json_source_fail(source, value, "'path' is not a text");
    }
    const char *path = value->valuestring;
    const char *slash = strrchr(source->path, '/');
    const bool is_own = path[0] == '/' || strncmp(path, "scene:", 6) == 0 || slash == NULL;
    const int length = snprintf(out->path, sizeof out->path, "%.*s%s", is_own ? 0 : (int)(slash + 1 - source->path),
                                source->path, path);
    if (length < 0 || (size_t)length >= sizeof out->path) {
        return json_source_fail(source, value, "'path' is longer than %zu bytes", sizeof out->path - 1);
    }
    return strncmp(path, "scene:", 6) == 0 ? PROGRAM_DONE : output_protect(source->state, out->path);
}

static int read_tree(const json_source *source, const cJSON *object, scene_file_tree *out)
{
    static const char *const keys[] = {"path", "depth", "form", NULL};
    int exit_code = json_source_check_keys(source, object, "a tree", keys);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    if (strlen(object->string) >= sizeof out->name) {
        return json_source_fail(source, object, "the tree's name is longer than %zu bytes", sizeof out->name - 1);
    }
    memcpy(out->name, object->string, strlen(object->string) + 1);
    out->value = object;
    if (member(object, "path") == NULL) {
        return json_source_fail(source, object, "tree '%s' has no 'path'", out->name);
    }
    exit_code = find_path(source, member(object, "path"), out);
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_form(source, object, &out->form);
    }
    return exit_code == PROGRAM_DONE && member(object, "depth") != NULL
               ? json_source_count(source, member(object, "depth"), "depth", 1, 16, &out->depth)
               : exit_code;
}

static int read_trees(const json_source *source, scene_file *file)
{
    const cJSON *trees = member(source->root, "trees");
    if (!cJSON_IsObject(trees) || trees->child == NULL) {
        return json_source_fail(source, trees != NULL ? trees : source->root,
                                "'trees' is missing or not an object with a tree for each name");
    }
    const size_t count = (size_t)cJSON_GetArraySize(trees);
    if (count > SVO_SCENE_TREES_MAX) {
        return json_source_fail(source, trees, "%zu trees are above %u", count, SVO_SCENE_TREES_MAX);
    }
    file->trees = calloc(count, sizeof *file->trees);
    if (file->trees == NULL) {
        return program_fail(source->state, PROGRAM_FAILED, "out of memory for %zu trees", count);
    }
    int exit_code = PROGRAM_DONE;
    for (const cJSON *tree = trees->child; tree != NULL && exit_code == PROGRAM_DONE; tree = tree->next) {
        file->trees[file->tree_count].form = file->form;
        exit_code = read_tree(source, tree, &file->trees[file->tree_count++]);
    }
    return exit_code == PROGRAM_DONE ? unite_forms(source, file) : exit_code;
}

static int find_tree(const json_source *source, const scene_file *file, const cJSON *object, uint32_t *out)
{
    const cJSON *name = member(object, "tree");
    if (!cJSON_IsString(name)) {
        return json_source_fail(source, name != NULL ? name : object, "'tree' is missing or not a text");
    }
    suggestion near = suggestion_begin(name->valuestring, strlen(name->valuestring));
    for (size_t i = 0; i < file->tree_count; ++i) {
        if (strcmp(file->trees[i].name, name->valuestring) == 0) {
            *out = (uint32_t)i;
            return PROGRAM_DONE;
        }
        suggestion_offer(&near, file->trees[i].name);
    }
    return json_source_fail(source, name, "no tree is called '%s'%s", name->valuestring, suggestion_end(&near).text);
}

/* ---- transforms ---- */

/* The lit views place meshes without a scene, which would refuse a flat matrix. */
static int read_matrix(const json_source *source, const cJSON *value, float out[12])
{
    const int exit_code = json_source_floats(source, value, "matrix", 12, out);
    return exit_code != PROGRAM_DONE || !scene_place_is_flat(out)
               ? exit_code
               : json_source_fail(source, value, "'matrix' is flat: it maps space to a plane, a line or a point");
}

/* ---- instances ---- */

/* A lattice of copies: how many along each axis, the step between them, and by how much each is turned further than the
   one before it. */
typedef struct copies {
    unsigned count[3];
    float step[3], rotate[3];
} copies;

static int read_counts(const json_source *source, const cJSON *value, unsigned out[3])
{
    if (!cJSON_IsArray(value) || cJSON_GetArraySize(value) != 3) {
        return json_source_fail(source, value, "'count' is not an array of 3 numbers");
    }
    const cJSON *number = value->child;
    int exit_code = PROGRAM_DONE;
    for (int axis = 0; axis < 3 && exit_code == PROGRAM_DONE; ++axis, number = number->next) {
        exit_code = json_source_count(source, number, "count", 1, SVO_SCENE_INSTANCES_MAX, &out[axis]);
    }
    return exit_code;
}

static int read_copies(const json_source *source, const cJSON *object, copies *out)
{
    static const char *const keys[] = {"count", "step", "rotate", NULL};
    *out = (copies){.count = {1, 1, 1}};
    if (object == NULL) {
        return PROGRAM_DONE;
    }
    int exit_code = json_source_check_keys(source, object, "'copies'", keys);
    if (exit_code == PROGRAM_DONE && member(object, "count") != NULL) {
        exit_code = read_counts(source, member(object, "count"), out->count);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = scene_place_read_vector(source, object, "step", out->step);
    }
    return exit_code == PROGRAM_DONE ? scene_place_read_vector(source, object, "rotate", out->rotate) : exit_code;
}

/* Room for so many more. */
static int reserve(const json_source *source, const cJSON *object, scene_file *file, uint64_t more)
{
    const uint64_t needed = file->instance_count + more;
    if (more > SVO_SCENE_INSTANCES_MAX || needed > SVO_SCENE_INSTANCES_MAX) {
        return json_source_fail(source, object, "more than %u instances", SVO_SCENE_INSTANCES_MAX);
    }
    if (needed <= file->instance_capacity) {
        return PROGRAM_DONE;
    }
    const size_t capacity = (size_t)needed * 2;
    svo_instance *larger = realloc(file->instances, capacity * sizeof *larger);
    if (larger == NULL) {
        return program_fail(source->state, PROGRAM_FAILED, "out of memory for %zu instances", capacity);
    }
    file->instances = larger;
    file->instance_capacity = capacity;
    return PROGRAM_DONE;
}

/* A copy of an instance that a matrix places: moved, since its turn is the matrix's. */
static void move_matrix(const float matrix[12], const copies *lattice, const unsigned at[3], float out[12])
{
    memcpy(out, matrix, 12 * sizeof *out);
    for (int axis = 0; axis < 3; ++axis) {
        out[4 * axis + 3] += lattice->step[axis] * (float)at[axis];
    }
}

static void move_place(const scene_place *from, const copies *lattice, const unsigned at[3], unsigned index,
                       float out[12])
{
    scene_place moved = *from;
    for (int axis = 0; axis < 3; ++axis) {
        moved.translate[axis] += lattice->step[axis] * (float)at[axis];
        moved.rotate[axis] += (float)fmod((double)lattice->rotate[axis] * index, 360);
    }
    scene_place_compose(&moved, out);
}

/* matrix: NULL if a placement is given. */
static void add_copies(scene_file *file, uint32_t tree, const float *matrix, const scene_place *from,
                       const copies *lattice)
{
    unsigned at[3];
    unsigned index = 0;
    for (at[2] = 0; at[2] < lattice->count[2]; ++at[2]) {
        for (at[1] = 0; at[1] < lattice->count[1]; ++at[1]) {
            for (at[0] = 0; at[0] < lattice->count[0]; ++at[0]) {
                svo_instance *added = &file->instances[file->instance_count++];
                added->tree = tree;
                if (matrix != NULL) {
                    move_matrix(matrix, lattice, at, added->transform);
                } else {
                    move_place(from, lattice, at, index, added->transform);
                }
                ++index;
            }
        }
    }
}

static int check_matrix_alone(const json_source *source, const cJSON *object)
{
    static const char *const others[] = {"translate", "rotate", "scale"};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i) {
        if (member(object, others[i]) != NULL) {
            return json_source_fail(source, member(object, others[i]), "'%s' beside 'matrix'", others[i]);
        }
    }
    const cJSON *turned = member(member(object, "copies"), "rotate");
    return turned == NULL ? PROGRAM_DONE : json_source_fail(source, turned, "'rotate' of copies beside 'matrix'");
}

/* An instance that moves: it is where its first key places it. */
static int read_moving(const json_source *source, const cJSON *object, uint32_t tree, scene_file *file)
{
    static const char *const keys[] = {"tree", "motion", NULL};
    int exit_code = json_source_check_keys(source, object, "an instance with 'motion'", keys);
    if (exit_code == PROGRAM_DONE) {
        exit_code = reserve(source, object, file, 1);
    }
    scene_motion motion = {.keys = NULL};
    if (exit_code == PROGRAM_DONE) {
        exit_code = scene_motion_read(source, member(object, "motion"), &motion);
    }
    if (exit_code == PROGRAM_DONE) {
        motion.instance = file->instance_count;
        file->motions[file->motion_count++] = motion;
        file->entries[file->entry_count++] = (scene_file_entry){file->instance_count, object};
        svo_instance *added = &file->instances[file->instance_count++];
        added->tree = tree;
        scene_place_compose(&motion.keys[0].place, added->transform);
    }
    return exit_code;
}

static int read_instance(const json_source *source, const cJSON *object, scene_file *file)
{
    static const char *const keys[] = {"tree", "matrix", "translate", "rotate", "scale", "copies", "motion", NULL};
    const cJSON *given_matrix = member(object, "matrix");
    uint32_t tree = 0;
    float matrix[12] = {0};
    scene_place from;
    copies lattice;
    int exit_code = json_source_check_keys(source, object, "an instance", keys);
    if (exit_code == PROGRAM_DONE) {
        exit_code = find_tree(source, file, object, &tree);
    }
    if (exit_code == PROGRAM_DONE && member(object, "motion") != NULL) {
        return read_moving(source, object, tree, file);
    }
    if (exit_code == PROGRAM_DONE && given_matrix != NULL) {
        exit_code = check_matrix_alone(source, object);
    }
    if (exit_code == PROGRAM_DONE && given_matrix != NULL) {
        exit_code = read_matrix(source, given_matrix, matrix);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = scene_place_read(source, object, &from);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_copies(source, member(object, "copies"), &lattice);
    }
    if (exit_code == PROGRAM_DONE) {
        const uint64_t rows = (uint64_t)lattice.count[0] * lattice.count[1];
        exit_code = reserve(source, object, file, rows > SVO_SCENE_INSTANCES_MAX ? rows : rows * lattice.count[2]);
    }
    if (exit_code == PROGRAM_DONE) {
        file->entries[file->entry_count++] =
            (scene_file_entry){file->instance_count, given_matrix != NULL ? given_matrix : object};
        add_copies(file, tree, given_matrix != NULL ? matrix : NULL, &from, &lattice);
    }
    return exit_code;
}

static int read_instances(const json_source *source, scene_file *file)
{
    const cJSON *instances = member(source->root, "instances");
    if (!cJSON_IsArray(instances) || instances->child == NULL) {
        return json_source_fail(source, instances != NULL ? instances : source->root,
                                "'instances' is missing or not an array with an instance");
    }
    file->entries = calloc((size_t)cJSON_GetArraySize(instances), sizeof *file->entries);
    file->motions = calloc((size_t)cJSON_GetArraySize(instances), sizeof *file->motions);
    if (file->entries == NULL || file->motions == NULL) {
        return program_fail(source->state, PROGRAM_FAILED, "out of memory for %d entries",
                            cJSON_GetArraySize(instances));
    }
    int exit_code = PROGRAM_DONE;
    for (const cJSON *one = instances->child; one != NULL && exit_code == PROGRAM_DONE; one = one->next) {
        exit_code = read_instance(source, one, file);
    }
    return exit_code;
}

/* ---- camera and lights ---- */

static int read_fov(const json_source *source, const cJSON *camera, float *out)
{
    const cJSON *fov = member(camera, "fov");
    if (fov == NULL) {
        return PROGRAM_DONE;
    }
    if (!cJSON_IsNumber(fov) || !(fov->valuedouble > 0) || !(fov->valuedouble < 180)) {
        return json_source_fail(source, fov, "'fov' is not an angle above 0 and below 180 degrees");
    }
    *out = (float)(fov->valuedouble * PI / 180);
    return PROGRAM_DONE;
}

/* A camera looks somewhere, and its up is not along the line of sight, by a millionth of a radian as in the library. */
static int check_view(const json_source *source, const cJSON *object, const svo_camera *camera)
{
    double towards[3];
    double distance = 0;
    double height = 0;
    double across = 0;
    for (int axis = 0; axis < 3; ++axis) {
        towards[axis] = (double)camera->target[axis] - (double)camera->eye[axis];
        distance += towards[axis] * towards[axis];
        height += (double)camera->up[axis] * (double)camera->up[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int a = (axis + 1) % 3;
        const int b = (axis + 2) % 3;
        const double component = towards[a] * (double)camera->up[b] - towards[b] * (double)camera->up[a];
        across += component * component;
    }
    if (distance == 0) {
        return json_source_fail(source, member(object, "target"), "'target' is where 'eye' is");
    }
    if (!(across > 1e-12 * distance * height)) {
        const cJSON *up = member(object, "up");
        return json_source_fail(source, up != NULL ? up : object, "'up' is 0 or along the line of sight");
    }
    return PROGRAM_DONE;
}

static int read_camera(const json_source *source, scene_file *file)
{
    static const char *const keys[] = {"eye", "target", "up", "fov", NULL};
    const cJSON *object = member(source->root, "camera");
    if (object == NULL) {
        return PROGRAM_DONE;
    }
    file->camera = (svo_camera){.up = {0, 1, 0}, .vertical_fov = (float)(32 * PI / 180)};
    file->has_camera = true;
    int exit_code = json_source_check_keys(source, object, "'camera'", keys);
    if (exit_code == PROGRAM_DONE && (member(object, "eye") == NULL || member(object, "target") == NULL)) {
        exit_code = json_source_fail(source, object, "'camera' has no 'eye' or no 'target'");
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = scene_place_read_vector(source, object, "eye", file->camera.eye);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = scene_place_read_vector(source, object, "target", file->camera.target);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = scene_place_read_vector(source, object, "up", file->camera.up);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_fov(source, object, &file->camera.vertical_fov);
    }
    return exit_code == PROGRAM_DONE ? check_view(source, object, &file->camera) : exit_code;
}

static int read_direction(const json_source *source, const cJSON *light, float out[3])
{
    const cJSON *value = member(light, "direction");
    if (value == NULL) {
        return json_source_fail(source, light, "the light has no 'direction'");
    }
    const int exit_code = json_source_floats(source, value, "direction", 3, out);
    return exit_code != PROGRAM_DONE || out[0] != 0.0F || out[1] != 0.0F || out[2] != 0.0F
               ? exit_code
               : json_source_fail(source, value, "'direction' is 0, 0, 0");
}

static int read_color(const json_source *source, const cJSON *light, float out[3])
{
    const int exit_code = scene_place_read_vector(source, light, "color", out);
    return exit_code != PROGRAM_DONE || (out[0] >= 0.0F && out[1] >= 0.0F && out[2] >= 0.0F)
               ? exit_code
               : json_source_fail(source, member(light, "color"), "'color' has a number below 0");
}

static int read_light(const json_source *source, const cJSON *object, svo_scene_light *out)
{
    static const char *const keys[] = {"direction", "color", "shadows", NULL};
    *out = (svo_scene_light){.shadows = 1, .color = {1, 1, 1}};
    int exit_code = json_source_check_keys(source, object, "a light", keys);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    exit_code = read_direction(source, object, out->direction);
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_color(source, object, out->color);
    }
    const cJSON *shadows = member(object, "shadows");
    if (exit_code == PROGRAM_DONE && shadows != NULL && !cJSON_IsBool(shadows)) {
        exit_code = json_source_fail(source, shadows, "'shadows' is not true or false");
    }
    out->shadows = shadows == NULL || cJSON_IsTrue(shadows) ? 1 : 0;
    return exit_code;
}

static int read_lights(const json_source *source, scene_file *file)
{
    const cJSON *lights = member(source->root, "lights");
    if (lights == NULL) {
        return PROGRAM_DONE;
    }
    if (!cJSON_IsArray(lights) || (size_t)cJSON_GetArraySize(lights) > SVO_SCENE_LIGHTS_MAX) {
        return json_source_fail(source, lights, "'lights' is not an array of at most %u lights", SVO_SCENE_LIGHTS_MAX);
    }
    int exit_code = PROGRAM_DONE;
    for (const cJSON *light = lights->child; light != NULL && exit_code == PROGRAM_DONE; light = light->next) {
        exit_code = read_light(source, light, &file->lights[file->light_count++]);
    }
    return exit_code;
}

static int read_range(const json_source *source, scene_file *file)
{
    const cJSON *range = member(source->root, "occlusion_range");
    if (range == NULL) {
        return PROGRAM_DONE;
    }
    if (!cJSON_IsNumber(range) || !(range->valuedouble > 0) || !(range->valuedouble <= 1e30)) {
        return json_source_fail(source, range, "'occlusion_range' is not above 0 and at most 1e30");
    }
    file->occlusion_range = (float)range->valuedouble;
    return PROGRAM_DONE;
}

/* ---- files ---- */

typedef int part_reader(const json_source *source, scene_file *file);

static int read_file(const json_source *source, scene_file *file)
{
    static const char *const keys[] = {"form", "trees", "instances", "camera", "lights", "occlusion_range", NULL};
    static part_reader *const readers[] = {read_scene_form, read_trees,  read_instances,
                                           read_camera,     read_lights, read_range};
    int exit_code = json_source_check_keys(source, source->root, "the scene", keys);
    for (size_t i = 0; i < sizeof readers / sizeof readers[0] && exit_code == PROGRAM_DONE; ++i) {
        exit_code = readers[i](source, file);
    }
    return exit_code;
}

int scene_file_open(program *state, const char *path, scene_file *out)
{
    *out = (scene_file){.trees = NULL};
    int exit_code = json_source_open(state, path, &out->source);
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_file(&out->source, out);
    }
    if (exit_code != PROGRAM_DONE) {
        scene_file_close(out);
    }
    return exit_code;
}

void scene_file_close(scene_file *file)
{
    json_source_close(&file->source);
    free(file->trees);
    free(file->entries);
    free(file->instances);
    for (size_t i = 0; i < file->motion_count; ++i) {
        free(file->motions[i].keys);
    }
    free(file->motions);
    *file = (scene_file){.trees = NULL};
}

const char *scene_file_form_name(const scene_file *file)
{
    return form_name(file->form);
}

int scene_file_fail_library(const scene_file *file, const char *message)
{
    static const char name[] = "instance ";
    const char *words = program_words(message);
    const char *named = strstr(words, name);
    char *end = NULL;
    const size_t index = named != NULL ? strtoul(named + sizeof name - 1, &end, 10) : 0;
    if (named == NULL || end == named + sizeof name - 1) {
        return program_fail(file->source.state, PROGRAM_FAILED, "%s: %s", file->source.path, words);
    }
    size_t entry = 0;
    while (entry + 1 < file->entry_count && file->entries[entry + 1].begin <= index) {
        ++entry;
    }
    return json_source_fail(&file->source, file->entries[entry].value, "%s", words);
}
