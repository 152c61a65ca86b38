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
    "build: grid, voxelize, transfer and list to tree; wall: the clock's, from the mesh to the tree; gaps: what of it "
    "is "
    "in no stage. Launches, uploads, waits, allocations and blocking reads are calls of OpenCL in the last build with "
    "its plan, and so is the time in the last two. Rate: million rays per second.";
static const char drivers_note[] =
    "The OpenCL devices, and those of their extensions that svocl or its compiler knows.";
static const char kernels_note[] =
    "The kernels of these builds, light and probes, once for each way in which they were compiled: local memory of a "
    "group, private memory of a work-item and registers as far as the driver tells (NVIDIA's, when it compiles), and "
    "the number of which groups should be a multiple.";

static void add_columns(result_table *table, const char *const names[], size_t count, const char *unit)
{
    for (size_t i = 0; i < count; ++i) {
        result_add_column(table, names[i], unit);
    }
}

#define COLUMNS(names) (names), sizeof(names) / sizeof((names)[0])

void gpu_add_tables(gpu_run *run)
{
    static const char *const of_drivers[] = {"device", "type", "driver", "extensions"};
    static const char *const of_pairs[] = {"device", "renderer", "context", "kind", "name", "works", "reason"};
    static const char *const texts[] = {"step", "input", "method", "verdict"};
    static const char *const times[] = {"compile", "voxelize", "list to tree", "build", "wall", "gaps"};
    static const char *const counts[] = {"launches", "uploads", "waits", "allocations", "reads"};
    static const char *const in_calls[] = {"allocating", "reading", "process"};
    static const char *const of_kernels[] = {"multiple", "registers"};
    static const char *const memories[] = {"local", "private"};
    run->drivers = result_add_table(run->results, "gpu-devices", "Devices", drivers_note);
    add_columns(run->drivers, COLUMNS(of_drivers), "");
    result_add_column(run->drivers, "compute units", "");
    result_add_column(run->drivers, "memory", "B");
    run->pairs = result_add_table(run->results, "gpu-pairs", "Devices and renderers", pairs_note);
    add_columns(run->pairs, COLUMNS(of_pairs), "");
    run->steps = result_add_table(run->results, "gpu", "A machine in one table", steps_note);
    add_columns(run->steps, COLUMNS(texts), "");
    add_columns(run->steps, COLUMNS(times), "ms");
    result_add_column(run->steps, "rate", "M/s");
    add_columns(run->steps, COLUMNS(counts), "");
    add_columns(run->steps, COLUMNS(in_calls), "ms");
    result_add_column(run->steps, "reason", "");
    run->kernels = result_add_table(run->results, "gpu-kernels", "Kernels", kernels_note);
    result_add_column(run->kernels, "kernel", "");
    add_columns(run->kernels, COLUMNS(memories), "B");
    add_columns(run->kernels, COLUMNS(of_kernels), "");
}

/* ---- rows ---- */

/* The numbers of a row, in the order of their columns. */
enum {
    COMPILE_MS,
    VOXELIZE_MS,
    TREE_MS,
    BUILD_MS,
    WALL_MS,
    GAPS_MS,
    RATE,
    LAUNCHES,
    UPLOADS,
    WAITS,
    ALLOCATIONS,
    READS,
    ALLOCATING_MS,
    READING_MS,
    NUMBER_COUNT
};

/* A row before it is added. Numbers that are not finite are absent. */
typedef struct step_row {
    const char *step, *method;
    const gpu_input *source; /* NULL: none */
    const char *kind; /* of rays, or of what is made; NULL: none */
    bool is_absent; /* the machine does not offer the method */
    double numbers[NUMBER_COUNT];
} step_row;

static step_row row_of(const char *step, const gpu_input *source, const char *method)
{
    step_row row = {.step = step, .method = method, .source = source};
    for (size_t i = 0; i < NUMBER_COUNT; ++i) {
        row.numbers[i] = (double)NAN;
    }
    return row;
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
    for (size_t i = 0; i < NUMBER_COUNT; ++i) {
        result_add_number(run->steps, row->numbers[i]);
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

/* Those of all extensions that matter here. */
static void join_extensions(const char *all, char *words, size_t words_bytes)
{
    static const char *const known[] = {"cl_khr_fp64",
                                        "cl_khr_gl_sharing",
                                        "cl_khr_gl_event",
                                        "cl_khr_subgroups",
                                        "cl_khr_int64_base_atomics",
                                        "cl_intel_subgroups",
                                        "cl_nv_compiler_options",
                                        "cl_nv_device_attribute_query",
                                        "cl_amd_device_attribute_query"};
    size_t used = 0;
    words[0] = '\0';
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        const size_t length = strlen(known[i]);
        const char *at = strstr(all, known[i]);
        while (at != NULL && at[length] != ' ' && at[length] != '\0') {
            at = strstr(at + length, known[i]);
        }
        if (at != NULL && used + length + 2 < words_bytes) {
            used += (size_t)snprintf(words + used, words_bytes - used, "%s%s", used > 0 ? " " : "", known[i]);
        }
    }
}

static void add_devices(gpu_run *run, const cJSON *devices)
{
    const cJSON *platform = NULL;
    const cJSON *device = NULL;
    char extensions[512];
    cJSON_ArrayForEach(platform, array_of(devices, "platforms"))
    {
        cJSON_ArrayForEach(device, array_of(platform, "devices"))
        {
            join_extensions(text_of(device, "extensions"), extensions, sizeof extensions);
            result_add_text(run->drivers, "%s", text_of(device, "name"));
            result_add_text(run->drivers, "%s", text_of(device, "type"));
            result_add_text(run->drivers, "%s", text_of(device, "driver"));
            result_add_text(run->drivers, "%s", extensions);
            result_add_number(run->drivers, number_of(device, "compute_units"));
            result_add_number(run->drivers, number_of(device, "memory_bytes"));
        }
    }
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
    add_devices(run, answer.document);
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
    static const char *const words[] = {"verify", "--tree-form", "all", NULL};
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
    return sum;
}

static void fill_numbers(const cJSON *document, double numbers[NUMBER_COUNT])
{
    static const char *const stages[] = {"voxelize", "subdivide", "link",     "pack",
                                         "filter",   "grid",      "transfer", "compile"};
    const size_t stage_count = sizeof stages / sizeof stages[0];
    static const struct {
        const char *name;
        int at;
    } fields[] = {{"first_compile_ms", COMPILE_MS},
                  {"wall_ms", WALL_MS},
                  {"launches", LAUNCHES},
                  {"uploads", UPLOADS},
                  {"waits", WAITS},
                  {"allocations", ALLOCATIONS},
                  {"reads", READS},
                  {"allocations_ms", ALLOCATING_MS},
                  {"reads_ms", READING_MS}};
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; ++i) {
        numbers[fields[i].at] = number_of(document, fields[i].name);
    }
    numbers[VOXELIZE_MS] = sum_stages(document, stages, 1);
    numbers[TREE_MS] = sum_stages(document, stages + 1, 4);
    numbers[BUILD_MS] = sum_stages(document, stages, stage_count - 1);
    numbers[GAPS_MS] = numbers[WALL_MS] - sum_stages(document, stages, stage_count);
}

/* ---- kernels ---- */

/* Whether the table has a kernel with these numbers. */
static bool has_kernel(const result_table *table, const char *name, const double numbers[], size_t count)
{
    for (size_t row = 0; row < result_row_count(table); ++row) {
        bool is_same = strcmp(result_cell_at(table, row, 0)->text, name) == 0;
        for (size_t i = 0; i < count; ++i) {
            const result_cell *cell = result_cell_at(table, row, i + 1);
            is_same = is_same && (cell->kind == RESULT_NUMBER ? cell->number == numbers[i] : isnan(numbers[i]));
        }
        if (is_same) {
            return true;
        }
    }
    return false;
}

/* Adds the kernels that a child has compiled, but those that others had before. */
static void add_kernels(gpu_run *run, const cJSON *document)
{
    static const char *const names[] = {"local_bytes", "private_bytes", "group_multiple", "registers"};
    const cJSON *kernel = NULL;
    cJSON_ArrayForEach(kernel, array_of(document, "compiled_kernels"))
    {
        double numbers[sizeof names / sizeof names[0]];
        for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
            numbers[i] = number_of(kernel, names[i]);
        }
        if (has_kernel(run->kernels, text_of(kernel, "name"), COLUMNS(numbers))) {
            continue;
        }
        result_add_text(run->kernels, "%s", text_of(kernel, "name"));
        for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
            result_add_number(run->kernels, numbers[i]);
        }
    }
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
    const char *const words[] = {"build", "--need", NEEDS, "--weights", source->weights, "--repeat", repeats, NULL};
    char wrong[128];
    child_answer answer;
    ask(run, words, source, method, &answer);
    step_row row = row_of("build", source, method->name);
    row.is_absent = is_absent(run, method) || strcmp(text_of(answer.document, "status"), "SVO_UNSUPPORTED") == 0;
    if (answer.well) {
        fill_numbers(answer.document, row.numbers);
        add_kernels(run, answer.document);
    }
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
    add_kernels(run, answer.document);
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
        row.numbers[RATE] = number_of(set, "ours_mrays");
        add_row(run, &row, &answer, NULL);
    }
    if (cJSON_GetArraySize(sets) == 0) {
        add_row(run, &row, &answer, NULL);
    }
    cJSON_Delete(answer.document);
}
