/* MTL materials: what each model of the format means here. */
#include "mesh_file.h"

#include "read/obj/mtl.h"
#include "read/obj/obj.h"

static fathom_material material_of(const char *body) {
    mtl_library library = {0};
    forget_warnings();
    const char *text = unit_text("newmtl m\n%s", body);
    assert_ok(context, mtl_read(context, put_text("m.mtl", text), &library));
    assert_int_equal(library.materials.count, 1);
    fathom_material material = library.materials.items[0].value;
    mtl_free(&library);
    return material;
}

static void expect_color(const char *body, const char *field, const float found[3], double r, double g,
                         double b) {
    /* 1 - d and products are rounded to double, then to float. */
    const double expected[3] = {r, g, b};
    for (int k = 0; k < 3; ++k) {
        if (!(fabs((double)found[k] - expected[k]) <= 0x1p-24)) {
            fail_msg("%s: %s[%d] is %g, expected %g", body, field, k, (double)found[k], expected[k]);
        }
    }
}

UNIT_TEST(absent_values_get_defaults) {
    fathom_material plain, found = material_of("");
    fathom_material_default(&plain);
    assert_memory_equal(found.k_d, plain.k_d, sizeof plain.k_d);
    assert_true(found.k_a[0] < 0);
    assert_int_equal(found.specular, FATHOM_SPECULAR_NONE);
    expect_color("", "k_t", found.k_t, 0, 0, 0);
    expect_color("", "k_r", found.k_r, 0, 0, 0);
}

UNIT_TEST(diffuse_and_highlights_are_read) {
    const char *body = "Kd 0.1 0.2 0.3\nKs 0.4 0.5 0.6\nNs 50\nKe 1 2 3\nKa 0.7 0.8 0.9\nillum 2\n";
    fathom_material m = material_of(body);
    expect_color(body, "k_d", m.k_d, 0.1, 0.2, 0.3);
    expect_color(body, "k_s", m.k_s, 0.4, 0.5, 0.6);
    expect_color(body, "k_e", m.k_e, 1, 2, 3);
    expect_color(body, "k_a", m.k_a, 0.7, 0.8, 0.9);
    assert_true(m.shininess == 50 && m.specular == FATHOM_SPECULAR_BLINN);
    expect_color(body, "k_r", m.k_r, 0, 0, 0);
    /* No illum: highlights if there is a colour for them. */
    assert_int_equal(material_of("Ks 1 1 1\nNs 10\n").specular, FATHOM_SPECULAR_BLINN);
    assert_int_equal(material_of("Ks 0 0 0\nNs 10\n").specular, FATHOM_SPECULAR_NONE);
    assert_int_equal(material_of("Ks 1 1 1\nNs 10\nillum 1\n").specular, FATHOM_SPECULAR_NONE);
    /* Ns 0 would be a highlight as wide as the world. */
    assert_int_equal(material_of("Ks 1 1 1\nNs 0\nillum 2\n").specular, FATHOM_SPECULAR_NONE);
    /* One number is grey. */
    m = material_of("Kd 0.25\n");
    expect_color("Kd 0.25", "k_d", m.k_d, 0.25, 0.25, 0.25);
}

UNIT_TEST(ambient_follows_ka_and_illum) {
    assert_true(material_of("Kd 0.1 0.2 0.3\nKa 1 1 1\nillum 2\n").k_a[0] < 0);
    fathom_material m = material_of("Ka 0 0 0\nillum 1\n");
    expect_color("Ka 0", "k_a", m.k_a, 0, 0, 0);
    m = material_of("Ka 1 1 1\nillum 0\n");
    expect_color("illum 0", "k_a", m.k_a, 0, 0, 0);
}

/* What Blender and others write for a surface that is simply opaque. */
UNIT_TEST(materials_as_exported_look_right) {
    const char *body =
        "Ns 250.000000\nKa 1.000000 1.000000 1.000000\nKd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.45\n"
        "d 1.000000\nTr 0.0\nTf 1 1 1\nillum 2\n";
    fathom_material m = material_of(body);
    expect_color(body, "k_d", m.k_d, 0.8, 0.8, 0.8);
    expect_color(body, "k_t", m.k_t, 0, 0, 0);
    expect_color(body, "k_r", m.k_r, 0, 0, 0);
    assert_true(m.shininess == 250);
    assert_false(m.fresnel);
    expect_warning("m.mtl:3: a white Ka is left out");
    assert_ptr_equal(strchr(warned, '\n'), warned + strlen(warned) - 1);
}

UNIT_TEST(mirrors_follow_illum) {
    const char *models[] = {"illum 3", "illum 5\nNi 1.5", "illum 8"};
    material_of("Ks 1 1 1\nillum 3\n"); /* a mirror without a highlight loses nothing */
    assert_string_equal(warned, "");
    for (int i = 0; i < 3; ++i) {
        const char *body = unit_text("Kd 0.5 0.5 0.5\nKs 0.2 0.4 0.6\nNs 99\n%s\n", models[i]);
        fathom_material m = material_of(body);
        expect_color(body, "k_r", m.k_r, 0.2, 0.4, 0.6);
        expect_color(body, "k_t", m.k_t, 0, 0, 0);
        expect_color(body, "k_d", m.k_d, 0.5, 0.5, 0.5);
        assert_int_equal(m.fresnel, i == 1);
    }
    /* Fresnel's law with an index of 1 would take the mirror away. */
    assert_false(material_of("Ks 1 1 1\nillum 5\nNi 1\n").fresnel);
    /* Without an index, that of glass. */
    fathom_material m = material_of("Ks 1 1 1\nillum 5\n");
    assert_true(m.fresnel && m.ior == 1.5f);
}

/* Dissolving fades all that the surface sends out and bends nothing, however it is written. */
UNIT_TEST(dissolved_materials_pass_light_straight) {
    const char *bodies[] = {
        "Kd 0.8 0.8 0.8\nKs 1 1 1\nNs 10\nKe 1 1 1\nKa 0.4 0.4 0.4\nillum 2\nNi 1.45\nd 0.25\n",
        "Kd 0.8 0.8 0.8\nKs 1 1 1\nNs 10\nKe 1 1 1\nKa 0.4 0.4 0.4\nillum 2\nNi 1.45\nTr 0.75\n",
        "Kd 0.8 0.8 0.8\nKs 1 1 1\nNs 10\nKe 1 1 1\nKa 0.4 0.4 0.4\nillum 2\nd -halo 0.25\n"};
    for (int i = 0; i < 3; ++i) {
        fathom_material m = material_of(bodies[i]);
        expect_color(bodies[i], "k_t", m.k_t, 0.75, 0.75, 0.75);
        expect_color(bodies[i], "k_d", m.k_d, 0.2, 0.2, 0.2);
        expect_color(bodies[i], "k_s", m.k_s, 0.25, 0.25, 0.25);
        expect_color(bodies[i], "k_e", m.k_e, 0.25, 0.25, 0.25);
        expect_color(bodies[i], "k_a", m.k_a, 0.1, 0.1, 0.1);
        assert_true(m.ior == 1);
        assert_false(m.fresnel);
    }
}

/* MeshLab writes Tr 1 for opaque surfaces. What says d 0 is not seen, which is told. */
UNIT_TEST(tr_1_is_opaque) {
    const char *opaque[] = {"Kd 0.8 0.8 0.8\nTr 1.000000\nillum 2\nNs 0\n", "Kd 0.8 0.8 0.8\nd 1\nTr 1\n"};
    for (int i = 0; i < 2; ++i) {
        fathom_material m = material_of(opaque[i]);
        expect_color(opaque[i], "k_t", m.k_t, 0, 0, 0);
        expect_color(opaque[i], "k_d", m.k_d, 0.8, 0.8, 0.8);
        expect_warning("Tr 1 is read as opaque");
    }
    assert_true(material_of("Pr 0.5\nTr 1\n").opacity == 1);
    const char *clear[] = {"Kd 0.8 0.8 0.8\nd 0\n", "Kd 0.8 0.8 0.8\nTr 1\nd 0\n"};
    for (int i = 0; i < 2; ++i) {
        fathom_material m = material_of(clear[i]);
        expect_color(clear[i], "k_t", m.k_t, 1, 1, 1);
        expect_warning("surfaces of d 0 are not seen");
    }
    /* Glass is clear by right. */
    expect_color("glass", "k_t", material_of("Ks 0 0 0\nillum 4\nTr 1\n").k_t, 1, 1, 1);
    assert_string_equal(warned, "");
}

UNIT_TEST(glass_follows_its_formulas) {
    /* By Fresnel's law: all goes through or is mirrored, highlights stay. */
    const char *body = "Kd 0.01 0.01 0.01\nKs 1 1 1\nNs 200\nNi 1.5\nTf 0.9 1 0.8\nillum 7\n";
    fathom_material m = material_of(body);
    expect_color(body, "k_t", m.k_t, 0.9, 1, 0.8);
    expect_color(body, "k_r", m.k_r, 1, 1, 1);
    expect_color(body, "k_s", m.k_s, 1, 1, 1);
    expect_color(body, "k_d", m.k_d, 0, 0, 0);
    assert_true(m.fresnel && m.ior == 1.5f);
    /* The format's own formula without d or Tf. */
    body = "Ks 0.25 0.5 0\nNi 1.33\nillum 6\nd 1\n";
    m = material_of(body);
    expect_color(body, "k_t", m.k_t, 0.75, 0.5, 1);
    expect_color(body, "k_r", m.k_r, 0.25, 0.5, 0);
    assert_false(m.fresnel);
    assert_true(m.ior == 1.33f);
    /* d says how clear; no more comes back than there is. */
    body = "Kd 0.5 0.5 0.5\nKs 1 1 1\nNi 1.45\nd 0.25\nillum 4\n";
    m = material_of(body);
    expect_color(body, "k_t", m.k_t, 0.75, 0.75, 0.75);
    expect_color(body, "k_r", m.k_r, 0.25, 0.25, 0.25);
    expect_color(body, "k_d", m.k_d, 0.125, 0.125, 0.125);
    assert_true(m.ior == 1);
    /* What Blender writes for an opacity is no mirror. */
    body = "Kd 0.5 0.5 0.5\nKs 1 1 1\nNs 10\nNi 1.45\nd 0.25\nillum 9\n";
    m = material_of(body);
    expect_color(body, "k_t", m.k_t, 0.75, 0.75, 0.75);
    expect_color(body, "k_r", m.k_r, 0, 0, 0);
    expect_color(body, "k_s", m.k_s, 0.25, 0.25, 0.25);
    expect_color(body, "k_d", m.k_d, 0.125, 0.125, 0.125);
    for (int illum = 4; illum <= 9; ++illum) {
        if (illum == 5 || illum == 8) continue;
        const char *text = unit_text("Ks 1 1 1\nTf 0.5 0.5 0.5\nNi 1.7\nd 0.5\nillum %d\n", illum);
        m = material_of(text);
        expect_color(text, "k_t", m.k_t, 0.25, 0.25, 0.25);
        assert_true(m.ior == (illum == 6 || illum == 7 ? 1.7f : 1));
    }
}

/* Maya writes Tf 1 - transparency, and Ni 1 for what does not refract. */
UNIT_TEST(materials_of_maya_are_opaque) {
    const char *body =
        "illum 4\nKd 0.5 0.5 0.5\nKa 0.00 0.00 0.00\nTf 1.00 1.00 1.00\nNi 1.00\nKs 0.5 0.5 0.5\nNs 18\n";
    fathom_material m = material_of(body);
    expect_color(body, "k_t", m.k_t, 0, 0, 0);
    expect_color(body, "k_r", m.k_r, 0, 0, 0);
    expect_color(body, "k_d", m.k_d, 0.5, 0.5, 0.5);
    expect_warning("m.mtl:5: illum 4 with Tf and Ni, but without d, is read as Maya means it");
    body = "illum 4\nKd 0.5 0.5 0.5\nTf 0.25 0.25 0.25\nNi 1.00\n";
    m = material_of(body);
    expect_color(body, "k_t", m.k_t, 0.75, 0.75, 0.75);
    expect_color(body, "k_d", m.k_d, 0.125, 0.125, 0.125);
    body = "illum 4\nKd 0.5 0.5 0.5\nTf 0 0 0\nNi 1.80\nKs 1 1 1\n";
    m = material_of(body);
    expect_color(body, "k_t", m.k_t, 1, 1, 1);
    assert_true(m.fresnel && m.ior == 1.8f);
}

/* Cinema 4D says no more of them. */
UNIT_TEST(glass_needs_more_than_its_model) {
    const char *body = "Ka 1 1 1\nKd 0.8 0.8 0.8\nKs 1 1 1\nNs 50\nillum 7\n";
    fathom_material m = material_of(body);
    expect_color(body, "k_t", m.k_t, 0, 0, 0);
    expect_color(body, "k_r", m.k_r, 0, 0, 0);
    expect_color(body, "k_d", m.k_d, 0.8, 0.8, 0.8);
    assert_true(m.specular == FATHOM_SPECULAR_BLINN && m.shininess == 50);
    expect_warning("m.mtl:6: illum 4, 6, 7 and 9 without Ni, Tf and d are read as 2");
    static const char *const glass[] = {"Ni 1.5\nillum 7\n", "Tf 1 1 1\nillum 6\n", "d 0.5\nillum 4\n"};
    for (int i = 0; i < 3; ++i) assert_true(material_of(glass[i]).k_t[0] > 0);
}

/* Old Blender adds the image's alpha to an opacity of 0. */
UNIT_TEST(no_opacity_times_an_image_is_the_image) {
    fathom_material m = material_of("Ni -1\nd 0\nillum 1\nmap_Kd a.png\nmap_d a.png\n");
    expect_color("d", "k_t", m.k_t, 0, 0, 0);
    expect_warning("m.mtl:3: d 0 with map_d is read as 1");
}

/* Tf beside keys of metallic-roughness, and no word on a highlight, which Pr gives. */
UNIT_TEST(clear_metallic_materials_transmit) {
    fathom_material m = material_of("Kd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nPr 0\nNi 1.45\nillum 2\nTf 1 1 1\n");
    assert_int_equal(m.model, FATHOM_MODEL_METALLIC_ROUGHNESS);
    assert_true(m.transmission == 1 && m.thickness > 0 && m.ior == 1.45f);
    expect_warning("m.mtl:7: Tf next to Pr");
    assert_null(strstr(warned, "highlight"));
    m = material_of("Pr 0.5\nTf 0 0 0\n");
    assert_true(m.transmission == 0 && m.thickness == 0);
    assert_true(material_of("Pr 0.5\n").transmission == 0);
}

UNIT_TEST(omissions_are_reported) {
    material_of("Kd 1 1 1\nfoo 0.5\nmap_opacity a.png\nmap_ORM b.png\n");
    expect_warning("m.mtl:3: statements that are not read are left out (1 such, the first here: \"foo\")");
    expect_warning("m.mtl:4: images of unknown keys are left out (2 such, the first here: \"map_opacity\")");
    material_of("Kd 1 1 1\nfoo 0.5\nKs spectral x.rfl\nbar 1\nTf 0.5 1 1\nd -halo 1\nillum 10\n");
    expect_warning("m.mtl:3: statements that are not read are left out (2 such, the first here: \"foo\")");
    expect_warning("m.mtl:4: colours as spectra or in xyz are not read (1 such");
    expect_warning("m.mtl:6: Tf is left out where illum is not glass");
    expect_warning("m.mtl:7: d -halo is read as d");
    expect_warning("m.mtl:8: illum 10 is read as 2");
    material_of("Ks 1 1 1\nillum 2\n");
    expect_warning("m.mtl:2: there is no highlight where Ns is missing or less than 1");
}

/* What a map of the material names, with its options. */
static void expect_map(const char *body, fathom_map_kind kind, const char *file, uint32_t channel,
                       const float transform[6]) {
    mtl_library library = {0};
    const char *text = unit_text("newmtl m\n%s", body);
    assert_ok(context, mtl_read(context, put_text("m.mtl", text), &library));
    const mtl_image *image = &library.materials.items[0].images[kind];
    assert_non_null(image->file);
    assert_string_equal(image->file, file);
    assert_int_equal(image->map.channel, channel);
    for (int i = 0; i < 6; ++i) assert_near(image->map.transform[i], transform[i], 0);
    mtl_free(&library);
}

/* v grows upwards in the format, and downwards in maps. */
UNIT_TEST(images_become_maps) {
    const float plain[6] = {1, 0, 0, 0, -1, 1}, moved[6] = {2, 0, 0.5f, 0, -3, 0.75f};
    expect_map("map_Kd a b.png\n", FATHOM_MAP_COLOR, "a b.png", 0, plain);
    expect_map("map_Kd \"a b.png\"\n", FATHOM_MAP_COLOR, "a b.png", 0, plain);
    expect_map("map_Kd -s 2 3 1 -o 0.5 0.25 -clamp on a.png\n", FATHOM_MAP_COLOR, "a.png", 0, moved);
    expect_map("map_Kd a#1 b.png # the wall\n", FATHOM_MAP_COLOR, "a#1 b.png", 0, plain);
    expect_map("map_Kd \"a b.png\" #\n", FATHOM_MAP_COLOR, "a b.png", 0, plain);
    expect_map("map_Ks c\n", FATHOM_MAP_SPECULAR_COLOR, "c", 0, plain);
    expect_map("map_Ke d\n", FATHOM_MAP_EMISSIVE, "d", 0, plain);
    expect_map("map_Ns -imfchan g f\n", FATHOM_MAP_SHININESS, "f", 1, plain);
    expect_map("map_D g.png\n", FATHOM_MAP_OPACITY, "g.png", 0, plain);
    expect_map("map_kd g.png\n", FATHOM_MAP_COLOR, "g.png", 0, plain);
    expect_map("map_d g.png\n", FATHOM_MAP_OPACITY, "g.png", 0, plain);
    expect_map("map_d g.png\nmap_Kd g.png\n", FATHOM_MAP_OPACITY, "g.png", 3, plain);
    expect_map("map_Pr r\n", FATHOM_MAP_ROUGHNESS, "r", 0, plain);
    expect_map("norm n\n", FATHOM_MAP_NORMAL, "n", 0, plain);
    expect_map("map_Bump -bm 0.5 wall_normal.png\n", FATHOM_MAP_NORMAL, "wall_normal.png", 0, plain);
    expect_map("map_Bump -bm 0.5 -imfchan g wall.png\n", FATHOM_MAP_BUMP, "wall.png", 1, plain);
}

/* The first material of a file whose first line is `head`. */
static mtl_material first_of(const char *head, const char *body, mtl_library *library) {
    forget_warnings();
    const char *text = unit_text("%s\nnewmtl m\n%s", head, body);
    assert_ok(context, mtl_read(context, put_text("m.mtl", text), library));
    return library->materials.items[0];
}

/* Blender has no other use for the key. */
UNIT_TEST(bump_images_of_blender_are_normals) {
    static const char *const heads[] = {"# Blender 3.4.1 MTL File: 'a.blend'",
                                        "# Blender MTL File: 'a.blend'", "#"};
    for (int i = 0; i < 3; ++i) {
        mtl_library library = {0};
        const mtl_material m = first_of(heads[i], "map_Bump -bm 0.7 wall.png\n", &library);
        assert_int_equal(m.images[FATHOM_MAP_NORMAL].file != NULL, i == 0);
        assert_int_equal(m.images[FATHOM_MAP_BUMP].file != NULL, i != 0);
        assert_near(i ? m.value.bump_scale : m.value.normal_scale, 0.7f, 0);
        mtl_free(&library);
    }
}

/* Blender writes the values of its Principled BSDF: a roughness of 0.2 is Ns 640, and a specular of 0.5
 * reflects 4 %, as an ior of 1.5. */
UNIT_TEST(materials_of_blender_are_those_of_its_shader) {
    static const char head[] = "# Blender 3.4.1 MTL File: 'None'";
    static const struct {
        const char *body;
        double metallic, roughness, opacity, ior;
    } cases[] = {
        {"Ns 640\nKa 1 1 1\nKd 1 0.7 0.3\nKs 0.5 0.5 0.5\nNi 1.45\nd 1\nillum 3\n", 1, 0.2, 1, 1.5},
        {"Ns 640\nKa 0.25 0.25 0.25\nKs 0.5 0.5 0.5\nNi 1.45\nd 0.5\nillum 6\n", 0.25, 0.2, 0.5, 1.5},
        {"Ns 250\nKa 1 1 1\nKs 0.5 0.5 0.5\nNi 1.45\nd 0.5\nillum 9\n", 0, 0.5, 0.5, 1.5},
        {"Ns 1000\nKa 1 1 1\nKs 0 0 0\nNi 1.45\nd 1\nillum 1\n", 0, 0, 1, 1},
        {"Ns 250\nKs 0.5 0.5 0.5\nillum 2\nPr 0.75\nPm 0.5\n", 0.5, 0.75, 1, 1.5},
        {"Ni 1.25\nKs 0.5 0.5 0.5\nillum 2\nPr 0\nPm 0\nTf 1 1 1\n", 0, 0, 1, 1.25},
        {"Ks 0.5 0.5 0.5\nillum 2\nmap_Ns r\nmap_refl m\n", 1, 1, 1, 1.5},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        mtl_library library = {0};
        const mtl_material m = first_of(head, cases[i].body, &library);
        const fathom_material *v = &m.value;
        assert_int_equal(v->model, FATHOM_MODEL_METALLIC_ROUGHNESS);
        /* Roots and quotients in double, then one rounding to float: of 2^-24 of at most 1.5. */
        assert_near(v->metallic, cases[i].metallic, 0x1p-24);
        assert_near(v->roughness, cases[i].roughness, 0x1p-24);
        assert_near(v->opacity, cases[i].opacity, 0x1p-24);
        assert_near(v->ior, cases[i].ior, 0x1p-23);
        assert_near(v->specular_factor, cases[i].ior > 1, 0); /* no specular: no highlight */
        assert_int_equal(m.images[FATHOM_MAP_ROUGHNESS].file != NULL,
                         strstr(cases[i].body, "map_Ns") != NULL);
        assert_int_equal(m.images[FATHOM_MAP_METALLIC].file != NULL,
                         strstr(cases[i].body, "map_refl") != NULL);
        mtl_free(&library);
    }
    /* Its sheen is fainter than that of fibres. */
    mtl_library sheen = {0};
    assert_near(first_of(head, "Ks 0.5 0.5 0.5\nillum 2\nPr 1\nPs 0.5\n", &sheen).value.sheen_color[1], 0.052,
                0x1p-28);
    mtl_free(&sheen);
    /* The older exporter, whose Ni was 1 before 2.8. It writes the colour that an image replaces. */
    static const char *const ior[] = {"1.45", "1"};
    for (int i = 0; i < 2; ++i) {
        mtl_library library = {0};
        const mtl_material m = first_of(
            "# Blender MTL File: 'None'",
            unit_text("Ns 640\nKd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nNi %s\nillum 2\nmap_Kd a\nrefl m\n", ior[i]),
            &library);
        assert_int_equal(m.value.model, i ? FATHOM_MODEL_CLASSIC : FATHOM_MODEL_METALLIC_ROUGHNESS);
        assert_near(i ? m.value.k_d[0] : m.value.base_color[0], 1, 0);
        if (!i) assert_near(m.value.roughness, 0.2, 0x1p-24);
        assert_int_equal(m.images[FATHOM_MAP_METALLIC].file != NULL, !i);
        mtl_free(&library);
    }
    for (int i = 0; i < 2; ++i) { /* glass that Blender does not write, and a file of another program */
        mtl_library library = {0};
        const mtl_material m =
            first_of(i ? "# Blending" : head, i ? cases[0].body : "Ns 9\nillum 7\nd 0.5\n", &library);
        assert_int_equal(m.value.model, FATHOM_MODEL_CLASSIC);
        mtl_free(&library);
    }
}

/* 3ds Max writes the colour that its image hides, and AliceVision a grey. */
UNIT_TEST(images_of_3ds_max_and_alicevision_replace_the_colour) {
    static const char *const heads[] = {"# 3ds Max Wavefront OBJ Exporter v0.97b - (c)2007 guruware",
                                        "#\n# Wavefront material file\n# Created with AliceVision\n#\n", "#"};
    for (int i = 0; i < 6; ++i) {
        mtl_library library = {0};
        const char *body = i < 3 ? "Kd 0.6 0.6 0.6\nmap_Kd a\n" : "Kd 0.6 0.6 0.6\n";
        const mtl_material m = first_of(heads[i % 3], body, &library);
        assert_near(m.value.k_d[0], i < 2 ? 1 : 0.6f, 0);
        if (i < 2) expect_warning("Kd with map_Kd is read as 1");
        mtl_free(&library);
    }
}

UNIT_TEST(an_image_alone_has_factors_of_one) {
    const char *body = "map_Kd a\nmap_Ke d\nKe 0.5 0.5 0.5\n";
    fathom_material m = material_of(body);
    expect_color(body, "k_d", m.k_d, 1, 1, 1);
    expect_color(body, "k_e", m.k_e, 0.5, 0.5, 0.5);
    assert_true(material_of("norm -bm 0.25 n\n").normal_scale == 0.25f);
    assert_true(material_of("norm n\nbump -bm 0.25 h\n").bump_scale == 0.25f);
    assert_true(material_of("norm n\nbump -bm 0.25 h\n").normal_scale == 1);
    material_of("map_Ka e\nmap_Kd\n");
    expect_warning(":2: map_Ka");
    expect_warning(":3: an image without the name");
}

UNIT_TEST(black_times_an_image_is_the_image) {
    const char *bodies[] = {"Kd 0 0 0\nmap_Kd a\n", "map_Kd a\nKd 0 0 0\n"};
    for (int i = 0; i < 2; ++i) {
        fathom_material m = material_of(bodies[i]);
        expect_color(bodies[i], "k_d", m.k_d, 1, 1, 1);
        expect_warning(
            "Kd 0 with map_Kd is read as 1, as other programs do; else the image is black (1 such)");
    }
    fathom_material m = material_of("Kd 0 0 0\n");
    expect_color("Kd", "k_d", m.k_d, 0, 0, 0);
    m = material_of("Kd 0 0 0\nmap_Kd a\nPm 0.5\n");
    expect_color("Kd", "base colour", m.base_color, 0, 0, 0);
    assert_string_equal(warned, "");
    m = material_of("Ke 0 0 0\nmap_Ke a\n");
    expect_color("Ke", "k_e", m.k_e, 1, 1, 1);
    expect_warning("m.mtl:2: Ke 0 with map_Ke is read as 1");
}

/* Folders say nothing about an image. */
UNIT_TEST(names_tell_normals_from_bumps) {
    static const char *const normals[] = {"rock_normal.png", "RockNormal.png", "rock_n.png",
                                          "a/rock-NRM.jpg",  "norm.png",       "rockNorm2.png",
                                          "rock_nor_gl.png"},
                             *const bumps[] = {"rock_bump.png",    "C:\\Users\\norman\\rock.png",
                                               "normals/rock.png", "enormous.png",
                                               "norman.png",       "/home/rock_n.a/b.png"};
    for (size_t i = 0; i < sizeof normals / sizeof *normals; ++i)
        if (!mtl_says_normal(normals[i])) fail_msg("%s", normals[i]);
    for (size_t i = 0; i < sizeof bumps / sizeof *bumps; ++i)
        if (mtl_says_normal(bumps[i])) fail_msg("%s", bumps[i]);
}

UNIT_TEST(pbr_keys_make_a_metallic_roughness_material) {
    const char *body = "Kd 0.5 0.25 1\nPr 0.125\nPm 0.75\nPc 0.5\nPcr 0.25\nd 0.5\nNi 1.25\nKe 1 2 3\n";
    fathom_material m = material_of(body);
    assert_int_equal(m.model, FATHOM_MODEL_METALLIC_ROUGHNESS);
    expect_color(body, "base colour", m.base_color, 0.5, 0.25, 1);
    expect_color(body, "emissive", m.emissive, 1, 2, 3);
    assert_true(m.roughness == 0.125f && m.metallic == 0.75f && m.opacity == 0.5f && m.ior == 1.25f);
    assert_true(m.clearcoat == 0.5f && m.clearcoat_roughness == 0.25f);
    assert_int_equal(material_of("Kd 1 1 1\n").model, FATHOM_MODEL_CLASSIC);
    m = material_of("Ps 0.75\naniso 0.5\nanisor 0.25\n");
    assert_int_equal(m.model, FATHOM_MODEL_METALLIC_ROUGHNESS);
    assert_true(m.sheen_color[2] == 0.75f && m.sheen_roughness == 0.5f && m.anisotropy == 0.5f);
    assert_near(m.anisotropy_rotation, 1.5707963, 1e-6);
}

/* The words of printf() for what is no number; missing numbers. What was there before counts. */
UNIT_TEST(statements_without_numbers_are_left_out) {
    fathom_material m = material_of("Kd 0.25 0.5 0.75\nKd 1 x 0\nKd 1 0\nNs 1.#QNAN\nNi\nKe 1 2 3\n");
    expect_color("Kd", "k_d", m.k_d, 0.25, 0.5, 0.75);
    expect_color("Ke", "k_e", m.k_e, 1, 2, 3);
    expect_warning("m.mtl:3: Kd: expected three numbers; it is left out (2 such, the first here: \"x\")");
    expect_warning("m.mtl:5: Ns: expected a number; it is left out (1 such, the first here: \"1.#QNAN\")");
    expect_warning("m.mtl:6: Ni: expected a number; it is left out (1 such)");
}

UNIT_TEST(numbers_out_of_range_become_the_nearest) {
    fathom_material m = material_of("Kd -1 0.5 2\nKs 1 1 1\nNs nan\nd 1.5\nillum 11\nNi -3\n");
    expect_color("Kd", "k_d", m.k_d, 0, 0.5, 1);
    expect_warning("m.mtl:2: Kd above 1 would reflect more light than arrives, and is read as 1 (1 such)");
    expect_color("d", "k_t", m.k_t, 0, 0, 0);
    assert_int_equal(m.specular, FATHOM_SPECULAR_NONE);
    expect_warning("m.mtl:2: Kd: expected a number in [0, 1e+09]; the nearest is taken (1 such, the first "
                   "here: \"-1\")");
    expect_warning("m.mtl:4: Ns: expected a number in [0, 1e+09]; none is taken");
    expect_warning("m.mtl:5: d: ");
    expect_warning("m.mtl:6: illum: ");
    expect_warning("m.mtl:7: Ni: ");
    material_of("illum 2.5\n");
    expect_warning("m.mtl:2: illum: expected a whole number");
}

UNIT_TEST(materials_without_a_name_have_the_empty_one) {
    mtl_library library = {0};
    forget_warnings();
    assert_ok(
        context,
        mtl_read(context, put_text("m.mtl", "Kd 0 0 0\nnewmtl\nKd 1 0 0\nnewmtl b\nKd 0 1 0\n"), &library));
    assert_int_equal(library.materials.count, 2);
    assert_string_equal(library.materials.items[0].name, "");
    assert_true(library.materials.items[0].value.k_d[0] == 1);
    expect_warning("m.mtl:1: expected newmtl first");
    expect_warning("m.mtl:2: newmtl: expected a name");
    mtl_free(&library);
}

/* Names are whole lines; a later material of a name takes the place of the earlier. */
UNIT_TEST(names_may_hold_blanks) {
    mtl_library library = {0};
    assert_ok(
        context,
        mtl_read(
            context,
            put_text(
                "m.mtl",
                "newmtl Material #25 \r\nKd 1 0 0\r\nnewmtl b\nKd 0 1 0\nnewmtl Material #25\nKd 0 0 1\n"),
            &library));
    assert_int_equal(library.materials.count, 2);
    assert_string_equal(library.materials.items[0].name, "Material #25");
    assert_true(library.materials.items[0].value.k_d[2] == 1);
    assert_true(library.materials.items[1].value.k_d[1] == 1);
    mtl_free(&library);
}

int main(void) { return unit_main(open_folder, remove_folder); }
