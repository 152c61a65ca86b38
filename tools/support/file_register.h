/* SPDX-License-Identifier: MIT */
/*
 * The files that a run reads and writes, by device and inode, so that no output takes the place of an input or of
 * another output, whatever links lead there. support/output.h refuses on the command line's behalf; the viewer asks for
 * the files that it saves.
 */
#ifndef SVOCL_TOOLS_SUPPORT_FILE_REGISTER_H
#define SVOCL_TOOLS_SUPPORT_FILE_REGISTER_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/stat.h>

typedef struct file_entry {
    dev_t device;
    ino_t inode;
    char *name; /* by malloc */
    bool is_output;
    bool is_written; /* the output is complete: whoever reads it reads no input */
} file_entry;

typedef struct file_register file_register;
struct file_register {
    file_entry *entries;
    size_t count, capacity;
};

/* In place of a name, where there was no memory for an entry. */
extern const char file_register_no_memory[];

/* Notes a file or folder that is read. Returns the name of the output that it is to be, or NULL. */
const char *file_register_read(file_register *files, const struct stat *entry, const char *name);

/* Notes an output, over a file that is there. Returns the name of the input or of the other output that it is, or
   NULL. */
const char *file_register_write(file_register *files, const struct stat *entry, const char *name);

/* The output of that name is complete, and is this file now. */
void file_register_written(file_register *files, const struct stat *entry, const char *name);

/* The name of the input that a path leads to, or that is the folder of the path; NULL: none. */
const char *file_register_input_at(const file_register *files, const char *path);

/* Whether a name that was returned is that of an output. */
bool file_register_is_output(const file_register *files, const char *name);

/* Forgets an input that is meant to be replaced. */
void file_register_forget(file_register *files, const char *name);

void file_register_free(file_register *files);

#endif
