/* Runs a target once over each file of the folders and files named: the corpus without libFuzzer, with any
 * compiler. Exit code 0 if there were files and nothing was wrong. */
#include "fuzz.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static unsigned long runs;

static void stop(const char *path) {
    perror(path);
    exit(2);
}

static void run_file(const char *path, size_t size) {
    /* Of its exact size, so that AddressSanitizer sees a read beyond. */
    uint8_t *bytes = malloc(size ? size : 1);
    FILE *file = fopen(path, "rb");
    if (!bytes || !file || fread(bytes, 1, size, file) != size) stop(path);
    fclose(file);
    fprintf(stderr, "%s\n", path);
    LLVMFuzzerTestOneInput(bytes, size);
    free(bytes);
    ++runs;
}

static void run(const char *path) {
    struct stat info;
    if (stat(path, &info) != 0) stop(path);
    if (S_ISREG(info.st_mode)) {
        run_file(path, (size_t)info.st_size);
        return;
    }
    struct dirent **entries;
    int count = scandir(path, &entries, NULL, alphasort);
    if (count < 0) stop(path);
    for (int i = 0; i < count; ++i) {
        size_t room = strlen(path) + strlen(entries[i]->d_name) + 2;
        char *name = malloc(room);
        if (!name) stop(path);
        snprintf(name, room, "%s/%s", path, entries[i]->d_name);
        if (entries[i]->d_name[0] != '.') run(name);
        free(name);
        free(entries[i]);
    }
    free(entries);
}

int main(int argc, char **argv) {
    for (int i = 1; i < argc; ++i) run(argv[i]);
    if (!runs) {
        fprintf(stderr, "usage: %s FILE|FOLDER…\n", argv[0]);
        return 2;
    }
    printf("%lu inputs\n", runs);
    return 0;
}
