/* SPDX-License-Identifier: MIT */
/*
 * Coordinates in sub-units, which payload is weighed by (kernels/shared/snap.clh, fine.clh): the snapped one and its
 * remainder are the caller's number rounded to the nearest, ties to the even one, against the reference in integers of
 * any size. Ties and their neighbors, on grids where these are doubles; and any numbers on any grid.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "oracle_exact.h"
#include "shared/fine.clh"
#include "shared/snap.clh"
#include "support/meshes.h"
#include "support/suite.h"

enum { NUMBERS = 200000 };

/* A grid of 2^snap_bits units, of 2^bits sub-units each. */
typedef struct grid {
    double origin, edge;
    int snap_bits, bits;
} grid;

static double random_between(uint64_t *state, double low, double high)
{
    return low +
           (high - low) * ldexp((double)random_below(state, 1u << 31) + random_below(state, 1u << 22) * 0x1p-22, -31);
}

static grid random_grid(uint64_t *state, bool has_ties)
{
    const int depth = 1 + (int)random_below(state, 16);
    grid made = {.snap_bits = depth <= 12 ? 20 : depth + 8};
    made.bits = SVO_SUB_LOG2 - (made.snap_bits - depth);
    const int scale = (int)random_below(state, 41) - 20;
    made.edge = ldexp(has_ties ? 1.0 + random_below(state, 8) / 8.0 : random_between(state, 1.0, 2.0), scale);
    made.origin = has_ties ? made.edge * ((double)random_below(state, 64) / 16.0 - 2.0)
                           : made.edge * random_between(state, -3.0, 3.0);
    return made;
}

/* Returns whether the remainder is not 0. */
static bool check(const grid *on, double vertex)
{
    const double scale = ldexp(1.0, on->snap_bits) / on->edge;
    const svo_snap snap = svo_make_snap(scale, on->edge, on->snap_bits);
    const int32_t units = svo_snap_coordinate(&snap, vertex, on->origin);
    const int32_t remainder = svo_snap_remainder(&snap, vertex, on->origin, units, on->bits);
    const uint64_t packed = svo_pack_remainders(~remainder, remainder, -1);
    const int64_t found = svo_fine_coordinate(units, packed, 1, on->bits);
    const int64_t expected = oracle_exact_rounded(vertex, on->origin, on->edge, (unsigned)(on->snap_bits + on->bits));
    if (found != expected) {
        fail_msg("%a from %a on an edge of %a, 2^%d units of 2^%d: %lld, not %lld", vertex, on->origin, on->edge,
                 on->snap_bits, on->bits, (long long)found, (long long)expected);
    }
    return remainder != 0;
}

static void remainders_round_to_the_nearest(void **state)
{
    uint64_t seed = 20261101;
    size_t with_remainder = 0;
    (void)state;
    for (int i = 0; i < NUMBERS; ++i) {
        const grid on = random_grid(&seed, false);
        const double vertex = on.origin + on.edge * random_between(&seed, -1.0, 2.0);
        with_remainder += check(&on, i % 2 == 0 ? (double)(float)vertex : vertex) ? 1 : 0;
    }
    assert_in_range(with_remainder, NUMBERS / 2, NUMBERS);
}

static void ties_go_to_the_even_one(void **state)
{
    uint64_t seed = 20261102;
    size_t ties = 0;
    (void)state;
    for (int i = 0; i < NUMBERS; ++i) {
        const grid on = random_grid(&seed, true);
        const int depth_bits = on.snap_bits + on.bits;
        const double middle = floor(ldexp(random_between(&seed, -1.0, 2.0), depth_bits)) + 0.5;
        const double tie = on.origin + ldexp(middle, -depth_bits) * on.edge;
        ties += tie - on.origin == ldexp(middle, -depth_bits) * on.edge ? 1 : 0;
        (void)check(&on, tie);
        (void)check(&on, nextafter(tie, -INFINITY));
        (void)check(&on, nextafter(tie, INFINITY));
    }
    assert_in_range(ties, NUMBERS / 2, NUMBERS);
}

TEST_GROUP(remainder)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(remainders_round_to_the_nearest),
        cmocka_unit_test(ties_go_to_the_even_one),
    };
    return cmocka_run_group_tests_name("remainder", tests, NULL, NULL);
}
