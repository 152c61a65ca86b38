/* SPDX-License-Identifier: MIT */
/*
 * Numbers of text formats in the import child, correctly rounded: the float or double nearest to the digits, ties to
 * even, whatever the locale. C around fast_float (Lemire, "Number parsing at a gigabyte per second", 2021).
 */
#ifndef SVO_LIB_IO_IMPORT_NUMBER_H
#define SVO_LIB_IO_IMPORT_NUMBER_H

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Reads a number that begins at text: an optional sign, digits with or without a decimal point, an optional exponent,
 * or nan, inf, infinity in any case. What is too large becomes infinite, what is too small zero.
 * Returns the first character behind it, at most end; NULL, with *value untouched, where no number begins.
 */
const char *svo_i_number_float(const char *text, const char *end, float *value);
const char *svo_i_number_double(const char *text, const char *end, double *value);

#ifdef __cplusplus
}
#endif

#endif
