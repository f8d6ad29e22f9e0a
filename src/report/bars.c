#include "report/bars.h"

#include "report/frame.h"
#include "report/number.h"

#include <math.h>

static void put_bar(page *p, const frame *f, const bar *b, double floor) {
    double left = scale_at(&f->x.scale, b->from), right = scale_at(&f->x.scale, b->to);
    if (b->to <= 0) left -= 4, right += 4;
    double top = scale_at(&f->y.scale, b->count);
    page_put(p, "<path class=\"mark bar\" d=\"M%.1f %.1fV%.1fH%.1fV%.1fz\"><title>", left, floor, top,
             fmax(right - 0.6, left + 0.8), floor);
    if (b->to > 0)
        page_put(p, "%s to %s: ", number_of(b->from).text, number_of(b->to).text);
    else
        page_put(p, "0: ");
    page_put(p, "%s</title></path>\n", number_count((uint64_t)b->count).text);
}

void bars_put(page *p, const bars *b) {
    box area = frame_area(b->width, b->height);
    frame f = {b->title, b->summary, b->width, b->height, .marks = b->count};
    f.x = (axis){.name = b->x_name, .scale = scale_over(true, b->low, b->high, area.left + 6, area.right)};
    f.y = (axis){.name = b->y_name, .scale = scale_over(true, 1, fmax(10, b->most), area.bottom, area.top)};
    /* One ray is a bar that can be seen. */
    f.y.scale.from -= 6;
    frame_zero(&f.x, b->zero);
    frame_open(p, &f);
    for (size_t i = 0; i < b->count; ++i) put_bar(p, &f, &b->items[i], area.bottom);
    frame_close(p, b->caption);
}

#define RATIO_WIDTH 120.0
#define RATIO_LOW 1e-6
#define RATIO_HIGH 10.0

void bars_ratio(page *p, double value, const char *title) {
    scale s = {true, RATIO_LOW, RATIO_HIGH, 0, RATIO_WIDTH, 0};
    double end = isnan(value) ? 0 : scale_at(&s, value), one = scale_at(&s, 1);
    page_put(p, "<svg class=\"ratio\" viewBox=\"0 0 %g 14\" width=\"%g\" height=\"14\" role=\"img\"><title>",
             RATIO_WIDTH, RATIO_WIDTH);
    page_text(p, title);
    page_put(p, "</title><path class=\"track\" d=\"M0 3h%gv8H0z\"/>", RATIO_WIDTH);
    page_put(p, "<path class=\"mark %s\" d=\"M0 3H%.1fV11H0z\"/>", value <= 1 ? "fine" : "over",
             fmax(1, end));
    page_put(p, "<path class=\"limit\" d=\"M%.1f 0v14\"/></svg>", one);
}
