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
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define DRACO_FILE "fathom/fathom-draco"
static const char extension[] = "KHR_draco_mesh_compression";

/* ---- the process ---- */

/* Returns 0, or the error number. */
static int start(const char *path, int from, int to, pid_t *child) {
    posix_spawn_file_actions_t actions;
    int failed = posix_spawn_file_actions_init(&actions);
    if (failed) return failed;
    failed = posix_spawn_file_actions_adddup2(&actions, from, STDIN_FILENO);
    if (!failed) failed = posix_spawn_file_actions_adddup2(&actions, to, STDOUT_FILENO);
    if (!failed)
        failed = posix_spawn(child, path, &actions, NULL, (char *[]){(char *)(uintptr_t)path, NULL}, environ);
    posix_spawn_file_actions_destroy(&actions);
    return failed;
}

static fathom_status fail_broken(gltf *g, const gltf_value *at, int status, int answer) {
    char text[160] = "";
    const ssize_t n = pread(answer, text, sizeof text - 1, 0);
    const char *name = WIFSIGNALED(status) ? sigabbrev_np(WTERMSIG(status)) : NULL;
    if (name)
        return gltf_fail(g, at, NULL, "cannot be unpacked: Draco was ended by SIG%s; the data is broken",
                         name);
    return gltf_fail(g, at, NULL, "cannot be unpacked by Draco: %s", n > 0 ? text : "the data is broken");
}

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

static bool be_open(gltf *g) {
    const size_t bytes = sizeof *g->draco + gltf_count(&g->views) * sizeof *g->draco->jobs;
    if (!g->draco) g->draco = calloc(1, bytes);
    if (!g->draco) gltf_fail_memory(g, bytes);
    return gltf_fine(g);
}

static void forget(gltf *g, draco_job *job) {
    if (job->answer >= 0) close(job->answer);
    *job = (draco_job){.started = false};
    --g->draco->running;
}

void gltf_draco_close(gltf *g) {
    for (size_t i = 0; g->draco && g->draco->running && i < gltf_count(&g->views); ++i) {
        draco_job *job = &g->draco->jobs[i];
        if (!job->started) continue;
        kill(job->child, SIGKILL);
        while (waitpid(job->child, NULL, 0) < 0 && errno == EINTR) continue;
        forget(g, job);
    }
    free(g->draco);
}

/* Starts a process that decompresses the view's bytes into the job's file. */
static fathom_status start_job(gltf *g, const gltf_value *at, uint32_t view) {
    char path[PATH_MAX];
    gltf_value view_at;
    gltf_view packed;
    draco_job job = {.started = true};
    if (gltf_view_open(g, view, &view_at, &packed) != FATHOM_OK) return g->status;
    if (!helper_find_file(DRACO_FILE, path))
        return gltf_fail(g, at, NULL,
                         "needs Draco, but this Fathom was built without it; build it with libdraco-dev "
                         "(Debian), or export the model without compression");
    const int question = file_in_memory(packed.bytes, packed.length);
    job.answer = file_in_memory(NULL, 0);
    fathom_status status = FATHOM_OK;
    if (question < 0 || job.answer < 0)
        status = fail_file(g->context, FATHOM_OUT_OF_RESOURCES, g->path, "no memory for a mesh to unpack: %s",
                           strerror(errno));
    const int failed = status == FATHOM_OK ? start(path, question, job.answer, &job.child) : 0;
    if (failed)
        status =
            fail_file(g->context, FATHOM_OUT_OF_RESOURCES, path, "cannot be started: %s", strerror(failed));
    if (question >= 0) close(question);
    if (status == FATHOM_OK) {
        g->draco->jobs[view] = job;
        ++g->draco->running;
    } else if (job.answer >= 0) {
        close(job.answer);
    }
    return status;
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

/* Decompresses a view into a file, which the caller closes. */
static fathom_status unpack(gltf *g, const gltf_value *at, uint32_t view, int *answer) {
    draco_job *job = &g->draco->jobs[view];
    int status = 0;
    if (!job->started) start_job(g, at, view);
    if (!job->started) return gltf_fine(g) ? FATHOM_OUT_OF_RESOURCES : g->status;
    start_ahead(g);
    pid_t ended;
    do ended = waitpid(job->child, &status, 0);
    while (ended < 0 && errno == EINTR);
    *answer = job->answer;
    job->answer = -1;
    forget(g, job);
    start_ahead(g);
    return status || ended < 0 ? fail_broken(g, at, status, *answer) : FATHOM_OK;
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

static fathom_status take_attribute(gltf *g, const gltf_value *attributes, const gltf_value *ids,
                                    const char *key, const answer *a) {
    uint64_t id = 0;
    draco_attribute found;
    fathom_status status = gltf_integer(g, ids, key, 0, UINT32_MAX, &id);
    if (status != FATHOM_OK || !json_object_get(attributes->json, key)) return status;
    const unsigned char *values = find_attribute(a, id, &found);
    if (!values)
        return gltf_fail(g, ids, key, "is %llu; the data has no such attribute", (unsigned long long)id);
    return gltf_array_give(g, attributes, key,
                           &(gltf_given){.view = a->view,
                                         .count = a->head.points,
                                         .components = found.components,
                                         .normalized = found.normalized,
                                         .values = values});
}

static fathom_status take_all(gltf *g, const gltf_value *primitive, const gltf_value *draco,
                              const answer *a) {
    gltf_value attributes, ids;
    const char *key;
    json_t *value;
    fathom_status status = gltf_object(g, primitive, "attributes", &attributes);
    if (status == FATHOM_OK) status = gltf_object(g, draco, "attributes", &ids);
    if (status != FATHOM_OK) return status;
    if (!ids.json)
        return gltf_fail(g, draco, "attributes", "is missing; expected the ids of the compressed attributes");
    if (!json_object_get(primitive->json, "indices"))
        return gltf_fail(g, primitive, "indices",
                         "is missing; expected an accessor that describes what is unpacked");
    status = gltf_array_give(g, primitive, "indices",
                             &(gltf_given){.view = a->view,
                                           .count = a->head.faces * 3,
                                           .components = 1,
                                           .integers = true,
                                           .values = a->indices});
    json_object_foreach(ids.json, key, value) {
        if (status == FATHOM_OK) status = take_attribute(g, &attributes, &ids, key, a);
    }
    return status;
}

static fathom_status take_answer(gltf *g, const gltf_value *primitive, const gltf_value *draco, uint32_t view,
                                 int file) {
    struct stat facts;
    if (fstat(file, &facts) || facts.st_size <= 0) return gltf_fail(g, draco, NULL, "unpacks to nothing");
    const size_t size = (size_t)facts.st_size;
    void *bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, file, 0);
    if (bytes == MAP_FAILED) return fail_memory(g->context, size);
    answer a = {.view = view, .bytes = bytes, .end = (unsigned char *)bytes + size};
    fathom_status status = open_answer(&a) ? take_all(g, primitive, draco, &a)
                                           : gltf_fail(g, draco, NULL, "unpacks to no triangles");
    munmap(bytes, size);
    return status;
}

fathom_status gltf_draco_read(gltf *g, const gltf_value *primitive) {
    gltf_value holder, at;
    uint32_t view = GLTF_ABSENT;
    int unpacked = -1;
    g->unpacked = 0;
    fathom_status status = gltf_extension(g, primitive, extension, &holder, &at);
    if (status != FATHOM_OK || !at.json) return status;
    status = gltf_index(g, &at, "bufferView", &g->views, &view);
    if (status == FATHOM_OK && view == GLTF_ABSENT)
        return gltf_fail(g, &at, "bufferView", "is missing; expected the compressed mesh");
    if (status != FATHOM_OK) return status;
    if (!helper_find_file(DRACO_FILE, (char[PATH_MAX]){""}) && !gltf_requires(g, extension)) {
        gltf_note(g, primitive, NULL, "Draco is not part of this build; what is not compressed is taken");
        return FATHOM_OK;
    }
    if (!be_open(g)) return g->status;
    status = unpack(g, &at, view, &unpacked);
    if (status == FATHOM_OK) status = take_answer(g, primitive, &at, view, unpacked);
    if (status == FATHOM_OK) g->unpacked = view + 1;
    if (unpacked >= 0) close(unpacked);
    return status;
}
