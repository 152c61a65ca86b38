/* SPDX-License-Identifier: MIT */
/* Light of a picture by few rays or cones, smoothed over surfaces: kernels/light/screen.cl. */
#ifndef SVO_LIB_LIGHT_SCREEN_H
#define SVO_LIB_LIGHT_SCREEN_H

#include "light/shader.h"

/* Pixels along a cell's edge. */
#define SVO_I_SCREEN_CELL 2u

typedef struct svo_i_light_screen {
    svo_i_light_shader points, gather;
    svo_gather_params asked;
    uint32_t height; /* cell rows of the picture */
    bool mirrors; /* surfaces, in this picture */
    svo_screen_params params; /* of the band */
    cl_mem cells, gathered, guide, light, spare; /* the work's, for the cells of a band */
    cl_mem specular; /* likewise; NULL: the picture mirrors nothing */
    uint32_t band_rows; /* of cells that the buffers hold, without those beside the band */
} svo_i_light_screen;

/* Makes kernels and buffers for bands of a picture of so many pixels; first: its own shader, begun. The last band may
   have fewer rows. mirrors: whether the view shows specular light. */
svo_status svo_i_light_screen_begin(const svo_i_light_shader *first, const svo_gather_params *gather, uint32_t width,
                                    uint32_t height, uint32_t row_count, bool mirrors, svo_i_light_screen *out);
/* Gathers for cell rows first_row .. end_row - 1 of the picture: screen->light has irradiance and openness of the cells
   that screen->params names, screen->specular what their surfaces mirror. picture: camera and view. */
svo_status svo_i_light_screen_band(svo_i_light_screen *screen, const svo_lit_picture_params *picture,
                                   uint32_t first_row, uint32_t end_row);
void svo_i_light_screen_end(svo_i_light_screen *screen);

#endif
