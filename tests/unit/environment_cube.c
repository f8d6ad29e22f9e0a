/* Environments given by the faces of a cube. */
#include "image/image.h"
#include "light/environment.h"
#include "owned.h"
#include "unit_folder.h"

UNIT_OWNS(environment, environment, environment_destroy)

enum { SIDE = 16, FACES = 6, FORMS = 5, MOST = 12 * SIDE * SIDE };

typedef float texel[3];

/* OpenGL's faces, seen from inside; z is turned, because the centre of a sky lies towards -z. */
static vec3_f64 direction_on(unsigned face, double s, double t) {
    const double r[FACES][3] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t}, {s, -1, -t}, {s, -t, 1}, {-s, -t, -1}};
    return normalize_f64(vec_f64(r[face][0], r[face][1], -r[face][2]));
}

/* A smooth function, or the number of the face. */
static void set_texel(texel to, bool smooth, unsigned face, unsigned x, unsigned y) {
    const vec3_f64 d = direction_on(face, (x + 0.5) / SIDE * 2 - 1, (y + 0.5) / SIDE * 2 - 1);
    for (int c = 0; c < 3; ++c) to[c] = smooth ? (float)(1 + d.x / 2 + d.y / 3 + d.z / 5) : (float)(face + 1);
}

static void write_part(const char *name, unsigned width, unsigned height, texel *texels, unsigned x,
                       unsigned y, unsigned full_width, unsigned full_height) {
    const image_channel channels[3] = {{"R", IMAGE_FLOAT, true, &texels[0][0], sizeof *texels},
                                       {"G", IMAGE_FLOAT, true, &texels[0][1], sizeof *texels},
                                       {"B", IMAGE_FLOAT, true, &texels[0][2], sizeof *texels}};
    const image img = {width, height, x, y, full_width, full_height, channels, 3, NULL, 0, 0};
    assert_ok(context, exr_write_plain(context, &img, in_folder(name)));
}

static void write_image(const char *name, unsigned width, unsigned height, texel *texels) {
    write_part(name, width, height, texels, 0, 0, width, height);
}

/* The square of each face, from the left and the top; squares of a cross without a face hold NaN. */
typedef struct form {
    unsigned columns, rows, at[FACES][2];
    bool turned; /* the last face */
} form;
static const form forms[FORMS - 1] = {
    {4, 3, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}}, false},
    {3, 4, {{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {1, 3}}, true},
    {6, 1, {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}}, false},
    {1, 6, {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}}, false},
};
static const char *const words[FACES] = {"posx", "negx", "posy", "negy", "posz", "negz"};

static void write_form(const form *f, bool smooth) {
    static texel texels[MOST];
    for (int i = 0; i < MOST; ++i) texels[i][0] = texels[i][1] = texels[i][2] = NAN;
    for (unsigned face = 0; face < FACES; ++face) {
        const bool turned = f->turned && face == FACES - 1;
        for (unsigned i = 0; i < SIDE * SIDE; ++i) {
            const unsigned x = i % SIDE, y = i / SIDE;
            const unsigned row = f->at[face][1] * SIDE + y, column = f->at[face][0] * SIDE + x;
            set_texel(texels[row * f->columns * SIDE + column], smooth, face, turned ? SIDE - 1 - x : x,
                      turned ? SIDE - 1 - y : y);
        }
    }
    write_image("sky.exr", f->columns * SIDE, f->rows * SIDE, texels);
}

static const char *face_file(unsigned face) {
    static char name[32];
    snprintf(name, sizeof name, "sky_%s.exr", words[face]);
    return name;
}

static void write_faces(bool smooth) {
    static texel texels[SIDE * SIDE];
    for (unsigned face = 0; face < FACES; ++face) {
        for (unsigned i = 0; i < SIDE * SIDE; ++i) set_texel(texels[i], smooth, face, i % SIDE, i / SIDE);
        write_image(face_file(face), SIDE, SIDE, texels);
    }
}

static fathom_status open_sky(const char *name, environment **out) {
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder(name);
    const fathom_status status = environment_create(context, &light, out);
    if (status == FATHOM_OK) own_environment(*out);
    return status;
}

/* Form 0 has six files. */
static environment *open_form(unsigned k, bool smooth) {
    environment *e;
    if (k)
        write_form(&forms[k - 1], smooth);
    else
        write_faces(smooth);
    assert_ok(context, open_sky(k ? "sky.exr" : "sky_<FACE>.exr", &e));
    return e;
}

static double red(const environment *e, vec3_f64 d) {
    float rgb[3];
    environment_radiance(e, d, rgb);
    return (double)rgb[0];
}

UNIT_TEST(each_face_lies_where_opengl_has_it) {
    static const vec3_f64 axes[FACES] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, -1}, {0, 0, 1}};
    for (unsigned k = 0; k < FORMS; ++k) {
        environment *e = open_form(k, false);
        for (unsigned face = 0; face < FACES; ++face) assert_near(red(e, axes[face]), face + 1.0, 1e-6);
    }
}

/* Between the outermost texels and a face's edge the radiance is constant: over half a texel, 1 / SIDE, it is
 * off by the gradient, at most 0.64. Elsewhere interpolation, by faces and then by the sky, is off by the
 * second order: at most an eighth of 0.64 times the squared widths, 2 / SIDE and 2 pi / (4 SIDE). */
UNIT_TEST(a_smooth_sky_comes_back) {
    const double bound = 0.64 * (1.0 / SIDE + (4 + 2.5) / 8.0 / (SIDE * SIDE));
    for (unsigned k = 0; k < FORMS; ++k) {
        environment *e = open_form(k, true);
        double off = 0, sum = 0;
        const int count = 20000;
        for (int i = 0; i < count; ++i) {
            const double y = 1 - (2 * i + 1.0) / count, r = sqrt(1 - y * y), turn = 2.39996322972865332 * i;
            const vec3_f64 d = {r * cos(turn), y, r * sin(turn)};
            const double found = red(e, d);
            off = fmax(off, fabs(found - (1 + d.x / 2 + d.y / 3 + d.z / 5)));
            sum += found / count;
        }
        assert_true(off < bound);
        /* What is off at the one edge of a face is off the other way at the opposite one. */
        assert_near(sum, 1, 1.0 / (SIDE * SIDE));
    }
}

static void fails_with(const char *name, const char *text) {
    environment *e;
    assert_int_equal(open_sky(name, &e), FATHOM_BAD_INPUT);
    if (!strstr(fathom_context_message(context), text))
        fail_msg("\"%s\" lacks \"%s\"", fathom_context_message(context), text);
}

UNIT_TEST(faults_are_named) {
    static texel texels[SIDE * SIDE];
    fails_with("sky_<FACE>.exr", "expected six files");
    write_faces(true);
    unlink(in_folder("sky_negz.exr"));
    fails_with("sky_<FACE>.exr", "sky_negz.exr: No such file");
    write_image("sky_negz.exr", SIDE / 2, SIDE / 2, texels);
    fails_with("sky_<FACE>.exr",
               "sky_negz.exr: the image is 8 x 8; expected the square face of a cube, 16 x 16");
    texels[2 * SIDE + 3][1] = NAN;
    write_image("sky_negz.exr", SIDE, SIDE, texels);
    fails_with("sky_<FACE>.exr",
               "sky_negz.exr: texel (3, 2), counted from the top left, has nan in channel G");
    write_image("sky_posx.exr", SIDE, SIDE / 2, texels);
    fails_with("sky_<FACE>.exr", "expected the square face of a cube, 16 x 16");
}

/* A compositor leaves out black edges. */
UNIT_TEST(what_a_file_leaves_out_is_black) {
    enum { LEFT = 3, TOP = 2, WIDTH = SIDE - 5, HEIGHT = SIDE / 2 - 3 };
    static texel whole[SIDE * SIDE / 2], part[WIDTH * HEIGHT];
    environment *e[2];
    for (unsigned i = 0; i < WIDTH * HEIGHT; ++i) {
        const unsigned x = LEFT + i % WIDTH, y = TOP + i / WIDTH;
        for (int c = 0; c < 3; ++c) part[i][c] = whole[y * SIDE + x][c] = (float)(1 + i);
    }
    for (int k = 0; k < 2; ++k) {
        if (k)
            write_part("sky.exr", WIDTH, HEIGHT, part, LEFT, TOP, SIDE, SIDE / 2);
        else
            write_image("sky.exr", SIDE, SIDE / 2, whole);
        assert_ok(context, open_sky("sky.exr", &e[k]));
    }
    for (unsigned i = 0; i < 100; ++i) {
        const vec3_f64 d = direction_on(i % FACES, sin(i), cos(3 * i));
        assert_true(red(e[0], d) == red(e[1], d));
    }
}

UNIT_TEST(what_lies_outside_of_the_image_is_not_used) {
    enum { LEFT = 3, TOP = 2, WIDTH = SIDE + 5, HEIGHT = SIDE / 2 + 3 };
    static texel whole[SIDE * SIDE / 2], data[WIDTH * HEIGHT];
    environment *e[2];
    for (unsigned i = 0; i < WIDTH * HEIGHT; ++i) {
        const unsigned x = i % WIDTH - LEFT, y = i / WIDTH - TOP;
        for (int c = 0; c < 3; ++c) data[i][c] = (float)(1 + i);
        if (x < SIDE && y < SIDE / 2) memcpy(whole[y * SIDE + x], data[i], sizeof *data);
    }
    write_image("sky.exr", SIDE, SIDE / 2, whole);
    assert_ok(context, open_sky("sky.exr", &e[0]));
    write_part("sky.exr", WIDTH, HEIGHT, data, 0u - LEFT, 0u - TOP, SIDE, SIDE / 2);
    assert_ok(context, open_sky("sky.exr", &e[1]));
    for (unsigned i = 0; i < 100; ++i) {
        const vec3_f64 d = direction_on(i % FACES, sin(i), cos(3 * i));
        assert_true(red(e[0], d) == red(e[1], d));
    }
}

int main(void) { return unit_main(open_folder, remove_folder); }
