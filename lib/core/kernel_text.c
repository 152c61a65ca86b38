/* SPDX-License-Identifier: MIT */
/* The order of kernel files in the text of a program. */
#include "core/kernel_text.h"

static bool is_listed(const svo_i_kernel_texts *texts, const svo_i_kernel_text *file)
{
    for (size_t i = 0; i < texts->count; ++i) {
        if (texts->files[i] == file) {
            return true;
        }
    }
    return false;
}

/* Adds what the file includes, then the file. */
static void add(svo_i_kernel_texts *texts, const svo_i_kernel_text *file)
{
    if (is_listed(texts, file)) {
        return;
    }
    for (size_t i = 0; file->includes[i] != NULL; ++i) {
        add(texts, file->includes[i]);
    }
    if (texts->count < SVO_I_KERNEL_TEXTS_MAX) {
        texts->files[texts->count++] = file;
    } else {
        texts->is_cut = true;
    }
}

void svo_i_kernel_texts_list(const svo_i_kernel_text *const *files, svo_i_kernel_texts *out)
{
    out->count = 0;
    out->is_cut = false;
    for (size_t i = 0; files[i] != NULL; ++i) {
        add(out, files[i]);
    }
}
