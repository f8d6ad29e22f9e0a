/* Units of work in their order. */
#ifndef JOB_RANKS_UNIT_QUEUE_H
#define JOB_RANKS_UNIT_QUEUE_H

#include "job/unit.h"

/* Zeros are an empty one; release `units` with free(). */
typedef struct unit_queue {
    work_unit *units;
    uint32_t first, end, room;
    uint64_t squares; /* of all units from `first` on */
} unit_queue;

/* False when out of memory. */
bool unit_queue_add(unit_queue *q, work_unit unit);
/* At most so many squares of the next unit, of which the others stay; none where there is no unit. */
work_unit unit_queue_take(unit_queue *q, uint32_t most);

#endif
