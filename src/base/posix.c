/* What Fortran cannot say: signals, the text of errno, terminals, directories.
 *
 * The signal flag is the one variable of the program that belongs to no object: a handler has
 * nothing else to write to. The second signal of a kind ends the process as usual. */
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

enum { longest_path = 4096, digits_wanted = 6 };

static volatile sig_atomic_t received = 0;

static void remember(int number)
{
    received = number;
}

/* From now on SIGINT and SIGTERM only set the flag, once. */
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

/* Number of the last signal received, 0 for none. */
int qsmpm_signal_received(void)
{
    return (int)received;
}

/* The words for errno; text holds length bytes. */
void qsmpm_last_error(char *text, int length)
{
    snprintf(text, (size_t)length, "%s", strerror(errno));
}

/* Columns of the terminal behind a descriptor, 0 when that is not known. */
int qsmpm_terminal_width(int descriptor)
{
    struct winsize size;

    memset(&size, 0, sizeof size);
    return ioctl(descriptor, TIOCGWINSZ, &size) == 0 ? (int)size.ws_col : 0;
}

/* Largest memory of the process so far [bytes]. getrusage also remembers the program that started
 * this one, so the mark of the process itself is asked first. */
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

/* 0 when path is a directory. */
static int is_directory(const char *path)
{
    struct stat status;

    if (stat(path, &status) != 0) return -1;
    if (S_ISDIR(status.st_mode)) return 0;
    errno = ENOTDIR;
    return -1;
}

/* Make a directory and those above it; 0 when it is there. */
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

/* Whether name is prefix, six or more digits, suffix. */
static int is_numbered(const char *name, const char *prefix, const char *suffix)
{
    size_t digits = 0, start = strlen(prefix);

    if (strncmp(name, prefix, start) != 0) return 0;
    name += start;
    while (isdigit((unsigned char)name[digits])) digits++;
    return digits >= digits_wanted && strcmp(name + digits, suffix) == 0;
}

/* Remove the files prefixNNNNNNsuffix of a directory; 0 when none is left (or no directory). */
int qsmpm_remove_numbered(const char *directory, const char *prefix, const char *suffix)
{
    char path[longest_path];
    struct dirent *entry;
    int result = 0, length;
    DIR *handle = opendir(directory);

    if (handle == NULL) return errno == ENOENT ? 0 : -1;
    while ((entry = readdir(handle)) != NULL) {
        if (!is_numbered(entry->d_name, prefix, suffix)) continue;
        length = snprintf(path, sizeof path, "%s/%s", directory, entry->d_name);
        if (length < 0 || (size_t)length >= sizeof path || unlink(path) != 0) result = -1;
    }
    closedir(handle);
    return result;
}
