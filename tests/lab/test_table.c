/* SPDX-License-Identifier: MIT */
/* Tables of the program: columns are aligned by characters, not by bytes; lines wrap on a terminal only. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "support/suite.h"
#include "support/table.h"
#include "support/text.h"

#define TEXT_BYTES 4096

/* Replaces standard output by a file; returns the old one. */
static int redirect(int file)
{
    fflush(stdout);
    const int kept = dup(STDOUT_FILENO);
    assert_true(kept >= 0 && dup2(file, STDOUT_FILENO) >= 0);
    return kept;
}

static void restore(int kept)
{
    fflush(stdout);
    assert_true(dup2(kept, STDOUT_FILENO) >= 0);
    close(kept);
}

/* What table_print writes into a file. */
static void print_into_file(table *rows, char text[TEXT_BYTES])
{
    FILE *file = tmpfile();
    assert_non_null(file);
    const int kept = redirect(fileno(file));
    table_print(rows);
    restore(kept);
    rewind(file);
    text[fread(text, 1, TEXT_BYTES - 1, file)] = '\0';
    fclose(file);
}

/* What it writes to a terminal that is so many columns wide, with line feeds for the terminal's line ends. */
static void print_on_terminal(table *rows, unsigned short columns, char text[TEXT_BYTES])
{
    const struct winsize window = {.ws_row = 25, .ws_col = columns};
    const int screen = posix_openpt(O_RDWR | O_NOCTTY);
    if (screen < 0 || grantpt(screen) != 0 || unlockpt(screen) != 0) {
        print_message("skipped: no pseudo-terminal\n");
        skip();
    }
    const int terminal = open(ptsname(screen), O_RDWR | O_NOCTTY);
    assert_true(terminal >= 0);
    assert_int_equal(ioctl(terminal, TIOCSWINSZ, &window), 0);
    const int kept = redirect(terminal);
    table_print(rows);
    puts("end");
    restore(kept);
    size_t used = 0;
    do {
        const ssize_t got = read(screen, text + used, TEXT_BYTES - 1 - used);
        assert_true(got > 0);
        used += (size_t)got;
        text[used] = '\0';
    } while (strstr(text, "end\r\n") == NULL);
    *strstr(text, "end\r\n") = '\0';
    for (char *end = strstr(text, "\r\n"); end != NULL; end = strstr(end, "\r\n")) {
        memmove(end, end + 1, strlen(end));
    }
    close(terminal);
    close(screen);
}

static void columns_are_aligned_by_characters(void **state)
{
    (void)state;
    char text[TEXT_BYTES];
    table *rows = table_create("lrl");
    static const char *const cells[] = {"Möller", "1", "ß", "plain text", "10⁻⁸", "x", "ab", "22", "yz"};
    for (size_t i = 0; i < sizeof cells / sizeof cells[0]; ++i) {
        table_cell(rows, "%s", cells[i]);
    }
    print_into_file(rows, text);
    assert_string_equal(text, "  Möller         1  ß\n"
                              "  plain text  10⁻⁸  x\n"
                              "  ab            22  yz\n");
}

/* The wrapped cell has 20 characters in 40 bytes; 30 columns leave room for 22 of its characters. */
static void wrapping_counts_characters(void **state)
{
    (void)state;
    char text[TEXT_BYTES];
    table *rows = table_create("ll");
    table_cell(rows, "name");
    table_cell(rows, "ääääääääääääääääääää");
    table_cell(rows, "more");
    table_cell(rows, "ööööööööö ööööööööö ööööööööö");
    print_on_terminal(rows, 30, text);
    assert_string_equal(text, "  name  ääääääääääääääääääää\n"
                              "  more  ööööööööö ööööööööö\n"
                              "        ööööööööö\n");
}

/* A word that is longer than the line is cut between two characters. */
static void wrapping_cuts_no_character(void **state)
{
    (void)state;
    char text[TEXT_BYTES];
    table *rows = table_create("l");
    table_cell(rows, "€€€€€€€€€€€€€€€€€€€€€€€€€€€€€€");
    print_on_terminal(rows, 27, text);
    assert_string_equal(text, "  €€€€€€€€€€€€€€€€€€€€€€€€€\n"
                              "  €€€€€\n");
}

static void files_get_one_line_per_row(void **state)
{
    (void)state;
    char text[TEXT_BYTES];
    char words[400] = "";
    for (size_t i = 0; i < 60; ++i) {
        memcpy(words + 6 * i, "words ", 7);
    }
    table *rows = table_create("l");
    table_cell(rows, "%s", words);
    print_into_file(rows, text);
    assert_int_equal(strcspn(text, "\n") + 1, strlen(text));
    assert_non_null(strstr(text, words));
}

static void figures_are_readable(void **state)
{
    (void)state;
    assert_string_equal(figure_count(0).text, "0");
    assert_string_equal(figure_count(999).text, "999");
    assert_string_equal(figure_count(1167738).text, "1,167,738");
    assert_string_equal(figure_count(UINT64_MAX).text, "18,446,744,073,709,551,615");
    assert_string_equal(figure_bytes(1).text, "1 byte");
    assert_string_equal(figure_bytes(1023).text, "1023 bytes");
    assert_string_equal(figure_bytes(1536).text, "1.5 KiB");
    assert_string_equal(figure_bytes(UINT64_C(1) << 50).text, "1024.0 TiB");
    assert_string_equal(figure_rate(6.21e6).text, "6.21 M/s");
    assert_string_equal(figure_rate(999).text, "999.00 /s");
    assert_string_equal(figure_needs(0).text, "none");
}

/* As NVIDIA's compiler writes it. */
static void logs_have_registers(void **state)
{
    static const char log[] = "ptxas info    : 0 bytes gmem\n"
                              "ptxas info    : Compiling entry function 'svo_k_trace_voxels' for 'sm_90'\n"
                              "ptxas info    : Function properties for svo_k_trace_voxels\n"
                              "ptxas         .     0 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads\n"
                              "ptxas info    : Used 64 registers, 424 bytes cmem[0]\n"
                              "ptxas info    : Compiling entry function 'svo_k_silent' for 'sm_90'\n"
                              "ptxas info    : Compiling entry function 'svo_k_trace' for 'sm_90'\n"
                              "ptxas info    : Used 118 registers, 440 bytes cmem[0]\n";
    (void)state;
    assert_int_equal(log_registers(log, "svo_k_trace_voxels"), 64);
    assert_int_equal(log_registers(log, "svo_k_trace"), 118);
    assert_int_equal(log_registers(log, "svo_k_silent"), 0);
    assert_int_equal(log_registers(log, "svo_k_other"), 0);
    assert_int_equal(log_registers("", "svo_k_trace"), 0);
}

TEST_GROUP(table)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(columns_are_aligned_by_characters),
        cmocka_unit_test(wrapping_counts_characters),
        cmocka_unit_test(wrapping_cuts_no_character),
        cmocka_unit_test(files_get_one_line_per_row),
        cmocka_unit_test(figures_are_readable),
        cmocka_unit_test(logs_have_registers),
    };
    return cmocka_run_group_tests_name("table", tests, NULL, NULL);
}
