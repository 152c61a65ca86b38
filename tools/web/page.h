/* SPDX-License-Identifier: MIT */
/* The page of svocl export-web. */
#ifndef SVOCL_TOOLS_WEB_PAGE_H
#define SVOCL_TOOLS_WEB_PAGE_H

#include <stdio.h>

#include "support/program.h"
#include "web/pack.h"
#include "web/sky.h"

/* Where a page begins, as far as it is known: else it frames the tree in its window. */
typedef struct web_start {
    svo_camera camera;
    bool has_place; /* eye and target of the camera are known; else only what is up */
    bool has_fov; /* so is its angle of view; else it is that of framed pictures */
    int view; /* WEB_VIEW_* */
} web_start;

/* Values of the page's buttons. */
enum web_view {
    WEB_VIEW_SHADED,
    WEB_VIEW_NORMAL,
    WEB_VIEW_DEPTH,
    WEB_VIEW_STEPS,
    WEB_VIEW_LEVEL,
    WEB_VIEW_OCCLUSION,
    WEB_VIEW_FULL
};

/* What shines besides the baked light. */
typedef struct web_shine {
    const svo_light_source *sources; /* at most WEB_SOURCES_MAX */
    size_t source_count;
    float sky[3]; /* of all directions, on top of the map's */
    web_sky sky_map;
    double exposure;
} web_shine;

#define WEB_SOURCES_MAX 16u

typedef struct web_page {
    const char *name; /* of the tree, a heading */
    const web_tree *tree;
    uint32_t low[3], high[3]; /* what web_tree_bounds says */
    web_cut cut;
    web_packed packed; /* what web_pack makes of the cut */
    web_start start;
    web_shine shine; /* for a tree with light */
} web_page;

/* The bytes of the page. Returns the exit code. */
int web_page_measure(program *state, const web_page *page, size_t *byte_count);

/* Returns the exit code. */
int web_page_write(program *state, const web_page *page, FILE *out);

#endif
