/* SPDX-License-Identifier: MIT */
/* Tables of results: written JSON reads back unchanged, and invalid text is refused with the reason. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure/result.h"
#include "measure/result_json.h"
#include "measure/result_text.h"
#include "measure/spread.h"
#include "support/suite.h"

/* Two tables: one with every kind of cell, one without rows. */
static result_set *make_set(void)
{
    result_set *set = result_create();
    assert_non_null(set);
    set->machine.cpu_threads = 2;
    result_set_fact(set, &set->machine.device, "PoCL \"quoted\"");
    result_set_fact(set, &set->machine.driver, "3.1");
    result_set_fact(set, &set->machine.renderer, "none");
    result_table *table = result_add_table(set, "voxelize", "Front ends", "medians, wall clock");
    result_add_column(table, "scene", "");
    result_add_column(table, "median", "ms");
    result_add_text(table, "%s:%d", "knot", 3000);
    result_add_number(table, 0.1);
    result_add_text(table, "comma, and \"quotes\"");
    result_add_absent(table);
    result_add_text(table, "not finite");
    result_add_number(table, NAN);
    result_add_column(result_add_table(set, "empty", "No rows", ""), "only", "B");
    return set;
}

static char *text_of_set(const result_set *set)
{
    cJSON *document = result_to_json(set);
    assert_non_null(document);
    char *text = cJSON_Print(document);
    assert_non_null(text);
    cJSON_Delete(document);
    return text;
}

static void test_round_trip(void **state)
{
    (void)state;
    result_set *set = make_set();
    char *text = text_of_set(set);
    svo_message message = {""};
    result_set *again = result_parse(text, &message);
    if (again == NULL) {
        fail_msg("refused: %s", message.text);
        return;
    }
    char *text_again = text_of_set(again);
    assert_string_equal(text_again, text);

    const result_table *table = result_find(again, "voxelize");
    assert_non_null(table);
    assert_int_equal(result_row_count(table), 3);
    assert_int_equal(result_find_column(table, "median"), 1);
    assert_int_equal(result_find_column(table, "nothing"), 2);
    assert_string_equal(result_cell_at(table, 0, 0)->text, "knot:3000");
    assert_true(result_cell_at(table, 0, 1)->number == 0.1);
    assert_int_equal(result_cell_at(table, 1, 1)->kind, RESULT_ABSENT);
    assert_int_equal(result_cell_at(table, 2, 1)->kind, RESULT_ABSENT);
    assert_null(result_cell_at(table, 3, 0));
    assert_null(result_cell_at(table, 0, 2));
    assert_int_equal(again->machine.cpu_threads, 2);
    assert_string_equal(again->machine.device, "PoCL \"quoted\"");
    assert_null(result_find(again, "nothing"));
    cJSON_free(text);
    cJSON_free(text_again);
    result_destroy(&again);
    result_destroy(&set);
}

static void test_csv_quotes_special_characters(void **state)
{
    (void)state;
    result_set *set = make_set();
    FILE *file = tmpfile();
    assert_non_null(file);
    result_write_csv(result_find(set, "voxelize"), file);
    rewind(file);
    char text[512] = "";
    assert_true(fread(text, 1, sizeof text - 1, file) > 0);
    fclose(file);
    assert_string_equal(text,
                        "scene,median [ms]\r\nknot:3000,0.1\r\n\"comma, and \"\"quotes\"\"\",\r\nnot finite,\r\n");
    result_destroy(&set);
}

static void test_unfinished_row_is_not_written(void **state)
{
    (void)state;
    result_set *set = make_set();
    result_add_text(result_find(set, "voxelize"), "half a row");
    assert_false(result_is_whole(set));
    assert_null(result_to_json(set));
    result_destroy(&set);
}

static void test_take_replaces_by_id(void **state)
{
    (void)state;
    result_set *set = make_set();
    result_set *other = result_create();
    assert_non_null(other);
    result_add_column(result_add_table(other, "voxelize", "Newer", ""), "one", "");
    result_add_column(result_add_table(other, "rays", "Further", ""), "one", "");
    result_take(set, other);
    result_destroy(&other);
    assert_int_equal(set->table_count, 3);
    assert_string_equal(set->tables[0]->title, "Newer");
    assert_string_equal(set->tables[2]->id, "rays");
    assert_ptr_equal(set->tables[2]->owner, set);
    assert_true(result_is_whole(set));
    result_destroy(&set);
}

static void test_quartiles_by_hand(void **state)
{
    (void)state;
    double five[] = {40, 10, 30, 20, 50};
    const spread odd = spread_of(five, 5);
    assert_true(odd.low == 20 && odd.median == 30 && odd.high == 40);
    double four[] = {4, 2, 1, 3};
    const spread even = spread_of(four, 4);
    assert_true(even.low == 1.75 && even.median == 2.5 && even.high == 3.25);
    const spread one = spread_of(four, 1);
    assert_true(one.low == 1 && one.median == 1 && one.high == 1);
    assert_true(isnan(spread_of(four, 0).median));

    result_set *set = result_create();
    assert_non_null(set);
    result_table *table = result_add_table(set, "t", "", "");
    result_add_column(table, "scene", "");
    spread_add_columns(table, "time", "ms");
    result_add_text(table, "cube");
    spread_add(table, even);
    assert_false(result_has_quartiles(table, 0));
    assert_true(result_has_quartiles(table, 1));
    assert_false(result_has_quartiles(table, 2));
    assert_true(result_cell_at(table, 0, 2)->number == 1.75);
    assert_true(result_is_whole(set));
    result_destroy(&set);
}

#define MACHINE                                                                                                     \
    "\"machine\":{\"device\":\"\",\"driver\":\"\",\"platform\":\"\",\"renderer\":\"\",\"cpu_threads\":1,\"svocl\":" \
    "\"\"}"
#define TABLE(columns, rows) \
    "{" MACHINE ",\"tables\":[{\"id\":\"a\",\"title\":\"\",\"note\":\"\",\"columns\":" columns ",\"rows\":" rows "}]}"
#define ONE_COLUMN "[{\"name\":\"n\",\"unit\":\"\"}]"

static void test_invalid_results_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"", "not JSON"},
        {"[]", "tables"},
        {"{\"tables\":[]}", "cpu_threads"},
        {"{\"machine\":{\"cpu_threads\":-1},\"tables\":[]}", "cpu_threads"},
        {"{\"machine\":{\"cpu_threads\":1},\"tables\":[]}", "device"},
        {"{" MACHINE ",\"tables\":[{\"id\":\"a\"}]}", "title"},
        {TABLE("7", "[]"), "columns"},
        {TABLE("[]", "[]"), "no columns"},
        {TABLE("[{\"name\":\"n\"}]", "[]"), "unit"},
        {TABLE(ONE_COLUMN, "{}"), "rows"},
        {TABLE(ONE_COLUMN, "[[1,2]]"), "1 cells"},
        {TABLE(ONE_COLUMN, "[7]"), "1 cells"},
        {TABLE(ONE_COLUMN, "[[true]]"), "cell"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        svo_message message = {""};
        if (result_parse(cases[i].text, &message) != NULL) {
            fail_msg("taken: %s", cases[i].text);
        }
        if (strstr(message.text, cases[i].words) == NULL) {
            fail_msg("%s: '%s' is not in '%s'", cases[i].text, cases[i].words, message.text);
        }
    }
    svo_message message = {""};
    result_set *set = result_parse(TABLE(ONE_COLUMN, "[[1],[null],[\"x\"]]"), &message);
    assert_non_null(set);
    assert_int_equal(result_row_count(result_find(set, "a")), 3);
    result_destroy(&set);
}

TEST_GROUP(result)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_csv_quotes_special_characters),
        cmocka_unit_test(test_unfinished_row_is_not_written),
        cmocka_unit_test(test_take_replaces_by_id),
        cmocka_unit_test(test_invalid_results_are_refused),
        cmocka_unit_test(test_quartiles_by_hand),
    };
    return cmocka_run_group_tests_name("result", tests, NULL, NULL);
}
