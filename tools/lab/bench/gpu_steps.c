/* SPDX-License-Identifier: MIT */
#include "bench/gpu_steps.h"

#include <math.h>
#include <string.h>

#include "support/input.h"

/* No step takes that long on a machine that works. Where several hang, the last are not run. */
#define STEP_SECONDS 90u
#define ALL_SECONDS  570u
#define NEEDS        "color,normal,rays"

static const char pairs_note[] = "What works with each OpenCL device and OpenGL renderer, and why the rest does not.";
static const char steps_note[] =
    "Each row is a process of its own. Verdict: ok; wrong, a result that differs from the exact reference or from the "
    "known hash; absent, what device and renderer do not offer, or have no room for; failed. Builds have colors, "
    "normals and leaf lists, with `--quick` by uniform weights. Times are medians of the builds after the first; "
    "build: grid, voxelize, transfer and list to tree. Launches, uploads and waits are calls of OpenCL in one build "
    "with its plan. Rate: million rays per second.";

void gpu_add_tables(gpu_run *run)
{
    static const char *const of_pairs[] = {"device", "renderer", "context", "kind", "name", "works", "reason"};
    static const char *const texts[] = {"step", "input", "method", "verdict"};
    static const char *const times[] = {"compile", "voxelize", "list to tree", "build"};
    static const char *const counts[] = {"launches", "uploads", "waits"};
    run->pairs = result_add_table(run->results, "gpu-pairs", "Devices and renderers", pairs_note);
    for (size_t i = 0; i < sizeof of_pairs / sizeof of_pairs[0]; ++i) {
        result_add_column(run->pairs, of_pairs[i], "");
    }
    run->steps = result_add_table(run->results, "gpu", "A machine in one table", steps_note);
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        result_add_column(run->steps, texts[i], "");
    }
    for (size_t i = 0; i < sizeof times / sizeof times[0]; ++i) {
        result_add_column(run->steps, times[i], "ms");
    }
    result_add_column(run->steps, "rate", "M/s");
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        result_add_column(run->steps, counts[i], "");
    }
    result_add_column(run->steps, "process", "ms");
    result_add_column(run->steps, "reason", "");
}

/* ---- rows ---- */

/* A row before it is added. Numbers that are not finite are absent. */
typedef struct step_row {
    const char *step, *method;
    const gpu_input *source; /* NULL: none */
    const char *kind; /* of rays, or of what is made; NULL: none */
    bool is_absent; /* the machine does not offer the method */
    double compile_ms, voxelize_ms, tree_ms, build_ms, rate, launches, uploads, waits;
} step_row;

static step_row row_of(const char *step, const gpu_input *source, const char *method)
{
    const double none = (double)NAN;
    return (step_row){.step = step,
                      .method = method,
                      .source = source,
                      .compile_ms = none,
                      .voxelize_ms = none,
                      .tree_ms = none,
                      .build_ms = none,
                      .rate = none,
                      .launches = none,
                      .uploads = none,
                      .waits = none};
}

/* Keeps the first row that is wrong or failed. */
static void count_verdict(gpu_run *run, const step_row *row, const char *wrong, const child_answer *answer)
{
    bench_gpu_verdicts *verdicts = run->verdicts;
    const bool failed = wrong == NULL && !answer->well && !row->is_absent;
    if ((wrong != NULL || failed) && verdicts->wrong_count + verdicts->failed_count == 0) {
        snprintf(verdicts->first.text, sizeof verdicts->first.text, "%s %s%s%s: %.900s", row->step,
                 row->source != NULL ? row->source->scene : "", row->method[0] != '\0' ? ", " : "", row->method,
                 wrong != NULL ? wrong : answer->reason);
    }
    verdicts->wrong_count += wrong != NULL;
    verdicts->failed_count += failed;
}

/* wrong: why the result is, or NULL. */
static void add_row(gpu_run *run, const step_row *row, const child_answer *answer, const char *wrong)
{
    const double numbers[] = {row->compile_ms, row->voxelize_ms, row->tree_ms, row->build_ms,
                              row->rate,       row->launches,    row->uploads, row->waits};
    result_add_text(run->steps, "%s", row->step);
    if (row->source == NULL) {
        result_add_text(run->steps, "%s", "");
    } else {
        result_add_text(run->steps, "%s at depth %s%s%s", row->source->scene + strlen("scene:"), row->source->depth,
                        row->kind != NULL ? ", " : "", row->kind != NULL ? row->kind : "");
    }
    result_add_text(run->steps, "%s", row->method);
    result_add_text(run->steps, "%s",
                    wrong != NULL    ? "wrong"
                    : answer->well   ? "ok"
                    : row->is_absent ? "absent"
                                     : "failed");
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i) {
        result_add_number(run->steps, numbers[i]);
    }
    result_add_number(run->steps, answer->ms);
    result_add_text(run->steps, "%s", wrong != NULL ? wrong : answer->reason);
    count_verdict(run, row, wrong, answer);
}

/* ---- children ---- */

static const char *text_of(const cJSON *object, const char *name)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, name));
    return text != NULL ? text : "";
}

static double number_of(const cJSON *object, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, name);
    return cJSON_IsNumber(item) ? item->valuedouble : (double)NAN;
}

static const cJSON *array_of(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItemCaseSensitive(object, name);
}

static void run_child(const gpu_run *run, const child_arguments *arguments, child_answer *answer)
{
    const double left = ALL_SECONDS - (input_now_ms() - run->start_ms) / 1000.0;
    if (left < 1.0) {
        *answer = (child_answer){.reason = "not run: the steps before took too long"};
        return;
    }
    child_ask(arguments, NULL, left < STEP_SECONDS ? (unsigned)left : STEP_SECONDS, answer);
}

/* first: the words of the command before --json; ends with NULL. */
static void ask(const gpu_run *run, const char *const first[], const gpu_input *source, const gpu_method *method,
                child_answer *answer)
{
    child_arguments arguments = {.count = 0};
    for (size_t i = 0; first[i] != NULL; ++i) {
        child_add(&arguments, first[i]);
    }
    if (source != NULL) {
        child_add(&arguments, source->scene);
        child_add(&arguments, "-d");
        child_add(&arguments, source->depth);
    }
    for (size_t i = 0; method != NULL && method->options[i] != NULL; ++i) {
        child_add(&arguments, method->options[i]);
    }
    child_add(&arguments, "--json");
    child_add_device(&arguments, &run->state->options, method != NULL && method->in_gl);
    run_child(run, &arguments, answer);
}

/* ---- devices ---- */

/* list: ends with NULL. */
static bool is_among(const char *name, const char *const list[])
{
    size_t i = 0;
    while (list[i] != NULL && strcmp(list[i], name) != 0) {
        ++i;
    }
    return list[i] != NULL;
}

static void add_methods(gpu_run *run, const cJSON *pair, const char *list, const char *kind)
{
    const cJSON *method = NULL;
    cJSON_ArrayForEach(method, array_of(pair, list))
    {
        result_add_text(run->pairs, "%s", text_of(pair, "device"));
        result_add_text(run->pairs, "%s", text_of(pair, "renderer"));
        result_add_text(run->pairs, "%s %.0f", text_of(pair, "context"), number_of(pair, "device_index"));
        result_add_text(run->pairs, "%s", kind);
        result_add_text(run->pairs, "%s", text_of(method, "name"));
        result_add_text(run->pairs, "%s", text_of(method, "reason")[0] == '\0' ? "yes" : "no");
        result_add_text(run->pairs, "%s", text_of(method, "reason"));
    }
}

/* The driver and the version of the device that builds ran on. */
static void keep_driver(const cJSON *devices, result_set *results)
{
    result_machine *machine = &results->machine;
    const cJSON *platform = NULL;
    const cJSON *device = NULL;
    cJSON_ArrayForEach(platform, array_of(devices, "platforms"))
    {
        cJSON_ArrayForEach(device, array_of(platform, "devices"))
        {
            const char *name = text_of(device, "name");
            const size_t length = strlen(machine->device);
            if (length >= strlen(name) && strcmp(machine->device + length - strlen(name), name) == 0) {
                result_set_fact(results, &machine->driver, text_of(device, "driver"));
                result_set_fact(results, &machine->platform, text_of(device, "version"));
            }
        }
    }
}

/* Names the device and the renderer that the options choose, by a small build. */
static void keep_machine(gpu_run *run, const cJSON *devices)
{
    static const gpu_input smallest = {.scene = "scene:cube", .depth = "2"};
    static const char *const words[] = {"build", NULL};
    result_machine *machine = &run->results->machine;
    child_answer answer;
    ask(run, words, &smallest, NULL, &answer);
    result_set_fact(run->results, &machine->device, text_of(answer.document, "device"));
    cJSON_Delete(answer.document);
    const cJSON *pair = NULL;
    result_set_fact(run->results, &machine->renderer, "none");
    cJSON_ArrayForEach(pair, array_of(devices, "pairs"))
    {
        if (strcmp(machine->renderer, "none") == 0 && strcmp(text_of(pair, "device"), machine->device) == 0) {
            result_set_fact(run->results, &machine->renderer, text_of(pair, "renderer"));
        }
    }
    keep_driver(devices, run->results);
}

void gpu_step_devices(gpu_run *run)
{
    child_arguments arguments = {.count = 0};
    child_answer answer;
    child_add(&arguments, "devices");
    child_add(&arguments, "--json");
    if (run->state->options.path != SVO_PATH_AUTO) { /* what may be shared depends on it */
        child_add(&arguments, "--path");
        child_add(&arguments, svo_name(SVO_NAME_PATH, (svo_path)run->state->options.path));
    }
    run_child(run, &arguments, &answer);
    const cJSON *pair = NULL;
    cJSON_ArrayForEach(pair, array_of(answer.document, "pairs"))
    {
        add_methods(run, pair, "frontends", "front end");
        add_methods(run, pair, "shares", "share");
        add_methods(run, pair, "builders", "builder");
    }
    keep_machine(run, answer.document);
    const step_row row = row_of("devices", NULL, "");
    add_row(run, &row, &answer, NULL);
    run->devices = answer.document;
}

/* Whether no pair with the device of the builds offers what a method names: a front end, a share path, a builder. */
static bool is_absent(const gpu_run *run, const gpu_method *method)
{
    static const char *const lists[] = {"frontends", "shares", "builders"};
    const char *device = run->results->machine.device;
    const cJSON *pair = NULL;
    bool offers = !method->in_gl || run->devices == NULL || device[0] == '\0';
    cJSON_ArrayForEach(pair, array_of(run->devices, "pairs"))
    {
        bool lacks = strcmp(text_of(pair, "device"), device) != 0;
        for (size_t i = 0; i < sizeof lists / sizeof lists[0]; ++i) {
            const cJSON *one = NULL;
            cJSON_ArrayForEach(one, array_of(pair, lists[i]))
            {
                lacks = lacks || (is_among(text_of(one, "name"), method->options) && text_of(one, "reason")[0] != '\0');
            }
        }
        offers = offers || !lacks;
    }
    return !offers;
}

/* ---- checks ---- */

void gpu_step_stress(gpu_run *run, const char *count)
{
    const char *const words[] = {"stress", "--count", count, NULL};
    child_answer answer;
    char wrong[SVO_MESSAGE_BYTES];
    size_t failed = 0;
    ask(run, words, NULL, NULL, &answer);
    const cJSON *one = NULL;
    cJSON_ArrayForEach(one, array_of(answer.document, "cases"))
    {
        const bool is_wrong = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(one, "judged")) &&
                              !cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(one, "passed"));
        if (is_wrong && failed++ == 0) {
            snprintf(wrong, sizeof wrong, "%s: %s", text_of(one, "name"), text_of(one, "reason"));
        }
    }
    const step_row row = row_of("stress", NULL, text_of(answer.document, "frontend"));
    add_row(run, &row, &answer, failed > 0 ? wrong : NULL);
    cJSON_Delete(answer.document);
}

void gpu_step_verify(gpu_run *run, const gpu_input *source, const gpu_method *method)
{
    static const char *const words[] = {"verify", NULL};
    child_answer answer;
    ask(run, words, source, method, &answer);
    const cJSON *exact = cJSON_GetObjectItemCaseSensitive(answer.document, "exact");
    step_row row = row_of("verify", source, method->name);
    row.is_absent = is_absent(run, method);
    add_row(run, &row, &answer, cJSON_IsFalse(exact) ? "not exact" : NULL);
    cJSON_Delete(answer.document);
}

void gpu_step_forms(gpu_run *run, const gpu_input *source)
{
    static const char *const words[] = {"verify", "--form", "all", NULL};
    child_answer answer;
    const char *wrong = NULL;
    ask(run, words, source, NULL, &answer);
    const cJSON *form = NULL;
    cJSON_ArrayForEach(form, array_of(answer.document, "forms"))
    {
        const bool same = cJSON_IsTrue(array_of(form, "same_nodes")) && cJSON_IsTrue(array_of(form, "same_payload"));
        wrong = same ? wrong : "a form is another tree";
    }
    step_row row = row_of("compact", source, "");
    row.kind = "all forms";
    add_row(run, &row, &answer, wrong);
    cJSON_Delete(answer.document);
}

/* ---- times ---- */

/* The sum of some stages. */
static double sum_stages(const cJSON *document, const char *const names[], size_t count)
{
    double sum = 0.0;
    const cJSON *stage = NULL;
    cJSON_ArrayForEach(stage, array_of(document, "stages"))
    {
        for (size_t i = 0; i < count; ++i) {
            sum += strcmp(text_of(stage, "name"), names[i]) == 0 ? number_of(stage, "ms") : 0.0;
        }
    }
    return document != NULL ? sum : (double)NAN;
}

/* Why the hash is wrong; NULL where it is right, or where there is none. */
static const char *compare_hash(const gpu_input *source, const cJSON *document, char *words, size_t words_bytes)
{
    const char *hash = text_of(document, "hash");
    if (hash[0] == '\0' || source->hash == NULL || strcmp(hash, source->hash) == 0) {
        return NULL;
    }
    snprintf(words, words_bytes, "the hash is %s, not %s", hash, source->hash);
    return words;
}

void gpu_step_build(gpu_run *run, const gpu_input *source, const gpu_method *method, const char *repeats)
{
    static const char *const stages[] = {"voxelize", "subdivide", "link", "pack", "filter", "grid", "transfer"};
    const char *const words[] = {"build", "--need", NEEDS, "--weights", source->weights, "--repeat", repeats, NULL};
    char wrong[128];
    child_answer answer;
    ask(run, words, source, method, &answer);
    step_row row = row_of("build", source, method->name);
    row.is_absent = is_absent(run, method) || strstr(answer.reason, "above the storage block limit") != NULL;
    row.compile_ms = number_of(answer.document, "first_compile_ms");
    row.voxelize_ms = sum_stages(answer.document, stages, 1);
    row.tree_ms = sum_stages(answer.document, stages + 1, 4);
    row.build_ms = sum_stages(answer.document, stages, sizeof stages / sizeof stages[0]);
    row.launches = number_of(answer.document, "launches");
    row.uploads = number_of(answer.document, "uploads");
    row.waits = number_of(answer.document, "waits");
    add_row(run, &row, &answer, compare_hash(source, answer.document, wrong, sizeof wrong));
    cJSON_Delete(answer.document);
}

void gpu_step_product(gpu_run *run, const gpu_product *product)
{
    const char *words[16] = {"hash"};
    char wrong[128];
    child_answer answer;
    memcpy(words + 1, product->options, sizeof product->options);
    ask(run, words, &product->source, NULL, &answer);
    step_row row = row_of(product->step, &product->source, "");
    row.kind = product->kind;
    add_row(run, &row, &answer, compare_hash(&product->source, answer.document, wrong, sizeof wrong));
    cJSON_Delete(answer.document);
}

void gpu_step_subject(gpu_run *run, const char *name)
{
    const char *const words[] = {"bench", name, "--quick", NULL};
    child_answer answer;
    ask(run, words, NULL, NULL, &answer);
    const step_row row = row_of(name, NULL, "");
    add_row(run, &row, &answer, NULL);
    cJSON_Delete(answer.document);
}

void gpu_step_rays(gpu_run *run, const gpu_input *source)
{
    const bool quick = run->state->options.quick != 0;
    const char *const words[] = {"bench", "rays", "--ray-count", quick ? "10000" : "1000000", NULL};
    child_answer answer;
    ask(run, words, source, NULL, &answer);
    const cJSON *sets = array_of(answer.document, "sets");
    const cJSON *set = NULL;
    step_row row = row_of("rays", source, "");
    cJSON_ArrayForEach(set, sets)
    {
        row.kind = text_of(set, "name");
        row.rate = number_of(set, "ours_mrays");
        add_row(run, &row, &answer, NULL);
    }
    if (cJSON_GetArraySize(sets) == 0) {
        add_row(run, &row, &answer, NULL);
    }
    cJSON_Delete(answer.document);
}
