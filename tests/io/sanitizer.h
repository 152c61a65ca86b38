/* SPDX-License-Identifier: MIT */
/* Whether the build has AddressSanitizer, which maps more addresses than any limit of them allows. */
#ifndef SVO_TESTS_SANITIZER_H
#define SVO_TESTS_SANITIZER_H

#if defined(__SANITIZE_ADDRESS__)
#define WITH_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define WITH_ADDRESS_SANITIZER 1
#endif
#endif
#ifndef WITH_ADDRESS_SANITIZER
#define WITH_ADDRESS_SANITIZER 0
#endif

#endif
