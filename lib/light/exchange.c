/* SPDX-License-Identifier: MIT */
/* The host's part of the exchange: which leaves are lit, and the unit of their radiance. */
#include "light/exchange.h"

#include <math.h>
#include <string.h>

#include "svocl/nodes.h"
#include "svocl/plan.h"

#define PI 3.14159265358979323846
/* The exponents that the unit of radiance may have, with room for the largest radiance in a float. */
#define UNIT_EXPONENT_MIN (-120)
#define UNIT_EXPONENT_MAX 90

/* The arguments that SVO_SURFACE_PARAMETERS of kernels/light/leaf_surface.clh declares. */
#define SURFACE_ARGUMENTS(e)                                                                         \
    SVO_I_ARGUMENT((e)->light->tree->buffers[SVO_TREE_COLORS]),                                      \
        SVO_I_ARGUMENT((e)->light->tree->buffers[SVO_TREE_FILLS]),                                   \
        SVO_I_ARGUMENT((e)->light->tree->buffers[SVO_TREE_MATERIALS]), SVO_I_ARGUMENT((e)->records), \
        SVO_I_ARGUMENT((e)->light->tree->buffers[SVO_TREE_NORMALS]), SVO_I_ARGUMENT((e)->decline)

/* What the steps share. */
typedef struct exchange {
    svo_i_photons *photons;
    svo_i_device_work *work;
    svo_light *light;
    const svo_finish *finishes;
    uint32_t finish_count; /* 0: none, or the tree has no materials */
    svo_exchange_params params;
    cl_mem records; /* svo_finish_record each; NULL: none */
    cl_mem decline; /* of lobes; NULL: there are none */
    double brightest; /* emission of a leaf */
    double radiance_of_one; /* of a sum of 1, on a surface of albedo 1 */
} exchange;

/* What the kernels need to know of the tree. */
static void describe_tree(exchange *e)
{
    const svo_tree_info *info = &e->light->tree->info;
    const bool areas = e->light->info.opacity == SVO_OPACITY_AREA;
    const double edge = ldexp(1.0 / info->scale, (int)(info->snap_bits - info->depth));
    e->params.leaf_begin = (cl_uint)(info->inner_count - info->level_begin[info->payload_level]);
    e->params.flags = ((info->need & SVO_NEED_COLOR) != 0 ? SVO_EXCHANGE_COLORS : 0) |
                      (svo_i_tree_is_constant(info, SVO_TREE_COLORS) ? SVO_EXCHANGE_ONE_COLOR : 0) |
                      (svo_i_tree_is_constant(info, SVO_TREE_MATERIALS) ? SVO_EXCHANGE_ONE_MATERIAL : 0) |
                      ((info->need & SVO_NEED_FILL) != 0 ? SVO_EXCHANGE_FILLS : 0) | (areas ? SVO_EXCHANGE_AREAS : 0) |
                      (svo_i_tree_is_constant(info, SVO_TREE_NORMALS) ? SVO_EXCHANGE_ONE_NORMAL : 0) |
                      (e->light->options.one_side != 0 ? SVO_EXCHANGE_ONE_SIDE : 0);
    e->radiance_of_one = e->photons->unit / (PI * edge * edge);
}

/* ---- leaves that emit ---- */

static float largest_of(const float values[3])
{
    const float two = values[0] > values[1] ? values[0] : values[1];
    return two > values[2] ? two : values[2];
}

/* Claims slots for the leaves of emitting materials, and finds the brightest of those materials. emits: a word a
   finish, whether it emits; becomes whether a leaf has it. */
static svo_status claim_emitting(exchange *e, uint32_t *emits)
{
    const size_t bytes = e->finish_count * sizeof *emits;
    const svo_tree *tree = e->light->tree;
    cl_mem given = NULL;
    cl_mem used = NULL;
    SVO_I_TRY(svo_i_work_alloc(e->work, "light_emits", bytes, &given));
    SVO_I_TRY(svo_i_work_alloc(e->work, "light_emits_used", bytes, &used));
    SVO_I_TRY(svo_i_work_write(e->work, given, emits, bytes));
    SVO_I_TRY(svo_i_work_fill_zero(e->work, used, bytes));
    e->params.count = (cl_uint)tree->info.leaf_count;
    e->params.finish_count = e->finish_count;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(tree->buffers[SVO_TREE_MATERIALS]),
                                        SVO_I_ARGUMENT(given),
                                        SVO_I_ARGUMENT(used),
                                        SVO_I_ARGUMENT(e->photons->slots),
                                        SVO_I_ARGUMENT(e->photons->counters),
                                        SVO_I_ARGUMENT(e->params)};
    SVO_I_TRY(svo_i_work_launch(e->work, "svo_k_emission_claim", SVO_I_ARGUMENTS(arguments), e->params.count));
    SVO_I_TRY(svo_i_work_read(e->work, used, 0, emits, bytes));
    svo_i_work_free(e->work, &given);
    svo_i_work_free(e->work, &used);
    return svo_i_photons_make_room(e->photons);
}

static svo_status find_emitting(exchange *e)
{
    if (e->finish_count == 0) {
        return SVO_OK;
    }
    uint32_t *emits = svo_i_alloc_zeroed(&e->light->device->memory, e->finish_count, sizeof *emits);
    if (emits == NULL) {
        return svo_i_device_fail(e->light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u finishes",
                                 e->work->function, e->finish_count);
    }
    for (uint32_t i = 0; i < e->finish_count; ++i) {
        emits[i] = largest_of(e->finishes[i].emission) > 0.0F ? 1 : 0;
    }
    const svo_status status = claim_emitting(e, emits);
    for (uint32_t i = 0; status == SVO_OK && i < e->finish_count; ++i) {
        const double emission = largest_of(e->finishes[i].emission);
        e->brightest = emits[i] != 0 && emission > e->brightest ? emission : e->brightest;
    }
    svo_i_free(emits);
    return status;
}

/* ---- finishes ---- */

/* exp(-x / SVO_LOBE_STEPS), by + and * alone. */
static void make_decline(cl_ushort table[SVO_LOBE_TABLE])
{
    const double step = -1.0 / SVO_LOBE_STEPS;
    const double factor = 1 + step * (1 + step / 2 * (1 + step / 3 * (1 + step / 4 * (1 + step / 5))));
    double value = 65535;
    for (int i = 0; i < SVO_LOBE_TABLE; ++i) {
        table[i] = (cl_ushort)(value + 0.5);
        value *= factor;
    }
}

/* A finish in integers. Emission that no leaf has may be brighter than all that can be stored. unit: of radiance. */
static svo_finish_record convert_finish(const svo_finish *finish, double unit)
{
    const double most = (double)(UINT32_C(1) << SVO_RADIANCE_MOST_LOG2);
    const double variance = finish->exponent > 0.125F ? 1 / (double)finish->exponent : 8;
    svo_finish_record record = {.variance = (cl_uint)(variance * (1 << SVO_LOBE_BITS) + 0.5)};
    for (int channel = 0; channel < 3; ++channel) {
        const double emission = (double)finish->emission[channel] / unit + 0.5;
        record.emission[channel] = (cl_uint)(emission < most ? emission : most);
        record.specular[channel] = (cl_uint)((double)finish->specular[channel] * 65536 + 0.5);
    }
    return record;
}

static svo_status upload_finishes(exchange *e, double unit)
{
    const size_t bytes = e->finish_count * sizeof(svo_finish_record);
    if (bytes == 0) {
        return SVO_OK;
    }
    svo_finish_record *records = svo_i_alloc(&e->light->device->memory, bytes);
    if (records == NULL) {
        return svo_i_device_fail(e->light->device, SVO_OUT_OF_HOST_MEMORY, "%s: no memory for %u finishes",
                                 e->work->function, e->finish_count);
    }
    for (uint32_t i = 0; i < e->finish_count; ++i) {
        records[i] = convert_finish(&e->finishes[i], unit);
    }
    svo_status status = SVO_OK;
    if (e->records == NULL) {
        status = svo_i_work_alloc(e->work, "light_finishes", bytes, &e->records);
    }
    if (status == SVO_OK) {
        status = svo_i_work_write(e->work, e->records, records, bytes);
    }
    svo_i_free(records);
    return status;
}

static svo_status upload_decline(exchange *e)
{
    cl_ushort table[SVO_LOBE_TABLE];
    if (!e->photons->has_lobes) {
        return SVO_OK;
    }
    make_decline(table);
    SVO_I_TRY(svo_i_work_alloc(e->work, "light_decline", sizeof table, &e->decline));
    return svo_i_work_write(e->work, e->decline, table, sizeof table);
}

/* ---- lit leaves ---- */

/* The leaves that have slots, in ascending order. */
static svo_status list_leaves(exchange *e, svo_i_lit_leaves *lit)
{
    const uint64_t leaf_count = e->light->tree->info.leaf_count;
    cl_mem flags = NULL;
    cl_mem places = NULL;
    e->params.count = (cl_uint)leaf_count;
    SVO_I_TRY(svo_i_work_alloc(e->work, "lit_flags", leaf_count * sizeof(cl_uint), &flags));
    SVO_I_TRY(svo_i_work_alloc(e->work, "lit_places", (leaf_count + 1) * sizeof(cl_uint), &places));
    SVO_I_TRY(svo_i_work_alloc(e->work, "lit_leaves", lit->lit_count * sizeof(cl_uint), &lit->leaves));
    const svo_i_argument mark[] = {SVO_I_ARGUMENT(e->photons->slots), SVO_I_ARGUMENT(flags), SVO_I_ARGUMENT(e->params)};
    const svo_i_argument list[] = {SVO_I_ARGUMENT(e->photons->slots), SVO_I_ARGUMENT(places),
                                   SVO_I_ARGUMENT(lit->leaves), SVO_I_ARGUMENT(e->params)};
    SVO_I_TRY(svo_i_work_launch(e->work, "svo_k_lit_flags", SVO_I_ARGUMENTS(mark), leaf_count));
    SVO_I_TRY(svo_i_work_scan(e->work, flags, places, leaf_count));
    SVO_I_TRY(svo_i_work_launch(e->work, "svo_k_lit_leaves", SVO_I_ARGUMENTS(list), leaf_count));
    svo_i_work_free(e->work, &flags);
    svo_i_work_free(e->work, &places);
    return SVO_OK;
}

/* ---- radiance ---- */

/* Bits of the largest radiance of photons, before it has a unit. */
static svo_status find_bits(exchange *e, const svo_i_lit_leaves *lit, uint32_t *bits)
{
    const cl_mem slot_bits = e->photons->kept != NULL ? e->photons->kept->bits : NULL;
    e->params.count = (cl_uint)lit->lit_count;
    e->params.kept = e->photons->kept != NULL ? SVO_RADIANCE_OF_STALE : SVO_RADIANCE_OF_LEAVES;
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(lit->leaves),      SVO_I_ARGUMENT(e->photons->slots),
                                        SVO_I_ARGUMENT(e->photons->sums), SURFACE_ARGUMENTS(e),
                                        SVO_I_ARGUMENT(slot_bits),        SVO_I_ARGUMENT(e->photons->counters),
                                        SVO_I_ARGUMENT(e->params)};
    SVO_I_TRY(svo_i_work_launch(e->work, "svo_k_radiance_bits", SVO_I_ARGUMENTS(arguments), lit->lit_count));
    return svo_i_work_read(e->work, e->photons->counters, SVO_PHOTON_BITS * sizeof *bits, bits, sizeof *bits);
}

/* The least power of two that is not below value; 0 for a value of 0. */
static double power_above(double value)
{
    int exponent = 0;
    const double fraction = frexp(value, &exponent);
    return value > 0 ? ldexp(1.0, fraction > 0.5 ? exponent : exponent - 1) : 0;
}

/* The unit in which the largest radiance has SVO_RADIANCE_MOST_LOG2 bits, and the factor of sums. */
static svo_status choose_unit(exchange *e, uint32_t bits, double *unit)
{
    const double most = ldexp(1.0, SVO_RADIANCE_MOST_LOG2);
    const double of_photons = bits > 0 ? ldexp(e->radiance_of_one, (int)bits) / most : 0;
    /* A unit finer than that of sums would say no more. */
    const double finest = bits > 0 ? e->radiance_of_one : 0;
    const double of_emission = e->brightest / most;
    *unit = power_above(fmax(of_photons, fmax(finest, of_emission)));
    *unit = *unit > 0 ? *unit : 1;
    if (*unit < ldexp(1.0, UNIT_EXPONENT_MIN) || *unit > ldexp(1.0, UNIT_EXPONENT_MAX)) {
        return svo_i_device_fail(e->light->device, SVO_UNSUPPORTED,
                                 "%s: radiance up to %g is beyond the range of floats", e->work->function,
                                 *unit * most);
    }
    int exponent = 0;
    const double fraction = frexp(e->radiance_of_one / *unit, &exponent); /* at most 1, where there is any flux */
    const bool too_small = bits == 0 || exponent < -62;
    const uint64_t factor = too_small ? 0 : (uint64_t)ldexp(fraction, exponent > 0 ? 64 : 63);
    e->params.factor_low = (cl_uint)factor;
    e->params.factor_high = (cl_uint)(factor >> 32);
    e->params.shift = too_small || exponent > 0 ? 0 : (cl_uint)-exponent;
    return SVO_OK;
}

/* Where the radiance goes. What is kept in another unit is made anew. */
static svo_status place_radiance(exchange *e, svo_i_lit_leaves *lit)
{
    svo_i_kept_photons *kept = e->photons->kept;
    if (kept == NULL) {
        const uint64_t values = svo_i_photons_values_of_leaf(e->photons);
        return svo_i_work_alloc(e->work, "lit_radiance", lit->lit_count * values * sizeof(cl_uint), &lit->radiance);
    }
    e->params.kept = kept->unit == lit->unit ? SVO_RADIANCE_OF_STALE : SVO_RADIANCE_OF_SLOTS;
    kept->unit = lit->unit;
    lit->radiance = kept->radiance;
    return SVO_OK;
}

static svo_status make_radiance(exchange *e, svo_i_lit_leaves *lit)
{
    const cl_mem slot_bits = e->photons->kept != NULL ? e->photons->kept->bits : NULL;
    svo_light_info *info = &e->light->info;
    info->bytes[SVO_LIGHT_FLUX] = lit->lit_count * SVO_FLUX_SUMS * sizeof(cl_ulong);
    SVO_I_TRY(svo_i_light_buffer(e->work, e->light, SVO_LIGHT_FLUX));
    SVO_I_TRY(place_radiance(e, lit));
    const svo_i_argument arguments[] = {SVO_I_ARGUMENT(lit->leaves),
                                        SVO_I_ARGUMENT(e->photons->slots),
                                        SVO_I_ARGUMENT(e->photons->sums),
                                        SURFACE_ARGUMENTS(e),
                                        SVO_I_ARGUMENT(e->light->tree->buffers[SVO_TREE_AREAS]),
                                        SVO_I_ARGUMENT(slot_bits),
                                        SVO_I_ARGUMENT(lit->radiance),
                                        SVO_I_ARGUMENT(e->light->buffers[SVO_LIGHT_FLUX]),
                                        SVO_I_ARGUMENT(e->params)};
    return svo_i_work_launch(e->work, "svo_k_radiance", SVO_I_ARGUMENTS(arguments), lit->lit_count);
}

svo_status svo_i_light_exchange(svo_i_photons *photons, svo_light *light, const svo_finish *finishes,
                                size_t finish_count, svo_i_lit_leaves *lit)
{
    const bool has_materials = (light->tree->info.need & SVO_NEED_MATERIAL) != 0;
    exchange e = {.photons = photons,
                  .work = photons->work,
                  .light = light,
                  .finishes = finishes,
                  .finish_count = has_materials ? (uint32_t)finish_count : 0};
    uint32_t bits = 0;
    double unit = 0;
    *lit = (svo_i_lit_leaves){.unit = 1};
    SVO_I_TRY(svo_i_photons_use(photons));
    describe_tree(&e);
    SVO_I_TRY(find_emitting(&e));
    lit->lit_count = photons->lit_count;
    if (lit->lit_count == 0) {
        return SVO_OK;
    }
    SVO_I_TRY(list_leaves(&e, lit));
    e.params.finish_count = e.finish_count;
    SVO_I_TRY(upload_decline(&e));
    SVO_I_TRY(upload_finishes(&e, 1)); /* emission has no unit yet, and is not read */
    SVO_I_TRY(find_bits(&e, lit, &bits));
    SVO_I_TRY(choose_unit(&e, bits, &unit));
    SVO_I_TRY(upload_finishes(&e, unit));
    lit->unit = (float)unit;
    SVO_I_TRY(make_radiance(&e, lit));
    svo_i_work_free(e.work, &e.records);
    svo_i_work_free(e.work, &e.decline);
    return SVO_OK;
}
