/* SPDX-License-Identifier: MIT */
/* Fills a template with the style sheet and the scripts of the report's page. */
#include "measure/results_page.h"

#include "measure/result_json.h"
#include "support/page_template.h"

#define DATA_OPEN "<script id=\"data\" type=\"application/json\">"

extern const char page_style[], page_script_text[], page_script_charts[], page_script_page[];

/* JSON text by malloc; NULL when out of memory. */
static char *print_data(const result_set *results, cJSON *data)
{
    cJSON *tables = result_to_json(results);
    const bool added = tables != NULL && cJSON_AddItemToObject(data, "results", tables) &&
                       cJSON_AddArrayToObject(data, "pictures") != NULL;
    char *text = added ? cJSON_PrintUnformatted(data) : NULL;
    cJSON_Delete(data);
    return text;
}

int results_page_write(program *state, const char *page_template, const char *content_name, const char *content,
                       const result_set *results, cJSON *data, FILE *page)
{
    char content_reference[96];
    char *text = print_data(results, data);
    snprintf(content_reference, sizeof content_reference, "<script src=\"%s\"></script>", content_name);
    const page_part parts[] = {
        {"<link rel=\"stylesheet\" href=\"../report/page.css\">", "<style>", page_style, "</style>", false},
        {DATA_OPEN "null</script>", DATA_OPEN, text, "</script>", true},
        {"<script src=\"../report/text.js\"></script>", "<script>", page_script_text, "</script>", false},
        {content_reference, "<script>", content, "</script>", false},
        {"<script src=\"../report/charts.js\"></script>", "<script>", page_script_charts, "</script>", false},
        {"<script src=\"../report/page.js\"></script>", "<script>", page_script_page, "</script>", false},
    };
    if (text == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the page");
    }
    const int exit_code = page_template_write(state, page_template, parts, sizeof parts / sizeof parts[0], page);
    cJSON_free(text);
    return exit_code;
}
