/* SPDX-License-Identifier: MIT */
/* The commands of an update, each after the one before, whatever the queue. */
#ifndef SVO_LIB_MOVING_CHAIN_H
#define SVO_LIB_MOVING_CHAIN_H

#include "commands/commands.h"
#include "core/work.h"
#include "moving/state.h"

typedef struct svo_i_chain {
    const char *function; /* for messages */
    cl_command_queue queue;
    bool waits; /* each stage waits for its commands; else none does, and counts stay on the device */
    cl_event last; /* the newest command, owned; NULL: nothing is to be waited for */
} svo_i_chain;

/* The program of kernels/moving. */
svo_status svo_i_moving_program(const svo_moving *moving, const char *function, cl_program *out);

/* Begins a piece of work with the program of kernels/moving. */
svo_status svo_i_chain_begin(svo_i_chain *chain, const svo_moving *moving, svo_i_device_work *work);
/* Ends it: after a failure waits for its commands. Returns the first failure. */
svo_status svo_i_chain_end(svo_i_chain *chain, svo_i_device_work *work, svo_status status);

/* The same for stages of builds. The commands have buffers of their own. */
svo_i_commands svo_i_chain_begin_commands(svo_i_chain *chain, svo_plan *plan, svo_build_report *report);
void svo_i_chain_end_commands(svo_i_chain *chain, svo_i_commands *commands, svo_status status);

/* Waits for the newest command and releases the chain. */
void svo_i_chain_settle(svo_i_chain *chain);

#endif
