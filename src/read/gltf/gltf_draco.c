/* KHR_draco_mesh_compression. A separate process decompresses each mesh (helper/draco.cpp), because Draco's
 * library is not safe with corrupt files. Its output is checked like a file, and becomes the arrays of the
 * accessors that the primitive names.
 *
 * While one primitive is read, processes decompress the next ones of the file, one per thread. A failure of
 * such a process is only reported when its primitive is read. */
#include "read/gltf/gltf_draco.h"

#include "image/helper/helper.h"
#include "read/gltf/gltf_data.h"

#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define DRACO_FILE "fathom/fathom-draco"
static const char extension[] = "KHR_draco_mesh_compression";

/* ---- parallel decompression ---- */

/* The decompression of one buffer view. */
typedef struct draco_job {
    bool started;
    pid_t child;
    int answer; /* descriptor of the output file */
} draco_job;

struct gltf_draco {
    size_t mesh, primitive; /* the next primitive to examine */
    unsigned running;       /* number of started processes that were not waited for yet */
    draco_job jobs[];
};

static void be_open(gltf *g) {
    const size_t bytes = sizeof *g->draco + gltf_count(&g->views) * sizeof *g->draco->jobs;
    if (!g->draco) g->draco = calloc(1, bytes);
    if (!g->draco) gltf_fail_memory(g, bytes);
}

/* Waits for the job's process. Returns its status, or -1. */
static int end_job(gltf *g, draco_job *job) {
    int status = 0;
    pid_t ended;
    do ended = waitpid(job->child, &status, 0);
    while (ended < 0 && errno == EINTR);
    *job = (draco_job){.started = false};
    --g->draco->running;
    return ended < 0 ? -1 : status;
}

void gltf_draco_close(gltf *g) {
    for (size_t i = 0; g->draco && i < gltf_count(&g->views); ++i) {
        draco_job *job = &g->draco->jobs[i];
        if (!job->started) continue;
        kill(job->child, SIGKILL);
        close(job->answer);
        end_job(g, job);
    }
    free(g->draco);
}

/* Starts a process that decompresses the view's bytes into the job's file. */
static void start_job(gltf *g, const gltf_value *at, uint32_t view) {
    char path[PATH_MAX];
    gltf_value view_at;
    gltf_view packed;
    draco_job job = {.started = true};
    if (gltf_view_open(g, view, &view_at, &packed) != FATHOM_OK) return;
    if (!helper_find_file(DRACO_FILE, path)) {
        gltf_fail(g, at, NULL,
                  "needs Draco, but this Fathom was built without it; build it with libdraco-dev "
                  "(Debian), or export the model without compression");
        return;
    }
    const int question = file_in_memory(packed.bytes, packed.length);
    job.answer = question < 0 ? -1 : file_in_memory(NULL, 0);
    const int descriptors[] = {question, job.answer, -1};
    const int failed = job.answer < 0 ? errno : helper_spawn(path, descriptors, 3, &job.child);
    if (failed)
        g->status = fail_file(g->context, FATHOM_OUT_OF_RESOURCES, g->path,
                              "a mesh cannot be unpacked by %s: %s", path, strerror(failed));
    if (question >= 0) close(question);
    if (gltf_fine(g))
        g->draco->jobs[view] = job, ++g->draco->running;
    else if (job.answer >= 0)
        close(job.answer);
}

/* Finds the view of the next compressed primitive of the file, without checking the primitive. */
static bool find_next(gltf *g, uint32_t *view) {
    struct gltf_draco *d = g->draco;
    for (; d->mesh < gltf_count(&g->meshes); ++d->mesh, d->primitive = 0) {
        const json_t *list = json_object_get(json_array_get(g->meshes.json, d->mesh), "primitives");
        while (d->primitive < json_array_size(list)) {
            const json_t *one = json_object_get(json_array_get(list, d->primitive++), "extensions");
            const json_t *number = json_object_get(json_object_get(one, extension), "bufferView");
            if (!json_is_integer(number) || (uint64_t)json_integer_value(number) >= gltf_count(&g->views))
                continue;
            *view = (uint32_t)json_integer_value(number);
            if (!d->jobs[*view].started) return true;
        }
    }
    return false;
}

static void start_ahead(gltf *g) {
    uint32_t view;
    while (g->draco->running < fathom_context_threads(g->context) && find_next(g, &view)) {
        start_job(g, &g->meshes, view);
        g->status = FATHOM_OK;
    }
}

/* Decompresses a view into a file, which the caller closes; -1: reading has failed. */
static int unpack(gltf *g, const gltf_value *at, uint32_t view) {
    draco_job *job = &g->draco->jobs[view];
    if (!job->started) start_job(g, at, view);
    if (!gltf_fine(g)) return -1;
    start_ahead(g);
    const int answer = job->answer, status = end_job(g, job);
    start_ahead(g);
    if (!status) return answer;
    char text[160] = "";
    const ssize_t n = pread(answer, text, sizeof text - 1, 0);
    const char *name = WIFSIGNALED(status) ? sigabbrev_np(WTERMSIG(status)) : NULL;
    if (name)
        gltf_fail(g, at, NULL, "cannot be unpacked: Draco was ended by SIG%s; the data is broken", name);
    else
        gltf_fail(g, at, NULL, "cannot be unpacked by Draco: %s", n > 0 ? text : "the data is broken");
    return answer;
}

/* ---- the output ---- */

typedef struct answer {
    uint32_t view; /* that was decompressed */
    const unsigned char *bytes, *end;
    draco_head head;
    const unsigned char *indices, *attributes;
} answer;

static bool open_answer(answer *a) {
    const size_t size = (size_t)(a->end - a->bytes);
    if (size < sizeof a->head) return false;
    memcpy(&a->head, a->bytes, sizeof a->head);
    a->indices = a->bytes + sizeof a->head;
    const uint64_t indices = (uint64_t)a->head.faces * 3 * sizeof(uint32_t);
    if (a->head.magic != DRACO_MAGIC || indices > size - sizeof a->head) return false;
    a->attributes = a->indices + indices;
    return a->head.points && a->head.faces && a->head.points < UINT32_MAX && a->head.faces < UINT32_MAX / 3;
}

/* NULL: there is no attribute with this id, or the output is too short. */
static const unsigned char *find_attribute(const answer *a, uint64_t id, draco_attribute *out) {
    const unsigned char *at = a->attributes;
    for (uint32_t i = 0; i < a->head.attributes && (size_t)(a->end - at) >= sizeof *out; ++i) {
        memcpy(out, at, sizeof *out);
        at += sizeof *out;
        const uint64_t size = (uint64_t)out->components * a->head.points * sizeof(float);
        if (size > (uint64_t)(a->end - at)) return NULL;
        if (out->id == id) return at;
        at += size;
    }
    return NULL;
}

static void take_attribute(gltf *g, const gltf_value *attributes, const gltf_value *ids, const char *key,
                           const answer *a) {
    uint64_t id = 0;
    draco_attribute found;
    gltf_integer(g, ids, key, 0, UINT32_MAX, &id);
    if (!gltf_fine(g) || !json_object_get(attributes->json, key)) return;
    const unsigned char *values = find_attribute(a, id, &found);
    if (values)
        gltf_array_give(g, attributes, key,
                        &(gltf_given){.view = a->view,
                                      .count = a->head.points,
                                      .components = found.components,
                                      .normalized = found.normalized,
                                      .values = values});
    else
        gltf_fail(g, ids, key, "is %llu; the data has no such attribute", (unsigned long long)id);
}

static void take_all(gltf *g, const gltf_value *primitive, const gltf_value *draco, const answer *a) {
    gltf_value attributes, ids;
    const char *key;
    json_t *value;
    gltf_object(g, primitive, "attributes", &attributes);
    gltf_object(g, draco, "attributes", &ids);
    if (!ids.json)
        gltf_fail(g, draco, "attributes", "is missing; expected the ids of the compressed attributes");
    if (!json_object_get(primitive->json, "indices"))
        gltf_fail(g, primitive, "indices",
                  "is missing; expected an accessor that describes what is unpacked");
    gltf_array_give(g, primitive, "indices",
                    &(gltf_given){.view = a->view,
                                  .count = a->head.faces * 3,
                                  .components = 1,
                                  .integers = true,
                                  .values = a->indices});
    json_object_foreach(ids.json, key, value) take_attribute(g, &attributes, &ids, key, a);
}

static void take_answer(gltf *g, const gltf_value *primitive, const gltf_value *draco, uint32_t view,
                        int file) {
    struct stat facts;
    if (!gltf_fine(g)) return;
    if (fstat(file, &facts) || facts.st_size <= 0) {
        gltf_fail(g, draco, NULL, "unpacks to nothing");
        return;
    }
    const size_t size = (size_t)facts.st_size;
    void *bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, file, 0);
    if (bytes == MAP_FAILED) {
        gltf_fail_memory(g, size);
        return;
    }
    answer a = {.view = view, .bytes = bytes, .end = (unsigned char *)bytes + size};
    if (open_answer(&a))
        take_all(g, primitive, draco, &a);
    else
        gltf_fail(g, draco, NULL, "unpacks to no triangles");
    munmap(bytes, size);
}

void gltf_draco_read(gltf *g, const gltf_value *primitive) {
    gltf_value holder, at;
    uint32_t view = GLTF_ABSENT;
    g->unpacked = 0;
    gltf_extension(g, primitive, extension, &holder, &at);
    if (!at.json) return;
    gltf_index(g, &at, "bufferView", &g->views, &view);
    if (view == GLTF_ABSENT) gltf_fail(g, &at, "bufferView", "is missing; expected the compressed mesh");
    if (gltf_fine(g) && !helper_find_file(DRACO_FILE, (char[PATH_MAX]){""}) && !gltf_requires(g, extension)) {
        gltf_note(g, primitive, NULL, "Draco is not part of this build; what is not compressed is taken");
        return;
    }
    be_open(g);
    const int unpacked = gltf_fine(g) ? unpack(g, &at, view) : -1;
    take_answer(g, primitive, &at, view, unpacked);
    if (gltf_fine(g)) g->unpacked = view + 1;
    if (unpacked >= 0) close(unpacked);
}
