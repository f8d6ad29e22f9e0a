#include "report/heat.h"

#include "report/colour.h"
#include "report/frame.h"
#include "report/number.h"

#include <math.h>

#define CELL 22.0
#define TOP 6.0
#define BOTTOM 24.0

unsigned heat_step(const heat_range *range, double value) {
    if (!(value > range->low)) return 0;
    double place = log(value / range->low) / log(range->high / range->low) * COLOUR_STEPS;
    return place >= COLOUR_STEPS ? COLOUR_STEPS - 1 : (unsigned)place;
}

static void put_sign(page *p, heat_sign sign, double x, double y) {
    double r = CELL / 2;
    if (sign == HEAT_LEAK)
        page_put(p, "<circle class=\"leak\" cx=\"%.1f\" cy=\"%.1f\" r=\"3.5\"/>", x + r, y + r);
    if (sign == HEAT_WRONG)
        page_put(p, "<path class=\"wrong\" d=\"M%.1f %.1fl%g %gm0 %gl%g %g\"/>", x + r - 5, y + r - 5, 10.0,
                 10.0, -10.0, -10.0, 10.0);
}

static void put_cell(page *p, const heat *h, const heat_cell *cell, double x, double y) {
    if (cell->sign == HEAT_NONE) return;
    page_put(p, "<g class=\"mark\"><title>");
    page_text(p, cell->title);
    page_put(p, "</title><rect class=\"h%u\" x=\"%.1f\" y=\"%.1f\" width=\"%g\" height=\"%g\"/>",
             heat_step(&h->range, cell->value), x, y, CELL - 1, CELL - 1);
    put_sign(p, cell->sign, x, y);
    page_put(p, "</g>\n");
}

/* Half the room of a column's number, with space to the next one. */
static double half_number(double x) {
    number text = number_tick(x);
    return FRAME_LETTER * (double)number_width(text.text) / 2 + 3;
}

/* Numbers under every nth column: the least n at which they do not touch. */
static size_t column_stride(const heat *h) {
    size_t stride = 1;
    for (size_t i = 0; i + stride < h->column_count;) {
        double room = half_number(h->columns[i]) + half_number(h->columns[i + stride]);
        if (room <= CELL * (double)stride)
            i += stride;
        else
            ++stride, i = 0;
    }
    return stride;
}

static void put_columns(page *p, const heat *h, double left, double y) {
    size_t stride = column_stride(h);
    for (size_t i = 0; i < h->column_count; i += stride)
        page_put(p, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n",
                 left + CELL * ((double)i + 0.5), y, number_tick(h->columns[i]).text);
}

static size_t count_marks(const heat *h) {
    size_t marks = 0;
    for (size_t i = 0; i < h->row_count * h->column_count; ++i) marks += h->cells[i].sign != HEAT_NONE;
    return marks;
}

static void put_row(page *p, const heat *h, size_t row, double left) {
    double y = TOP + CELL * (double)row;
    page_put(p, "<text class=\"label\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">", left - 7,
             y + CELL / 2 + 4);
    page_text(p, h->rows[row]);
    page_put(p, "</text>\n");
    for (size_t i = 0; i < h->column_count; ++i)
        put_cell(p, h, &h->cells[row * h->column_count + i], left + CELL * (double)i, y);
}

void heat_put(page *p, const heat *h) {
    size_t widest = 4;
    for (size_t i = 0; i < h->row_count; ++i) {
        size_t width = number_width(h->rows[i]);
        if (width > widest) widest = width;
    }
    double left = FRAME_LETTER * (double)widest + 12, bottom = TOP + CELL * (double)h->row_count;
    /* The number of the last column may be wider than the column. */
    double width = left + CELL * (double)h->column_count + 24;
    page_put(p, "<figure>\n<h3>");
    page_text(p, h->title);
    page_put(p, "</h3>\n<div class=\"scroll\">");
    frame_svg_open(p, width, bottom + BOTTOM, h->title, h->summary, count_marks(h));
    for (size_t i = 0; i < h->row_count; ++i) put_row(p, h, i, left);
    put_columns(p, h, left, bottom + 16);
    frame_close(p, h->caption);
}

void heat_legend(page *p, const heat_range *range, const char *name) {
    double step = 16, width = step * COLOUR_STEPS;
    page_put(p, "<ul class=\"legend\">\n<li>");
    page_text(p, name);
    page_put(
        p,
        ": \xe2\x89\xa4 %s&nbsp;<svg viewBox=\"0 0 %g 14\" width=\"%g\" height=\"14\" aria-hidden=\"true\">",
        number_tick(range->low).text, width, width);
    for (unsigned i = 0; i < COLOUR_STEPS; ++i)
        page_put(p, "<rect class=\"h%u\" x=\"%g\" y=\"0\" width=\"%g\" height=\"14\"/>", i, step * i, step);
    page_put(p, "</svg>&nbsp;\xe2\x89\xa5 %s</li>\n", number_tick(range->high).text);
    static const struct {
        heat_sign sign;
        const char *name;
    } signs[2] = {{HEAT_LEAK, "some leak"}, {HEAT_WRONG, "some are wrong"}};
    for (int i = 0; i < 2; ++i) {
        page_put(p, "<li><svg viewBox=\"0 0 %g %g\" width=\"%g\" height=\"%g\" aria-hidden=\"true\">", CELL,
                 CELL, CELL, CELL);
        put_sign(p, signs[i].sign, 0, 0);
        page_put(p, "</svg> %s</li>\n", signs[i].name);
    }
    page_put(p, "</ul>\n");
}
