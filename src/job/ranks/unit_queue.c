#include "job/ranks/unit_queue.h"

#include <string.h>

bool unit_queue_add(unit_queue *q, work_unit unit) {
    q->units.count -= q->first;
    if (q->first) memmove(q->units.items, q->units.items + q->first, q->units.count * sizeof unit);
    q->first = 0;
    q->squares += (uint64_t)__builtin_popcountll(unit.squares);
    return array_push(&q->units, unit);
}

work_unit unit_queue_take(unit_queue *q, uint32_t most) {
    if (q->first == q->units.count) return (work_unit){.squares = 0};
    work_unit *next = &q->units.items[q->first], taken = {.wave = next->wave};
    for (; most && next->squares; --most, --q->squares) {
        taken.squares |= next->squares & -next->squares;
        next->squares &= next->squares - 1;
    }
    if (!next->squares) ++q->first;
    return taken;
}

char *unit_results_add(unit_results *all, size_t bytes) {
    const size_t used = all->message.count ? all->message.count : sizeof(message);
    if (!array_room(&all->message, used + bytes - all->message.count)) return NULL;
    all->message.count = used + bytes;
    ++all->count;
    return all->message.items + used;
}
