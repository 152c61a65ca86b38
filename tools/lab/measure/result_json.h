/* SPDX-License-Identifier: MIT */
/*
 * Sets of tables as JSON:
 *
 *   {"version": "0.1.0",
 *    "machine": {"device": "...", "driver": "...", "platform": "...", "renderer": "...", "cpu_threads": 2,
 *                "svocl": "0.1.0"},
 *    "tables": [{"id": "voxelize", "title": "...", "note": "...",
 *                "columns": [{"name": "scene", "unit": ""}, {"name": "median", "unit": "ms"}],
 *                "rows": [["knot", 1.25], ["cube", null]]}]}
 */
#ifndef SVOCL_TOOLS_MEASURE_RESULT_JSON_H
#define SVOCL_TOOLS_MEASURE_RESULT_JSON_H

#include <cjson/cJSON.h>

#include "measure/result.h"
#include "svocl/status.h"

/* NULL when the set is not whole or memory runs out. */
cJSON *result_to_json(const result_set *set);
/* NULL on failure; the message then says in one line what is wrong with the text. */
result_set *result_parse(const char *text, svo_message *message);

#endif
