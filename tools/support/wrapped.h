/* SPDX-License-Identifier: MIT */
/*
 * Functions that stand between a program with its static libraries and a library that it calls. The linker's option
 * --wrap=NAME sends calls of NAME to __wrap_NAME, and __real_NAME is the function itself.
 */
#ifndef SVO_TOOLS_SUPPORT_WRAPPED_H
#define SVO_TOOLS_SUPPORT_WRAPPED_H

/* NOLINTBEGIN(bugprone-macro-parentheses): lists of parameters */
/* Takes a note, a statement that can use the parameters, and calls the real function. */
#define WRAPPED(type, name, parameters, arguments, note) \
    type __real_##name parameters;                       \
    type __wrap_##name parameters;                       \
    type __wrap_##name parameters                        \
    {                                                    \
        note;                                            \
        return __real_##name arguments;                  \
    }
/* NOLINTEND(bugprone-macro-parentheses) */

/* The end of the parameters of a call that enqueues a command. */
#define EVENTS       cl_uint num_wait, const cl_event *wait, cl_event *event
#define EVENTS_GIVEN num_wait, wait, event

#endif
