/* A C program that pushes a rigid plate on the ground, then loads it step by step, and reads its place and force. */
#include <stdio.h>
#include "qsmpm.h"

static int step_through(qsmpm_handle run, const char *word)
{
    double found[2];

    while (!qsmpm_finished(run)) {
        if (qsmpm_advance(run) || qsmpm_get(run, "histories", found, 2)) return 1;
        printf("%s %.14e %.14e\n", word, found[0], found[1]);
    }
    return 0;
}

int main(void)
{
    qsmpm_handle run = NULL;
    char text[400];

    if (qsmpm_create(&run) || qsmpm_read_deck(run, "plate.inp") || qsmpm_initialise(run) ||
        step_through(run, "MOVED") ||
        qsmpm_add_cards(run, "*PHASE, NAME=load\n*LOAD, BODY=plate, COMPONENT=Y\n-40\n"
                             "*CONTROLS, STEPS=2, TOLERANCE=1e-8\n*END PHASE\n") ||
        step_through(run, "LOADED")) {
        qsmpm_error(run, text, sizeof text);
        printf("failed: %s\n", text);
        return 1;
    }
    qsmpm_destroy(&run);
    return 0;
}
