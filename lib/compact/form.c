/* SPDX-License-Identifier: MIT */
/* The table of forms. */
#include "compact/form.h"

#include "compact/descriptor.h"
#include "compact/implied.h"
#include "compact/shared.h"

#define CL12    "-cl-std=CL1.2"
#define IMPLIED " -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2="
#define PLACES  " -DSVO_HAS_BASES"
#define WORDS   " -DSVO_READ_DESCRIPTOR"
#define SHARED  " -DSVO_READ_SHARED"

const char *svo_i_form_options(const svo_compact_info *info)
{
    static const char *const implied[3][2] = {{CL12 IMPLIED "4", CL12 IMPLIED "4" PLACES},
                                              {CL12 IMPLIED "5", CL12 IMPLIED "5" PLACES},
                                              {CL12 IMPLIED "6", CL12 IMPLIED "6" PLACES}};
    const bool places = svo_i_compact_has_places(info);
    if (info->form == SVO_FORM_SHARED) {
        return places ? CL12 SHARED PLACES : CL12 SHARED;
    }
    if (info->form == SVO_FORM_IMPLIED) {
        return implied[info->directory_step_log2 - SVO_I_DIRECTORY_LOG2_MIN][places ? 1 : 0];
    }
    return places ? CL12 WORDS PLACES : CL12 WORDS;
}

const char *svo_i_form_defines(const svo_compact_info *info)
{
    return svo_i_form_options(info) + sizeof CL12 - 1;
}

size_t svo_i_form_expanded_bytes(svo_form form)
{
    const size_t node_words = form == SVO_FORM_SHARED ? 3 : 1;
    return (node_words + 2) * sizeof(cl_uint);
}

void svo_i_form_count(svo_compact_info *info)
{
    switch (info->form) {
    case SVO_FORM_DESCRIPTOR:
        svo_i_descriptor_count(info);
        break;
    case SVO_FORM_IMPLIED:
        svo_i_implied_count(info);
        break;
    default:
        svo_i_shared_count(info);
        break;
    }
    svo_i_compact_count(info);
}

svo_status svo_i_form_make(svo_i_device_work *work, const svo_i_compact_source *source, svo_compact *compact)
{
    switch (source->info.form) {
    case SVO_FORM_IMPLIED:
        return svo_i_implied_make(work, source, compact);
    case SVO_FORM_SHARED:
        return svo_i_shared_make(work, source, compact);
    default:
        return svo_i_descriptor_make(work, source, compact);
    }
}
