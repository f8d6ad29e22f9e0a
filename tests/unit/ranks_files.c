/* A rank that cannot open the scene's files gets them from rank 0, here in the same thread: each message to
 * rank 0 is answered at once. */
#include "job/ranks/ranks_files.h"
#include "defaults.h"
#include "materials.h"
#include "scene/scene.h"
#include "unit_folder.h"

#include <sys/stat.h>

enum { PIECE = 1 << 20, NAME = 1024 };

/* As the sender makes it; the bytes follow. */
typedef struct file_piece {
    message head;
    uint64_t size;
    char name[NAME];
} file_piece;

/* Both ranks, and the last message to rank 1. */
typedef struct pair {
    fathom_context *root, *other;
    fathom_ranks ranks[2];
    unsigned asked; /* how many pieces rank 1 has asked for */
    char *bytes;
    size_t size;
    bool waiting;
    const char *forged; /* the name of the only file that rank 0 sends, or NULL */
} pair;

static void put_letter(pair *p, const void *bytes, size_t size) {
    free(p->bytes);
    p->bytes = malloc(size);
    assert_non_null(p->bytes);
    memcpy(p->bytes, bytes, size);
    p->size = size, p->waiting = true;
}

static bool send_from_root(void *user, uint32_t to, const void *bytes, size_t size) {
    assert_int_equal(to, 1);
    put_letter(user, bytes, size);
    return true;
}

static bool send_to_root(void *user, uint32_t to, const void *bytes, size_t size) {
    pair *p = user;
    message head;
    assert_int_equal(to, 0);
    assert_true(size > sizeof head);
    memcpy(&head, bytes, sizeof head);
    assert_int_equal(head.kind, FILE_WANTED);
    ++p->asked;
    if (p->forged) {
        file_piece piece = {.head = {FILE_PIECE, 1}};
        snprintf(piece.name, sizeof piece.name, "%s", p->forged);
        put_letter(p, &piece, sizeof piece);
        return true;
    }
    return ranks_answer_file(&p->ranks[0], p->root, 1, (const unsigned char *)bytes + sizeof head,
                             size - sizeof head, head.count);
}

static bool receive(void *user, uint32_t *from, const void **bytes, size_t *size) {
    pair *p = user;
    if (!p->waiting) return false;
    p->waiting = false;
    *from = 0, *bytes = p->bytes, *size = p->size;
    return true;
}

static void open_pair(pair *p) {
    *p = (pair){.root = context};
    assert_int_equal(fathom_context_create(&p->other), FATHOM_OK);
    for (uint32_t i = 0; i < 2; ++i) {
        fathom_ranks *r = &p->ranks[i];
        fathom_ranks_default(r);
        r->rank = i, r->count = 2, r->user = p, r->receive = receive;
        r->send = i ? send_to_root : send_from_root;
    }
}

static void close_pair(pair *p) {
    fathom_context_destroy(p->other);
    free(p->bytes);
}

/* Rank 0 reads the scene of this name, and rank 1 asks for it. */
static fathom_status read_both(pair *p, const char *scene, char **copies, fathom_scene **got) {
    fathom_scene *own;
    fathom_read_options options = default_read_options();
    char *none;
    assert_ok(p->root,
              fathom_ranks_read(p->root, &p->ranks[0], in_folder(scene), &options, NULL, &own, &none));
    assert_null(none);
    const fathom_status status =
        fathom_ranks_read(p->other, &p->ranks[1], in_folder("absent.json"), &options, NULL, got, copies);
    fathom_scene_destroy(own);
    return status;
}

static void assert_gone(const char *path) { assert_int_not_equal(access(path, F_OK), 0); }

static void remove_got(char *copies) {
    assert_non_null(copies);
    const char *kept = unit_text("%s", copies);
    fathom_ranks_remove(copies);
    assert_gone(kept);
}

#define TRIANGLE "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
#define MESHES(a) "{\"objects\": [{\"type\": \"mesh\", \"file\": \"" a "\"}]}"

/* The scene has one file of more than two pieces below it, which names another beside its folder, and whose
 * name has two dots. */
UNIT_TEST(files_come_whole_with_their_folders) {
    pair p;
    fathom_scene *got;
    char *copies;
    const size_t most = 2 * PIECE + 5000;
    char *text = malloc(most + 128), *back = malloc(most + 128);
    assert_true(text && back);
    size_t size = (size_t)sprintf(text, "mtllib ../looks/m.mtl\nusemtl red\n" TRIANGLE);
    for (unsigned i = 0; size < most; ++i)
        size += (size_t)snprintf(text + size, 128, "# %u is not to be lost\n", i * 2654435761u);
    assert_int_equal(mkdir(in_folder("meshes"), 0700), 0);
    assert_int_equal(mkdir(in_folder("looks"), 0700), 0);
    unit_write_file(in_folder("meshes/t..obj"), text, size);
    put_text("looks/m.mtl", "newmtl red\nKd 1 0 0\n");
    put_text("scene.json", MESHES("meshes/t..obj"));
    open_pair(&p);
    assert_ok(p.other, read_both(&p, "scene.json", &copies, &got));
    assert_int_equal(got->meshes.items[0].triangle_count, 1);
    assert_int_not_equal(find_material(got, "red"), FATHOM_NONE);
    assert_int_equal(p.asked, 1 + 3 + 1);
    FILE *file = fopen(unit_text("%s/meshes/t..obj", copies), "rb");
    assert_non_null(file);
    assert_int_equal(fread(back, 1, most + 128, file), size);
    assert_memory_equal(back, text, size);
    fclose(file);
    fathom_scene_destroy(got);
    remove_got(copies);
    close_pair(&p);
    free(text), free(back);
}

UNIT_TEST(files_beside_the_scenes_folder_are_refused) {
    pair p;
    fathom_scene *got;
    char *copies;
    /* The context has read another scene before, whose files no longer count. */
    assert_int_equal(mkdir(in_folder("a"), 0700), 0);
    put_text("t.obj", TRIANGLE);
    put_text("a/scene.json", MESHES("../t.obj"));
    open_pair(&p);
    fathom_context_allow_outside(p.root, true);
    assert_fails(p.other, read_both(&p, "a/scene.json", &copies, &got), FATHOM_BAD_INPUT,
                 "a/../t.obj: cannot be opened by rank 1, and rank 0 cannot send it; expected a file below");
    fathom_context_allow_outside(p.root, false);
    remove_got(copies);
    close_pair(&p);
}

static fathom_status ask_for(pair *p, char **copies) {
    fathom_scene *got;
    fathom_read_options options = default_read_options();
    return fathom_ranks_read(p->other, &p->ranks[1], in_folder("absent.json"), &options, NULL, &got, copies);
}

/* Rank 0 is believed only as far as the private folder goes. */
UNIT_TEST(names_that_lead_out_are_refused) {
    char outside[256], *copies;
    const char *names[] = {outside, "../fathom-outside", "a/../../fathom-outside", ".."};
    snprintf(outside, sizeof outside, "%s", in_folder("outside"));
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        pair p;
        open_pair(&p);
        p.forged = names[i];
        assert_fails(p.other, ask_for(&p, &copies), FATHOM_OUT_OF_RESOURCES,
                     "rank 1 gets the scene's files from rank 0, and cannot write them: ");
        assert_int_equal(p.asked, 1);
        remove_got(copies);
        assert_gone(outside), assert_gone("/var/tmp/fathom-outside");
        close_pair(&p);
    }
}

UNIT_TEST(a_folder_that_cannot_be_written_is_told) {
    char *copies;
    pair p;
    open_pair(&p);
    setenv("TMPDIR", in_folder("absent"), true);
    assert_fails(p.other, ask_for(&p, &copies), FATHOM_OUT_OF_RESOURCES, "; name another folder in $TMPDIR");
    unsetenv("TMPDIR");
    assert_int_equal(p.asked, 0);
    fathom_ranks_remove(copies);
    close_pair(&p);
}

static bool send_nothing(void *user, uint32_t to, const void *bytes, size_t size) {
    (void)to, (void)bytes, (void)size;
    ++((pair *)user)->asked;
    return true;
}

static bool send_short(void *user, uint32_t to, const void *bytes, size_t size) {
    (void)to, (void)size;
    put_letter(user, bytes, sizeof(message));
    return true;
}

static bool stopped(void) { return true; }

UNIT_TEST(an_answer_that_is_none_is_told_and_waiting_can_be_stopped) {
    char *copies;
    pair p;
    fathom_scene *got;
    fathom_read_options options = default_read_options();
    open_pair(&p);
    p.ranks[1].send = send_short;
    assert_fails(p.other, ask_for(&p, &copies), FATHOM_BAD_INPUT, "rank 0 sent no file");
    remove_got(copies);
    p.ranks[1].send = send_nothing;
    assert_int_equal(
        fathom_ranks_read(p.other, &p.ranks[1], in_folder("absent.json"), &options, stopped, &got, &copies),
        FATHOM_INTERRUPTED);
    assert_int_equal(p.asked, 1);
    remove_got(copies);
    close_pair(&p);
}

/* Rank 0 answers what makes sense, and says of any other message that it does not. */
UNIT_TEST(rank_0_checks_what_it_is_asked) {
    pair p;
    fathom_scene *own;
    fathom_read_options options = default_read_options();
    char *none;
    uint64_t at = 3;
    open_pair(&p);
    put_text("t.obj", TRIANGLE);
    assert_ok(p.root,
              fathom_ranks_read(p.root, &p.ranks[0], in_folder("t.obj"), &options, NULL, &own, &none));
    fathom_scene_destroy(own);
    unsigned char body[sizeof at];
    memcpy(body, &at, sizeof at);
    assert_false(ranks_answer_file(&p.ranks[0], p.root, 1, body, sizeof body - 1, 0));
    assert_false(ranks_answer_file(&p.ranks[0], p.root, 1, body, sizeof body, 1));
    assert_false(p.waiting);
    assert_true(ranks_answer_file(&p.ranks[0], p.root, 1, body, sizeof body, 0));
    file_piece piece;
    assert_int_equal(p.size, sizeof piece + strlen(TRIANGLE) - at);
    memcpy(&piece, p.bytes, sizeof piece);
    assert_int_equal(piece.head.count, 1);
    assert_int_equal(piece.size, strlen(TRIANGLE));
    assert_string_equal(piece.name, "t.obj");
    assert_memory_equal(p.bytes + sizeof piece, &TRIANGLE[at], strlen(TRIANGLE) - at);
    /* No file has this offset, and the file is gone. */
    at = UINT64_MAX;
    memcpy(body, &at, sizeof at);
    assert_true(ranks_answer_file(&p.ranks[0], p.root, 1, body, sizeof body, 0));
    memcpy(&piece, p.bytes, sizeof piece);
    assert_int_equal(piece.head.count, 0);
    unlink(in_folder("t.obj"));
    at = 0;
    memcpy(body, &at, sizeof at);
    assert_true(ranks_answer_file(&p.ranks[0], p.root, 1, body, sizeof body, 0));
    memcpy(&piece, p.bytes, sizeof piece);
    assert_int_equal(piece.head.count, 0);
    assert_string_equal(piece.name, in_folder("t.obj"));
    close_pair(&p);
}

int main(void) {
    unsetenv("TMPDIR");
    return unit_main(open_folder, remove_folder);
}
