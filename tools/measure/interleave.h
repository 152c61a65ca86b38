/* SPDX-License-Identifier: MIT */
/* Ways that are compared take turns in one run, so that whatever else the machine does falls on all of them alike. */
#ifndef SVOCL_TURNS_H
#define SVOCL_TURNS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct turn {
    double (*work_ms)(void *user); /* does the work once; returns what it took, below 0 on failure */
    void *user;
    double median_ms; /* of the rounds after the first: set by turns_measure */
} turn;

/* The first round warms up and does not count. Returns false when a way fails or memory runs out; then no median is set. */
bool turns_measure(turn *ways, size_t way_count, size_t round_count);

#endif
