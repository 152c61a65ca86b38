/* SPDX-License-Identifier: MIT */
/* The table of options, and the parser and the help that use it. */
#include "support/options_parse.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scenes/scenes.h"
#include "support/table.h"
#include "svocl/trace.h"

typedef struct choice {
    const char *name;
    int value;
} choice;

typedef struct rule rule;
struct rule {
    const char *name;
    char letter; /* '\0': no short form */
    unsigned group;
    const char *value_name; /* NULL: a flag */
    int (*read)(program *state, const rule *option, const char *value);
    size_t offset; /* of the field in options */
    uint64_t minimum, maximum; /* read_count */
    const choice *choices; /* read_choice: ends with a NULL name */
    const char *help;
};

static const choice frontends[] = {{"auto", OPTION_FRONTEND_AUTO},
                                   {"cl", OPTION_FRONTEND_CL},
                                   {"gl-expand", OPTION_FRONTEND_GL_EXPAND},
                                   {"gl-hw", OPTION_FRONTEND_GL_HW},
                                   {NULL, 0}};
static const choice shares[] = {{"auto", SVO_GL_SHARE_AUTO},
                                {"interop", SVO_GL_SHARE_INTEROP},
                                {"host", SVO_GL_SHARE_HOST},
                                {"copy", SVO_GL_SHARE_COPY},
                                {NULL, 0}};
static const choice builders[] = {
    {"cl", SVO_BUILDER_CL}, {"sorted", SVO_BUILDER_SORTED}, {"gl-compute", OPTION_BUILDER_GL_COMPUTE}, {NULL, 0}};
static const choice coverages[] = {
    {"half-open", SVO_COVERAGE_HALF_OPEN}, {"closed", SVO_COVERAGE_CLOSED}, {"thin", SVO_COVERAGE_THIN}, {NULL, 0}};
static const choice weights[] = {
    {"area", SVO_WEIGHTS_AREA}, {"uniform", SVO_WEIGHTS_UNIFORM}, {"center", SVO_WEIGHTS_CENTER}, {NULL, 0}};
static const choice contexts[] = {{"auto", OPTION_CONTEXT_AUTO},
                                  {"surfaceless", SVO_GL_SURFACELESS},
                                  {"egl-device", SVO_GL_EGL_DEVICE},
                                  {"osmesa", SVO_GL_OSMESA},
                                  {NULL, 0}};

static const choice views[] = {{"shaded", SVO_VIEW_SHADED},
                               {"normal", SVO_VIEW_NORMAL},
                               {"depth", SVO_VIEW_DEPTH},
                               {"steps", SVO_VIEW_STEPS},
                               {"level", SVO_VIEW_LEVEL},
                               {"triangles", SVO_VIEW_TRIANGLES},
                               {NULL, 0}};
static const choice rivals[] = {{"none", 0}, {"embree", 1}, {NULL, 0}};

static void *field(program *state, const rule *option)
{
    return (char *)&state->options + option->offset;
}

static int read_flag(program *state, const rule *option, const char *value)
{
    (void)value;
    *(uint64_t *)field(state, option) = 1;
    return PROGRAM_DONE;
}

static int read_text(program *state, const rule *option, const char *value)
{
    if (value[0] == '\0') {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s is empty", option->name);
    }
    *(const char **)field(state, option) = value;
    return PROGRAM_DONE;
}

static int read_count(program *state, const rule *option, const char *value)
{
    errno = 0;
    char *end = NULL;
    const unsigned long long number = strtoull(value, &end, 10);
    if (value[0] < '0' || value[0] > '9' || *end != '\0') {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s '%s' is not a whole number", option->name, value);
    }
    if (errno == ERANGE || number > option->maximum) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s %s is above %" PRIu64, option->name, value,
                            option->maximum);
    }
    if (number < option->minimum) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s %s is below %" PRIu64, option->name, value,
                            option->minimum);
    }
    *(uint64_t *)field(state, option) = number;
    return PROGRAM_DONE;
}

/* "auto, cl, gl-expand, gl-hw" */
static void list_choices(const choice *choices, char *text, size_t text_bytes)
{
    size_t used = 0;
    text[0] = '\0';
    for (const choice *one = choices; one->name != NULL && used < text_bytes; ++one) {
        used += (size_t)snprintf(text + used, text_bytes - used, "%s%s", used == 0 ? "" : ", ", one->name);
    }
}

static int read_choice(program *state, const rule *option, const char *value)
{
    for (const choice *one = option->choices; one->name != NULL; ++one) {
        if (strcmp(one->name, value) == 0) {
            *(int *)field(state, option) = one->value;
            return PROGRAM_DONE;
        }
    }
    char known[128];
    list_choices(option->choices, known, sizeof known);
    return program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is none of %s", option->name, value, known);
}

static bool parse_number(const char *text, char **end, double *number)
{
    *number = strtod(text, end);
    return *end != text && isfinite(*number);
}

static int read_origin(program *state, const rule *option, const char *value)
{
    double *origin = field(state, option);
    const char *rest = value;
    for (int axis = 0; axis < 3; ++axis) {
        char *end = NULL;
        if (!parse_number(rest, &end, &origin[axis]) || *end != (axis < 2 ? ',' : '\0')) {
            return program_fail(state, PROGRAM_WRONG_USAGE, "origin '%s' is not of the form x,y,z", value);
        }
        rest = end + 1;
    }
    state->options.has_origin = true;
    return PROGRAM_DONE;
}

static int read_edge(program *state, const rule *option, const char *value)
{
    double *edge = field(state, option);
    char *end = NULL;
    if (!parse_number(value, &end, edge) || *end != '\0' || *edge <= 0.0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "edge '%s' is not a number above 0", value);
    }
    return PROGRAM_DONE;
}

static uint32_t need_bit(const char *name, size_t length)
{
    for (uint32_t bit = 1; bit < SVO_NEED_ALL; bit *= 2) {
        const char *known = svo_need_name((svo_need)bit);
        if (strlen(known) == length && strncmp(known, name, length) == 0) {
            return bit;
        }
    }
    return 0;
}

static int read_need(program *state, const rule *option, const char *value)
{
    uint32_t need = 0;
    for (const char *name = value; strcmp(value, "none") != 0;) {
        const size_t length = strcspn(name, ",");
        const uint32_t bit = need_bit(name, length);
        if (bit == 0) {
            return program_fail(state, PROGRAM_WRONG_USAGE,
                                "--need '%s' is neither none nor a list of color, normal, rays, material, fill", value);
        }
        need |= bit;
        if (name[length] == '\0') {
            break;
        }
        name += length + 1;
    }
    *(uint32_t *)field(state, option) = need == 0 ? (uint32_t)SVO_NEED_NONE : need;
    return PROGRAM_DONE;
}

static int read_depth(program *state, const rule *option, const char *value)
{
    state->options.has_depth = true;
    return read_count(state, option, value);
}

static int read_repeat(program *state, const rule *option, const char *value)
{
    state->options.has_repeat = true;
    return read_count(state, option, value);
}

static int read_triangles(program *state, const rule *option, const char *value)
{
    state->options.has_triangles = true;
    return read_count(state, option, value);
}

static int read_seed(program *state, const rule *option, const char *value)
{
    state->options.has_seed = true;
    return read_count(state, option, value);
}

static int read_pixels(program *state, const rule *option, const char *value)
{
    uint32_t *pixels = field(state, option); /* width, then height */
    const char *rest = value;
    for (int i = 0; i < 2; ++i) {
        char *end = NULL;
        const unsigned long number = rest[0] >= '0' && rest[0] <= '9' ? strtoul(rest, &end, 10) : 0;
        if (end == NULL || *end != (i == 0 ? 'x' : '\0') || number < option->minimum || number > option->maximum) {
            return program_fail(state, PROGRAM_WRONG_USAGE,
                                "size '%s' is not WIDTHxHEIGHT, each %" PRIu64 " to %" PRIu64, value, option->minimum,
                                option->maximum);
        }
        pixels[i] = (uint32_t)number;
        rest = end + 1;
    }
    return PROGRAM_DONE;
}

#define FIELD(name) offsetof(options, name)

static const rule rules[] = {
    {"depth", 'd', OPTION_BUILD, "D", read_depth, FIELD(depth), SVO_DEPTH_MIN, SVO_DEPTH_MAX, NULL,
     "levels below the root: 2^D voxels per axis, 1 to 16 (8)"},
    {"need", '\0', OPTION_BUILD, "LIST", read_need, FIELD(need), 0, 0, NULL,
     "color,normal,rays,material,fill or none (colors and normals of the mesh)"},
    {"origin", '\0', OPTION_BUILD, "X,Y,Z", read_origin, FIELD(origin), 0, 0, NULL,
     "minimum corner of the grid, requires --edge (fitted to the mesh)"},
    {"edge", '\0', OPTION_BUILD, "E", read_edge, FIELD(edge), 0, 0, NULL,
     "width of the grid, requires --origin (fitted to the mesh)"},
    {"coverage", '\0', OPTION_BUILD, "NAME", read_choice, FIELD(coverage), 0, 0, coverages,
     "half-open, closed, thin (half-open)"},
    {"weights", '\0', OPTION_BUILD, "NAME", read_choice, FIELD(weights), 0, 0, weights,
     "weight of a triangle in a mean: area, uniform, center (area)"},
    {"frontend", '\0', OPTION_BUILD | OPTION_METHODS, "NAME", read_choice, FIELD(frontend), 0, 0, frontends,
     "auto, cl, gl-expand, gl-hw (auto: the fastest)"},
    {"share", '\0', OPTION_BUILD | OPTION_METHODS, "NAME", read_choice, FIELD(share), 0, 0, shares,
     "auto, interop, host, copy (auto)"},
    {"builder", '\0', OPTION_BUILD, "NAME", read_choice, FIELD(builder), 0, 0, builders,
     "cl: top-down; sorted: bottom-up; gl-compute: top-down in OpenGL (cl)"},
    {"context", '\0', OPTION_BUILD | OPTION_METHODS, "NAME", read_choice, FIELD(context), 0, 0, contexts,
     "auto, surfaceless, egl-device, osmesa (auto)"},
    {"gl-device", '\0', OPTION_BUILD | OPTION_METHODS, "NAME", read_text, FIELD(gl_device), 0, 0, NULL,
     "EGL device: its index, part of its name, or gpu (0)"},
    {"device", '\0', OPTION_DEVICE, "NAME", read_text, FIELD(device_name), 0, 0, NULL,
     "OpenCL device: part of its name, or P.D indices"},
    {"threads", '\0', OPTION_DEVICE, "N", read_count, FIELD(threads), 1, 1024, NULL,
     "threads of PoCL and llvmpipe, 1 to 1024 (all cores)"},
    {"output", 'o', OPTION_OUTPUT, "FILE", read_text, FIELD(output_path), 0, 0, NULL, "file to write"},
    {"triangles", '\0', OPTION_SCENE_COMMAND, "N", read_triangles, FIELD(triangles), 1, SCENE_TRIANGLES_MAX, NULL,
     "approximate number of triangles (the default of the scene)"},
    {"seed", '\0', OPTION_SCENE_COMMAND | OPTION_STRESS_COMMAND, "S", read_seed, FIELD(seed), 0, UINT32_MAX, NULL,
     "random seed (1)"},
    {"count", '\0', OPTION_STRESS_COMMAND, "N", read_count, FIELD(count), 0, 1000, NULL,
     "amount of work, 0 to 1000: triangles per case grow with it (8)"},
    {"size", '\0', OPTION_PICTURE_SIZE, "WxH", read_pixels, FIELD(width), 1, 16384, NULL,
     "size of the image in pixels (1024x768)"},
    {"rays", '\0', OPTION_TRACE_COMMAND, "FILE", read_text, FIELD(rays_path), 0, 0, NULL,
     "CSV file with one ray per line: ox,oy,oz,dx,dy,dz"},
    {"camera", '\0', OPTION_TRACE_COMMAND, "VIEW", read_text, FIELD(camera), 0, 0, NULL,
     "one ray per pixel: auto, or eye, target, up, degrees as 6, 9 or 10 numbers"},
    {"view", '\0', OPTION_RENDER_COMMAND, "NAME", read_choice, FIELD(view), 0, 0, views,
     "shaded, normal, depth, steps, level, triangles (shaded)"},
    {"repeat", '\0', OPTION_BUILD_COMMAND | OPTION_MEASURE, "N", read_repeat, FIELD(repeat), 1, 10000, NULL,
     "repeat N times and report medians; builds leave out the first (1; measurements: 11 after a warm-up)"},
    {"scenes", '\0', OPTION_MEASURE, "LIST", read_text, FIELD(scenes), 0, 0, NULL,
     "comma-separated INPUTs without their scene: prefix (each measurement has its own)"},
    {"depths", '\0', OPTION_MEASURE, "LIST", read_text, FIELD(depths), 0, 0, NULL,
     "comma-separated depths (each measurement has its own)"},
    {"quick", '\0', OPTION_MEASURE, NULL, read_flag, FIELD(quick), 0, 0, NULL,
     "smaller scenes, fewer depths, 3 repeats: a quick check"},
    {"from", '\0', OPTION_REPORT_COMMAND, "FILE", read_text, FIELD(from), 0, 0, NULL,
     "JSON file written by svocl bench -o, used in place of new measurements"},
    {"docs", '\0', OPTION_REPORT_COMMAND, "DIR", read_text, FIELD(docs), 0, 0, NULL,
     "update the marked tables of DIR/README.md and DIR/docs/*.md; -o is then optional"},
    {"plan", '\0', OPTION_BUILD_COMMAND, NULL, read_flag, FIELD(plan), 0, 0, NULL,
     "print what the build will run, allocate and leave out, then build"},
    {"plan-only", '\0', OPTION_BUILD_COMMAND, NULL, read_flag, FIELD(plan_only), 0, 0, NULL,
     "print the plan without building"},
    {"count-first", '\0', OPTION_BUILD_COMMAND, NULL, read_flag, FIELD(count_first), 0, 0, NULL,
     "count the fragments before allocating memory for them"},
    {"payload-level", '\0', OPTION_BUILD_COMMAND, "N", read_count, FIELD(payload_level), 0, SVO_DEPTH_MAX, NULL,
     "first level with payload, 0 to 16 (0: all levels)"},
    {"compress", '\0', OPTION_BUILD_COMMAND, NULL, read_flag, FIELD(compress), 0, 0, NULL,
     "compress the .svo file with zstd"},
    {"nodes", '\0', OPTION_HASH_COMMAND, NULL, read_flag, FIELD(nodes), 0, 0, NULL,
     "hash only the nodes, without lists and payload"},
    {"vs", '\0', OPTION_BENCH_COMMAND, "NAME", read_choice, FIELD(versus), 0, 0, rivals,
     "also measure this library, interleaved: embree (none)"},
    {"ray-count", '\0', OPTION_BENCH_COMMAND, "N", read_count, FIELD(ray_count), 1, 100000000, NULL,
     "rays per set (1000000)"},
    {"json", '\0', OPTION_JSON, NULL, read_flag, FIELD(json), 0, 0, NULL, "print JSON on standard output"},
    {"verbose", 'v', OPTION_COMMON, NULL, read_flag, FIELD(verbose), 0, 0, NULL, "print the library's log"},
    {"help", 'h', OPTION_COMMON, NULL, read_flag, FIELD(help), 0, 0, NULL, "print this help"},
};

#define RULE_COUNT (sizeof rules / sizeof rules[0])

static const rule *find_rule(const char *argument, const char **attached_value)
{
    *attached_value = NULL;
    if (argument[1] != '-') {
        for (size_t i = 0; i < RULE_COUNT; ++i) {
            if (rules[i].letter != '\0' && rules[i].letter == argument[1]) {
                *attached_value = argument[2] != '\0' ? argument + 2 : NULL;
                return &rules[i];
            }
        }
        return NULL;
    }
    const size_t length = strcspn(argument + 2, "=");
    for (size_t i = 0; i < RULE_COUNT; ++i) {
        if (strlen(rules[i].name) == length && strncmp(rules[i].name, argument + 2, length) == 0) {
            *attached_value = argument[2 + length] == '=' ? argument + 3 + length : NULL;
            return &rules[i];
        }
    }
    return NULL;
}

/* Reads the option at arguments[*index]; moves *index past a value that follows it. */
static int parse_option(program *state, const command *which, int argument_count, char **arguments, int *index)
{
    const char *argument = arguments[*index];
    const char *value = NULL;
    const rule *option = find_rule(argument, &value);
    if (option == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "unknown option '%s'", argument);
    }
    if ((option->group & (which->groups | (unsigned)OPTION_COMMON)) == 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --%s does not apply to this command", option->name);
    }
    if (option->value_name == NULL && value != NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "option --%s takes no value, got '%s'", option->name, value);
    }
    if (option->value_name != NULL && value == NULL) {
        if (*index + 1 >= argument_count) {
            return program_fail(state, PROGRAM_WRONG_USAGE, "option --%s needs a value: %s", option->name,
                                option->value_name);
        }
        value = arguments[++*index];
    }
    state->options.given_groups |= option->group;
    return option->read(state, option, value);
}

static int parse_all(program *state, const command *which, int argument_count, char **arguments)
{
    bool only_input = false;
    for (int i = 0; i < argument_count; ++i) {
        if (!only_input && strcmp(arguments[i], "--") == 0) {
            only_input = true;
        } else if (!only_input && arguments[i][0] == '-' && arguments[i][1] != '\0') {
            const int result = parse_option(state, which, argument_count, arguments, &i);
            if (result != PROGRAM_DONE) {
                return result;
            }
        } else if ((which->groups & (unsigned)OPTION_BENCH_COMMAND) != 0 && state->options.subject == NULL) {
            state->options.subject = arguments[i];
        } else if (which->input_name == NULL || state->options.input != NULL) {
            return program_fail(state, PROGRAM_WRONG_USAGE, "unexpected argument '%s'", arguments[i]);
        } else {
            state->options.input = arguments[i];
        }
    }
    return PROGRAM_DONE;
}

bool options_ask_for_gl(const options *given)
{
    return given->share != SVO_GL_SHARE_AUTO || given->context != OPTION_CONTEXT_AUTO ||
           given->frontend == OPTION_FRONTEND_GL_EXPAND || given->frontend == OPTION_FRONTEND_GL_HW ||
           given->builder == OPTION_BUILDER_GL_COMPUTE;
}

/* Combinations of options that exclude or require one another. */
static int check_together(program *state, const command *which)
{
    options *given = &state->options;
    if (which->needs_input && given->input == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s is missing, see svocl %s --help", which->input_name,
                            which->name);
    }
    if (given->has_origin != (given->edge > 0.0)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--origin and --edge require each other, --%s is missing",
                            given->has_origin ? "edge" : "origin");
    }
    if (given->gl_device != NULL && given->context == OPTION_CONTEXT_AUTO) {
        given->context = SVO_GL_EGL_DEVICE;
    }
    if (given->gl_device != NULL && given->context != SVO_GL_EGL_DEVICE) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--gl-device requires --context egl-device");
    }
    if (given->frontend == OPTION_FRONTEND_CL && options_ask_for_gl(given)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s requires OpenGL, which --frontend cl does not use",
                            given->builder == OPTION_BUILDER_GL_COMPUTE ? "builder gl-compute"
                            : given->share != SVO_GL_SHARE_AUTO         ? "share"
                                                                        : "context");
    }
    return PROGRAM_DONE;
}

int options_parse(program *state, const command *which, int argument_count, char **arguments)
{
    state->options = (options){.depth = OPTION_DEFAULT_DEPTH,
                               .context = OPTION_CONTEXT_AUTO,
                               .repeat = 1,
                               .seed = 1,
                               .width = 1024,
                               .height = 768,
                               .count = 8,
                               .ray_count = 1000000};
    const int result = parse_all(state, which, argument_count, arguments);
    if (result != PROGRAM_DONE || state->options.help) {
        return result;
    }
    return check_together(state, which);
}

void options_print_help(const command *which)
{
    printf("usage: svocl %s%s%s [options]\n\n%s\n\n", which->name, which->input_name != NULL ? " " : "",
           which->input_name != NULL ? which->input_name : "", which->summary);
    table *rows = table_create("lll");
    for (size_t i = 0; i < RULE_COUNT; ++i) {
        const rule *option = &rules[i];
        if ((option->group & (which->groups | (unsigned)OPTION_COMMON)) == 0) {
            continue;
        }
        if (option->letter != '\0') {
            table_cell(rows, "-%c,", option->letter);
        } else {
            table_cell(rows, "%s", "");
        }
        table_cell(rows, "--%s %s", option->name, option->value_name != NULL ? option->value_name : "");
        table_cell(rows, "%s", option->help);
    }
    table_print(rows);
}
