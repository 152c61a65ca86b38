/* SPDX-License-Identifier: MIT */
/* Paged trees for tests: a scene's file, its whole tree beside it, and a camera that flies by. */
#ifndef SVO_TESTS_PAGED_WALK_H
#define SVO_TESTS_PAGED_WALK_H

#include "support/fixture.h"
#include "svocl/paged.h"

#define PAGED_WIDTH  96u
#define PAGED_HEIGHT 72u
#define PAGED_BYTES  ((size_t)PAGED_WIDTH * PAGED_HEIGHT * 4)

/* The file is path_of(name) in the folder of work_folder.h. */
typedef struct paged_scene {
    fixture opened;
    built whole;
    const char *name;
    uint8_t *expected, *drawn; /* of PAGED_BYTES */
} paged_scene;

/* Builds "scene:..." at a depth and saves it. need: 0 for all that pictures show. */
void paged_scene_make(void **state, const char *spec, unsigned depth, uint32_t need, paged_scene *out);
void paged_scene_destroy(paged_scene *of);
/* Builds the parts of the same tree, with all that pictures show, in the folder path_of("parts"). */
void paged_scene_make_parts(const paged_scene *of, const char *spec, unsigned depth);

/* Opens the file; fails the test with the library's words. page_levels: 0 for the default. */
svo_paged *paged_scene_open(const paged_scene *of, uint64_t budget_bytes, uint32_t page_levels);
/* A budget with which no page has to go. */
uint64_t paged_scene_whole_bytes(const paged_scene *of, uint32_t page_levels);

svo_paged_info paged_info(const svo_paged *paged);
svo_paged_counts paged_counts(const svo_paged *paged);

/* View k of a flight from afar to near, which turns half around the scene. */
svo_render_options paged_view(const paged_scene *of, svo_render_view view, unsigned k, unsigned count);

/* Draws into drawn, and updates; fail the test with the library's words. */
void paged_draw(const paged_scene *of, svo_paged *paged, const svo_render_options *options);
void paged_update(const paged_scene *of, svo_paged *paged);
/* Draws the whole tree, or another one, into expected. */
void paged_draw_tree(const paged_scene *of, svo_tree *tree, const svo_render_options *options);
/* Draws and updates until a picture misses nothing. Returns the number of pictures. */
unsigned paged_complete(const paged_scene *of, svo_paged *paged, const svo_render_options *options);

#endif
