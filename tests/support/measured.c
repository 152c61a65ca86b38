/* SPDX-License-Identifier: MIT */
/* Builds once to record programs and a second time to record memory, and compares two such builds. */
#include "measured.h"
#include "support/info_of.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* The result that the running measured_build fills. */
static measured *current;

/* Records the plan's figures before the build. */
static void take_plan(const svo_plan *plan)
{
    const svo_plan_info info = info_of_plan(plan);
    current->planned_peak_bytes = info.peak_bytes;
    current->planned_tree_bytes = info.tree_bytes;
    current->left_out_count = info.left_out_count;
    assert_in_range(current->left_out_count, 0, MEASURED_LEFT_OUT_MAX);
    for (size_t i = 0; i < current->left_out_count; ++i) {
        svo_left_out entry = SVO_LEFT_OUT_INIT;
        svo_plan_get_left_out(plan, i, &entry);
        const char *space = strchr(entry.reason, ' ');
        if (strlen(entry.what) == 0 || space == NULL || strchr(space + 1, ' ') == NULL || strchr(entry.reason, '\n')) {
            fail_msg("left out: '%s' because '%s', which is not one short line", entry.what, entry.reason);
        }
        current->left_out[i].what = entry.what;
        snprintf(current->left_out[i].reason.text, sizeof current->left_out[i].reason.text, "%s", entry.reason);
    }
}

/* Where a text goes on after another one; NULL where it does not begin with it. */
static const char *after(const char *text, const char *begin)
{
    return strncmp(text, begin, strlen(begin)) == 0 ? text + strlen(begin) : NULL;
}

static bool plan_has_program(const svo_plan *plan, const char *options)
{
    bool found = false;
    const char *given = after(options, "-cl-std=CL1.2");
    const char *beyond = given != NULL ? after(given, " -cl-fp32-correctly-rounded-divide-sqrt") : NULL;
    given = beyond != NULL ? beyond : given;
    for (size_t i = 0; i < info_of_plan(plan).kernels_count; ++i) {
        svo_kernels_info kernels = SVO_KERNELS_INFO_INIT;
        svo_plan_get_kernels(plan, i, &kernels);
        const char *rest = given != NULL ? after(given, kernels.defines) : NULL;
        /* What core/program.c adds for PoCL 3. */
        found = found || (rest != NULL && (rest[0] == '\0' || strcmp(rest, " -D_OPENCL_H_") == 0));
    }
    return found;
}

/* The programs compiled since counting_begin are exactly those that the plan lists. */
static void take_programs(const svo_plan *plan)
{
    const counted compiled = counting_read();
    for (size_t i = 0; i < compiled.builds; ++i) {
        const size_t defines_used = strlen(current->defines);
        const size_t kernels_used = strlen(current->kernels);
        if (!plan_has_program(plan, counting_options(i))) {
            fail_msg("a program was compiled with %s, which the plan does not list", counting_options(i));
        }
        snprintf(current->defines + defines_used, sizeof current->defines - defines_used, " %s ", counting_options(i));
        snprintf(current->kernels + kernels_used, sizeof current->kernels - kernels_used, ";%s;", counting_kernels(i));
    }
    assert_int_equal(compiled.builds, info_of_plan(plan).kernels_count);
    assert_int_equal(compiled.programs, compiled.builds);
    current->programs = compiled.programs;
    current->built_kernels = compiled.built_kernels;
}

/* The buffers allocated since counting_begin, by a build that compiled nothing, are exactly the plan's list. Several
   may be parts of one. */
static void take_memory(const svo_plan *plan)
{
    const counted allocated = counting_read();
    uint64_t bytes = 0;
    uint64_t count = 0;
    for (size_t i = 0; i < info_of_plan(plan).buffer_count; ++i) {
        svo_buffer_info buffer = SVO_BUFFER_INFO_INIT;
        svo_plan_get_buffer(plan, i, &buffer);
        assert_int_equal(buffer.certainty, SVO_BYTES_EXACT);
        bytes += buffer.bytes;
        count += buffer.count;
    }
    assert_int_equal(allocated.builds, 0);
    assert_in_range(allocated.buffers, 1, count);
    assert_in_range(allocated.buffers + allocated.sub_buffers, count, 2 * count);
    assert_int_equal(allocated.total_bytes, bytes);
    assert_int_equal(allocated.peak_bytes, info_of_plan(plan).peak_bytes);
    assert_int_equal(allocated.live_bytes, info_of_plan(plan).tree_bytes);
    current->peak_bytes = allocated.peak_bytes;
    current->tree_bytes = allocated.live_bytes;
}

/* Compiling a kernel includes a warm-up on separate buffers, so memory is counted in a second build. */
static svo_status build_twice(const fixture *opened, svo_plan *plan, svo_tree **out, svo_build_report *report)
{
    svo_tree *first = NULL;
    take_plan(plan);
    counting_begin();
    svo_status status = svo_build(plan, opened->frontend, opened->queue, &first, NULL);
    svo_tree_destroy(&first);
    if (status != SVO_OK) {
        return status;
    }
    assert_int_equal(counting_read().live_buffers, 0); /* the first build released everything */
    take_programs(plan);
    counting_begin();
    status = svo_build(plan, opened->frontend, opened->queue, out, report);
    if (status == SVO_OK) {
        take_memory(plan);
    }
    return status;
}

/* The build kept within the plan's sizes, unless it had to grow. */
static void assert_plan_sufficed(const measured *made)
{
    if (made->result.report.reruns == 0 &&
        (made->planned_peak_bytes < made->peak_bytes || made->planned_tree_bytes < made->tree_bytes)) {
        fail_msg("planned: %llu bytes, %llu of them for the tree; used: %llu, %llu for the tree",
                 (unsigned long long)made->planned_peak_bytes, (unsigned long long)made->planned_tree_bytes,
                 (unsigned long long)made->peak_bytes, (unsigned long long)made->tree_bytes);
    }
}

void measured_build(const svo_mesh *mesh, unsigned depth, const svo_plan_options *options, measured *out)
{
    *out = (measured){.programs = 0};
    current = out;
    fixture_open_cl(&(fixture_options){0}, &out->opened);
    fixture_build_by(&out->opened, mesh, depth, options, build_twice, &out->result);
    current = NULL;
    assert_plan_sufficed(out);
}

void measured_destroy(measured *made)
{
    built_destroy(&made->result);
    fixture_close(&made->opened);
}

const char *measured_left_out(const measured *made, const char *what)
{
    for (size_t i = 0; i < made->left_out_count; ++i) {
        if (strcmp(made->left_out[i].what, what) == 0) {
            return made->left_out[i].reason.text;
        }
    }
    return NULL;
}

bool measured_has_define(const measured *made, const char *define)
{
    char option[64];
    snprintf(option, sizeof option, " -D%s ", define);
    return strstr(made->defines, option) != NULL;
}

bool measured_has_kernel(const measured *made, const char *name)
{
    char entry[64];
    snprintf(entry, sizeof entry, ";%s;", name);
    return strstr(made->kernels, entry) != NULL;
}

const svo_buffer_info *measured_buffer(const measured *made, const char *name)
{
    for (size_t i = 0; i < made->result.buffer_count; ++i) {
        if (strcmp(made->result.buffers[i].name, name) == 0) {
            return &made->result.buffers[i];
        }
    }
    return NULL;
}

size_t measured_array_bytes(const measured *made, svo_tree_buffer array)
{
    const cl_mem buffer = svo_tree_get_buffer(made->result.tree, array);
    size_t bytes = 0;
    if (buffer != NULL) {
        assert_int_equal(clGetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof bytes, &bytes, NULL), CL_SUCCESS);
    }
    return bytes;
}

static void assert_figure(const char *name, uint64_t less, uint64_t full, bool strictly)
{
    if (strictly ? less >= full : less > full) {
        fail_msg("%s: %llu, which is not %s %llu", name, (unsigned long long)less, strictly ? "below" : "at most",
                 (unsigned long long)full);
    }
}

void assert_takes_less(const measured *less, const measured *full, unsigned gains)
{
    const bool peak = (gains & FEWER_PEAK_BYTES) != 0;
    const bool tree = (gains & FEWER_TREE_BYTES) != 0;
    assert_figure("planned peak bytes", less->planned_peak_bytes, full->planned_peak_bytes, peak);
    if ((gains & SAME_PEAK_BYTES) != 0) {
        assert_int_equal(less->peak_bytes, full->peak_bytes);
    } else {
        assert_figure("peak bytes", less->peak_bytes, full->peak_bytes, peak);
    }
    assert_figure("planned tree bytes", less->planned_tree_bytes, full->planned_tree_bytes, tree);
    assert_figure("tree bytes", less->tree_bytes, full->tree_bytes, tree);
    assert_figure("programs", less->programs, full->programs, (gains & FEWER_PROGRAMS) != 0);
    assert_figure("kernels", less->built_kernels, full->built_kernels, (gains & FEWER_KERNELS) != 0);
    if ((gains & OTHER_DEFINES) != 0) {
        assert_string_not_equal(less->defines, full->defines);
    }
}

/* Compares one array of two trees, where both have it. */
static void assert_same_array(const char *name, const void *a, const void *b, uint64_t count, size_t element_bytes)
{
    if (a != NULL && b != NULL && memcmp(a, b, (size_t)count * element_bytes) != 0) {
        fail_msg("%s differ", name);
    }
}

void assert_same_results(const measured *a, const measured *b)
{
    const svo_tree_arrays *x = &a->result.arrays;
    const svo_tree_arrays *y = &b->result.arrays;
    const svo_tree_info *info = &a->result.info;
    assert_string_equal(a->result.nodes_hash, b->result.nodes_hash);
    assert_same_array("colors", x->colors, y->colors, info->node_count, 4);
    assert_same_array("normals", x->normals, y->normals, info->node_count, 6);
    assert_same_array("materials", x->materials, y->materials, info->node_count, 2);
    assert_same_array("fills", x->fills, y->fills, info->node_count, 2);
    assert_same_array("areas", x->areas, y->areas, info->leaf_count, 12);
    if (x->list != NULL && y->list != NULL) {
        assert_int_equal(info->list_count, b->result.info.list_count);
        assert_same_array("lists", x->list, y->list, info->list_count, 4);
        assert_same_array("lists' begins", x->list_begin, y->list_begin, info->leaf_count + 1, 4);
    }
}
