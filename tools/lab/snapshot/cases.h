/* SPDX-License-Identifier: MIT */
/* The cases of a snapshot: requests (which tree of which mesh) and methods (how it is built), as tables. */
#ifndef SVOCL_TOOLS_SNAPSHOT_CASES_H
#define SVOCL_TOOLS_SNAPSHOT_CASES_H

#include <stddef.h>
#include <stdint.h>

#include "svocl/svocl.h"

/* How the mesh of a scene is changed. */
typedef enum mesh_variant {
    MESH_PLAIN = 0, /* unchanged */
    MESH_BARE, /* positions and triangles alone */
    MESH_TEXTURED, /* with texture coordinates and two textured materials */
    MESH_BROKEN, /* every seventh triangle has an index out of range */
    MESH_DOUBLES, /* coordinates in double, no indices */
    MESH_VARIANT_COUNT
} mesh_variant;

typedef struct request {
    const char *scene; /* as scene_create takes it */
    mesh_variant variant;
    unsigned depth;
    svo_coverage coverage;
    svo_weights weights;
    uint32_t need;
    uint32_t payload_level;
    double origin[3], edge; /* the caller's grid; edge 0: fitted */
    uint64_t chunk_bytes, fragment_capacity;
    uint32_t worst_case_nodes;
    unsigned methods; /* METHOD_ bits */
} request;

typedef enum method_front { FRONT_CL = 0, FRONT_GL_HOST, FRONT_GL_COPY } method_front;

typedef enum method_mode {
    MODE_BLOCKING = 0, /* svo_build */
    MODE_COUNTED, /* svo_plan_count before svo_build */
    MODE_ENQUEUED, /* svo_build_enqueue, svo_tree_finish without trim */
    MODE_TRIMMED, /* the same with trim */
    MODE_TWICE, /* two builds into one tree, scratch at an offset in the caller's buffer, trim */
    MODE_GL_COMPUTE /* svo_gl_build */
} method_mode;

typedef struct method {
    const char *name; /* "builder front-end share mode" */
    svo_builder builder;
    method_front front;
    method_mode mode;
} method;

#define METHOD_COUNT 13
extern const method methods[METHOD_COUNT];

extern const request requests[];
extern const size_t request_count;

/* Requests for which the OpenCL calls of each method are counted. */
extern const request counted_requests[];
extern const size_t counted_request_count;

/* Trees that are rendered and queried for rays and nearest points. */
extern const request query_requests[];
extern const size_t query_request_count;

/* Trees whose files are drawn page by page. */
extern const request paged_requests[];
extern const size_t paged_request_count;

/* Scenes that move, on grids of their own. */
extern const request moving_requests[];
extern const size_t moving_request_count;

/* Trees that one scene has instances of. */
#define INSTANCED_COUNT 3
extern const request instanced_requests[INSTANCED_COUNT];

/* "knot:2000 bare d8 half-open area color,normal level 4 ..." */
void request_name(const request *wanted, char *name, size_t name_bytes);
svo_plan_options request_options(const request *wanted, svo_builder builder);

#endif
