/* SPDX-License-Identifier: MIT */
/*
 * Fills the template of the page. page.html names its style sheet and scripts, so that it opens in a browser as it is;
 * here each reference gives way to the embedded file. The scripts make tables and charts from a block of JSON:
 *
 *   {"results": what results.json holds, "origin": "full",
 *    "pictures": [{"name": "atrium", "caption": "...", "width": 1120, "height": 700, "source": "data:image/png;..."}]}
 */
#include "report/page.h"

#include <stdlib.h>
#include <string.h>

#include "measure/result_json.h"
#include "report/text.h"

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
    text_base64(one->png, one->png_bytes, stream);
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

/* ---- the template ---- */

/* What stands in the template, and what takes its place. */
typedef struct replacement {
    const char *reference, *open, *text, *close;
    bool is_json;
} replacement;

static void write_replacement(const replacement *part, FILE *page)
{
    fputs(part->open, page);
    if (part->is_json) {
        text_write_script_json(part->text, page);
    } else {
        fputs(part->text, page);
    }
    fputs(part->close, page);
}

int page_write(program *state, const page_content *content, FILE *page)
{
    char *data = make_data(content);
    const replacement parts[] = {
        {"<link rel=\"stylesheet\" href=\"page.css\">", "<style>", page_style, "</style>", false},
        {DATA_OPEN "null</script>", DATA_OPEN, data, "</script>", true},
        {"<script src=\"text.js\"></script>", "<script>", page_script_text, "</script>", false},
        {"<script src=\"content.js\"></script>", "<script>", page_script_content, "</script>", false},
        {"<script src=\"charts.js\"></script>", "<script>", page_script_charts, "</script>", false},
        {"<script src=\"page.js\"></script>", "<script>", page_script_page, "</script>", false},
    };
    const char *rest = page_template + strspn(page_template, "\n");
    if (data == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory for the page");
    }
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
        const char *found = strstr(rest, parts[i].reference);
        if (found == NULL) {
            free(data);
            return program_fail(state, PROGRAM_FAILED, "the page's template lacks %s", parts[i].reference);
        }
        fwrite(rest, 1, (size_t)(found - rest), page);
        write_replacement(&parts[i], page);
        rest = found + strlen(parts[i].reference);
    }
    fputs(rest, page);
    free(data);
    return PROGRAM_DONE;
}
