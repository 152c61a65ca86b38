/* SPDX-License-Identifier: MIT */
/* What `svocl bench` measures, by name: for its help, the manual pages and the completion of shells, which are made by
   programs that measure nothing. tools/lab has the measurements. */
#ifndef SVOCL_TOOLS_SUPPORT_SUBJECTS_H
#define SVOCL_TOOLS_SUPPORT_SUBJECTS_H

/* In order of execution. The group "all" comes first, then the group "errors". */
typedef enum subject_id {
    SUBJECT_VOXELIZE,
    SUBJECT_BUILD,
    SUBJECT_FILTER,
    SUBJECT_STARTUP,
    SUBJECT_IMPORT,
    SUBJECT_CONVERT,
    SUBJECT_RAYS,
    SUBJECT_VOXEL_RAYS,
    SUBJECT_COMPACT,
    SUBJECT_SOLID,
    SUBJECT_SCENE,
    SUBJECT_LIGHT,
    SUBJECT_LEAVING_OUT,
    SUBJECT_SIZES,
    SUBJECT_MEMORY,
    SUBJECT_PARTS,
    SUBJECT_PARTS_LARGE,
    SUBJECT_PAGED,
    SUBJECT_MOVING,
    SUBJECT_MOVING_LIGHT,
    SUBJECT_THESIS_2020,
    SUBJECT_THESIS_2016,
    SUBJECT_PEER_EMBREE,
    SUBJECT_PEER_OPENVDB,
    SUBJECT_E1,
    SUBJECT_E2,
    SUBJECT_E3,
    SUBJECT_E4,
    SUBJECT_E5,
    SUBJECT_E7,
    SUBJECT_E8,
    SUBJECT_COUNT
} subject_id;

typedef struct subject_words {
    const char *name;
    const char *group; /* a name that asks for all subjects of the group */
    const char *summary; /* one line, without a full stop */
} subject_words;

/* What is no subject of any group: measurements in processes of their own. */
#define BENCH_GPU_NAME "gpu"
#define BENCH_GPU_SUMMARY \
    "devices, exactness, hashes, builds, light and rays of this machine, each in a process of its own"
#define BENCH_VERSUS_NAME "gl-vs-cl"
#define BENCH_VERSUS_SUMMARY \
    "what building by OpenGL costs beside OpenCL: a factorial design, several processes, one clock"

/* By subject_id. */
extern const subject_words subject_table[SUBJECT_COUNT];

#endif
