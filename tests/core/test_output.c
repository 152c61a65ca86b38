/* SPDX-License-Identifier: MIT */
/*
 * Files that are written whole or not at all: what a path leads to, what is left behind by whom, with files without a
 * name and, as on file systems that lack them, with temporary names.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "output/output.h"
#include "support/suite.h"

#define TEXT_BYTES 256

static char folder[] = "/tmp/svocl_output_XXXXXX";
static bool without_tmpfile;

/* NOLINTBEGIN(readability-identifier-naming) */
int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, mode_t mode);

int __wrap_open(const char *path, int flags, mode_t mode)
{
    if (without_tmpfile && (flags & O_TMPFILE) == O_TMPFILE) {
        errno = EOPNOTSUPP;
        return -1;
    }
    return __real_open(path, flags, mode);
}
/* NOLINTEND(readability-identifier-naming) */

static int save(const char *path, const char *text)
{
    svo_i_output output;
    int error = svo_i_output_open(path, NULL, &output);
    if (error == 0) {
        error = svo_i_output_write(&output, text, strlen(text));
    }
    if (error == 0) {
        return svo_i_output_commit(&output);
    }
    svo_i_output_abandon(&output);
    return error;
}

static void expect_text(const char *path, const char *text)
{
    char found[TEXT_BYTES] = "";
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    found[fread(found, 1, sizeof found - 1, file)] = '\0';
    assert_int_equal(fclose(file), 0);
    assert_string_equal(found, text);
}

static bool is_link(const char *path)
{
    struct stat entry;
    return lstat(path, &entry) == 0 && S_ISLNK(entry.st_mode);
}

/* How many entries the folder has. */
static size_t count_entries(void)
{
    size_t count = 0;
    DIR *opened = opendir(".");
    assert_non_null(opened);
    for (const struct dirent *entry = readdir(opened); entry != NULL; entry = readdir(opened)) {
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    }
    closedir(opened);
    return count;
}

static int enter_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) == NULL || chdir(folder) != 0;
}

static int empty_folder(void **state)
{
    (void)state;
    without_tmpfile = false;
    return system("rm -rf ./* ./.svocl*");
}

static int leave_folder(void **state)
{
    (void)state;
    return chdir("/") != 0 || rmdir(folder) != 0;
}

/* ---- what paths lead to ---- */

static void files_are_made_and_replaced(void **state)
{
    (void)state;
    for (int i = 0; i < 2; ++i) {
        without_tmpfile = i == 1;
        assert_int_equal(save("a", "first"), 0);
        expect_text("a", "first");
        assert_int_equal(save("a", "second"), 0);
        expect_text("a", "second");
        assert_int_equal(save("./a", "third"), 0);
        expect_text("a", "third");
        assert_int_equal(count_entries(), 1);
        assert_int_equal(unlink("a"), 0);
    }
}

/* A name as long as the file system allows leaves no room for more. */
static void the_longest_name_is_good(void **state)
{
    (void)state;
    char name[NAME_MAX + 1];
    memset(name, 'n', NAME_MAX);
    name[NAME_MAX] = '\0';
    for (int i = 0; i < 2; ++i) {
        without_tmpfile = i == 1;
        assert_int_equal(save(name, "first"), 0);
        assert_int_equal(save(name, "second"), 0);
        expect_text(name, "second");
    }
}

static void links_stay_and_their_targets_are_written(void **state)
{
    (void)state;
    assert_int_equal(mkdir("data", 0777), 0);
    assert_int_equal(symlink("data/a", "relative"), 0);
    assert_int_equal(symlink("../relative", "data/chain"), 0);
    for (int i = 0; i < 2; ++i) {
        without_tmpfile = i == 1;
        assert_int_equal(save("relative", "through one"), 0); /* leads nowhere the first time */
        expect_text("data/a", "through one");
        assert_int_equal(save("data/chain", "through two"), 0);
        expect_text("data/a", "through two");
        assert_true(is_link("relative") && is_link("data/chain"));
        assert_int_equal(unlink("data/a"), 0);
    }
    assert_int_equal(symlink("circle", "circle"), 0);
    assert_int_equal(save("circle", "x"), ELOOP);
    assert_int_equal(symlink("data", "folder"), 0);
    assert_int_equal(save("folder", "x"), EISDIR);
    assert_int_equal(save("folder/b", "in a folder"), 0);
    expect_text("data/b", "in a folder");
}

static void descriptors_are_written_where_they_stand(void **state)
{
    (void)state;
    char path[64];
    const int file = open("log", O_RDWR | O_CREAT | O_APPEND, 0666);
    assert_true(file >= 0);
    assert_int_equal(write(file, "before,", 7), 7);
    (void)snprintf(path, sizeof path, "/dev/fd/%d", file);
    assert_int_equal(svo_i_output_descriptor_of(path), file);
    assert_int_equal(symlink(path, "link"), 0);
    assert_int_equal(svo_i_output_check("link"), 0);
    assert_int_equal(save("link", "through a link,"), 0);
    assert_int_equal(save(path, "straight,"), 0);
    (void)snprintf(path, sizeof path, "/proc/thread-self/fd/%d", file);
    assert_int_equal(save(path, "by thread,"), 0);
    assert_int_equal(write(file, "after", 5), 5);
    assert_int_equal(close(file), 0);
    expect_text("log", "before,through a link,straight,by thread,after");
    assert_true(is_link("link"));
    assert_int_equal(svo_i_output_descriptor_of("log"), -1);
    const int reading = open("log", O_RDONLY);
    (void)snprintf(path, sizeof path, "/dev/fd/%d", reading);
    assert_int_equal(svo_i_output_check(path), EBADF);
    assert_int_equal(save(path, "x"), EBADF);
    assert_int_equal(close(reading), 0);
}

static void devices_and_pipes_are_written_straight(void **state)
{
    (void)state;
    char text[TEXT_BYTES] = "";
    assert_int_equal(symlink("/dev/null", "nowhere"), 0);
    assert_int_equal(save("nowhere", "x"), 0);
    assert_true(is_link("nowhere"));
    assert_int_equal(mkfifo("pipe", 0600), 0);
    const int reading = open("pipe", O_RDONLY | O_NONBLOCK);
    assert_true(reading >= 0);
    assert_int_equal(svo_i_output_check("pipe"), 0);
    assert_int_equal(save("pipe", "through a pipe"), 0);
    assert_int_equal(read(reading, text, sizeof text - 1), 14);
    assert_string_equal(text, "through a pipe");
    assert_int_equal(close(reading), 0);
    struct stat entry;
    assert_int_equal(stat("pipe", &entry), 0);
    assert_true(S_ISFIFO(entry.st_mode));
    if (access("/dev/full", W_OK) == 0) {
        assert_int_equal(save("/dev/full", "x"), ENOSPC);
    }
}

/* SIGPIPE would end the process. */
static void a_reader_that_is_gone_is_an_error(void **state)
{
    (void)state;
    int ends[2];
    svo_i_output output;
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(close(ends[0]), 0);
    assert_int_equal(svo_i_output_open_descriptor(ends[1], &output), 0);
    assert_int_equal(svo_i_output_write(&output, "x", 1), EPIPE);
    svo_i_output_abandon(&output);
    sigset_t pending;
    assert_int_equal(sigpending(&pending), 0);
    assert_int_equal(sigismember(&pending, SIGPIPE), 0);
    assert_int_equal(close(ends[1]), 0);
}

static void what_cannot_be_written_is_known_beforehand(void **state)
{
    (void)state;
    assert_int_equal(save("file", ""), 0);
    static const struct {
        const char *path;
        int error;
    } rows[] = {{"", ENOENT}, {"nowhere/a", ENOENT}, {"file/a", ENOTDIR}, {".", EISDIR}, {"nowhere/", ENOENT}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        assert_int_equal(svo_i_output_check(rows[i].path), rows[i].error);
        assert_int_equal(save(rows[i].path, "x"), rows[i].error);
    }
    assert_int_equal(svo_i_output_check("new"), 0);
    assert_int_equal(svo_i_output_check("file"), 0);
    assert_int_equal(count_entries(), 1);
}

static void a_replaced_file_keeps_its_permissions(void **state)
{
    (void)state;
    for (int i = 0; i < 2; ++i) {
        struct stat entry;
        without_tmpfile = i == 1;
        assert_int_equal(save("secret", "first"), 0);
        assert_int_equal(chmod("secret", 0600), 0);
        assert_int_equal(save("secret", "second"), 0);
        assert_int_equal(stat("secret", &entry), 0);
        assert_int_equal(entry.st_mode & 0777, 0600);
        assert_int_equal(unlink("secret"), 0);
    }
}

/* ---- what is left behind ---- */

static void abandoned_files_leave_nothing(void **state)
{
    (void)state;
    for (int i = 0; i < 2; ++i) {
        svo_i_output output;
        without_tmpfile = i == 1;
        assert_int_equal(svo_i_output_open("a", NULL, &output), 0);
        assert_int_equal(svo_i_output_write(&output, "half", 4), 0);
        svo_i_output_abandon(&output);
        svo_i_output_abandon(&output);
        assert_int_equal(count_entries(), 0);
    }
}

/* A folder that took the place of the file meanwhile. */
static void a_failed_rename_leaves_nothing(void **state)
{
    (void)state;
    for (int i = 0; i < 2; ++i) {
        svo_i_output output;
        without_tmpfile = i == 1;
        assert_int_equal(svo_i_output_open("a", NULL, &output), 0);
        assert_int_equal(mkdir("a", 0777), 0);
        assert_int_equal(svo_i_output_commit(&output), EISDIR);
        assert_int_equal(count_entries(), 1);
        assert_int_equal(rmdir("a"), 0);
    }
}

static void a_killed_process_leaves_nothing(void **state)
{
    (void)state;
    const int probe = open(".", O_TMPFILE | O_WRONLY, 0600);
    if (probe < 0) {
        print_message("skipped: this file system has no O_TMPFILE\n");
        skip();
    }
    assert_int_equal(close(probe), 0);
    const pid_t child = fork();
    if (child == 0) {
        svo_i_output output;
        if (svo_i_output_open("a", NULL, &output) == 0 && svo_i_output_write(&output, "half", 4) == 0) {
            (void)raise(SIGKILL);
        }
        _exit(1);
    }
    int ended = 0;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == SIGKILL);
    assert_int_equal(count_entries(), 0);
}

/* What a watch was told, against what is there. */
typedef struct witness {
    bool held;
    size_t calls;
    char name[TEXT_BYTES];
} witness;

static void note_hold(void *user)
{
    witness *seen = user;
    assert_false(seen->held);
    seen->held = true;
}

static void note_release(void *user, const char *temporary)
{
    witness *seen = user;
    assert_true(seen->held);
    seen->held = false;
    ++seen->calls;
    (void)snprintf(seen->name, sizeof seen->name, "%s", temporary != NULL ? temporary : "");
    assert_true(temporary == NULL || access(temporary, F_OK) == 0);
}

static void temporary_names_are_told(void **state)
{
    (void)state;
    witness seen = {.calls = 0};
    const svo_i_output_watch watch = {.hold = note_hold, .release = note_release, .user = &seen};
    svo_i_output output;
    without_tmpfile = true;
    assert_int_equal(svo_i_output_open("a", &watch, &output), 0);
    assert_true(strlen(seen.name) > 0);
    assert_int_equal(svo_i_output_commit(&output), 0);
    assert_string_equal(seen.name, "");
    assert_int_equal(seen.calls, 2);
    assert_int_equal(svo_i_output_open("a", &watch, &output), 0);
    svo_i_output_abandon(&output);
    assert_string_equal(seen.name, "");
    assert_int_equal(seen.calls, 4);
    assert_int_equal(count_entries(), 1);
}

TEST_GROUP(output)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(files_are_made_and_replaced, empty_folder),
        cmocka_unit_test_teardown(the_longest_name_is_good, empty_folder),
        cmocka_unit_test_teardown(links_stay_and_their_targets_are_written, empty_folder),
        cmocka_unit_test_teardown(descriptors_are_written_where_they_stand, empty_folder),
        cmocka_unit_test_teardown(devices_and_pipes_are_written_straight, empty_folder),
        cmocka_unit_test_teardown(a_reader_that_is_gone_is_an_error, empty_folder),
        cmocka_unit_test_teardown(what_cannot_be_written_is_known_beforehand, empty_folder),
        cmocka_unit_test_teardown(a_replaced_file_keeps_its_permissions, empty_folder),
        cmocka_unit_test_teardown(abandoned_files_leave_nothing, empty_folder),
        cmocka_unit_test_teardown(a_failed_rename_leaves_nothing, empty_folder),
        cmocka_unit_test_teardown(a_killed_process_leaves_nothing, empty_folder),
        cmocka_unit_test_teardown(temporary_names_are_told, empty_folder),
    };
    return cmocka_run_group_tests_name("output", tests, enter_folder, leave_folder);
}
