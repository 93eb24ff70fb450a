// A system that fails on purpose: preloaded into the program under test, it counts what that program asks of the files below one
// folder and spoils the n-th request. Nothing of the program is changed for it.
//
//   FAULT_UNDER  the folder; requests elsewhere (libraries, terminals, sockets) pass
//   FAULT_KIND   count   only counts
//                fail    the request fails: EIO for reads and syncs, ENOSPC for what needs room
//                short   a read or write does half of what was asked
//                again   a read or write is interrupted once: EINTR
//                torn    a write does half, and the process is killed
//                kill    the process is killed before the request
//                memory  a request for 64 KiB of memory or more gets none; count-memory counts those
//   FAULT_AT     which request, from 1
//   FAULT_LOG    a file that gets the number of requests, or the one that was spoilt
//   FAULT_DISK   a folder that gets what a power cut would leave: data/INODE as it was last synced, dirs/INODE with the names that
//                were synced in a folder. The test put there what was on the disk before.
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static const char *under, *kind, *log_file, *disk;
static long at, count;
static int of_memory;
static __thread int inside; // the shim's own requests
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

#define REAL(name) ((__typeof__(&name))real(#name))
static void *real(const char *name) {
    void *found = dlsym(RTLD_NEXT, name);
    if (!found) abort();
    return found;
}

static void tell(const char *what, const char *path) {
    if (!log_file) return;
    int fd = (int)syscall(SYS_openat, AT_FDCWD, log_file, O_WRONLY | O_CREAT | O_TRUNC, 0644);
    char line[PATH_MAX + 100];
    int length = snprintf(line, sizeof line, "%ld %s %s\n", count, what, path);
    syscall(SYS_write, fd, line, length);
    syscall(SYS_close, fd);
}

__attribute__((constructor)) static void begin(void) {
    under = getenv("FAULT_UNDER");
    kind = getenv("FAULT_KIND");
    log_file = getenv("FAULT_LOG");
    disk = getenv("FAULT_DISK");
    at = getenv("FAULT_AT") ? atol(getenv("FAULT_AT")) : 0;
    if (!kind) under = NULL;
    of_memory = under && strstr(kind, "memory");
}

__attribute__((destructor)) static void end(void) {
    if (under && !strncmp(kind, "count", 5)) tell("requests", "");
}

static int is_under(const char *path) {
    return under && !strncmp(path, under, strlen(under));
}

static int path_of(int fd, char *path) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = syscall(SYS_readlinkat, AT_FDCWD, link, path, PATH_MAX - 1);
    path[length < 0 ? 0 : length] = 0;
    return length > 0 && is_under(path);
}

// What becomes of a request: 0 it passes, 1 it fails, 2 half of it is done, 3 it is interrupted, 4 half of it, then the end.
enum { PASS, FAIL, HALF, AGAIN, TORN };
static int fate(const char *what, const char *path, int has_bytes, int is_write) {
    if (of_memory) return PASS;
    pthread_mutex_lock(&lock);
    int mine = ++count == at;
    pthread_mutex_unlock(&lock);
    if (!mine) return PASS;
    tell(what, path);
    if (!strcmp(kind, "kill")) kill(getpid(), SIGKILL), pause();
    if (!strcmp(kind, "fail")) return FAIL;
    if (!strcmp(kind, "short") && has_bytes) return HALF;
    if (!strcmp(kind, "again") && has_bytes) return AGAIN;
    if (!strcmp(kind, "torn")) {
        if (is_write) return TORN;
        kill(getpid(), SIGKILL), pause();
    }
    return PASS;
}

static size_t half(size_t bytes) { return bytes > 1 ? bytes / 2 : bytes; }

#define FAILED(code) (errno = (code), -1)
#define BYTES(what, code, fd, length, is_write, call)                                     \
    do {                                                                                    \
        char path[PATH_MAX];                                                              \
        if (inside || !path_of(fd, path)) { size_t n = length; return call; }              \
        int todo = fate(what, path, 1, is_write);                                           \
        if (todo == FAIL) return FAILED(code);                                              \
        if (todo == AGAIN) return FAILED(EINTR);                                            \
        size_t n = todo == HALF || todo == TORN ? half(length) : (size_t)(length);        \
        if (todo != TORN) return call;                                                    \
        ssize_t done = call;                                                              \
        (void)done;                                                                       \
        kill(getpid(), SIGKILL);                                                          \
        pause();                                                                          \
        return -1;                                                                        \
    } while (0)

ssize_t read(int fd, void *to, size_t length) { BYTES("read", EIO, fd, length, 0, REAL(read)(fd, to, n)); }
ssize_t pread(int fd, void *to, size_t length, off_t from) { BYTES("read", EIO, fd, length, 0, REAL(pread)(fd, to, n, from)); }
ssize_t pread64(int fd, void *to, size_t length, off64_t from) { BYTES("read", EIO, fd, length, 0, REAL(pread64)(fd, to, n, from)); }
ssize_t write(int fd, const void *from, size_t length) { BYTES("write", ENOSPC, fd, length, 1, REAL(write)(fd, from, n)); }
ssize_t pwrite(int fd, const void *from, size_t length, off_t to) { BYTES("write", ENOSPC, fd, length, 1, REAL(pwrite)(fd, from, n, to)); }
ssize_t pwrite64(int fd, const void *from, size_t length, off64_t to) { BYTES("write", ENOSPC, fd, length, 1, REAL(pwrite64)(fd, from, n, to)); }
// The first piece alone is a legal answer to a request for many.
ssize_t writev(int fd, const struct iovec *of, int pieces) {
    char path[PATH_MAX];
    if (inside || !path_of(fd, path)) return REAL(writev)(fd, of, pieces);
    while (pieces > 1 && of->iov_len == 0) of++, pieces--;
    return write(fd, of->iov_base, of->iov_len);
}
ssize_t readv(int fd, const struct iovec *of, int pieces) {
    char path[PATH_MAX];
    if (inside || !path_of(fd, path)) return REAL(readv)(fd, of, pieces);
    while (pieces > 1 && of->iov_len == 0) of++, pieces--;
    return read(fd, of->iov_base, of->iov_len);
}
// Copies by the kernel are done by reads and writes instead: those are counted.
ssize_t copy_file_range(int from, off64_t *a, int to, off64_t *b, size_t length, unsigned flags) {
    char path[PATH_MAX];
    if (path_of(from, path) || path_of(to, path)) return FAILED(ENOSYS);
    return REAL(copy_file_range)(from, a, to, b, length, flags);
}
ssize_t sendfile64(int to, int from, off64_t *at_, size_t length) {
    char path[PATH_MAX];
    if (path_of(from, path) || path_of(to, path)) return FAILED(ENOSYS);
    return REAL(sendfile64)(to, from, at_, length);
}
ssize_t sendfile(int to, int from, off_t *at_, size_t length) { return sendfile64(to, from, at_, length); }

#define NAMED(what, path, call) \
    do { \
        if (!inside && is_under(path) && fate(what, path, 0, 0) == FAIL) return FAILED(ENOSPC); \
        return call; \
    } while (0)

// An inode that is kept open is not given to another file: the disk's data go by inodes.
static void hold(const char *path) {
    if (disk && is_under(path)) syscall(SYS_openat, AT_FDCWD, path, O_PATH | O_NOFOLLOW | O_CLOEXEC, 0);
}
int ftruncate(int fd, off_t length) {
    char path[PATH_MAX];
    if (inside || !path_of(fd, path)) return REAL(ftruncate)(fd, length);
    NAMED("truncate", path, REAL(ftruncate)(fd, length));
}
int ftruncate64(int fd, off64_t length) {
    char path[PATH_MAX];
    if (inside || !path_of(fd, path)) return REAL(ftruncate64)(fd, length);
    NAMED("truncate", path, REAL(ftruncate64)(fd, length));
}
int rename(const char *from, const char *to) { hold(to); NAMED("rename", to, REAL(rename)(from, to)); }
int link(const char *from, const char *to) { NAMED("link", to, REAL(link)(from, to)); }
int linkat(int a, const char *from, int b, const char *to, int flags) { NAMED("link", to, REAL(linkat)(a, from, b, to, flags)); }
int mkdir(const char *path, mode_t mode) { NAMED("mkdir", path, REAL(mkdir)(path, mode)); }
int unlink(const char *path) { hold(path); NAMED("unlink", path, REAL(unlink)(path)); }
int rmdir(const char *path) { hold(path); NAMED("rmdir", path, REAL(rmdir)(path)); }

static int opened(const char *name, int folder, const char *path, int flags, mode_t mode) {
    char whole[PATH_MAX];
    if (path[0] == '/' || folder != AT_FDCWD) snprintf(whole, sizeof whole, "%s", path);
    else if (getcwd(whole, sizeof whole)) { size_t n = strlen(whole); snprintf(whole + n, sizeof whole - n, "/%s", path); }
    if (!inside && is_under(whole)) {
        int todo = fate(flags & O_CREAT ? "create" : name, whole, 0, 0);
        if (todo == FAIL) return FAILED(flags & O_CREAT ? ENOSPC : EIO);
    }
    return (int)syscall(SYS_openat, folder, path, flags, mode);
}
#define MODE mode_t mode = 0; if (flags & (O_CREAT | O_TMPFILE)) { va_list l; va_start(l, flags); mode = va_arg(l, mode_t); va_end(l); }
int open(const char *path, int flags, ...) { MODE return opened("open", AT_FDCWD, path, flags, mode); }
int open64(const char *path, int flags, ...) { MODE return opened("open", AT_FDCWD, path, flags, mode); }
int openat(int folder, const char *path, int flags, ...) { MODE return opened("open", folder, path, flags, mode); }
int openat64(int folder, const char *path, int flags, ...) { MODE return opened("open", folder, path, flags, mode); }

// Memory. Below 64 KiB it is given always: what a file asks for is what may be too much.
void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
static int refused(size_t bytes) {
    if (!of_memory || bytes < 65536) return 0;
    int mine = __atomic_add_fetch(&count, 1, __ATOMIC_SEQ_CST) == at && !strcmp(kind, "memory");
    if (mine) tell("memory", "");
    return mine;
}
void *malloc(size_t bytes) { return refused(bytes) ? NULL : __libc_malloc(bytes); }
void *calloc(size_t many, size_t bytes) { return refused(many * bytes) ? NULL : __libc_calloc(many, bytes); }
void *realloc(void *block, size_t bytes) { return refused(bytes) ? NULL : __libc_realloc(block, bytes); }

// Copies a file's bytes, or a folder's names, to the disk.
static void keep(int fd) {
    struct stat of;
    if (!disk || fstat(fd, &of)) return;
    char to[PATH_MAX], line[NAME_MAX + 64];
    snprintf(to, sizeof to, "%s/%s/%lu", disk, S_ISDIR(of.st_mode) ? "dirs" : "data", (unsigned long)of.st_ino);
    int out = (int)syscall(SYS_openat, AT_FDCWD, to, O_WRONLY | O_CREAT | O_TRUNC, 0644);
    char self[64];
    snprintf(self, sizeof self, "/proc/self/fd/%d", fd);
    if (S_ISDIR(of.st_mode)) {
        DIR *all = opendir(self);
        for (struct dirent *one; all && (one = readdir(all));) {
            if (!strcmp(one->d_name, ".") || !strcmp(one->d_name, "..")) continue;
            int n = snprintf(line, sizeof line, "%lu %c %s\n", (unsigned long)one->d_ino, one->d_type == DT_DIR ? 'd' : 'f', one->d_name);
            syscall(SYS_write, out, line, n);
        }
        if (all) closedir(all);
    } else {
        int in = (int)syscall(SYS_openat, AT_FDCWD, self, O_RDONLY, 0);
        char bytes[65536];
        for (ssize_t n; (n = syscall(SYS_read, in, bytes, sizeof bytes)) > 0;) syscall(SYS_write, out, bytes, n);
        syscall(SYS_close, in);
    }
    syscall(SYS_close, out);
}
static int synced(int fd, int (*call)(int)) {
    char path[PATH_MAX];
    if (inside || !path_of(fd, path)) return call(fd);
    if (fate("sync", path, 0, 0) == FAIL) return FAILED(EIO);
    inside = 1;
    keep(fd);
    inside = 0;
    return disk ? 0 : call(fd);
}
int fsync(int fd) { return synced(fd, REAL(fsync)); }
int fdatasync(int fd) { return synced(fd, REAL(fdatasync)); }
