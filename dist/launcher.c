/* Starts the program of an archive with the loader and the libraries beside it, wherever the archive
 * was unpacked, and whatever C library the system has, if any. Linked statically. */
#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char *join(const char *folder, const char *name) {
    size_t size = strlen(folder) + strlen(name) + 1;
    char *path = malloc(size);
    if (path) snprintf(path, size, "%s%s", folder, name);
    return path;
}

int main(int argc, char **argv) {
    char self[PATH_MAX + 1];
    ssize_t length = readlink("/proc/self/exe", self, PATH_MAX);
    char **words = calloc((size_t)argc + 6, sizeof *words);
    if (length < 0 || !words) {
        fprintf(stderr, "itarl: finding out where it lies, by /proc/self/exe: %s\n", strerror(errno));
        return 1;
    }
    self[length] = 0;
    /* For scripts that start it again: to the system, the loader is what runs. */
    setenv("ITARL_PROGRAM", self, 1);
    const char *folder = dirname(dirname(strdup(self)));
    words[0] = join(folder, "/lib/ld-linux-x86-64.so.2");
    words[1] = "--argv0";
    words[2] = argc > 0 ? argv[0] : "itarl";
    words[3] = "--library-path";
    words[4] = join(folder, "/lib");
    words[5] = join(folder, "/lib/itarl");
    for (int i = 1; i < argc; i++) words[5 + i] = argv[i];
    if (words[0] && words[4] && words[5]) execv(words[0], words);
    fprintf(stderr, "itarl: starting %s: %s\n", words[0] ? words[0] : "it", strerror(errno));
    return 1;
}
