/* Counts allocations: loaded before a program's libraries, it stands in front of the C library's own. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdatomic.h>
#include <stddef.h>

static atomic_long count;
static void *(*next_malloc)(size_t);
static void *(*next_realloc)(void *, size_t);

long allocations(void) { return count; }

void *malloc(size_t size) {
    if (!next_malloc) next_malloc = (void *(*)(size_t))dlsym(RTLD_NEXT, "malloc");
    count++;
    return next_malloc(size);
}

void *realloc(void *old, size_t size) {
    if (!next_realloc) next_realloc = (void *(*)(void *, size_t))dlsym(RTLD_NEXT, "realloc");
    count++;
    return next_realloc(old, size);
}
