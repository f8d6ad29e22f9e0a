#include "base/memory.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

/* The number after `key` in a system file; SIZE_MAX if there is none. */
static size_t system_number(const char *path, const char *key, size_t unit) {
    FILE *file = fopen(path, "re");
    char line[256];
    size_t number = SIZE_MAX, length = strlen(key);
    while (file && number == SIZE_MAX && fgets(line, sizeof line, file)) {
        unsigned long long value;
        if (strncmp(line, key, length) == 0 && sscanf(line + length, "%llu", &value) == 1)
            number = (size_t)value * unit;
    }
    if (file) fclose(file);
    return number;
}

static size_t own_number(const char *key) {
    size_t bytes = system_number("/proc/self/status", key, 1024);
    return bytes == SIZE_MAX ? 0 : bytes;
}

size_t memory_resident(void) { return own_number("VmRSS:"); }

size_t memory_private(void) { return own_number("RssAnon:"); }

/* What a container may still take: cached files make room. */
static size_t container_free(void) {
    const size_t most = system_number("/sys/fs/cgroup/memory.max", "", 1),
                 used = system_number("/sys/fs/cgroup/memory.current", "", 1),
                 old = system_number("/sys/fs/cgroup/memory.stat", "inactive_file", 1),
                 recent = system_number("/sys/fs/cgroup/memory.stat", "active_file", 1);
    if (most == SIZE_MAX || used == SIZE_MAX || old == SIZE_MAX || recent == SIZE_MAX) return most;
    const size_t kept = used > old + recent ? used - old - recent : 0;
    return most > kept ? most - kept : 0;
}

size_t memory_free(void) {
    size_t machine = system_number("/proc/meminfo", "MemAvailable:", 1024), container = container_free();
    return machine < container ? machine : container;
}

#define LITTLE ((size_t)256 << 20)

bool memory_has(size_t bytes) { return bytes <= LITTLE || bytes <= memory_free(); }

/* ---- zeroed memory ---- */

#define POPULATED ((size_t)64 << 20)

size_t memory_taken(size_t bytes) { return bytes <= POPULATED ? bytes : 0; }

void *memory_take(size_t bytes) {
    int populate = memory_taken(bytes) ? MAP_POPULATE : 0;
    void *data = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | populate, -1, 0);
    return data == MAP_FAILED ? NULL : data;
}

void memory_return(void *data, size_t bytes) {
    if (data) munmap(data, bytes);
}
