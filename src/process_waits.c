/* How threads wait. Those of OpenMP spin until there is work for them, which on busy cores takes the time of those that
 * have some: two of them on two busy cores made a run fifteen times longer. The runtime reads how it is to wait when it
 * is loaded, before the program has seen its words; so a run that asks for threads starts the program once more with
 * the environment set. What the caller has set stays. */
#define _DEFAULT_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

/* Most words of a command line; a longer one runs as it is. */
enum { MOST_WORDS = 64, MOST_BYTES = 65536 };

/* Start the program again so that its threads sleep while they wait; comes back where that was done or cannot be. */
void qsmpm_wait_asleep(void)
{
    static char words[MOST_BYTES];
    char *argv[MOST_WORDS + 1];
    size_t length, place;
    int count = 0;
    FILE *file;

    if (getenv("OMP_WAIT_POLICY") || getenv("GOMP_SPINCOUNT")) return;
    file = fopen("/proc/self/cmdline", "re");
    if (!file) return;
    length = fread(words, 1, sizeof words, file);
    fclose(file);
    if (length == 0 || length == sizeof words || words[length - 1] != '\0') return;
    for (place = 0; place < length && count < MOST_WORDS; count++) {
        argv[count] = words + place;
        while (words[place++] != '\0') continue;
    }
    if (place < length) return;
    argv[count] = NULL;
    if (setenv("OMP_WAIT_POLICY", "passive", 1)) return;
    setenv("OPENBLAS_NUM_THREADS", "1", 0);
    execv("/proc/self/exe", argv);
}
