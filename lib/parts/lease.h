/* SPDX-License-Identifier: MIT */
/*
 * Who uses a folder of parts. Nothing here is needed for the bytes of a tree to be right: files know their plan. Leases
 * keep planners from taking a plan away from those that work by it.
 *
 *   run-OWNER.lease      a file of each run that builds or stitches (svo_parts_lease)
 *   planner.lease/OWNER/ a folder in a folder, of the one process that plans: "owner", which is renewed, and what it
 *                        makes beside the plan that is there (planning.c)
 *
 * A folder is renamed onto another only where that is empty, on network file systems too, so there is one planner.
 * OWNER is a name that no other lease has, and all that a planner moves into the folder of the parts or out of it goes
 * by renames through that. When the lease is broken by a rename, those paths are gone, so a planner that was stopped
 * meanwhile can change nothing when it goes on, not even release what is another's by then.
 *
 * A lease is stale when it was not renewed for SVO_PARTS_LEASE_SECONDS by the clock of the file system, or when its
 * process is known to be gone: one of this machine since it started, that has no such process any more.
 */
#ifndef SVO_LIB_PARTS_LEASE_H
#define SVO_LIB_PARTS_LEASE_H

#include <stdbool.h>

#include "core/device.h"
#include "svocl/parts.h"

#define LEASE_SUFFIX ".lease"
#define OWNER_BYTES  160 /* of an OWNER, with what may stand around it */

/* The lease of a planner. */
typedef struct svo_i_planner {
    char *held; /* FOLDER/planner.lease/OWNER; NULL: none */
    char *owner; /* the file in it that is renewed */
    char *folder; /* of the parts */
    bool made_folder;
    int64_t renewed_ms; /* by the monotonic clock */
} svo_i_planner;

/* Refuses, with SVO_UNAVAILABLE and the owner's name, while another process has a lease of a folder. Leases of runs of
   this process, and of the one that started it, do not count. */
svo_status svo_i_lease_check(const char *folder, svo_message *message);

/* Takes the lease, and makes the folder where it is not there. Stale leases are broken, which the device's log is told.
   planner: all zero; to be released also after a failure. */
svo_status svo_i_planner_take(const char *folder, const svo_device *device, svo_i_planner *planner,
                              svo_message *message);
/* Renews it where that is due. SVO_UNAVAILABLE: it was broken. */
svo_status svo_i_planner_renew(svo_i_planner *planner, svo_message *message);
/* Removes it with all that is in it. */
void svo_i_planner_release(svo_i_planner *planner);

/* A name that no other has: of this process and the time. */
void svo_i_owner_name(char name[OWNER_BYTES]);

/* FOLDER/NAME; released by svo_i_free. NULL when out of memory. */
char *svo_i_path_join(const char *folder, const char *name);
/* Removes a file, or a folder with what is in it; links are not followed. Returns an errno; what is not there is 0. */
int svo_i_path_remove(const char *path);

#endif
