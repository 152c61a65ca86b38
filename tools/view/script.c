/* SPDX-License-Identifier: MIT */
/* Scripts: lines of a command and its arguments to steps. */
#include "view/script.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SCRIPT_BYTES_MAX  (1L << 20)
#define SCRIPT_FRAMES_MAX 100000.0
#define SCRIPT_WORDS_MAX  8

/* A line that is being read. */
typedef struct reader {
    program *running;
    const char *path;
    unsigned line;
    bool is_loading; /* the line begins with the word */
    script *out;
    char *words[SCRIPT_WORDS_MAX];
    size_t word_count;
} reader;

typedef struct key_name {
    const char *name;
    int key;
} key_name;

static const key_name key_names[] = {
    {"backspace", VIEW_KEY_BACKSPACE}, {"tab", VIEW_KEY_TAB},     {"enter", VIEW_KEY_ENTER},
    {"escape", VIEW_KEY_ESCAPE},       {"space", VIEW_KEY_SPACE}, {"delete", VIEW_KEY_DELETE},
    {"left", VIEW_KEY_LEFT},           {"right", VIEW_KEY_RIGHT}, {"up", VIEW_KEY_UP},
    {"down", VIEW_KEY_DOWN},           {"home", VIEW_KEY_HOME},   {"end", VIEW_KEY_END}};

#define KEY_NAMES (sizeof key_names / sizeof key_names[0])

/* ---- failures ---- */

static int fail(const reader *from, const char *format, ...) __attribute__((format(printf, 2, 3)));

static int fail(const reader *from, const char *format, ...)
{
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return program_fail(from->running, PROGRAM_FAILED, "%s:%u: %s", from->path, from->line, text);
}

/* ---- steps ---- */

static int add(reader *from, const script_step *step)
{
    script *out = from->out;
    if (out->step_count == out->step_capacity) {
        const size_t wanted = out->step_capacity > 0 ? 2 * out->step_capacity : 64;
        script_step *larger = realloc(out->steps, wanted * sizeof *larger);
        if (larger == NULL) {
            return fail(from, "out of memory for the script");
        }
        out->steps = larger;
        out->step_capacity = wanted;
    }
    out->steps[out->step_count] = *step;
    out->steps[out->step_count].is_loading = from->is_loading;
    out->steps[out->step_count++].line = from->line;
    return PROGRAM_DONE;
}

static int add_event(reader *from, const view_event *event)
{
    return add(from, &(script_step){.kind = SCRIPT_EVENT, .event = *event});
}

static int add_wait(reader *from, unsigned frames)
{
    return frames == 0 ? PROGRAM_DONE : add(from, &(script_step){.kind = SCRIPT_WAIT, .count = frames});
}

/* ---- arguments ---- */

static int read_number(const reader *from, size_t word, double low, double high, double *out)
{
    char *end = NULL;
    if (word >= from->word_count) {
        return fail(from, "'%s' lacks a number", from->words[0]);
    }
    *out = strtod(from->words[word], &end);
    return end != from->words[word] && *end == '\0' && *out >= low && *out <= high
               ? PROGRAM_DONE
               : fail(from, "'%s' is not a number within %g .. %g", from->words[word], low, high);
}

static int read_whole(const reader *from, size_t word, int low, int high, int *out)
{
    double number = 0;
    const int exit_code = read_number(from, word, low, high, &number);
    *out = (int)number;
    return exit_code == PROGRAM_DONE && number > (double)*out
               ? fail(from, "'%s' is not a whole number", from->words[word])
               : exit_code;
}

/* x and y, of which the first is at a word. */
static int read_place(const reader *from, size_t word, view_event *event)
{
    const int exit_code = read_whole(from, word, 0, (int)VIEW_EDGE_MAX, &event->x);
    return exit_code == PROGRAM_DONE ? read_whole(from, word + 1, 0, (int)VIEW_EDGE_MAX, &event->y) : exit_code;
}

/* "shift+" and "ctrl+" before a word; returns what is behind them. */
static const char *read_modifiers(const char *word, view_event *event)
{
    for (;;) {
        if (strncmp(word, "shift+", 6) == 0) {
            event->shift = true;
            word += 6;
        } else if (strncmp(word, "ctrl+", 5) == 0) {
            event->control = true;
            word += 5;
        } else {
            return word;
        }
    }
}

static int key_of_name(const char *name)
{
    if (name[0] == 'F' && name[1] >= '1' && name[1] <= '9') {
        const long number = strtol(name + 1, NULL, 10);
        return number <= 12 ? VIEW_KEY_F1 + (int)number - 1 : VIEW_KEY_NONE;
    }
    for (size_t i = 0; i < KEY_NAMES; ++i) {
        if (strcmp(key_names[i].name, name) == 0) {
            return key_names[i].key;
        }
    }
    return name[0] > ' ' && name[0] <= '~' && name[1] == '\0' ? name[0] : VIEW_KEY_NONE;
}

/* "left", "right" or "middle", with modifiers; word moves behind it. */
static void read_button(const reader *from, size_t *word, view_event *event)
{
    static const char *const names[] = {"left", "right", "middle"};
    if (*word >= from->word_count) {
        return;
    }
    const char *name = read_modifiers(from->words[*word], event);
    for (int i = 0; i < 3; ++i) {
        if (strcmp(name, names[i]) == 0) {
            event->button = i;
            ++*word;
            return;
        }
    }
}

/* ---- commands ---- */

/* key NAME [FRAMES] */
static int read_key(reader *from)
{
    view_event event = {.kind = VIEW_EVENT_KEY, .is_down = true};
    int frames = 1;
    if (from->word_count < 2) {
        return fail(from, "'key' lacks a key");
    }
    event.key = key_of_name(read_modifiers(from->words[1], &event));
    if (event.key == VIEW_KEY_NONE) {
        return fail(from, "'%s' is not a key", from->words[1]);
    }
    int exit_code = from->word_count > 2 ? read_whole(from, 2, 1, (int)SCRIPT_FRAMES_MAX, &frames) : PROGRAM_DONE;
    exit_code = exit_code == PROGRAM_DONE ? add_event(from, &event) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? add_wait(from, (unsigned)frames - 1) : exit_code;
    event.is_down = false;
    return exit_code == PROGRAM_DONE ? add_event(from, &event) : exit_code;
}

/* text WORDS: what is typed, to the end of the line */
static int read_text(reader *from)
{
    view_event event = {.kind = VIEW_EVENT_TEXT};
    size_t used = 0;
    if (from->word_count < 2) {
        return fail(from, "'text' lacks text");
    }
    for (size_t i = 1; i < from->word_count && used < sizeof event.text; ++i) {
        used += (size_t)snprintf(event.text + used, sizeof event.text - used, "%s%s", i > 1 ? " " : "", from->words[i]);
    }
    return used < sizeof event.text ? add_event(from, &event)
                                    : fail(from, "text is longer than %zu bytes", sizeof event.text - 1);
}

/* move X Y */
static int read_move(reader *from)
{
    view_event event = {.kind = VIEW_EVENT_MOVE};
    const int exit_code = read_place(from, 1, &event);
    return exit_code == PROGRAM_DONE ? add_event(from, &event) : exit_code;
}

static int add_button(reader *from, const view_event *place, bool is_down)
{
    view_event event = *place;
    event.kind = VIEW_EVENT_BUTTON;
    event.is_down = is_down;
    return add_event(from, &event);
}

/* click [BUTTON] X Y: moves there, waits until panels have seen the mouse, presses and lets go */
static int read_click(reader *from)
{
    view_event event = {.kind = VIEW_EVENT_MOVE};
    size_t word = 1;
    read_button(from, &word, &event);
    int exit_code = read_place(from, word, &event);
    exit_code = exit_code == PROGRAM_DONE ? add_event(from, &event) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? add_wait(from, 1) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? add_button(from, &event, true) : exit_code;
    return exit_code == PROGRAM_DONE ? add_button(from, &event, false) : exit_code;
}

/* The moves of a drag, one a frame, along a line. */
static int add_moves(reader *from, const view_event *begin, const view_event *end, int frames)
{
    int exit_code = PROGRAM_DONE;
    for (int i = 1; i <= frames && exit_code == PROGRAM_DONE; ++i) {
        view_event event = *begin;
        event.kind = VIEW_EVENT_MOVE;
        event.x = begin->x + (end->x - begin->x) * i / frames;
        event.y = begin->y + (end->y - begin->y) * i / frames;
        exit_code = add_event(from, &event);
    }
    return exit_code;
}

/* drag [BUTTON] X Y X2 Y2 [FRAMES] */
static int read_drag(reader *from)
{
    view_event begin = {.kind = VIEW_EVENT_MOVE};
    view_event end = {.kind = VIEW_EVENT_MOVE};
    size_t word = 1;
    int frames = 8;
    read_button(from, &word, &begin);
    int exit_code = read_place(from, word, &begin);
    exit_code = exit_code == PROGRAM_DONE ? read_place(from, word + 2, &end) : exit_code;
    if (exit_code == PROGRAM_DONE && from->word_count > word + 4) {
        exit_code = read_whole(from, word + 4, 1, 1000, &frames);
    }
    exit_code = exit_code == PROGRAM_DONE ? add_event(from, &begin) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? add_wait(from, 1) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? add_button(from, &begin, true) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? add_moves(from, &begin, &end, frames) : exit_code;
    end.button = begin.button;
    end.shift = begin.shift;
    end.control = begin.control;
    return exit_code == PROGRAM_DONE ? add_button(from, &end, false) : exit_code;
}

/* wheel [MODIFIERS] X Y STEPS */
static int read_wheel(reader *from)
{
    view_event event = {.kind = VIEW_EVENT_MOVE};
    double steps = 0;
    size_t word = 1;
    if (from->word_count > 4 && *read_modifiers(from->words[1], &event) == '\0') {
        ++word;
    }
    int exit_code = read_place(from, word, &event);
    exit_code = exit_code == PROGRAM_DONE ? read_number(from, word + 2, -100, 100, &steps) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? add_event(from, &event) : exit_code;
    exit_code = exit_code == PROGRAM_DONE ? add_wait(from, 1) : exit_code;
    event.kind = VIEW_EVENT_WHEEL;
    event.steps = (float)steps;
    return exit_code == PROGRAM_DONE ? add_event(from, &event) : exit_code;
}

/* size WIDTH HEIGHT: of the window */
static int read_size(reader *from)
{
    view_event event = {.kind = VIEW_EVENT_RESIZE};
    int exit_code = read_whole(from, 1, (int)VIEW_EDGE_MIN, (int)VIEW_EDGE_MAX, &event.x);
    exit_code =
        exit_code == PROGRAM_DONE ? read_whole(from, 2, (int)VIEW_EDGE_MIN, (int)VIEW_EDGE_MAX, &event.y) : exit_code;
    return exit_code == PROGRAM_DONE ? add_event(from, &event) : exit_code;
}

/* wait FRAMES */
static int read_wait(reader *from)
{
    int frames = 0;
    const int exit_code = read_whole(from, 1, 1, (int)SCRIPT_FRAMES_MAX, &frames);
    return exit_code == PROGRAM_DONE ? add_wait(from, (unsigned)frames) : exit_code;
}

static int read_refine(reader *from)
{
    return add(from, &(script_step){.kind = SCRIPT_REFINE});
}

/* coarse PIXELS: 1, 2, 4, 8; 0 by time, which stands still in scripts: the coarsest first */
static int read_coarse(reader *from)
{
    int pixels = 0;
    const int exit_code = read_whole(from, 1, 0, (int)VIEW_COARSE_MAX, &pixels);
    if (exit_code == PROGRAM_DONE && (pixels & (pixels - 1)) != 0) {
        return fail(from, "'coarse %d' is none of 0, 1, 2, 4, 8", pixels);
    }
    return exit_code == PROGRAM_DONE ? add(from, &(script_step){.kind = SCRIPT_COARSE, .count = (unsigned)pixels})
                                     : exit_code;
}

/* The word's place among names; below 0: it is none of them. */
static int find_name(const char *word, int count, const char *(*name)(int index))
{
    int index = count - 1;
    while (index >= 0 && strcmp(word, name(index)) != 0) {
        --index;
    }
    return index;
}

static const char *tool_name(int index)
{
    return view_brush_tool_name((view_brush_tool)index);
}

static const char *shape_name(int index)
{
    return view_brush_shape_name((view_brush_shape)index);
}

/* brush TOOL SHAPE RADIUS [R G B [MATERIAL]] */
static int read_brush(reader *from)
{
    script_brush brush = {.has_color = from->word_count > 4};
    double radius = 0;
    if (from->word_count < 4) {
        return fail(from, "'brush' lacks a tool, a shape or a radius");
    }
    const int tool = find_name(from->words[1], VIEW_BRUSH_TOOLS, tool_name);
    const int shape = find_name(from->words[2], VIEW_BRUSH_SHAPES, shape_name);
    if (tool < 0 || shape < 0) {
        return fail(from, "'%s' is not a %s", from->words[tool < 0 ? 1 : 2], tool < 0 ? "tool" : "shape");
    }
    int exit_code = read_number(from, 3, 0, (double)VIEW_BRUSH_MAX, &radius);
    for (size_t i = 0; i < 3 && brush.has_color && exit_code == PROGRAM_DONE; ++i) {
        exit_code = read_whole(from, 4 + i, 0, 255, &brush.color[i]);
    }
    if (from->word_count > 7 && exit_code == PROGRAM_DONE) {
        exit_code = read_whole(from, 7, 0, VIEW_BRUSH_MATERIAL_MAX, &brush.material);
    }
    brush.tool = (view_brush_tool)tool;
    brush.shape = (view_brush_shape)shape;
    brush.radius = (float)radius;
    return exit_code == PROGRAM_DONE ? add(from, &(script_step){.kind = SCRIPT_BRUSH, .brush = brush}) : exit_code;
}

/* drop FILE: on the window */
static int read_drop(reader *from)
{
    view_event event = {.kind = VIEW_EVENT_DROP};
    if (from->word_count != 2 || strlen(from->words[1]) >= sizeof event.path) {
        return fail(from, "'drop' takes one file name");
    }
    (void)snprintf(event.path, sizeof event.path, "%s", from->words[1]);
    return add_event(from, &event);
}

/* shot FILE */
static int read_shot(reader *from)
{
    return from->word_count == 2 ? add(from, &(script_step){.kind = SCRIPT_SHOT, .path = from->words[1]})
                                 : fail(from, "'shot' takes one file name");
}

typedef struct script_command {
    const char *name;
    int (*read)(reader *from);
} script_command;

static const script_command commands[] = {
    {"key", read_key},     {"text", read_text}, {"move", read_move},  {"click", read_click},   {"drag", read_drag},
    {"wheel", read_wheel}, {"size", read_size}, {"wait", read_wait},  {"refine", read_refine}, {"coarse", read_coarse},
    {"drop", read_drop},   {"shot", read_shot}, {"brush", read_brush}};

#define COMMANDS (sizeof commands / sizeof commands[0])

/* ---- files ---- */

static int read_line(reader *from, char *line)
{
    char *rest = NULL;
    from->word_count = 0;
    for (char *word = strtok_r(line, " \t\r", &rest); word != NULL && word[0] != '#';
         word = strtok_r(NULL, " \t\r", &rest)) {
        if (from->word_count == SCRIPT_WORDS_MAX) {
            return fail(from, "more than %d words", SCRIPT_WORDS_MAX);
        }
        from->words[from->word_count++] = word;
    }
    from->is_loading = from->word_count > 1 && strcmp(from->words[0], "loading") == 0;
    if (from->is_loading) {
        memmove(from->words, from->words + 1, --from->word_count * sizeof *from->words);
    }
    for (size_t i = 0; i < COMMANDS && from->word_count > 0; ++i) {
        if (strcmp(commands[i].name, from->words[0]) == 0) {
            return commands[i].read(from);
        }
    }
    return from->word_count == 0 ? PROGRAM_DONE : fail(from, "'%s' is not a command", from->words[0]);
}

static int read_lines(reader *from)
{
    int exit_code = PROGRAM_DONE;
    for (char *line = from->out->text; line != NULL && exit_code == PROGRAM_DONE;) {
        char *end = strchr(line, '\n');
        if (end != NULL) {
            *end++ = '\0';
        }
        ++from->line;
        exit_code = read_line(from, line);
        line = end;
    }
    return exit_code;
}

/* The whole file as a string. */
static int read_file(program *running, const char *path, char **out)
{
    FILE *file = fopen(path, "rb");
    char *text = file != NULL ? malloc(SCRIPT_BYTES_MAX + 1) : NULL;
    if (text == NULL) {
        const int error = file == NULL ? errno : ENOMEM;
        if (file != NULL) {
            (void)fclose(file);
        }
        return program_fail(running, PROGRAM_FAILED, "%s: %s", path, strerror(error));
    }
    const size_t length = fread(text, 1, SCRIPT_BYTES_MAX + 1, file);
    const bool failed = ferror(file) != 0;
    (void)fclose(file);
    if (failed || length > SCRIPT_BYTES_MAX) {
        free(text);
        return program_fail(running, PROGRAM_FAILED, "%s: %s", path,
                            failed ? "it cannot be read" : "a script has at most 1048576 bytes");
    }
    text[length] = '\0';
    *out = text;
    return PROGRAM_DONE;
}

int script_open(program *running, const char *path, script *out)
{
    reader from = {.running = running, .path = path, .out = out};
    *out = (script){.text = NULL};
    int exit_code = read_file(running, path, &out->text);
    if (exit_code == PROGRAM_DONE) {
        exit_code = read_lines(&from);
    }
    if (exit_code != PROGRAM_DONE) {
        script_close(out);
    }
    return exit_code;
}

void script_close(script *which)
{
    free(which->steps);
    free(which->text);
    *which = (script){.text = NULL};
}

/* ---- playing ---- */

script_step script_next(script *which, const view_state *state)
{
    if (which->next == which->step_count) {
        return (script_step){.kind = SCRIPT_END};
    }
    const script_step *step = &which->steps[which->next];
    const bool is_over = step->kind == SCRIPT_WAIT     ? ++which->waited >= step->count
                         : step->kind == SCRIPT_REFINE ? which->waited++ > 0 && state->is_refined
                                                       : true;
    if (is_over) {
        ++which->next;
        which->waited = 0;
    }
    return *step;
}

/* A key that began the work goes up later. */
static size_t loading_index(const script *which)
{
    const script_step *next = &which->steps[which->next];
    const bool is_release = which->next < which->step_count && next->kind == SCRIPT_EVENT && !next->is_loading &&
                            next->event.kind == VIEW_EVENT_KEY && !next->event.is_down;
    return which->next + (is_release ? 1 : 0);
}

bool script_has_loading(const script *which, unsigned line)
{
    const size_t index = loading_index(which);
    return index < which->step_count && which->steps[index].is_loading &&
           (line == 0 || which->steps[index].line == line);
}

script_step script_next_loading(script *which)
{
    const size_t index = loading_index(which);
    const script_step step = which->steps[index];
    which->steps[index] = which->steps[which->next++];
    return step;
}
