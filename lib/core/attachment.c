/* SPDX-License-Identifier: MIT */
/* Lists of what other rooms keep with a device or a tree. */
#include "core/attachment.h"

#include <stddef.h>

void svo_i_attachment_add(svo_i_attachment **list, svo_i_attachment *attachment)
{
    attachment->next = *list;
    *list = attachment;
}

svo_i_attachment *svo_i_attachment_find(svo_i_attachment *list, svo_i_attachment_destroy destroy)
{
    while (list != NULL && list->destroy != destroy) {
        list = list->next;
    }
    return list;
}

void svo_i_attachments_outdate(svo_i_attachment **list)
{
    while (*list != NULL) {
        svo_i_attachment *attachment = *list;
        if (attachment->outdate != NULL && attachment->outdate(attachment) != 0) {
            list = &attachment->next;
        } else {
            *list = attachment->next;
            attachment->destroy(attachment);
        }
    }
}

void svo_i_attachments_clear(svo_i_attachment **list)
{
    while (*list != NULL) {
        svo_i_attachment *attachment = *list;
        *list = attachment->next;
        attachment->destroy(attachment);
    }
}
