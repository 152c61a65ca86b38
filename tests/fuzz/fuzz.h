/* SPDX-License-Identifier: MIT */
/*
 * Shared by the fuzz targets: libFuzzer's entry points (https://llvm.org/docs/LibFuzzer.html), and a macro that reports
 * a violated guarantee. replay.c calls the same entry points with stored inputs, as an ordinary test.
 */
#ifndef SVOCL_TESTS_FUZZ_FUZZ_H
#define SVOCL_TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

/* NOLINTBEGIN(readability-identifier-naming): libFuzzer's names */
/* Runs one input of arbitrary bytes; always returns 0. A finding ends the process. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count);

/* Called by libFuzzer instead of its own mutations: changes byte_count bytes in place, up to byte_count_max, and
   returns the new count. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t byte_count, size_t byte_count_max, unsigned seed);
/* libFuzzer's own mutations, for use by the function above. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t byte_count, size_t byte_count_max);
/* NOLINTEND(readability-identifier-naming) */

/* Unlike assert(), it also checks in release builds. */
#define REQUIRE(condition)                                                                  \
    do {                                                                                    \
        if (!(condition)) {                                                                 \
            (void)fprintf(stderr, "%s:%d: not true: %s\n", __FILE__, __LINE__, #condition); \
            abort();                                                                        \
        }                                                                                   \
    } while (0)

#endif
