/* SPDX-License-Identifier: MIT */
/* Whether the compact forms of a tree expand to the tree again: option --form. */
#ifndef SVOCL_TOOLS_SUPPORT_FORM_CHECK_H
#define SVOCL_TOOLS_SUPPORT_FORM_CHECK_H

#include "support/json.h"
#include "support/session.h"

/* One form and what it expands to. */
typedef struct form_check {
    svo_compact_info info;
    char hash[SVO_HASH_TEXT_BYTES]; /* SVO_HASH_NODES */
    bool same_nodes; /* as that of the tree */
    bool same_payload;
} form_check;

typedef struct form_checks {
    form_check forms[SVO_FORM_COUNT];
    size_t count; /* 0: none was asked for */
} form_checks;

/* Makes, expands and compares what --form names. tree: with host arrays. Returns the exit code, its line printed. */
int form_check_run(program *state, const session *opened, const svo_tree *tree, form_checks *out);
/* Whether all of them are the tree again; true for none. */
bool form_check_is_exact(const form_checks *checks);
/* A line for each form; nothing for none. */
void form_check_print(const form_checks *checks);
void form_check_add_json(cJSON *document, const form_checks *checks);

#endif
