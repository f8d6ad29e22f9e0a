/* A queue of units of work, and the messages between ranks. */
#pragma once

#include "base/array.h"
#include "job/job.h"

/* An empty queue is all zeros. */
typedef struct unit_queue {
    ARRAY(work_unit) units;
    size_t first;     /* the units before it are taken */
    uint64_t squares; /* total of the units in the queue */
} unit_queue;

/* False when out of memory. */
bool unit_queue_add(unit_queue *q, work_unit unit);
/* Takes at most `most` squares of the first unit; its other squares stay. No squares if the queue is
 * empty. */
work_unit unit_queue_take(unit_queue *q, uint32_t most);

enum { HELLO = 1, WANT, UNITS, DONE, FILE_WANTED, FILE_PIECE };

/* The head of each message. */
typedef struct message {
    uint32_t kind, count;
} message;

typedef struct unit_record {
    work_unit unit;
    uint64_t samples;
    double error, seconds;
    ray_counts rays;
} unit_record;

/* A growing message of `count` records, each with its pixels. */
typedef struct unit_results {
    ARRAY(char) message; /* with its head, which the sender fills in */
    uint32_t count;
} unit_results;

/* Appends uninitialised memory for a record and its pixels; NULL: out of memory. */
char *unit_results_add(unit_results *all, size_t bytes);
