#include "base/sized.h"

#include <string.h>

static fathom_status check_size(fathom_context *context, const char *name, size_t size, size_t least,
                                size_t known) {
    if (size >= least && size <= known) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_USAGE, name,
                      "its size is %zu bytes; expected the size of the struct, as its _default() function "
                      "sets it: at most the %zu that Fathom %s knows",
                      size, known, fathom_version());
}

static size_t own_size(const void *item) {
    size_t size;
    memcpy(&size, item, sizeof size);
    return size;
}

fathom_status sized_read(fathom_context *context, const char *name, const void *from, size_t size, void *full,
                         size_t known) {
    if (!from) return fail_null(context, name);
    fathom_status status = check_size(context, name, size, 1, known);
    if (status == FATHOM_OK) memcpy(full, from, size);
    return status;
}

fathom_status sized_read_own(fathom_context *context, const char *name, const void *from, void *full,
                             size_t known) {
    fathom_status status = sized_check(context, name, from, known);
    if (status != FATHOM_OK) return status;
    memcpy(full, from, own_size(from));
    memcpy(full, &known, sizeof known);
    return FATHOM_OK;
}

fathom_status sized_check(fathom_context *context, const char *name, const void *out, size_t known) {
    if (!out) return fail_null(context, name);
    return check_size(context, name, own_size(out), sizeof(size_t), known);
}

void sized_write(void *out, const void *full, size_t known) {
    const size_t size = own_size(out);
    sized_give(out, size, full, known);
    memcpy(out, &size, sizeof size);
}

void sized_give(void *out, size_t size, const void *full, size_t known) {
    if (!out) return;
    memcpy(out, full, size < known ? size : known);
    if (size > known) memset((char *)out + known, 0, size - known);
}
