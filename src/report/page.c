#include "report/page.h"

#include "base/file.h"
#include "report/style.h"

#include <fathom/fathom.h>

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* By this page_check() knows its own pages. */
#define GENERATOR "<meta name=\"generator\" content=\"fathom"

/* ---- bytes ---- */

static void append(page *p, const char *bytes, size_t size) {
    if (p->lost || !array_room(p, size + 1)) {
        p->lost = true;
        return;
    }
    memcpy(p->items + p->count, bytes, size);
    p->count += size;
    p->items[p->count] = '\0';
}

static void append_format(page *p, const char *format, va_list list) {
    va_list again;
    va_copy(again, list);
    int size = vsnprintf(NULL, 0, format, list);
    if (size < 0 || p->lost || !array_room(p, (size_t)size + 1)) {
        p->lost = true;
    } else {
        vsnprintf(p->items + p->count, (size_t)size + 1, format, again);
        p->count += (size_t)size;
    }
    va_end(again);
}

void page_put(page *p, const char *format, ...) {
    va_list list;
    va_start(list, format);
    append_format(p, format, list);
    va_end(list);
}

/* ---- text ---- */

/* Bytes of the UTF-8 character at s; 0 when there is none, as in names of files that are not UTF-8. */
static size_t utf8_length(const unsigned char *s) {
    size_t length = s[0] < 0x80   ? 1
                    : s[0] < 0xc2 ? 0
                    : s[0] < 0xe0 ? 2
                    : s[0] < 0xf0 ? 3
                    : s[0] < 0xf5 ? 4
                                  : 0;
    for (size_t i = 1; i < length; ++i) {
        if ((s[i] & 0xc0) != 0x80) return 0;
    }
    return length;
}

static const char *entity(char c) {
    switch (c) {
    case '&': return "&amp;";
    case '<': return "&lt;";
    case '>': return "&gt;";
    case '"': return "&quot;";
    case '\'': return "&#39;";
    default: return NULL;
    }
}

/* Control characters have no place in HTML, not even as entities. */
static bool is_control(char c) {
    return ((unsigned char)c < 0x20 && c != '\n' && c != '\t') || (unsigned char)c == 0x7f;
}

void page_text(page *p, const char *text) {
    while (text && *text) {
        size_t length = utf8_length((const unsigned char *)text);
        const char *name = entity(*text);
        if (name)
            append(p, name, strlen(name));
        else if (!length || is_control(*text))
            append(p, "\xef\xbf\xbd", 3);
        else
            append(p, text, length);
        text += length ? length : 1;
    }
}

void page_textf(page *p, const char *format, ...) {
    page plain = {.count = 0};
    va_list list;
    va_start(list, format);
    append_format(&plain, format, list);
    va_end(list);
    p->lost |= plain.lost;
    page_text(p, plain.items);
    page_free(&plain);
}

/* ---- the document ---- */

void page_begin(page *p, const char *title) {
    page_put(p,
             "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n" GENERATOR " %s\">\n",
             fathom_version());
    /* The browser itself sees to it that the page asks nobody for anything. */
    page_put(p, "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
                "style-src 'unsafe-inline'; img-src data:\">\n"
                "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                "<meta name=\"color-scheme\" content=\"light dark\">\n"
                "<link rel=\"icon\" href=\"data:,\">\n<title>");
    page_text(p, title);
    page_put(p, "</title>\n<style>\n");
    style_put(p);
    page_put(p, "</style>\n</head>\n<body>\n<main>\n<h1>");
    page_text(p, title);
    page_put(p, "</h1>\n<section>\n");
}

void page_links(page *p) { p->links_at = p->count; }

void page_section(page *p, const char *name, const char *heading) {
    page link = {p->links, p->links_count, p->links_capacity, .lost = p->lost};
    page_put(&link, "<li><a href=\"#%s\">", name);
    page_text(&link, heading);
    page_put(&link, "</a></li>\n");
    p->links = link.items, p->links_count = link.count, p->links_capacity = link.capacity;
    p->lost |= link.lost;
    page_put(p, "</section>\n<section id=\"%s\" aria-labelledby=\"%s-heading\">\n<h2 id=\"%s-heading\">",
             name, name, name);
    page_text(p, heading);
    page_put(p, "</h2>\n");
}

/* The sections are known at the end: their links move in before them. */
static void insert_links(page *p) {
    page with = {.count = 0};
    append(&with, p->items, p->links_at);
    page_put(&with, "<nav aria-label=\"Sections\"><ul>\n");
    append(&with, p->links, p->links_count);
    page_put(&with, "</ul></nav>\n");
    append(&with, p->items + p->links_at, p->count - p->links_at);
    free(p->items);
    p->items = with.items, p->count = with.count, p->capacity = with.capacity;
    p->lost |= with.lost;
}

void page_end(page *p) {
    page_put(p, "</section>\n</main>\n</body>\n</html>\n");
    if (p->links_at && p->links && !p->lost) insert_links(p);
}

void page_free(page *p) {
    array_free(p);
    free(p->links);
    memset(p, 0, sizeof *p);
}

/* ---- the file ---- */

static char *index_of(const char *folder) {
    size_t room = strlen(folder) + sizeof "/index.html";
    char *path = malloc(room);
    if (path) snprintf(path, room, "%s/index.html", folder);
    return path;
}

static fathom_status check_ours(fathom_context *context, const char *path) {
    char head[512];
    FILE *file = fopen(path, "rb");
    if (!file) {
        if (errno == ENOENT) return FATHOM_OK;
        return fail(context, FATHOM_OUT_OF_RESOURCES, "%s: cannot be replaced: %s", path, strerror(errno));
    }
    size_t size = fread(head, 1, sizeof head - 1, file);
    head[size] = '\0';
    fclose(file);
    if (size == 0 || strstr(head, GENERATOR)) return FATHOM_OK;
    return fail(context, FATHOM_OUT_OF_RESOURCES,
                "%s: is there already and is no report of fathom; remove it or name another folder", path);
}

/* A folder that does not exist yet is a file to be made in the one above. */
static fathom_status check_new(fathom_context *context, const char *folder) {
    size_t length = strlen(folder);
    while (length > 1 && folder[length - 1] == '/') --length;
    char *name = strndup(folder, length);
    if (!name) return fail_memory(context, length);
    fathom_status status = file_check_writable(context, name);
    free(name);
    return status;
}

fathom_status page_check(fathom_context *context, const char *folder) {
    struct stat info;
    if (stat(folder, &info) != 0) return check_new(context, folder);
    if (!S_ISDIR(info.st_mode))
        return fail(context, FATHOM_OUT_OF_RESOURCES, "%s: is a file; expected a folder for the report",
                    folder);
    char *path = index_of(folder);
    if (!path) return fail_memory(context, strlen(folder));
    fathom_status status = file_check_writable(context, path);
    if (status == FATHOM_OK) status = check_ours(context, path);
    free(path);
    return status;
}

static fathom_status put_file(fathom_context *context, const page *p, const char *path) {
    file_writer *writer;
    fathom_status status = file_writer_open(context, path, &writer);
    if (status != FATHOM_OK) return status;
    file_writer_put(writer, p->items, p->count);
    return file_writer_commit(writer);
}

fathom_status page_write(fathom_context *context, const page *p, const char *folder) {
    if (p->lost) return fail_memory(context, p->count);
    fathom_status status = page_check(context, folder);
    if (status != FATHOM_OK) return status;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return fail(context, FATHOM_OUT_OF_RESOURCES, "%s: cannot be made: %s", folder, strerror(errno));
    char *path = index_of(folder);
    if (!path) return fail_memory(context, strlen(folder));
    status = put_file(context, p, path);
    free(path);
    return status;
}
