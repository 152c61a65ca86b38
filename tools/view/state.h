/* SPDX-License-Identifier: MIT */
/*
 * What the viewer shows and knows: plain data, without a type of SDL, OpenGL or OpenCL, and the functions that change
 * it. Keys, the mouse, scripts and panels all go through these functions. What they change is drawn by the next frame:
 * the drawing compares the state with what it drew last.
 */
#ifndef SVOCL_TOOLS_VIEW_STATE_H
#define SVOCL_TOOLS_VIEW_STATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "support/scene_motion.h"
#include "support/sky_file.h"
#include "svocl/light.h"
#include "svocl/probes.h"
#include "svocl/scene.h"
#include "svocl/trace.h"

#define VIEW_NAME_BYTES         64
#define VIEW_PATH_BYTES         1024
#define VIEW_LOG_LINES          200
#define VIEW_FRAMES_KEPT        240
#define VIEW_LIST_KEPT          256
#define VIEW_COARSE_MAX         8u
#define VIEW_EDGE_MIN           160u /* of the window, pixels */
#define VIEW_EDGE_MAX           16384u
#define VIEW_EXPOSURE_MAX       64.0F
#define VIEW_SPEED_MAX          4 /* of motions, as a power of two */
#define VIEW_RECENT_MAX         8 /* files that were opened */
#define VIEW_NOTICE_BYTES       2048
#define VIEW_PROBES_AXIS        32u /* most probes along an axis that the panel offers */
#define VIEW_BRUSH_MAX          64.0F /* radius of the brush, voxels */
#define VIEW_BRUSH_PLACES       256 /* of the mouse in a frame */
#define VIEW_BRUSH_MATERIAL_MAX 65534 /* as voxels have it */

/* ---- what is shown ---- */

/* In the order of their keys, 1 to 9 and 0; the last one has none. */
typedef enum view_picture {
    VIEW_SHADED = 0,
    VIEW_NORMAL,
    VIEW_DEPTH,
    VIEW_STEPS,
    VIEW_LEVEL,
    VIEW_TRIANGLES,
    VIEW_AO,
    VIEW_DIRECT,
    VIEW_GI,
    VIEW_FULL,
    VIEW_SPECULAR,
    VIEW_PICTURES
} view_picture;

/* A grid of probes that is asked for. */
typedef struct view_probe_grid {
    uint32_t counts[3];
    uint32_t resolution; /* 0: what max_mib allows, 256 at most */
    uint32_t field_size;
    uint32_t max_mib; /* of texels */
} view_probe_grid;

/* A plane that cuts away what is on its near side: points p with normal . p < offset. */
typedef struct view_clip {
    bool is_on;
    float normal[3]; /* unit */
    float offset; /* world units along it */
} view_clip;

/* Everything that decides a picture besides camera, lights and instances. */
typedef struct view_shown {
    view_picture picture;
    unsigned level; /* of the leaves: view_state.level_min .. level_max */
    bool gi; /* VIEW_FULL shows indirect light */
    bool photons; /* surfaces that the lights reach light others */
    svo_light_form form; /* how light is stored */
    unsigned cones; /* 1, 5, 6, 16, 64; 0: exact rays in their place */
    float exposure;
    float range, falloff; /* of ambient occlusion; 0: unlimited, none */
    bool through; /* camera rays pass probes, not the tree */
    view_probe_grid probes; /* where they are shown: view_shows_probes */
    view_clip clip;
} view_shown;

/* Everything that decides the bytes of a picture: it is drawn anew when one of these differs from what was drawn. */
typedef struct view_revisions {
    unsigned lights; /* sources and sky */
    unsigned instances;
    unsigned film; /* the tree of what moves */
    unsigned strokes; /* of the brush */
} view_revisions;

/* ---- camera ---- */

typedef enum view_camera_mode { VIEW_ORBIT = 0, VIEW_FLY } view_camera_mode;

/* Directions in which the camera moves while their keys are held: W S A D R F. */
typedef enum view_motion {
    VIEW_FORWARD = 0,
    VIEW_BACK,
    VIEW_LEFT,
    VIEW_RIGHT,
    VIEW_UP,
    VIEW_DOWN,
    VIEW_MOTIONS
} view_motion;

typedef struct view_camera {
    svo_camera at;
    svo_camera home; /* where it began */
    float up[3]; /* of the world, unit; zero: at.up */
    view_camera_mode mode;
    float speed; /* world units a second */
    bool held[VIEW_MOTIONS];
} view_camera;

/* ---- selection ---- */

/* What a click found. */
typedef struct view_selection {
    bool is_hit;
    float t; /* world units from the eye */
    float point[3]; /* world */
    uint32_t instance; /* SVO_NO_INSTANCE: the tree is not placed */
    uint32_t triangle; /* position in the mesh's index array; SVO_NO_TRIANGLE: the tree has none, or none was hit */
    float corners[3][3]; /* world; of the triangle */
    uint32_t node; /* SVO_NO_NODE: none was hit */
    unsigned level; /* of the node */
    bool has_box;
    float box[8][3]; /* world; the corners of the node: bit a of the number is the high side of axis a */
    bool has_color, has_normal, has_material, has_fill;
    uint8_t color[4];
    float normal[3];
    unsigned material, fill;
    size_t list_count; /* triangles of the leaf */
    size_t list_kept; /* of those, in list: the first VIEW_LIST_KEPT */
    uint32_t list[VIEW_LIST_KEPT]; /* positions in the mesh's index array */
    float list_corners[VIEW_LIST_KEPT][3][3]; /* world */
} view_selection;

/* ---- the brush ---- */

typedef enum view_brush_tool {
    VIEW_BRUSH_SET = 0,
    VIEW_BRUSH_CLEAR,
    VIEW_BRUSH_PAINT,
    VIEW_BRUSH_TOOLS
} view_brush_tool;
typedef enum view_brush_shape { VIEW_BRUSH_SPHERE = 0, VIEW_BRUSH_BOX, VIEW_BRUSH_SHAPES } view_brush_shape;

/* What a hand does to the voxels of a tree alone. While it is on, pictures are of the edit and not of the tree. */
typedef struct view_brush {
    bool is_on;
    view_brush_tool tool;
    view_brush_shape shape;
    float radius; /* voxels; of a box, half of its edge */
    float color[3]; /* 0 .. 1, as voxels have it */
    int material;
    /* What the mouse asks for, in pixels of the window. */
    float mouse[2]; /* the first below 0: over a panel */
    bool is_down; /* a stroke is under way */
    bool begins; /* it has no place yet */
    bool is_beside; /* it began where nothing is: the drag turns the camera */
    bool takes; /* color and material of the voxel under the mouse */
    float places[VIEW_BRUSH_PLACES][2]; /* that the stroke came by since the last frame */
    size_t place_count;
    /* What the drawing says. */
    bool is_over; /* a voxel is under the mouse */
    int32_t voxel[3];
    float box[8][3]; /* world; its corners, as those of a selection */
    float center[3], reach; /* world; of the stroke that a click would make, and half of its width */
    uint64_t voxel_count; /* of the edit */
    uint64_t position; /* shapes that the edit has; history.h goes back and forth */
    uint64_t oldest; /* position: the edit has forgotten those before */
} view_brush;

/* ---- probes ---- */

/* What a probe's map shows. */
typedef enum view_map { VIEW_MAP_RADIANCE = 0, VIEW_MAP_NORMAL, VIEW_MAP_DISTANCE, VIEW_MAPS } view_map;

typedef struct view_probes {
    view_probe_grid asked; /* what the panel edits; view_make_probes shows it */
    bool has_spheres, has_map; /* shown */
    view_map map;
    uint32_t chosen; /* the probe whose map is shown */
    /* What the drawing says of them. */
    svo_probe_info planned; /* of asked; probe_count 0: refused */
    char refusal[SVO_MESSAGE_BYTES]; /* why */
    svo_probe_info made; /* probe_count 0: there are none */
    const svo_probe *places; /* made.probe_count */
    const uint32_t *texels; /* of the map, as probe_types.h has them; NULL: none is shown */
    uint32_t texture; /* of the map, as the window knows it */
    float found[SVO_PROBE_UNKNOWN + 1]; /* percent of the rays of the last picture, by their outcome */
} view_probes;

/* ---- instances ---- */

/* A tree that can be placed. */
typedef struct view_tree {
    char name[VIEW_NAME_BYTES]; /* as the scene file calls it */
    char path[4096]; /* a .svo or .svc file, a mesh or scene:...; relative to where the program runs */
    unsigned depth; /* 0: not given */
} view_tree;

/* An instance that moves. */
typedef struct view_mover {
    size_t instance;
    const scene_motion *motion; /* as the scene's file has it */
    scene_place first; /* where its first key is now; the others follow (view_mover_key) */
} view_mover;

/* ---- motions ---- */

/* Motions frame by frame, as svocl render --animate has them. */
typedef struct view_film {
    uint64_t frame_count;
    uint64_t frame; /* that is asked for */
    double position; /* in frames; what plays is between two */
    float first_time, last_time; /* of all motions */
    double time; /* of the frame that is shown */
    bool is_playing, loops; /* after the last frame comes the first */
    int speed_log2; /* motions' time in a second; -VIEW_SPEED_MAX .. VIEW_SPEED_MAX */
} view_film;

/* ---- statistics ---- */

typedef enum view_stage {
    VIEW_STAGE_EVENTS = 0,
    VIEW_STAGE_TREE, /* a level or a light is made */
    VIEW_STAGE_PICTURE, /* OpenCL */
    VIEW_STAGE_UPLOAD, /* to the texture */
    VIEW_STAGE_PANELS,
    VIEW_STAGE_SHOW, /* OpenGL until the buffers are swapped */
    VIEW_STAGES
} view_stage;

/* One frame. In a script times are those of its clock. */
typedef struct view_frame {
    float ms; /* from the begin of the one before to the begin of this one */
    float work_ms; /* of the stages: what ms has beyond it is waiting */
    float stage_ms[VIEW_STAGES];
    uint64_t rays; /* from the camera; 0: nothing was drawn */
    unsigned coarse; /* pixels along the side of a block of one color; 1: fully refined */
} view_frame;

/* Device memory of one buffer. */
typedef struct view_memory {
    char name[VIEW_NAME_BYTES];
    uint64_t planned_bytes; /* 0: the plan did not list it */
    uint64_t bytes;
} view_memory;

#define VIEW_MEMORY_MAX 48

/* A piece of a line in the world. */
typedef struct view_piece {
    float from[3], to[3];
    float color[4];
} view_piece;

/* ---- panels and settings ---- */

/* In the order of their keys, F1 to F10, F12, K and J. */
typedef enum view_panel {
    VIEW_PANEL_HELP = 0,
    VIEW_PANEL_FRAMES,
    VIEW_PANEL_MEMORY,
    VIEW_PANEL_PICTURE,
    VIEW_PANEL_CAMERA,
    VIEW_PANEL_LIGHTS,
    VIEW_PANEL_SELECTION,
    VIEW_PANEL_INSTANCES,
    VIEW_PANEL_SETTINGS,
    VIEW_PANEL_LOG,
    VIEW_PANEL_PROBES,
    VIEW_PANEL_MOTION,
    VIEW_PANEL_BRUSH,
    VIEW_PANELS
} view_panel;

/* What is kept from one run to the next. */
typedef struct view_settings {
    unsigned width, height; /* of the window, pixels */
    bool fullscreen;
    bool panels; /* shown at all */
    bool open[VIEW_PANELS];
    float turn_speed; /* radians for the width of the window */
    float move_speed; /* widths of the scene a second */
    float goal_ms; /* of a frame while something moves */
    unsigned coarse; /* while something moves: 1, 2, 4, 8; 0: by goal_ms */
    float text_scale; /* 0: by the window; above 1: large */
    char recent[VIEW_RECENT_MAX][VIEW_PATH_BYTES]; /* files that were opened, the last one first; "" behind the last */
    bool axes, grid; /* shown */
} view_settings;

/* ---- opening files ---- */

/* The box that asks for a file. */
typedef struct view_open {
    bool is_shown;
    bool takes_focus; /* its field is to be typed into */
    char path[VIEW_PATH_BYTES]; /* as it was typed */
    char listed[VIEW_PATH_BYTES]; /* the path whose names are below */
    char **names; /* what the path's folder has that begins as the path ends; folders end with a slash */
    size_t name_count;
    size_t chosen; /* of names; name_count: none */
} view_open;

/* A picture of the window that is asked for. */
typedef enum view_shot { VIEW_SHOT_NONE = 0, VIEW_SHOT_PICTURE, VIEW_SHOT_WINDOW /* with panels */ } view_shot;

/* ---- what is saved ---- */

/* What a session can edit and save: a scene, the lights of a tree alone, or its voxels. */
typedef enum view_document { VIEW_SCENE = 0, VIEW_LIGHTS, VIEW_VOXELS, VIEW_DOCUMENTS } view_document;

typedef enum view_asking {
    VIEW_ASKS_NOTHING = 0,
    VIEW_ASKS_TO_SAVE, /* before work is lost */
    VIEW_ASKS_FOR_NAME,
    VIEW_ASKS_TO_REPLACE /* a file that is there */
} view_asking;

/* What the window asks; question.h answers. */
typedef struct view_question {
    view_asking asking;
    view_document document;
    bool *wish; /* what becomes true once nothing is lost; NULL: nothing waits */
    bool is_new; /* it was not drawn yet */
    bool has_failed; /* the last line of the log says why the name was not taken */
    char path[VIEW_PATH_BYTES]; /* that is asked about */
} view_question;

/* Steps of edits; history.h has them. */
typedef struct view_history view_history;

/* ---- all of it ---- */

typedef struct view_state {
    const char *input; /* INPUT, for titles */
    const char *device; /* name of the OpenCL device */
    const char *renderer; /* name of OpenGL's */
    const char *share; /* how pictures get from the one to the other, as svo_name has it; NULL: none did */
    char *share_reason; /* what that is, and why not shared; NULL: nothing to say */
    unsigned width, height; /* of the window, pixels */
    float scale; /* pixels for each pixel of a plain display: of panels and of what a hand does */
    bool is_done; /* the window is to close */
    view_shown shown;
    view_revisions revisions;
    view_camera camera;
    double seconds; /* of the clock */
    float low[3], high[3]; /* world; the box of what is shown */
    const view_piece *ground; /* ground_count: the lines that are seen of the ground grid */
    size_t ground_count;
    float depth_range[2]; /* world units from the eye that view depth shows in white and in dark gray */
    float ground_spacing; /* world units between its lines; 0: it is not shown */
    bool exposure_is_automatic; /* shown.exposure follows what is in view */
    bool is_refined; /* the window shows the picture in full */
    bool is_idle; /* and nothing moves: frames wait for an event */

    unsigned level_min, level_max; /* of leaves to choose from; equal where the tree cannot be built anew */
    bool has_triangles; /* VIEW_TRIANGLES and picking of triangles work */
    bool is_scene; /* placed trees, not a tree alone: VIEW_SHADED alone, and what probes show without light */

    svo_light_source *sources; /* source_count of source_capacity */
    size_t source_count, source_capacity;
    float sky[3]; /* zero where there is a map */
    const sky_file *sky_map; /* of the file of lights, kept as it is; NULL: none */
    size_t source; /* the chosen one */

    const view_tree *trees;
    size_t tree_count;
    svo_instance *instances; /* instance_count of instance_capacity */
    size_t instance_count, instance_capacity;
    size_t instance; /* the chosen one */
    view_mover *movers; /* mover_count of mover_capacity, by ascending instance */
    size_t mover_count, mover_capacity;
    view_film film;
    scene_place edited; /* how an instance was placed last: its angles, which its matrix does not tell */
    svo_scene_light scene_lights[SVO_SCENE_LIGHTS_MAX]; /* of a scene, in place of sources */
    size_t scene_light_count;
    size_t scene_light; /* the chosen one */
    float occlusion_range; /* of a scene; 0: its own */
    const char *scene_form; /* as the scene's file calls it; NULL: there is no file */
    char scene_path[VIEW_PATH_BYTES]; /* of the scene's file */
    const struct file_register *files; /* what is shown is read from these, so nothing is saved there; NULL: unknown */
    bool wants_load; /* scene_path is to be loaded */
    view_open open; /* the box */
    char open_path[VIEW_PATH_BYTES]; /* a file in place of what is looked at */
    bool wants_open; /* it is to be loaded */
    char notice[VIEW_NOTICE_BYTES]; /* a failure in a box that waits to be closed; "": none */
    view_shot wants_shot;
    char lights_path[VIEW_PATH_BYTES]; /* of the lights of a tree alone; "": they have no file yet */
    char voxels_path[VIEW_PATH_BYTES]; /* of its voxels, the same */
    bool wants_voxels; /* they are to be written to question.path */
    char own_paths[VIEW_DOCUMENTS][VIEW_PATH_BYTES]; /* read or written by this session: replaced without a question */
    bool unsaved[VIEW_DOCUMENTS]; /* edits that no file has */
    view_question question;
    view_history *history; /* NULL: nothing is open */
    double wheel_rests; /* in the clock's seconds: until then the wheel may go on moving a light */
    view_revisions looked; /* those that unsaved tells of */

    view_selection selection;
    view_brush brush;
    view_probes probes;

    view_frame frames[VIEW_FRAMES_KEPT]; /* a ring */
    size_t frame_count; /* of all frames; the last one is at (frame_count - 1) % VIEW_FRAMES_KEPT */
    view_memory memory[VIEW_MEMORY_MAX];
    size_t memory_count;
    char *log[VIEW_LOG_LINES]; /* a ring; view_log_line reads it */
    size_t log_count; /* of all lines */

    view_settings settings;
} view_state;

/* The state before anything is loaded. */
void view_state_begin(view_state *state);
/* Frees its arrays and texts. */
void view_state_end(view_state *state);
/* The state for something else in the same window: of what was there only the window, settings, statistics and the log
   stay. */
void view_state_renew(const view_state *before, view_state *fresh);

/* Whether so many numbers are finite and within a thousand million, as hands may not leave them. */
bool view_is_moderate(const float *numbers, size_t count);

/* "shaded", "normal", ...: as svocl render --view has them. */
const char *view_picture_name(view_picture picture);
/* "radiance", "normal", "distance". */
const char *view_map_name(view_map map);
/* "events", "tree", ... */
const char *view_stage_name(view_stage stage);
/* "help", "frames", ... */
const char *view_panel_name(view_panel panel);

/* Replaces a text of the state by one of any length, since names of drivers have any. NULL where memory ran out. */
void view_set_text(char **text, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Adds a line to the log, of any length. */
void view_log(view_state *state, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Line `back` before the last one; "" where there is none. */
const char *view_log_line(const view_state *state, size_t back);

/* Asks for a file in place of what is looked at; the next frame loads it. */
void view_open_file(view_state *state, const char *path);
/* Puts a file in front of those that were opened. */
void view_remember_file(view_state *state, const char *path);
/* Says a failure in a box, and in the log. */
void view_notice(view_state *state, const char *text);

/* Whether closing what is shown would lose edits. */
bool view_is_unsaved(const view_state *state);
/* For whatever closes what is shown: sets a wish of the state, such as is_done or wants_load, at once if nothing is
   lost, else when the window's question is answered with Save or Discard. After Cancel it stays false. */
void view_leave(view_state *state, bool *wish);

/* Chooses a picture. Where it cannot be drawn the log says why, and nothing changes. */
void view_choose_picture(view_state *state, view_picture picture);
/* Clamped to what there is. */
void view_choose_level(view_state *state, int level);
void view_choose_form(view_state *state, svo_light_form form);
void view_choose_gi(view_state *state, bool is_on);
void view_choose_photons(view_state *state, bool is_on);
/* Which ends automatic exposure; and begins or ends that. */
void view_choose_exposure(view_state *state, float exposure);
void view_choose_automatic_exposure(view_state *state, bool is_on);
void view_toggle_panel(view_state *state, view_panel panel);
/* Whether the tree of what moves is shown. */
bool view_shows_film(const view_state *state);

/* Clips by a plane through the middle of what is shown, across the axis that the camera looks along most; or clips no
   more. */
void view_choose_clip(view_state *state, bool is_on);
/* The least and the greatest offset of planes of a normal that meet the box of what is shown. */
void view_clip_range(const view_state *state, const float normal[3], float range[2]);
/* As svo_render_options.clip has it; zeros where nothing is clipped. */
void view_clip_plane(const view_state *state, float plane[4]);

/* "set", "clear", "paint"; "sphere", "box": as svocl edit has them. */
const char *view_brush_tool_name(view_brush_tool tool);
const char *view_brush_shape_name(view_brush_shape shape);
/* Begins or ends drawing on the tree alone, in view shaded. Where there is none the log says so. */
void view_choose_brush(view_state *state, bool is_on);
/* Clamped. */
void view_choose_brush_radius(view_state *state, float radius);
/* The mouse at a place of the window: a stroke begins or goes on there. */
void view_brush_press(view_state *state, int x, int y);
void view_brush_move(view_state *state, int x, int y);

/* Looks through probes, in a view that they have, or at the tree again. */
void view_choose_through(view_state *state, bool is_on);
bool view_grid_differs(const view_probe_grid *a, const view_probe_grid *b);
/* Shows the grid that is asked for. */
void view_make_probes(view_state *state);
/* Clamped to those that were made. */
void view_choose_probe(view_state *state, int64_t index);
/* Whether the picture, spheres or a map show probes, so that they have to be made. */
bool view_shows_probes(const view_state *state);
/* Shows nothing of them any more. */
void view_hide_probes(view_state *state);
/* The same, and says that what moves has none. */
void view_refuse_probes(view_state *state);

#endif
