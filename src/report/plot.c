#include "report/plot.h"

#include "report/number.h"

#include <math.h>
#include <stdlib.h>

#define MARK 5.0 /* half a mark's width, pixels */

static bool is_drawn(const plot_point *q) { return isfinite(q->x) && isfinite(q->y); }

/* ---- marks ---- */

/* Circle, square, triangle, diamond. */
static void put_mark(page *p, double x, double y, unsigned kind, const char *class) {
    double r = MARK;
    page_put(p, "<path class=\"%s k%u\" d=\"", class, kind % PLOT_KINDS);
    switch (kind % PLOT_KINDS) {
    case 0:
        page_put(p, "M%.1f %.1fa%g %g 0 1 0 %g 0a%g %g 0 1 0 %g 0z", x - r, y, r, r, 2 * r, r, r, -2 * r);
        break;
    case 1:
        page_put(p, "M%.1f %.1fh%gv%gh%gz", x - r + 0.5, y - r + 0.5, 2 * r - 1, 2 * r - 1, 1 - 2 * r);
        break;
    case 2: page_put(p, "M%.1f %.1fl%g %gh%gz", x, y - r - 0.5, r + 0.5, 2 * r, -2 * r - 1); break;
    case 3:
        page_put(p, "M%.1f %.1fl%g %gl%g %gl%g %gz", x, y - r - 1, r + 1, r + 1, -r - 1, r + 1, -r - 1,
                 -r - 1);
        break;
    }
    page_put(p, "\"/>");
}

static void put_point(page *p, const axis *x, const axis *y, const plot_point *q) {
    double across = scale_at(&x->scale, q->x), up = scale_at(&y->scale, q->y);
    page_put(p, "<g class=\"mark\"><title>");
    page_text(p, q->title);
    page_put(p, "</title>");
    if (isfinite(q->high)) {
        double top = scale_at(&y->scale, q->high);
        page_put(p, "<line class=\"interval k%u\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>",
                 q->kind % PLOT_KINDS, across, up, across, top);
        put_mark(p, across, top, q->kind, "hollow");
    }
    put_mark(p, across, up, q->kind, q->hollow ? "hollow" : "solid");
    page_put(p, "</g>\n");
}

/* ---- lines ---- */

static bool can_show(bool log, double x) { return isfinite(x) && (!log || x > 0); }

static bool is_line_drawn(const plot *t, const plot_line *l) {
    return can_show(t->x_log, l->x0) && can_show(t->x_log, l->x1) && can_show(t->y_log, l->y0) &&
           can_show(t->y_log, l->y1);
}

static void put_line(page *p, const axis *x, const axis *y, const plot_line *l) {
    page_put(p, "<line class=\"interval k%u%s\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n",
             l->kind % PLOT_KINDS, l->dashed ? " dashed" : "", scale_at(&x->scale, l->x0),
             scale_at(&y->scale, l->y0), scale_at(&x->scale, l->x1), scale_at(&y->scale, l->y1));
}

/* ---- labels ---- */

static box mark_box(double x, double y) {
    return (box){x - MARK - 1, y - MARK - 1, x + MARK + 1, y + MARK + 1};
}

/* What no label may cover: both marks and the line between them. */
static size_t take_room(const plot *t, const axis *x, const axis *y, box *taken) {
    size_t count = 0;
    for (size_t i = 0; i < t->count; ++i) {
        const plot_point *q = &t->points[i];
        if (!is_drawn(q)) continue;
        double across = scale_at(&x->scale, q->x), up = scale_at(&y->scale, q->y);
        taken[count++] = mark_box(across, up);
        if (!isfinite(q->high)) continue;
        double top = scale_at(&y->scale, q->high);
        taken[count++] = mark_box(across, top);
        taken[count++] = (box){across - 1, top, across + 1, up};
    }
    return count;
}

static void put_label(page *p, const label *l, const char *text) {
    if (!l->placed) return;
    double y = (l->at.top + l->at.bottom) / 2;
    if (l->far) {
        double x, end;
        label_leader(l, &x, &end);
        page_put(p, "<line class=\"leader\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>", l->x, l->y, x,
                 end);
    }
    page_put(p, "<text class=\"label\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">",
             (l->at.left + l->at.right) / 2, y + 4);
    page_text(p, text);
    page_put(p, "</text>\n");
}

static void put_labels(page *p, const plot *t, const axis *x, const axis *y) {
    label *labels = calloc(t->count, sizeof *labels);
    box *taken = calloc(t->count, 3 * sizeof *taken), area = frame_area(t->width, t->height);
    size_t count = 0;
    if (!labels || !taken) p->lost = true;
    for (size_t i = 0; i < t->count && !p->lost; ++i) {
        const plot_point *q = &t->points[i];
        if (!is_drawn(q) || !q->label) continue;
        double width = FRAME_LETTER * (double)number_width(q->label) + 4;
        labels[count++] = (label){scale_at(&x->scale, q->x), scale_at(&y->scale, q->y), width, FRAME_TEXT + 3,
                                  .placed = false};
    }
    if (!p->lost) place_labels(labels, count, taken, take_room(t, x, y, taken), &area);
    for (size_t i = 0, k = 0; i < t->count && !p->lost; ++i) {
        if (is_drawn(&t->points[i]) && t->points[i].label) put_label(p, &labels[k++], t->points[i].label);
    }
    free(labels);
    free(taken);
}

/* ---- the plot ---- */

typedef struct extent {
    double least, most;
    bool zero;
} extent;

static void extend(extent *e, bool log, double x) {
    if (!isfinite(x)) return;
    if (log && !(x > 0)) {
        e->zero = true;
        return;
    }
    e->least = fmin(e->least, x), e->most = fmax(e->most, x);
}

static axis axis_over(const char *name, bool log, const extent *e, double from, double to) {
    axis a = {.name = name};
    bool none = !(e->least <= e->most);
    a.scale = scale_over(log, none ? 1 : e->least, none ? 1 : e->most, from, to);
    frame_zero(&a, e->zero);
    return a;
}

/* What the axes must hold; returns how many points are drawn. */
static size_t measure(const plot *t, extent *across, extent *up) {
    size_t marks = 0;
    extend(up, t->y_log, t->y_low), extend(up, t->y_log, t->y_high);
    for (size_t i = 0; i < t->count; ++i) {
        const plot_point *q = &t->points[i];
        if (!is_drawn(q)) continue;
        ++marks;
        extend(across, t->x_log, q->x), extend(up, t->y_log, q->y), extend(up, t->y_log, q->high);
    }
    for (size_t i = 0; i < t->line_count; ++i) {
        const plot_line *l = &t->lines[i];
        if (!is_line_drawn(t, l)) continue;
        extend(across, t->x_log, l->x0), extend(across, t->x_log, l->x1);
        extend(up, t->y_log, l->y0), extend(up, t->y_log, l->y1);
    }
    return marks;
}

void plot_put(page *p, const plot *t) {
    extent across = {INFINITY, -INFINITY, false}, up = across;
    size_t marks = measure(t, &across, &up);
    box area = frame_area(t->width, t->height);
    frame f = {t->title, t->summary, t->width, t->height, .marks = marks};
    /* Marks at the ends stay clear of the frame. */
    double in = 2 * MARK;
    f.x = axis_over(t->x_name, t->x_log, &across, area.left + in, area.right - in);
    f.y = axis_over(t->y_name, t->y_log, &up, area.bottom - in, area.top + in);
    frame_open(p, &f);
    for (size_t i = 0; i < t->line_count; ++i) {
        if (is_line_drawn(t, &t->lines[i])) put_line(p, &f.x, &f.y, &t->lines[i]);
    }
    for (size_t i = 0; i < t->count; ++i) {
        if (is_drawn(&t->points[i])) put_point(p, &f.x, &f.y, &t->points[i]);
    }
    put_labels(p, t, &f.x, &f.y);
    frame_close(p, t->caption);
}

static void put_key(page *p, unsigned kind, const char *class, const char *name) {
    page_put(p, "<li><svg viewBox=\"0 0 16 16\" width=\"16\" height=\"16\" aria-hidden=\"true\">");
    put_mark(p, 8, 8, kind, class);
    page_put(p, "</svg> ");
    page_text(p, name);
    page_put(p, "</li>\n");
}

void plot_legend(page *p, const char *const names[PLOT_KINDS], const char *solid, const char *hollow) {
    page_put(p, "<ul class=\"legend\">\n");
    for (unsigned k = 0; k < PLOT_KINDS; ++k) {
        if (names[k]) put_key(p, k, "solid", names[k]);
    }
    put_key(p, 0, "solid plain", solid);
    if (hollow) put_key(p, 0, "hollow plain", hollow);
    page_put(p, "</ul>\n");
}
