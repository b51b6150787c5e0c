/* Soil models in shared libraries: how they are loaded, and a guard around each call of one.
 *
 * A model may leave a call in other ways than by returning: by a STOP, a run-time error of its compiler or a call
 * of exit, which all end in exit(3); by a fault, which is a signal; by abort. Each brings the caller back here
 * with a number that says what it was.
 *   - exit(3) runs the handlers of atexit(3), the last one registered first. Ours jumps back. It is registered
 *     when a library is loaded, again by qsmpm_guard_exit when the files of a run are open, so that their
 *     libraries have not been shut down yet, and again after each time it has been used up.
 *   - SIGFPE, SIGSEGV, SIGBUS, SIGILL and SIGABRT have a handler that jumps back while a model is being called and
 *     hands them to whoever had them before otherwise.
 *   - SIGINT and SIGTERM are left alone. Where the program asks for it (qsmpm_guard_watch) a thread looks whether calls
 *     return: a call that goes on for longer than patience after one of them is left, by a signal of its own.
 * A model computes without traps of floating-point exceptions, also in a host that has set some: it may divide zero by
 * zero on the way to a good answer, and what is not finite in its answer is seen afterwards.
 * Locks that the model held stay locked, memory that it damaged stays damaged; so it is not called again until it is
 * looked up anew, by another analysis, and a run ends after that. _exit(2) and quick_exit(3) are caught where the program
 * lends its own (src/process_exit.c), exec(3) is not.
 *
 * The variables of this file belong to the process, as exit and signals do. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <fenv.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* The watch looks every tick [ms]; so many ticks are its patience with a call when the run is to stop, and so many until
 * it tells of a call, first. */
enum { left_by_exit = -1, left_by_stop = -2, signals = 5, most_abandoned = 64, most_threads = 256, tick = 250, patience = 4,
       long_call = 120 };

typedef void (*procedure)(void);

struct guard {
    sigjmp_buf place;
    fenv_t arithmetic;
    volatile sig_atomic_t what;
};

/* What a thread is doing: odd while it is in a model. */
struct calls {
    atomic_uint count;
    _Atomic procedure model;
    pthread_t thread;
};

static const int watched[signals] = {SIGFPE, SIGSEGV, SIGBUS, SIGILL, SIGABRT};
static struct sigaction before[signals];
static volatile sig_atomic_t installed = 0, abandoned = 0;
static procedure abandoned_model[most_abandoned];
static int abandoned_by[most_abandoned];
static _Thread_local struct guard *volatile active = NULL;
static struct calls calls[most_threads];
static atomic_int threads = 0, watches = 0, stopped = 0;
static _Thread_local struct calls *own_calls = NULL;

int qsmpm_signal_received(void);

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

/* The run is to stop and the model does not return. */
static void on_stop(int number)
{
    (void)number;
    if (active == NULL) return;
    stopped = 1;
    leave(left_by_stop);
}

/* Say that a model has not returned for so many seconds. */
static void tell_long_call(procedure model, unsigned seconds)
{
    char text[1024];
    void *address;
    Dl_info where;
    int length;

    memcpy(&address, &model, sizeof address);
    if (dladdr(address, &where) == 0) return;
    length = snprintf(text, sizeof text, "qsmpm: the soil model %s of %s has not returned for %u s\n",
                      where.dli_sname == NULL ? "?" : where.dli_sname, where.dli_fname, seconds);
    if (length >= (int)sizeof text) length = (int)sizeof text - 1;
    if (write(STDERR_FILENO, text, (size_t)length) < 0) return;
}

/* Look at the calls for ever. */
static void *watch(void *unused)
{
    unsigned seen[most_threads] = {0}, ticks[most_threads] = {0}, next[most_threads] = {0};
    const struct timespec pause = {0, tick * 1000000L};
    unsigned count;
    int i;

    for (;;) {
        nanosleep(&pause, NULL);
        for (i = 0; i < threads && i < most_threads; i++) {
            count = calls[i].count;
            if (count % 2 == 0 || count != seen[i]) {
                seen[i] = count;
                ticks[i] = 0;
                next[i] = long_call;
                continue;
            }
            ticks[i]++;
            if (qsmpm_signal_received() != 0 && ticks[i] >= patience) pthread_kill(calls[i].thread, SIGRTMIN);
            if (ticks[i] < next[i]) continue;
            tell_long_call(calls[i].model, ticks[i] * tick / 1000);
            next[i] *= 4;
        }
    }
    return unused;
}

/* Begin the watch, deaf to all signals. */
static void begin_watch(void)
{
    struct sigaction action;
    sigset_t all, had;
    pthread_t watcher;

    memset(&action, 0, sizeof action);
    action.sa_handler = on_stop;
    action.sa_flags = SA_NODEFER;
    sigemptyset(&action.sa_mask);
    sigaction(SIGRTMIN, &action, NULL);
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &had);
    if (pthread_create(&watcher, NULL, watch, NULL) == 0) pthread_detach(watcher);
    pthread_sigmask(SIG_SETMASK, &had, NULL);
}

/* From now on the program wants calls of models to be watched. */
void qsmpm_guard_watch(void)
{
    watches = 1;
}

/* Not 0 when a call has been left because the run was to stop. */
int qsmpm_guard_stopped(void)
{
    return stopped;
}

/* The thread enters a model, or has left one. */
static void note_call(procedure model)
{
    int mine;

    if (!watches) return;
    if (own_calls == NULL) {
        mine = atomic_fetch_add(&threads, 1);
        own_calls = &calls[mine < most_threads ? mine : most_threads - 1];
        own_calls->thread = pthread_self();
    }
    own_calls->model = model;
    own_calls->count++;
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
    if (watches) begin_watch();
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

    for (i = 0; i < most_abandoned; i++)
        if (abandoned_model[i] == model || (i == most_abandoned - 1 && abandoned_model[i] != NULL)) return abandoned_by[i];
    return 0;
}

/* Another analysis begins with a model: what has become of it in one before does not count. */
static void forget(procedure model)
{
    int i;

    for (i = 0; i < most_abandoned; i++)
        if (abandoned_model[i] == model) abandoned_model[i] = NULL;
}

/* Call a model: 0 when it has returned, the number of a signal, or -1 when it has ended the process, now or before. */
int qsmpm_guarded(procedure model, void (*call)(void *), void *data)
{
    struct guard here, *outer = active;
    int i;

    if (abandoned && was_abandoned(model)) return was_abandoned(model);
    here.what = 0;
    feholdexcept(&here.arithmetic);
    if (sigsetjmp(here.place, 0) == 0) {
        active = &here;
        note_call(model);
        call(data);
    }
    active = outer;
    note_call(model);
    fesetenv(&here.arithmetic);
    if (here.what == 0) return 0;
    for (i = 0; i < most_abandoned - 1 && abandoned_model[i] != NULL;) i++;
    abandoned_model[i] = model;
    abandoned_by[i] = (int)here.what;
    abandoned++;
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
    if (address != NULL) forget(procedure);
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
