/* _exit, _Exit and quick_exit of the program, lent to the soil models that it loads: one that ends the process past the handlers of
 * exit comes back to its caller like one that calls exit. Calls that are not a model's end the process as always. A system
 * call of a model's own is not seen. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

void qsmpm_guard_leave(void);

static _Noreturn void end_process(int code)
{
    qsmpm_guard_leave();
    for (;;) syscall(SYS_exit_group, code);
}

_Noreturn void _exit(int code)
{
    end_process(code);
}

_Noreturn void _Exit(int code)
{
    end_process(code);
}

/* Its own handlers run where it is not a model's. */
_Noreturn void quick_exit(int code)
{
    void (*libc)(int);
    void *address;

    qsmpm_guard_leave();
    address = dlsym(RTLD_NEXT, "quick_exit");
    memcpy(&libc, &address, sizeof libc);
    if (address != NULL) libc(code);
    end_process(code);
}
