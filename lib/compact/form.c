/* SPDX-License-Identifier: MIT */
/* The table of forms. */
#include "compact/form.h"

#include "compact/descriptor.h"
#include "compact/implied.h"

#define CL12    "-cl-std=CL1.2"
#define IMPLIED " -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2="
#define PLACES  " -DSVO_HAS_BASES"
#define WORDS   " -DSVO_READ_DESCRIPTOR"

const char *svo_i_form_options(const svo_compact_info *info)
{
    static const char *const implied[3][2] = {{CL12 IMPLIED "4", CL12 IMPLIED "4" PLACES},
                                              {CL12 IMPLIED "5", CL12 IMPLIED "5" PLACES},
                                              {CL12 IMPLIED "6", CL12 IMPLIED "6" PLACES}};
    const bool places = svo_i_compact_has_places(info);
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
    (void)form;
    return 3 * sizeof(cl_uint);
}

void svo_i_form_count(svo_compact_info *info)
{
    if (info->form == SVO_FORM_IMPLIED) {
        svo_i_implied_count(info);
    } else {
        svo_i_descriptor_count(info);
    }
    svo_i_compact_count(info);
}

svo_status svo_i_form_make(svo_i_compact_work *work, const svo_i_compact_source *source, svo_compact *compact)
{
    return source->info.form == SVO_FORM_IMPLIED ? svo_i_implied_make(work, source, compact)
                                                 : svo_i_descriptor_make(work, source, compact);
}
