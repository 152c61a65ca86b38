/* SPDX-License-Identifier: MIT */
/*
 * A .vox file in memory: its models, its palette, and the nodes of its scene
 * (https://github.com/ephtracy/voxel-model, MagicaVoxel-file-format-vox.txt and -extension.txt).
 */
#ifndef SVO_LIB_IO_VOXELS_VOX_FILE_H
#define SVO_LIB_IO_VOXELS_VOX_FILE_H

#include "io/voxels_files.h"

#define VOX_SIDE_MAX   256 /* voxels along an axis of a model */
#define VOX_DEPTH_MAX  1024 /* nodes from the root of the scene on */
#define VOX_NODE_BYTES 4 /* of an id in a group's list of children */

/* A model: SIZE and XYZI. */
typedef struct vox_model {
    int32_t size[3];
    const uint8_t *voxels; /* count times x, y, z, index of the palette; 0 is empty */
    uint32_t count;
    uint32_t filled; /* of those, not empty */
    bool is_placed; /* by an instance that is read */
} vox_model;

/* p goes to R p + T. Row i of R has sign[i] in column[i] and is 0 elsewhere. */
typedef struct vox_transform {
    uint8_t column[3];
    int8_t sign[3];
    int64_t translation[3];
} vox_transform;

typedef enum vox_node_kind { VOX_NODE_TRANSFORM, VOX_NODE_GROUP, VOX_NODE_SHAPE } vox_node_kind;

/* A node of the scene, as it is in the asked frame. */
typedef struct vox_node {
    vox_node_kind kind;
    int32_t id;
    size_t offset; /* of its chunk in the file */
    bool hidden; /* the node itself */
    bool on_path; /* of the walk that is running */
    int32_t layer; /* of a transform; -1: none */
    int32_t child; /* of a transform: a node's id; of a shape: the index of a model */
    vox_transform transform;
    const uint8_t *children; /* of a group: ids, 4 bytes each */
    uint32_t child_count;
} vox_node;

typedef struct vox_layer {
    int32_t id;
    size_t offset; /* of its chunk in the file */
    bool hidden;
} vox_layer;

/* Lists are owned. */
typedef struct vox_file {
    voxel_reader *reader;
    vox_model *models;
    size_t model_count, model_capacity;
    bool has_size; /* a SIZE is waiting for its XYZI */
    int32_t size[3];
    int64_t packed; /* models by PACK; -1: no such chunk */
    uint8_t palette[256][4]; /* by the index of a voxel */
    bool has_palette; /* of its own */
    bool is_used[256]; /* entries of the palette that a voxel of some model has */
    vox_node *nodes; /* by id, when all are read */
    size_t node_count, node_capacity;
    vox_layer *layers; /* by id and offset, when all are read */
    size_t layer_count, layer_capacity;
} vox_file;

/* A part of a chunk that is being read. */
typedef struct vox_cursor {
    const voxel_reader *reader;
    char id[5]; /* printable */
    size_t offset; /* of the chunk in the file */
    const uint8_t *at, *end;
} vox_cursor;

/* Reads all of a file. file: with its reader, packed -1 and the rest 0; the caller frees the lists, after a failure
   too. */
svo_status svo_i_vox_read_file(vox_file *file);

#endif
