/* SPDX-License-Identifier: MIT */
/* Rays and points from CSV files or a camera, and hits into a CSV file. */
#ifndef SVOCL_TOOLS_SUPPORT_QUERY_TABLE_H
#define SVOCL_TOOLS_SUPPORT_QUERY_TABLE_H

#include <stddef.h>

#include "support/output.h"
#include "support/program.h"
#include "svocl/light_types.h"
#include "svocl/svocl.h"

/* ---- rays and hits ---- */

typedef struct ray_table {
    svo_ray *rays; /* by malloc */
    size_t count;
} ray_table;

/* Lines ox,oy,oz,dx,dy,dz. A first line that does not begin with a number is a heading; empty lines are skipped. Any
   other line is an error that names it. Returns the exit code. */
int ray_table_read(program *state, const char *path, ray_table *out);

/* Unit vectors at right angles. NaN for a camera without a line of sight; rays from them hit nothing. */
typedef struct camera_axes {
    double forward[3], right[3], up[3];
} camera_axes;
camera_axes ray_table_axes(const svo_camera *camera);

/* One ray through each pixel, row by row from the upper left corner. place: where in the pixel, 0 .. 1; NULL: the
   center. Returns the exit code. */
int ray_table_from_camera(program *state, const svo_camera *camera, uint32_t width, uint32_t height,
                          const double place[2], ray_table *out);

/* "auto", or EX,EY,EZ,TX,TY,TZ[,UX,UY,UZ[,DEGREES]]: eye, target, up (0,1,0), vertical field of view (32). framed:
   the camera for "auto". Returns false if the text is neither. */
bool ray_table_parse_camera(const char *text, const svo_camera *framed, svo_camera *out);

void ray_table_free(ray_table *list);

/* ray,t,triangle,u,v with a heading; a miss has triangle -1 and t inf. */
void ray_table_write_hits(output_file *file, const svo_hit *hits, size_t count);

/* ray,t,level,face with a heading: 2 * axis of the face, plus 1 for its high side, or 6 inside the voxel; a miss has -1
   for both and t inf. */
void ray_table_write_voxel_hits(output_file *file, const svo_voxel_hit *hits, size_t count);

/* ---- points ---- */

typedef struct point_table {
    svo_gather_point *points; /* by malloc */
    size_t count; /* at least 1 */
} point_table;

/* Lines x,y,z,nx,ny,nz; see number_table_read. Returns the exit code. */
int point_table_read(program *state, const char *path, point_table *out);
void point_table_free(point_table *list);

#endif
