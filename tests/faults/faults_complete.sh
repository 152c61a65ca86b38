#!/bin/sh
# SPDX-License-Identifier: MIT
# faults_complete.sh NM CALLS LIBRARY...: lists what the static libraries call and test_faults does not make fail.
# CALLS: the wrapped calls, separated by semicolons. A new call gets a wrapper in faults.c or faults_cl.c, or, where it
# cannot fail or allocates nothing of the library's own, a name here.
set -u
nm=$1
calls=$2
shift 2

# Text, memory, numbers, signal sets, the clock; what only releases.
plain="__errno_location __isoc99_sscanf __popcountdi2 __tls_get_addr _GLOBAL_OFFSET_TABLE_ bcmp bsearch clock_gettime
dlerror environ feof ftell getenv gethostname getpid getppid getrlimit memchr memcmp memcpy memmove memset nanosleep
posix_spawn_file_actions_destroy posix_spawnattr_destroy pthread_sigmask qsort sigaddset sigemptyset sigfillset
sigismember sigpending sigtimedwait sin sincos snprintf strcasecmp strchr strcmp strcspn strerror strlen strncasecmp
strncmp strpbrk strrchr strncat strspn strstr strtok_r strtol strtoll strtoul strtoull sysconf ungetc vsnprintf acosf
cbrt ceil cos exp2 floor fma fmax fmaxf fmin fminf frexp ilogbf ldexp ldexpf log2 nextafter nextafterf pow rint sqrt
sqrtf tan"
plain=$(printf '%s' "$plain" | tr '\n' ' ')
# Libraries that allocate for themselves or by functions of ours (zlib), and what compilers and sanitizers add.
families='^(svo_|ai[A-Z]|cJSON_|ZSTD_|XXH|zip_|XML_|__(asan|ubsan|tsan|sanitizer|gcov|stack_chk|llvm)_|llvm_'
families="$families|inflate|deflate|blosc_|_ZN10fast_float|_ZTVN10__cxxabiv1)"

missing=$("$nm" -u "$@" | awk '$1 == "U" { print $2 }' | grep -Ev "$families" | sort -u |
    while read -r name; do
        case ";$calls;" in *";$name;"*) continue ;; esac
        case " $plain " in *" $name "*) continue ;; esac
        echo "$name"
    done)
if [ -n "$missing" ]; then
    printf 'calls that test_faults does not make fail:\n%s\n' "$missing"
    exit 1
fi
echo "every call is wrapped or needs no wrapper"
