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
                               {"mirrored", 1 + SVO_FORM_MIRRORED},
                               {NULL, 0}};
static const choice ray_sets[] = {{"16", 16},   {"32", 32},   {"64", 64},     {"128", 128},
                                  {"256", 256}, {"512", 512}, {"1024", 1024}, {NULL, 0}};
/* Of probes without values. */
static const choice probe_sets[] = {{"2x64", GATHER_GRID(2, 64)},
                                    {"4x64", GATHER_GRID(4, 64)},
                                    {"4x128", GATHER_GRID(4, 128)},
                                    {"8x64", GATHER_GRID(8, 64)},
                                    {NULL, 0}};
#define PROBES_ALONG_MAX 40 /* 64,000 in all, below SVO_PROBES_MAX */
#define PROBES_TEXELS    128u /* without a number */

static const char *const gather_names[] = {
    [GATHER_NOTHING] = "", [GATHER_CONES] = "cones", [GATHER_RAYS] = "rays", [GATHER_PROBES] = "probes"};

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
    if (which == DIMENSION_GATHER && gather_how(value) == GATHER_PROBES) {
        (void)snprintf(text, text_bytes, "%ux%u probes", gather_along(value), gather_texels(value));
    } else if (which == DIMENSION_GATHER) {
        (void)snprintf(text, text_bytes, "%u %s", gather_count(value), gather_names[gather_how(value)]);
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

/* A name of --free: its dimension, its choices and, of light, the way to gather. */
typedef struct free_name {
    tune_dimension which;
    tune_gather how;
    const choice *choices;
} free_name;

static int add_named(const free_reader *reader, const free_name *name, int value)
{
    return add_value(reader, name->which, name->which == DIMENSION_GATHER ? GATHER_VALUE(name->how, value) : value);
}

/* "4" or "4x64". */
static int add_probes(const free_reader *reader, const char *text, size_t length)
{
    char *end = NULL;
    const unsigned long along = strtoul(text, &end, 10);
    const unsigned long texels = *end == 'x' ? strtoul(end + 1, &end, 10) : PROBES_TEXELS;
    const bool is_read = end == text + length && text[0] >= '0' && text[0] <= '9';
    return is_read && along >= 1 && along <= PROBES_ALONG_MAX && texels >= SVO_PROBES_RESOLUTION_MIN &&
                   texels <= SVO_PROBES_RESOLUTION_MAX && texels % SVO_PROBES_RESOLUTION_STEP == 0
               ? add_value(reader, DIMENSION_GATHER, GATHER_VALUE(GATHER_PROBES, GATHER_GRID((int)along, (int)texels)))
               : program_fail(reader->state, PROGRAM_WRONG_USAGE,
                              "--free: '%.*s' is not N or NxR: probes along an axis, 1 .. %d, and texels of a map's "
                              "side, %u .. %u in steps of %u",
                              (int)length, text, PROBES_ALONG_MAX, SVO_PROBES_RESOLUTION_MIN, SVO_PROBES_RESOLUTION_MAX,
                              SVO_PROBES_RESOLUTION_STEP);
}

static int add_choice(const free_reader *reader, const free_name *name, const char *text, size_t length)
{
    suggestion near = suggestion_begin(text, length);
    for (const choice *one = name->choices; one->name != NULL; ++one) {
        if (strlen(one->name) == length && strncmp(one->name, text, length) == 0) {
            return add_named(reader, name, one->value);
        }
        suggestion_offer(&near, one->name);
    }
    return program_fail(reader->state, PROGRAM_WRONG_USAGE, "--free: '%.*s' is no value of %s%s", (int)length, text,
                        name->which != DIMENSION_GATHER ? names[name->which] : gather_names[name->how],
                        suggestion_end(&near).text);
}

static int add_all(const free_reader *reader, const free_name *name)
{
    int exit_code = PROGRAM_DONE;
    if (name->which == DIMENSION_DEPTH) {
        for (const unsigned *depth = reader->depths; *depth != 0 && exit_code == PROGRAM_DONE; ++depth) {
            exit_code = add_value(reader, name->which, (int)*depth);
        }
        return exit_code;
    }
    for (const choice *one = name->choices; one->name != NULL && exit_code == PROGRAM_DONE; ++one) {
        exit_code = add_named(reader, name, one->value);
    }
    return exit_code;
}

static bool is_text(const char *text, size_t length, const char *name)
{
    return strlen(name) == length && strncmp(name, text, length) == 0;
}

static bool find_free(const char *text, size_t length, free_name *out)
{
    const choice *const sets[] = {
        [GATHER_CONES] = choices_named("cones"), [GATHER_RAYS] = ray_sets, [GATHER_PROBES] = probe_sets};
    *out = (free_name){.which = DIMENSION_GATHER};
    for (out->how = GATHER_CONES; out->how <= GATHER_PROBES; ++out->how) {
        if (is_text(text, length, gather_names[out->how])) {
            out->choices = sets[out->how];
            return true;
        }
    }
    for (out->which = DIMENSION_DEPTH; out->which < DIMENSION_GATHER; ++out->which) {
        if (is_text(text, length, names[out->which])) {
            out->choices = choices_of(out->which);
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
    for (int i = GATHER_CONES; i <= GATHER_PROBES; ++i) {
        suggestion_offer(&near, gather_names[i]);
    }
    return program_fail(state, PROGRAM_WRONG_USAGE,
                        "--free: '%.*s' is none of depth, coverage, weights, frontend, share, builder, path, form, "
                        "light-form, cones, rays, probes%s",
                        (int)length, text, suggestion_end(&near).text);
}

/* One "NAME" or "NAME:VALUE+VALUE". */
static int read_free(const free_reader *reader, const char *text, size_t length)
{
    free_name name;
    const size_t name_length = strcspn(text, ":,");
    int exit_code = PROGRAM_DONE;
    if (!find_free(text, name_length, &name)) {
        return fail_free(reader->state, text, name_length);
    }
    if (name_length == length) {
        return add_all(reader, &name);
    }
    for (const char *value = text + name_length + 1; exit_code == PROGRAM_DONE; ++value) {
        const size_t value_length = strcspn(value, "+,");
        exit_code = name.which == DIMENSION_DEPTH ? add_depths(reader, value, value_length)
                    : name.how == GATHER_PROBES   ? add_probes(reader, value, value_length)
                                                  : add_choice(reader, &name, value, value_length);
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
    int exit_code = given->has_depth ? PROGRAM_DONE : add_all(reader, &(free_name){.which = DIMENSION_DEPTH});
    for (tune_dimension i = DIMENSION_COVERAGE; i <= DIMENSION_WEIGHTS && exit_code == PROGRAM_DONE; ++i) {
        if (!options_is_given(given, names[i])) {
            exit_code = add_all(reader, &(free_name){.which = i, .choices = choices_of(i)});
        }
    }
    for (size_t i = 0; i < 2 && !given->has_builder && exit_code == PROGRAM_DONE; ++i) {
        exit_code = add_value(reader, DIMENSION_BUILDER, usual_builders[i]);
    }
    return exit_code;
}

int tune_space_read(program *state, const unsigned *depths, tune_wish wish, tune_space *space)
{
    static const int usual_gathers[] = {
        GATHER_VALUE(GATHER_CONES, 5), GATHER_VALUE(GATHER_CONES, 16), GATHER_VALUE(GATHER_RAYS, 16),
        GATHER_VALUE(GATHER_RAYS, 64), GATHER_VALUE(GATHER_RAYS, 256), GATHER_VALUE(GATHER_PROBES, GATHER_GRID(4, 64))};
    const size_t usual_count = wish == WISH_LIGHT ? 6 : wish == WISH_GATHER ? 5 : 0;
    const free_reader reader = {state, depths, space};
    const char *text = state->options.free_list;
    fix_values(&state->options, space);
    int exit_code = text == NULL ? free_usual(&reader) : PROGRAM_DONE;
    while (text != NULL && exit_code == PROGRAM_DONE) {
        const size_t length = strcspn(text, ",");
        exit_code = read_free(&reader, text, length);
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
    for (size_t i = 0; i < usual_count && !space->is_free[DIMENSION_GATHER] && exit_code == PROGRAM_DONE; ++i) {
        space->values[DIMENSION_GATHER][i] = usual_gathers[i];
        space->counts[DIMENSION_GATHER] = i + 1;
    }
    return exit_code;
}

/* ---- settings ---- */

/* For cones, which light what probes see, too. */
static bool stores_light(const tune_setting *setting)
{
    const tune_gather how = gather_how(setting->values[DIMENSION_GATHER]);
    return how == GATHER_CONES || how == GATHER_PROBES;
}

/* Whether the setting with the first values of the dimensions that do not matter to it is another one. */
static bool is_second_name(const tune_space *space, const tune_setting *setting)
{
    const int *at = setting->values;
    const bool in_gl = at[DIMENSION_BUILDER] == OPTION_BUILDER_GL_COMPUTE;
    const bool in_cl = at[DIMENSION_FRONTEND] == OPTION_FRONTEND_CL || at[DIMENSION_FRONTEND] == OPTION_FRONTEND_AUTO;
    return (in_gl && at[DIMENSION_FRONTEND] != space->values[DIMENSION_FRONTEND][0]) ||
           (in_cl && !in_gl && at[DIMENSION_SHARE] != space->values[DIMENSION_SHARE][0]) ||
           (!stores_light(setting) && at[DIMENSION_LIGHT_FORM] != space->values[DIMENSION_LIGHT_FORM][0]);
}

int tune_space_list(program *state, const tune_space *space, tune_setting *settings, size_t *count)
{
    size_t product = 1;
    *count = 0;
    for (int i = 0; i < DIMENSION_COUNT; ++i) {
        product *= space->counts[i]; /* below 16^10 */
    }
    for (size_t place = 0; place < product; ++place) {
        tune_setting one = {.need = 0};
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

/* ---- what trees hold ---- */

uint32_t tune_gather_need(int gather, const svo_mesh *mesh)
{
    const bool has_colors = mesh->colors != NULL || mesh->material_count > 0;
    const tune_gather how = gather_how(gather);
    return how == GATHER_NOTHING
               ? 0
               : SVO_NEED_NORMAL | SVO_NEED_RAYS | (how != GATHER_RAYS ? (uint32_t)SVO_NEED_PROJECTED_AREA : 0U) |
                     (has_colors ? (uint32_t)SVO_NEED_COLOR : 0U) |
                     (mesh->finishes != NULL ? (uint32_t)SVO_NEED_MATERIAL : 0U);
}

/* The names of bits, with a separator and in a text each. */
static void add_needs(text_list *list, uint32_t need, const char *separator, void (*add)(text_list *, const char *))
{
    const char *before = "";
    for (const choice *one = choices_named("need"); one->name != NULL; ++one) {
        if ((need & (uint32_t)one->value) != 0) {
            text_list_add(list, "%s", before);
            add(list, one->name);
            before = separator;
        }
    }
}

static void add_plain(text_list *list, const char *name)
{
    text_list_add(list, "%s", name);
}

void tune_need_names(uint32_t need, text_list *out)
{
    text_list_clear(out);
    add_needs(out, need, ",", add_plain);
    text_list_add(out, "%s", need == 0 ? "none" : "");
}

const char *tune_setting_lacks(const tune_setting *setting, tune_quantity quantity)
{
    const int *at = setting->values;
    const bool is_thin = at[DIMENSION_COVERAGE] == SVO_COVERAGE_THIN;
    const bool has_probes = gather_how(at[DIMENSION_GATHER]) == GATHER_PROBES;
    switch (quantity) {
    case QUANTITY_ENCLOSED:
        return is_thin ? "thin voxels enclose nothing" : NULL;
    case QUANTITY_TRIANGLE:
    case QUANTITY_T:
        return is_thin                   ? "thin voxels lack triangles"
               : at[DIMENSION_FORM] != 0 ? "a compact form has no triangles"
                                         : NULL;
    case QUANTITY_OCCLUSION:
        return has_probes ? "probes hold no openness" : NULL;
    case QUANTITY_DIRECT:
        return has_probes ? "probes hold no direct light" : NULL;
    default:
        return NULL;
    }
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
                   (option->group & (OPTION_COMMON | OPTION_JSON | OPTION_TUNE_COMMAND)) == 0 &&
                   strcmp(option->name, "need") != 0;
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

static void add_gather_options(text_list *out, const program *state, const tune_setting *setting)
{
    const int gather = setting->values[DIMENSION_GATHER];
    const unsigned along = gather_along(gather);
    if (state->options.lights_path != NULL) {
        text_list_add(out, " --lights");
        add_word(out, state->options.lights_path);
    }
    if (stores_light(setting) && setting->values[DIMENSION_LIGHT_FORM] != SVO_LIGHT_FACES) {
        text_list_add(out, " --form %s",
                      choice_name(choices_of(DIMENSION_LIGHT_FORM), setting->values[DIMENSION_LIGHT_FORM]));
    }
    if (gather_how(gather) == GATHER_PROBES) {
        text_list_add(out, " --through probes --probes %u,%u,%u --probe-resolution %u -o probes.png", along, along,
                      along, gather_texels(gather));
        return;
    }
    text_list_add(out, gather_how(gather) == GATHER_CONES ? " --method cones --cones %u" : " --method rays --paths %u",
                  gather_count(gather));
    text_list_add(out, " --points %u", GATHER_POINTS);
    if (options_is_given(&state->options, "seed")) {
        text_list_add(out, " --seed %u", (unsigned)state->options.seed);
    }
    text_list_add(out, " -o light.csv");
}

void tune_setting_command(const program *state, const tune_setting *setting, text_list *out)
{
    static const char *const commands[] = {
        [GATHER_NOTHING] = "build", [GATHER_CONES] = "gather", [GATHER_RAYS] = "gather", [GATHER_PROBES] = "render"};
    const int *at = setting->values;
    text_list need;
    text_list_clear(out);
    text_list_add(out, "svocl %s", commands[gather_how(at[DIMENSION_GATHER])]);
    add_word(out, state->options.input);
    text_list_add(out, " -d %d", at[DIMENSION_DEPTH]);
    for (tune_dimension i = DIMENSION_COVERAGE; i <= DIMENSION_PATH; ++i) {
        add_option(out, setting, i, 0);
    }
    if (setting->names_need) {
        tune_need_names(setting->need, &need);
        text_list_add(out, " --need %s", need.text);
    }
    add_carried(out, state);
    if (at[DIMENSION_GATHER] != 0) {
        add_gather_options(out, state, setting);
    } else if (at[DIMENSION_FORM] != 0) {
        text_list_add(out, " --tree-form %s -o model.svc", choice_name(forms, at[DIMENSION_FORM]));
    } else {
        text_list_add(out, " -o model.svo");
    }
}

/* ---- C ---- */

static void add_upper(text_list *list, const char *name)
{
    for (; *name != '\0'; ++name) {
        const char letter = *name >= 'a' && *name <= 'z' ? (char)(*name - 'a' + 'A') : *name == '-' ? '_' : *name;
        text_list_add(list, "%c", letter);
    }
}

/* ".coverage = SVO_COVERAGE_THIN": prefix and the name in upper case. */
static void add_field(text_list *list, const char *field, const char *prefix, const char *name)
{
    text_list_add(list, ", .%s = %s", field, prefix);
    add_upper(list, name);
}

static void add_need(text_list *list, const char *name)
{
    text_list_add(list, "SVO_NEED_");
    add_upper(list, name);
}

static void add_gather(text_list *list, const tune_setting *setting)
{
    const int gather = setting->values[DIMENSION_GATHER];
    const unsigned along = gather_along(gather);
    if (stores_light(setting)) {
        text_list_add(list, "; svo_light_options light = {.struct_size = sizeof light");
        add_field(list, "form", "SVO_LIGHT_",
                  choice_name(choices_of(DIMENSION_LIGHT_FORM), setting->values[DIMENSION_LIGHT_FORM]));
        text_list_add(list, "}");
    }
    if (gather_how(gather) == GATHER_PROBES) {
        text_list_add(list,
                      "; svo_probe_options probes = {.struct_size = sizeof probes, .counts = {%u, %u, %u}, "
                      ".resolution = %u, .diffuse = 1}",
                      along, along, along, gather_texels(gather));
    } else if (gather != 0) {
        const bool is_cones = gather_how(gather) == GATHER_CONES;
        text_list_add(list, "; svo_gather_options gather = {.struct_size = sizeof gather, .method = %s, .%s = %u}",
                      is_cones ? "SVO_GATHER_CONES" : "SVO_GATHER_RAYS", is_cones ? "cones" : "paths",
                      gather_count(gather));
    }
}

void tune_setting_code(const tune_setting *setting, text_list *out)
{
    const int *at = setting->values;
    text_list_clear(out);
    text_list_add(out, "/* depth %d */ svo_plan_options plan = {.struct_size = sizeof plan", at[DIMENSION_DEPTH]);
    if (setting->names_need || at[DIMENSION_GATHER] != 0) {
        text_list_add(out, ", .need = ");
        add_needs(out, setting->need, " | ", add_need);
        text_list_add(out, "%s", setting->need == 0 ? "SVO_NEED_NONE" : "");
    }
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

const char *tune_setting_rest(const tune_setting *setting)
{
    const bool has_form = setting->values[DIMENSION_FORM] != 0 && setting->values[DIMENSION_GATHER] != 0;
    return gather_how(setting->values[DIMENSION_GATHER]) == GATHER_PROBES
               ? "the command draws a picture through these probes: irradiance at points is svo_probes_irradiance's"
           : has_form ? "the command gathers in the tree alone: svocl build --tree-form makes its compact form"
                      : "";
}
