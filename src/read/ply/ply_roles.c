/* Finds the meaning of the header's elements and properties. */
#include "base/text.h"
#include "read/ply/ply.h"

#include <limits.h>
#include <string.h>

static size_t find_element(const ply_header *header, const char *name) {
    for (size_t i = 0; i < header->elements.count; ++i) {
        if (strcmp(header->elements.items[i].name, name) == 0) return i;
    }
    return SIZE_MAX;
}

/* The place of the name in the list of lower-case names; -1: none. Some programs write X, Nx or Red. */
static int find_name(const char *names, const char *name) {
    char lower[PLY_NAME];
    size_t length = 0;
    for (; name[length]; ++length)
        lower[length] = name[length] >= 'A' && name[length] <= 'Z' ? (char)(name[length] + 32) : name[length];
    return words_find(names, lower, length);
}

/* The first property that has the earliest possible name of the list; -1: none. */
static int find_property(const ply_element *element, const char *names) {
    int found = -1, best = INT_MAX;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const int word = find_name(names, element->properties.items[i].name);
        if (word >= 0 && word < best) best = word, found = (int)i;
    }
    return found;
}

/* The property with one of the names; -1: there is none, or it is a list. */
static int find_number(const ply_element *element, const char *names) {
    const int found = find_property(element, names);
    return found >= 0 && !element->properties.items[found].is_list ? found : -1;
}

static void set_role(ply_reader *r, int role, int property) {
    r->role[role] = property;
    if (property >= 0) r->header.elements.items[r->vertex_element].properties.items[property].role = role;
}

void ply_drop_role(ply_reader *r, int role) {
    const int property = r->role[role];
    r->role[role] = -1;
    if (property >= 0) r->header.elements.items[r->vertex_element].properties.items[property].role = -1;
}

/* Colours need all three channels; without them, an opacity is ignored too. */
static void drop_partial_colors(ply_reader *r) {
    const bool partial = r->role[PLY_R] < 0 || r->role[PLY_G] < 0 || r->role[PLY_B] < 0;
    for (int role = PLY_R; partial && role <= PLY_A; ++role) ply_drop_role(r, role);
}

/* The colour of splats is that of their first spherical harmonic, the mean over all directions. Their opacity
 * is a logit. */
static void find_splats(ply_reader *r, const ply_element *vertex) {
    static const char *const names[] = {"f_dc_0", "f_dc_1", "f_dc_2", "scale_0", "rot_0"};
    int found[5];
    for (int i = 0; i < 5; ++i) {
        found[i] = find_number(vertex, names[i]);
        if (found[i] < 0) return;
    }
    r->splats = r->role[PLY_R] < 0;
    if (!r->splats) return;
    for (int c = 0; c < 3; ++c) set_role(r, PLY_R + c, found[c]);
    set_role(r, PLY_A, find_number(vertex, "opacity"));
}

static const char *const color_names[] = {"red|diffuse_red|r", "green|diffuse_green|g", "blue|diffuse_blue|b",
                                          "alpha|a"};

static bool find_vertices(ply_reader *r) {
    const char *const names[PLY_ROLES] = {"x",
                                          "y",
                                          "z",
                                          "nx",
                                          "ny",
                                          "nz",
                                          "u|s|texture_u|texture_s",
                                          "v|t|texture_v|texture_t",
                                          "u1|s1",
                                          "v1|t1",
                                          color_names[0],
                                          color_names[1],
                                          color_names[2],
                                          color_names[3]};
    r->vertex_element = find_element(&r->header, "vertex");
    if (r->vertex_element == SIZE_MAX)
        return text_wrong(&r->fault, r->file.begin, "element vertex", "the header has none");
    const ply_element *vertex = &r->header.elements.items[r->vertex_element];
    if (vertex->count >= UINT32_MAX) {
        return text_wrong(&r->fault, vertex->line, "element vertex",
                          "%llu rows; at most 2^32 - 2 can be indexed", (unsigned long long)vertex->count);
    }
    r->vertex_count = (uint32_t)vertex->count;
    for (int role = 0; role < PLY_ROLES; ++role) {
        set_role(r, role, find_number(vertex, names[role]));
        if (role <= PLY_Z && r->role[role] < 0)
            return text_wrong(&r->fault, vertex->line, "element vertex",
                              "it has no number %s; expected x, y and z", names[role]);
    }
    drop_partial_colors(r);
    find_splats(r, vertex);
    return r->vertex_count ||
           text_wrong(&r->fault, r->file.begin, NULL,
                      "no vertices: expected an element vertex that is not empty, and an element face or "
                      "tristrips");
}

static bool find_faces(ply_reader *r) {
    char field[52];
    const ply_element *elements = r->header.elements.items;
    r->face_element = find_element(&r->header, "face");
    if (r->face_element == SIZE_MAX || !elements[r->face_element].count) {
        size_t strips = find_element(&r->header, "tristrips");
        r->strips = strips != SIZE_MAX && elements[strips].count > 0;
        if (r->strips) r->face_element = strips;
    }
    if (r->face_element == SIZE_MAX || !elements[r->face_element].count) {
        r->face_element = SIZE_MAX;
        return true;
    }
    const ply_element *face = &elements[r->face_element];
    int list = find_property(face, "vertex_indices|vertex_index");
    if (list < 0 || !face->properties.items[list].is_list) {
        return text_wrong(&r->fault, face->line, ply_element_field(face, field),
                          "it has no list vertex_indices or vertex_index");
    }
    r->index_list = (size_t)list;
    return true;
}

/* Colours of faces are read if vertices have none, and need all three channels. */
static void find_face_colors(ply_reader *r, const ply_element *face) {
    int found[4];
    for (int c = 0; c < 4; ++c) {
        found[c] = find_number(face, color_names[c]);
        if (r->role[PLY_R] >= 0 || (c < 3 && found[c] < 0)) return;
    }
    for (int c = 0; c < 4; ++c) {
        if (found[c] >= 0) face->properties.items[found[c]].role = PLY_FACE_R + c;
    }
    r->face_color = found[0], r->face_alpha = found[3];
    r->looks_read = true;
}

/* The number of a face's texture. False: faces have none. */
static bool find_texture_numbers(ply_reader *r, const ply_element *face) {
    const int found = find_number(face, "texnumber");
    if (!r->textures.count || found < 0) return false;
    face->properties.items[found].role = PLY_TEXNUMBER;
    r->looks_read = true;
    return true;
}

static void keep_one_texture(ply_reader *r) {
    if (r->textures.count > 1) {
        notes_add_at(&r->notes, r->textures.count - 1, &r->file, r->textures.items[1], true,
                     "textures after the first one are left out, because faces have no texnumber");
        r->textures.count = 1;
    }
}

/* Texture coordinates of the faces' corners go before those of vertices. */
static void find_face_uvs(ply_reader *r, const ply_element *face) {
    const int list = find_property(face, "texcoord");
    if (list < 0 || !face->properties.items[list].is_list) return;
    r->uv_list = (size_t)list;
    for (int role = PLY_U; role <= PLY_V; ++role) ply_drop_role(r, role);
}

static void find_looks(ply_reader *r) {
    r->uv_list = SIZE_MAX;
    r->face_color = r->face_alpha = -1;
    bool numbered = false;
    if (r->face_element != SIZE_MAX && !r->strips) {
        const ply_element *face = &r->header.elements.items[r->face_element];
        find_face_uvs(r, face);
        find_face_colors(r, face);
        numbered = find_texture_numbers(r, face);
    }
    if (!numbered) keep_one_texture(r);
}

/* An element "edge" without both vertices is not read, and gets a note. */
static void find_edges(ply_reader *r) {
    static const char *const names[PLY_ENDS] = {"vertex1", "vertex2"};
    r->edge_element = find_element(&r->header, "edge");
    if (r->edge_element == SIZE_MAX) return;
    const ply_element *edge = &r->header.elements.items[r->edge_element];
    int found[PLY_ENDS];
    bool good = edge->count > 0;
    for (int end = 0; end < PLY_ENDS; ++end) {
        found[end] = find_number(edge, names[end]);
        good = good && found[end] >= 0;
    }
    for (int end = 0; good && end < PLY_ENDS; ++end) edge->properties.items[found[end]].role = end;
    if (!good) r->edge_element = SIZE_MAX;
}

bool ply_find_roles(ply_reader *r) {
    if (!find_vertices(r) || !find_faces(r)) return false;
    find_looks(r);
    find_edges(r);
    return true;
}

/* ---- unused parts ---- */

/* An opacity, or a letter, is one only next to a whole colour: r may be a radius, and a an area. */
static bool is_color(const ply_element *element, const char *name) {
    bool whole = true;
    int channel = 4;
    for (int c = 0; c < 4; ++c) {
        if (find_name(color_names[c], name) >= 0) channel = c;
        whole &= c == 3 || find_property(element, color_names[c]) >= 0;
    }
    return channel < (whole ? 4 : strlen(name) > 1 ? 3 : 0);
}

static void note_properties(ply_reader *r, size_t index) {
    const ply_element *element = &r->header.elements.items[index];
    bool colors = false;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const char *name = element->properties.items[i].name;
        if (element->properties.items[i].role >= 0 ||
            (index == r->face_element && (i == r->index_list || i == r->uv_list)))
            continue;
        if (is_color(element, name))
            colors = true;
        else
            notes_add_at(&r->notes, (size_t)element->count, &r->file, element->line, false,
                         "element %.40s: the property %s is not used", element->name, name);
    }
    if (colors)
        notes_add_at(&r->notes, (size_t)element->count, &r->file, element->line, false,
                     "%.40s colours are not used", element->name);
}

void ply_note_unused(ply_reader *r) {
    for (size_t i = 0; i < r->header.elements.count; ++i) {
        const ply_element *element = &r->header.elements.items[i];
        if (i == r->vertex_element && r->splats)
            notes_add_at(&r->notes, (size_t)element->count, &r->file, element->line, false,
                         "Gaussian splats are shown as points of their mean colours and opacities, without "
                         "their sizes and directions");
        else if (i == r->vertex_element || i == r->face_element || i == r->edge_element)
            note_properties(r, i);
        else
            notes_add_at(&r->notes, (size_t)element->count, &r->file, element->line, false,
                         "element %.40s is not read", element->name);
    }
}
