// SPDX-License-Identifier: Apache-2.0
// Preloaded: of the calls that change files of this process, number PHOTIC_FAIL_AT (from 1) fails, and all after it for a
// full disk (PHOTIC_FAIL_ALL=1). PHOTIC_FAIL_COUNT names a file that gets the number of such calls at the end.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static long calls, fails_at;
static int fails_on;

__attribute__((constructor)) static void begin(void) {
    const char* at = getenv("PHOTIC_FAIL_AT");
    const char* all = getenv("PHOTIC_FAIL_ALL");
    fails_at = at ? atol(at) : 0;
    fails_on = all != NULL && all[0] == '1';
}

__attribute__((destructor)) static void end(void) {
    const char* path = getenv("PHOTIC_FAIL_COUNT");
    if (path == NULL) return;
    fails_at = 0;
    FILE* file = fopen(path, "w");
    if (file == NULL) return;
    fprintf(file, "%ld\n", __atomic_load_n(&calls, __ATOMIC_SEQ_CST));
    fclose(file);
}

static int fails(void) {
    const long call = __atomic_add_fetch(&calls, 1, __ATOMIC_SEQ_CST);
    return fails_at > 0 && (call == fails_at || (fails_on && call > fails_at));
}

static int regular(int descriptor) {
    struct stat status;
    return fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
#define FAIL(error)     \
    do {                \
        errno = error;  \
        return -1;      \
    } while (0)

ssize_t write(int d, const void* data, size_t size) {
    if (regular(d) && fails()) FAIL(ENOSPC);
    return REAL(write)(d, data, size);
}
ssize_t writev(int d, const struct iovec* parts, int count) {
    if (regular(d) && fails()) FAIL(ENOSPC);
    return REAL(writev)(d, parts, count);
}
ssize_t pwrite(int d, const void* data, size_t size, off_t at) {
    if (regular(d) && fails()) FAIL(ENOSPC);
    return REAL(pwrite)(d, data, size, at);
}
ssize_t pwrite64(int d, const void* data, size_t size, off64_t at) {
    if (regular(d) && fails()) FAIL(ENOSPC);
    return REAL(pwrite64)(d, data, size, at);
}
int fsync(int d) {
    if (regular(d) && fails()) FAIL(EIO);
    return REAL(fsync)(d);
}
int ftruncate(int d, off_t size) {
    if (regular(d) && fails()) FAIL(ENOSPC);
    return REAL(ftruncate)(d, size);
}
int rename(const char* from, const char* to) {
    if (fails()) FAIL(EIO);
    return REAL(rename)(from, to);
}
int link(const char* from, const char* to) {
    if (fails()) FAIL(EPERM);
    return REAL(link)(from, to);
}
int mkdir(const char* path, mode_t mode) {
    if (fails()) FAIL(ENOSPC);
    return REAL(mkdir)(path, mode);
}
static int creates(int flags) { return (flags & O_CREAT) != 0; }
int open(const char* path, int flags, ...) {
    __builtin_va_list more;
    __builtin_va_start(more, flags);
    const mode_t mode = creates(flags) ? __builtin_va_arg(more, mode_t) : 0;
    __builtin_va_end(more);
    if (creates(flags) && fails()) FAIL(ENOSPC);
    return REAL(open)(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
    __builtin_va_list more;
    __builtin_va_start(more, flags);
    const mode_t mode = creates(flags) ? __builtin_va_arg(more, mode_t) : 0;
    __builtin_va_end(more);
    if (creates(flags) && fails()) FAIL(ENOSPC);
    return REAL(open64)(path, flags, mode);
}
