/* A C program: a material of its own, two analyses at once, values by name, errors with their sentences. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "qsmpm.h"

struct hooke {
    double young, poisson;
    long calls;
    int fails_at; /* phase in which it says that it is broken, 0 for never */
};

static int update(void *user, const qsmpm_increment *increment, double *stress, double *state, qsmpm_response *answer)
{
    struct hooke *law = user;
    double shear = law->young / (2 * (1 + law->poisson)), lame = 2 * shear * law->poisson / (1 - 2 * law->poisson);
    int i, j;

    law->calls++;
    if (increment->phase == law->fails_at) {
        strcpy(answer->message, "this model is for one phase only");
        return QSMPM_UNRECOVERABLE;
    }
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) answer->tangent[i + 6 * j] = lame;
        answer->tangent[7 * i] += 2 * shear;
        answer->tangent[7 * (i + 3)] = shear;
    }
    for (i = 0; i < 6; i++)
        for (j = 0; j < 6; j++) stress[i] += answer->tangent[i + 6 * j] * increment->strain[j];
    state[0] += increment->strain[1];
    return QSMPM_UPDATED;
}

static void hear(void *user, const char *text)
{
    ++*(int *)user;
    if (text[0] == '\0') puts("an empty sentence");
}

static int failed(qsmpm_handle handle, const char *what)
{
    char text[400];

    qsmpm_error(handle, text, sizeof text);
    printf("failed: %s: %s\n", what, text);
    return 1;
}

int main(void)
{
    qsmpm_handle own = NULL, theirs = NULL;
    struct hooke law = {1000.0, 0.3, 0, 2};
    qsmpm_model_options options = {1, 1, 0, 0, 0, 1000.0, 1000.0 / 2.6};
    const double *position, gravity[3] = {0, -2, 0};
    double settlement[2], state[2000];
    char text[400];
    int heard = 0, rows, columns, number, status;

    if (qsmpm_api_version() / 100 != QSMPM_API_VERSION / 100) return 1;
    if (qsmpm_advance(NULL) != QSMPM_NO_HANDLE || qsmpm_destroy(&own) != QSMPM_OK) return 1;
    if (qsmpm_create(&own) || qsmpm_create(&theirs)) return 1;
    qsmpm_set_logger(own, hear, &heard);
    status = qsmpm_advance(own);
    qsmpm_error(own, text, sizeof text);
    printf("status %d %s\n", status, text);
    if (qsmpm_read_deck(own, "block.inp") || qsmpm_set_material(own, "soil", &options, NULL, update, &law) ||
        qsmpm_initialise(own)) return failed(own, "own");
    if (qsmpm_read_deck(theirs, "block.inp") || qsmpm_initialise(theirs)) return failed(theirs, "theirs");
    qsmpm_view(own, "point_position", &position, &rows, &columns);
    while (!qsmpm_finished(own))
        if (qsmpm_advance(own) || qsmpm_advance(theirs)) return failed(own, "step");
    qsmpm_get(own, "histories", settlement, 1);
    qsmpm_get(theirs, "histories", settlement + 1, 1);
    printf("own %.14e theirs %.14e heard %d\n", settlement[0], settlement[1], heard);
    qsmpm_count(own, "point_state", &number);
    if (number > 2000 || qsmpm_get(own, "point_state", state, number)) return failed(own, "state");
    printf("view %d x %d, first point %.6f, its state %.6e, called %s\n", rows, columns, position[1], state[0],
           law.calls > 0 ? "yes" : "no");
    if (qsmpm_add_stage(own, "more", 2) || qsmpm_set_gravity(own, gravity)) return failed(own, "stage");
    status = qsmpm_run(own);
    qsmpm_error(own, text, sizeof text);
    printf("status %d %s\n", status, text);
    qsmpm_destroy(&own);
    qsmpm_destroy(&theirs);
    return own == NULL ? 0 : 1;
}
