/* SPDX-License-Identifier: MIT */
/* Names of values are those of the options of the same name. */
#include "tune/dimensions.h"

#include <stdlib.h>
#include <string.h>

#include "support/options_parse.h"
#include "support/options_rules.h"
#include "support/suggest.h"
#include "svocl/svocl.h"
#include "tune/text_list.h"

static const char *const names[DIMENSION_COUNT] = {"depth",   "coverage", "weights", "frontend",   "share",
                                                   "builder", "path",     "form",    "light-form", "gather"};

const char *dimension_name(tune_dimension which)
{
    return names[which];
}

/* ---- values ---- */

static const choice forms[] = {{"tree", 0},
                               {"descriptor", 1 + SVO_FORM_DESCRIPTOR},
                               {"implied", 1 + SVO_FORM_IMPLIED},
                               {"shared", 1 + SVO_FORM_SHARED},
                               {NULL, 0}};
static const choice ray_sets[] = {{"16", -16},   {"32", -32},   {"64", -64},     {"128", -128},
                                  {"256", -256}, {"512", -512}, {"1024", -1024}, {NULL, 0}};

/* The choices of the first option of a name, which is light's; NULL for numbers. */
static const choice *choices_named(const char *name)
{
    size_t place = 0;
    while (options_rule(place) != NULL && strcmp(options_rule(place)->name, name) != 0) {
        ++place;
    }
    return options_rule(place) != NULL ? options_rule(place)->choices : NULL;
}

static const choice *choices_of(tune_dimension which)
{
    return which == DIMENSION_FORM ? forms : choices_named(which == DIMENSION_LIGHT_FORM ? "form" : names[which]);
}

static const char *choice_name(const choice *choices, int value)
{
    while (choices != NULL && choices->name != NULL && choices->value != value) {
        ++choices;
    }
    return choices != NULL && choices->name != NULL ? choices->name : NULL;
}

void dimension_value(tune_dimension which, int value, char *text, size_t text_bytes)
{
    const char *name = choice_name(choices_of(which), value);
    if (which == DIMENSION_GATHER) {
        (void)snprintf(text, text_bytes, "%d %s", abs(value), value > 0 ? "cones" : value < 0 ? "rays" : "");
        text[value == 0 ? 0 : strlen(text)] = '\0';
    } else if (name != NULL) {
        (void)snprintf(text, text_bytes, "%s", name);
    } else if (which == DIMENSION_PATH && value == 0) {
        (void)snprintf(text, text_bytes, "auto");
    } else {
        (void)snprintf(text, text_bytes, "%d", value);
    }
}

/* ---- --free ---- */

typedef struct free_reader {
    program *state;
    const unsigned *depths;
    tune_space *space;
} free_reader;

static int add_value(const free_reader *reader, tune_dimension which, int value)
{
    tune_space *space = reader->space;
    if (!space->is_free[which]) {
        space->is_free[which] = true;
        space->counts[which] = 0;
    }
    for (size_t i = 0; i < space->counts[which]; ++i) {
        if (space->values[which][i] == value) {
            return PROGRAM_DONE; /* named twice */
        }
    }
    if (space->counts[which] == DIMENSION_VALUES_MAX) {
        return program_fail(reader->state, PROGRAM_WRONG_USAGE, "--free: %s has more than %u values", names[which],
                            DIMENSION_VALUES_MAX);
    }
    space->values[which][space->counts[which]++] = value;
    return PROGRAM_DONE;
}

/* "7" or "7-9". */
static int add_depths(const free_reader *reader, const char *text, size_t length)
{
    char *end = NULL;
    const unsigned long first = strtoul(text, &end, 10);
    const unsigned long last = *end == '-' ? strtoul(end + 1, &end, 10) : first;
    int exit_code = PROGRAM_DONE;
    if (end != text + length || first < SVO_DEPTH_MIN || last > SVO_DEPTH_MAX || first > last) {
        return program_fail(reader->state, PROGRAM_WRONG_USAGE,
                            "--free: '%.*s' is no depth or range of depths in %d .. %d", (int)length, text,
                            SVO_DEPTH_MIN, SVO_DEPTH_MAX);
    }
    for (unsigned long depth = first; depth <= last && exit_code == PROGRAM_DONE; ++depth) {
        exit_code = add_value(reader, DIMENSION_DEPTH, (int)depth);
    }
    return exit_code;
}

static int add_choice(const free_reader *reader, tune_dimension which, const choice *choices, const char *text,
                      size_t length)
{
    suggestion near = suggestion_begin(text, length);
    for (const choice *one = choices; one->name != NULL; ++one) {
        if (strlen(one->name) == length && strncmp(one->name, text, length) == 0) {
            return add_value(reader, which, one->value);
        }
        suggestion_offer(&near, one->name);
    }
    return program_fail(reader->state, PROGRAM_WRONG_USAGE, "--free: '%.*s' is no value of %s%s", (int)length, text,
                        which != DIMENSION_GATHER ? names[which]
                        : choices == ray_sets     ? "rays"
                                                  : "cones",
                        suggestion_end(&near).text);
}

static int add_all(const free_reader *reader, tune_dimension which, const choice *choices)
{
    int exit_code = PROGRAM_DONE;
    if (which == DIMENSION_DEPTH) {
        for (const unsigned *depth = reader->depths; *depth != 0 && exit_code == PROGRAM_DONE; ++depth) {
            exit_code = add_value(reader, which, (int)*depth);
        }
        return exit_code;
    }
    for (; choices->name != NULL && exit_code == PROGRAM_DONE; ++choices) {
        exit_code = add_value(reader, which, choices->value);
    }
    return exit_code;
}

/* The dimension and the choices of a name of --free. */
static bool find_free(const char *name, size_t length, tune_dimension *which, const choice **choices)
{
    const bool cones = length == 5 && strncmp(name, "cones", length) == 0;
    if (cones || (length == 4 && strncmp(name, "rays", length) == 0)) {
        *which = DIMENSION_GATHER;
        *choices = cones ? choices_named("cones") : ray_sets;
        return true;
    }
    for (*which = DIMENSION_DEPTH; *which < DIMENSION_GATHER; ++*which) {
        if (strlen(names[*which]) == length && strncmp(names[*which], name, length) == 0) {
            *choices = choices_of(*which);
            return true;
        }
    }
    return false;
}

static int fail_free(program *state, const char *text, size_t length)
{
    suggestion near = suggestion_begin(text, length);
    for (int i = 0; i < DIMENSION_GATHER; ++i) {
        suggestion_offer(&near, names[i]);
    }
    suggestion_offer(&near, "cones");
    suggestion_offer(&near, "rays");
    return program_fail(state, PROGRAM_WRONG_USAGE,
                        "--free: '%.*s' is none of depth, coverage, weights, frontend, share, builder, path, form, "
                        "light-form, cones, rays%s",
                        (int)length, text, suggestion_end(&near).text);
}

/* One "NAME" or "NAME:VALUE+VALUE". */
static int read_free(const free_reader *reader, const char *text, size_t length)
{
    tune_dimension which;
    const choice *choices = NULL;
    const size_t name_length = strcspn(text, ":,");
    int exit_code = PROGRAM_DONE;
    if (!find_free(text, name_length, &which, &choices)) {
        return fail_free(reader->state, text, name_length);
    }
    if (name_length == length) {
        return add_all(reader, which, choices);
    }
    for (const char *value = text + name_length + 1; exit_code == PROGRAM_DONE; ++value) {
        const size_t value_length = strcspn(value, "+,");
        exit_code = which == DIMENSION_DEPTH ? add_depths(reader, value, value_length)
                                             : add_choice(reader, which, choices, value, value_length);
        value += value_length;
        if (*value != '+') {
            break;
        }
    }
    return exit_code;
}

static void fix_values(const options *given, tune_space *space)
{
    const int fixed[DIMENSION_COUNT] = {
        [DIMENSION_DEPTH] = (int)given->depth, [DIMENSION_COVERAGE] = given->coverage,
        [DIMENSION_WEIGHTS] = given->weights,  [DIMENSION_FRONTEND] = given->frontend,
        [DIMENSION_SHARE] = given->share,      [DIMENSION_BUILDER] = given->builder,
        [DIMENSION_PATH] = given->path,
    };
    *space = (tune_space){.counts = {0}};
    for (int i = 0; i < DIMENSION_COUNT; ++i) {
        space->values[i][0] = fixed[i];
        space->counts[i] = 1;
    }
}

/* Of what is not named on the command line, what is free without --free. */
static int free_usual(const free_reader *reader)
{
    static const int usual_builders[] = {SVO_BUILDER_CL, SVO_BUILDER_SORTED};
    const options *given = &reader->state->options;
    int exit_code = given->has_depth ? PROGRAM_DONE : add_all(reader, DIMENSION_DEPTH, NULL);
    for (int i = DIMENSION_COVERAGE; i <= DIMENSION_WEIGHTS && exit_code == PROGRAM_DONE; ++i) {
        if (!options_is_given(given, names[i])) {
            exit_code = add_all(reader, (tune_dimension)i, choices_of((tune_dimension)i));
        }
    }
    for (size_t i = 0; i < 2 && !given->has_builder && exit_code == PROGRAM_DONE; ++i) {
        exit_code = add_value(reader, DIMENSION_BUILDER, usual_builders[i]);
    }
    return exit_code;
}

int tune_space_read(program *state, const unsigned *depths, bool gathers, tune_space *space)
{
    static const int usual_gathers[] = {5, 16, -16, -64, -256};
    const free_reader reader = {state, depths, space};
    const char *text = state->options.free_list;
    fix_values(&state->options, space);
    int exit_code = text == NULL ? free_usual(&reader) : PROGRAM_DONE;
    while (text != NULL && exit_code == PROGRAM_DONE) {
        const size_t length = strcspn(text, ",");
        exit_code = read_free(&reader, text, length);
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    for (size_t i = 0; i < 5 && gathers && !space->is_free[DIMENSION_GATHER] && exit_code == PROGRAM_DONE; ++i) {
        space->values[DIMENSION_GATHER][i] = usual_gathers[i];
        space->counts[DIMENSION_GATHER] = i + 1;
    }
    return exit_code;
}

/* ---- settings ---- */

/* Whether the setting with the first values of the dimensions that do not matter to it is another one. */
static bool is_second_name(const tune_space *space, const tune_setting *setting)
{
    const int *at = setting->values;
    const bool in_gl = at[DIMENSION_BUILDER] == OPTION_BUILDER_GL_COMPUTE;
    const bool in_cl = at[DIMENSION_FRONTEND] == OPTION_FRONTEND_CL || at[DIMENSION_FRONTEND] == OPTION_FRONTEND_AUTO;
    return (in_gl && at[DIMENSION_FRONTEND] != space->values[DIMENSION_FRONTEND][0]) ||
           (in_cl && !in_gl && at[DIMENSION_SHARE] != space->values[DIMENSION_SHARE][0]) ||
           (at[DIMENSION_GATHER] <= 0 && at[DIMENSION_LIGHT_FORM] != space->values[DIMENSION_LIGHT_FORM][0]);
}

int tune_space_list(program *state, const tune_space *space, tune_setting *settings, size_t *count)
{
    size_t product = 1;
    *count = 0;
    for (int i = 0; i < DIMENSION_COUNT; ++i) {
        product *= space->counts[i]; /* below 16^10 */
    }
    for (size_t place = 0; place < product; ++place) {
        tune_setting one;
        size_t rest = place;
        for (int i = DIMENSION_COUNT - 1; i >= 0; --i) {
            one.values[i] = space->values[i][rest % space->counts[i]];
            rest /= space->counts[i];
        }
        if (is_second_name(space, &one)) {
            continue;
        }
        if (*count == TUNE_SETTINGS_MAX) {
            return program_fail(state, PROGRAM_WRONG_USAGE, "--free: more than %u settings", TUNE_SETTINGS_MAX);
        }
        settings[(*count)++] = one;
    }
    return PROGRAM_DONE;
}

/* ---- command lines ---- */

static void add_option(text_list *list, const tune_setting *setting, tune_dimension which, int usual)
{
    char value[32];
    if (setting->values[which] != usual) {
        dimension_value(which, setting->values[which], value, sizeof value);
        text_list_add(list, " --%s %s", names[which], value);
    }
}

/* As a word of a shell. */
static void add_word(text_list *list, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:,=+@%-";
    if (word[0] != '\0' && word[strspn(word, plain)] == '\0') {
        text_list_add(list, " %s", word);
        return;
    }
    text_list_add(list, " '");
    for (; *word != '\0'; ++word) {
        if (*word == '\'') {
            text_list_add(list, "'\\''");
        } else {
            text_list_add(list, "%c", *word);
        }
    }
    text_list_add(list, "'");
}

/* Whether an option is about what is built, and no setting has a value of its own for it. */
static bool is_carried(const program *state, size_t place)
{
    const rule *option = options_rule(place);
    bool carried = options_is_given_at(&state->options, place) &&
                   (option->group & (OPTION_COMMON | OPTION_JSON | OPTION_TUNE_COMMAND)) == 0;
    for (tune_dimension i = DIMENSION_DEPTH; i < DIMENSION_COUNT; ++i) {
        carried = carried && strcmp(option->name, names[i]) != 0;
    }
    return carried;
}

static void add_carried(text_list *list, const program *state)
{
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        if (is_carried(state, i)) {
            text_list_add(list, " --%s", options_rule(i)->name);
            if (state->options.given_values[i] != NULL) {
                add_word(list, state->options.given_values[i]);
            }
        }
    }
}

void tune_setting_command(const program *state, const tune_setting *setting, text_list *out)
{
    const int *at = setting->values;
    const int gather = at[DIMENSION_GATHER];
    text_list_clear(out);
    text_list_add(out, "svocl %s", gather != 0 ? "gather" : "build");
    add_word(out, state->options.input);
    text_list_add(out, " -d %d", at[DIMENSION_DEPTH]);
    for (tune_dimension i = DIMENSION_COVERAGE; i <= DIMENSION_PATH; ++i) {
        add_option(out, setting, i, 0);
    }
    add_carried(out, state);
    if (gather != 0) {
        text_list_add(out, gather > 0 ? " --method cones --cones %d" : " --method rays --paths %d", abs(gather));
        if (gather > 0 && at[DIMENSION_LIGHT_FORM] != SVO_LIGHT_FACES) {
            text_list_add(out, " --form %s", choice_name(choices_of(DIMENSION_LIGHT_FORM), at[DIMENSION_LIGHT_FORM]));
        }
        text_list_add(out, " --points points.csv -o light.csv");
    } else {
        text_list_add(out, " -o model.svo");
    }
}

/* ".coverage = SVO_COVERAGE_THIN": prefix and the name in upper case. */
static void add_field(text_list *list, const char *field, const char *prefix, const char *name)
{
    text_list_add(list, ", .%s = %s", field, prefix);
    for (; *name != '\0'; ++name) {
        const char letter = *name >= 'a' && *name <= 'z' ? (char)(*name - 'a' + 'A') : *name == '-' ? '_' : *name;
        text_list_add(list, "%c", letter);
    }
}

static void add_gather(text_list *list, const tune_setting *setting)
{
    const int gather = setting->values[DIMENSION_GATHER];
    if (gather > 0) {
        text_list_add(list, "; svo_light_options light = {.struct_size = sizeof light");
        add_field(list, "form", "SVO_LIGHT_",
                  choice_name(choices_of(DIMENSION_LIGHT_FORM), setting->values[DIMENSION_LIGHT_FORM]));
        text_list_add(list, "}");
    }
    if (gather != 0) {
        text_list_add(list, "; svo_gather_options gather = {.struct_size = sizeof gather, .method = %s, .%s = %d}",
                      gather > 0 ? "SVO_GATHER_CONES" : "SVO_GATHER_RAYS", gather > 0 ? "cones" : "paths", abs(gather));
    }
}

void tune_setting_code(const tune_setting *setting, text_list *out)
{
    const int *at = setting->values;
    text_list_clear(out);
    text_list_add(out, "/* depth %d */ svo_plan_options plan = {.struct_size = sizeof plan", at[DIMENSION_DEPTH]);
    add_field(out, "coverage", "SVO_COVERAGE_", svo_name(SVO_NAME_COVERAGE, (uint32_t)at[DIMENSION_COVERAGE]));
    add_field(out, "weights", "SVO_WEIGHTS_", svo_name(SVO_NAME_WEIGHTS, (uint32_t)at[DIMENSION_WEIGHTS]));
    if (at[DIMENSION_BUILDER] == SVO_BUILDER_SORTED) {
        text_list_add(out, ", .builder = SVO_BUILDER_SORTED");
    }
    text_list_add(out, "}");
    if (at[DIMENSION_FORM] > 0) {
        text_list_add(out, "; svo_compact_options compact = {.struct_size = sizeof compact");
        add_field(out, "form", "SVO_FORM_", choice_name(forms, at[DIMENSION_FORM]));
        text_list_add(out, "}");
    }
    add_gather(out, setting);
}
