/* SPDX-License-Identifier: MIT */
/*
 * The cells of one process: a first build of each, smaller ones before larger ones, then rounds in which every cell has
 * one build, in an order of its own. Each tree is hashed as `svocl hash` does.
 */
#include "bench/versus_run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/versus_data.h"
#include "measure/host.h"
#include "support/devices.h"
#include "support/info_of.h"

#define SLOW_MS     2000.0 /* where a build takes longer, what is larger still is left out */
#define ENOUGH_MS   1000.0 /* a cell leaves once its rounds have taken so long */
#define FIRST_SHARE 0.6 /* of the time, for first builds */
#define METHODS_MAX 64u
#define SCENES_MAX  (OPTION_INPUTS_MAX + 1)

/* How trees are built. */
typedef struct method {
    unsigned level[VERSUS_FACTORS];
    session *opened;
    svo_frontend *frontend; /* not used by gl-compute, which draws by its own */
    svo_message reason; /* not "": it does not work at all */
} method;

typedef struct cell_state {
    method *by;
    bool is_left_out; /* its method has a cell that says why */
    size_t rounds;
    double first_ms, spent_ms;
    double numbers[VERSUS_HASH - VERSUS_TRIANGLES];
    char hash[SVO_HASH_TEXT_BYTES];
    char clocks[64];
    svo_message reason; /* not "": there are no rounds */
} cell_state;

typedef struct run {
    program *state;
    result_set *results;
    session own, gpu; /* gpu: of --path gpu, where that is not the device's own */
    suite_input scenes[SCENES_MAX];
    versus_design design;
    versus_cell *cells;
    cell_state *states;
    size_t count;
    method methods[METHODS_MAX];
    size_t method_count;
    size_t repeats;
    double first_end_ms, end_ms; /* of first builds, of all: input_now_ms; INFINITY: none */
} run;

/* ---- methods ---- */

static int value_of(const unsigned *level, versus_column factor)
{
    return versus_levels(factor)[level[factor]].value;
}

static bool is_compute(const method *one)
{
    return value_of(one->level, VERSUS_BUILDER) == OPTION_BUILDER_GL_COMPUTE;
}

/* gl-compute draws its list by itself, so it has none by OpenCL: it then takes its own choice, and the report says
   which. */
static int frontend_of(const method *one)
{
    const int frontend = value_of(one->level, VERSUS_LIST);
    return frontend == OPTION_FRONTEND_CL ? OPTION_FRONTEND_AUTO : frontend;
}

static void open_method(run *all, method *one)
{
    const bool is_own = one->level[VERSUS_PATH] == all->design.own_path;
    const bool in_cl = value_of(one->level, VERSUS_LIST) == OPTION_FRONTEND_CL && !is_compute(one);
    one->opened = is_own ? &all->own : &all->gpu;
    one->frontend = one->opened->cl;
    if (!in_cl && one->opened->gl == NULL) {
        one->reason = one->opened->reason;
    } else if (!in_cl) {
        one->frontend = opengl_further_frontend(one->opened->gl, frontend_of(one), value_of(one->level, VERSUS_SHARE),
                                                &one->reason);
    }
}

static method *find_method(run *all, const versus_cell *cell)
{
    for (size_t i = 0; i < all->method_count; ++i) {
        bool same = true;
        for (versus_column k = VERSUS_PATH; k <= VERSUS_BUILDER; ++k) {
            same = same && all->methods[i].level[k] == cell->level[k];
        }
        if (same) {
            return &all->methods[i];
        }
    }
    method *made = &all->methods[all->method_count++];
    memcpy(made->level, cell->level, sizeof made->level);
    open_method(all, made);
    return made;
}

/* A build that reports another list or share than it was asked for is another cell. */
static void check_report(method *one, const svo_build_report *report)
{
    const char *list = versus_levels(VERSUS_LIST)[one->level[VERSUS_LIST]].name;
    const char *share = versus_levels(VERSUS_SHARE)[one->level[VERSUS_SHARE]].name;
    if (strcmp(report->frontend, list) != 0) {
        snprintf(one->reason.text, sizeof one->reason.text, "the build reports list %s", report->frontend);
    } else if (strcmp(report->share, share) != 0) {
        snprintf(one->reason.text, sizeof one->reason.text, "the build reports share %s", report->share);
    }
}

/* ---- one build ---- */

static double stage_ms(const svo_build_report *report, svo_stage stage)
{
    return report->stage_times[stage].clock != NULL ? report->stage_times[stage].ms : 0.0;
}

/* The clocks of list, tree and transfer, each once: "wall, cl-event". */
static void name_clocks(const svo_build_report *report, char *text, size_t text_bytes)
{
    static const svo_stage stages[] = {SVO_STAGE_VOXELIZE, SVO_STAGE_SUBDIVIDE, SVO_STAGE_FILTER, SVO_STAGE_TRANSFER};
    text[0] = '\0';
    for (size_t i = 0; i < sizeof stages / sizeof stages[0]; ++i) {
        const char *clock = report->stage_times[stages[i]].clock;
        const size_t used = strlen(text);
        if (clock != NULL && strstr(text, clock) == NULL) {
            snprintf(text + used, text_bytes - used, "%s%s", used > 0 ? ", " : "", clock);
        }
    }
}

static void keep_times(const svo_build_report *report, double *ms)
{
    ms[VERSUS_VOXELIZE] = stage_ms(report, SVO_STAGE_VOXELIZE);
    ms[VERSUS_TREE] = stage_ms(report, SVO_STAGE_SUBDIVIDE) + stage_ms(report, SVO_STAGE_LINK) +
                      stage_ms(report, SVO_STAGE_PACK) + stage_ms(report, SVO_STAGE_FILTER);
    ms[VERSUS_TRANSFER] = stage_ms(report, SVO_STAGE_TRANSFER);
    ms[VERSUS_COMPILE] = stage_ms(report, SVO_STAGE_COMPILE);
}

static void keep_facts(const run *all, size_t index, const svo_plan *plan, const svo_build_report *report,
                       const svo_tree *tree)
{
    cell_state *own = &all->states[index];
    own->numbers[0] = (double)all->scenes[all->cells[index].level[VERSUS_SCENE]].source.mesh->triangle_count;
    own->numbers[VERSUS_FRAGMENTS - VERSUS_TRIANGLES] = (double)report->fragments;
    own->numbers[VERSUS_NODES - VERSUS_TRIANGLES] = (double)info_of_tree(tree).node_count;
    own->numbers[VERSUS_PEAK - VERSUS_TRIANGLES] = (double)info_of_plan(plan).peak_bytes;
    name_clocks(report, own->clocks, sizeof own->clocks);
}

/* Builds, and stops the clock when the queue is finished. The caller destroys plan and tree. */
static svo_status build(const run *all, size_t index, svo_plan **plan, svo_tree **tree, svo_build_report *report,
                        double *ms)
{
    const unsigned *level = all->cells[index].level;
    const method *by = all->states[index].by;
    const int builder = value_of(level, VERSUS_BUILDER);
    const svo_plan_options asked = {
        .struct_size = sizeof asked,
        .need = (uint32_t)value_of(level, VERSUS_NEED),
        .weights = (svo_weights)value_of(level, VERSUS_WEIGHTS),
        .coverage = (svo_coverage)value_of(level, VERSUS_COVERAGE),
        .builder = is_compute(by) ? SVO_BUILDER_CL : (svo_builder)builder,
    };
    const double start_ms = input_now_ms();
    svo_status status = svo_plan_create(by->opened->device, all->scenes[level[VERSUS_SCENE]].source.mesh,
                                        level[VERSUS_DEPTH], &asked, plan);
    ms[VERSUS_PLAN] = input_now_ms() - start_ms;
    if (status == SVO_OK && is_compute(by)) {
        status = opengl_further_build(by->opened->gl, frontend_of(by), value_of(level, VERSUS_SHARE), *plan,
                                      by->opened->queue, tree, report);
    } else if (status == SVO_OK) {
        status = svo_build(*plan, by->frontend, by->opened->queue, tree, report);
    }
    if (status == SVO_OK) {
        clFinish(by->opened->queue);
    }
    ms[VERSUS_WALL] = input_now_ms() - start_ms;
    keep_times(report, ms);
    return status;
}

/* The first cell of the same scene, depth, need, weights and coverage that has a tree. */
static const cell_state *find_twin(const run *all, size_t index)
{
    for (size_t i = 0; i < all->count; ++i) {
        bool same = all->states[i].hash[0] != '\0';
        for (versus_column k = 0; k < VERSUS_FACTORS; ++k) {
            const bool counts = (VERSUS_SETTING & VERSUS_BIT(k)) != 0;
            same = same && (!counts || all->cells[i].level[k] == all->cells[index].level[k]);
        }
        if (same) {
            return &all->states[i];
        }
    }
    return &all->states[index];
}

static int fail_hash(const run *all, size_t index, const char *hash, const char *expected)
{
    const unsigned *level = all->cells[index].level;
    char words[256] = "";
    for (versus_column i = VERSUS_PATH; i < VERSUS_FACTORS; ++i) {
        const size_t used = strlen(words);
        snprintf(words + used, sizeof words - used, "%s%s", used > 0 ? ", " : "", versus_levels(i)[level[i]].name);
    }
    return program_fail(all->state, PROGRAM_FAILED, "%s at depth %u, %s: the tree's hash is %s, others have %s",
                        suite_scene_name(&all->scenes[level[VERSUS_SCENE]].source), level[VERSUS_DEPTH], words, hash,
                        expected);
}

static int check_hash(const run *all, size_t index, svo_tree *tree)
{
    const cell_state twin = *find_twin(all, index);
    session *opened = all->states[index].by->opened;
    char *hash = all->states[index].hash;
    if (svo_tree_download(tree, opened->queue) != SVO_OK || svo_tree_hash(tree, SVO_HASH_ALL, hash) != SVO_OK) {
        return program_fail_library(all->state, svo_device_message(opened->device));
    }
    return twin.hash[0] == '\0' || strcmp(hash, twin.hash) == 0 ? PROGRAM_DONE : fail_hash(all, index, hash, twin.hash);
}

static void add_round(const run *all, size_t index, const double *ms)
{
    result_table *rounds = result_find(all->results, VERSUS_ROUNDS_ID);
    result_add_number(rounds, (double)index); /* the row of the cell, once rows are written */
    result_add_number(rounds, 1);
    result_add_number(rounds, (double)all->states[index].rounds);
    for (size_t i = 0; i < VERSUS_TIMES; ++i) {
        result_add_number(rounds, ms[i]);
    }
}

/* Failures that are a cell's reason; others end the run. */
static bool is_limit(svo_status status)
{
    return status == SVO_UNSUPPORTED || status == SVO_NO_GL || status == SVO_OUT_OF_DEVICE_MEMORY;
}

static int run_cell(run *all, size_t index)
{
    cell_state *own = &all->states[index];
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_build_report report = {.struct_size = sizeof report};
    double ms[VERSUS_TIMES];
    int exit_code = PROGRAM_DONE;
    const svo_status status = build(all, index, &plan, &tree, &report, ms);
    if (status == SVO_OK) {
        check_report(own->by, &report);
    }
    if (is_limit(status)) {
        snprintf(own->reason.text, sizeof own->reason.text, "%s",
                 program_words(svo_device_message(own->by->opened->device)));
    } else if (status != SVO_OK) {
        exit_code = program_fail_library(all->state, svo_device_message(own->by->opened->device));
    } else if (own->by->reason.text[0] == '\0') {
        exit_code = check_hash(all, index, tree);
        keep_facts(all, index, plan, &report, tree);
        add_round(all, index, ms);
        own->first_ms = own->rounds == 0 ? ms[VERSUS_WALL] : own->first_ms;
        own->spent_ms += own->rounds > 0 || versus_is_round(ms) ? ms[VERSUS_WALL] : 0.0;
        ++own->rounds;
    }
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    return exit_code;
}

/* ---- rounds ---- */

/* Whether a smaller cell of the same method and settings is slow. */
static bool is_beyond(const run *all, size_t index, size_t *smaller)
{
    const unsigned *level = all->cells[index].level;
    for (size_t i = 0; i < all->count && !all->design.full; ++i) {
        const unsigned *other = all->cells[i].level;
        bool same = all->states[i].first_ms > SLOW_MS && other[VERSUS_DEPTH] <= level[VERSUS_DEPTH] &&
                    all->scenes[other[VERSUS_SCENE]].source.mesh->triangle_count <=
                        all->scenes[level[VERSUS_SCENE]].source.mesh->triangle_count;
        for (versus_column k = VERSUS_PATH; k < VERSUS_FACTORS; ++k) {
            same = same && other[k] == level[k];
        }
        if (same) {
            *smaller = i;
            return true;
        }
    }
    return false;
}

static bool is_crossed(const run *all, size_t index)
{
    return versus_is_central(&all->design, &all->cells[index], VERSUS_BIT(VERSUS_SCENE) | VERSUS_BIT(VERSUS_DEPTH));
}

/* Whether another share works for the same path, list and builder: series have the first one that does. */
static bool has_other_share(const run *all, size_t index)
{
    const unsigned *level = all->cells[index].level;
    for (size_t i = 0; i < all->count && !all->design.full; ++i) {
        const unsigned *other = all->cells[i].level;
        if (all->states[i].hash[0] != '\0' && is_crossed(all, i) && other[VERSUS_PATH] == level[VERSUS_PATH] &&
            other[VERSUS_LIST] == level[VERSUS_LIST] && other[VERSUS_BUILDER] == level[VERSUS_BUILDER] &&
            other[VERSUS_SHARE] < level[VERSUS_SHARE]) {
            return true;
        }
    }
    return false;
}

static int begin_cell(run *all, size_t index)
{
    cell_state *own = &all->states[index];
    size_t smaller = 0;
    own->by = find_method(all, &all->cells[index]);
    own->numbers[0] = (double)all->scenes[all->cells[index].level[VERSUS_SCENE]].source.mesh->triangle_count;
    if (own->by->reason.text[0] == '\0' && !is_crossed(all, index) && has_other_share(all, index)) {
        own->is_left_out = true;
        return PROGRAM_DONE;
    }
    int exit_code = PROGRAM_DONE;
    if (own->by->reason.text[0] == '\0' && is_beyond(all, index, &smaller)) {
        snprintf(own->reason.text, sizeof own->reason.text, "not measured: %s at depth %u took %.1f s",
                 suite_scene_name(&all->scenes[all->cells[smaller].level[VERSUS_SCENE]].source),
                 all->cells[smaller].level[VERSUS_DEPTH], all->states[smaller].first_ms / 1000.0);
    } else if (own->by->reason.text[0] == '\0' && input_now_ms() > all->first_end_ms) {
        snprintf(own->reason.text, sizeof own->reason.text, "not measured: the time was over");
    } else if (own->by->reason.text[0] == '\0') {
        exit_code = run_cell(all, index);
    }
    if (own->by->reason.text[0] != '\0') {
        own->is_left_out = !versus_is_central(&all->design, &all->cells[index], VERSUS_SETTING);
        own->reason = own->by->reason;
    }
    return exit_code;
}

/* A guess at the fragments of a cell, up to a factor. */
static double work_of(const run *all, size_t index)
{
    const unsigned *level = all->cells[index].level;
    return ldexp(1.0, 2 * (int)level[VERSUS_DEPTH]) +
           (double)all->scenes[level[VERSUS_SCENE]].source.mesh->triangle_count;
}

/* Central cells are built first, in each round as well, then the cross, then the series: the time may end. */
static unsigned rank_of(const run *all, size_t index)
{
    const bool is_central = versus_is_central(&all->design, &all->cells[index], VERSUS_SETTING);
    return is_central ? 0 : is_crossed(all, index) ? 1 : 2;
}

/* Whether a cell is built before another: by rank, then work, then payload, so that all methods have what one has. */
static bool is_before(const run *all, size_t a, size_t b)
{
    const unsigned *of_a = all->cells[a].level;
    const unsigned *of_b = all->cells[b].level;
    if (rank_of(all, a) != rank_of(all, b)) {
        return rank_of(all, a) < rank_of(all, b);
    }
    const double more = work_of(all, a) - work_of(all, b);
    if (more > 0 || more < 0) {
        return more < 0;
    }
    for (versus_column i = VERSUS_NEED; i < VERSUS_FACTORS; ++i) {
        if (of_a[i] != of_b[i]) {
            return of_a[i] < of_b[i];
        }
    }
    return a < b;
}

static void sort_first(const run *all, size_t *order)
{
    for (size_t i = 0; i < all->count; ++i) {
        size_t at = i;
        for (; at > 0 && is_before(all, i, order[at - 1]); --at) {
            order[at] = order[at - 1];
        }
        order[at] = i;
    }
}

static int run_first(run *all, size_t *order)
{
    int exit_code = PROGRAM_DONE;
    sort_first(all, order);
    for (size_t i = 0; i < all->count && exit_code == PROGRAM_DONE; ++i) {
        progress_part(all->state->progress, "first builds", (double)i / (double)all->count);
        exit_code = begin_cell(all, order[i]);
    }
    return exit_code;
}

static bool has_enough(const run *all, const cell_state *own)
{
    return own->rounds == 0 || own->rounds > all->repeats || own->spent_ms > ENOUGH_MS;
}

/* The cells of each rank in an order of their own. */
static void shuffle(const run *all, size_t *order, random_stream *random)
{
    size_t used = 0;
    for (unsigned rank = 0; rank < 3; ++rank) {
        const size_t begin = used;
        for (size_t i = 0; i < all->count; ++i) {
            if (rank_of(all, i) == rank) {
                const size_t at = begin + random_index(random, (uint32_t)(used - begin + 1));
                order[used++] = order[at];
                order[at] = i;
            }
        }
    }
}

static int run_rounds(run *all)
{
    random_stream random = {.state = all->state->options.seed};
    size_t *order = calloc(all->count + 1, sizeof *order);
    int exit_code = order != NULL ? run_first(all, order) : program_fail(all->state, PROGRAM_FAILED, "out of memory");
    for (size_t round = 0; round < all->repeats && exit_code == PROGRAM_DONE; ++round) {
        shuffle(all, order, &random);
        progress_part(all->state->progress, "rounds", (double)round / (double)all->repeats);
        for (size_t i = 0; i < all->count && exit_code == PROGRAM_DONE && input_now_ms() < all->end_ms; ++i) {
            const cell_state *own = &all->states[order[i]];
            exit_code = has_enough(all, own) ? PROGRAM_DONE : run_cell(all, order[i]);
        }
    }
    free(order);
    return exit_code;
}

/* ---- rows ---- */

static void add_cell(const run *all, size_t index)
{
    result_table *cells = result_find(all->results, VERSUS_CELLS_ID);
    const unsigned *level = all->cells[index].level;
    const cell_state *own = &all->states[index];
    result_add_text(cells, "%s", suite_scene_name(&all->scenes[level[VERSUS_SCENE]].source));
    result_add_number(cells, level[VERSUS_DEPTH]);
    for (versus_column i = VERSUS_PATH; i < VERSUS_FACTORS; ++i) {
        result_add_text(cells, "%s", versus_levels(i)[level[i]].name);
    }
    result_add_number(cells, own->numbers[0]);
    for (size_t i = 1; i < VERSUS_HASH - VERSUS_TRIANGLES; ++i) {
        result_add_number(cells, own->rounds > 0 ? own->numbers[i] : (double)NAN);
    }
    result_add_text(cells, "%s", own->hash);
    result_add_text(cells, "%s", own->clocks);
    result_add_text(cells, "%s", own->reason.text);
}

/* The rows of cells, central ones first, and in place of cells' indices in the rounds their rows. */
static void add_cells(const run *all)
{
    result_table *rounds = result_find(all->results, VERSUS_ROUNDS_ID);
    size_t row = 0;
    for (size_t i = 0; i < 2 * all->count; ++i) {
        const size_t index = i % all->count;
        const bool is_central = versus_is_central(&all->design, &all->cells[index], VERSUS_SETTING);
        if (!all->states[index].is_left_out && is_central == (i < all->count)) {
            add_cell(all, index);
            all->states[index].first_ms = (double)row++;
        }
    }
    for (size_t i = 0; rounds != NULL && i < rounds->cell_count; i += rounds->column_count) {
        rounds->cells[i].number = all->states[(size_t)rounds->cells[i].number].first_ms;
    }
}

/* ---- what is opened ---- */

static int open_scenes(run *all)
{
    static const char *const usual[] = {"knot:10000", "knot:1000", "knot:100000", "knot:1000000", NULL};
    static const char *const quick[] = {"knot:2000", "knot:500", NULL};
    program *state = all->state;
    const char *given[SCENES_MAX + 1] = {state->options.input};
    memcpy(given + 1, state->options.further_inputs, state->options.further_count * sizeof given[0]);
    const char *const *names = given[0] != NULL ? given : all->design.quick ? quick : usual;
    int exit_code = PROGRAM_DONE;
    for (size_t i = 0; names[i] != NULL && exit_code == PROGRAM_DONE; ++i) {
        exit_code = suite_open(state, names[i], &all->scenes[i]);
        all->design.scene_count += exit_code == PROGRAM_DONE;
    }
    all->design.each_has_depths = given[0] != NULL;
    return exit_code;
}

static int open_sessions(run *all)
{
    program *state = all->state;
    const options kept = state->options;
    state->options.hybrid_columns = VERSUS_HYBRID_COLUMNS;
    int exit_code = session_open_both(state, &all->own);
    all->design.own_path = exit_code == PROGRAM_DONE && info_of_device(all->own.device).path == SVO_PATH_GPU ? 1 : 0;
    all->design.has_gpu_path = kept.path == SVO_PATH_AUTO && all->design.own_path == 0;
    if (exit_code == PROGRAM_DONE && all->design.has_gpu_path) {
        state->options.path = SVO_PATH_GPU;
        state->options.frontend = OPTION_FRONTEND_CL;
        exit_code = session_open(state, &all->gpu);
    }
    state->options = kept;
    return exit_code;
}

static void describe(const run *all)
{
    static const cl_device_info which[] = {CL_DRIVER_VERSION, CL_DEVICE_VERSION};
    result_machine *machine = &all->results->machine;
    char **const facts[] = {&machine->driver, &machine->platform};
    const svo_device_info on = info_of_device(all->own.device);
    host_describe(&all->state->options, machine);
    result_set_fact(all->results, &machine->device, on.name);
    for (size_t i = 0; i < 2; ++i) {
        char *text = devices_text(on.device, NULL, which[i]);
        result_set_fact(all->results, facts[i], text != NULL ? text : "");
        free(text);
    }
    result_set_fact(all->results, &machine->renderer, all->own.gl != NULL ? opengl_renderer(all->own.gl) : "none");
}

static int make_cells(run *all)
{
    all->cells = versus_list(&all->design, &all->count);
    all->states = calloc(all->count + 1, sizeof *all->states);
    return all->cells != NULL && all->states != NULL
               ? PROGRAM_DONE
               : program_fail(all->state, PROGRAM_FAILED, "out of memory for %zu cells", all->count);
}

static int measure(run *all)
{
    const options given = all->state->options;
    progress_step(all->state->progress, "measuring");
    int exit_code = open_scenes(all);
    all->state->options = given;
    if (exit_code == PROGRAM_DONE) {
        exit_code = open_sessions(all);
    }
    if (exit_code == PROGRAM_DONE) {
        exit_code = make_cells(all);
    }
    if (exit_code == PROGRAM_DONE) {
        describe(all);
        exit_code = run_rounds(all);
    }
    if (exit_code == PROGRAM_DONE) {
        add_cells(all);
    }
    return exit_code;
}

int versus_run(program *state, double seconds, result_set *results)
{
    const options *given = &state->options;
    run *all = calloc(1, sizeof *all);
    if (all == NULL) {
        return program_fail(state, PROGRAM_FAILED, "out of memory");
    }
    all->state = state;
    all->results = results;
    all->design = (versus_design){.quick = given->quick != 0, .full = given->full != 0};
    all->design.depth = given->has_depth ? (unsigned)given->depth : given->quick ? 4 : 6;
    all->repeats = given->has_repeat ? (size_t)given->repeat : given->quick ? 2 : 11;
    all->first_end_ms = seconds > 0 ? input_now_ms() + 1e3 * seconds * FIRST_SHARE : INFINITY;
    all->end_ms = seconds > 0 ? input_now_ms() + 1e3 * seconds : INFINITY;
    int exit_code = suite_read_depths(state,
                                      given->depths != NULL ? given->depths
                                      : given->quick        ? "3,4"
                                                            : "5,6,7,8,9,10,11",
                                      all->design.depths);
    if (exit_code == PROGRAM_DONE) {
        exit_code = measure(all);
    }
    session_close(&all->gpu);
    session_close(&all->own);
    for (size_t i = 0; i < all->design.scene_count; ++i) {
        input_close(&all->scenes[i].source);
    }
    free(all->cells);
    free(all->states);
    free(all);
    return exit_code;
}
