/* Bytes at offsets of open files, and files in memory. */
#include "base/file.h"

#include <errno.h>
#include <sys/mman.h>
#include <unistd.h>

bool file_write_at(int descriptor, uint64_t offset, const void *bytes, size_t size) {
    const char *from = bytes;
    while (size) {
        const ssize_t n = pwrite(descriptor, from, size, (off_t)offset);
        if (n < 0 && errno == EINTR) continue;
        if (n == 0) errno = ENOSPC;
        if (n <= 0) return false;
        from += n, size -= (size_t)n, offset += (uint64_t)n;
    }
    return true;
}

int file_in_memory(const void *bytes, size_t size) {
    const int descriptor = memfd_create("fathom", MFD_CLOEXEC);
    if (descriptor < 0 || file_write_at(descriptor, 0, bytes, size)) return descriptor;
    const int failed = errno;
    close(descriptor);
    errno = failed;
    return -1;
}
