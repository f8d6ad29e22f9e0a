#include "job/watch.h"

#include "base/pool.h"

void watch_run(const watch_calls *calls, void *user) {
    pool_task task = {.run = calls->work, .user = user};
    if (pool_run(&task)) {
        while (!pool_wait(&task, 0.1)) calls->tick(user);
    } else {
        calls->work(user);
    }
    calls->tick(user);
}
