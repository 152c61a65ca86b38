/* SPDX-License-Identifier: MIT */
/* The table of forms. */
#include "compact/form.h"

#include "compact/descriptor.h"
#include "compact/implied.h"

const char *svo_i_form_defines(const svo_compact_info *info)
{
    static const char *const implied[3][2] = {
        {" -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=4", " -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=4 -DSVO_HAS_BASES"},
        {" -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=5", " -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=5 -DSVO_HAS_BASES"},
        {" -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=6", " -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=6 -DSVO_HAS_BASES"}};
    const bool bases = svo_i_compact_has_places(info);
    if (info->form == SVO_FORM_IMPLIED) {
        return implied[info->directory_step_log2 - SVO_I_DIRECTORY_LOG2_MIN][bases ? 1 : 0];
    }
    return bases ? " -DSVO_READ_DESCRIPTOR -DSVO_HAS_BASES" : " -DSVO_READ_DESCRIPTOR";
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
