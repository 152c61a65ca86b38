/* SPDX-License-Identifier: MIT */
/*
 * Sets non-default OpenGL state, as an application may have it, and records all of it for a later comparison. Most of
 * the values would corrupt svocl's drawing if svocl did not override them.
 */
#ifndef SVOCL_TESTS_NONDEFAULT_STATE_H
#define SVOCL_TESTS_NONDEFAULT_STATE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct nondefault_state nondefault_state;

/* Creates objects and sets state in the current context. compatibility: the context has the compatibility profile. */
nondefault_state *nondefault_state_set(bool compatibility);
/* Fails the running test if a value differs from the state after nondefault_state_set, and names each. after: the
   operation in between, for the message. */
void nondefault_state_assert(const nondefault_state *odd, const char *after);
void nondefault_state_destroy(nondefault_state **odd);

#endif
