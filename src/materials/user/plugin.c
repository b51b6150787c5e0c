/* Soil models in shared libraries: how they are loaded, and a guard around each call of one.
 *
 * A model may leave a call in other ways than by returning: by a STOP, a run-time error of its compiler or a call
 * of exit, which all end in exit(3); by a fault, which is a signal; by abort. Each brings the caller back here
 * with a number that says what it was.
 *   - exit(3) runs the handlers of atexit(3), the last one registered first. Ours jumps back. It is registered
 *     when a library is loaded, again by qsmpm_guard_exit when the files of a run are open, so that their
 *     libraries have not been shut down yet, and again after each time it has been used up.
 *   - SIGFPE, SIGSEGV, SIGBUS, SIGILL and SIGABRT have a handler that jumps back while a model is being called and
 *     hands them to whoever had them before otherwise. SIGINT and SIGTERM are left alone.
 * A model computes without traps of floating-point exceptions, also in a host that has set some: it may divide zero by
 * zero on the way to a good answer, and what is not finite in its answer is seen afterwards.
 * Locks that the model held stay locked, memory that it damaged stays damaged; so it is not called again, and a run
 * ends after that. _exit(2) is caught where the program lends its own (src/process_exit.c), exec(3) is not.
 *
 * The variables of this file belong to the process, as exit and signals do. */
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <fcntl.h>
#include <fenv.h>
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { left_by_exit = -1, signals = 5, most_abandoned = 64 };

typedef void (*procedure)(void);

struct guard {
    sigjmp_buf place;
    fenv_t arithmetic;
    volatile sig_atomic_t what;
};

static const int watched[signals] = {SIGFPE, SIGSEGV, SIGBUS, SIGILL, SIGABRT};
static struct sigaction before[signals];
static volatile sig_atomic_t installed = 0, abandoned = 0;
static procedure abandoned_model[most_abandoned];
static int abandoned_by[most_abandoned];
static _Thread_local struct guard *volatile active = NULL;

/* Back to the caller of the model. */
static void leave(int what)
{
    active->what = what;
    siglongjmp(active->place, 1);
}

/* Somebody ends the process: back to the caller of the model, if one is being called. */
void qsmpm_guard_leave(void)
{
    if (active != NULL) leave(left_by_exit);
}

/* A fault. */
static void on_fault(int number)
{
    int i;

    if (active != NULL) leave(number);
    for (i = 0; i < signals; i++)
        if (watched[i] == number) sigaction(number, &before[i], NULL);
    raise(number);
}

/* Register the handlers. */
static void install(void)
{
    struct sigaction action;
    int i;

    memset(&action, 0, sizeof action);
    action.sa_handler = on_fault;
    action.sa_flags = SA_NODEFER;
    sigemptyset(&action.sa_mask);
    for (i = 0; i < signals; i++) sigaction(watched[i], &action, &before[i]);
    atexit(qsmpm_guard_leave);
    installed = 1;
}

/* Let the guard be the first of all handlers of exit again. */
void qsmpm_guard_exit(void)
{
    if (installed) atexit(qsmpm_guard_leave);
}

/* How a model has been abandoned before, 0 when it has not been. When there are too many, all count as such. */
static int was_abandoned(procedure model)
{
    int i;

    for (i = 0; i < abandoned && i < most_abandoned; i++)
        if (abandoned_model[i] == model || i == most_abandoned - 1) return abandoned_by[i];
    return 0;
}

/* Call a model: 0 when it has returned, the number of a signal, or -1 when it has ended the process, now or before. */
int qsmpm_guarded(procedure model, void (*call)(void *), void *data)
{
    struct guard here, *outer = active;

    if (abandoned && was_abandoned(model)) return was_abandoned(model);
    here.what = 0;
    feholdexcept(&here.arithmetic);
    if (sigsetjmp(here.place, 0) == 0) {
        active = &here;
        call(data);
    }
    active = outer;
    fesetenv(&here.arithmetic);
    if (here.what == 0) return 0;
    if (abandoned < most_abandoned) {
        abandoned_model[abandoned] = model;
        abandoned_by[abandoned] = (int)here.what;
        abandoned++;
    }
    if (here.what == left_by_exit) atexit(qsmpm_guard_leave);
    return (int)here.what;
}

/* How many models have been left in the middle. */
int qsmpm_guard_abandoned(void)
{
    return (int)abandoned;
}

/* End the process without the handlers of exit, which may wait for a lock that an abandoned model holds. */
void qsmpm_leave_process(int code)
{
    fflush(NULL);
    _exit(code);
}

/* Load a library; NULL and what is wrong when it cannot be loaded. */
void *qsmpm_open_library(const char *path, char *message, int length)
{
    void *library;
    const char *text;

    if (!installed) install();
    library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        text = dlerror();
        snprintf(message, (size_t)length, "%s", text == NULL ? "no reason given" : text);
    }
    return library;
}

/* A procedure of a library, NULL when there is none of that name. */
void (*qsmpm_library_symbol(void *library, const char *name))(void)
{
    void (*procedure)(void);
    void *address = dlsym(library, name);

    memcpy(&procedure, &address, sizeof procedure);
    return procedure;
}

/* Not 0 when files may be made in a directory. */
int qsmpm_may_write(const char *path)
{
    return access(path, W_OK | X_OK) == 0;
}

/* Send standard output to nowhere (saved < 0), or back to where it went; what to give to the second call. */
int qsmpm_silence(int saved)
{
    int nowhere;

    fflush(stdout);
    if (saved >= 0) {
        dup2(saved, STDOUT_FILENO);
        close(saved);
        return -1;
    }
    saved = dup(STDOUT_FILENO);
    nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0) {
        dup2(nowhere, STDOUT_FILENO);
        close(nowhere);
    }
    return saved;
}
