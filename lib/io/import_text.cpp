/* SPDX-License-Identifier: MIT */
/*
 * The library's one C++ file: fast_float is a header of templates. It is compiled without exceptions and run-time types
 * and needs nothing of the C++ library when it is linked.
 */
#include "io/import_text.h"

#include <fast_float/fast_float.h>

namespace
{

template <typename Number> const char *read_number(const char *text, const char *end, Number *value)
{
    /* fast_float follows std::from_chars, which takes no plus sign. */
    if (end - text > 1 && *text == '+' && text[1] != '-' && text[1] != '+') {
        ++text;
    }
    Number number;
    const fast_float::from_chars_result result = fast_float::from_chars(text, end, number);
    if (result.ec == std::errc::invalid_argument) {
        return nullptr;
    }
    *value = number;
    return result.ptr;
}

} // namespace

const char *svo_i_number_float(const char *text, const char *end, float *value)
{
    return read_number(text, end, value);
}

const char *svo_i_number_double(const char *text, const char *end, double *value)
{
    return read_number(text, end, value);
}
