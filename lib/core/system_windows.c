/* SPDX-License-Identifier: MIT */
/* The operating system as Windows 7 and later have it (https://learn.microsoft.com/windows/win32/api/). */
#include "core/system.h"

#include <direct.h>
#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>
#include <windows.h>

#define PIECE_BYTES ((size_t)1 << 30) /* of one read or write, whose sizes are 32 bits */

double svo_i_now_ms(void)
{
    LARGE_INTEGER now;
    LARGE_INTEGER second;
    QueryPerformanceCounter(&now);
    QueryPerformanceFrequency(&second);
    return (double)now.QuadPart / (double)second.QuadPart * 1e3;
}

void svo_i_system_sleep_ms(unsigned milliseconds)
{
    Sleep(milliseconds);
}

uint32_t svo_i_system_processors(void)
{
    const DWORD online = GetActiveProcessorCount(ALL_PROCESSOR_GROUPS);
    return online > 0 ? online : 1;
}

uint64_t svo_i_system_memory_bytes(void)
{
    MEMORYSTATUSEX memory = {.dwLength = sizeof memory};
    return GlobalMemoryStatusEx(&memory) ? memory.ullTotalPhys : UINT64_MAX;
}

int svo_i_system_open(const char *path)
{
    return _open(path, _O_RDONLY | _O_BINARY | _O_NOINHERIT);
}

int svo_i_system_make(const char *path)
{
    return _open(path, _O_WRONLY | _O_CREAT | _O_EXCL | _O_BINARY | _O_NOINHERIT, _S_IREAD | _S_IWRITE);
}

static unsigned piece_of(size_t size)
{
    return (unsigned)(size < PIECE_BYTES ? size : PIECE_BYTES);
}

bool svo_i_system_read(int descriptor, void *bytes, size_t size)
{
    size_t done = 0;
    while (done < size) {
        const int got = _read(descriptor, (char *)bytes + done, piece_of(size - done));
        if (got <= 0) {
            return false;
        }
        done += (size_t)got;
    }
    return true;
}

bool svo_i_system_write(int descriptor, const void *bytes, size_t size)
{
    size_t done = 0;
    while (done < size) {
        const int put = _write(descriptor, (const char *)bytes + done, piece_of(size - done));
        if (put <= 0) {
            return false;
        }
        done += (size_t)put;
    }
    return true;
}

/* The C library's rename replaces nothing. */
bool svo_i_system_replace(const char *from, const char *to)
{
    if (MoveFileExA(from, to, MOVEFILE_REPLACE_EXISTING)) {
        return true;
    }
    errno = GetLastError() == ERROR_ACCESS_DENIED ? EACCES : EIO;
    return false;
}

bool svo_i_system_make_folder(const char *path)
{
    return _mkdir(path) == 0 || errno == EEXIST;
}
