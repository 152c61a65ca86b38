/* SPDX-License-Identifier: MIT */
/*
 * Tables of results in the documents of a source tree, each between two marker lines:
 *
 *   <!-- svocl:table ID -->
 *   <!-- svocl:end -->
 *
 * ID is "machine" or that of an extract (summary.h). What stands between the two is the program's. A line
 *
 *   <!-- svocl:results FILE -->
 *
 * says that the tables below it are of the results in another file, in the document's folder; their IDs may then be
 * those of tables as well, which are written whole.
 */
#ifndef SVOCL_TOOLS_REPORT_DOCS_TABLES_H
#define SVOCL_TOOLS_REPORT_DOCS_TABLES_H

#include "measure/result.h"
#include "support/json.h"

/* Writes the tables of folder/README.md and of every .md file in folder/docs anew. Documents without markers stay as
   they are. So do all of them when a marker is unknown or not closed, or when the results lack a table. written gets
   {file, bytes} of each document that was written. Returns the exit code. */
int docs_tables_write(program *state, const result_set *results, const char *folder, cJSON *written);

#endif
