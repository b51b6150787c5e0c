/* METIS with restored signal handlers.
 *
 * While METIS runs it handles SIGTERM: it reports its errors by raising this signal, and takes a signal sent by a user
 * for such an error. A failed call is therefore repeated once. If the second call succeeds the signal was the user's
 * and is raised again for the original handler. The handlers of SIGTERM and SIGABRT are restored with their flags,
 * which METIS does not preserve. */
#define _POSIX_C_SOURCE 200809L
#include <signal.h>
#include <stddef.h>
#include <metis.h>

int qsmpm_metis_order(int n, int *first, int *neighbour, int seed, int *order, int *position);
int qsmpm_metis_parts(int n, int *first, int *neighbour, int *weight, int parts, int seed, int *part);

/* Makes one call and restores the handlers. */
static int order_once(idx_t n, idx_t *first, idx_t *neighbour, idx_t *options, idx_t *order, idx_t *position)
{
    struct sigaction on_term, on_abort;
    int status;

    sigaction(SIGTERM, NULL, &on_term);
    sigaction(SIGABRT, NULL, &on_abort);
    status = METIS_NodeND(&n, first, neighbour, NULL, options, order, position);
    sigaction(SIGTERM, &on_term, NULL);
    sigaction(SIGABRT, &on_abort, NULL);
    return status;
}

/* Nested dissection of a graph in compressed rows from 0; returns 0 on success. */
int qsmpm_metis_order(int n, int *first, int *neighbour, int seed, int *order, int *position)
{
    idx_t options[METIS_NOPTIONS];
    int status;

    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = seed;
    status = order_once(n, first, neighbour, options, order, position);
    if (status == METIS_ERROR) {
        status = order_once(n, first, neighbour, options, order, position);
        if (status == METIS_OK) raise(SIGTERM);
    }
    return status == METIS_OK ? 0 : -1;
}

/* Makes one call and restores the handlers. */
static int part_once(idx_t n, idx_t *first, idx_t *neighbour, idx_t *weight, idx_t parts, idx_t *options, idx_t *part)
{
    struct sigaction on_term, on_abort;
    idx_t constraints = 1, cut;
    int status;

    sigaction(SIGTERM, NULL, &on_term);
    sigaction(SIGABRT, NULL, &on_abort);
    status = METIS_PartGraphKway(&n, &constraints, first, neighbour, weight, NULL, NULL, &parts, NULL, NULL, options,
                                 &cut, part);
    sigaction(SIGTERM, &on_term, NULL);
    sigaction(SIGABRT, &on_abort, NULL);
    return status;
}

/* Partition of a graph in compressed rows from 0; returns 0 on success. */
int qsmpm_metis_parts(int n, int *first, int *neighbour, int *weight, int parts, int seed, int *part)
{
    idx_t options[METIS_NOPTIONS];
    int status;

    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = seed;
    status = part_once(n, first, neighbour, weight, parts, options, part);
    if (status == METIS_ERROR) {
        status = part_once(n, first, neighbour, weight, parts, options, part);
        if (status == METIS_OK) raise(SIGTERM);
    }
    return status == METIS_OK ? 0 : -1;
}
