#include "cli/validate/validate.h"

#include "cli/render/outputs.h"
#include "cli/report.h"

#include <limits.h>

fathom_status validate_check_report(fathom_context *context, const validate_settings *settings) {
    fathom_status status = report_check(context, settings->report);
    if (status != FATHOM_OK) return status;
    char paths[REPORT_FILES][PATH_MAX];
    report_paths(settings->report, paths[0], paths[1]);
    const char *outputs[REPORT_FILES + 2] = {paths[0], paths[1]};
    size_t count = REPORT_FILES;
    if (settings->json) outputs[count++] = settings->json;
    if (settings->failures) outputs[count++] = settings->failures;
    return outputs_check_distinct(context, outputs, count, settings->scene);
}
