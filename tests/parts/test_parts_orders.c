/* SPDX-License-Identifier: MIT */
/*
 * Planners, builders and a stitcher of one folder, in every order of their steps up to a number of interruptions. The
 * library's own code runs: each process is a thread, and one of them runs at a time. What the library calls of files is
 * wrapped, and before each call that others can see, another may go on. The orders are searched depth first, by running
 * all of them from the beginning.
 *
 * In one world leases are never stale, in the other they always are, as if each process was stopped for minutes between
 * any two of its steps. A file of two plans must not come of either, and the folder must always be good for a next run.
 *
 * A process that stitches by shares is also killed before every call that changes a file.
 *
 * Of the scenario with all processes, which has 7,082 orders in each world, those are run that interrupt before every
 * fourth call; with SVOCL_LONG_TESTS all.
 */
#define _GNU_SOURCE /* O_TMPFILE */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/message.h"
#include "support/fixture.h"
#include "support/meshes.h"
#include "support/suite.h"
#include "svocl/io.h"
#include "svocl/parts.h"

#define DEPTH        4
#define TRIANGLES    12
#define LIMIT        ((uint64_t)25000)
#define PATH_BYTES   512
#define ACTORS_MAX   5
#define STEPS_MAX    4096
#define MESHES       2
#define LONG_STRIDE  4
#define STALE_AFTER  1000 /* seconds that a lease looks old in the world where all are stale */
#define FIRST_NUMBER 4000000 /* of processes: above what Linux gives */

/* ---- what is tried ---- */

typedef enum role { PLANS_A, PLANS_B, BUILDS, STITCHES, SHARES } role;

typedef struct scenario {
    const char *name;
    role roles[ACTORS_MAX];
    int count;
    int interruptions; /* most of a run */
    bool begins_planned; /* by A */
    bool has_one_part; /* else eight */
    bool is_long; /* interrupted before every fourth call alone */
    bool begins_built;
} scenario;

typedef struct actor {
    int index;
    role does;
    pthread_t thread;
    bool is_begun, is_done;
    bool opened; /* the folder; planned is its plan then */
    char planned[SVO_PARTS_IDENTITY_BYTES];
    svo_status status;
    svo_message message;
} actor;

/* A decision of a run: which of count processes goes on. */
typedef struct decision {
    int chosen;
    int count;
    bool is_interruption; /* else who begins, or goes on after another has ended */
} decision;

static struct {
    fixture opened;
    owned_mesh meshes[MESHES];
    svo_plan_options options;
    char identities[MESHES][SVO_PARTS_IDENTITY_BYTES];
    char root[64], folder[128];
    char *whole[MESHES]; /* the files in one piece */
    size_t whole_bytes[MESHES];
    /* of a run */
    const scenario *of;
    bool leases_are_stale;
    actor actors[ACTORS_MAX];
    pthread_mutex_t mutex;
    pthread_cond_t turn;
    int running; /* index of the actor; -1: none */
    int interruptions;
    decision steps[STEPS_MAX];
    int step, given_steps;
    int calls_left; /* before the process is killed; below 0: it is not */
} world = {.calls_left = -1};

static _Thread_local actor *self; /* NULL: the test itself */

/* ---- one at a time ---- */

/* The next decision: as it was given, or the first. */
static int decide(int count)
{
    assert_true(world.step < STEPS_MAX);
    decision *now = &world.steps[world.step];
    if (world.step >= world.given_steps) {
        now->chosen = 0;
    }
    now->count = count;
    now->is_interruption = false;
    ++world.step;
    return now->chosen;
}

/* Whether it does the same as one before it, and neither has begun. */
static bool is_twin(int index)
{
    bool found = false;
    for (int i = 0; i < index; ++i) {
        const actor *a = &world.actors[i];
        found = found || (a->does == world.actors[index].does && !a->is_begun && !world.actors[index].is_begun);
    }
    return found;
}

/* The nth actor that is not done, other than one. Of those that are alike the first begins first. */
static int nth_left(int n, int other_than)
{
    for (int i = 0; i < world.of->count; ++i) {
        if (i != other_than && !world.actors[i].is_done && !is_twin(i) && n-- == 0) {
            return i;
        }
    }
    return -1;
}

static int count_left(int other_than)
{
    int count = 0;
    while (nth_left(count, other_than) >= 0) {
        ++count;
    }
    return count;
}

static void hand_to(int next)
{
    world.running = next;
    (void)pthread_cond_broadcast(&world.turn);
}

static void wait_for_turn(int index)
{
    while (world.running != index) {
        (void)pthread_cond_wait(&world.turn, &world.mutex);
    }
}

/* Others may go on before the next call of this process. */
static void step(void)
{
    if (self == NULL || world.interruptions >= world.of->interruptions) {
        return;
    }
    (void)pthread_mutex_lock(&world.mutex);
    const int decided = world.step;
    const int chosen = decide(1 + count_left(self->index));
    world.steps[decided].is_interruption = true;
    if (chosen > 0) {
        ++world.interruptions;
        hand_to(nth_left(chosen - 1, self->index));
        wait_for_turn(self->index);
    }
    (void)pthread_mutex_unlock(&world.mutex);
}

/* ---- the calls ---- */

/* Whether others see what happens at a path: it is in the folder, and not below the lease of a planner or a file
   without a name. */
static bool is_seen(const char *path)
{
    const size_t length = strlen(world.folder);
    return strncmp(path, world.folder, length) == 0 && strstr(path + length, "planner.lease/") == NULL;
}

/* Kills the process before a call that changes a file, when its turn has come. */
static void may_die(void)
{
    if (world.calls_left >= 0 && world.calls_left-- == 0) {
        (void)raise(SIGKILL);
    }
}

/* NOLINTBEGIN(readability-identifier-naming) */
#define DECLARE(type, name, parameters) \
    type __real_##name parameters;      \
    type __wrap_##name parameters;      \
    type __wrap_##name parameters

DECLARE(int, open, (const char *path, int flags, ...))
{
    va_list arguments;
    va_start(arguments, flags);
    const int mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, int) : 0;
    va_end(arguments);
    if ((flags & O_TMPFILE) != O_TMPFILE && is_seen(path)) {
        step();
    }
    if ((flags & O_CREAT) != 0) {
        may_die();
    }
    return __real_open(path, flags, mode);
}

DECLARE(int, rename, (const char *from, const char *to))
{
    if (is_seen(from) || is_seen(to)) {
        step();
    }
    may_die();
    return __real_rename(from, to);
}

DECLARE(int, linkat, (int from_folder, const char *from, int to_folder, const char *to, int flags))
{
    if (is_seen(to)) {
        step();
    }
    may_die();
    return __real_linkat(from_folder, from, to_folder, to, flags);
}

DECLARE(int, unlink, (const char *path))
{
    if (is_seen(path)) {
        step();
    }
    may_die();
    return __real_unlink(path);
}

DECLARE(ssize_t, pwrite, (int file, const void *bytes, size_t byte_count, off_t offset))
{
    may_die();
    return __real_pwrite(file, bytes, byte_count, offset);
}

DECLARE(int, fsync, (int file))
{
    may_die();
    return __real_fsync(file);
}

DECLARE(int, ftruncate, (int file, off_t length))
{
    may_die();
    return __real_ftruncate(file, length);
}

DECLARE(DIR *, opendir, (const char *path))
{
    if (is_seen(path)) {
        step();
    }
    return __real_opendir(path);
}

DECLARE(int, fstat, (int file, struct stat *entry))
{
    const int result = __real_fstat(file, entry);
    if (self != NULL && world.leases_are_stale) {
        entry->st_mtime -= STALE_AFTER;
    }
    return result;
}

DECLARE(pid_t, getpid, (void))
{
    return self != NULL ? FIRST_NUMBER + self->index : __real_getpid();
}

DECLARE(int, kill, (pid_t process, int number))
{
    return process >= FIRST_NUMBER ? 0 : __real_kill(process, number);
}
/* NOLINTEND(readability-identifier-naming) */

/* ---- the processes ---- */

static void plan_folder(int mesh, svo_status *status, svo_message *message)
{
    const uint64_t limit = world.of != NULL && world.of->has_one_part ? (uint64_t)1 << 30 : LIMIT;
    *status = svo_parts_create(world.opened.device, &world.meshes[mesh].mesh, DEPTH, &world.options, limit,
                               world.folder, message);
}

static void out_of(const actor *a, char path[PATH_BYTES])
{
    (void)snprintf(path, PATH_BYTES, "%s/out%d.svo", world.root, a->index);
}

static svo_status build_all(const svo_parts *parts, svo_message *message)
{
    for (size_t i = 0; i < svo_parts_count(parts); ++i) {
        SVO_I_TRY(svo_parts_build(parts, i, world.opened.device, NULL, NULL, message));
    }
    return SVO_OK;
}

/* The last share first, and each twice: a worker that was given up may go on. */
static svo_status stitch_by_shares(const svo_parts *parts, unsigned count, const char *out, svo_message *message)
{
    SVO_I_TRY(svo_parts_shares_begin(parts, count, message));
    for (unsigned i = 2 * count; i-- > 0;) {
        SVO_I_TRY(svo_parts_shares_write(parts, i / 2, count, message));
    }
    return svo_parts_shares_finish(parts, count, out, message);
}

/* What a run does when it has a lease and the folder is open. */
static svo_status work(actor *a, const svo_parts *parts, const char *out)
{
    switch (a->does) {
    case BUILDS:
        return build_all(parts, &a->message);
    case SHARES:
        return stitch_by_shares(parts, 2, out, &a->message);
    default:
        return svo_parts_finish(parts, out, &a->message);
    }
}

/* A run as the program does it: with a lease. */
static void use_folder(actor *a)
{
    svo_parts_lease *lease = NULL;
    svo_parts *parts = NULL;
    char out[PATH_BYTES];
    out_of(a, out);
    a->status = svo_parts_lease_take(world.folder, &lease, &a->message);
    if (a->status == SVO_OK) {
        a->status = svo_parts_open(world.folder, &parts, &a->message);
    }
    if (a->status == SVO_OK) {
        a->opened = svo_parts_get_identity(parts, a->planned, NULL) == SVO_OK;
        a->status = work(a, parts, out);
    }
    svo_parts_close(&parts);
    svo_parts_lease_release(&lease);
}

static void *act(void *user)
{
    actor *a = user;
    self = a;
    (void)pthread_mutex_lock(&world.mutex);
    wait_for_turn(a->index);
    a->is_begun = true;
    (void)pthread_mutex_unlock(&world.mutex);
    if (a->does == PLANS_A || a->does == PLANS_B) {
        plan_folder(a->does == PLANS_A ? 0 : 1, &a->status, &a->message);
    } else {
        use_folder(a);
    }
    (void)pthread_mutex_lock(&world.mutex);
    a->is_done = true;
    const int left = count_left(-1);
    hand_to(left > 0 ? nth_left(decide(left), -1) : -1);
    (void)pthread_mutex_unlock(&world.mutex);
    return NULL;
}

/* ---- what must hold ---- */

static char *read_file(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    *bytes = (size_t)ftell(file);
    rewind(file);
    char *content = malloc(*bytes + 1);
    assert_non_null(content);
    assert_int_equal(fread(content, 1, *bytes, file), *bytes);
    (void)fclose(file);
    return content;
}

/* The order, for messages. */
static const char *order(void)
{
    static char text[2048];
    if (world.of == NULL) {
        return "killed";
    }
    int used = snprintf(text, sizeof text, "%s, leases %s, decisions", world.of->name,
                        world.leases_are_stale ? "stale" : "live");
    for (int i = 0; i < world.of->count && used < (int)sizeof text - 200; ++i) {
        used += snprintf(text + used, sizeof text - (size_t)used, " (%s %.100s)",
                         svo_name(SVO_NAME_STATUS, world.actors[i].status),
                         world.actors[i].status != SVO_OK ? world.actors[i].message.text : "");
    }
    for (int i = 0; i < world.step && used < (int)sizeof text - 16; ++i) {
        if (world.steps[i].chosen != 0) {
            used += snprintf(text + used, sizeof text - (size_t)used, " %d:%d", i, world.steps[i].chosen);
        }
    }
    return text;
}

/* The file is that of the plan, byte for byte. */
static void expect_file_of(const char *identity, const char *path)
{
    size_t bytes = 0;
    char *content = read_file(path, &bytes);
    const int mesh = strcmp(identity, world.identities[0]) == 0 ? 0 : 1;
    if (bytes != world.whole_bytes[mesh] || memcmp(content, world.whole[mesh], bytes) != 0) {
        fail_msg("%s: the file is not that of its plan", order());
    }
    free(content);
    (void)unlink(path);
}

/* Of one that stitches by shares while another does. */
static bool is_of_shares(const char *text)
{
    return strstr(text, "is not written") != NULL || strstr(text, "were finished meanwhile") != NULL ||
           strstr(text, "has not been begun") != NULL;
}

static void expect_words(const actor *a)
{
    const char *text = a->message.text;
    const bool plans = a->does == PLANS_A || a->does == PLANS_B;
    bool known = a->status == SVO_UNAVAILABLE && a->does == SHARES && is_of_shares(text);
    if (a->status == SVO_UNAVAILABLE && !world.leases_are_stale) {
        known = known || strstr(text, "its lease is less than") != NULL;
    } else if (a->status == SVO_UNAVAILABLE) {
        known = known || strstr(text, "the lease was broken") != NULL || strstr(text, "planned anew meanwhile") != NULL;
    } else if (a->status == SVO_FILE_ERROR && !plans) {
        known = !a->opened ? strstr(text, "plan: cannot be opened") != NULL
                           : a->does >= STITCHES && strstr(text, "is missing") != NULL;
    } else if (a->status == SVO_FILE_DAMAGED && a->does >= STITCHES) {
        known = strstr(text, " belongs to plan ") != NULL;
    }
    if (!known) {
        fail_msg("%s: process %d: %s: %s", order(), a->index, svo_name(SVO_NAME_STATUS, a->status), text);
    }
}

/* Nothing but the plan, its place and parts is left. */
static void expect_tidy(const char *identity)
{
    DIR *opened = opendir(world.folder);
    assert_non_null(opened);
    for (const struct dirent *entry = readdir(opened); entry != NULL; entry = readdir(opened)) {
        const char *name = entry->d_name;
        if (name[0] != '.' && strcmp(name, "plan") != 0 && strcmp(name, identity) != 0 &&
            strstr(name, ".part") == NULL) {
            fail_msg("%s: %s is left", order(), name);
        }
    }
    (void)closedir(opened);
}

/* Whoever comes next builds what is missing and stitches the tree of the plan that is there. */
static void expect_good_folder(void)
{
    svo_parts *parts = NULL;
    svo_message message;
    char identity[SVO_PARTS_IDENTITY_BYTES];
    char out[PATH_BYTES];
    (void)snprintf(out, sizeof out, "%s/next.svo", world.root);
    svo_status status = svo_parts_open(world.folder, &parts, &message);
    if (status == SVO_OK) {
        status = build_all(parts, &message);
    }
    if (status == SVO_OK) {
        status = svo_parts_finish(parts, out, &message);
    }
    if (status != SVO_OK) {
        fail_msg("%s: the next run: %s", order(), message.text);
    }
    assert_int_equal(svo_parts_get_identity(parts, identity, NULL), SVO_OK);
    svo_parts_close(&parts);
    expect_file_of(identity, out);
    expect_tidy(identity);
}

static void check_run(void)
{
    bool is_planned = world.of->begins_planned;
    for (int i = 0; i < world.of->count; ++i) {
        const actor *a = &world.actors[i];
        char out[PATH_BYTES];
        out_of(a, out);
        if (a->status != SVO_OK) {
            expect_words(a);
        } else if (a->does >= STITCHES) {
            expect_file_of(a->planned, out);
        }
        is_planned = is_planned || (a->status == SVO_OK && a->does <= PLANS_B);
    }
    if (is_planned) {
        expect_good_folder();
    }
}

/* ---- the search ---- */

static void build_folder(void)
{
    svo_parts *parts = NULL;
    svo_message message;
    assert_int_equal(svo_parts_open(world.folder, &parts, &message), SVO_OK);
    assert_int_equal(build_all(parts, &message), SVO_OK);
    svo_parts_close(&parts);
}

static void run_once(void)
{
    svo_message message;
    svo_status status = SVO_OK;
    if (world.of->begins_planned) {
        plan_folder(0, &status, &message);
        assert_int_equal(status, SVO_OK);
    }
    if (world.of->begins_built) {
        build_folder();
    }
    world.step = 0;
    world.interruptions = 0;
    world.running = -1;
    for (int i = 0; i < world.of->count; ++i) {
        world.actors[i] = (actor){.index = i, .does = world.of->roles[i]};
    }
    for (int i = 0; i < world.of->count; ++i) {
        assert_int_equal(pthread_create(&world.actors[i].thread, NULL, act, &world.actors[i]), 0);
    }
    (void)pthread_mutex_lock(&world.mutex);
    hand_to(nth_left(decide(count_left(-1)), -1));
    (void)pthread_mutex_unlock(&world.mutex);
    for (int i = 0; i < world.of->count; ++i) {
        (void)pthread_join(world.actors[i].thread, NULL);
    }
    check_run();
    assert_int_equal(svo_parts_remove(world.folder, NULL), SVO_OK);
}

/* Whether no other is tried in place of a decision. */
static bool is_left_out(int decided)
{
    return world.of->is_long && world.steps[decided].is_interruption && decided % LONG_STRIDE != 0 && !suite_is_long();
}

/* The order after the one that ran; false: it was the last. */
static bool next_order(void)
{
    int last = world.step - 1;
    while (last >= 0 && (is_left_out(last) || world.steps[last].chosen + 1 >= world.steps[last].count)) {
        --last;
    }
    if (last < 0) {
        return false;
    }
    ++world.steps[last].chosen;
    world.given_steps = last + 1;
    return true;
}

/* ---- the meshes ---- */

static void make_whole(int mesh)
{
    svo_plan *plan = NULL;
    svo_tree *tree = NULL;
    svo_message message;
    svo_parts *parts = NULL;
    char path[PATH_BYTES];
    (void)snprintf(path, sizeof path, "%s/whole.svo", world.root);
    assert_int_equal(svo_plan_create(world.opened.device, &world.meshes[mesh].mesh, DEPTH, &world.options, &plan),
                     SVO_OK);
    assert_int_equal(svo_build(plan, world.opened.frontend, world.opened.queue, &tree, NULL), SVO_OK);
    assert_int_equal(svo_tree_download(tree, world.opened.queue), SVO_OK);
    assert_int_equal(svo_tree_save(tree, svo_to_path(path), NULL, &message), SVO_OK);
    svo_tree_destroy(&tree);
    svo_plan_destroy(&plan);
    world.whole[mesh] = read_file(path, &world.whole_bytes[mesh]);
    (void)unlink(path);
    svo_status status = SVO_OK;
    plan_folder(mesh, &status, &message);
    assert_int_equal(status, SVO_OK);
    assert_int_equal(svo_parts_open(world.folder, &parts, &message), SVO_OK);
    assert_true(svo_parts_count(parts) > 1);
    assert_int_equal(svo_parts_get_identity(parts, world.identities[mesh], &message), SVO_OK);
    svo_parts_close(&parts);
    assert_int_equal(svo_parts_remove(world.folder, &message), SVO_OK);
}

/* Two meshes on one grid, one a little beside the other, so that a file of both would be one that readers take. */
static void prepare(void **state)
{
    if (world.whole[0] != NULL) {
        return;
    }
    world.opened = fixture_cl_of_group(state);
    world.options = (svo_plan_options)SVO_PLAN_OPTIONS_INIT;
    world.options.edge = 1.5;
    for (int i = 0; i < MESHES; ++i) {
        random_mesh(7, TRIANGLES, 0.0, &world.meshes[i]);
        for (size_t k = 0; k < 3 * world.meshes[i].mesh.vertex_count; k += 3) {
            world.meshes[i].positions[k] += i == 0 ? 0.0 : 0.002;
        }
        make_whole(i);
    }
}

static void search(void **state, const scenario *of)
{
    prepare(state);
    for (int stale = 0; stale < 2; ++stale) {
        uint64_t runs = 0;
        world.of = of;
        world.leases_are_stale = stale != 0;
        world.given_steps = 0;
        do {
            run_once();
            ++runs;
        } while (next_order());
        print_message("%s, leases %s: %llu orders\n", of->name, stale != 0 ? "stale" : "live",
                      (unsigned long long)runs);
    }
}

static void test_two_planners(void **state)
{
    static const scenario of = {"two planners", {PLANS_A, PLANS_B}, 2, 2, false, false, false, false};
    search(state, &of);
}

static void test_two_planners_of_one_plan(void **state)
{
    static const scenario of = {
        "two planners of the plan that is there", {PLANS_A, PLANS_A}, 2, 2, true, false, false, false};
    search(state, &of);
}

static void test_a_planner_and_a_builder(void **state)
{
    static const scenario of = {"a planner and a builder", {PLANS_B, BUILDS}, 2, 2, true, true, false, false};
    search(state, &of);
}

static void test_parts_of_two_plans(void **state)
{
    static const scenario of = {
        "a planner, a builder and a stitcher", {BUILDS, PLANS_B, STITCHES}, 3, 1, true, false, false, false};
    search(state, &of);
}

static void test_all_of_them(void **state)
{
    static const scenario of = {"two planners, two builders and a stitcher",
                                {BUILDS, PLANS_B, BUILDS, PLANS_A, STITCHES},
                                5,
                                1,
                                true,
                                true,
                                true,
                                false};
    search(state, &of);
}

static void test_two_stitch_by_shares(void **state)
{
    static const scenario of = {
        "a planner, and two that stitch by shares", {SHARES, PLANS_B, SHARES}, 3, 1, true, true, false, true};
    search(state, &of);
}

/* ---- processes that are killed ---- */

/* Stitches by three shares, and is killed before a call that changes a file. Returns whether it was. */
static bool is_killed(const svo_parts *parts, int calls, const char *out)
{
    int how = 0;
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        svo_message message;
        world.calls_left = calls;
        _exit(stitch_by_shares(parts, 3, out, &message) == SVO_OK ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_true(WIFSIGNALED(how) || WEXITSTATUS(how) == 0);
    return WIFSIGNALED(how);
}

/* Whenever it is killed, there is no file or the whole one, and the next try ends with the same bytes. */
static void test_killed_at_any_call(void **state)
{
    svo_parts *parts = NULL;
    svo_status status = SVO_OK;
    svo_message message;
    char out[PATH_BYTES];
    int calls = 0;
    prepare(state);
    world.of = NULL;
    plan_folder(0, &status, &message);
    assert_int_equal(status, SVO_OK);
    build_folder();
    (void)snprintf(out, sizeof out, "%s/killed.svo", world.root);
    assert_int_equal(svo_parts_open(world.folder, &parts, &message), SVO_OK);
    while (is_killed(parts, calls, out)) {
        if (access(out, F_OK) == 0) {
            expect_file_of(world.identities[0], out);
        }
        if (stitch_by_shares(parts, 3, out, &message) != SVO_OK) {
            fail_msg("after %d calls: %s", calls, message.text);
        }
        expect_file_of(world.identities[0], out);
        calls += !suite_is_long() ? LONG_STRIDE : 1;
    }
    print_message("killed at %d of its calls\n", calls);
    assert_true(calls > 50);
    expect_file_of(world.identities[0], out);
    svo_parts_close(&parts);
    assert_int_equal(svo_parts_remove(world.folder, NULL), SVO_OK);
}

static int setup(void **state)
{
    const char *where = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp";
    (void)snprintf(world.root, sizeof world.root, "%s/svocl-orders-XXXXXX", where);
    assert_non_null(mkdtemp(world.root));
    (void)snprintf(world.folder, sizeof world.folder, "%s/a.svo.parts", world.root);
    assert_int_equal(pthread_mutex_init(&world.mutex, NULL), 0);
    assert_int_equal(pthread_cond_init(&world.turn, NULL), 0);
    return fixture_group_setup(state);
}

static int teardown(void **state)
{
    for (int i = 0; i < MESHES; ++i) {
        free(world.whole[i]);
        owned_mesh_free(&world.meshes[i]);
    }
    return rmdir(world.root) == 0 ? fixture_group_teardown(state) : -1;
}

TEST_GROUP(parts_orders)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_two_planners),
        cmocka_unit_test(test_two_planners_of_one_plan),
        cmocka_unit_test(test_a_planner_and_a_builder),
        cmocka_unit_test(test_parts_of_two_plans),
        cmocka_unit_test(test_all_of_them),
        cmocka_unit_test(test_two_stitch_by_shares),
        cmocka_unit_test(test_killed_at_any_call),
    };
    return cmocka_run_group_tests_name("parts_orders", tests, setup, teardown);
}
