/* SPDX-License-Identifier: MIT */
/* The table of forms. */
#include "compact/form.h"

#include "compact/descriptor.h"
#include "compact/implied.h"
#include "compact/shared.h"

const char *svo_i_form_defines(const svo_compact_info *info)
{
    static const char *const implied[3][2] = {
        {" -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=4", " -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=4 -DSVO_HAS_BASES"},
        {" -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=5", " -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=5 -DSVO_HAS_BASES"},
        {" -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=6", " -DSVO_READ_IMPLIED -DSVO_DIRECTORY_LOG2=6 -DSVO_HAS_BASES"}};
    const bool bases = svo_i_compact_has_places(info);
    if (info->form == SVO_FORM_SHARED) {
        return bases ? " -DSVO_READ_SHARED -DSVO_HAS_BASES" : " -DSVO_READ_SHARED";
    }
    if (info->form == SVO_FORM_IMPLIED) {
        return implied[info->directory_step_log2 - SVO_I_DIRECTORY_LOG2_MIN][bases ? 1 : 0];
    }
    return bases ? " -DSVO_READ_DESCRIPTOR -DSVO_HAS_BASES" : " -DSVO_READ_DESCRIPTOR";
}

size_t svo_i_form_expanded_bytes(svo_form form)
{
    const size_t node_words = form == SVO_FORM_SHARED ? 3 : 1;
    return (node_words + 2) * sizeof(cl_uint);
}

void svo_i_form_count(svo_compact_info *info)
{
    void (*const counts[SVO_FORM_COUNT])(svo_compact_info *) = {[SVO_FORM_DESCRIPTOR] = svo_i_descriptor_count,
                                                                [SVO_FORM_IMPLIED] = svo_i_implied_count,
                                                                [SVO_FORM_SHARED] = svo_i_shared_count};
    counts[info->form](info);
    svo_i_compact_count(info);
}

svo_status svo_i_form_make(svo_i_compact_work *work, const svo_i_compact_source *source, svo_compact *compact)
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
