#include "report/frame.h"

#include "report/number.h"

#define LEFT 78.0  /* a tick such as 5×10⁻³, and the axis' name */
#define RIGHT 34.0 /* half of a tick such as 100×10⁻³ at the end */
#define TOP 12.0
#define BOTTOM 46.0
#define LEAST 0.75 /* what text in plots may shrink to on a narrow screen, before they scroll */
#define ZERO 22.0  /* from 0 to the low end of a logarithmic axis */

box frame_area(double width, double height) { return (box){LEFT, TOP, width - RIGHT, height - BOTTOM}; }

void frame_zero(axis *a, bool zero) {
    a->zero = zero;
    if (zero) a->scale.from += a->scale.to > a->scale.from ? ZERO : -ZERO;
}

void frame_svg_open(page *p, double width, double height, const char *title, const char *summary,
                    size_t marks) {
    unsigned id = ++p->ids;
    page_put(p,
             "<svg viewBox=\"0 0 %g %g\" width=\"%g\" height=\"%g\" style=\"min-width:%gpx\" role=\"img\" "
             "aria-labelledby=\"t%u d%u\" data-marks=\"%zu\">\n<title id=\"t%u\">",
             width, height, width, height, LEAST * width, id, id, marks, id);
    page_text(p, title);
    page_put(p, "</title>\n<desc id=\"d%u\">", id);
    page_text(p, summary);
    page_put(p, "</desc>\n");
}

static void put_tick(page *p, const box *area, bool across, double at, const char *text) {
    if (across)
        page_put(p,
                 "<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>"
                 "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n",
                 at, area->top, at, area->bottom, at, area->bottom + 16, text);
    else
        page_put(p,
                 "<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>"
                 "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n",
                 area->left, at, area->right, at, area->left - 7, at + 4, text);
}

static void put_axis(page *p, const box *area, const axis *a, bool across, size_t most) {
    double ticks[SCALE_TICKS];
    size_t count = scale_ticks(&a->scale, most, ticks);
    /* Powers of ten all look alike; so do numbers between them. */
    bool powers = true;
    for (size_t i = 0; i < count; ++i) powers &= number_is_power(ticks[i]);
    for (size_t i = 0; i < count; ++i) {
        number text = powers ? number_tick(ticks[i]) : number_of(ticks[i]);
        put_tick(p, area, across, scale_at(&a->scale, ticks[i]), text.text);
    }
    if (a->zero) put_tick(p, area, across, a->scale.zero, "0");
    if (across)
        page_put(p, "<text class=\"axis\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">",
                 (area->left + area->right) / 2, area->bottom + 38);
    else
        page_put(p,
                 "<text class=\"axis\" transform=\"translate(14 %.1f) rotate(-90)\" text-anchor=\"middle\">",
                 (area->top + area->bottom) / 2);
    page_text(p, a->name);
    page_put(p, "</text>\n");
}

void frame_open(page *p, const frame *f) {
    box area = frame_area(f->width, f->height);
    page_put(p, "<figure>\n<h3>");
    page_text(p, f->title);
    page_put(p, "</h3>\n<div class=\"scroll\">");
    frame_svg_open(p, f->width, f->height, f->title, f->summary, f->marks);
    put_axis(p, &area, &f->x, true, f->width > 800 ? 12 : f->width > 400 ? 8 : 6);
    put_axis(p, &area, &f->y, false, f->height > 240 ? 8 : 5);
    page_put(p, "<path class=\"rule\" d=\"M%.1f %.1fV%.1fH%.1f\"/>\n", area.left, area.top, area.bottom,
             area.right);
}

void frame_close(page *p, const char *caption) {
    page_put(p, "</svg></div>\n");
    if (*caption) {
        page_put(p, "<figcaption>");
        page_text(p, caption);
        page_put(p, "</figcaption>\n");
    }
    page_put(p, "</figure>\n");
}
