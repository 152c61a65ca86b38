/* SPDX-License-Identifier: MIT */
/*
 * An OpenGL context with odd values everywhere, as an integrator's may have, and a record of all of it that can be
 * compared later. Most of them would spoil what svocl draws if they stayed.
 */
#ifndef SVOCL_TESTS_NONDEFAULT_STATE_H
#define SVOCL_TESTS_NONDEFAULT_STATE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct nondefault_state nondefault_state;

/* Makes objects and sets state in the context that is current; compatibility: it has that profile. */
nondefault_state *nondefault_state_set(bool compatibility);
/* Fails the running test naming each value that is not as nondefault_state_set left it; after: what was done
   meanwhile. */
void nondefault_state_assert(const nondefault_state *odd, const char *after);
void nondefault_state_destroy(nondefault_state **odd);

#endif
