/* SPDX-License-Identifier: MIT */
/*
 * Kernel files as the library holds them, one object each, so that a static program links the files of the programs
 * that it uses and no others. cmake/embed_kernel.cmake makes svo_i_text_FOLDER_FILE_EXTENSION of each file of kernels/
 * and of the public headers that they include.
 */
#ifndef SVO_LIB_CORE_KERNEL_TEXT_H
#define SVO_LIB_CORE_KERNEL_TEXT_H

#include <stdbool.h>
#include <stddef.h>

typedef struct svo_i_kernel_text {
    const char *text; /* after a #line with the file's name; without comments and #include "..." lines */
    const struct svo_i_kernel_text *const *includes; /* the files of these lines, in their order; the last is NULL */
} svo_i_kernel_text;

/* The most files of a program. */
#define SVO_I_KERNEL_TEXTS_MAX 96

/* The text of a program in pieces: of its files and of those that they include. Each file comes once, before the first
   that includes it, whatever #if stands around that line. */
typedef struct svo_i_kernel_texts {
    const svo_i_kernel_text *files[SVO_I_KERNEL_TEXTS_MAX];
    size_t count;
    bool is_cut; /* there are more: a mistake in the library */
} svo_i_kernel_texts;

/* Lists the files. files: the last is NULL. */
void svo_i_kernel_texts_list(const svo_i_kernel_text *const *files, svo_i_kernel_texts *out);

#endif
