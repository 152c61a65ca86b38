/* SPDX-License-Identifier: MIT */
/* svocl stress: ill-conditioned and extreme inputs on this device and driver, compared with the exact reference and
   with common float32 methods. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "program/commands.h"
#include "stress/cases.h"
#include "stress/stress.h"
#include "support/info_of.h"
#include "support/json.h"
#include "support/table.h"

static size_t count_failed(const stress *run)
{
    size_t failed = 0;
    for (size_t i = 0; i < run->case_count; ++i) {
        failed += run->cases[i].judged && !run->cases[i].passed;
    }
    return failed;
}

static size_t count_judged(const stress *run)
{
    size_t judged = 0;
    for (size_t i = 0; i < run->case_count; ++i) {
        judged += run->cases[i].judged;
    }
    return judged;
}

static void print_case(table *rows, const stress_case *one)
{
    const bool whole = strcmp(one->unit, "standard errors") != 0;
    table_cell(rows, "%s", one->name);
    table_cell(rows, "%s", one->method);
    table_cell(rows, "%s", figure_count(one->false_negatives).text);
    table_cell(rows, "%s", figure_count(one->false_positives).text);
    if (whole) {
        table_cell(rows, "%s", figure_count((uint64_t)one->figure).text);
    } else {
        table_cell(rows, "%.2f", one->figure);
    }
    table_cell(rows, "%s", one->unit);
    table_cell(rows, "%s", figure_ms(one->ms).text);
    table_cell(rows, "%s",
               one->judged   ? (one->passed ? "passed" : "FAILED")
               : one->passed ? "exact here"
                             : "not exact");
}

static void print_cases(const stress *run)
{
    table_heading("Ill-conditioned and extreme inputs on %s, frontend %s, renderer %s, seed %" PRIu64,
                  info_of_device(run->opened.device).name, svo_frontend_name(run->opened.frontend),
                  session_renderer(&run->opened), run->seed);
    table *rows = table_create("llrrrlrl");
    static const char *const titles[] = {"case", "method", "missed", "surplus", "figure", "", "time", "verdict"};
    for (size_t i = 0; i < sizeof titles / sizeof titles[0]; ++i) {
        table_cell(rows, "%s", titles[i]);
    }
    for (size_t i = 0; i < run->case_count; ++i) {
        print_case(rows, &run->cases[i]);
    }
    table_print(rows);
    for (size_t i = 0; i < run->case_count; ++i) {
        if (run->cases[i].reason[0] != '\0') {
            table_line("%s: %s", run->cases[i].name, run->cases[i].reason);
        }
    }
    table_line(
        "float32 methods are listed for comparison and never fail. They run on the host with the sampling rules of");
    table_line("rasterizers. Schwarz-Seidel and box-centered target closed coverage, the others half-open coverage.");
    table_line("%zu of %zu cases passed", count_judged(run) - count_failed(run), count_judged(run));
}

static cJSON *to_json(const stress *run)
{
    cJSON *document = json_document();
    json_add_text(document, "device", info_of_device(run->opened.device).name);
    json_add_text(document, "renderer", session_renderer(&run->opened));
    json_add_text(document, "frontend", svo_frontend_name(run->opened.frontend));
    json_add_text(document, "frontend_reason", run->opened.reason.text);
    json_add_count(document, "seed", run->seed);
    json_add_count(document, "count", run->count);
    cJSON *cases = cJSON_AddArrayToObject(document, "cases");
    for (size_t i = 0; i < run->case_count; ++i) {
        const stress_case *one = &run->cases[i];
        cJSON *object = cJSON_CreateObject();
        json_add_text(object, "name", one->name);
        json_add_text(object, "method", one->method);
        json_add_count(object, "false_negatives", one->false_negatives);
        json_add_count(object, "false_positives", one->false_positives);
        cJSON_AddNumberToObject(object, "figure", one->figure);
        json_add_text(object, "unit", one->unit);
        cJSON_AddNumberToObject(object, "ms", one->ms);
        cJSON_AddBoolToObject(object, "judged", one->judged);
        cJSON_AddBoolToObject(object, "passed", one->passed);
        if (one->reason[0] != '\0') {
            json_add_text(object, "reason", one->reason);
        }
        cJSON_AddItemToArray(cases, object);
    }
    cJSON_AddBoolToObject(document, "passed", count_failed(run) == 0);
    return document;
}

static int report(program *state, const stress *run)
{
    progress_destroy(&state->progress);
    if (run->failed) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    int exit_code = PROGRAM_DONE;
    if (state->options.json) {
        exit_code = json_print(state, to_json(run));
    } else if (!state->options.quiet) {
        print_cases(run);
    }
    const size_t failed = count_failed(run);
    if (exit_code == PROGRAM_DONE && failed > 0) {
        exit_code = program_fail(state, PROGRAM_FAILED, "%zu of %zu cases failed with seed %" PRIu64, failed,
                                 count_judged(run), run->seed);
    }
    return exit_code;
}

int command_stress(program *state)
{
    stress run = {.state = state, .seed = state->options.seed, .count = (size_t)state->options.count};
    int exit_code = session_open(state, &run.opened);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    session_choose_opengl(state, &run.opened);
    program_begin_progress(state, 3);
    progress_step(state->progress, "closed forms, fragment estimate, symmetry");
    stress_cases_forms(&run);
    progress_step(state->progress, "trees against the reference");
    stress_cases_builds(&run);
    progress_step(state->progress, "averages and repeatability");
    stress_cases_payload(&run);
    exit_code = report(state, &run);
    free(run.cases);
    session_close(&run.opened);
    return exit_code;
}
