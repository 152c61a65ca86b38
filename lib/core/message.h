/* SPDX-License-Identifier: MIT */
/* Error messages and checked sizes, for every host file of the library. */
#ifndef SVO_LIB_CORE_MESSAGE_H
#define SVO_LIB_CORE_MESSAGE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/system.h"
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

/* On functions with arguments as printf has them: which is the format, and which the first after it. C99's formats have
   a name of their own where the system's are others. */
#if defined(__MINGW32__) && !defined(__clang__)
#define SVO_I_FORMAT(format_index, first_index) __attribute__((format(gnu_printf, format_index, first_index)))
#else
#define SVO_I_FORMAT(format_index, first_index) __attribute__((format(printf, format_index, first_index)))
#endif

SVO_I_SHARED_BEGIN

/* Writes one line, cut to fit and always terminated, and returns status. message: NULL allowed. */
svo_status svo_i_fail(svo_message *message, svo_status status, const char *format, ...) SVO_I_FORMAT(3, 4);
svo_status svo_i_fail_v(svo_message *message, svo_status status, const char *format, va_list arguments);

/* Writes a line that reports no failure. */
void svo_i_message_set(svo_message *message, const char *format, ...) SVO_I_FORMAT(2, 3);

/* Replaces the function at the front of a message, for a public function that calls another. message: NULL allowed. */
void svo_i_message_rename(svo_message *message, const char *function);

/* *out = a * b or a + b; false, with *out untouched, on overflow. */
bool svo_i_mul_size(size_t a, size_t b, size_t *out);
bool svo_i_add_size(size_t a, size_t b, size_t *out);

SVO_I_SHARED_END

#endif
