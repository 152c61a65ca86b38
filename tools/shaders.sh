# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# `tools/dev check`: every variant of the shaders of glinterop, as drivers get it, compiles with glslang at the version
# of GLSL that it states. tools/dev sources this file, which uses its functions and settings.
# shellcheck disable=SC2154

readonly int64_lines=$'#extension GL_ARB_gpu_shader_int64 : require\n#define SVO_INT64\n'

# shader_text FILE...: their text; a file that is included comes first, and once.
shader_text()
{
    awk '
        function has(path,    line, found) { found = (getline line <path) > 0; close(path); return found }
        function find(path, name) {
            sub(/[^\/]*$/, "", path)
            return has(path name) ? path name : has("kernels/" name) ? "kernels/" name : "include/" name
        }
        function put(path,    line, text) {
            if (path in seen) return
            seen[path]
            while ((getline line <path) > 0) {
                if (line !~ /^#include "/) { text = text line "\n"; continue }
                gsub(/^[^"]*"|".*$/, "", line)
                put(find(path, line))
            }
            printf "%s", text
        }
        BEGIN { for (i = 1; i < ARGC; ++i) put(ARGV[i]) }' "$@"
}

# As raster/raster.c and raster/light_view.c put them together, in a folder.
put_raster_shaders()
{
    local folder=$1 place=glinterop/raster/shaders stage text class code thin reach int64 count=0
    for stage in vert frag; do
        text=$(shader_text $place/light_view.{glsl,"$stage"})
        printf '#version 430 core\n%s\n' "$text" >"$folder/light_view.$stage"
        text=$(shader_text $place/{triangle.glsl,raster."$stage"})
        for class in $'#define SVO_POINT\n' $'#define SVO_NARROW\n' '' $'#define SVO_WIDE\n'; do
            for code in '' $'#define SVO_CODE48\n'; do
                for thin in '' $'#define SVO_THIN\n'; do
                    for reach in 0.0 0.0625 0.5625; do
                        for int64 in '' "$int64_lines"; do
                            count=$((count + 1))
                            printf '#version 430 core\n%s#define SVO_REACH %s\n%s\n' "$int64$class$code$thin" "$reach" \
                                "$text" >"$folder/raster$count.$stage"
                        done
                    done
                done
            done
        done
    done
}

# The defines that select what a shader of the builder makes: lines of names without their SVO_.
payload_defines()
{
    local color normal weights fill areas code
    for color in '' COLOR 'COLOR '{VERTEX_COLOR,TEXTURE,'VERTEX_COLOR TEXTURE'}; do
        for normal in '' NORMAL 'NORMAL VERTEX_NORMAL'; do
            for weights in '' WEIGHTS_AREA WEIGHTS_CENTER; do
                for fill in '' FILL; do
                    for areas in '' AREAS; do
                        for code in '' CODE48; do
                            printf '%s\n' "$color $normal $weights $fill $areas $code"
                        done
                    done
                done
            done
        done
    done
}

# As compute/compute.c puts them together, by its table of entry points. Defines that an entry point does not ask for
# are left out, so that each shader comes once.
put_compute_shaders()
{
    local folder=$1 place=glinterop/compute/shaders entry source base has_64_bits names name head text files
    local -A known=()
    while read -r entry source base has_64_bits; do
        files=("$place/compute.glsl")
        [[ $base == COMMON ]] || files+=("$place/fragment.glsl")
        [[ $base != ATTRIBUTE ]] || files+=("$place/attribute.glsl")
        text=$(shader_text "${files[@]}" "$place/${source,,}.comp")
        while read -r names; do
            head=
            # Built for projected areas alone.
            [[ $entry != *_AREA* || $names == *AREAS* ]] || continue
            for name in $names; do
                [[ $text != *"SVO_$name"* ]] || head+="#define SVO_$name"$'\n'
            done
            [[ $has_64_bits == false ]] || head=$int64_lines$head
            [[ -z ${known[$entry$head]:-} ]] || continue
            known[$entry$head]=1
            printf '#version 430 core\n%s#define %s\n%s\n' "$head" "$entry" "$text" >"$folder/$entry.${#known[@]}.comp"
        done < <(if [[ $has_64_bits == true ]]; then payload_defines; else printf '\nCODE48\n'; fi)
    done < <(sed -nE 's/^ *\{"(SVO_K_[A-Z_]+)", ([A-Z]+), BASE_([A-Z]+), (true|false),.*/\1 \2 \3 \4/p' \
        glinterop/compute/compute.c)
    ((${#known[@]} > 0)) || fail "no entry points were found in glinterop/compute/compute.c"
}

check_shaders()
{
    local folder=$build_clang/shaders log
    rm -rf "$folder"
    mkdir -p "$folder"
    put_raster_shaders "$folder"
    put_compute_shaders "$folder"
    if ! log=$(find "$folder" -type f -print0 | xargs -0 -n 64 -P "$jobs" glslangValidator 2>&1); then
        grep -B 1 -A 1 ERROR <<<"$log" | head -n 100
        return 1
    fi
}
