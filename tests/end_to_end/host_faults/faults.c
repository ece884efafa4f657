/* Faults of the computer that a test brings about in one program (LD_PRELOAD): a wall clock that is set, a disk that hangs.
 * TRUNNION_FAULTS names a folder: `clock` in it holds the seconds that the wall clock is off, `hang` holds every fdatasync. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static const char *place(const char *name, char *path, size_t size) {
    const char *folder = getenv("TRUNNION_FAULTS");
    snprintf(path, size, "%s/%s", folder ? folder : "/nowhere", name);
    return path;
}

int clock_gettime(clockid_t id, struct timespec *now) {
    int failed = syscall(SYS_clock_gettime, id, now);
    if (!failed && id == CLOCK_REALTIME) {
        char path[4096];
        FILE *file = fopen(place("clock", path, sizeof path), "r");
        long seconds = 0;
        if (file) {
            if (fscanf(file, "%ld", &seconds) == 1) now->tv_sec += seconds;
            fclose(file);
        }
    }
    return failed;
}

int fdatasync(int file) {
    char path[4096];
    while (access(place("hang", path, sizeof path), F_OK) == 0) usleep(10000);
    return syscall(SYS_fdatasync, file);
}
