/* The page of `fathom validate` from a file of its JSON. Usage: make_page JSON FOLDER */
#include "report/validate_page.h"

#include <fathom/fathom.h>
#include <stdio.h>

int main(int argc, char **argv) {
    fathom_context *context;
    if (argc != 3 || fathom_context_create(&context) != FATHOM_OK) return 2;
    json_error_t error;
    json_t *results = json_load_file(argv[1], 0, &error);
    page p = {.count = 0};
    validate_page(&p, results);
    fathom_status status = results ? page_write(context, &p, argv[2]) : FATHOM_BAD_INPUT;
    if (status != FATHOM_OK) fprintf(stderr, "%s\n", results ? fathom_context_message(context) : error.text);
    page_free(&p);
    json_decref(results);
    fathom_context_destroy(context);
    return (int)status;
}
