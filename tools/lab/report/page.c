/* SPDX-License-Identifier: MIT */
/*
 * Fills the template of the page, page.html, which opens in a browser as it is too. The scripts make tables and charts
 * from a block of JSON:
 *
 *   {"results": what results.json holds, "origin": "full",
 *    "pictures": [{"name": "atrium", "caption": "...", "width": 1120, "height": 700, "source": "data:image/png;..."}]}
 */
#include "report/page.h"

#include <stdlib.h>

#include "measure/result_json.h"
#include "support/page_template.h"

#define DATA_OPEN "<script id=\"data\" type=\"application/json\">"

extern const char page_template[], page_style[], page_script_text[], page_script_content[], page_script_charts[],
    page_script_page[];

/* ---- the data ---- */

/* "data:image/png;base64,..." */
static cJSON *make_source(const picture *one)
{
    char *text = NULL;
    size_t text_bytes = 0;
    FILE *stream = open_memstream(&text, &text_bytes);
    if (stream == NULL) {
        return NULL;
    }
    fputs("data:image/png;base64,", stream);
    page_template_base64(one->png, one->png_bytes, stream);
    cJSON *source = fclose(stream) == 0 ? cJSON_CreateString(text) : NULL;
    free(text);
    return source;
}

static bool add_picture(cJSON *list, const picture *one)
{
    cJSON *object = cJSON_CreateObject();
    return cJSON_AddItemToArray(list, object) && cJSON_AddStringToObject(object, "name", one->name) != NULL &&
           cJSON_AddStringToObject(object, "caption", one->caption) != NULL &&
           cJSON_AddNumberToObject(object, "width", one->width) != NULL &&
           cJSON_AddNumberToObject(object, "height", one->height) != NULL &&
           cJSON_AddItemToObject(object, "source", make_source(one));
}

static bool add_content(cJSON *data, const page_content *content)
{
    cJSON *list = cJSON_AddArrayToObject(data, "pictures");
    bool added = list != NULL && cJSON_AddItemToObject(data, "results", result_to_json(content->results)) &&
                 cJSON_AddStringToObject(data, "origin", content->origin) != NULL;
    for (size_t i = 0; i < content->drawn->count && added; ++i) {
        added = add_picture(list, &content->drawn->list[i]);
    }
    return added;
}

/* JSON text by malloc; NULL when out of memory. */
static char *make_data(const page_content *content)
{
    cJSON *data = cJSON_CreateObject();
    char *text = data != NULL && add_content(data, content) ? cJSON_PrintUnformatted(data) : NULL;
    cJSON_Delete(data);
    return text;
}

/* ---- the page ---- */

int page_write(program *state, const page_content *content, FILE *page)
{
    char *data = make_data(content);
    const page_part parts[] = {
        {"<link rel=\"stylesheet\" href=\"page.css\">", "<style>", page_style, "</style>", false},
        {DATA_OPEN "null</script>", DATA_OPEN, data, "</script>", true},
        {"<script src=\"text.js\"></script>", "<script>", page_script_text, "</script>", false},
        {"<script src=\"content.js\"></script>", "<script>", page_script_content, "</script>", false},
        {"<script src=\"charts.js\"></script>", "<script>", page_script_charts, "</script>", false},
        {"<script src=\"page.js\"></script>", "<script>", page_script_page, "</script>", false},
    };
    if (data == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the page");
    }
    const int exit_code = page_template_write(state, page_template, parts, sizeof parts / sizeof parts[0], page);
    free(data);
    return exit_code;
}
