/* SPDX-License-Identifier: MIT */
/* The parser and the help. */
#include "support/options_parse.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/options_rules.h"
#include "support/suggest.h"
#include "support/table.h"
#include "svocl/compact.h"
#include "svocl/plan.h"

/* Commands whose INPUT comes after a subject. */
#define SUBJECT_FIRST ((unsigned)OPTION_BENCH_COMMAND | (unsigned)OPTION_PARTS_COMMAND)

/* Whether an argument names the option: -L, -LVALUE, --name or --name=VALUE. */
static bool is_named(const rule *option, const char *argument)
{
    if (argument[1] != '-') {
        return option->letter != '\0' && option->letter == argument[1];
    }
    const size_t length = strcspn(argument + 2, "=");
    return strlen(option->name) == length && strncmp(option->name, argument + 2, length) == 0;
}

/* The option of that name: the command's, since commands may have different options of one name; or else another's. */
static const rule *find_rule(const command *which, const char *argument, const char **attached_value)
{
    const rule *found = NULL;
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        const rule *option = options_rule(i);
        if (is_named(option, argument) && (found == NULL || !options_apply(found, which))) {
            found = option;
        }
    }
    const char *behind = argument[1] != '-' ? argument + 2 : argument + 2 + strcspn(argument + 2, "=");
    *attached_value = argument[1] != '-' ? (*behind != '\0' ? behind : NULL) : (*behind == '=' ? behind + 1 : NULL);
    return found;
}

/* The long option that has one dash too few: "-depth". */
static const rule *find_one_dash(const command *which, const char *argument)
{
    const rule *found = NULL;
    const size_t length = strcspn(argument + 1, "=");
    for (size_t i = 0; argument[1] != '-' && length > 1 && options_rule(i) != NULL; ++i) {
        const rule *option = options_rule(i);
        if (strlen(option->name) == length && strncmp(option->name, argument + 1, length) == 0 &&
            options_apply(option, which)) {
            found = option;
        }
    }
    return found;
}

static int fail_one_dash(program *state, const rule *option, const char *argument, const char *next)
{
    const char *attached = strchr(argument, '=');
    const char *value = option->value_name == NULL ? NULL : attached != NULL ? attached + 1 : next;
    return program_fail(state, PROGRAM_WRONG_USAGE, "unknown option '%s', did you mean '--%s%s%s'?", argument,
                        option->name, value != NULL ? " " : "", value != NULL ? value : "");
}

/* Other programs ask for the voxels along an axis where -d asks for levels. */
static int fail_resolution(program *state, const char *argument, const char *next)
{
    const char *attached = strchr(argument, '=');
    const char *value = attached != NULL ? attached + 1 : next != NULL ? next : "";
    const unsigned long voxels = strtoul(value, NULL, 10);
    unsigned depth = SVO_DEPTH_MIN;
    while (depth < SVO_DEPTH_MAX && 1ul << depth < voxels) {
        ++depth;
    }
    return voxels < 2 || voxels > 1ul << SVO_DEPTH_MAX
               ? program_fail(state, PROGRAM_WRONG_USAGE,
                              "unknown option '%s', did you mean '--depth D', for 2^D voxels along each axis?",
                              argument)
               : program_fail(state, PROGRAM_WRONG_USAGE,
                              "unknown option '%s', did you mean '--depth %u', for %lu voxels along each axis?",
                              argument, depth, 1ul << depth);
}

static bool is_resolution(const command *which, const char *argument)
{
    static const char *const names[] = {"resolution", "res", "grid", "voxels"};
    const char *name = argument + strspn(argument, "-");
    const size_t length = strcspn(name, "=");
    bool found = false;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        found = found || (strlen(names[i]) == length && strncmp(names[i], name, length) == 0);
    }
    return found && (which->groups & (unsigned)OPTION_BUILD) != 0;
}

static int fail_unknown(program *state, const command *which, const char *argument, const char *next)
{
    if (is_resolution(which, argument)) {
        return fail_resolution(state, argument, next);
    }
    const char *name = argument + strspn(argument, "-");
    suggestion near = suggestion_begin(name, strcspn(name, "="));
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        if (options_apply(options_rule(i), which)) {
            suggestion_offer(&near, options_rule(i)->name);
        }
    }
    const suggestion_text words = suggestion_end_option(&near);
    return program_fail(state, PROGRAM_WRONG_USAGE, "unknown option '%s'%s", argument, words.text);
}

/* Reads the option at arguments[*index]; moves *index past a value that follows it. */
static int parse_option(program *state, const command *which, int argument_count, char **arguments, int *index)
{
    const char *argument = arguments[*index];
    const char *value = NULL;
    const char *next = *index + 1 < argument_count ? arguments[*index + 1] : NULL;
    const rule *one_dash = find_one_dash(which, argument);
    if (one_dash != NULL) {
        return fail_one_dash(state, one_dash, argument, next);
    }
    const rule *option = find_rule(which, argument, &value);
    if (option == NULL) {
        return fail_unknown(state, which, argument, next);
    }
    if (!options_apply(option, which)) {
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
    const size_t place = (size_t)(option - options_rule(0));
    state->options.given_groups |= option->group;
    state->options.given_rules[place / 64] |= (uint64_t)1 << place % 64;
    state->options.given_values[place] = value;
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
        } else if ((which->groups & SUBJECT_FIRST) != 0 && state->options.subject == NULL) {
            state->options.subject = arguments[i];
        } else if ((which->groups & (unsigned)OPTION_CONVERT_COMMAND) != 0 && state->options.input != NULL &&
                   state->options.output_path == NULL) {
            state->options.output_path = arguments[i];
        } else if ((which->groups & (OPTION_DIFF_COMMAND | OPTION_EDIT_COMMAND)) != 0 && state->options.input != NULL &&
                   state->options.second_input == NULL) {
            state->options.second_input = arguments[i];
        } else if ((which->groups & (unsigned)OPTION_BENCH_COMMAND) != 0 && state->options.input != NULL &&
                   state->options.further_count < OPTION_INPUTS_MAX) {
            state->options.further_inputs[state->options.further_count++] = arguments[i];
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
           given->frontend == OPTION_FRONTEND_GL_HYBRID || given->tune || given->builder == OPTION_BUILDER_GL_COMPUTE;
}

/* Combinations of options that exclude or require one another. */
static int check_together(program *state, const command *which)
{
    options *given = &state->options;
    if (which->needs_input && given->input == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s is missing, see svocl %s --help", which->input_name,
                            which->name);
    }
    if (given->depth > SVO_DEPTH_MAX && strcmp(which->name, "parts") != 0) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "depth %" PRIu64 " is above %d; svocl parts plan takes %d, for folders that are trees",
                            given->depth, SVO_DEPTH_MAX, SVO_PARTS_DEPTH_MAX);
    }
    if (given->quiet && given->verbose) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--quiet and --verbose exclude each other");
    }
    if (given->has_origin != (given->edge > 0.0)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--origin and --edge require each other, --%s is missing",
                            given->has_origin ? "edge" : "origin");
    }
    if (given->voxel_size > 0.0 && (given->has_depth || given->has_origin || given->animate)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--voxel-size and --%s exclude each other",
                            given->has_depth    ? "depth"
                            : given->has_origin ? "origin"
                                                : "animate");
    }
    if (given->gl_device != NULL && given->context == OPTION_CONTEXT_AUTO) {
        given->context = SVO_GL_EGL_DEVICE;
    }
    if (given->gl_device != NULL && given->context != SVO_GL_EGL_DEVICE) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--gl-device requires --context egl-device");
    }
    if (given->hybrid_columns != 0 && given->frontend != OPTION_FRONTEND_GL_HYBRID) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--hybrid-columns requires --frontend gl-hybrid");
    }
    if (given->tune && (given->hybrid_columns != 0 || given->builder == OPTION_BUILDER_GL_COMPUTE ||
                        (given->frontend != OPTION_FRONTEND_AUTO && given->frontend != OPTION_FRONTEND_GL_HYBRID))) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--tune chooses the front end and its --hybrid-columns");
    }
    if (given->frontend == OPTION_FRONTEND_CL && options_ask_for_gl(given)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s requires OpenGL, which --frontend cl does not use",
                            given->builder == OPTION_BUILDER_GL_COMPUTE ? "builder gl-compute"
                            : given->share != SVO_GL_SHARE_AUTO         ? "share"
                                                                        : "context");
    }
    if (given->tree_form == 0 && (given->minimize || given->directory_step_log2 != 0)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s requires --tree-form",
                            given->minimize ? "minimize" : "directory-step");
    }
    if (given->tree_form == 0 && options_packing(given) != NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s requires --tree-form", options_packing(given));
    }
    if (given->directory_step_log2 != 0 && given->tree_form != 1 + SVO_FORM_IMPLIED) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--directory-step requires --tree-form implied");
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
                               .photons = 1,
                               .gi = 1,
                               .ray_count = 1000000,
                               .samples = 16384,
                               .max_bytes = OPTION_DEFAULT_PAGE,
                               .band = 3,
                               .margin = -1};
    const int result = parse_all(state, which, argument_count, arguments);
    if (result != PROGRAM_DONE || state->options.help) {
        return result;
    }
    return check_together(state, which);
}

/* ---- what is on the command line ---- */

static bool is_among(const char *name, const char *const names[])
{
    size_t i = 0;
    while (names[i] != NULL && strcmp(names[i], name) != 0) {
        ++i;
    }
    return names[i] != NULL;
}

bool options_is_given_at(const options *given, size_t place)
{
    return (given->given_rules[place / 64] >> place % 64 & 1u) != 0;
}

static int refuse(program *state, const rule *option, const char *where)
{
    return program_fail(state, PROGRAM_WRONG_USAGE, "option --%s does not apply %s", option->name, where);
}

bool options_is_given(const options *given, const char *name)
{
    bool found = false;
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        found = found || (options_is_given_at(given, i) && strcmp(options_rule(i)->name, name) == 0);
    }
    return found;
}

const char *options_input_path(const options *given, size_t place)
{
    const rule *option = options_rule(place);
    const bool is_output = (option->group & OPTION_TUNE_COMMAND) != 0 && strcmp(option->name, "lights") != 0;
    return options_is_given_at(given, place) && option->value_name != NULL && strcmp(option->value_name, "FILE") == 0 &&
                   option->group != (unsigned)OPTION_OUTPUT && option->group != OPTION_DIFF_COMMAND && !is_output
               ? *(const char *const *)((const char *)given + option->offset)
               : NULL;
}

int options_refuse(program *state, const char *const names[], const char *where)
{
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        if (options_is_given_at(&state->options, i) && is_among(options_rule(i)->name, names)) {
            return refuse(state, options_rule(i), where);
        }
    }
    return PROGRAM_DONE;
}

int options_refuse_groups(program *state, uint64_t groups, const char *where)
{
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        if (options_is_given_at(&state->options, i) && (options_rule(i)->group & groups) != 0) {
            return refuse(state, options_rule(i), where);
        }
    }
    return PROGRAM_DONE;
}

int options_take_only(program *state, uint64_t groups, const char *const names[], const char *where)
{
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        const bool is_taken = (options_rule(i)->group & (groups | (unsigned)OPTION_COMMON)) != 0;
        if (options_is_given_at(&state->options, i) && !is_taken && !is_among(options_rule(i)->name, names)) {
            return refuse(state, options_rule(i), where);
        }
    }
    return PROGRAM_DONE;
}

/* ---- help ---- */

bool options_may_lack_input(const command *which)
{
    return !which->needs_input && (which->groups & SUBJECT_FIRST) == 0;
}

void options_print_help(const command *which)
{
    printf("usage: svocl %s", which->name);
    if (which->input_name != NULL) {
        printf(options_may_lack_input(which) ? " [%s]" : " %s", which->input_name);
    }
    printf(" [options]\n\n%s\n\n", which->summary);
    table *rows = table_create("lll");
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        const rule *option = options_rule(i);
        if (!options_apply(option, which)) {
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
    table_print_wrapped(rows, TABLE_HELP_WIDTH);
}
