/* SPDX-License-Identifier: MIT */
/*
 * The command line: one parser and one table of options for all commands. Each command names the groups of options it
 * takes. The help is generated from the same table.
 */
#ifndef SVOCL_TOOLS_SUPPORT_OPTIONS_H
#define SVOCL_TOOLS_SUPPORT_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "svocl/gl.h"

struct program;

/* Which options a command takes. */
enum option_group {
    OPTION_COMMON = 1, /* help, quiet, verbose */
    OPTION_DEVICE = 2, /* the OpenCL device, its kernels and the threads */
    OPTION_BUILD = 4, /* how a mesh is built; does not apply to a finished tree */
    OPTION_JSON = 8,
    OPTION_OUTPUT = 16,
    OPTION_BUILD_COMMAND = 32, /* repeat, compress, plan */
    OPTION_HASH_COMMAND = 64,
    OPTION_SCENE_COMMAND = 128,
    OPTION_RENDER_COMMAND = 256, /* view, camera */
    OPTION_METHODS = 512, /* front end, share path, context: for any kind of build */
    OPTION_STRESS_COMMAND = 1024, /* count, seed */
    OPTION_BENCH_COMMAND = 2048, /* what is measured, and compared with what */
    OPTION_TRACE_COMMAND = 4096, /* rays, camera */
    OPTION_PICTURE_SIZE = 8192,
    OPTION_MEASURE = 16384, /* amount of work and number of repeats */
    OPTION_REPORT_COMMAND = 32768, /* from, docs */
    OPTION_FORM = 65536, /* verify: tree-form, of several forms */
    OPTION_SOLID = 131072, /* solid */
    OPTION_VOXELS = 262144, /* what is read of a voxel file */
    OPTION_CONVERT_COMMAND = 524288, /* a second argument, the file to write */
    OPTION_REFERENCE_COMMAND = 1048576, /* points, samples, range, lambda */
    OPTION_LIGHT = 2097152, /* lights, and the cones that gather them */
    OPTION_GATHER_COMMAND = 4194304, /* points, reference */
    OPTION_WEB_COMMAND = 8388608, /* max-bytes; of render: view, exposure, camera */
    OPTION_PROBES = 16777216, /* probes of a tree or a scene */
    OPTION_VIEW_COMMAND = 33554432, /* the window, script */
    OPTION_DEVICES_COMMAND = 67108864, /* path, of all devices */
    OPTION_LEVELS = 134217728, /* how much of a .svo file is read */
    OPTION_PARTS_COMMAND = 268435456, /* an argument before INPUT, which part */
    OPTION_PAGED = 536870912, /* how much of a file is held */
    OPTION_PICTURE_FILE = 1073741824 /* what a picture's file holds, and its frames */
};

/* Bits that an enumerator could not hold. */
#define OPTION_UNFOLDED     ((uint64_t)1 << 31) /* how large voxel files and trees may become */
#define OPTION_DIFF_COMMAND ((uint64_t)1 << 32) /* a second INPUT, picture */
#define OPTION_TUNE_COMMAND ((uint64_t)1 << 33) /* what is free, bounds, files */
#define OPTION_TREE_FORM    ((uint64_t)1 << 34) /* the form of a tree that is held or written */
#define OPTION_SDF_COMMAND  ((uint64_t)1 << 35) /* band */
#define OPTION_DISTANCES    ((uint64_t)1 << 36) /* sign, margin */
#define OPTION_MESH_COMMAND ((uint64_t)1 << 37) /* iso, colors */
#define OPTION_EDIT_COMMAND ((uint64_t)1 << 38) /* a second argument, the script; the memory of nodes */
#define OPTION_PARTS_CHECK  ((uint64_t)1 << 39) /* verify: parts, sample, seed */

enum option_frontend {
    OPTION_FRONTEND_AUTO = 0,
    OPTION_FRONTEND_CL, /* OpenCL alone */
    OPTION_FRONTEND_GL_EXPAND,
    OPTION_FRONTEND_GL_HW,
    OPTION_FRONTEND_GL_HYBRID
};

/* Next to the values of svo_builder. */
#define OPTION_BUILDER_GL_COMPUTE (-1)

/* The first value of svo_render_view that is of lights alone; and next to its values: SVO_VIEW_SHADED of a light. */
#define OPTION_VIEW_LIGHT ((int)SVO_VIEW_AO)
#define OPTION_VIEW_FULL  ((int)SVO_VIEW_SPECULAR + 1)

/* Formats of pictures: their places in the table of support/picture_files.c are their values less 1. */
enum option_format {
    OPTION_FORMAT_BY_NAME = 0, /* by the suffix of -o */
    OPTION_FORMAT_PNG,
    OPTION_FORMAT_EXR,
    OPTION_FORMAT_HDR,
    OPTION_FORMAT_PPM,
    OPTION_FORMAT_Y4M
};

enum option_sign { OPTION_SIGN_NONE = 100 }; /* beside svo_solid_rule */

enum option_background { OPTION_BACKGROUND_OWN = 0, OPTION_BACKGROUND_COLOR, OPTION_BACKGROUND_TRANSPARENT };

/* Next to 1 + the values of svo_form. */
#define OPTION_FORM_ALL (-1)

#define OPTION_MEETS_TRIANGLES 1
#define OPTION_MEETS_VOXELS    2

#define OPTION_VERSUS_EMBREE  1
#define OPTION_VERSUS_OPENVDB 2
#define OPTION_VERSUS_GRID    3

#define OPTION_DEFAULT_DEPTH 8
#define OPTION_DEFAULT_PAGE  ((uint64_t)32 << 20) /* bytes */
#define OPTION_CONTEXT_AUTO  (-1)
#define OPTION_DEFAULT_FPS   30u
#define OPTION_SAMPLES_MAX   262144
#define OPTION_RULES_MAX     192
#define OPTION_INPUTS_MAX    12 /* of bench, after the first */

/* A point or direction of the command line. */
typedef struct option_vector {
    double at[3];
    bool is_given;
} option_vector;

typedef struct options {
    const char *input; /* the argument that is not an option; NULL: none */
    const char *further_inputs[OPTION_INPUTS_MAX]; /* bench: the arguments after input */
    size_t further_count;
    const char *second_input; /* diff, edit: the argument after input; NULL: none */
    const char *subject; /* bench: what is measured; parts: what is done; the argument before input */
    uint64_t given_groups; /* groups of the options on the command line */
    uint64_t given_rules[OPTION_RULES_MAX / 64]; /* those options: bits, by their places in the table */
    const char *given_values[OPTION_RULES_MAX]; /* their values as they are written; NULL: a flag, or not given */
    uint64_t help, quiet, verbose, json; /* flags: 0 or 1 */

    const char *device_name; /* NULL: the library's choice */
    uint64_t threads; /* 0: the drivers decide */
    int path; /* svo_path */
    const char *kernels_path; /* folder of saved kernels; NULL: the user's */

    uint64_t depth;
    int frontend; /* option_frontend */
    bool has_depth;
    bool has_builder;
    bool depth_for_rays; /* set by commands: svo_plan_info.ray_depth in place of depth */
    int share; /* svo_gl_share */
    uint32_t hybrid_columns; /* 0: not given */
    bool tune;
    int builder; /* svo_builder or OPTION_BUILDER_GL_COMPUTE */
    int coverage; /* svo_coverage */
    int weights; /* svo_weights */
    double drop_alpha; /* 0: not given */
    int context; /* svo_gl_context_kind or OPTION_CONTEXT_AUTO */
    uint64_t strict; /* flag: warnings of the import are errors */
    uint64_t import_seconds; /* time limit of the import; 0: by the size of the file */
    uint64_t import_memory; /* bytes, of the import; 0: by the size of the file */
    const char *gl_device; /* EGL device by index or name; NULL: not given */
    double origin[3];
    bool has_origin;
    double edge; /* 0: not given */
    double voxel_size; /* 0: not given, or origin, edge and depth are of it already */
    uint32_t need; /* svo_need bits */

    const char *output_path; /* NULL: not given. convert: the second argument; diff: of --picture */
    uint64_t repeat, compress;
    uint64_t plan, plan_only, count_first; /* build: flags */
    uint64_t payload_level; /* build */
    uint64_t last_level; /* of a .svo file; 0: all */
    uint64_t sample; /* parts that are checked; 0: all */
    const char *parts_path; /* verify: the folder that is compared */
    const char *region; /* of a folder of parts, LEVEL-CODE; NULL: all */
    bool has_repeat;
    int tree_form; /* 0: as built, else 1 + svo_form; verify: or OPTION_FORM_ALL */
    int directory_step_log2; /* of the implied form; 0: not given */
    uint64_t minimize; /* compact trees: a flag */
    uint64_t color_error; /* of packed payload */
    bool has_color_error; /* given, whatever it is */
    int normal_bits; /* of packed payload; 0: not given */
    int meets; /* trace: 0 not given, else OPTION_MEETS_* */
    int solid; /* build, verify: 0 not given, else 1 + svo_solid_rule */
    uint64_t nodes; /* hash: nodes only */
    const char *expected_hash; /* hash: SVO_HASH_TEXT_BYTES - 1 digits; NULL: not given */
    bool has_light; /* hash: the light is hashed, of light_form */
    uint64_t triangles; /* scene: 0: not given */
    uint64_t seed;
    uint32_t width, height; /* pixels */
    int view; /* svo_render_view, or OPTION_VIEW_FULL */
    option_vector eye, look_at, up; /* render: the camera, world units */
    double fov; /* render: degrees; 0: not given */
    int from_side; /* render: 0: not given, else 1 + the place in the table of sides of support/viewpoint.c */
    uint64_t count; /* stress: amount of work */
    int versus; /* bench: 0 nothing, or OPTION_VERSUS_* */
    uint64_t ray_count; /* bench: rays per set */
    uint64_t processes, full; /* bench gl-vs-cl: 0: not given; a flag */
    const char *workers; /* bench parts: a list with commas; NULL: not given */
    const char *isa; /* bench: the instruction set of PoCL and of Embree; NULL: the processor's */
    const char *scenes, *depths; /* measurements: lists with commas; NULL: each measurement's own */
    uint64_t quick; /* measurements: a flag */
    const char *from; /* report: a file of measurements; NULL: measure now */
    const char *docs; /* report: the folder whose documents are updated; NULL: none */
    const char *rays_path, *camera; /* trace: NULL: not given */
    const char *points_path; /* light: a file of points, or how many; NULL: not given */
    uint64_t samples; /* light: paths for each point */
    double range, falloff; /* light: of ambient occlusion; 0: unlimited, none */
    const char *lights_path; /* light: NULL: not given */
    int cones; /* light: 0: not given */
    int gather_method; /* gather: an svo_gather_method */
    uint64_t paths, bounces; /* gather: 0: not given */
    double error_goal; /* gather: 0: none */
    int light_form; /* light: svo_light_form */
    int opacity; /* light: svo_opacity */
    const char *light_file; /* render: NULL: not given */
    const char *mesh_path; /* of a stored tree that is lit; NULL: not given */
    int one_side; /* light: 1: of closed meshes the front alone is opaque */
    int photons, gi; /* light: 0: off */
    uint64_t emission_photons; /* light: 0: none */
    double exposure; /* light: of pictures; 0: not given */
    uint64_t reference; /* gather: paths for each point; 0: none */
    uint64_t hidden, frame; /* voxel files: a flag, and the number of a frame */
    uint64_t counts; /* point clouds: a flag */
    int axes; /* an svo_axes */
    uint64_t merge; /* convert: a flag */
    double weld; /* of mesh files: a distance; 0: none */
    uint64_t max_bytes; /* export-web: of the page */
    int through; /* render: 0 the tree, 1 probes */
    uint32_t probe_counts[3]; /* probes along each axis */
    uint64_t probe_resolution, probe_field; /* texels along a map's side, field cells an axis; 0: not given */
    uint64_t window_width, window_height; /* view: pixels; 0: not given */
    uint64_t fullscreen; /* view: a flag */
    double scale; /* view: of panels; 0: not given */
    const char *script_path; /* view: NULL: not given */
    double band; /* sdf: voxels; 0: dense */
    double margin; /* sdf, mesh: voxels; below 0: not given */
    double iso; /* mesh: world units */
    uint64_t colors; /* mesh: a flag */
    int sign; /* sdf, mesh: svo_solid_rule or OPTION_SIGN_NONE */
    uint64_t max_voxels; /* of voxel files and trees; 0: by memory */
    uint64_t max_memory; /* build, parts: bytes that a part may take; edit: nodes; 0: not given */
    uint64_t resume; /* build: a flag */
    const char *part; /* parts: NULL: not given, else an index, or of parts LEVEL-CODE */
    uint64_t shares; /* parts: 0: not given */
    uint64_t animate, verify_frames; /* render: flags */
    uint64_t frames; /* render: of an animation */
    uint64_t paged; /* render: bytes of buffers for a file that is paged; 0: not given */
    int format; /* render: option_format */
    int background; /* render: option_background */
    uint8_t background_bytes[3]; /* of OPTION_BACKGROUND_COLOR: red, green, blue */
    uint64_t pixel_samples; /* render: rays of a pixel; 0: the picture's own number */
    uint64_t turntable; /* render: frames round the up axis; 0: not given */
    uint64_t frame_rate; /* render: of a film, frames a second; 0: not given */
    const char *free_list, *error_list; /* tune: NULL: not given */
    double time_bound; /* tune, bench gl-vs-cl: seconds; 0: not given */
    uint64_t memory_bound; /* tune: bytes; 0: not given */
    uint64_t exhaustive; /* tune: a flag */
    uint64_t queries; /* tune: that count in times */
    const char *page_path, *csv_path, *resume_path; /* tune, the first two of bench too: NULL: not given */
} options;

/* The option that asks for packed payload, without dashes; NULL: none. */
static inline const char *options_packing(const options *given)
{
    return given->has_color_error ? "color-error" : given->normal_bits != 0 ? "normal-bits" : NULL;
}

enum option_output {
    OPTION_OUTPUT_BYTES = 0, /* a file of bytes that no terminal shows */
    OPTION_OUTPUT_TEXT, /* a file of text */
    OPTION_OUTPUT_FOLDER
};

typedef struct command {
    const char *name;
    bool in_lab; /* svocl-lab runs it */
    uint64_t groups;
    const char *input_name; /* "INPUT"; NULL: takes none */
    bool needs_input;
    const char *summary; /* one line */
    bool reads_file; /* INPUT may be a file or a pipe */
    bool compares; /* the exit code is 1 for different inputs alone, and 2 for every failure, as that of cmp(1) */
    enum option_output output; /* what -o names */
    const char *suffixes; /* of the files that the command writes, ".obj .ply"; NULL: any. ".svc" with --tree-form or
                             --solid, and then no other */
    bool needs_suffix; /* it tells the format */
    const char *const *examples; /* arguments after "svocl"; ends with NULL */
} command;

#endif
