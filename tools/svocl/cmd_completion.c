/* SPDX-License-Identifier: MIT */
/* svocl completion: functions of bash, zsh and fish that complete command lines, from the tables of commands and
   options. */
#include <stdio.h>
#include <string.h>

#include "scenes/scenes.h"
#include "support/options_rules.h"
#include "support/output.h"
#include "support/subjects.h"
#include "svocl/commands.h"

#define SHELLS "bash zsh fish"

typedef void script_writer(const program *state, FILE *script);

static bool is_value(const rule *option, const char *value_name)
{
    return option->value_name != NULL && strcmp(option->value_name, value_name) == 0;
}

/* The names that a value may have, with spaces between. */
static void put_choices(FILE *script, const choice *choices)
{
    for (const choice *one = choices; one->name != NULL; ++one) {
        fprintf(script, "%s%s", one == choices ? "" : " ", one->name);
    }
}

static void put_scenes(FILE *script)
{
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        fprintf(script, "%s%s", i == 0 ? "" : " ", scene_describe(i)->name);
    }
}

static void put_subjects(FILE *script)
{
    for (size_t i = 0; i < SUBJECT_COUNT; ++i) {
        fprintf(script, "%s ", subject_table[i].name);
    }
    fputs("all errors " BENCH_GPU_NAME " " BENCH_VERSUS_NAME, script);
}

static void put_commands(FILE *script, const program *state)
{
    for (size_t i = 0; i < state->command_count; ++i) {
        fprintf(script, "%s%s", i == 0 ? "" : " ", state->commands[i].name);
    }
}

/* What the argument of a command may be. */
typedef enum argument_kind {
    ARGUMENT_NONE,
    ARGUMENT_INPUT,
    ARGUMENT_FILE,
    ARGUMENT_SCENE,
    ARGUMENT_SUBJECT,
    ARGUMENT_SHELL,
    ARGUMENT_COMMAND
} argument_kind;

static argument_kind kind_of(const command *which)
{
    return which->input_name == NULL                     ? ARGUMENT_NONE
           : strcmp(which->input_name, "INPUT") == 0     ? ARGUMENT_INPUT
           : strcmp(which->input_name, "A B") == 0       ? ARGUMENT_INPUT
           : strcmp(which->input_name, "FILE") == 0      ? ARGUMENT_FILE
           : strcmp(which->input_name, "IN OUT") == 0    ? ARGUMENT_INPUT
           : strcmp(which->input_name, "IN SCRIPT") == 0 ? ARGUMENT_INPUT
           : strcmp(which->input_name, "NAME") == 0      ? ARGUMENT_SCENE
           : strcmp(which->input_name, "SHELL") == 0     ? ARGUMENT_SHELL
           : strcmp(which->input_name, "COMMAND") == 0   ? ARGUMENT_COMMAND
                                                         : ARGUMENT_SUBJECT;
}

/* ---- bash ---- */

/* bash splits words at = and : too, so that --option=value and scene:NAME come in three. */
static const char bash_begin[] =
    "# Completion of svocl for bash, made by `svocl completion bash`.\n"
    "\n"
    "_svocl_words()\n"
    "{\n"
    "    mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"$2\")\n"
    "}\n"
    "\n"
    "_svocl_paths()\n"
    "{\n"
    "    compopt -o filenames\n"
    "    mapfile -t COMPREPLY < <(compgen \"$1\" -- \"$2\")\n"
    "}\n"
    "\n"
    "# The last name of a list with commas.\n"
    "_svocl_list()\n"
    "{\n"
    "    local before=\n"
    "    [[ $2 != *,* ]] || before=${2%,*},\n"
    "    compopt -o nospace\n"
    "    mapfile -t COMPREPLY < <(compgen -P \"$before\" -W \"$1\" -- \"${2##*,}\")\n"
    "}\n"
    "\n"
    "# A file, or scene:NAME.\n"
    "_svocl_input()\n"
    "{\n"
    "    _svocl_paths -f \"$1\"\n"
    "    if [[ -n $1 && scene: == \"$1\"* ]]; then\n"
    "        COMPREPLY+=(scene:)\n"
    "        compopt -o nospace\n"
    "    fi\n"
    "}\n"
    "\n"
    "_svocl()\n"
    "{\n"
    "    local command=${COMP_WORDS[1]} current=$2 previous=${COMP_WORDS[COMP_CWORD - 1]}\n"
    "    COMPREPLY=()\n"
    "    if [[ $current == [=:] ]]; then\n"
    "        current=\n"
    "    fi\n"
    "    if [[ ${COMP_WORDS[COMP_CWORD]} == [=:] ]]; then\n"
    "        previous=${COMP_WORDS[COMP_CWORD]}:${COMP_WORDS[COMP_CWORD - 1]}\n"
    "    elif [[ $previous == [=:] ]]; then\n"
    "        previous=$previous:${COMP_WORDS[COMP_CWORD - 2]}\n"
    "    fi\n"
    "    previous=${previous#=:}\n";

static void put_bash_values(FILE *script)
{
    fputs("    case $previous in\n    ::scene)\n        _svocl_words '", script);
    put_scenes(script);
    fputs("' \"$current\"\n        return\n        ;;\n", script);
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        const rule *option = options_rule(i);
        if (option->value_name == NULL) {
            continue;
        }
        fprintf(script, "    --%s", option->name);
        if (option->letter != '\0') {
            fprintf(script, " | -%c", option->letter);
        }
        fputs(")\n", script);
        if (option->choices != NULL) {
            fprintf(script, "        %s '", is_value(option, "LIST") ? "_svocl_list" : "_svocl_words");
            put_choices(script, option->choices);
            fputs("' \"$current\"\n", script);
        } else if (is_value(option, "FILE") || is_value(option, "DIR")) {
            fprintf(script, "        _svocl_paths %s \"$current\"\n", is_value(option, "DIR") ? "-d" : "-f");
        }
        fputs("        return\n        ;;\n", script);
    }
    fputs("    esac\n", script);
}

static void put_bash_argument(FILE *script, const program *state, const command *which)
{
    switch (kind_of(which)) {
    case ARGUMENT_NONE:
        return;
    case ARGUMENT_INPUT:
        fputs("        _svocl_input \"$current\"\n", script);
        return;
    case ARGUMENT_FILE:
        fputs("        _svocl_paths -f \"$current\"\n", script);
        return;
    case ARGUMENT_SCENE:
        fputs("        _svocl_words '", script);
        put_scenes(script);
        break;
    case ARGUMENT_SUBJECT:
        fputs("        _svocl_words '", script);
        put_subjects(script);
        break;
    case ARGUMENT_SHELL:
        fputs("        _svocl_words '" SHELLS, script);
        break;
    case ARGUMENT_COMMAND:
        fputs("        _svocl_words '", script);
        put_commands(script, state);
        break;
    }
    fputs("' \"$current\"\n", script);
}

static void put_bash_command(FILE *script, const program *state, const command *which)
{
    fprintf(script, "    %s)\n        if [[ $current == -* ]]; then\n            _svocl_words '", which->name);
    const char *space = "";
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        if (options_apply(options_rule(i), which)) {
            fprintf(script, "%s--%s", space, options_rule(i)->name);
            space = " ";
        }
    }
    fputs("' \"$current\"\n            return\n        fi\n", script);
    put_bash_argument(script, state, which);
    fputs("        ;;\n", script);
}

static void write_bash(const program *state, FILE *script)
{
    fputs(bash_begin, script);
    fputs("    if ((COMP_CWORD == 1)); then\n        _svocl_words '", script);
    put_commands(script, state);
    fputs(" help --help --version' \"$current\"\n        return\n    fi\n", script);
    put_bash_values(script);
    fputs("    case $command in\n    help)\n        _svocl_words '", script);
    put_commands(script, state);
    fputs("' \"$current\"\n        ;;\n", script);
    for (size_t i = 0; i < state->command_count; ++i) {
        put_bash_command(script, state, &state->commands[i]);
    }
    fputs("    esac\n}\n\ncomplete -F _svocl svocl\n", script);
}

/* ---- zsh ---- */

/* A text in single quotes, where a bracket or a colon would end it. */
static void put_zsh_text(FILE *script, const char *text)
{
    for (const char *c = text; *c != '\0'; ++c) {
        if (*c == '\'') {
            fputs("'\\''", script);
        } else {
            fputs(strchr("[]:\\", *c) != NULL ? "\\" : "", script);
            fputc(*c, script);
        }
    }
}

static void put_zsh_option(FILE *script, const rule *option)
{
    if (option->letter != '\0') {
        fprintf(script, " \\\n            '(-%c --%s)'{-%c,--%s}'[", option->letter, option->name, option->letter,
                option->name);
    } else {
        fprintf(script, " \\\n            '--%s[", option->name);
    }
    put_zsh_text(script, option->help);
    fputs("]", script);
    if (option->value_name != NULL) {
        fputs(":", script);
        put_zsh_text(script, option->value_name);
        fputs(":", script);
    }
    if (option->choices != NULL) {
        fputs(is_value(option, "LIST") ? "_values -s , name " : "(", script);
        put_choices(script, option->choices);
        fputs(is_value(option, "LIST") ? "" : ")", script);
    } else if (is_value(option, "FILE") || is_value(option, "DIR")) {
        fputs(is_value(option, "DIR") ? "_files -/" : "_files", script);
    }
    fputs("'", script);
}

static void put_zsh_argument(FILE *script, const program *state, const command *which)
{
    const argument_kind kind = kind_of(which);
    if (kind == ARGUMENT_NONE) {
        return;
    }
    fprintf(script, " \\\n            '1:%s:", which->input_name);
    if (kind == ARGUMENT_INPUT || kind == ARGUMENT_FILE) {
        fputs(kind == ARGUMENT_INPUT ? "_svocl_input" : "_files", script);
    } else {
        fputs("(", script);
        if (kind == ARGUMENT_SCENE) {
            put_scenes(script);
        } else if (kind == ARGUMENT_SUBJECT) {
            put_subjects(script);
        } else if (kind == ARGUMENT_COMMAND) {
            put_commands(script, state);
        } else {
            fputs(SHELLS, script);
        }
        fputs(")", script);
    }
    fputs("'", script);
    if (kind == ARGUMENT_SUBJECT) {
        fputs(" \\\n            '2:INPUT:_svocl_input'", script);
    }
    if ((which->groups & OPTION_DIFF_COMMAND) != 0) {
        fputs(" \\\n            '2:B:_svocl_input'", script);
    }
    if ((which->groups & OPTION_EDIT_COMMAND) != 0) {
        fputs(" \\\n            '2:SCRIPT:_files'", script);
    }
    if ((which->groups & (unsigned)OPTION_CONVERT_COMMAND) != 0) {
        fputs(" \\\n            '2:OUT:_files'", script);
    }
}

static void write_zsh(const program *state, FILE *script)
{
    fputs("#compdef svocl\n# Completion of svocl for zsh, made by `svocl completion zsh`.\n\n"
          "_svocl_input()\n{\n    _alternative 'files:file:_files' 'scenes:scene:(",
          script);
    for (size_t i = 0; scene_describe(i) != NULL; ++i) {
        fprintf(script, "%sscene\\:%s", i == 0 ? "" : " ", scene_describe(i)->name);
    }
    fputs(")'\n}\n\n_svocl()\n{\n    local -a commands\n    commands=(\n", script);
    for (size_t i = 0; i < state->command_count; ++i) {
        fprintf(script, "        '%s:", state->commands[i].name);
        put_zsh_text(script, state->commands[i].summary);
        fputs("'\n", script);
    }
    fputs("        'help:Prints the options of a command.'\n    )\n"
          "    if ((CURRENT == 2)); then\n        _describe -t commands command commands\n        return\n    fi\n"
          "    local command=$words[2]\n    shift words\n    ((CURRENT--))\n    case $command in\n"
          "    help)\n        ((CURRENT == 2)) && _describe -t commands command commands\n        ;;\n",
          script);
    for (size_t i = 0; i < state->command_count; ++i) {
        const command *which = &state->commands[i];
        fprintf(script, "    %s)\n        _arguments -s", which->name);
        for (size_t k = 0; options_rule(k) != NULL; ++k) {
            if (options_apply(options_rule(k), which)) {
                put_zsh_option(script, options_rule(k));
            }
        }
        put_zsh_argument(script, state, which);
        fputs("\n        ;;\n", script);
    }
    fputs("    esac\n}\n\n"
          "# In fpath this file is the function's body; read by source, it registers the function.\n"
          "if [[ $funcstack[1] == _svocl ]]; then\n    _svocl \"$@\"\nelse\n    compdef _svocl svocl\nfi\n",
          script);
}

/* ---- fish ---- */

static const char fish_begin[] =
    "# Completion of svocl for fish, made by `svocl completion fish`.\n"
    "\n"
    "# Whether the command is one of these.\n"
    "function __svocl_is\n"
    "    set -l words (commandline -opc)\n"
    "    test (count $words) -gt 1; and contains -- $words[2] $argv\n"
    "end\n"
    "\n"
    "# Names for the end of a list with commas.\n"
    "function __svocl_list\n"
    "    set -l before (commandline -ct | string replace -r '^--[a-z-]+=' '' | string match -r '.*,')\n"
    "    printf '%s\\n' \"$before\"$argv\n"
    "end\n"
    "\n"
    "complete -c svocl -f\n"
    "complete -c svocl -n __fish_use_subcommand -l help -d 'Prints the commands.'\n"
    "complete -c svocl -n __fish_use_subcommand -l version -d 'Prints the version.'\n"
    "complete -c svocl -n __fish_use_subcommand -a help -d 'Prints the options of a command.'\n";

/* A text in single quotes. */
static void put_fish_text(FILE *script, const char *text)
{
    fputc('\'', script);
    for (const char *c = text; *c != '\0'; ++c) {
        fputs(*c == '\'' || *c == '\\' ? "\\" : "", script);
        fputc(*c, script);
    }
    fputc('\'', script);
}

/* The option for all commands that have it. */
static void put_fish_option(FILE *script, const program *state, const rule *option)
{
    fputs("complete -c svocl -n '__svocl_is", script);
    for (size_t i = 0; i < state->command_count; ++i) {
        if (options_apply(option, &state->commands[i])) {
            fprintf(script, " %s", state->commands[i].name);
        }
    }
    fprintf(script, "' -l %s", option->name);
    if (option->letter != '\0') {
        fprintf(script, " -s %c", option->letter);
    }
    if (option->choices != NULL) {
        fputs(is_value(option, "LIST") ? " -x -a '(__svocl_list " : " -x -a '", script);
        put_choices(script, option->choices);
        fputs(is_value(option, "LIST") ? ")'" : "'", script);
    } else if (is_value(option, "DIR")) {
        fputs(" -x -a '(__fish_complete_directories (commandline -ct))'", script);
    } else if (option->value_name != NULL) {
        fputs(is_value(option, "FILE") ? " -r -F" : " -x", script);
    }
    fputs(" -d ", script);
    put_fish_text(script, option->help);
    fputc('\n', script);
}

static void put_fish_argument(FILE *script, const program *state, const command *which)
{
    const argument_kind kind = kind_of(which);
    if (kind == ARGUMENT_NONE) {
        return;
    }
    fprintf(script, "complete -c svocl -n '__svocl_is %s'", which->name);
    fputs(kind == ARGUMENT_INPUT || kind == ARGUMENT_FILE || kind == ARGUMENT_SUBJECT ? " -F" : "", script);
    if (kind != ARGUMENT_FILE) {
        fputs(" -a '", script);
        if (kind == ARGUMENT_INPUT) {
            for (size_t i = 0; scene_describe(i) != NULL; ++i) {
                fprintf(script, "%sscene:%s", i == 0 ? "" : " ", scene_describe(i)->name);
            }
        } else if (kind == ARGUMENT_SCENE) {
            put_scenes(script);
        } else if (kind == ARGUMENT_SUBJECT) {
            put_subjects(script);
        } else if (kind == ARGUMENT_COMMAND) {
            put_commands(script, state);
        } else {
            fputs(SHELLS, script);
        }
        fputs("'", script);
    }
    fputc('\n', script);
}

static void write_fish(const program *state, FILE *script)
{
    fputs(fish_begin, script);
    fputs("complete -c svocl -n '__svocl_is help' -a '", script);
    put_commands(script, state);
    fputs("'\n", script);
    for (size_t i = 0; i < state->command_count; ++i) {
        fprintf(script, "complete -c svocl -n __fish_use_subcommand -a %s -d ", state->commands[i].name);
        put_fish_text(script, state->commands[i].summary);
        fputc('\n', script);
        put_fish_argument(script, state, &state->commands[i]);
    }
    for (size_t i = 0; options_rule(i) != NULL; ++i) {
        put_fish_option(script, state, options_rule(i));
    }
}

/* ---- the command ---- */

int command_completion(program *state)
{
    const options *given = &state->options;
    script_writer *write = strcmp(given->input, "bash") == 0   ? write_bash
                           : strcmp(given->input, "zsh") == 0  ? write_zsh
                           : strcmp(given->input, "fish") == 0 ? write_fish
                                                               : NULL;
    if (write == NULL) {
        return program_fail(state, PROGRAM_WRONG_USAGE, "SHELL '%s' is none of bash, zsh, fish", given->input);
    }
    if (given->output_path == NULL) {
        write(state, stdout);
        return PROGRAM_DONE;
    }
    output_file file;
    const int exit_code = output_open(state, given->output_path, &file);
    if (exit_code != PROGRAM_DONE) {
        return exit_code;
    }
    write(state, file.stream);
    return output_commit(state, &file);
}
