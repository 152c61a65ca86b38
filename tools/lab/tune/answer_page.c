/* SPDX-License-Identifier: MIT */
/* Fills tune.html with the answer and the tables. */
#include "tune/answer_page.h"

#include "measure/results_page.h"
#include "tune/answer.h"

extern const char tune_template[], tune_script_content[];

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
        cJSON_AddStringToObject(facts, "note", tune_setting_rest(&all->settings[all->verdict.winner].setting));
        cJSON_AddNumberToObject(facts, "sure", all->verdict.sure);
        cJSON_AddNumberToObject(facts, "near", all->verdict.near);
    }
    if (all->verdict.second < all->count) {
        tune_setting_command(all->state, &all->settings[all->verdict.second].setting, &text);
        cJSON_AddStringToObject(facts, "second", text.text);
        answer_varied(all, all->verdict.second, &text);
        cJSON_AddStringToObject(facts, "varied", text.text);
    }
    return facts;
}

int answer_page(const sweep *all, const result_set *tables, FILE *page)
{
    cJSON *data = cJSON_CreateObject();
    cJSON_AddItemToObject(data, "answer", verdict_to_facts(all));
    cJSON_AddStringToObject(data, "input", all->state->options.input);
    cJSON_AddStringToObject(data, "origin", all->exhaustive ? "exhaustive" : "halving");
    return results_page_write(all->state, tune_template, "content.js", tune_script_content, tables, data, page);
}
