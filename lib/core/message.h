/* SPDX-License-Identifier: MIT */
/* Error messages, checked sizes and the clock, for every host file of the library. */
#ifndef SVO_LIB_CORE_MESSAGE_H
#define SVO_LIB_CORE_MESSAGE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/visibility.h"
#include "svocl/status.h"

/*
 * The two ways to pass a failure on; tools/dev check finds others. A function that owns nothing returns it. A function
 * that has something to release declares "svo_status status = SVO_OK;" first and ends in one label "cleanup:".
 */
#define SVO_I_TRY(call)                          \
    do {                                         \
        const svo_status svo_i_status_ = (call); \
        if (svo_i_status_ != SVO_OK) {           \
            return svo_i_status_;                \
        }                                        \
    } while (0)
#define SVO_I_TRY_CLEANUP(call) \
    do {                        \
        status = (call);        \
        if (status != SVO_OK) { \
            goto cleanup;       \
        }                       \
    } while (0)

SVO_I_SHARED_BEGIN

/* Writes one line, cut to fit and always terminated, and returns status. message: NULL allowed. */
svo_status svo_i_fail(svo_message *message, svo_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
svo_status svo_i_fail_v(svo_message *message, svo_status status, const char *format, va_list arguments);

/* Writes a line that reports no failure. */
void svo_i_message_set(svo_message *message, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Replaces the function at the front of a message, for a public function that calls another. message: NULL allowed. */
void svo_i_message_rename(svo_message *message, const char *function);

/* *out = a * b or a + b; false, with *out untouched, on overflow. */
bool svo_i_mul_size(size_t a, size_t b, size_t *out);
bool svo_i_add_size(size_t a, size_t b, size_t *out);

/* Wall clock in milliseconds, monotonic. */
double svo_i_now_ms(void);

SVO_I_SHARED_END

#endif
