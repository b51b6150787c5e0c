/* Soil models in shared libraries: loading, and a guard around each call.
 *
 * A model may leave a call in other ways than by returning: by a STOP, a run-time error of its compiler or a call
 * of exit, which all end in exit(3); by a fault, which is a signal; by abort. In each case control returns to the
 * caller with a number that identifies the reason.
 *   - exit(3) runs the handlers of atexit(3), the last one registered first. The handler of this file jumps back. It is
 *     registered when a library is loaded, again by qsmpm_guard_exit when the files of a run are open, so that it runs
 *     before their libraries are shut down, and again each time it has been used.
 *   - SIGFPE, SIGSEGV, SIGBUS, SIGILL and SIGABRT have a handler that jumps back during the call of a model and
 *     otherwise passes them to the previous handler.
 *   - SIGINT and SIGTERM are not handled here. On request (qsmpm_guard_watch) a thread checks whether calls
 *     return: a call that continues for longer than patience after one of them is abandoned by a separate signal.
 * Traps of floating-point exceptions are disabled during a call, also if the host program has set some: a model may
 * divide zero by zero on the way to a valid result, and results that are not finite are detected afterwards.
 * Locks held by the model remain locked and damaged memory remains damaged. It is therefore not called again until it
 * is looked up again, by another analysis, and the run ends. _exit(2) and quick_exit(3) are caught where the program
 * provides replacements (src/process_exit.c), exec(3) is not.
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

/* Interval of the checks [ms]; number of intervals until a call is abandoned when the run is to stop, and until a call
 * is first reported. */
enum { left_by_exit = -1, left_by_stop = -2, signals = 5, most_abandoned = 64, most_threads = 256, tick = 250, patience = 4,
       long_call = 120 };

typedef void (*procedure)(void);

struct guard {
    sigjmp_buf place;
    fenv_t arithmetic;
    volatile sig_atomic_t what;
};

/* Calls of a thread: the count is odd during the call of a model. */
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
static _Thread_local int invalid = 0;
static struct calls calls[most_threads];
static atomic_int threads = 0, watches = 0, stopped = 0;
static _Thread_local struct calls *own_calls = NULL;

int qsmpm_signal_received(void);

/* Jumps back to the caller of the model. */
static void leave(int what)
{
    active->what = what;
    siglongjmp(active->place, 1);
}

/* Exit handler: jumps back to the caller of the model, if one is being called. */
void qsmpm_guard_leave(void)
{
    if (active != NULL) leave(left_by_exit);
}

/* Handler of faults. */
static void on_fault(int number)
{
    int i;

    if (active != NULL) leave(number);
    for (i = 0; i < signals; i++)
        if (watched[i] == number) sigaction(number, &before[i], NULL);
    raise(number);
}

/* Abandons a model that does not return when the run is to stop. */
static void on_stop(int number)
{
    (void)number;
    if (active == NULL) return;
    stopped = 1;
    leave(left_by_stop);
}

/* Reports that a model has not returned for the given time. */
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

/* Checks the calls in an endless loop. */
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

/* Starts the thread that checks the calls, with all signals blocked. */
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

/* Enables the check of the calls of models. */
void qsmpm_guard_watch(void)
{
    watches = 1;
}

/* Returns not 0 when a call has been abandoned because the run was to stop. */
int qsmpm_guard_stopped(void)
{
    return stopped;
}

/* Counts the start and the end of a call. */
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

/* Registers the handlers. */
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

/* Registers the guard again, so that it is the first exit handler to run. */
void qsmpm_guard_exit(void)
{
    if (installed) atexit(qsmpm_guard_leave);
}

/* Returns the reason for which a model was abandoned before, 0 if it was not. If the list is full, all are
 * regarded as abandoned. */
static int was_abandoned(procedure model)
{
    int i;

    for (i = 0; i < most_abandoned; i++)
        if (abandoned_model[i] == model || (i == most_abandoned - 1 && abandoned_model[i] != NULL)) return abandoned_by[i];
    return 0;
}

/* Removes a model from the list of abandoned ones, for another analysis. */
static void forget(procedure model)
{
    int i;

    for (i = 0; i < most_abandoned; i++)
        if (abandoned_model[i] == model) abandoned_model[i] = NULL;
}

/* Calls a model. Returns 0 when it has returned, the number of a signal, -1 when it has ended the process, or -2 when
 * it was abandoned on a stop, now or before. */
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
    invalid = fetestexcept(FE_INVALID);
    fesetenv(&here.arithmetic);
    if (here.what == 0) return 0;
    for (i = 0; i < most_abandoned - 1 && abandoned_model[i] != NULL;) i++;
    abandoned_model[i] = model;
    abandoned_by[i] = (int)here.what;
    abandoned++;
    if (here.what == left_by_exit) atexit(qsmpm_guard_leave);
    return (int)here.what;
}

/* Returns not 0 when a floating-point operation of the last call of this thread was invalid. */
int qsmpm_guard_invalid(void)
{
    return invalid;
}

/* Returns the number of abandoned calls. */
int qsmpm_guard_abandoned(void)
{
    return (int)abandoned;
}

/* Ends the process without the exit handlers, which may wait for a lock that an abandoned model holds. */
void qsmpm_leave_process(int code)
{
    fflush(NULL);
    _exit(code);
}

/* Loads a library; NULL and a message if it cannot be loaded. */
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

/* Returns a procedure of a library, NULL if there is none of that name. */
void (*qsmpm_library_symbol(void *library, const char *name))(void)
{
    void (*procedure)(void);
    void *address = dlsym(library, name);

    memcpy(&procedure, &address, sizeof procedure);
    if (address != NULL) forget(procedure);
    return procedure;
}

/* Returns not 0 when files may be created in a directory. */
int qsmpm_may_write(const char *path)
{
    return access(path, W_OK | X_OK) == 0;
}

/* Redirects standard output to /dev/null (saved < 0), or back; returns the argument of the second call. */
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
