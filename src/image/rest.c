#include "image/rest.h"

#include <link.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/mman.h>
#include <unistd.h>

typedef struct walk {
    size_t first, count;
} walk;

static int count_one(struct dl_phdr_info *info, size_t size, void *user) {
    (void)info, (void)size;
    ++((walk *)user)->count;
    return 0;
}

size_t rest_library_count(void) {
    walk w = {0, 0};
    dl_iterate_phdr(count_one, &w);
    return w.count;
}

/* Code with relocations of its own was written to while it was loaded, and is not the file's any more. */
static bool has_written_code(const struct dl_phdr_info *info) {
    for (size_t i = 0; i < info->dlpi_phnum; ++i) {
        const ElfW(Phdr) *header = &info->dlpi_phdr[i];
        if (header->p_type != PT_DYNAMIC) continue;
        const ElfW(Dyn) *entry = (const void *)(info->dlpi_addr + header->p_vaddr);
        for (; entry->d_tag != DT_NULL; ++entry) {
            if (entry->d_tag == DT_TEXTREL) return true;
            if (entry->d_tag == DT_FLAGS && entry->d_un.d_val & DF_TEXTREL) return true;
        }
    }
    return false;
}

static int rest_one(struct dl_phdr_info *info, size_t size, void *user) {
    (void)size;
    walk *w = user;
    if (w->count++ < w->first || has_written_code(info)) return 0;
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE);
    for (size_t i = 0; i < info->dlpi_phnum; ++i) {
        const ElfW(Phdr) *header = &info->dlpi_phdr[i];
        if (header->p_type != PT_LOAD || header->p_flags & PF_W) continue;
        uintptr_t begin = info->dlpi_addr + header->p_vaddr, end = begin + header->p_memsz;
        begin = begin / page * page, end = (end + page - 1) / page * page;
        madvise((void *)begin, end - begin, MADV_DONTNEED);
    }
    return 0;
}

void rest_libraries(size_t first) {
    walk w = {first, 0};
    dl_iterate_phdr(rest_one, &w);
}
