/* SPDX-License-Identifier: MIT */
/* Reads scripts of edits line by line. */
#include "svocl/edit_script.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "svocl/names.h"

#define SCRIPT_BYTES_MAX ((size_t)64 << 20)
#define MATERIAL_MAX     65534.0
#define COUNT_MAX        1048576.0

/* ---- the file ---- */

int edit_script_fail(program *state, const edit_script *script, int exit_code, const char *words)
{
    return program_fail(state, exit_code, "%s:%u: %s", script->path, script->line, words);
}

static int fail_read(program *state, const char *path, int error)
{
    return program_fail(state, PROGRAM_FAILED, "%s: %s", path, strerror(error));
}

int edit_script_open(program *state, const char *path, edit_script *script)
{
    *script = (edit_script){.path = path};
    FILE *file = fopen(path, "rb");
    size_t count = 0;
    size_t room = 4096;
    if (file == NULL) {
        return fail_read(state, path, errno);
    }
    script->text = malloc(room + 1);
    while (script->text != NULL && count <= SCRIPT_BYTES_MAX) {
        count += fread(script->text + count, 1, room - count, file);
        if (count < room) {
            break;
        }
        room *= 2;
        char *larger = realloc(script->text, room + 1);
        if (larger == NULL) {
            free(script->text);
        }
        script->text = larger;
    }
    const int error = ferror(file) != 0 ? EIO : script->text == NULL ? ENOMEM : 0;
    (void)fclose(file);
    if (error != 0) {
        return fail_read(state, path, error);
    }
    if (count > SCRIPT_BYTES_MAX) {
        return program_fail(state, PROGRAM_FAILED, "%s: more than %zu bytes", path, SCRIPT_BYTES_MAX);
    }
    if (memchr(script->text, '\0', count) != NULL) {
        return program_fail(state, PROGRAM_FAILED, "%s is no text: it has a byte 0", path);
    }
    script->text[count] = '\0';
    script->next = script->text;
    return PROGRAM_DONE;
}

void edit_script_close(edit_script *script)
{
    free(script->text);
    script->text = NULL;
}

/* ---- words ---- */

static bool is_space(char letter)
{
    return letter == ' ' || letter == '\t' || letter == '\r';
}

/* Cuts the next word of a line off, which may stand in quotes. Returns NULL at the end; *is_open: a quote is. */
static char *take_word(char **line, bool *is_open)
{
    char *at = *line;
    while (is_space(*at)) {
        ++at;
    }
    if (*at == '\0' || *at == '#') {
        return NULL;
    }
    const bool quoted = *at == '"';
    char *word = quoted ? at + 1 : at;
    for (at = word; *at != '\0' && (quoted ? *at != '"' : !is_space(*at) && *at != '#');) {
        ++at;
    }
    *is_open = quoted && *at == '\0';
    *line = *at == '\0' ? at : at + 1;
    if (*at == '#') { /* the rest is a comment */
        *line = at + strlen(at);
    }
    *at = '\0';
    return word;
}

/* The words of the next line that has any; none at the end. */
static int read_line(program *state, edit_script *script)
{
    script->word = 0;
    script->word_count = 0;
    while (script->word_count == 0 && *script->next != '\0') {
        char *line = script->next;
        char *end = strchr(line, '\n');
        bool is_open = false;
        script->next = end != NULL ? end + 1 : line + strlen(line);
        if (end != NULL) {
            *end = '\0';
        }
        ++script->line;
        for (char *word = take_word(&line, &is_open); word != NULL; word = take_word(&line, &is_open)) {
            if (script->word_count == SCRIPT_WORDS_MAX || is_open) {
                return edit_script_fail(state, script, PROGRAM_FAILED,
                                        is_open ? "a quote has no end" : "there are too many words");
            }
            script->words[script->word_count++] = word;
        }
    }
    return PROGRAM_DONE;
}

static const char *next_word(edit_script *script)
{
    return script->word < script->word_count ? script->words[script->word++] : NULL;
}

/* Takes the next word if it is this one. */
static bool take(edit_script *script, const char *wanted)
{
    const bool found = script->word < script->word_count && strcmp(script->words[script->word], wanted) == 0;
    script->word += found ? 1 : 0;
    return found;
}

/* ---- values ---- */

static int fail_word(program *state, const edit_script *script, const char *word, const char *what)
{
    svo_message text;
    if (word == NULL) {
        (void)snprintf(text.text, sizeof text.text, "%s is missing", what);
    } else {
        (void)snprintf(text.text, sizeof text.text, "'%s' is not %s", word, what);
    }
    return edit_script_fail(state, script, PROGRAM_FAILED, text.text);
}

/* A number within low .. high; whole: without a fraction. */
static int read_number(program *state, edit_script *script, const char *what, const double range[2], bool whole,
                       double *out)
{
    char *end = NULL;
    const char *word = next_word(script);
    const double value = word != NULL ? strtod(word, &end) : NAN;
    if (word == NULL || end == word || *end != '\0' || !isfinite(value) || (whole && value != floor(value)) ||
        value < range[0] || value > range[1]) {
        return fail_word(state, script, word, what);
    }
    *out = value;
    return PROGRAM_DONE;
}

/* Numbers, which messages call "a coordinate". */
static int read_place(program *state, edit_script *script, double out[3])
{
    static const double range[2] = {-1073741824.0, 1073741824.0};
    int exit_code = PROGRAM_DONE;
    for (int axis = 0; axis < 3 && exit_code == PROGRAM_DONE; ++axis) {
        exit_code = read_number(state, script, "a coordinate", range, false, &out[axis]);
    }
    return exit_code;
}

static int read_offset(program *state, edit_script *script, int32_t out[3])
{
    static const double range[2] = {-1073741824.0, 1073741824.0};
    int exit_code = PROGRAM_DONE;
    for (int axis = 0; axis < 3 && exit_code == PROGRAM_DONE; ++axis) {
        double value = 0.0;
        exit_code = read_number(state, script, "a whole number of voxels", range, true, &value);
        out[axis] = (int32_t)value;
    }
    return exit_code;
}

static int read_color(program *state, edit_script *script, uint8_t rgba[4])
{
    static const double range[2] = {0.0, 255.0};
    for (int i = 0; i < 4; ++i) {
        double value = 255.0;
        if (i == 3 && (script->word == script->word_count || strcmp(script->words[script->word], "material") == 0)) {
            break; /* alpha may be left out */
        }
        const int exit_code = read_number(state, script, "a color's component, 0 .. 255", range, true, &value);
        if (exit_code != PROGRAM_DONE) {
            return exit_code;
        }
        rgba[i] = (uint8_t)value;
    }
    return PROGRAM_DONE;
}

/* ---- meshes ---- */

/* Turns what was turned before by an angle about an axis; quarters are exact. */
static void turn(double matrix[3][3], int axis, double degrees)
{
    static const double quarters[4][2] = {{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}}; /* cosine, sine */
    const double quarter = fmod(degrees / 90.0, 4.0) + (fmod(degrees / 90.0, 4.0) < 0.0 ? 4.0 : 0.0);
    const bool exact = quarter == floor(quarter) && quarter < 4.0;
    const double radians = degrees * (3.14159265358979323846 / 180.0);
    const double cosine = exact ? quarters[(int)quarter][0] : cos(radians);
    const double sine = exact ? quarters[(int)quarter][1] : sin(radians);
    double *first = matrix[(axis + 1) % 3];
    double *second = matrix[(axis + 2) % 3];
    for (int i = 0; i < 3; ++i) {
        const double a = first[i];
        const double b = second[i];
        first[i] = cosine * a - sine * b;
        second[i] = sine * a + cosine * b;
    }
}

static int read_turn(program *state, edit_script *script, script_mesh *out)
{
    static const double range[2] = {-1e6, 1e6};
    double degrees = 0.0;
    const char *word = next_word(script);
    if (word == NULL || strlen(word) != 1 || word[0] < 'x' || word[0] > 'z') {
        return fail_word(state, script, word, "an axis: x, y or z");
    }
    const int exit_code = read_number(state, script, "a number of degrees", range, false, &degrees);
    turn(out->turn, word[0] - 'x', degrees);
    return exit_code;
}

/* What follows the file of a mesh: the rule, scale, turns and place, in this order; all may be left out. */
static int read_mesh(program *state, edit_script *script, script_mesh *out)
{
    static const double scales[2] = {1e-9, 1e9};
    int exit_code = PROGRAM_DONE;
    *out = (script_mesh){.scale = 1.0, .turn = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    out->rule = take(script, "parity") ? SVO_SOLID_PARITY : SVO_SOLID_WINDING;
    if (take(script, "scale")) {
        exit_code = read_number(state, script, "a scale, 1e-9 .. 1e9", scales, false, &out->scale);
    }
    while (exit_code == PROGRAM_DONE && take(script, "turn")) {
        exit_code = read_turn(state, script, out);
    }
    return exit_code == PROGRAM_DONE && take(script, "at") ? read_place(state, script, out->at) : exit_code;
}

/* ---- steps ---- */

/* The shape and its numbers. */
static int read_shape(program *state, edit_script *script, script_step *out)
{
    static const double radii[2] = {0.0, 1073741824.0};
    svo_edit_step *step = &out->step;
    const char *word = next_word(script);
    out->is_mesh = word != NULL && strcmp(word, "mesh") == 0 && out->action != SCRIPT_COPY;
    step->shape = out->is_mesh ? SVO_EDIT_VOXELS : SVO_EDIT_BOX;
    while (!out->is_mesh && step->shape <= SVO_EDIT_VOXELS &&
           (word == NULL || strcmp(word, svo_name(SVO_NAME_EDIT_SHAPE, step->shape)) != 0)) {
        ++step->shape;
    }
    if (step->shape > SVO_EDIT_VOXELS || (out->action == SCRIPT_COPY && step->shape == SVO_EDIT_VOXELS)) {
        return fail_word(state, script, word,
                         out->action == SCRIPT_COPY ? "box, sphere or capsule"
                                                    : "box, sphere, capsule, voxels or mesh");
    }
    if (step->shape == SVO_EDIT_VOXELS) {
        out->file = next_word(script);
        if (out->file == NULL || out->file[0] == '\0') {
            return fail_word(state, script, NULL, out->is_mesh ? "the file of a mesh" : "the file of voxels");
        }
        return out->is_mesh         ? read_mesh(state, script, &out->mesh)
               : take(script, "at") ? read_offset(state, script, step->offset)
                                    : PROGRAM_DONE;
    }
    int exit_code = read_place(state, script, step->begin);
    if (exit_code == PROGRAM_DONE && step->shape != SVO_EDIT_SPHERE) {
        exit_code = read_place(state, script, step->end);
    }
    if (exit_code == PROGRAM_DONE && step->shape != SVO_EDIT_BOX) {
        exit_code = read_number(state, script, "a radius", radii, false, &step->radius);
    }
    return exit_code;
}

/* Color and material, in this order, of verbs and shapes that take them. */
static int read_payload(program *state, edit_script *script, script_step *out)
{
    static const double materials[2] = {0.0, MATERIAL_MAX};
    svo_edit_step *step = &out->step;
    int exit_code = PROGRAM_DONE;
    if (step->verb == SVO_EDIT_CLEAR || step->verb == SVO_EDIT_KEEP ||
        (step->shape == SVO_EDIT_VOXELS && !out->is_mesh)) {
        return PROGRAM_DONE;
    }
    out->has_color = take(script, "color");
    if (out->has_color) {
        exit_code = read_color(state, script, step->rgba);
    }
    if (exit_code == PROGRAM_DONE && take(script, "material")) {
        double value = 0.0;
        exit_code = read_number(state, script, "a material, 0 .. 65534", materials, true, &value);
        step->material = (uint32_t)value;
    }
    return exit_code;
}

/* undo and redo, which may have a number. */
static int read_count(program *state, edit_script *script, script_step *out)
{
    static const double range[2] = {1.0, COUNT_MAX};
    double value = 1.0;
    const int exit_code = script->word < script->word_count
                              ? read_number(state, script, "a number of steps", range, true, &value)
                              : PROGRAM_DONE;
    out->count = (uint32_t)value;
    return exit_code;
}

static int read_step(program *state, edit_script *script, script_step *out)
{
    const char *word = next_word(script);
    if (strcmp(word, "undo") == 0 || strcmp(word, "redo") == 0) {
        out->action = word[0] == 'u' ? SCRIPT_UNDO : SCRIPT_REDO;
        return read_count(state, script, out);
    }
    if (strcmp(word, "copy") == 0) {
        out->action = SCRIPT_COPY;
        const int exit_code = read_shape(state, script, out);
        return exit_code != PROGRAM_DONE ? exit_code
               : take(script, "by")      ? read_offset(state, script, out->offset)
                                         : fail_word(state, script, NULL, "'by' with an offset");
    }
    out->action = SCRIPT_APPLY;
    while (out->step.verb <= SVO_EDIT_PAINT && strcmp(word, svo_name(SVO_NAME_EDIT_VERB, out->step.verb)) != 0) {
        ++out->step.verb;
    }
    if (out->step.verb > SVO_EDIT_PAINT) {
        return fail_word(state, script, word, "a step: set, add, clear, keep, paint, copy, undo or redo");
    }
    const int exit_code = read_shape(state, script, out);
    return exit_code == PROGRAM_DONE ? read_payload(state, script, out) : exit_code;
}

int edit_script_next(program *state, edit_script *script, script_step *out)
{
    *out = (script_step){.action = SCRIPT_END, .step = {.struct_size = sizeof out->step, .rgba = {255, 255, 255, 255}}};
    int exit_code = read_line(state, script);
    if (exit_code != PROGRAM_DONE || script->word_count == 0) {
        return exit_code;
    }
    exit_code = read_step(state, script, out);
    if (exit_code == PROGRAM_DONE && script->word < script->word_count) {
        svo_message text;
        (void)snprintf(text.text, sizeof text.text, "unexpected '%s'", script->words[script->word]);
        exit_code = edit_script_fail(state, script, PROGRAM_FAILED, text.text);
    }
    return exit_code;
}
