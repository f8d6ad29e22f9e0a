#include "cli/validate.h"

#include "base/file.h"
#include "cli/outputs.h"
#include "report/validate_page.h"

#include <limits.h>
#include <stdio.h>

fathom_status validate_check_report(fathom_context *context, const validate_settings *settings) {
    fathom_status status = page_check(context, settings->report);
    if (status != FATHOM_OK) return status;
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/index.html", settings->report);
    const char *outputs[3] = {path};
    size_t count = 1;
    if (settings->json) outputs[count++] = settings->json;
    if (settings->failures) outputs[count++] = settings->failures;
    return outputs_check_distinct(context, outputs, count, settings->scene);
}

fathom_status validate_write_report(fathom_context *context, const json_t *results,
                                    const validate_settings *settings) {
    page p = {.count = 0};
    validate_page(&p, results);
    fathom_status status = page_write(context, &p, settings->report);
    page_free(&p);
    return status;
}
