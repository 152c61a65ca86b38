/* SPDX-License-Identifier: MIT */
/* The table of options and the readers of their values. */
#include "support/options_rules.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "scenes/scenes.h"
#include "support/suggest.h"
#include "svocl/compact.h"
#include "svocl/edit.h"
#include "svocl/light.h"
#include "svocl/probes.h"
#include "svocl/solid.h"
#include "svocl/trace.h"
#include "svocl/voxels.h"

#define OPTION_VECTOR_MAX 1e18
#define OPTION_FOV_MIN    0.01
#define OPTION_FOV_MAX    179.0
#define OPTION_SCALE_MAX  4.0

static const choice frontends[] = {{"auto", OPTION_FRONTEND_AUTO},           {"cl", OPTION_FRONTEND_CL},
                                   {"gl-expand", OPTION_FRONTEND_GL_EXPAND}, {"gl-hw", OPTION_FRONTEND_GL_HW},
                                   {"gl-hybrid", OPTION_FRONTEND_GL_HYBRID}, {NULL, 0}};
static const choice paths[] = {{"cpu", SVO_PATH_CPU}, {"gpu", SVO_PATH_GPU}, {NULL, 0}};
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

static const choice views[] = {{"shaded", SVO_VIEW_SHADED}, {"normal", SVO_VIEW_NORMAL},
                               {"depth", SVO_VIEW_DEPTH},   {"steps", SVO_VIEW_STEPS},
                               {"level", SVO_VIEW_LEVEL},   {"triangles", SVO_VIEW_TRIANGLES},
                               {"ao", SVO_VIEW_AO},         {"direct", SVO_VIEW_DIRECT},
                               {"gi", SVO_VIEW_INDIRECT},   {"specular", SVO_VIEW_SPECULAR},
                               {"full", OPTION_VIEW_FULL},  {NULL, 0}};
static const choice picture_formats[] = {{"png", OPTION_FORMAT_PNG}, {"exr", OPTION_FORMAT_EXR},
                                         {"hdr", OPTION_FORMAT_HDR}, {"ppm", OPTION_FORMAT_PPM},
                                         {"y4m", OPTION_FORMAT_Y4M}, {NULL, 0}};
static const choice sides[] = {{"front", 1}, {"left", 2},   {"right", 3}, {"back", 4},
                               {"top", 5},   {"bottom", 6}, {"iso", 7},   {NULL, 0}};
static const choice light_forms[] = {
    {"faces", SVO_LIGHT_FACES}, {"bricks", SVO_LIGHT_BRICKS}, {"voxels", SVO_LIGHT_VOXELS}, {NULL, 0}};
static const choice opacities[] = {{"area", SVO_OPACITY_AREA}, {"full", SVO_OPACITY_FULL}, {NULL, 0}};
static const choice opaque_sides[] = {{"both", 0}, {"one", 1}, {NULL, 0}};
static const choice gather_methods[] = {
    {"auto", SVO_GATHER_AUTO}, {"cones", SVO_GATHER_CONES}, {"rays", SVO_GATHER_RAYS}, {NULL, 0}};
static const choice cone_sets[] = {{"1", 1}, {"5", 5}, {"6", 6}, {"16", 16}, {"64", 64}, {NULL, 0}};
static const choice ways_through[] = {{"tree", 0}, {"probes", 1}, {NULL, 0}};
static const choice things_met[] = {{"triangles", OPTION_MEETS_TRIANGLES}, {"voxels", OPTION_MEETS_VOXELS}, {NULL, 0}};
static const choice switches[] = {{"on", 1}, {"off", 0}, {NULL, 0}};
static const choice rivals[] = {{"none", 0},
                                {"embree", OPTION_VERSUS_EMBREE},
                                {"openvdb", OPTION_VERSUS_OPENVDB},
                                {"grid", OPTION_VERSUS_GRID},
                                {NULL, 0}};
static const choice solids[] = {{"winding", 1 + SVO_SOLID_WINDING},
                                {"parity", 1 + SVO_SOLID_PARITY},
                                {"generalized", 1 + SVO_SOLID_GENERALIZED},
                                {NULL, 0}};
static const choice signs[] = {
    {"winding", SVO_SOLID_WINDING}, {"parity", SVO_SOLID_PARITY}, {"none", OPTION_SIGN_NONE}, {NULL, 0}};
static const choice forms[] = {{"descriptor", 1 + SVO_FORM_DESCRIPTOR},
                               {"implied", 1 + SVO_FORM_IMPLIED},
                               {"shared", 1 + SVO_FORM_SHARED},
                               {"mirrored", 1 + SVO_FORM_MIRRORED},
                               {NULL, 0}};
static const choice checked_forms[] = {
    {"descriptor", 1 + SVO_FORM_DESCRIPTOR}, {"implied", 1 + SVO_FORM_IMPLIED}, {"shared", 1 + SVO_FORM_SHARED},
    {"mirrored", 1 + SVO_FORM_MIRRORED},     {"all", OPTION_FORM_ALL},          {NULL, 0}};
static const choice normal_bits[] = {{"4", 4}, {"5", 5}, {"6", 6}, {"7", 7}, {"8", 8}, {NULL, 0}};
static const choice directory_steps[] = {{"16", 4}, {"32", 5}, {"64", 6}, {NULL, 0}};
static const choice axes_of_files[] = {
    {"auto", SVO_AXES_AUTO}, {"keep", SVO_AXES_KEEP}, {"z-up", SVO_AXES_Z_UP}, {NULL, 0}};
static const choice needs[] = {{"color", SVO_NEED_COLOR},
                               {"normal", SVO_NEED_NORMAL},
                               {"rays", SVO_NEED_RAYS},
                               {"material", SVO_NEED_MATERIAL},
                               {"fill", SVO_NEED_FILL},
                               {"projected-area", SVO_NEED_PROJECTED_AREA},
                               {"none", 0},
                               {NULL, 0}};

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

/* The hash that a tree is to have; upper case is the same. */
static int read_hash(program *state, const rule *option, const char *value)
{
    const size_t digits = SVO_HASH_TEXT_BYTES - 1;
    if (strlen(value) != digits || strspn(value, "0123456789abcdefABCDEF") != digits) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is not a hash, which has %zu hexadecimal digits",
                            option->name, value, digits);
    }
    return read_text(state, option, value);
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

/* Bytes in a unit: K, M, G, T and KiB, MiB, ... are powers of 1024; KB, MB, ... of 1000; B and nothing are 1. 0: none
   of them. */
static uint64_t unit_bytes(const char *unit)
{
    static const char letters[] = "KMGT";
    if (unit[0] == '\0' || strcasecmp(unit, "B") == 0) {
        return 1;
    }
    const char *letter = strchr(letters, toupper((unsigned char)unit[0]));
    const bool is_decimal = strcasecmp(unit + 1, "B") == 0;
    if (letter == NULL || !(unit[1] == '\0' || is_decimal || strcasecmp(unit + 1, "iB") == 0)) {
        return 0;
    }
    uint64_t bytes = 1;
    for (const char *at = letters; at <= letter; ++at) {
        bytes *= is_decimal ? 1000 : 1024;
    }
    return bytes;
}

/* A number of bytes with a unit, which may have a fraction then: 65536, 512M, 4GB, 1.5GiB. */
static int read_bytes(program *state, const rule *option, const char *value)
{
    errno = 0;
    const size_t whole = strspn(value, "0123456789");
    const size_t digits = value[whole] == '.' ? whole + 1 + strspn(value + whole + 1, "0123456789") : whole;
    const uint64_t unit = whole > 0 ? unit_bytes(value + digits) : 0;
    const bool has_fraction = digits > whole;
    const unsigned long long count = strtoull(value, NULL, 10);
    if (unit == 0 || (has_fraction && (unit == 1 || digits == whole + 1))) {
        return program_fail(state, PROGRAM_WRONG_USAGE,
                            "--%s '%s' is not a number of bytes, such as 65536, 512M, 4GB or 1.5GiB", option->name,
                            value);
    }
    const uint64_t fraction = has_fraction ? (uint64_t)(strtod(value + whole, NULL) * (double)unit) : 0;
    const uint64_t most = option->maximum;
    if (errno == ERANGE || fraction > most || count > (most - fraction) / unit) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s %s is above %" PRIu64 " bytes", option->name, value, most);
    }
    const uint64_t bytes = count * unit + fraction;
    const uint64_t least = option->minimum > 0 ? option->minimum : 1;
    if (bytes < least) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s %s is below %" PRIu64, option->name, value, least);
    }
    *(uint64_t *)field(state, option) = bytes;
    return PROGRAM_DONE;
}

/* "auto, cl, gl-expand, gl-hw, gl-hybrid" */
static void list_choices(const choice *choices, char *text, size_t text_bytes)
{
    size_t used = 0;
    text[0] = '\0';
    for (const choice *one = choices; one->name != NULL && used < text_bytes; ++one) {
        used += (size_t)snprintf(text + used, text_bytes - used, "%s%s", used == 0 ? "" : ", ", one->name);
    }
}

static void offer_choices(suggestion *near, const choice *choices)
{
    for (const choice *one = choices; one->name != NULL; ++one) {
        suggestion_offer(near, one->name);
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
    suggestion near = suggestion_begin(value, strlen(value));
    offer_choices(&near, option->choices);
    list_choices(option->choices, known, sizeof known);
    return program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is none of %s%s", option->name, value, known,
                        suggestion_end(&near).text);
}

static bool parse_number(const char *text, char **end, double *number)
{
    *number = strtod(text, end);
    return *end != text && isfinite(*number);
}

/* "x,y,z" */
static bool parse_vector(const char *text, double out[3])
{
    const char *rest = text;
    for (int axis = 0; axis < 3; ++axis) {
        char *end = NULL;
        if (!parse_number(rest, &end, &out[axis]) || *end != (axis < 2 ? ',' : '\0')) {
            return false;
        }
        rest = end + 1;
    }
    return true;
}

static int read_origin(program *state, const rule *option, const char *value)
{
    if (!parse_vector(value, field(state, option))) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "origin '%s' is not of the form x,y,z", value);
    }
    state->options.has_origin = true;
    return PROGRAM_DONE;
}

/* A vector of the camera, which floats must hold. */
static int read_vector(program *state, const rule *option, const char *value)
{
    option_vector *vector = field(state, option);
    vector->is_given = parse_vector(value, vector->at) && fabs(vector->at[0]) <= OPTION_VECTOR_MAX &&
                       fabs(vector->at[1]) <= OPTION_VECTOR_MAX && fabs(vector->at[2]) <= OPTION_VECTOR_MAX;
    return vector->is_given ? PROGRAM_DONE
                            : program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is not X,Y,Z, each within %g",
                                           option->name, value, OPTION_VECTOR_MAX);
}

static int read_fov(program *state, const rule *option, const char *value)
{
    double *degrees = field(state, option);
    char *end = NULL;
    if (!parse_number(value, &end, degrees) || *end != '\0' || *degrees < OPTION_FOV_MIN || *degrees > OPTION_FOV_MAX) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is not a number of degrees within %g .. %g",
                            option->name, value, OPTION_FOV_MIN, OPTION_FOV_MAX);
    }
    return PROGRAM_DONE;
}

static int read_scale(program *state, const rule *option, const char *value)
{
    double *scale = field(state, option);
    char *end = NULL;
    if (!parse_number(value, &end, scale) || *end != '\0' || *scale < 1.0 || *scale > OPTION_SCALE_MAX) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is not a number within 1 .. %g", option->name, value,
                            OPTION_SCALE_MAX);
    }
    return PROGRAM_DONE;
}

static int read_edge(program *state, const rule *option, const char *value)
{
    double *edge = field(state, option);
    char *end = NULL;
    if (!parse_number(value, &end, edge) || *end != '\0' || *edge <= 0.0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "%s '%s' is not a number above 0", option->name, value);
    }
    return PROGRAM_DONE;
}

static int read_amount(program *state, const rule *option, const char *value)
{
    double *amount = field(state, option);
    char *end = NULL;
    if (!parse_number(value, &end, amount) || *end != '\0' || *amount < 0.0) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is not a number of at least 0", option->name, value);
    }
    return PROGRAM_DONE;
}

static int read_distance(program *state, const rule *option, const char *value)
{
    char *end = NULL;
    return parse_number(value, &end, field(state, option)) && *end == '\0'
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is not a number", option->name, value);
}

/* A number of seconds with a unit: 20s, 500ms. */
static int read_seconds(program *state, const rule *option, const char *value)
{
    double *seconds = field(state, option);
    char *end = NULL;
    const bool is_number = parse_number(value, &end, seconds);
    const double unit = strcmp(end, "ms") == 0 ? 1e-3 : strcmp(end, "s") == 0 || *end == '\0' ? 1.0 : 0.0;
    *seconds *= unit;
    return is_number && *seconds > 0.0
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is not a time above 0, such as 20s or 500ms",
                              option->name, value);
}

/* Above 0, at most 1. */
static int read_share(program *state, const rule *option, const char *value)
{
    double *share = field(state, option);
    char *end = NULL;
    if (!parse_number(value, &end, share) || *end != '\0' || !(*share > 0.0 && *share <= 1.0)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is not a number above 0 and at most 1", option->name,
                            value);
    }
    return PROGRAM_DONE;
}

/* One name of a list, which is not terminated; NULL: none has that name. */
static const choice *find_choice(const choice *choices, const char *name, size_t length)
{
    for (const choice *one = choices; one->name != NULL; ++one) {
        if (strlen(one->name) == length && strncmp(one->name, name, length) == 0) {
            return one;
        }
    }
    return NULL;
}

static int read_need(program *state, const rule *option, const char *value)
{
    uint32_t need = 0;
    for (const char *name = value;; ++name) {
        const size_t length = strcspn(name, ",");
        const choice *one = find_choice(option->choices, name, length);
        if (one == NULL || (one->value == 0 && strcmp(value, one->name) != 0)) {
            suggestion near = suggestion_begin(name, length);
            offer_choices(&near, option->choices);
            return program_fail(state, PROGRAM_WRONG_USAGE,
                                "--need '%s' is neither none nor a list of color, normal, rays, material, fill, "
                                "projected-area%s",
                                value, suggestion_end(&near).text);
        }
        need |= (uint32_t)one->value;
        name += length;
        if (*name == '\0') {
            break;
        }
    }
    *(uint32_t *)field(state, option) = need == 0 ? (uint32_t)SVO_NEED_NONE : need;
    return PROGRAM_DONE;
}

static int read_depth(program *state, const rule *option, const char *value)
{
    state->options.has_depth = true;
    return read_count(state, option, value);
}

static int read_builder(program *state, const rule *option, const char *value)
{
    state->options.has_builder = true;
    return read_choice(state, option, value);
}

static int read_light(program *state, const rule *option, const char *value)
{
    state->options.has_light = true;
    return read_choice(state, option, value);
}

static int read_color_error(program *state, const rule *option, const char *value)
{
    state->options.has_color_error = true;
    return read_count(state, option, value);
}

static int read_repeat(program *state, const rule *option, const char *value)
{
    state->options.has_repeat = true;
    return read_count(state, option, value);
}

/* Whole numbers from the minimum to the maximum, with a character between each two. */
static bool parse_counts(const rule *option, const char *value, char between, size_t count, uint32_t *out)
{
    const char *rest = value;
    for (size_t i = 0; i < count; ++i) {
        char *end = NULL;
        const unsigned long number = rest[0] >= '0' && rest[0] <= '9' ? strtoul(rest, &end, 10) : 0;
        if (end == NULL || *end != (i + 1 < count ? between : '\0') || number < option->minimum ||
            number > option->maximum) {
            return false;
        }
        out[i] = (uint32_t)number;
        rest = end + 1;
    }
    return true;
}

/* "transparent", or a color in bytes. */
static int read_background(program *state, const rule *option, const char *value)
{
    uint32_t color[3];
    options *given = &state->options;
    if (strcmp(value, "transparent") == 0) {
        given->background = OPTION_BACKGROUND_TRANSPARENT;
        return PROGRAM_DONE;
    }
    if (!parse_counts(option, value, ',', 3, color)) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is neither transparent nor R,G,B, each 0 to 255",
                            option->name, value);
    }
    given->background = OPTION_BACKGROUND_COLOR;
    for (int channel = 0; channel < 3; ++channel) {
        given->background_bytes[channel] = (uint8_t)color[channel];
    }
    return PROGRAM_DONE;
}

static int read_probe_counts(program *state, const rule *option, const char *value)
{
    return parse_counts(option, value, ',', 3, field(state, option))
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "--%s '%s' is not X,Y,Z, each %" PRIu64 " to %" PRIu64,
                              option->name, value, option->minimum, option->maximum);
}

static int read_pixels(program *state, const rule *option, const char *value)
{
    return parse_counts(option, value, 'x', 2, field(state, option)) /* width, then height */
               ? PROGRAM_DONE
               : program_fail(state, PROGRAM_WRONG_USAGE, "size '%s' is not WIDTHxHEIGHT, each %" PRIu64 " to %" PRIu64,
                              value, option->minimum, option->maximum);
}

#define FIELD(name) offsetof(options, name)

static const rule rules[] = {
    {"depth", 'd', OPTION_BUILD, "D", read_depth, FIELD(depth), SVO_DEPTH_MIN, SVO_PARTS_DEPTH_MAX, NULL,
     "levels below the root: 2^D voxels per axis, 1 to 16, of parts to 20 (8; voxels: the least that holds them)"},
    {"need", '\0', OPTION_BUILD, "LIST", read_need, FIELD(need), 0, 0, needs,
     "color,normal,rays,material,fill,projected-area or none (normals, and the colors of the mesh)"},
    {"origin", '\0', OPTION_BUILD, "X,Y,Z", read_origin, FIELD(origin), 0, 0, NULL,
     "minimum corner of the grid, requires --edge (fitted to the mesh or the points)"},
    {"edge", '\0', OPTION_BUILD, "E", read_edge, FIELD(edge), 0, 0, NULL,
     "width of the grid, requires --origin (fitted to the mesh or the points)"},
    {"voxel-size", '\0', OPTION_BUILD, "S", read_edge, FIELD(voxel_size), 0, 0, NULL,
     "width of a voxel, in place of --depth: planes at multiples of S, the least depth that holds them (by depth)"},
    {"coverage", '\0', OPTION_BUILD, "NAME", read_choice, FIELD(coverage), 0, 0, coverages,
     "half-open, closed, thin (half-open)"},
    {"weights", '\0', OPTION_BUILD, "NAME", read_choice, FIELD(weights), 0, 0, weights,
     "weight of a triangle in a mean: area, uniform, center (area)"},
    {"drop-alpha", '\0', OPTION_BUILD, "A", read_share, FIELD(drop_alpha), 0, 0, NULL,
     "leave out triangles' parts in voxels that show less than A, 0 to 1, by materials, colors and textures (none)"},
    {"strict", '\0', OPTION_BUILD, NULL, read_flag, FIELD(strict), 0, 0, NULL,
     "fail where the mesh file holds something that is not read"},
    {"import-seconds", '\0', OPTION_BUILD, "N", read_count, FIELD(import_seconds), 1, 1000000, NULL,
     "time limit for reading the mesh file (5, and 1 for each MB that it reads)"},
    {"import-memory", '\0', OPTION_BUILD, "BYTES", read_bytes, FIELD(import_memory), 1, UINT64_MAX, NULL,
     "address space for reading the mesh file: 512MiB, 4GB (1GiB, and 64 bytes for each that it reads)"},
    {"frontend", '\0', OPTION_BUILD | OPTION_METHODS, "NAME", read_choice, FIELD(frontend), 0, 0, frontends,
     "auto, cl, gl-expand, gl-hw, gl-hybrid (auto: the fastest)"},
    {"hybrid-columns", '\0', OPTION_BUILD | OPTION_METHODS, "N", read_count, FIELD(hybrid_columns), 1, UINT32_MAX, NULL,
     "gl-hybrid: triangles of more columns of voxels are rasterized (64; software: none)"},
    {"tune", '\0', OPTION_BUILD, NULL, read_flag, FIELD(tune), 0, 0, NULL,
     "first measure with this input which triangles gl-hybrid rasterizes, and keep it for auto"},
    {"share", '\0', OPTION_BUILD | OPTION_METHODS, "NAME", read_choice, FIELD(share), 0, 0, shares,
     "auto, interop, host, copy (auto)"},
    {"builder", '\0', OPTION_BUILD, "NAME", read_builder, FIELD(builder), 0, 0, builders,
     "cl: top-down; sorted: bottom-up; gl-compute: top-down in OpenGL (cl; voxels: sorted)"},
    {"context", '\0', OPTION_BUILD | OPTION_METHODS, "NAME", read_choice, FIELD(context), 0, 0, contexts,
     "auto, surfaceless, egl-device, osmesa (auto)"},
    {"gl-device", '\0', OPTION_BUILD | OPTION_METHODS, "NAME", read_text, FIELD(gl_device), 0, 0, NULL,
     "EGL device: its index, part of its name, or gpu (0)"},
    {"device", '\0', OPTION_DEVICE, "NAME", read_text, FIELD(device_name), 0, 0, NULL,
     "OpenCL device: part of its name, or P.D indices"},
    {"threads", '\0', OPTION_DEVICE, "N", read_count, FIELD(threads), 1, 1024, NULL,
     "threads of PoCL and llvmpipe, 1 to 1024 (all cores)"},
    {"path", '\0', OPTION_DEVICE | OPTION_DEVICES_COMMAND, "NAME", read_choice, FIELD(path), 0, 0, paths,
     "kernels for another kind of device: cpu, gpu (the device's own)"},
    {"kernels", '\0', OPTION_DEVICE, "DIR", read_text, FIELD(kernels_path), 0, 0, NULL,
     "where svocl kernels saves, and others load instead of compiling ($XDG_CACHE_HOME/svocl)"},
    {"output", 'o', OPTION_OUTPUT, "FILE", read_text, FIELD(output_path), 0, 0, NULL,
     "file to write; - is standard output"},
    {"triangles", '\0', OPTION_SCENE_COMMAND, "N", read_count, FIELD(triangles), 1, SCENE_TRIANGLES_MAX, NULL,
     "approximate number of triangles (the default of the scene)"},
    {"seed", '\0',
     OPTION_SCENE_COMMAND | OPTION_STRESS_COMMAND | OPTION_REFERENCE_COMMAND | OPTION_GATHER_COMMAND |
         OPTION_TUNE_COMMAND | OPTION_BENCH_COMMAND | OPTION_PARTS_CHECK,
     "S", read_count, FIELD(seed), 0, UINT32_MAX, NULL, "random seed (1)"},
    {"count", '\0', OPTION_STRESS_COMMAND, "N", read_count, FIELD(count), 0, 1000, NULL,
     "amount of work, 0 to 1000: triangles per case grow with it (8)"},
    {"size", '\0', OPTION_PICTURE_SIZE, "WxH", read_pixels, FIELD(width), 1, 16384, NULL,
     "size of the image in pixels (1024x768)"},
    {"rays", '\0', OPTION_TRACE_COMMAND, "FILE", read_text, FIELD(rays_path), 0, 0, NULL,
     "CSV file with one ray per line: ox,oy,oz,dx,dy,dz; - is standard input"},
    {"camera", '\0', OPTION_TRACE_COMMAND, "VIEW", read_text, FIELD(camera), 0, 0, NULL,
     "one ray per pixel: auto, or eye, target, up, degrees as 6, 9 or 10 numbers"},
    {"meet", '\0', OPTION_TRACE_COMMAND, "NAME", read_choice, FIELD(meets), 0, 0, things_met,
     "what rays meet: triangles, voxels (triangles; compact trees, which have none: voxels)"},
    {"points", '\0', OPTION_REFERENCE_COMMAND | OPTION_GATHER_COMMAND, "FILE", read_text, FIELD(points_path), 0, 0,
     NULL, "CSV file with one point per line: x,y,z,nx,ny,nz; or a number of points, spread over the mesh by area"},
    {"samples", '\0', OPTION_REFERENCE_COMMAND, "N", read_count, FIELD(samples), 1, OPTION_SAMPLES_MAX, NULL,
     "paths for each point, rounded down to 16 squares (16384)"},
    {"range", '\0', OPTION_REFERENCE_COMMAND, "R", read_amount, FIELD(range), 0, 0, NULL,
     "farthest that ambient occlusion reaches, in the mesh's units (0: any distance)"},
    {"range", '\0', OPTION_LIGHT, "R", read_amount, FIELD(range), 0, 0, NULL,
     "farthest that ambient occlusion reaches, in the mesh's units; 0: any distance (a tenth of the grid's width; "
     "pages: 0)"},
    {"lambda", '\0', OPTION_REFERENCE_COMMAND | OPTION_LIGHT, "L", read_amount, FIELD(falloff), 0, 0, NULL,
     "occlusion at a distance t counts 1 / (1 + L t) (0)"},
    {"view", '\0', OPTION_RENDER_COMMAND | OPTION_WEB_COMMAND, "NAME", read_choice, FIELD(view), 0, 0, views,
     "shaded, normal, depth, steps, level, triangles; lit: ao, direct, gi, specular, full (shaded)"},
    {"format", '\0', OPTION_PICTURE_FILE, "NAME", read_choice, FIELD(format), 0, 0, picture_formats,
     "format of -o: png, exr, hdr, ppm, y4m (its suffix; standard output: png)"},
    {"background", '\0', OPTION_PICTURE_FILE, "R,G,B", read_background, FIELD(background), 0, 255, NULL,
     "what is behind everything: 0 to 255 each, or transparent (a gradient; with light the sky; views: white)"},
    {"samples", '\0', OPTION_PICTURE_FILE, "N", read_count, FIELD(pixel_samples), 1, SVO_PICTURE_SAMPLES_MAX, NULL,
     "rays of a pixel, in cells of equal area, averaged as linear light (4; views without light: 1)"},
    {"turntable", '\0', OPTION_PICTURE_FILE, "N", read_count, FIELD(turntable), 1, 9999, NULL,
     "N frames of a turn round the up axis: -o a.png writes a-0001.png and so on, -o a.y4m a film (one picture)"},
    {"fps", '\0', OPTION_PICTURE_FILE, "N", read_count, FIELD(frame_rate), 1, 1000, NULL,
     "frames of a film a second (30)"},
    {"animate", '\0', OPTION_PICTURE_FILE, NULL, read_flag, FIELD(animate), 0, 0, NULL,
     "the motions of a .json scene in one tree, a frame each: -o a.png writes a_000.png and so on, -o a.y4m a film"},
    {"frames", '\0', OPTION_PICTURE_FILE | OPTION_VIEW_COMMAND, "N", read_count, FIELD(frames), 1, 100000, NULL,
     "frames of an animation, from the first to the last time of its motions (60)"},
    {"verify", '\0', OPTION_PICTURE_FILE, NULL, read_flag, FIELD(verify_frames), 0, 0, NULL,
     "build each frame of an animation anew and compare the hashes"},
    {"through", '\0', OPTION_RENDER_COMMAND, "NAME", read_choice, FIELD(through), 0, 0, ways_through,
     "what camera rays pass: tree; probes, where green is a miss and red unknown (tree)"},
    {"probes", '\0', OPTION_PROBES | OPTION_HASH_COMMAND, "X,Y,Z", read_probe_counts, FIELD(probe_counts), 1, 65534,
     NULL, "number of probes along each axis (4,4,4; hash: the tree's hash)"},
    {"probe-resolution", '\0', OPTION_PROBES | OPTION_HASH_COMMAND, "R", read_count, FIELD(probe_resolution), 64, 1024,
     NULL, "texels along a side of a probe's map, a multiple of 16 (256, or what 1 GiB allows)"},
    {"probe-field", '\0', OPTION_PROBES | OPTION_HASH_COMMAND, "N", read_count, FIELD(probe_field), 1, 256, NULL,
     "cells along each axis of the field that rays choose probes from (64)"},
    {"lights", '\0', OPTION_LIGHT | OPTION_REFERENCE_COMMAND, "FILE", read_text, FIELD(lights_path), 0, 0, NULL,
     "JSON file with lights, sky and camera (a scene's own; else pictures: a sky, and a sun or a lamp that reaches "
     "what is in view)"},
    {"lights", '\0', OPTION_TUNE_COMMAND, "FILE", read_text, FIELD(lights_path), 0, 0, NULL,
     "JSON file with the lights and the sky that light is measured under (a sun and a sky)"},
    {"cones", '\0', OPTION_LIGHT, "N", read_choice, FIELD(cones), 0, 0, cone_sets,
     "cones that gather the light of a point: 1, 5, 6, 16, 64 (16)"},
    {"method", '\0', OPTION_LIGHT, "NAME", read_choice, FIELD(gather_method), 0, 0, gather_methods,
     "how light is gathered: cones, rays (auto: with --cones cones, else rays)"},
    {"paths", '\0', OPTION_LIGHT, "N", read_count, FIELD(paths), 16, 65536, NULL,
     "paths of a point by rays, at most: 16, 32, 64 and so on (64; of 2 x 2 pixels 16)"},
    {"bounces", '\0', OPTION_LIGHT | OPTION_REFERENCE_COMMAND, "N", read_count, FIELD(bounces), 1, 64, NULL,
     "so often surfaces reflect the lights: rays of a path; for cones, times that photons are reflected (1)"},
    {"error", '\0', OPTION_LIGHT, "E", read_amount, FIELD(error_goal), 0, 0, NULL,
     "a point has paths enough at this standard error of its openness, and of its light as a share (0: it has all)"},
    {"form", '\0', OPTION_LIGHT, "NAME", read_choice, FIELD(light_form), 0, 0, light_forms,
     "how light is stored: faces, bricks, voxels; walls leak in the latter two (faces)"},
    {"opacity", '\0', OPTION_LIGHT, "NAME", read_choice, FIELD(opacity), 0, 0, opacities,
     "how opaque leaves are: area, by the area in them that each direction meets; full (area)"},
    {"sides", '\0', OPTION_LIGHT, "NAME", read_choice, FIELD(one_side), 0, 0, opaque_sides,
     "which sides of a closed mesh hold cones back: both; one, the front (both)"},
    {"light-file", '\0', OPTION_RENDER_COMMAND, "FILE", read_text, FIELD(light_file), 0, 0, NULL,
     "the light of the tree: read with its sources where FILE is there, else made and written (none)"},
    {"mesh", '\0', OPTION_LIGHT, "FILE", read_text, FIELD(mesh_path), 0, 0, NULL,
     "the mesh that INPUT, a tree with rays, was made of: light has its textures, normals and finishes (none)"},
    {"photons", '\0', OPTION_LIGHT, "NAME", read_choice, FIELD(photons), 0, 0, switches,
     "whether surfaces that the lights reach light others by cones: on, off (on)"},
    {"emission-photons", '\0', OPTION_LIGHT, "N", read_count, FIELD(emission_photons), 1, SVO_EMISSION_PHOTONS_MAX,
     NULL, "photons that materials that emit shoot, so that cones have what surfaces reflect of them (none)"},
    {"gi", '\0', OPTION_RENDER_COMMAND, "NAME", read_choice, FIELD(gi), 0, 0, switches,
     "whether --view full shows indirect light: on, off (on)"},
    {"exposure", '\0', OPTION_RENDER_COMMAND | OPTION_WEB_COMMAND, "E", read_amount, FIELD(exposure), 0, 0, NULL,
     "light is multiplied by it before the tone curve, in views of light (automatic: by the light in view)"},
    {"reference", '\0', OPTION_GATHER_COMMAND, "N", read_count, FIELD(reference), 1, OPTION_SAMPLES_MAX, NULL,
     "also path-trace each point by N paths, rounded down to 16 squares (none)"},
    {"eye", '\0', OPTION_RENDER_COMMAND | OPTION_WEB_COMMAND, "X,Y,Z", read_vector, FIELD(eye), 0, 0, NULL,
     "where the camera stands, world units (where all of INPUT is in view)"},
    {"from", '\0', OPTION_RENDER_COMMAND, "SIDE", read_choice, FIELD(from_side), 0, 0, sides,
     "side from which all of INPUT is framed: front, left, right, back, top, bottom, iso (a little right and above)"},
    {"at", '\0', OPTION_RENDER_COMMAND | OPTION_WEB_COMMAND, "X,Y,Z", read_vector, FIELD(look_at), 0, 0, NULL,
     "the point that the camera looks at (the middle of INPUT)"},
    {"up", '\0', OPTION_RENDER_COMMAND | OPTION_WEB_COMMAND, "X,Y,Z", read_vector, FIELD(up), 0, 0, NULL,
     "direction that is up in the picture (0,1,0)"},
    {"fov", '\0', OPTION_RENDER_COMMAND | OPTION_WEB_COMMAND, "DEG", read_fov, FIELD(fov), 0, 0, NULL,
     "angle of view from the picture's bottom to its top, degrees (32; with --eye 60)"},
    {"repeat", '\0', OPTION_BUILD_COMMAND | OPTION_MEASURE, "N", read_repeat, FIELD(repeat), 1, 10000, NULL,
     "repeat N times and report medians; builds leave out the first (1; measurements: 11 after a warm-up)"},
    {"scenes", '\0', OPTION_MEASURE, "LIST", read_text, FIELD(scenes), 0, 0, NULL,
     "comma-separated INPUTs without their scene: prefix (each measurement has its own)"},
    {"depths", '\0', OPTION_MEASURE, "LIST", read_text, FIELD(depths), 0, 0, NULL,
     "comma-separated depths (each measurement has its own)"},
    {"quick", '\0', OPTION_MEASURE, NULL, read_flag, FIELD(quick), 0, 0, NULL,
     "smaller scenes, fewer depths, 3 repeats: a quick check"},
    {"from", '\0', OPTION_REPORT_COMMAND | OPTION_BENCH_COMMAND, "FILE", read_text, FIELD(from), 0, 0, NULL,
     "JSON file written by svocl bench -o, used in place of new measurements (bench: gl-vs-cl)"},
    {"docs", '\0', OPTION_REPORT_COMMAND, "DIR", read_text, FIELD(docs), 0, 0, NULL,
     "update the marked tables of DIR/README.md and DIR/docs/*.md; -o is then optional"},
    {"plan", '\0', OPTION_BUILD_COMMAND, NULL, read_flag, FIELD(plan), 0, 0, NULL,
     "print what the build will run, allocate and leave out, then build"},
    {"plan-only", '\0', OPTION_BUILD_COMMAND, NULL, read_flag, FIELD(plan_only), 0, 0, NULL,
     "print the plan without building"},
    {"count-first", '\0', OPTION_BUILD_COMMAND, NULL, read_flag, FIELD(count_first), 0, 0, NULL,
     "count the fragments before allocating memory for them"},
    {"payload-level", '\0', OPTION_BUILD_COMMAND, "N", read_count, FIELD(payload_level), 0, SVO_PARTS_DEPTH_MAX, NULL,
     "first level with payload, 0 to the depth (0: all levels)"},
    {"levels", '\0', OPTION_LEVELS, "L", read_count, FIELD(last_level), 1, SVO_PARTS_DEPTH_MAX, NULL,
     "read levels 0 to L of a .svo file or of a folder of parts alone: a tree of depth L (all)"},
    {"region", '\0', OPTION_LEVELS, "NODE", read_text, FIELD(region), 0, 0, NULL,
     "read what lies under a node of a folder of parts alone, LEVEL-CODE as parts are named (all)"},
    {"paged", '\0', OPTION_PAGED, "BYTES", read_bytes, FIELD(paged), 1, UINT64_MAX, NULL,
     "draw a .svo file or parts with so much of it on the device: 65536, 512MiB, 4GB; the rest is read as rays need it "
     "(all)"},
    {"max-memory", '\0', OPTION_BUILD_COMMAND | OPTION_PARTS_COMMAND, "BYTES", read_bytes, FIELD(max_memory), 0,
     UINT64_MAX, NULL,
     "build in parts that take at most so much memory each: 65536, 512MiB, 4GB (build: in one piece); of point "
     "clouds, most memory"},
    {"max-memory", '\0', OPTION_EDIT_COMMAND, "BYTES", read_bytes, FIELD(max_memory), SVO_EDIT_BYTES_MIN, UINT64_MAX,
     NULL, "most memory of the nodes that are edited: 512MiB, 4GB (half of the machine's)"},
    {"resume", '\0', OPTION_BUILD_COMMAND, NULL, read_flag, FIELD(resume), 0, 0, NULL,
     "with --max-memory: keep the parts that an earlier run has finished"},
    {"part", '\0', OPTION_PARTS_COMMAND, "PART", read_text, FIELD(part), 0, 0, NULL,
     "parts build: the part to build, its index or its LEVEL-CODE (all); parts share: the share to write (none, shares "
     "are begun)"},
    {"shares", '\0', OPTION_PARTS_COMMAND, "N", read_count, FIELD(shares), 1, 65536, NULL,
     "parts share, stitch: how many shares of the file are written side by side (stitch: none, it writes all)"},
    {"parts", '\0', OPTION_PARTS_CHECK, "FOLDER", read_text, FIELD(parts_path), 0, 0, NULL,
     "compare a folder of parts of INPUT, in regions here and there (the tree that is built of INPUT)"},
    {"sample", '\0', OPTION_PARTS_COMMAND | OPTION_PARTS_CHECK, "N", read_count, FIELD(sample), 1, UINT32_MAX, NULL,
     "parts check: how many parts are checked, spread over the tree (all); verify: how many regions of parts (100)"},
    {"max-voxels", '\0', OPTION_UNFOLDED, "N", read_count, FIELD(max_voxels), 1, UINT32_MAX, NULL,
     "most voxels that a voxel file or a tree may unfold to, those of all levels (what memory holds)"},
    {"solid", '\0', OPTION_SOLID, "RULE", read_choice, FIELD(solid), 0, 0, solids,
     "also fill the inside, by winding, parity or generalized winding numbers; -o then writes the solid (not filled)"},
    {"band", '\0', OPTION_SDF_COMMAND, "VOXELS", read_amount, FIELD(band), 0, 0, NULL,
     "only voxels less than so many voxels' widths from the surface; 0: all voxels (3)"},
    {"iso", '\0', OPTION_MESH_COMMAND, "DISTANCE", read_distance, FIELD(iso), 0, 0, NULL,
     "where the surface is: at this distance from the mesh, in its units; below 0 inside (0)"},
    {"colors", '\0', OPTION_MESH_COMMAND, NULL, read_flag, FIELD(colors), 0, 0, NULL,
     "vertices also have colors, those of the nearest voxels (positions and normals)"},
    {"sign", '\0', OPTION_DISTANCES, "RULE", read_choice, FIELD(sign), 0, 0, signs,
     "what is inside, with negative distances: winding, parity, none (winding)"},
    {"margin", '\0', OPTION_DISTANCES, "VOXELS", read_amount, FIELD(margin), 0, 0, NULL,
     "room around the mesh in its grid, on each side (the band and 1; of dense fields 4; of mesh 2)"},
    {"axes", '\0', OPTION_BUILD | OPTION_CONVERT_COMMAND, "NAME", read_choice, FIELD(axes), 0, 0, axes_of_files,
     "what is up in files: auto, z in .vox, .bt and .las, else y; z-up; keep, nothing is turned (auto)"},
    {"weld", '\0', OPTION_BUILD, "DISTANCE", read_amount, FIELD(weld), 0, 0, NULL,
     "mesh files: vertices within this distance of an earlier one get its position (0: none do)"},
    {"hidden", '\0', OPTION_VOXELS, NULL, read_flag, FIELD(hidden), 0, 0, NULL,
     "voxel files: also read what hidden layers and nodes hold"},
    {"counts", '\0', OPTION_VOXELS, NULL, read_flag, FIELD(counts), 0, 0, NULL,
     "point clouds: the material of a voxel is the number of its points"},
    {"frame", '\0', OPTION_VOXELS, "N", read_count, FIELD(frame), 0, INT32_MAX, NULL,
     "voxel files: the frame, or the model where there is no scene (0)"},
    {"max-bytes", '\0', OPTION_WEB_COMMAND, "BYTES", read_bytes, FIELD(max_bytes), 1, (uint64_t)256 << 20, NULL,
     "most bytes of the page, up to 256MiB; a larger tree is cut at the deepest level that fits (32MiB)"},
    {"width", '\0', OPTION_VIEW_COMMAND, "N", read_count, FIELD(window_width), 160, 16384, NULL,
     "width of the window in pixels (that of the last time; 1280)"},
    {"height", '\0', OPTION_VIEW_COMMAND, "N", read_count, FIELD(window_height), 160, 16384, NULL,
     "height of the window in pixels (that of the last time; 800)"},
    {"fullscreen", '\0', OPTION_VIEW_COMMAND, NULL, read_flag, FIELD(fullscreen), 0, 0, NULL, "cover the screen"},
    {"scale", '\0', OPTION_VIEW_COMMAND, "S", read_scale, FIELD(scale), 0, 0, NULL,
     "size of panels and text, 1 to 4 (that of the display)"},
    {"script", '\0', OPTION_VIEW_COMMAND, "FILE", read_text, FIELD(script_path), 0, 0, NULL,
     "keys, moves, clicks, waits and shots to play, in place of hands; the same pictures on every run"},
    {"compress", '\0', OPTION_BUILD_COMMAND | OPTION_CONVERT_COMMAND, NULL, read_flag, FIELD(compress), 0, 0, NULL,
     "compress the .svo file with zstd"},
    {"tree-form", '\0', OPTION_FORM, "NAME", read_choice, FIELD(tree_form), 0, 0, checked_forms,
     "also expand a compact form: descriptor, implied, shared, mirrored, or all of them (none)"},
    {"tree-form", '\0', OPTION_TREE_FORM, "NAME", read_choice, FIELD(tree_form), 0, 0, forms,
     "the compact form that the tree has here and in .svc files: descriptor, implied, shared, mirrored (that of "
     "INPUT)"},
    {"minimize", '\0', OPTION_TREE_FORM, NULL, read_flag, FIELD(minimize), 0, 0, NULL,
     "with --tree-form: eight leaves of one payload become a leaf"},
    {"directory-step", '\0', OPTION_TREE_FORM, "N", read_choice, FIELD(directory_step_log2), 0, 0, directory_steps,
     "with --tree-form implied: nodes for which its directory has an entry, 16, 32 or 64 (32; export-web: 16)"},
    {"color-error", '\0', OPTION_TREE_FORM, "E", read_color_error, FIELD(color_error), 0, 255, NULL,
     "with --tree-form: payload is packed; red, green and blue may change by so much, 0 .. 255; 0: exact"},
    {"normal-bits", '\0', OPTION_TREE_FORM, "N", read_choice, FIELD(normal_bits), 0, 0, normal_bits,
     "with --tree-form: payload is packed; normals are octahedral with 2 N bits, N 4 .. 8 (exact)"},
    {"merge", '\0', OPTION_CONVERT_COMMAND, NULL, read_flag, FIELD(merge), 0, 0, NULL,
     "OUT .ply or .obj: the surface as rectangles, faces of one color merged; a mesh that can be read back"},
    {"nodes", '\0', OPTION_HASH_COMMAND, NULL, read_flag, FIELD(nodes), 0, 0, NULL,
     "hash only the nodes, without lists and payload"},
    {"expect", '\0', OPTION_HASH_COMMAND, "HASH", read_hash, FIELD(expected_hash), 0, 0, NULL,
     "fail with exit code 1 unless the hash is this one (any hash is right)"},
    {"picture", '\0', OPTION_DIFF_COMMAND, "FILE", read_text, FIELD(output_path), 0, 0, NULL,
     "PNG file to write: voxels of A alone in orange, of B alone in blue, with other payload in yellow (none)"},
    {"light", '\0', OPTION_HASH_COMMAND, "FORM", read_light, FIELD(light_form), 0, 0, light_forms,
     "hash the light of a sun and a lamp, stored as faces, bricks or voxels (the tree)"},
    {"vs", '\0', OPTION_BENCH_COMMAND, "NAME", read_choice, FIELD(versus), 0, 0, rivals,
     "also measure this, interleaved: embree or grid (leaf lists without the tree) for rays, openvdb for solid (none)"},
    {"ray-count", '\0', OPTION_BENCH_COMMAND, "N", read_count, FIELD(ray_count), 1, 100000000, NULL,
     "rays per set (1000000)"},
    {"workers", '\0', OPTION_BENCH_COMMAND, "LIST", read_text, FIELD(workers), 0, 0, NULL,
     "bench parts: comma-separated numbers of workers of one thread each (1,2)"},
    {"isa", '\0', OPTION_BENCH_COMMAND, "NAME", read_text, FIELD(isa), 0, 0, NULL,
     "instruction set of PoCL's kernels and of Embree: sse2, avx2 or avx512 (the widest of the processor)"},
    {"processes", '\0', OPTION_BENCH_COMMAND, "N", read_count, FIELD(processes), 1, 64, NULL,
     "gl-vs-cl: processes that measure, one after the other; 1: this one (3)"},
    {"time", '\0', OPTION_BENCH_COMMAND, "T", read_seconds, FIELD(time_bound), 0, 0, NULL,
     "gl-vs-cl: about when it ends: 600s (600s; --full: any)"},
    {"full", '\0', OPTION_BENCH_COMMAND, NULL, read_flag, FIELD(full), 0, 0, NULL,
     "gl-vs-cl: all depths and scenes with all needs, weights and coverages"},
    {"free", '\0', OPTION_TUNE_COMMAND, "LIST", read_text, FIELD(free_list), 0, 0, NULL,
     "what may vary, with commas between, by values or all: depth:7-9 coverage weights builder:cl+sorted frontend "
     "share path form light-form cones rays probes:4x64 (depth,coverage,weights,builder:cl+sorted)"},
    {"error", '\0', OPTION_TUNE_COMMAND, "LIST", read_text, FIELD(error_list), 0, 0, NULL,
     "bounds of errors, as voxel-rms-units:.01,normal:5; a measure without a number is to be the least (none)"},
    {"time", '\0', OPTION_TUNE_COMMAND, "T", read_seconds, FIELD(time_bound), 0, 0, NULL,
     "most time of a build with its queries: 20s, 500ms (any)"},
    {"memory", '\0', OPTION_TUNE_COMMAND, "BYTES", read_bytes, FIELD(memory_bound), 1, UINT64_MAX, NULL,
     "most memory on the device at one time: 65536, 512M, 4GB (any)"},
    {"queries", '\0', OPTION_TUNE_COMMAND, "N", read_count, FIELD(queries), 1, 1000000000, NULL,
     "so many gathered points, or without light rays through voxels, count in times (0; with light 100000)"},
    {"exhaustive", '\0', OPTION_TUNE_COMMAND, NULL, read_flag, FIELD(exhaustive), 0, 0, NULL,
     "measure all settings to the end, also those that cannot win"},
    {"page", '\0', OPTION_TUNE_COMMAND | OPTION_BENCH_COMMAND, "FILE", read_text, FIELD(page_path), 0, 0, NULL,
     "web page to write, with charts (none; bench: gl-vs-cl)"},
    {"csv", '\0', OPTION_TUNE_COMMAND | OPTION_BENCH_COMMAND, "FILE", read_text, FIELD(csv_path), 0, 0, NULL,
     "CSV file to write, a line for each round (none; bench: gl-vs-cl)"},
    {"resume", '\0', OPTION_TUNE_COMMAND, "FILE", read_text, FIELD(resume_path), 0, 0, NULL,
     "JSON file that keeps what is measured; a run that was interrupted goes on from it (none)"},
    {"json", '\0', OPTION_JSON, NULL, read_flag, FIELD(json), 0, 0, NULL, "print JSON on standard output"},
    {"quiet", 'q', OPTION_COMMON, NULL, read_flag, FIELD(quiet), 0, 0, NULL,
     "print errors and results, no report of what was done, no warnings, no progress"},
    {"verbose", 'v', OPTION_COMMON, NULL, read_flag, FIELD(verbose), 0, 0, NULL, "print the library's log"},
    {"help", 'h', OPTION_COMMON, NULL, read_flag, FIELD(help), 0, 0, NULL, "print this help"},
};

_Static_assert(sizeof rules / sizeof rules[0] <= OPTION_RULES_MAX, "a bit for each option");

const rule *options_rule(size_t index)
{
    return index < sizeof rules / sizeof rules[0] ? &rules[index] : NULL;
}

bool options_apply(const rule *option, const command *which)
{
    return (option->group & (which->groups | (unsigned)OPTION_COMMON)) != 0;
}
