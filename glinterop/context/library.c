/* SPDX-License-Identifier: MIT */
/* Libraries loaded at run time and extension lists, below egl.c, osmesa.c and context.c. */
#define _POSIX_C_SOURCE 200809L
#include "context/library.h"

#include <dlfcn.h>
#include <stddef.h>
#include <string.h>
#include <strings.h>

#include "core/message.h"

svo_status svo_i_library_open(const char *file_name, void **library, svo_message *message)
{
    void *opened = dlopen(file_name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (opened == NULL) {
        const char *words = dlerror(); /* names the file itself */
        return svo_i_fail(message, SVO_NO_GL, "svo_gl_context_create: %s%s", words != NULL ? words : file_name,
                          words != NULL ? "" : " cannot be opened");
    }
    *library = opened;
    return SVO_OK;
}

void *svo_i_library_if_loaded(const char *file_name)
{
    return dlopen(file_name, RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD);
}

void svo_i_library_close(void *library)
{
    if (library != NULL) {
        (void)dlclose(library);
    }
}

svo_i_function svo_i_library_function(void *library, const char *name)
{
    /* POSIX lets dlsym return a function, but ISO C has no cast for it: copy the bytes. */
    void *symbol = dlsym(library, name);
    svo_i_function function;
    _Static_assert(sizeof function == sizeof symbol, "function pointers are as wide as object pointers");
    memcpy(&function, &symbol, sizeof function);
    return function;
}

void *svo_i_library_ask(const char *file_name, const char *function_name)
{
    typedef void *(*ask_function)(void);
    void *library = svo_i_library_if_loaded(file_name);
    const ask_function ask = library != NULL ? (ask_function)svo_i_library_function(library, function_name) : NULL;
    void *answer = ask != NULL ? ask() : NULL;
    svo_i_library_close(library);
    return answer;
}

bool svo_i_list_has_token(const char *list, const char *token)
{
    size_t length = strlen(token);
    if (list == NULL || length == 0) {
        return false;
    }
    for (const char *at = strstr(list, token); at != NULL; at = strstr(at + length, token)) {
        bool starts = at == list || at[-1] == ' ';
        bool ends = at[length] == ' ' || at[length] == '\0';
        if (starts && ends) {
            return true;
        }
    }
    return false;
}

bool svo_i_text_contains(const char *text, const char *part)
{
    const size_t length = strlen(part);
    for (; length > 0 && *text != '\0'; ++text) {
        if (strncasecmp(text, part, length) == 0) {
            return true;
        }
    }
    return false;
}
