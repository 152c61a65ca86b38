/* SPDX-License-Identifier: MIT */
/*
 * What other rooms keep with a handle of the core: compiled programs with a device, a BVH with a tree. The handle owns
 * these attachments and destroys them without knowing what they are, so that the core includes no other room.
 */
#ifndef SVO_LIB_CORE_ATTACHMENT_H
#define SVO_LIB_CORE_ATTACHMENT_H

typedef struct svo_i_attachment svo_i_attachment;

/* Releases what is attached, and the attachment itself. */
typedef void (*svo_i_attachment_destroy)(svo_i_attachment *attachment);

/* Tells what is attached that the handle's content changes. Returns 0 if it is of no use then. */
typedef int (*svo_i_attachment_outdate)(svo_i_attachment *attachment);

/* The first member of every struct that is attached. */
struct svo_i_attachment {
    svo_i_attachment *next; /* of the same handle */
    svo_i_attachment_destroy destroy; /* not NULL; also says what is attached, see svo_i_attachment_find */
    svo_i_attachment_outdate outdate; /* NULL: it is of no use when the content changes */
};

/* Adds an attachment to the list, which owns it from now on. */
void svo_i_attachment_add(svo_i_attachment **list, svo_i_attachment *attachment);

/* The newest attachment that destroy would release, or NULL. */
svo_i_attachment *svo_i_attachment_find(svo_i_attachment *list, svo_i_attachment_destroy destroy);

/* Destroys the attachments that are of no use when the handle's content changes. */
void svo_i_attachments_outdate(svo_i_attachment **list);

/* Destroys all attachments, the newest first, and sets *list to NULL. */
void svo_i_attachments_clear(svo_i_attachment **list);

#endif
