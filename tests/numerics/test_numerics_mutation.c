/* SPDX-License-Identifier: MIT */
/*
 * T17 mutation: the tests find mistakes. The shared overlap test with one comparison changed, one axis removed, or one
 * term dropped fails the golden counts (T1) and the random pairs (T4). Rasterization without the expansion's margin
 * fails the golden counts. The unchanged source passes both. tests/mutants shows that svocl stress finds mistakes too.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "numerics/agree/probe.h"
#include "numerics/agree/sample.h"
#include "oracle.h"
#include "plan/chunking.h"
#include "raster/raster.h"
#include "support/golden.h"
#include "support/machine.h"
#include "support/suite.h"

typedef struct mutant {
    const char *name;
    probe_function *ask;
    probe_column_function *column;
    sample_width width;
    bool thin;
    bool is_sound; /* no mistake */
} mutant;

static const mutant mutants[] = {
    {"regular", probe_regular, probe_column_regular, SAMPLE_REGULAR, false, true},
    {"narrow", probe_narrow, probe_column_narrow, SAMPLE_NARROW, false, true},
    {"thin", probe_thin_regular, probe_column_thin_regular, SAMPLE_REGULAR, true, true},
    {">= is >", probe_mutant_sign, probe_column_mutant_sign, SAMPLE_REGULAR, false, false},
    {">= is >, narrow", probe_mutant_narrow_sign, probe_column_mutant_narrow_sign, SAMPLE_NARROW, false, false},
    {"a line left out", probe_mutant_line, probe_column_mutant_line, SAMPLE_REGULAR, false, false},
    {"the plane left out", probe_mutant_plane, probe_column_mutant_plane, SAMPLE_REGULAR, false, false},
    {"far faces owned", probe_mutant_open, probe_column_mutant_open, SAMPLE_REGULAR, false, false},
    {"thin intervals closed", probe_mutant_thin, probe_column_mutant_thin, SAMPLE_REGULAR, true, false},
};
enum { MUTANTS = sizeof mutants / sizeof mutants[0] };

/* T4: the number of random records where it disagrees with the references. */
static unsigned wrong_pairs(const mutant *m)
{
    enum { RECORDS = 16384 };
    unsigned wrong = 0;
    for (uint32_t i = 0; i < RECORDS; ++i) {
        sample s = {.kind = (sample_kind)0};
        probe_output found;
        (m->thin ? sample_make_thin : sample_make)(m->width, 20240305, i, &s);
        m->ask(&s.record, &found, 1);
        wrong += sample_is_wrong(&s, &found, oracle_sat_touches(&s.triangle, &s.box, s.coverage)) ? 1 : 0;
    }
    return wrong;
}

static int32_t smallest(int32_t a, int32_t b, int32_t c)
{
    return a < b ? (a < c ? a : c) : b < c ? b : c;
}

static int32_t largest(int32_t a, int32_t b, int32_t c)
{
    return -smallest(-a, -b, -c);
}

/* Adds the voxels of one triangle at a depth, by testing every column of its bounds: those that may touch, and those
   that surely do. Closed boxes begin one unit earlier. */
static void count_voxels(const mutant *m, const int32_t *corners, unsigned depth, bool closed, uint64_t *most,
                         uint64_t *least)
{
    const unsigned shift = GOLDEN_SNAP_BITS - depth;
    const int32_t end = (1 << depth) - 1;
    int32_t first[3];
    int32_t last[3];
    probe_input given = {{0}};
    for (unsigned axis = 0; axis < 3; ++axis) {
        const int32_t low = smallest(corners[axis], corners[3 + axis], corners[6 + axis]) - (closed ? 1 : 0);
        const int32_t high = largest(corners[axis], corners[3 + axis], corners[6 + axis]) >> shift;
        first[axis] = low < 0 ? 0 : low >> shift;
        last[axis] = high > end ? end : high;
    }
    for (unsigned k = 0; k < 9; ++k) {
        given.words[k] = corners[k] - (first[k % 3] << shift);
    }
    given.words[9] = 1 << shift;
    given.words[10] = closed ? 0 : 1;
    given.words[14] = last[2] - first[2];
    for (int32_t u = 0; u <= last[0] - first[0]; ++u) {
        for (int32_t v = 0; v <= last[1] - first[1]; ++v) {
            given.words[11] = u << shift;
            given.words[12] = v << shift;
            SVO_I32 begin = 0;
            SVO_I32 finish = 0;
            SVO_I32 decided = 0;
            m->column(&given, &begin, &finish, &decided);
            *most += finish >= begin ? (uint64_t)(finish - begin + 1) : 0;
            *least += (uint64_t)decided;
        }
    }
}

/* T1: the number of golden counts that are not between what surely touches and what may. The table has no thin counts,
   and its triangles are too large for narrow arithmetic. */
static unsigned wrong_counts(const mutant *m, const golden_table *table)
{
    unsigned wrong = 0;
    for (size_t s = 0; s < table->scene_count; ++s) {
        const golden_scene *scene = &table->scenes[s];
        for (size_t i = 0; i < scene->count_count; ++i) {
            const golden_count *expected = &scene->counts[i];
            if (expected->depth < 1 || expected->depth > 6) {
                continue;
            }
            uint64_t most = 0;
            uint64_t least = 0;
            for (size_t t = 0; t < scene->triangle_count; ++t) {
                count_voxels(m, scene->vertices + t * 9, expected->depth, expected->is_closed, &most, &least);
            }
            wrong += expected->pairs < least || expected->pairs > most ? 1 : 0;
        }
    }
    return wrong;
}

static void t17_mutants_of_the_shared_test_are_found(void **state)
{
    (void)state;
    golden_table *table = golden_load(GOLDEN_COUNTS_PATH);
    assert_non_null(table);
    for (size_t i = 0; i < MUTANTS; ++i) {
        const mutant *m = &mutants[i];
        const unsigned pairs = wrong_pairs(m);
        const bool in_table = m->width == SAMPLE_REGULAR && !m->thin;
        const unsigned counts = in_table ? wrong_counts(m, table) : 0;
        print_message("%s: %u pairs and %u golden counts wrong\n", m->name, pairs, counts);
        assert_int_equal(pairs == 0, m->is_sound);
        /* Scenes with odd coordinates, which may be off, do not show who owns a face. */
        assert_true(!m->is_sound || counts == 0);
    }
    golden_free(table);
}

/*
 * The expansion's margin. The method for hardware with conservative rasterization omits it; used without such hardware,
 * that is a mistake.
 */

#define CONSERVATIVE_RASTERIZATION_NV 0x9346

/* The original functions of the context that is lying, for its wrappers, which have no user pointer. */
static svo_i_gl_functions honest;

static void APIENTRY enable_all_but_conservative(GLenum capability)
{
    if (capability != CONSERVATIVE_RASTERIZATION_NV) {
        honest.Enable(capability);
    }
}

static void APIENTRY disable_all_but_conservative(GLenum capability)
{
    if (capability != CONSERVATIVE_RASTERIZATION_NV) {
        honest.Disable(capability);
    }
}

static void APIENTRY ignore_parameter(GLenum name, GLint value)
{
    (void)name;
    (void)value;
}

/* The numbers of fragments that a rasterization method produces for a plan; none are stored. */
static svo_i_raster_count count_fragments(svo_gl_context *context, svo_plan *plan, svo_i_conservative method)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(context);
    svo_i_raster *raster = NULL;
    svo_i_chunking layout;
    svo_i_raster_count counts = {0, 0};
    GLuint buffer = 0;
    assert_int_equal(svo_i_raster_create(plan->device, context, method, false, &raster), SVO_OK);
    assert_int_equal(svo_i_chunking_create(plan, UINT64_C(1) << 26, &layout), SVO_OK);
    assert_int_equal(layout.chunk_count, 1);
    layout.chunks[0].capacity = 0;
    assert_int_equal(svo_i_gl_context_make_current(context, NULL), SVO_OK);
    gl->GenBuffers(1, &buffer);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, 64, NULL, GL_STREAM_READ);
    assert_int_equal(svo_i_raster_prepare(raster, plan), SVO_OK);
    assert_int_equal(svo_i_raster_upload(raster, plan, plan->items, plan->class_begin[SVO_I_CLASS_COUNT], 1), SVO_OK);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, SVO_I_RASTER_FRAGMENTS, buffer);
    assert_int_equal(svo_i_raster_draw(raster, plan, &layout, 0), SVO_OK);
    assert_int_equal(svo_i_raster_finish(raster, 1, &counts), SVO_OK);
    gl->DeleteBuffers(1, &buffer);
    svo_i_gl_context_release_current(context);
    svo_i_chunking_destroy(&layout);
    svo_i_raster_destroy(&raster);
    return counts;
}

static unsigned wrong_rasters(svo_device *device, svo_gl_context *context, const golden_table *table,
                              svo_i_conservative method)
{
    unsigned wrong = 0;
    for (size_t s = 0; s < table->scene_count; ++s) {
        const golden_scene *scene = &table->scenes[s];
        const size_t value_count = scene->triangle_count * 9;
        float *positions = malloc(value_count * sizeof *positions);
        assert_non_null(positions);
        for (size_t i = 0; i < value_count; ++i) {
            positions[i] = (float)scene->vertices[i];
        }
        const svo_mesh mesh = {.struct_size = sizeof mesh,
                               .positions = positions,
                               .vertex_count = scene->triangle_count * 3,
                               .triangle_count = scene->triangle_count};
        for (size_t i = 0; i < scene->count_count; ++i) {
            const golden_count *expected = &scene->counts[i];
            const svo_plan_options options = {.struct_size = sizeof options,
                                              .edge = 1u << GOLDEN_SNAP_BITS,
                                              .need = SVO_NEED_NONE,
                                              .coverage =
                                                  expected->is_closed ? SVO_COVERAGE_CLOSED : SVO_COVERAGE_HALF_OPEN};
            if (expected->depth != 6) {
                continue;
            }
            svo_plan *plan = NULL;
            assert_int_equal(svo_plan_create(device, &mesh, expected->depth, &options, &plan), SVO_OK);
            const svo_i_raster_count counts = count_fragments(context, plan, method);
            wrong += expected->pairs < counts.decided || expected->pairs > (uint64_t)counts.decided + counts.undecided;
            svo_plan_destroy(&plan);
        }
        free(positions);
    }
    return wrong;
}

static void t17_rasterizing_without_a_margin_is_found(void **state)
{
    (void)state;
    golden_table *table = golden_load(GOLDEN_COUNTS_PATH);
    assert_non_null(table);
    svo_device *device = machine_device_or_skip();
    svo_gl_context *context = machine_any_context_or_skip();
    assert_int_equal(wrong_rasters(device, context, table, SVO_I_CONSERVATIVE_EXPAND), 0);
    honest = context->functions;
    context->functions.Enable = enable_all_but_conservative;
    context->functions.Disable = disable_all_but_conservative;
    context->functions.ConservativeRasterParameteriNV = ignore_parameter;
    const unsigned wrong = wrong_rasters(device, context, table, SVO_I_CONSERVATIVE_NV);
    context->functions = honest;
    print_message("without a margin: %u golden counts wrong\n", wrong);
    assert_true(wrong > 0);
    svo_gl_context_destroy(&context);
    svo_device_destroy(&device);
    golden_free(table);
}

TEST_GROUP(numerics_mutation)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(t17_mutants_of_the_shared_test_are_found),
        cmocka_unit_test(t17_rasterizing_without_a_margin_is_found),
    };
    return cmocka_run_group_tests_name("numerics_mutation", tests, NULL, NULL);
}
