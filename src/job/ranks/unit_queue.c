#include "job/ranks/unit_queue.h"

#include <stdlib.h>
#include <string.h>

static bool make_room(unit_queue *q) {
    if (q->first) {
        q->end -= q->first;
        memmove(q->units, q->units + q->first, q->end * sizeof *q->units);
        q->first = 0;
        return true;
    }
    const uint32_t room = q->room ? 2 * q->room : 256;
    work_unit *more = realloc(q->units, room * sizeof *more);
    if (!more) return false;
    q->units = more, q->room = room;
    return true;
}

bool unit_queue_add(unit_queue *q, work_unit unit) {
    if (q->end == q->room && !make_room(q)) return false;
    q->units[q->end++] = unit;
    q->squares += (uint64_t)__builtin_popcountll(unit.squares);
    return true;
}

work_unit unit_queue_take(unit_queue *q, uint32_t most) {
    if (q->first == q->end) return (work_unit){.squares = 0};
    work_unit *next = &q->units[q->first], taken = {.wave = next->wave};
    for (; most && next->squares; --most, --q->squares) {
        taken.squares |= next->squares & -next->squares;
        next->squares &= next->squares - 1;
    }
    if (!next->squares) ++q->first;
    return taken;
}

char *unit_results_add(unit_results *all, size_t bytes) {
    const size_t used = all->used ? all->used : sizeof(message), needed = used + bytes;
    if (needed > all->room) {
        char *more = realloc(all->bytes, 2 * needed);
        if (!more) return NULL;
        all->bytes = more, all->room = 2 * needed;
    }
    all->used = needed;
    ++all->count;
    return all->bytes + used;
}
