#include "measure/watch.h"

#include <stddef.h>

static double at(const bench_watch *watch, double share) {
    return watch->from + (watch->to - watch->from) * share;
}

void bench_watch_tell(const bench_watch *watch, double done, double total) {
    if (watch && watch->tell && total > 0) watch->tell(watch->user, at(watch, done / total));
}

bench_watch bench_watch_part(const bench_watch *watch, double from, double to) {
    if (!watch) return (bench_watch){.tell = NULL};
    return (bench_watch){watch->tell, watch->user, at(watch, from), at(watch, to)};
}
