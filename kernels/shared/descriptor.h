/* SPDX-License-Identifier: MIT */
/* The words of SVO_FORM_DESCRIPTOR (svocl/compact.h), for kernels and for the host. */
#ifndef SVO_KERNELS_SHARED_DESCRIPTOR_H
#define SVO_KERNELS_SHARED_DESCRIPTOR_H

#define SVO_WORD_LEAF_SHIFT     8 /* below it the valid mask */
#define SVO_WORD_FAR            0x10000u
#define SVO_WORD_DISTANCE_SHIFT 17
#define SVO_WORD_DISTANCE_MAX   32767u

#endif
