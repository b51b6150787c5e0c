/* What the process wants of the system before it begins.
 *
 * How threads wait. Those of OpenMP spin until there is work for them, which on busy cores takes the time of those that
 * have some: two of them on two busy cores made a run fifteen times longer. The runtime reads how it is to wait when it
 * is loaded, before the program has seen its words; so a run that asks for threads starts the program once more with
 * the environment set. What the caller has set stays.
 *
 * The stack: one that the shell limits (ulimit -s) to less than the libraries take ends the process without a word, and
 * that of the threads is settled when the program is loaded; so it is started once more with more, where it may have
 * more. Files: one that would pass ulimit -f is to fail to be written, and not to end the process. */
#define _DEFAULT_SOURCE
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

/* Most words of a command line; a longer one runs as it is. */
enum { MOST_WORDS = 64, MOST_BYTES = 65536 };
/* Least stack, and the usual one [kB]. */
enum { LEAST_STACK = 1024, USUAL_STACK = 8192 };

/* Start the program again with the same words; comes back where that cannot be. */
static void start_again(void)
{
    static char words[MOST_BYTES];
    char *argv[MOST_WORDS + 1];
    size_t length, place;
    int count = 0;
    FILE *file;

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
    execv("/proc/self/exe", argv);
}

/* Start the program again so that its threads sleep while they wait; comes back where that was done or cannot be. */
void qsmpm_wait_asleep(void)
{
    if (getenv("OMP_WAIT_POLICY") || getenv("GOMP_SPINCOUNT")) return;
    if (setenv("OMP_WAIT_POLICY", "passive", 1)) return;
    setenv("OPENBLAS_NUM_THREADS", "1", 0);
    start_again();
}

/* Let files that grow too large fail, and see to the stack: the kilobytes of one that is too small, 0 for enough. */
int qsmpm_meet_limits(void)
{
    struct rlimit stack;
    rlim_t least = (rlim_t)1024 * LEAST_STACK, usual = (rlim_t)1024 * USUAL_STACK;

    signal(SIGXFSZ, SIG_IGN);
    if (getrlimit(RLIMIT_STACK, &stack) != 0 || stack.rlim_cur == RLIM_INFINITY || stack.rlim_cur >= least) return 0;
    if (stack.rlim_max == RLIM_INFINITY || stack.rlim_max >= least) {
        stack.rlim_cur = stack.rlim_max == RLIM_INFINITY || stack.rlim_max > usual ? usual : stack.rlim_max;
        if (setrlimit(RLIMIT_STACK, &stack) == 0) start_again();
    }
    return (int)(stack.rlim_cur / 1024);
}
