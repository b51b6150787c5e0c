/* System services not available in Fortran: signals, the text of errno, terminals, directories, locks.
 *
 * The signal flag is the only global variable of the program, since a signal handler can set nothing else. The second
 * signal of a kind ends the process as usual. */
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

enum { longest_path = 4096, digits_wanted = 6 };

static volatile sig_atomic_t received = 0;

static void remember(int number)
{
    received = number;
}

/* Makes SIGINT and SIGTERM set the flag, once each. */
void qsmpm_watch_signals(void)
{
    struct sigaction action;

    memset(&action, 0, sizeof action);
    action.sa_handler = remember;
    action.sa_flags = SA_RESETHAND | SA_RESTART;
    sigemptyset(&action.sa_mask);
    received = 0;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

/* Returns the number of the last signal received, 0 for none. */
int qsmpm_signal_received(void)
{
    return (int)received;
}

/* Returns nonzero if the process can allocate so many further bytes; they are freed immediately. */
int qsmpm_may_have_memory(long bytes)
{
    void *place = mmap(NULL, (size_t)bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);

    if (place == MAP_FAILED) return 0;
    munmap(place, (size_t)bytes);
    return 1;
}

/* Returns the text of errno; text has length bytes. */
void qsmpm_last_error(char *text, int length)
{
    snprintf(text, (size_t)length, "%s", strerror(errno));
}

/* Returns the number of columns of a terminal, 0 if unknown. */
int qsmpm_terminal_width(int descriptor)
{
    struct winsize size;

    memset(&size, 0, sizeof size);
    return ioctl(descriptor, TIOCGWINSZ, &size) == 0 ? (int)size.ws_col : 0;
}

/* Returns the peak memory of the process [bytes]. getrusage includes the program that started this one, so the value
 * of the process itself is read first. */
long qsmpm_peak_memory(void)
{
    struct rusage usage;
    char line[128];
    long kilobytes = -1;
    FILE *status = fopen("/proc/self/status", "r");

    if (status != NULL) {
        while (kilobytes < 0 && fgets(line, sizeof line, status) != NULL)
            if (sscanf(line, "VmHWM: %ld", &kilobytes) != 1) kilobytes = -1;
        fclose(status);
    }
    if (kilobytes < 0) kilobytes = getrusage(RUSAGE_SELF, &usage) == 0 ? usage.ru_maxrss : 0;
    return 1024 * kilobytes;
}

/* Returns 0 if path is a directory. */
static int is_directory(const char *path)
{
    struct stat status;

    if (stat(path, &status) != 0) return -1;
    if (S_ISDIR(status.st_mode)) return 0;
    errno = ENOTDIR;
    return -1;
}

/* Creates a directory and its parents; returns 0 if it exists. */
int qsmpm_make_directory(const char *path)
{
    char part[longest_path];
    size_t i, n = strlen(path);

    if (n == 0 || n >= sizeof part) {
        errno = n == 0 ? ENOENT : ENAMETOOLONG;
        return -1;
    }
    memcpy(part, path, n + 1);
    for (i = 1; i <= n; i++) {
        if (path[i] != '/' && path[i] != '\0') continue;
        part[i] = '\0';
        if (mkdir(part, 0777) != 0 && errno != EEXIST && is_directory(part) != 0) return -1;
        part[i] = path[i];
    }
    return is_directory(path);
}

/* Returns whether name is prefix, six or more digits, suffix. */
static int is_numbered(const char *name, const char *prefix, const char *suffix)
{
    size_t digits = 0, start = strlen(prefix);

    if (strncmp(name, prefix, start) != 0) return 0;
    name += start;
    while (isdigit((unsigned char)name[digits])) digits++;
    return digits >= digits_wanted && strcmp(name + digits, suffix) == 0;
}

/* Removes a file of a directory; returns 0 on success. */
static int remove_entry(const char *directory, const char *name)
{
    char path[longest_path];
    int length = snprintf(path, sizeof path, "%s/%s", directory, name);

    return length < 0 || (size_t)length >= sizeof path ? -1 : unlink(path);
}

/* Removes the files prefixNNNNNNsuffix of a directory; returns 0 if none is left (or there is no directory). */
int qsmpm_remove_numbered(const char *directory, const char *prefix, const char *suffix)
{
    struct dirent *entry;
    int result = 0;
    DIR *handle = opendir(directory);

    if (handle == NULL) return errno == ENOENT ? 0 : -1;
    while ((entry = readdir(handle)) != NULL) {
        if (!is_numbered(entry->d_name, prefix, suffix)) continue;
        if (remove_entry(directory, entry->d_name) != 0) result = -1;
    }
    closedir(handle);
    return result;
}

/* Returns whether a descriptor still is the file of that name, which another process may have removed. */
static int is_named(int descriptor, const char *path)
{
    struct stat open_file, named;

    return fstat(descriptor, &open_file) == 0 && stat(path, &named) == 0 && open_file.st_dev == named.st_dev
        && open_file.st_ino == named.st_ino;
}

/* Creates and locks the file path until it is unlocked or the process ends in any way. Returns the descriptor;
 * -1: failed, see errno; -2: locked by the process *holder (0 if unknown). On a file system without locks the file is
 * created and not locked. */
int qsmpm_lock_file(const char *path, int *holder)
{
    char text[32];
    int descriptor, length;

    *holder = 0;
    for (;;) {
        descriptor = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (descriptor < 0) return -1;
        if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            length = (int)pread(descriptor, text, sizeof text - 1, 0);
            text[length > 0 ? length : 0] = '\0';
            *holder = (int)strtol(text, NULL, 10);
            close(descriptor);
            return -2;
        }
        if (is_named(descriptor, path)) break;
        close(descriptor);
    }
    length = snprintf(text, sizeof text, "%ld\n", (long)getpid());
    if (ftruncate(descriptor, 0) != 0 || pwrite(descriptor, text, (size_t)length, 0) != length) {
        unlink(path);
        close(descriptor);
        return -1;
    }
    return descriptor;
}

/* Removes and unlocks a locked file. */
void qsmpm_unlock_file(const char *path, int descriptor)
{
    unlink(path);
    close(descriptor);
}
