/* SPDX-License-Identifier: MIT */
/*
 * From one plan of a folder to the next. A planner writes below its lease: "new" with the files of triangles, and
 * "plan". Then each step is a rename of what lies there, or to there, so a planner whose lease was broken can do none
 * of them:
 *
 *   1. "new" becomes the folder that has the plan's identity for a name; where that is there, its files replace those.
 *   2. "plan" replaces the plan of the folder. From here on who opens the folder has the new plan; before, the old one.
 *   3. The files of other plans move below the lease, where they are removed. Part files stay: they may be of this
 *      plan, with another --max-memory.
 */
#define _POSIX_C_SOURCE 200809L
#include "parts/planning.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "parts/lease.h"
#include "parts/part_file.h"

#define PLAN_NAME "plan"

static svo_status fail_errno(const svo_parts *parts, svo_message *message, const char *what, int error)
{
    return error == ENOENT
               ? svo_i_fail(message, SVO_UNAVAILABLE,
                            "%s: the lease was broken, since it had not been renewed for %d s; the plan "
                            "that is there stays",
                            parts->folder, SVO_PARTS_LEASE_SECONDS)
               : svo_i_fail(message, svo_i_file_status(error), "%s: %s: %s", parts->folder, what, strerror(error));
}

svo_status svo_i_planning_begin(svo_parts *parts, const svo_device *device, svo_message *message)
{
    SVO_I_TRY(svo_i_planner_take(parts->folder, device, &parts->planner, message));
    parts->place = svo_i_path_join(parts->planner.held, "new");
    if (parts->place == NULL) {
        return svo_i_folder_no_memory(parts, message);
    }
    return mkdir(parts->place, 0777) == 0 ? SVO_OK : fail_errno(parts, message, "cannot be filled", errno);
}

svo_status svo_i_planning_renew(svo_parts *parts, svo_message *message)
{
    return parts->planner.held != NULL ? svo_i_planner_renew(&parts->planner, message) : SVO_OK;
}

/* Renames FROM/NAME to TO/NAME. Returns an errno. */
static int move(const char *from_folder, const char *to_folder, const char *name)
{
    char *from = svo_i_path_join(from_folder, name);
    char *to = svo_i_path_join(to_folder, name);
    const int error = from == NULL || to == NULL ? ENOMEM : rename(from, to) == 0 ? 0 : errno;
    svo_i_free(from);
    svo_i_free(to);
    return error;
}

/* What is moved out of a folder: the names that choose selects. */
typedef struct moving {
    const char *from;
    const char *to;
    bool (*choose)(const char *name, const char *kept);
    const char *kept;
} moving;

/* Returns an errno. */
static int move_chosen(const moving *m)
{
    DIR *opened = opendir(m->from);
    if (opened == NULL) {
        return errno;
    }
    int error = 0;
    const struct dirent *entry = NULL;
    do {
        errno = 0;
        entry = readdir(opened);
        error = entry == NULL ? errno : 0;
        if (entry != NULL && m->choose(entry->d_name, m->kept)) {
            error = move(m->from, m->to, entry->d_name);
        }
    } while (entry != NULL && error == 0);
    (void)closedir(opened);
    return error;
}

static bool is_any(const char *name, const char *kept)
{
    (void)kept;
    return strcmp(name, ".") != 0 && strcmp(name, "..") != 0;
}

/* The plan's files get their place. */
static int install(const svo_parts *parts, const char *place)
{
    const int error = rename(parts->place, place) == 0 ? 0 : errno;
    const moving all = {.from = parts->place, .to = place, .choose = is_any};
    return error == EEXIST || error == ENOTEMPTY ? move_chosen(&all) : error;
}

/* Removes what is of other plans. What stays in the end does no harm, so failures are not told. */
static void remove_others(const svo_parts *parts, const char *kept)
{
    char *old = svo_i_path_join(parts->planner.held, "old");
    if (old != NULL && mkdir(old, 0777) == 0) {
        const moving others = {parts->folder, old, svo_i_folder_is_of_other_plans, kept};
        (void)move_chosen(&others);
    }
    svo_i_free(old);
}

svo_status svo_i_planning_switch(svo_parts *parts, svo_message *message)
{
    svo_i_identity_text name;
    svo_i_part_identity(&parts->header, parts->identity);
    svo_i_identity_write(parts->identity, name);
    char *place = svo_i_path_join(parts->folder, name);
    char *plan = svo_i_path_join(parts->planner.held, PLAN_NAME);
    char *target = svo_i_path_join(parts->folder, PLAN_NAME);
    svo_status status = place != NULL && plan != NULL && target != NULL ? svo_i_folder_save(parts, plan, message)
                                                                        : svo_i_folder_no_memory(parts, message);
    if (status == SVO_OK) {
        int error = install(parts, place);
        error = error == 0 && rename(plan, target) != 0 ? errno : error;
        status = error == 0 ? SVO_OK : fail_errno(parts, message, "the plan cannot be put in its place", error);
    }
    if (status == SVO_OK) {
        remove_others(parts, name);
    }
    svo_i_free(target);
    svo_i_free(plan);
    svo_i_free(place);
    return status;
}
