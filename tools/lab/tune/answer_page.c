/* SPDX-License-Identifier: MIT */
/* Fills tune.html with the style and the scripts of the report's page, and with a content of its own. */
#include "tune/answer_page.h"

#include "measure/result_json.h"
#include "support/page_template.h"
#include "tune/answer.h"

#define DATA_OPEN "<script id=\"data\" type=\"application/json\">"

extern const char tune_template[], tune_script_content[], page_style[], page_script_text[], page_script_charts[],
    page_script_page[];

static cJSON *verdict_to_facts(const sweep *all)
{
    text_list text;
    cJSON *facts = cJSON_CreateObject();
    answer_words(all, &text);
    cJSON_AddStringToObject(facts, "asked", text.text);
    if (all->verdict.winner < all->count) {
        tune_setting_command(all->state, &all->settings[all->verdict.winner].setting, &text);
        cJSON_AddStringToObject(facts, "command", text.text);
        tune_setting_code(&all->settings[all->verdict.winner].setting, &text);
        cJSON_AddStringToObject(facts, "c", text.text);
        cJSON_AddNumberToObject(facts, "sure", all->verdict.sure);
        cJSON_AddNumberToObject(facts, "near", all->verdict.near);
    }
    if (all->verdict.second < all->count) {
        tune_setting_command(all->state, &all->settings[all->verdict.second].setting, &text);
        cJSON_AddStringToObject(facts, "second", text.text);
    }
    return facts;
}

/* JSON text by malloc; NULL when out of memory. */
static char *make_data(const sweep *all, const result_set *tables)
{
    cJSON *data = cJSON_CreateObject();
    cJSON *results = result_to_json(tables);
    const bool added = results != NULL && cJSON_AddItemToObject(data, "results", results) &&
                       cJSON_AddItemToObject(data, "answer", verdict_to_facts(all)) &&
                       cJSON_AddStringToObject(data, "input", all->state->options.input) != NULL &&
                       cJSON_AddStringToObject(data, "origin", all->exhaustive ? "exhaustive" : "halving") != NULL &&
                       cJSON_AddArrayToObject(data, "pictures") != NULL;
    char *text = added ? cJSON_PrintUnformatted(data) : NULL;
    cJSON_Delete(data);
    return text;
}

int answer_page(const sweep *all, const result_set *tables, FILE *page)
{
    char *data = make_data(all, tables);
    const page_part parts[] = {
        {"<link rel=\"stylesheet\" href=\"../report/page.css\">", "<style>", page_style, "</style>", false},
        {DATA_OPEN "null</script>", DATA_OPEN, data, "</script>", true},
        {"<script src=\"../report/text.js\"></script>", "<script>", page_script_text, "</script>", false},
        {"<script src=\"content.js\"></script>", "<script>", tune_script_content, "</script>", false},
        {"<script src=\"../report/charts.js\"></script>", "<script>", page_script_charts, "</script>", false},
        {"<script src=\"../report/page.js\"></script>", "<script>", page_script_page, "</script>", false},
    };
    if (data == NULL) {
        return program_fail(all->state, PROGRAM_FAILED, "out of memory for the page");
    }
    const int exit_code = page_template_write(all->state, tune_template, parts, sizeof parts / sizeof parts[0], page);
    cJSON_free(data);
    return exit_code;
}
