/* A library without a tracer. */
int fathom_nothing_here(void);
int fathom_nothing_here(void) { return 0; }
