/* SPDX-License-Identifier: MIT */
/*
 * An OpenGL context with odd values everywhere, as an integrator's may have, and a record of all of it that can be compared
 * later. Most of them would spoil what svocl draws if they stayed.
 */
#ifndef SVO_TESTS_ODD_STATE_H
#define SVO_TESTS_ODD_STATE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct odd_state odd_state;

/* Makes objects and sets state in the context that is current; compatibility: it has that profile. */
odd_state *odd_state_set(bool compatibility);
/* Fails the running test naming each value that is not as odd_state_set left it; after: what was done meanwhile. */
void odd_state_assert(const odd_state *odd, const char *after);
void odd_state_destroy(odd_state **odd);

#endif
